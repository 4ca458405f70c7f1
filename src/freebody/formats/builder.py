"""The system that grows from a robot's file: names, parameters, bodies of merged links."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import reduce
from operator import add
from typing import Any

from ..describe.contacts.turn import is_free
from ..describe.description import names_of
from ..describe.joints.joint import turns_freely
from ..describe.joints.primitive import Primitive
from ..describe.system import System
from ..errors import MassError, ModelError, shown
from ..scalar.algebra import IDENTITY, ZERO, Matrix, Vector
from ..scalar.expression import exact
from ..space.mass import MassProperties
from ..space.pose import Pose
from .contacts import check_contacts
from .reading import Reading
from .xml_tree import Element, identifier

BASES = (None, "fixed", "free", "planar")
"""Values of ``base``: how the ground holds the first link; None is what the file says, or fixed. Motions, too."""
SYMBOLS = ("none", "masses", "all")
"""Values of ``symbols``: what becomes a parameter."""
UNITS = {"hinge": ("N m s", "N m"), "slide": ("N s/m", "N/m")}
"""Units of the damping and the stiffness of joints."""
COMPONENTS = ("x", "y", "z", "e0", "e1", "e2", "e3", "wx", "wy", "wz", "vx", "vy", "vz")
"""Endings of the coordinates and speeds of a free joint."""

NOTHING_MASSIVE = MassProperties.as_given(0, ZERO, ((0, 0, 0),) * 3)
"""Mass properties of a link without any."""


@dataclass
class Cluster:
    """Links that fixed joints hold together, with their poses in the first one, which is ``head``.

    A link has ``name``, ``element``, ``properties`` (in its own axes) and ``color``. ``joints`` holds what moves
    relative to the cluster, with its pose in the first link.
    """

    head: Any
    members: list[tuple[Any, Pose]] = field(default_factory=list)
    joints: list[tuple[Any, Pose]] = field(default_factory=list)

    @property
    def properties(self) -> MassProperties:
        """Mass properties of the links together, in the axes of the first, with their solids."""
        return reduce(add, (placed(link.properties, pose) for link, pose in self.members))

    @property
    def massive(self) -> bool:
        """True if the cluster has a mass or an inertia."""
        links = (link.properties for link, _ in self.members)
        return any(one.mass or any(map(any, one.inertia)) for one in links)


@dataclass(frozen=True)
class Options:
    """Options of robots' files, arguments of :func:`freebody.read`; ModelError for a value that does not exist."""

    base: Any
    symbols: str
    keep_fixed: bool
    meshes: bool
    limits: bool
    friction: bool
    contacts: Any

    def __post_init__(self) -> None:
        check_contacts(self.contacts)
        known = {"base": BASES, "symbols": SYMBOLS}
        for name, value in vars(self).items():
            if name == "contacts":
                continue
            values: Any = known.get(name, (False, True))
            if name == "base" and _are_motions(value):
                continue
            if value not in values or isinstance(value, int) != isinstance(values[-1], int):
                listed = ", ".join(repr(x) for x in values if x is not None)
                listed += ", or motions such as [fb.Slider('x'), fb.Hinge('z')]" if name == "base" else ""
                raise ModelError(f"Expected {name}= one of {listed}, got {shown(value)}.")


def _are_motions(base: Any) -> bool:
    """Return whether ``base`` is a motion of a joint, or several."""
    motions = [base] if isinstance(base, Primitive) else base
    return isinstance(motions, list | tuple) and all(isinstance(one, Primitive) for one in motions)


class Builder:
    """The system, and the names that are taken in it."""

    def __init__(self, name: str, reading: Reading, options: Options) -> None:
        self.s, self.reading, self.options = System(name), reading, options
        self.symbols = options.symbols
        self.coefficients: dict[float, Any] = {}
        self.s.reading = reading
        self.taken = {"t"}  # names of coordinates, their speeds and parameters
        # constraints and contacts share the names of joints
        self.bodies, self.joints, self.loads = {"ground"}, set(), set()  # type: set[str], set[str], set[str]

    def renamed(self, name: str, taken: set[str]) -> str:
        """Return the name of a link or joint in the system."""
        result = identifier(name, taken)
        if result != name:
            self.reading.names[name] = result
        return result

    def name(self, name: str) -> str:
        """Return a name of a coordinate or parameter."""
        return identifier(name, self.taken)

    def free(self, name: str) -> str:
        """Return the prefix of the components of a free or ball joint."""
        while self.taken.intersection(parts := [f"{name}_{ending}" for ending in COMPONENTS]):
            name += "_"
        self.taken.update(parts)
        return name

    def held(self, name: str, body: Any, **where: Any) -> None:
        """Let a body move from the ground as ``base`` says: by motions, in a plane, or freely."""
        s, base = self.s, self.options.base
        if isinstance(base, str):
            joins: dict[str, Any] = {"planar": (s.planar, self.plane), "free": (s.free, self.free)}
            join, coordinate = joins[base]
            join(name, s.ground, body, coordinate=coordinate(name), **where)
        else:
            s.chain(name, s.ground, body, [base] if isinstance(base, Primitive) else base, **where)
            self.taken.update(names_of(s).kinds)

    def plane(self, name: str) -> list[str]:
        """Return the coordinates of a motion in a plane."""
        return [self.name(f"{name}_{x}") for x in ("x", "y", "turn")]

    def parameter(self, name: str, value: float, unit: str) -> Any:
        """Return a parameter with this default, or the number itself: zero, or where no symbols are wanted."""
        if self.symbols == "none" or value == 0:
            return value
        symbol = self.s.parameters(**{self.name(name): value})
        if unit:
            self.s.describe(symbol, unit=unit)
        return symbol

    def lengths(self, name: str, place: Vector) -> Any:
        """Return the place of a joint; its components are parameters with ``symbols="all"``."""
        if self.symbols != "all":
            return place
        return [self.parameter(f"r_{name}_{a}", x, "m") for a, x in zip("xyz", place, strict=True)]

    def stop(
        self,
        what: str,
        line: int,
        name: str,
        on: Any,
        limits: tuple[float, float],
        index: int = 0,
        ref: float = 0,
    ) -> None:
        """Let a joint of displacement q - ref, or an expression, stop at its limits; report what does not."""
        low, high = limits
        detail = f"{low:g} to {high:g}"
        if not self.options.limits:
            self.reading.left_out(
                what, line, "no stop holds it at its limits, which limits=True reads", detail
            )
        elif not low < high:
            self.reading.left_out(what, line, "limits without a range between them stop nothing", detail)
        elif turns_freely(on, index) and not high < math.pi:
            self.reading.left_out(what, line, "the turn of a ball is at most half a turn", detail)
        else:
            text = self.renamed(f"{name}_stop", self.joints)
            ends = {
                key: exact(end) - exact(ref)
                for key, end in (("low", low), ("high", high))
                if math.isfinite(end) and not (key == "low" and turns_freely(on, index))
            }
            self.s.stop(text, on, coordinate=index, **ends)

    def inside(self, what: str, line: int, text: str, limits: tuple[float, float]) -> None:
        """Start the coordinate ``text`` at the nearest of its limits if the pose of the file is beyond it."""
        low, high = limits
        start = self.reading.initial.get(text, 0.0)
        if self.options.limits and low < high and not low <= start <= high:
            self.reading.initial[text] = min(max(start, low), high)
            self.reading.changed(
                what, line, "s.reading.initial has the nearest limit, since the pose of the file is beyond it",
                f"{start:g} is not in {low:g} to {high:g}",
            )  # fmt: skip

    def dry_friction(self, what: str, line: int, name: str, made: Any, value: float, index: int = 0) -> None:
        """Give a joint dry friction of a greatest force or torque, a free joint both; report if it has none."""
        if not value:
            return
        if not self.options.friction:
            self.reading.left_out(
                what, line, "it moves without its dry friction, which friction=True reads", f"{value:g}"
            )
            return
        turns, free = made.primitives[index].turns, is_free(made)
        bound = self.parameter(f"f_{name}", value, "" if free else "N m" if turns else "N")
        for ending, word in (
            ("friction", "torque" if turns else "force"),
            *([("drag", "force")] if free else []),
        ):
            given: Any = {word: bound}
            self.s.friction(self.renamed(f"{name}_{ending}", self.joints), made, coordinate=index, **given)

    def coefficient(self, value: float) -> Any:
        """Return a coefficient of friction of contacts: one parameter ``mu`` for each value."""
        if value not in self.coefficients:
            self.coefficients[value] = self.parameter("mu", value, "")
        return self.coefficients[value]

    def body(self, cluster: Cluster, kind: str) -> Any:
        """Add the body of a cluster of links of a ``kind``, as the file calls them."""
        name = self.renamed(cluster.head.name, self.bodies)
        total = cluster.properties
        mass, center, inertia = _each(total.mass), _each(total.center), _each(total.inertia)
        possible = True
        try:
            MassProperties(mass, center, inertia)
        except MassError as error:
            possible = False
            self.reading.changed(
                f"{kind} '{cluster.head.name}'", cluster.head.element.line,
                "kept as it is, although no body can have it", str(error),
            )  # fmt: skip
        if self.symbols != "none":
            mass = self.parameter(f"m_{name}", mass, "kg")
            center = [self.parameter(f"c_{name}_{a}", x, "m") for a, x in zip("xyz", center, strict=True)]
            entries = {
                a + b: self.parameter(f"I_{name}_{a}{b}", inertia[i][j], "kg m²")
                for i, a in enumerate("xyz") for j, b in enumerate("xyz") if i <= j
            }  # fmt: skip
            inertia = [[entries["".join(sorted(a + b))] for b in "xyz"] for a in "xyz"]
        color = next((link.color for link, _ in cluster.members if link.color), None)
        rows: Any = tuple(map(tuple, inertia))
        given = MassProperties.as_given(mass, tuple(center), rows, total.shape, possible)
        return self.s.body(name, given, color=color or None)


def _each(x: Any) -> Any:
    """Return integers and the nearest floats of exact numbers, in nested tuples."""
    if isinstance(x, tuple):
        return tuple(map(_each, x))
    return x if isinstance(x, int) else float(x)


def whole(x: Any) -> Any:
    """Return an integer for a whole number: it is exact in formulas."""
    return int(x) if x == int(x) else x


def placed(thing: Any, pose: Pose) -> Any:
    """Return a shape, or mass properties, that stand at a pose."""
    R, p = pose.rotation.matrix, pose.position
    turned = thing if R == IDENTITY else thing.rotated(R)
    return turned if p == ZERO else turned.moved(p)


def normal(axis: Vector) -> Matrix:
    """Return a rotation matrix whose third column is a unit vector."""
    x, y, z = axis
    if (x, y) == (0, 0):
        return IDENTITY if z > 0 else ((1, 0, 0), (0, -1, 0), (0, 0, -1))
    across = math.hypot(x, y)
    u: Vector = (-y / across, x / across, 0)
    v = (-z * u[1], z * u[0], x * u[1] - y * u[0])
    return ((u[0], v[0], x), (u[1], v[1], y), (u[2], v[2], z))


@contextmanager
def refused(element: Element) -> Iterator[None]:
    """Give the line of an element to what the system refuses."""
    try:
        yield
    except ModelError as error:
        raise element.error(str(error).rstrip(".")) from None
