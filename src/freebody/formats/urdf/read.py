"""A robot as a system: fixed joints merge their links, the others are joints of the system."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...describe.system import System
from ...scalar.algebra import IDENTITY, multiply
from ...scalar.expression import exact
from ...space.pose import Pose
from ..builder import Builder, Cluster, check_options, normal
from ..meshes import Meshes
from ..reading import Reading
from ..xml_tree import Element, identifier
from .robot import Joint, Link, Robot, robot

GRAVITY = 9.81


def system_of(
    root: Element, file: Path, base: str | None, symbols: str, keep_fixed: bool, meshes: bool
) -> System:
    """Return the system of a URDF file, with ``reading``.

    Raises
    ------
    FormatError
        With the line, what was expected and what came.
    ModelError
        An option that does not exist.
    """
    check_options(base=base, symbols=symbols, keep_fixed=keep_fixed, meshes=meshes)
    reading = Reading(file.name)
    found = Meshes(file) if meshes else None
    return _Reader(robot(root, reading, found), reading, symbols, keep_fixed).system(base or "fixed")


class _Reader(Builder):
    """The system that grows from a robot."""

    def __init__(self, robot: Robot, reading: Reading, symbols: str, keep_fixed: bool) -> None:
        super().__init__(robot.name, reading, symbols)
        self.robot, self.keep_fixed = robot, keep_fixed
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
                s.free(name, s.ground, held, coordinate=self.free(name))
            else:
                s.planar(
                    name, s.ground, held, coordinate=[self.name(f"{name}_{x}") for x in ("x", "y", "turn")]
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
        if joint.damping:
            s.damper(f"{name}_damper", made, damping=self.parameter(f"d_{name}", joint.damping, ""))
        if joint.stiffness:
            stiffness = self.parameter(f"k_{name}", joint.stiffness, "")
            s.spring(f"{name}_spring", made, stiffness=stiffness, rest=joint.rest)

    def _displacement(self, joint: Joint) -> Any:
        """Return the coordinate of a joint, or the expression of the joint that it mimics."""
        if joint.mimic is None:
            if joint.name not in self.coordinates:
                self.coordinates[joint.name] = self.s.coordinates(self.name(joint.name))
            return self.coordinates[joint.name]
        name, multiplier, offset = joint.mimic
        self.reading.counts["mimic"] += 1
        return exact(multiplier) * self._displacement(self.robot.joints[name]) + exact(offset)
