"""Writer of MJCF: bodies nested as their joints hold them, each with the frame that it has in the system.

A joint of several motions is as many joints of one body. The body of a ball joint has the axes of the joint, and that
of a free joint its frame, since the coordinates of the file are about these.

Source: MuJoCo's documentation, XML reference.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from ...describe.system import System
from ...scalar.algebra import IDENTITY, ZERO
from ...space.mass import MassProperties
from ...space.pose import Pose
from ...space.rotation import Rotation
from ..machine import Held, Machine, Motion, text_of
from ..xml_tree import DEEPEST
from .bodies import GREATEST
from .placing import pose_attributes
from .write_contacts import UNSEEN
from .write_forces import CANNOT, Forces

LEAST = 1 / 10**15
"""Least mass and moment of inertia of a body that moves, as in MuJoCo [kg, kg m²]."""
TYPES = {"hinge": "hinge", "slider": "slide", "ball": "ball", "free": "free"}
"""Types of joints, by the words of motions."""


def text_of_system(system: System, values: Mapping[Any, Any] | None) -> str:
    """Return the text of an MJCF file.

    Raises
    ------
    FormatError
        The parts that the format cannot hold, each with its cure.
    """
    return _Writer(Machine(system, values, "An MJCF file", CANNOT)).text()


class _Writer:
    """The file that grows from a machine."""

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.root = Element("mujoco", model=machine.system.name)
        SubElement(self.root, "compiler", angle="radian")
        SubElement(self.root, "option", gravity=text_of(*machine.vector(machine.system.gravity, "gravity")))
        self.sections = {
            tag: Element(tag) for tag in ("asset", "worldbody", "contact", "tendon", "equality", "actuator")
        }
        self.elements: dict[str, Element] = {}

    def text(self) -> str:
        """Return the file."""
        m = self.machine
        for held in m.of.values():
            own = [motion.kind for motion in held.motions if motion.kind in ("ball", "free")]
            position = held.end.position if own == ["free"] else ZERO
            held.frame = Pose(held.end.rotation if own else Rotation.trusted(IDENTITY), position)
        forces = Forces(m, self.sections, self.elements)
        m.acts(forces.sayings)
        forces.damp()
        self._solids(self.sections["worldbody"], m.system.scenery, "the scenery", Pose())
        waiting = [(held, self.sections["worldbody"], 3) for held in reversed(m.held)]
        while waiting:
            held, outer, depth = waiting.pop()
            inner = self._body(held, outer)
            if depth > DEEPEST - 2:  # of joints and geoms in the body
                m.refuse(
                    "the tree",
                    f"it has more than {DEEPEST - 4} bodies one in the other, which no reader takes",
                )
                break
            waiting += [(child, inner, depth + 1) for child in reversed(held.below)]
        forces.add()
        m.finish()
        self.root.extend(section for section in self.sections.values() if len(section))
        indent(self.root)
        return tostring(self.root, encoding="unicode") + "\n"

    # -- bodies -------------------------------------------------------------------------------------

    def _body(self, held: Held, outer: Element) -> Element:
        """Return the element of a body, with its joints and its mass."""
        m = self.machine
        name, what = held.body.name, f"body '{held.body.name}'"
        inside = held.frame.inverse @ held.end  # of the joint, in the body
        here = m.place(held.joint.parent, held.start) @ inside.inverse
        body = SubElement(outer, "body", {"name": name, **pose_attributes(here)})
        self.elements[name] = body
        own = m.properties(held)
        if name == "world":
            m.refuse(what, "the format calls the ground so; give the body another name")
        if held.motions and not any(_heavy(m.properties(one)) for one in _welded(held)):
            m.refuse(
                what, "MuJoCo moves no body without a mass and a moment of inertia about each axis; give it a "
                "thickness, such as fb.cylinder in place of fb.slender_bar, or fb.sphere in place of fb.particle",
            )  # fmt: skip
        kinds = [motion.kind for motion in held.motions]
        if "ball" in kinds and "hinge" in kinds[kinds.index("ball") :]:
            m.refuse(
                held.joint.title, "MuJoCo takes no turn after a ball in one body; put a body between them"
            )
        for motion in held.motions:
            self._joint(body, motion, held, inside)
        if own.mass or any(map(any, own.inertia)):
            self._inertial(body, own)
        self._solids(body, held.body.mass_properties.shape, what, held.frame.inverse)
        return body

    def _joint(self, body: Element, motion: Motion, held: Held, inside: Pose) -> None:
        """Add a joint to its body."""
        m = self.machine
        if motion.kind == "free":
            ground = held.joint.parent.is_ground and held.start == Pose() and len(held.motions) == 1
            if not ground:
                m.refuse(
                    motion.title, "a free joint of the format begins at the origin of the ground and has its axes; "
                    "use s.free(name, s.ground, body) without at= and parent_axes=",
                )  # fmt: skip
        numbers: dict[str, Any] = {}
        if motion.kind != "free":
            numbers["pos"] = inside.point(motion.anchor)
        if motion.kind in ("hinge", "slider"):
            numbers["axis"] = inside.vector(motion.axis)
        low, high = (min(max(x, -GREATEST), GREATEST) for x in (motion.low, motion.high))
        numbers |= {
            "ref": motion.ref, "armature": motion.armature, "damping": motion.damping, "stiffness": motion.stiffness,
            "springref": motion.rest if motion.stiffness else 0, "frictionloss": motion.friction,
            "range": (low, high) if motion.limits else (),
        }  # fmt: skip
        attributes = {"name": motion.name, "type": TYPES.get(motion.kind, motion.kind)}
        for key, value in numbers.items():
            several = value if isinstance(value, tuple) else (value,)
            if any(several):
                attributes[key] = text_of(*several)
        SubElement(body, "joint", attributes)

    def _inertial(self, body: Element, own: MassProperties) -> None:
        """Add the mass properties of a body, about its principal axes."""
        inertia = np.array(own.inertia, float)
        moments, axes = np.diagonal(inertia), np.eye(3)
        if np.count_nonzero(inertia - np.diag(moments)):
            moments, axes = np.linalg.eigh(inertia)
            axes = axes * np.sign(np.linalg.det(axes))
        pose = Pose(Rotation.trusted(axes.tolist()), own.center)
        numbers = {"mass": text_of(own.mass), "diaginertia": text_of(*moments)}
        SubElement(body, "inertial", {"pos": "0 0 0", **pose_attributes(pose), **numbers})

    def _solids(self, element: Element, shape: Any, what: str, frame: Pose) -> None:
        """Add the solids by which a body is drawn."""
        for kind, sizes, pose, color in self.machine.solids(shape, what):
            halves = tuple(x / 2 for x in sizes) if kind == "box" else sizes
            if kind == "cylinder":
                halves = (sizes[0], sizes[1] / 2)
            attributes = {"type": kind, "size": text_of(*halves), **pose_attributes(frame @ pose)}
            if color:
                attributes["rgba"] = text_of(*(int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)), 1)
            SubElement(element, "geom", {**attributes, **UNSEEN})


def _welded(held: Held) -> Sequence[Held]:
    """Return a body with those that are welded to it."""
    result = [held]
    for one in result:  # grows as it is read
        result += [child for child in one.below if not child.motions]
    return result


def _heavy(own: MassProperties) -> bool:
    """Return True if MuJoCo moves a body of these mass properties."""
    least = np.linalg.eigvalsh(np.array(own.inertia, float)).min()
    return own.mass > LEAST and least > LEAST and math.isfinite(least)
