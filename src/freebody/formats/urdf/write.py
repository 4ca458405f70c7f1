"""Writer of URDF: bodies are links whose frames stand in their joints, the ground is the first link.

A joint of several motions is a row of joints with links without mass between them. Limits and drives without end are
the greatest float, since the format demands limits of prismatic and revolute joints.

Source: the XML specification of URDF (ROS wiki, urdf/XML).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from ...describe.system import System
from ...scalar.algebra import Vector
from ...space.pose import Pose
from ...space.rotation import Rotation
from ..machine import GROUND, Held, Machine, Motion, text_of
from ..xml_tree import GREATEST, identifier
from .read import GRAVITY

BETWEEN = "the format has no forces but those of joints; keep it in Python or in a .toml file"
CANNOT = {
    "ball": "the format has no ball joint; use a gimbal, or write a .xml file (MJCF)",
    "screw": "the format has no screw; write the drive as a hinge",
    "path": "the format has no joint by functions",
    "armature": "the format has no armature; add it to the inertia, or write a .xml file (MJCF)",
    "ContactPair": "the format has shapes but no floor and no friction; write a .xml file (MJCF)",
    "joint_effort": "the format has no motors; leave it out: a program that reads the file drives the joint",
    "generalized_force": "the format has no motors; leave it out: a program that reads the file drives the joint",
    "motor": "the format has no motors; leave it out: a program that reads the file drives the joint",
    **dict.fromkeys(("spring", "damper", "force", "torque"), BETWEEN),
    **dict.fromkeys(
        ("torsion_spring", "torsion_damper"), "springs and dampers of the format act along one axis"
    ),
    **dict.fromkeys(
        ("Condition", "Gear"), "the format has no constraints but a joint whose displacement is an expression"
    ),
}
"""Why URDF cannot hold a kind of part; what is named here or in no other place is refused."""


def text_of_system(system: System, values: Mapping[Any, Any] | None) -> str:
    """Return the text of a URDF file.

    Raises
    ------
    FormatError
        The parts that the format cannot hold, each with its cure.
    """
    writer = _Writer(Machine(system, values, "A URDF file", CANNOT))
    return writer.text()


class _Writer:
    """The robot that grows from a machine."""

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.robot = Element("robot", name=machine.system.name)

    def text(self) -> str:
        """Return the file."""
        m = self.machine
        self._gravity()
        m.acts(
            {
                "joint_spring": m.spring,
                "joint_damper": m.damper,
                "joint_friction": m.dry_friction,
                "stop": m.stop,
            }
        )
        for joint in m.system.joints.values():
            if joint.closes:
                m.refuse(joint.title, "it closes a loop, and the format has trees; write a .xml file (MJCF)")
        for held in m.of.values():
            held.frame = held.end if not held.motions else held.end @ Pose(position=held.motions[-1].anchor)
        self._link(GROUND, None)
        waiting = list(reversed(m.held))
        while waiting:
            held = waiting.pop()
            self._joint(held)
            waiting += reversed(held.below)
        m.finish()
        indent(self.robot)
        return '<?xml version="1.0"?>\n' + tostring(self.robot, encoding="unicode") + "\n"

    def _gravity(self) -> None:
        """Refuse gravity of another direction or size than readers take."""
        m = self.machine
        g = m.vector(m.system.gravity, "gravity")
        if g != (0, 0, -GRAVITY):
            m.refuse(
                f"gravity ({', '.join(f'{x:g}' for x in g)})",
                f"the format has none, and what reads it takes {GRAVITY} against z; set s.gravity = (0, 0, -{GRAVITY})",
            )

    # -- links --------------------------------------------------------------------------------------

    def _link(self, name: str, held: Held | None) -> None:
        """Add a link with its mass and its solids; that of the ground without a body."""
        m, link = self.machine, SubElement(self.robot, "link", name=name)
        shape, what = m.system.scenery, "the scenery"
        if held is not None:
            own, what = m.properties(held), f"body '{name}'"
            shape = held.body.mass_properties.shape
            inertial = SubElement(link, "inertial")
            SubElement(inertial, "origin", xyz=text_of(*own.center))
            SubElement(inertial, "mass", value=text_of(own.mass))
            entries = {
                "i" + "xyz"[i] + "xyz"[j]: text_of(own.inertia[i][j]) for i in range(3) for j in range(i, 3)
            }
            SubElement(inertial, "inertia", entries)
        for number, (kind, sizes, pose, color) in enumerate(m.solids(shape, what)):
            if kind == "ellipsoid":
                continue
            visual = SubElement(link, "visual")
            self._origin(visual, pose if held is None else held.frame.inverse @ pose)
            geometry = SubElement(visual, "geometry")
            if kind == "box":
                SubElement(geometry, "box", size=text_of(*sizes))
            else:
                names = ("radius", "length")[: len(sizes)]
                SubElement(geometry, kind, {key: text_of(x) for key, x in zip(names, sizes, strict=True)})
            if color:
                material = SubElement(visual, "material", name=f"{name}_{number + 1}")
                rgb = [int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)]
                SubElement(material, "color", rgba=text_of(*rgb, 1))

    # -- joints -------------------------------------------------------------------------------------

    def _joint(self, held: Held) -> None:
        """Add the joints of a body, and the links between them."""
        m = self.machine
        parent = held.joint.parent
        link, here = (GROUND if parent.is_ground else parent.name), m.place(parent, held.start)
        if not held.motions:
            name = identifier(held.joint.name, m.joint_names)
            self._element(name, "fixed", link, held.body.name, here)
        for index, motion in enumerate(held.motions):
            last = index == len(held.motions) - 1
            child = held.body.name if last else identifier(f"{held.body.name}_{index + 1}", m.link_names)
            if not last:
                SubElement(self.robot, "link", name=child)
            before = held.motions[index - 1].anchor if index else (0, 0, 0)
            x, y, z = (b - a for a, b in zip(before, motion.anchor, strict=True))
            here = here @ Pose(position=(x, y, z)) @ _moved(motion)
            self._motion(self._element(motion.name, _type(motion), link, child, here), motion)
            link, here = child, Pose()
        self._link(held.body.name, held)

    def _element(self, name: str, kind: str, parent: str, child: str, pose: Pose) -> Element:
        joint = SubElement(self.robot, "joint", name=name, type=kind)
        self._origin(joint, pose)
        SubElement(joint, "parent", link=parent)
        SubElement(joint, "child", link=child)
        return joint

    def _motion(self, joint: Element, motion: Motion) -> None:
        """Add what a joint of one coordinate has."""
        if motion.kind not in ("hinge", "slider"):
            return
        SubElement(joint, "axis", xyz=text_of(*motion.axis))
        if motion.follows is not None:
            leader, polynomial = motion.follows
            if polynomial.degree() > 1:
                self.machine.refuse(
                    motion.title,
                    "its displacement is no linear function of another; write a .xml file (MJCF)",
                )
            multiplier, offset = (float(polynomial.coeff_monomial(polynomial.gen**k)) for k in (1, 0))
            SubElement(
                joint, "mimic", joint=leader.name, multiplier=text_of(multiplier), offset=text_of(offset)
            )
        if motion.kind == "slider" or motion.limits:
            low, high = (min(max(x, -GREATEST), GREATEST) for x in (motion.low, motion.high))
            without = {"effort": text_of(GREATEST), "velocity": text_of(GREATEST)}
            SubElement(joint, "limit", {"lower": text_of(low), "upper": text_of(high), **without})
        acting = {
            "damping": motion.damping, "friction": motion.friction,
            "spring_stiffness": motion.stiffness, "spring_reference": motion.rest,
        }  # fmt: skip
        if any(acting.values()):
            SubElement(joint, "dynamics", {key: text_of(x) for key, x in acting.items() if x})

    def _origin(self, element: Element, pose: Pose) -> None:
        """Add the <origin> of an element."""
        angles = roll_pitch_yaw(pose.rotation.matrix)
        if not any((*pose.position, *angles)):
            return
        SubElement(element, "origin", xyz=text_of(*pose.position), rpy=text_of(*angles))


def _type(motion: Motion) -> str:
    """Return the type of a joint of one motion."""
    if motion.kind == "hinge":
        return "revolute" if motion.limits else "continuous"
    return {"slider": "prismatic", "free": "floating"}.get(motion.kind, motion.kind)


def _moved(motion: Motion) -> Pose:
    """Return the pose in which the coordinate, zero at no ``ref`` in URDF, begins."""
    if not motion.ref:
        return Pose()
    if motion.kind == "slider":
        x, y, z = (-motion.ref * a for a in motion.axis)
        return Pose(position=(x, y, z))
    return Pose(Rotation.axis_angle(motion.axis, -motion.ref))


def roll_pitch_yaw(R: Any) -> Vector:
    """Return the angles of R = Rz(yaw) Ry(pitch) Rx(roll); the roll is exact for the yaw where they are one turn.

    >>> roll_pitch_yaw(((0, -1, 0), (1, 0, 0), (0, 0, 1)))
    (0.0, 0.0, 1.5707963267948966)
    """
    yaw = math.atan2(R[1][0], R[0][0])
    pitch = math.atan2(-R[2][0], math.hypot(R[0][0], R[1][0]))
    s, c = math.sin(yaw), math.cos(yaw)
    # of Rzᵀ R the entries that only Rx has: (0, -sin) and (0, cos)
    roll = math.atan2(s * R[0][2] - c * R[1][2], c * R[1][1] - s * R[0][1])
    return (roll, pitch, yaw)
