"""A robot as a system: fixed joints merge their links, the others are joints of the system."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...describe.system import System
from ...errors import shown
from ...scalar.algebra import IDENTITY, multiply
from ...scalar.expression import exact
from ...space.pose import Pose
from ..builder import UNITS, Builder, Cluster, Options, normal
from ..meshes import Meshes
from ..reading import Reading
from ..xml_tree import Element, identifier
from .contacts import add_contacts
from .joint import Joint
from .link import Link
from .robot import Robot, robot

GRAVITY = 9.81


def system_of(root: Element, file: Path, reading: Reading, options: Options) -> System:
    """Return the system of a URDF file, with ``reading``.

    Raises
    ------
    FormatError
        With the line, what was expected and what came.
    """
    meshes = Meshes(file, reading)
    reader = _Reader(robot(root, reading, meshes if options.meshes else None), reading, options)
    system = reader.system("fixed" if options.base is None else options.base)
    add_contacts(reader, meshes)
    return system


class _Reader(Builder):
    """The system that grows from a robot."""

    def __init__(self, robot: Robot, reading: Reading, options: Options) -> None:
        super().__init__(robot.name, reading, options)
        self.robot, self.keep_fixed = robot, options.keep_fixed
        self.coordinates: dict[str, Any] = {}
        self.clusters: dict[str, Cluster] = {}
        self.mimics: dict[str, list[tuple[Joint, float, float]]] = {}  # followers of each joint
        for one in robot.joints.values():
            if one.mimic is not None:
                self.mimics.setdefault(one.mimic[0], []).append((one, *one.mimic[1:]))

    def system(self, base: Any) -> System:
        """Return the system."""
        s, root = self.s, self.robot.links[self.robot.root]
        first = self._cluster(root)
        driven = self._driven(first)
        g = s.parameters(g=GRAVITY) if self.symbols != "none" else GRAVITY
        self.taken.add("g")
        if self.symbols != "none":
            s.describe("g", unit="m/s²")
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
                    f"expected a mass of link '{root.name}', which moves freely with base={shown(base)}"
                )
            self.held(name, held)
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
        """Add the body of a cluster, with the frames of its links."""
        body = self.body(cluster, "link")
        self._frames(cluster, body)
        return body

    # -- joints -------------------------------------------------------------------------------------

    def _joint(self, joint: Joint, parent: Any, child: Any, pose: Pose) -> None:
        """Add a joint with its damper and spring."""
        s, name = self.s, self.renamed(joint.name, self.joints)
        axes = pose.rotation.matrix
        where: dict[str, Any] = {"at": self.lengths(name, pose.position)}
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
                q = [self.name(f"{name}_{x}") for x in ("x", "y", "turn")]
                s.planar(name, parent, child, coordinate=q, child_axes=turn, **where)
                return
            case "floating":
                s.free(name, parent, child, coordinate=self.free(name), **where)
                return
            case _:
                s.ball(name, parent, child, coordinate=self.free(name), **where)
                return
        damping, stiffness = UNITS["slide" if joint.kind == "prismatic" else "hinge"]
        if joint.damping:
            s.damper(f"{name}_damper", made, damping=self.parameter(f"d_{name}", joint.damping, damping))
        if joint.stiffness:
            stiffness = self.parameter(f"k_{name}", joint.stiffness, stiffness)
            s.spring(f"{name}_spring", made, stiffness=stiffness, rest=joint.rest)
        if joint.mimic is None:
            self._stops(joint, name, made)

    def _stops(self, joint: Joint, name: str, made: Any) -> None:
        """Add the stops and the dry friction of a joint, with those of the joints that mimic it.

        A follower y = m q + b between two limits holds q between (limit - b)/m; its friction T acts as |m| T on q.
        """
        line, what, limits, friction = joint.element.line, joint.what, joint.limits, joint.friction
        for one, m, b in self._followers(joint):
            friction += abs(m) * one.friction
            if one.limits is None or m == 0:
                continue
            low, high = sorted((limit - b) / m + 0 for limit in one.limits)  # -0.0 becomes 0.0
            narrow = (low, high) if limits is None else (max(limits[0], low), min(limits[1], high))
            if narrow != limits:
                self.reading.changed(
                    one.what, one.element.line, "its limits are those of the joint that it follows",
                    f"'{joint.name}' {narrow[0]:g} to {narrow[1]:g}",
                )  # fmt: skip
            limits = narrow
        if limits is not None:
            self.stop(what, line, name, made, limits)
            self.inside(what, line, self.coordinates[joint.name].func.__name__, limits)
        self.dry_friction(what, line, name, made, friction)

    def _followers(self, joint: Joint) -> list[tuple[Joint, float, float]]:
        """Return the joints that mimic a joint, by way of others too, with m and b of y = m q + b."""
        result: list[tuple[Joint, float, float]] = []
        waiting = [(joint.name, 1.0, 0.0)]
        while waiting:
            name, m, b = waiting.pop()
            for one, multiplier, shift in self.mimics.get(name, ()):
                factor, offset = multiplier * m, multiplier * b + shift
                result.append((one, factor, offset))
                waiting.append((one.name, factor, offset))
        return result

    def _displacement(self, joint: Joint) -> Any:
        """Return the coordinate of a joint, or the expression of the joint that it mimics."""
        if joint.mimic is None:
            if joint.name not in self.coordinates:
                self.coordinates[joint.name] = self.s.coordinates(self.name(joint.name))
            return self.coordinates[joint.name]
        name, multiplier, offset = joint.mimic
        self.reading.counts["mimic"] += 1
        return exact(multiplier) * self._displacement(self.robot.joints[name]) + exact(offset)
