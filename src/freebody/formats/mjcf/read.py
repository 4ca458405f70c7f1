"""An MJCF file as a system: bodies without joints merge with their parents, the others have joints of the system.

A coordinate has the file's values (``qpos``), so that its limits, springs and targets can be compared with the file.
The pose that the file draws is ``s.reading.initial``.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from ...describe.joints.ball import Ball
from ...describe.joints.hinge import Hinge
from ...describe.joints.slider import Slider
from ...describe.system import System
from ...scalar.algebra import IDENTITY, ZERO
from ...scalar.expression import exact
from ...space.pose import Pose
from ...space.quaternion import quaternion_from_matrix
from ..builder import COMPONENTS, UNITS, Builder, Cluster, Options, refused
from ..reading import Reading
from ..xml_tree import Element, identifier
from .bodies import SINGLE, Bodies, Body, Joint
from .contacts import add_contacts
from .document import Document, document
from .forces import add_forces
from .geoms import Geoms
from .words import COMPILER, OPTIONS, SECTIONS

GRAVITY = (0.0, 0.0, -9.81)
INERTIAS = {"hinge": "kg m²", "slide": "kg", "ball": "kg m²", "free": ""}
"""Unit of a joint's armature; a free joint has one number for turns and translations."""


def system_of(root: Element, file: Path, reading: Reading, options: Options) -> System:
    """Return the system of an MJCF file, with ``reading``.

    Raises
    ------
    FormatError
        With the line, what was expected and what came.
    """
    whole = document(root, file, reading)
    bodies = Bodies(whole, reading, options.meshes)
    world = bodies.world()
    reader = Reader(whole, bodies.geoms, reading, options)
    reader.grow(world, options.base)
    add_forces(reader)
    add_contacts(reader)
    reader.report()
    return reader.s


class Reader(Builder):
    """The system that grows from a document."""

    def __init__(self, document: Document, geoms: Geoms, reading: Reading, options: Options) -> None:
        super().__init__(document.root.attributes.get("model") or "model", reading, options)
        self.document, self.geoms, self.keep_fixed = document, geoms, options.keep_fixed
        self.coordinates = reading.coordinates
        self.displacements: dict[str, Any] = {}  # coordinate of each hinge and slide
        self.joint_of: dict[str, Joint] = {}
        self.carriers: dict[str, tuple[Any, Pose]] = {}  # body of the system that carries a body of the file
        self.places: dict[str, Pose] = {}  # of bodies and sites in the ground, as the file draws them
        self.bodies_of: dict[str, Body] = {}
        self.sites: dict[str, tuple[Any, Pose]] = {}
        self.first: set[str] = set()  # bodies that are not in another

    # -- the tree -----------------------------------------------------------------------------------

    def grow(self, world: Body, base: Any) -> None:
        """Add all bodies and joints."""
        self.gravity()
        self.first = {child.name for child in world.children}
        cluster = self.cluster(world, base)
        self.s.scenery = cluster.properties.shape
        self.carry(cluster, self.s.ground, Pose())
        waiting = [(child, pose, self.s.ground, pose) for child, pose in reversed(cluster.joints)]
        while waiting:
            body, pose, parent, place = waiting.pop()
            own = self.cluster(body, base)
            if not _moves_mass(self, own, base) and not any(joint.armature for joint in body.joints):
                problem = next((f": {geom.problem}" for geom in body.geoms if geom.problem), "")
                raise body.element.error(
                    f"expected a mass of body '{body.name}' or of one that it carries, since it has a joint{problem}"
                )
            held = self.body(own, "body")
            self.carry(own, held, place)
            self.hold(body, parent, held, pose)
            waiting += [(child, inner, held, place @ inner) for child, inner in reversed(own.joints)]

    def cluster(self, head: Body, base: Any) -> Cluster:
        """Return the bodies that move with ``head``."""
        result = Cluster(head)
        waiting = [(head, Pose())]
        while waiting:
            body, pose = waiting.pop()
            result.members.append((body, pose))
            for child in body.children:
                place = pose @ child.pose
                if self.moves(child, base, body):
                    result.joints.append((child, place))
                    continue
                waiting.append((child, place))
                if any(joint.kind == "free" for joint in child.joints):
                    self.reading.changed(
                        f"body '{child.name}'",
                        child.element.line,
                        "base='fixed' holds the body that the file has free",
                    )
        result.joints.sort(key=lambda pair: pair[0].number)
        return result

    def moves(self, body: Body, base: Any, parent: Body) -> bool:
        """Return True if a body is one of its own in the system."""
        if body.mocap:
            return False
        if parent.name == "world" and base is not None:
            kinds = [joint.kind for joint in body.joints]
            if base == "fixed":
                return bool(kinds) and kinds != ["free"]
            massive = bool(body.properties.mass) or bool(body.children)
            return bool(kinds) or massive
        return bool(body.joints) or (self.keep_fixed and parent.name != "world")

    def carry(self, cluster: Cluster, body: Any, place: Pose) -> None:
        """Keep frames of the bodies and sites of a cluster whose first one is at ``place`` in the ground."""
        frames = self.reading.frames
        for one, pose in cluster.members:
            self.carriers[one.name], self.places[one.name] = (body, pose), place @ pose
            self.bodies_of[one.name] = one
            self.sites.update((name, (body, pose @ inner)) for name, inner in one.sites)
            frames[one.name] = (body.point(*pose.position), pose.rotation.matrix)

    # -- joints -------------------------------------------------------------------------------------

    def hold(self, body: Body, parent: Any, child: Any, pose: Pose) -> None:
        """Add the joints of a body: one joint of the system, which is a chain if there are several."""
        joints = body.joints
        if not joints:
            self.base(body, parent, child, pose)
        elif len(joints) == 1:
            self.single(joints[0], parent, child, pose)
        else:
            name = self.renamed(body.name, self.joints)
            with refused(body.element):
                motions = [self.motion(joint) for joint in joints]
                made = self.s.chain(name, parent, child, motions, **_where(pose, ZERO))
            for index, joint in enumerate(joints):
                self.with_forces(joint, made, index, pose)

    def base(self, body: Body, parent: Any, child: Any, pose: Pose) -> None:
        """Hold a body without joints: as ``base`` says, or welded."""
        name = self.renamed(f"{body.name}_base", self.joints)
        where = _where(pose, ZERO)
        if body.name in self.first:
            self.held(name, child, **where)
        else:
            self.s.weld(name, parent, child, **where)

    def single(self, joint: Joint, parent: Any, child: Any, pose: Pose) -> None:
        """Add the only joint of a body."""
        s, name = self.s, self.renamed(joint.name, self.joints)
        where = _where(pose, joint.place)
        armature = self.parameter(f"A_{name}", joint.armature, INERTIAS[joint.kind])
        with refused(joint.element):
            if joint.kind in SINGLE:
                where["at"] = self.lengths(name, where["at"])
                add = s.hinge if joint.kind == "hinge" else s.slider
                y = self.displacement(joint)
                made = add(name, parent, child, axis=joint.axis, coordinate=y, armature=armature, **where)
            elif joint.kind == "ball":
                made = s.ball(
                    name, parent, child, coordinate=self.quaternion(joint), armature=armature, **where
                )
            else:
                prefix = self.free(name)
                made = s.free(name, parent, child, coordinate=prefix, armature=armature)
                self.coordinates[joint.name] = tuple(f"{prefix}_{x}" for x in COMPONENTS[:7])
                values = (*pose.position, *quaternion_from_matrix(pose.rotation.matrix))
                pairs = zip(self.coordinates[joint.name], map(float, values), strict=True)
                self.reading.initial.update((text, x) for text, x in pairs if x != 0)
        self.with_forces(joint, made, 0, pose)

    def motion(self, joint: Joint) -> Any:
        """Return one of several joints of a body, as a motion of a chain."""
        armature = self.parameter(f"A_{joint.name}", joint.armature, INERTIAS[joint.kind]) or ()
        if joint.kind == "ball":
            return Ball(coordinate=self.quaternion(joint), at=joint.place, armature=armature)
        kind = Hinge if joint.kind == "hinge" else Slider
        return kind(joint.axis, self.displacement(joint), at=joint.place, armature=armature)

    def displacement(self, joint: Joint) -> Any:
        """Return the displacement q - ref of a hinge or slide from the pose of the file."""
        text = self.name(joint.name)
        q = self.s.coordinates(text)
        self.displacements[joint.name], self.coordinates[joint.name] = q, (text,)
        if joint.ref:
            self.reading.initial[text] = joint.ref
        return q - exact(joint.ref)

    def quaternion(self, joint: Joint) -> str:
        """Return the prefix of the coordinates of a ball."""
        prefix = self.free(identifier(joint.name, set()))
        self.coordinates[joint.name] = tuple(f"{prefix}_e{i}" for i in range(4))
        return prefix

    def with_forces(self, joint: Joint, made: Any, index: int, pose: Pose) -> None:
        """Add the spring, damper, stops and friction of a joint, which is the motion ``index`` of one of the system."""
        self.joint_of[joint.name] = joint
        name = identifier(joint.name, set())
        if joint.kind == "ball" and sum(motion.turns for motion in made.primitives) > 1:
            given = {
                "spring": joint.stiffness, "damper": joint.damping, "dry friction": joint.friction,
                "stop": joint.limits,
            }  # fmt: skip
            if lost := [word for word, value in given.items() if value]:
                self.reading.left_out(
                    joint.what, joint.element.line, "a ball beside hinges of its body moves without what acts against "
                    "its turn", ", ".join(lost),
                )  # fmt: skip
            return
        if joint.kind not in SINGLE:
            self.turning(joint, name, made, index, pose)
        else:
            damping, stiffness = UNITS[joint.kind]
            if joint.damping:
                d = self.parameter(f"d_{name}", joint.damping, damping)
                self.s.damper(self.renamed(f"{name}_damper", self.loads), made, damping=d, coordinate=index)
            if joint.stiffness:
                k = self.parameter(f"k_{name}", joint.stiffness, stiffness)
                rest = exact(joint.rest) - exact(joint.ref)
                self.s.spring(
                    self.renamed(f"{name}_spring", self.loads), made, stiffness=k, rest=rest, coordinate=index
                )
            self.dry_friction(joint.what, joint.element.line, name, made, joint.friction, index)
        if joint.limits is not None:
            self.stops(joint, name, made, joint.limits, index)

    def stops(self, joint: Joint, name: str, made: Any, limits: tuple[float, float], index: int) -> None:
        """Add the stops of a joint, whose limits are values of the coordinate q and not of q - ref."""
        low, high = limits
        line = joint.element.line
        self.reading.limits[joint.name] = {"lower": low, "upper": high}
        self.stop(joint.what, line, name, made, limits, index, joint.ref)
        if joint.kind in SINGLE:
            self.inside(joint.what, line, self.coordinates[joint.name][0], limits)

    def turning(self, joint: Joint, name: str, made: Any, index: int, pose: Pose) -> None:
        """Add spring, damper and friction of a ball or free joint; the body of a free one rests at ``pose``."""
        line = joint.element.line
        self.dry_friction(joint.what, line, name, made, joint.friction, index)
        child, load = made.child, partial(self.renamed, taken=self.loads)
        if joint.stiffness:
            k = self.parameter(f"k_{name}", joint.stiffness, "")
            rest = Pose() if joint.kind == "ball" else pose
            self.s.torsion_spring(load(f"{name}_spring"), made, stiffness=k, rest=rest.rotation)
            if joint.kind == "free":
                at = made.parent.point(*rest.position)
                self.s.bushing(load(f"{name}_bushing"), at, child, stiffness=(k, k, k))
        if not joint.damping:
            return
        d = self.parameter(f"d_{name}", joint.damping, "")
        self.s.damper(load(f"{name}_damper"), made, damping=d)
        if joint.kind == "free":
            prefix = self.coordinates[joint.name][-1].removesuffix("_e3")
            slides = [f"-({d})*{prefix}_v{x}" for x in "xyz"]
            self.s.force(load(f"{name}_drag"), child.point(0, 0, 0), slides, frame=child)

    # -- settings -----------------------------------------------------------------------------------

    def gravity(self) -> None:
        """Set gravity: a parameter along an axis, or the numbers of the file."""
        g: tuple[float, ...] = GRAVITY
        for option in self.document.settings("option"):
            g = option.numbers("gravity", 3, g)
            for flag in option.all("flag"):
                if flag.choice("gravity", ("disable", "enable"), "enable") == "disable":
                    g = (0, 0, 0)
            for name in option.attributes:
                what = OPTIONS.get(name, "")
                if what and any(option.several(name)):
                    self.reading.left_out("<option>", option.line, f"{name}: {what}")
        self.taken.add("g")
        if self.symbols != "none" and g[0] == g[1] == 0 and g[2] < 0:
            symbol = self.s.parameters(g=-g[2])
            self.s.describe("g", unit="m/s²")
            self.s.gravity = (0, 0, -symbol)
        else:
            self.s.gravity = g

    def report(self) -> None:
        """Report the sections that are not read, and keep the keyframes."""
        for element in self.document.settings("compiler"):
            for attribute in element.attributes:
                if said := COMPILER.get(attribute, "not an attribute that freebody knows"):
                    self.reading.left_out("<compiler>", element.line, f"{attribute}: {said}")
        for section in self.document.root.children:
            what = SECTIONS.get(section.tag, "not a part of MJCF that freebody knows")
            if what and section.children:
                self.reading.left_out(f"<{section.tag}>", section.line, what)
        for site, (body, pose) in self.sites.items():
            label = site if site not in self.reading.frames else f"{site} (site)"
            self.reading.frames[label] = (body.point(*pose.position), pose.rotation.matrix)
        order = [text for joint in self.joint_of.values() for text in self.coordinates[joint.name]]
        for number, key in enumerate(self.document.sections("keyframe")):
            name = key.attributes.get("name") or f"key{number + 1}"
            if name in self.reading.keyframes:
                raise key.error(f"expected each key once, got '{name}' again")
            values = key.several("qpos")
            if values and len(values) != len(order):
                self.reading.left_out(
                    f"<key> '{name}'",
                    key.line,
                    "a keyframe of other joints",
                    f"{len(values)} of {len(order)} values",
                )
            elif values:
                self.reading.keyframes[name] = dict(zip(order, values, strict=True))


def _moves_mass(reader: Reader, cluster: Cluster, base: Any) -> bool:
    """Return True if a cluster or what it carries has a mass."""
    waiting = [cluster]
    while waiting:
        one = waiting.pop()
        if one.massive:
            return True
        waiting += [reader.cluster(child, base) for child, _ in one.joints]
    return False


def _where(pose: Pose, place: Any) -> dict[str, Any]:
    """Return the arguments of a joint at ``place`` of its child, which is at a pose in its parent."""
    where: dict[str, Any] = {"at": pose.point(place), "to": place}
    if pose.rotation.matrix != IDENTITY:
        where["parent_axes"] = pose.rotation.matrix
    return where
