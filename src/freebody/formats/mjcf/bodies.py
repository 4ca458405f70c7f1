"""Bodies, joints and geoms of an MJCF file, as a tree with everything in its body's axes.

Source: MuJoCo's documentation, XML reference, (world)body; joints act one after the other, each at its own anchor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import reduce
from operator import add
from typing import Any

from ...scalar.algebra import IDENTITY, ZERO, Vector
from ...scalar.expression import exact
from ...space.mass import MassProperties
from ...space.pose import Pose
from ...space.rotation import Rotation
from ...space.shape import compound
from ..builder import NOTHING_MASSIVE, placed, whole
from ..reading import Reading
from ..xml_tree import Element
from .document import Document
from .geoms import Geom, Geoms
from .masses import bounded
from .placing import direction, orientation, pose
from .words import ATTRIBUTES, BODY_LEFT_OUT, NOTHING

JOINTS = ("hinge", "slide", "ball", "free")
SINGLE = ("hinge", "slide")
GREATEST = 10**10
"""A limit of this size is none: a range has two ends, and MuJoCo takes no greater numbers."""


@dataclass(frozen=True)
class Joint:
    """A joint between a body and its parent; ``ref`` is its coordinate in the pose of the file."""

    name: str
    kind: str
    element: Element
    place: Vector
    axis: Vector
    ref: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    damping: float = 0.0
    armature: float = 0.0
    friction: float = 0.0
    limits: tuple[float, float] | None = None

    @property
    def what(self) -> str:
        """Kind and name, as the report writes them."""
        return f"joint '{self.name}'"


@dataclass
class Body:
    """A body: pose in its parent, joints from the parent, mass properties with solids, what is in it."""

    name: str
    element: Element
    pose: Pose
    joints: list[Joint] = field(default_factory=list)
    geoms: list[Geom] = field(default_factory=list)
    sites: list[tuple[str, Pose]] = field(default_factory=list)
    children: list[Body] = field(default_factory=list)
    properties: MassProperties = NOTHING_MASSIVE
    color: str = ""
    mocap: bool = False
    number: int = 0  # in the order of the file
    massive: bool = False  # by its geoms


@dataclass(frozen=True)
class _Place:
    """Where the reader is: a body, the pose of the frame in it, the default class."""

    body: Body
    pose: Pose
    childclass: str


class Bodies:
    """Reads the bodies of a document."""

    def __init__(self, document: Document, reading: Reading, drawn: bool) -> None:
        self.document, self.reading = document, reading
        self.geoms = Geoms(document, drawn)
        self.names: dict[str, set[str]] = {"body": {"world"}, "joint": set(), "site": set()}
        self.count = 0
        self.all: list[Body] = []

    def world(self) -> Body:
        """Return the world with all bodies in it."""
        roots = list(self.document.settings("worldbody"))
        if not roots:
            raise self.document.root.error(
                "expected a <worldbody>, got none. A part of a model is read with the file that includes it"
            )
        world = Body("world", roots[0], Pose())
        for root in roots:
            self._inside(root, _Place(world, Pose(), "main"))
        self._masses(world)
        return world

    # -- elements -----------------------------------------------------------------------------------

    def _inside(self, element: Element, place: _Place) -> None:
        """Read what is in a body or a frame."""
        for child in element.children:
            match child.tag:
                case "body":
                    place.body.children.append(self._body(child, place))
                case "frame":
                    inner = place.pose @ pose(child, self.document.compiler)
                    childclass = child.attributes.get("childclass", place.childclass)
                    self._inside(child, _Place(place.body, inner, childclass))
                case "joint" | "freejoint":
                    place.body.joints.append(self._joint(child, place))
                case "geom":
                    full = self.document.full(child, place.childclass)
                    self._known(full)
                    geom = self.geoms.geom(full, place.body.name, place.body.massive)
                    place.body.geoms.append(self._placed(geom, place.pose, place.body))
                case "site":
                    name = self._name(child, "site", f"site{len(self.names['site']) + 1}")
                    full = self.document.full(child, place.childclass)
                    if "fromto" not in full.attributes:
                        place.body.sites.append((name, place.pose @ pose(full, self.document.compiler)))
                case "inertial":
                    pass  # with the masses
                case tag if tag in NOTHING:
                    pass
                case tag:
                    what = BODY_LEFT_OUT.get(tag)
                    if what is None:
                        raise child.error(
                            f"<{tag}> in a body is not read: bodies would be missing. Write the file that MuJoCo makes "
                            "of it: mujoco.mj_saveLastXML('whole.xml', mujoco.MjModel.from_xml_path('this.xml'))"
                        )
                    self.reading.left_out(f"<{tag}>", child.line, what)

    def _body(self, element: Element, place: _Place) -> Body:
        """Return a body with what is in it."""
        self.count += 1
        name = self._name(element, "body", f"body{self.count}")
        self._known(element)
        own = place.pose @ pose(element, self.document.compiler)
        body = Body(name, element, own, mocap=element.choice("mocap", ("false", "true"), "false") == "true")
        way = self.document.compiler.inertiafromgeom
        given = way != "true" and any(_inertials(element, Pose(), self.document))
        body.number, body.massive = self.count, way != "false" and not given
        self.all.append(body)
        childclass = element.attributes.get("childclass", place.childclass)
        self._inside(element, _Place(body, Pose(), childclass))
        if body.mocap:
            self.reading.changed(
                f"body '{name}'", element.line, "a mocap body stands where the file has it; nobody drags it"
            )
        if element.number("gravcomp", 0):
            self.reading.left_out(
                f"body '{name}'",
                element.line,
                "its weight acts in full: gravcomp is a force of another simulator",
            )
        kinds = [joint.kind for joint in body.joints]
        if "free" in kinds and (len(kinds) > 1 or place.body.name != "world"):
            raise element.error(
                f"expected the free joint of body '{name}' alone, on a body directly in <worldbody>, got "
                + ("other joints beside it" if len(kinds) > 1 else f"it in body '{place.body.name}'")
            )
        return body

    def _placed(self, geom: Geom, frame: Pose, body: Body) -> Geom:
        """Return a geom of a frame in the body's axes; what cannot be said of it is reported."""
        if geom.problem:
            what = "it has no mass and is not drawn" if geom.properties is None else "its mass is kept"
            self.reading.left_out(
                f"<geom> of body '{body.name}'",
                geom.element.line,
                f"a geom that cannot be read: {what}",
                geom.problem,
            )
        if frame.position == ZERO and frame.rotation.matrix == IDENTITY:
            return geom
        return replace(
            geom, pose=frame @ geom.pose, properties=geom.properties and placed(geom.properties, frame),
            shape=geom.shape and placed(geom.shape, frame),
        )  # fmt: skip

    def _joint(self, element: Element, place: _Place) -> Joint:
        """Return a joint in its body's axes."""
        body = place.body
        if body.name == "world":
            raise element.error("expected joints in bodies, got one in <worldbody>")
        plain = element.tag == "freejoint"
        given = [element] if plain else self.document.given(element, place.childclass)
        full = element if plain else self.document.full(element, place.childclass)
        kind = "free" if plain else full.choice("type", JOINTS, "hinge")
        before = next((one for one in body.joints if one.kind == "ball"), None)
        if before is not None and kind in ("hinge", "ball"):
            raise element.error(
                f"expected no turn after {before.what} in body '{body.name}', got a {kind}, which MuJoCo refuses, too: "
                "put the hinges before the ball, or a body between them"
            )
        number = len(body.joints) + 1
        name = self._name(element, "joint", f"{body.name}_{kind}{number if number > 1 else ''}")
        if plain:
            return Joint(name, kind, full, ZERO, (0, 0, 1))
        self._known(full)
        at: Any = tuple(map(exact, full.numbers("pos", 3, (0, 0, 0))))
        axis: Any = (
            direction(full, "axis", full.numbers("axis", 3, (0, 0, 1))) if kind in SINGLE else (0, 0, 1)
        )
        turns = kind in ("hinge", "ball") and self.document.compiler.angle == "degree"
        ref = self._angle(full, "ref", turns) if kind in SINGLE else 0.0
        joint = Joint(
            name, kind, full, ZERO if kind == "free" else place.pose.point(at), place.pose.vector(axis), ref,
            self._first(full, "stiffness"), self._angle(full, "springref", turns), self._first(full, "damping"),
            full.positive("armature"), full.positive("frictionloss"), self._limits(full, given, turns, kind),
        )  # fmt: skip
        if all(full.numbers("springdamper", 2, (0, 0))):
            self.reading.left_out(
                joint.what, full.line, "springdamper: the spring and damper for a time constant are not found"
            )
            return replace(joint, stiffness=0.0, damping=0.0)
        return joint

    def _first(self, element: Element, name: str) -> float:
        """Return the linear coefficient; further ones, of MuJoCo 4, are left out."""
        values = element.several(name)
        if any(values[1:]):
            self.reading.left_out(
                f"<{element.tag}>", element.line, f"{name}: coefficients of higher order are left out"
            )
        return values[0] if values else 0.0

    def _angle(self, element: Element, name: str, degrees: bool) -> float:
        value = element.number(name, 0)
        return math.radians(value) if degrees else value

    def _limits(
        self, element: Element, given: list[Element], degrees: bool, kind: str
    ) -> tuple[float, float] | None:
        """Return the limits of a joint that has some."""
        limited = element.choice("limited", ("false", "true", "auto"), "auto")
        if limited == "false" or "range" not in element.attributes or kind == "free":
            return None
        if limited == "auto" and not self.document.compiler.autolimits:
            raise element.error("expected limited= of a joint with range=, since autolimits='false'")
        low, high = element.numbers("range", 2)
        if low == high == 0 and limited == "auto":
            return None
        if low <= -GREATEST or high >= GREATEST:
            low, high = (-math.inf if low <= -GREATEST else low, math.inf if high >= GREATEST else high)
        return (math.radians(low), math.radians(high)) if degrees else (low, high)

    # -- masses -------------------------------------------------------------------------------------

    def _masses(self, world: Body) -> None:
        """Give all bodies their mass properties, and the world what is drawn of it."""
        compiler = self.document.compiler
        for body in self.all:
            own = self._mass(body)
            changed = False
            if own.mass or body.joints or compiler.boundmass > 0:
                own, changed = bounded(own, compiler)
            if changed:
                self.reading.changed(
                    f"body '{body.name}'",
                    body.element.line,
                    "mass or inertia raised to the bounds of <compiler>",
                )
            body.properties = own
        if compiler.settotalmass > 0:
            factor = compiler.settotalmass / (sum(float(body.properties.mass) for body in self.all) or 1)
            self.reading.changed(
                "<compiler>", self.document.root.line, "masses scaled to settotalmass", f"{factor:g}"
            )
            for body in self.all:
                one = body.properties
                inertia: Any = tuple(tuple(factor * x for x in row) for row in one.inertia)
                body.properties = MassProperties.as_given(
                    factor * one.mass, one.center, inertia, one.shape, possible=False
                )
        for body in [world, *self.all]:
            shapes = [geom.shape for geom in body.geoms if geom.shape is not None]
            body.properties = replace(body.properties, shape=reduce(compound, shapes, None))
            colors = (geom.element.several("rgba") for geom in body.geoms if geom.shape is not None)
            body.color = next((_color(rgba) for rgba in colors if len(rgba) == 4), "")

    def _mass(self, body: Body) -> MassProperties:
        """Return the mass properties that the file gives: those of <inertial>, or those of the geoms."""
        way = self.document.compiler.inertiafromgeom
        inertials = list(_inertials(body.element, Pose(), self.document))
        if inertials and way != "true":
            if len(inertials) > 1:
                raise inertials[1][0].error(f"expected one <inertial> in body '{body.name}', got another")
            return self._inertial(*inertials[0])
        low, high = self.document.compiler.inertiagrouprange
        massive = [geom.properties for geom in body.geoms if geom.properties and low <= geom.group <= high]
        return reduce(add, massive) if body.massive and massive else NOTHING_MASSIVE

    def _inertial(self, element: Element, frame: Pose) -> MassProperties:
        """Return the mass properties of an <inertial>."""
        self._known(element)
        mass = element.number("mass")
        if mass < 0:
            raise element.error(f"expected a mass that is not negative, got {mass:g} kg")
        if "fullinertia" in element.attributes:
            xx, yy, zz, xy, xz, yz = element.numbers("fullinertia", 6)
        else:
            (xx, yy, zz), xy, xz, yz = element.numbers("diaginertia", 3, (0, 0, 0)), 0.0, 0.0, 0.0
        own = MassProperties.as_given(mass, ZERO, ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)), possible=False)
        where = frame @ Pose(Rotation.trusted(orientation(element, self.document.compiler)))
        at: Any = tuple(map(whole, element.numbers("pos", 3, (0, 0, 0))))
        return placed(own, Pose(where.rotation, frame.point(at)))

    # -- names --------------------------------------------------------------------------------------

    def _name(self, element: Element, kind: str, otherwise: str) -> str:
        """Return the name of an element, which no other of its kind has."""
        name, known = element.attributes.get("name", ""), self.names[kind]
        if name in known:
            raise element.error(f"expected each {kind} once, got '{name}' again")
        while not name or name in known:
            name, otherwise = otherwise, otherwise + "_"
        known.add(name)
        self.reading.counts[kind] += 1
        return name

    def _known(self, element: Element) -> None:
        """Report attributes that are not read."""
        known = ATTRIBUTES["joint" if element.tag == "freejoint" else element.tag]
        for name in element.attributes:
            what = known.get(name, "not an attribute that freebody knows")
            if what:
                self.reading.left_out(f"<{element.tag}>", element.line, f"{name}: {what}")


def _inertials(element: Element, frame: Pose, document: Document) -> Any:
    """Iterate over the <inertial> of a body, also in its frames, with the pose of the frame."""
    for child in element.children:
        if child.tag == "inertial":
            yield child, frame
        elif child.tag == "frame":
            yield from _inertials(child, frame @ pose(child, document.compiler), document)


def _color(rgba: tuple[float, ...]) -> str:
    return "#" + "".join(f"{round(255 * min(max(x, 0.0), 1.0)):02x}" for x in rgba[:3])
