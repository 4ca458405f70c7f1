"""A robot as a system: fixed joints merge their links, the others are joints of the system."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import reduce
from operator import add
from pathlib import Path
from typing import Any

from ...describe.system import System
from ...errors import MassError, ModelError, shown
from ...scalar.algebra import IDENTITY, Matrix, Vector, multiply
from ...scalar.expression import exact
from ...space.mass import MassProperties
from ...space.pose import Pose
from ..meshes import Meshes
from ..reading import Reading
from ..xml_tree import Element, identifier
from .robot import Joint, Link, Robot, placed, robot

BASES = ("fixed", "free", "planar")
"""Values of ``base``: how the ground holds the link that no joint holds."""
SYMBOLS = ("none", "masses", "all")
"""Values of ``symbols``: what becomes a parameter."""
GRAVITY = 9.81


@dataclass
class Cluster:
    """Links that fixed joints hold together, with their poses in the first one, which is ``head``."""

    head: Link
    members: list[tuple[Link, Pose]] = field(default_factory=list)
    joints: list[tuple[Joint, Pose]] = field(default_factory=list)  # moving joints that begin here

    @property
    def properties(self) -> MassProperties:
        """Mass properties of the links together, in the axes of the first, with their solids."""
        return reduce(add, (placed(link.properties, pose) for link, pose in self.members))

    @property
    def massive(self) -> bool:
        """True if the cluster has a mass or an inertia."""
        links = (link.properties for link, _ in self.members)
        return any(one.mass or any(map(any, one.inertia)) for one in links)


def system_of(root: Element, file: Path, base: str, symbols: str, keep_fixed: bool, meshes: bool) -> System:
    """Return the system of a URDF file, with ``reading``.

    Raises
    ------
    FormatError
        With the line, what was expected and what came.
    ModelError
        An option that does not exist.
    """
    answers = (False, True)
    options = (
        ("base", base, BASES), ("symbols", symbols, SYMBOLS), ("keep_fixed", keep_fixed, answers),
        ("meshes", meshes, answers),
    )  # fmt: skip
    for name, value, values in options:
        if value not in values:
            listed = ", ".join(map(repr, values))
            raise ModelError(f"Expected {name}= one of {listed}, got {shown(value)}.")
    reading = Reading(file.name)
    found = Meshes(file) if meshes else None
    return _Reader(robot(root, reading, found), reading, symbols, keep_fixed).system(base)


class _Reader:
    """The system that grows from a robot."""

    def __init__(self, robot: Robot, reading: Reading, symbols: str, keep_fixed: bool) -> None:
        self.robot, self.reading = robot, reading
        self.symbols, self.keep_fixed = symbols, keep_fixed
        self.s = System(robot.name)
        self.s.reading = reading
        self.taken = {"t"}  # names of coordinates, their speeds and parameters
        self.bodies, self.joints = {"ground"}, set()  # type: set[str], set[str]
        self.coordinates: dict[str, Any] = {}
        self.clusters: dict[str, Cluster] = {}

    def system(self, base: str) -> System:
        """Return the system."""
        s, root = self.s, self.robot.links[self.robot.root]
        first = self._cluster(root)
        driven = self._driven(first)
        g = s.parameters(g=GRAVITY) if self.symbols != "none" else GRAVITY
        self.taken.add("g")
        s.gravity = (0, 0, -g)
        self.reading.changed(
            "<robot>", root.element.line, f"gravity is {GRAVITY} m/s² against z; the format says nothing"
        )
        if base == "fixed":
            held: Any = s.ground
            self._frames(first, s.ground)
            s.scenery = first.properties.shape
        else:
            held = self._body(first)
            name = identifier("base", self.joints)
            if not first.massive and not first.joints:
                raise root.element.error(
                    f"expected a mass of link '{root.name}', which moves freely with base='{base}'"
                )
            if base == "free":
                s.free(name, s.ground, held, coordinate=self._free(name))
            else:
                s.planar(
                    name, s.ground, held, coordinate=[self._name(f"{name}_{x}") for x in ("x", "y", "turn")]
                )
        self._grow(first, held, driven)
        return s

    # -- clusters -----------------------------------------------------------------------------------

    def _cluster(self, head: Link) -> Cluster:
        """Return the links that move with ``head``."""
        if head.name in self.clusters:
            return self.clusters[head.name]
        cluster = self.clusters[head.name] = Cluster(head)
        waiting = [(head, Pose())]
        while waiting:
            link, pose = waiting.pop()
            cluster.members.append((link, pose))
            for joint in self.robot.below[link.name]:
                if joint.kind == "fixed" and not self.keep_fixed:
                    waiting.append((self.robot.links[joint.child], pose @ joint.pose))
                else:
                    cluster.joints.append((joint, pose @ joint.pose))
        cluster.joints.sort(key=lambda pair: pair[0].element.line)
        return cluster

    def _driven(self, first: Cluster) -> set[str]:
        """Return the names of the joints that move a mass, themselves or by the joints that mimic them."""
        moved: set[str] = set()
        order: list[tuple[Joint | None, Cluster]] = [(None, first)]
        for _, cluster in order:  # grows as it is read: parents before children
            order += [(joint, self._cluster(self.robot.links[joint.child])) for joint, _ in cluster.joints]
        heavy: set[str] = set()
        for joint, cluster in reversed(order):
            if joint is not None and (cluster.massive or any(one.name in heavy for one, _ in cluster.joints)):
                heavy.add(joint.name)
        for name in heavy:
            joint = self.robot.joints[name]
            moved.add(name)
            while joint.mimic is not None:
                joint = self.robot.joints[joint.mimic[0]]
                moved.add(joint.name)
        return moved

    def _grow(self, cluster: Cluster, body: Any, driven: set[str]) -> None:
        """Add the joints that begin on a body and what they hold, branch by branch."""
        waiting = [(joint, pose, body) for joint, pose in reversed(cluster.joints)]
        while waiting:
            joint, pose, body = waiting.pop()
            child = self._cluster(self.robot.links[joint.child])
            if joint.kind != "fixed" and joint.name not in driven:
                self.reading.changed(
                    f"joint '{joint.name}'", joint.element.line,
                    "fixed at zero, since nothing beyond the joint has a mass and its motion is undetermined",
                )  # fmt: skip
                self._frames(child, body, pose)
                continue
            held = self._body(child)
            self._joint(joint, body, held, pose)
            waiting += [(below, place, held) for below, place in reversed(child.joints)]

    # -- bodies -------------------------------------------------------------------------------------

    def _frames(self, cluster: Cluster, body: Any, outer: Pose | None = None) -> None:
        """Keep the frames of the links of a cluster."""
        for link, pose in cluster.members:
            whole = pose if outer is None else outer @ pose
            self.reading.frames[link.name] = (body.point(*whole.position), whole.rotation.matrix)
        if outer is not None:
            for joint, pose in cluster.joints:
                self._frames(self._cluster(self.robot.links[joint.child]), body, outer @ pose)

    def _body(self, cluster: Cluster) -> Any:
        """Add the body of a cluster."""
        name = self._renamed(cluster.head.name, self.bodies)
        total = cluster.properties
        mass, center, inertia = _each(total.mass), _each(total.center), _each(total.inertia)
        possible = True
        try:
            MassProperties(mass, center, inertia)
        except MassError as error:
            possible = False
            self.reading.changed(
                f"link '{cluster.head.name}'", cluster.head.element.line,
                "kept as it is, although no body can have it", str(error),
            )  # fmt: skip
        if self.symbols != "none":
            mass = self._parameter(f"m_{name}", mass, "kg")
            center = [self._parameter(f"c_{name}_{a}", x, "m") for a, x in zip("xyz", center, strict=True)]
            entries = {
                a + b: self._parameter(f"I_{name}_{a}{b}", inertia[i][j], "kg m²")
                for i, a in enumerate("xyz") for j, b in enumerate("xyz") if i <= j
            }  # fmt: skip
            inertia = [[entries["".join(sorted(a + b))] for b in "xyz"] for a in "xyz"]
        color = next((link.color for link, _ in cluster.members if link.color), None)
        rows: Any = tuple(map(tuple, inertia))
        given = MassProperties.as_given(mass, tuple(center), rows, total.shape, possible)
        body = self.s.body(name, given, color=color or None)
        self._frames(cluster, body)
        return body

    # -- joints -------------------------------------------------------------------------------------

    def _joint(self, joint: Joint, parent: Any, child: Any, pose: Pose) -> None:
        """Add a joint with its damper and spring."""
        s, name = self.s, self._renamed(joint.name, self.joints)
        axes = pose.rotation.matrix
        where: dict[str, Any] = {"at": self._lengths(name, pose.position)}
        if axes != IDENTITY:
            where["parent_axes"] = axes
        match joint.kind:
            case "fixed":
                s.weld(name, parent, child, **where)
                return
            case "revolute" | "continuous":
                made = s.hinge(
                    name, parent, child, axis=joint.axis, coordinate=self._displacement(joint), **where
                )
            case "prismatic":
                made = s.slider(
                    name, parent, child, axis=joint.axis, coordinate=self._displacement(joint), **where
                )
            case "planar":
                turn = normal(joint.axis)
                where["parent_axes"] = multiply(axes, turn)
                q = [self._name(f"{name}_{x}") for x in ("x", "y", "turn")]
                s.planar(name, parent, child, coordinate=q, child_axes=turn, **where)
                return
            case "floating":
                s.free(name, parent, child, coordinate=self._free(name), **where)
                return
            case _:
                s.ball(name, parent, child, coordinate=self._free(name), **where)
                return
        if joint.damping:
            s.damper(f"{name}_damper", made, damping=self._parameter(f"d_{name}", joint.damping, ""))
        if joint.stiffness:
            stiffness = self._parameter(f"k_{name}", joint.stiffness, "")
            s.spring(f"{name}_spring", made, stiffness=stiffness, rest=joint.rest)

    def _displacement(self, joint: Joint) -> Any:
        """Return the coordinate of a joint, or the expression of the joint that it mimics."""
        if joint.mimic is None:
            if joint.name not in self.coordinates:
                self.coordinates[joint.name] = self.s.coordinates(self._name(joint.name))
            return self.coordinates[joint.name]
        name, multiplier, offset = joint.mimic
        self.reading.counts["mimic"] += 1
        return exact(multiplier) * self._displacement(self.robot.joints[name]) + exact(offset)

    # -- names and parameters -----------------------------------------------------------------------

    def _renamed(self, name: str, taken: set[str]) -> str:
        """Return the name of a link or joint in the system."""
        result = identifier(name, taken)
        if result != name:
            self.reading.names[name] = result
        return result

    def _name(self, name: str) -> str:
        """Return a name of a coordinate or parameter."""
        return identifier(name, self.taken)

    def _free(self, name: str) -> str:
        """Return the prefix of the components of a free or ball joint."""
        parts = [
            f"{name}_{x}" for x in ("x", "y", "z", "e0", "e1", "e2", "e3", "wx", "wy", "wz", "vx", "vy", "vz")
        ]
        while self.taken.intersection(parts):
            name += "_"
            parts = [f"{name}_{part.rpartition('_')[2]}" for part in parts]
        self.taken.update(parts)
        return name

    def _parameter(self, name: str, value: float, unit: str) -> Any:
        """Return a parameter with this default, or the number itself: zero, or where no symbols are wanted."""
        if self.symbols == "none" or value == 0:
            return value
        symbol = self.s.parameters(**{(text := self._name(name)): value})
        if unit:
            self.s.describe(text, unit=unit)
        return symbol

    def _lengths(self, name: str, place: Vector) -> Any:
        """Return the place of a joint; its components are parameters with ``symbols="all"``."""
        if self.symbols != "all":
            return place
        return [self._parameter(f"r_{name}_{a}", x, "m") for a, x in zip("xyz", place, strict=True)]


def _each(x: Any) -> Any:
    """Return integers and the nearest floats of exact numbers, in nested tuples."""
    if isinstance(x, tuple):
        return tuple(map(_each, x))
    return x if isinstance(x, int) else float(x)


def normal(axis: Vector) -> Matrix:
    """Return a rotation matrix whose third column is a unit vector."""
    x, y, z = axis
    if (x, y) == (0, 0):
        return IDENTITY if z > 0 else ((1, 0, 0), (0, -1, 0), (0, 0, -1))
    across = math.hypot(x, y)
    u: Vector = (-y / across, x / across, 0)
    v = (-z * u[1], z * u[0], x * u[1] - y * u[0])
    return ((u[0], v[0], x), (u[1], v[1], y), (u[2], v[2], z))
