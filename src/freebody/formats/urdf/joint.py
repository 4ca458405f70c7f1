"""Joints of a URDF file: type, pose, axis, limits, forces, and the joint that one mimics.

Source: the XML specification of URDF (ROS wiki, urdf/XML), and what its reference reader (urdfdom) accepts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from ...scalar.algebra import Vector
from ...space.pose import Pose
from ..builder import whole
from ..reading import Reading
from ..xml_tree import Element
from .origin import pose_of
from .words import MOVING, SEVERAL, say_unknown

ENDS, DRIVE = ("lower", "upper"), ("effort", "velocity")
"""Attributes of <limit>."""


@dataclass(frozen=True)
class Joint:
    """A joint; ``mimic`` is (joint, multiplier, offset) of a joint that follows another."""

    name: str
    kind: str
    element: Element
    parent: str
    child: str
    pose: Pose
    axis: Vector = (1, 0, 0)
    damping: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    mimic: tuple[str, float, float] | None = None
    friction: float = 0.0
    limits: tuple[float, float] | None = None

    @property
    def what(self) -> str:
        """Kind and name, as the report writes them."""
        return f"joint '{self.name}'"


def joint(element: Element, reading: Reading) -> Joint:
    """Return a joint."""
    name, kind = element.get("name"), element.get("type")
    what = f"joint '{name}'"
    if kind not in (*MOVING, "fixed"):
        raise element.error(f"expected a type of {what} among {', '.join((*MOVING, 'fixed'))}, got '{kind}'")
    ends = []
    for tag in ("parent", "child"):
        end = element.first(tag)
        if end is None:
            raise element.error(f"expected <{tag} link=...> in {what}")
        ends.append(end.get("link"))
    say_unknown(element, what, reading)
    result = Joint(name, kind, element, ends[0], ends[1], pose_of(element, reading))
    if kind == "fixed":
        return result
    result = replace(result, axis=_axis(element, kind, what, reading), mimic=_mimic(element, what))
    result = replace(_with_forces(result, what, reading), limits=_limits(element, result, reading))
    for tag in ("safety_controller", "calibration"):
        one = element.first(tag)
        if one is not None:
            reading.left_out(what, one.line, f"<{tag}> is a setting of a controller")
    return result


def _limits(element: Element, joint: Joint, reading: Reading) -> tuple[float, float] | None:
    """Return the limits of a joint that has some; ``reading`` keeps them, and those of its drive."""
    limit = element.first("limit")
    if limit is None:
        return None
    ends = {key: limit.bound(key) for key in (*ENDS, *DRIVE) if key in limit.attributes}
    bounds = {key: end for key, end in ends.items() if math.isfinite(end)}
    if bounds:
        reading.limits[joint.name] = bounds
    drive = ", ".join(f"{key} {bounds[key]:g}" for key in DRIVE if key in bounds)
    if drive:
        reading.left_out(
            joint.what, limit.line, "nothing limits the drive: s.reading.limits has its limits", drive
        )
    if joint.kind not in ("revolute", "prismatic") or not any(key in bounds for key in ENDS):
        return None
    low, high = (
        sign * math.inf if key in ends and key not in bounds else ends.get(key, 0.0)
        for key, sign in zip(ENDS, (-1, 1), strict=True)
    )
    return (low, high)


def _axis(element: Element, kind: str, what: str, reading: Reading) -> Vector:
    """Return the axis of a joint."""
    axis = element.first("axis")
    if axis is None:
        if kind in ("revolute", "continuous", "prismatic", "planar"):
            reading.changed(what, element.line, "without <axis> it is (1, 0, 0), as the format has it")
        return (1, 0, 0)
    x, y, z = axis.numbers("xyz", 3)
    length = math.hypot(x, y, z)
    if length == 0:
        if kind in ("floating", "spherical"):
            return (1, 0, 0)
        raise axis.error(f"expected an axis of {what} that has a direction, got (0, 0, 0)")
    if length != 1:
        if abs(length - 1) > 1e-6:
            reading.changed(
                what, axis.line, "an axis of another length than 1 is a direction", f"{length:.6g}"
            )
        x, y, z = x / length, y / length, z / length
    return (whole(x), whole(y), whole(z))


def _mimic(element: Element, what: str) -> tuple[str, float, float] | None:
    mimic = element.first("mimic")
    if mimic is None:
        return None
    if element.get("type") in SEVERAL:
        raise mimic.error(f"expected <mimic> on a joint of one coordinate, got it on {what}")
    return (mimic.get("joint"), mimic.number("multiplier", 1.0), mimic.number("offset", 0.0))


def _with_forces(joint: Joint, what: str, reading: Reading) -> Joint:
    """Return the joint with its damper and spring."""
    dynamics = joint.element.first("dynamics") or joint.element.first("joint_properties")
    if dynamics is None:
        return joint
    values = {
        key: dynamics.number(key, 0.0)
        for key in ("damping", "friction", "spring_stiffness", "spring_reference")
    }
    for key in ("damping", "friction", "spring_stiffness"):
        if values[key] < 0:
            raise dynamics.error(f"expected a {key} of {what} that is not negative, got {values[key]:g}")
    if joint.kind in SEVERAL and (values["damping"] or values["spring_stiffness"] or values["friction"]):
        reading.left_out(
            what, dynamics.line, f"a {joint.kind} joint has no damping, no friction and no spring"
        )
        return joint
    return replace(
        joint,
        damping=values["damping"],
        stiffness=values["spring_stiffness"],
        rest=values["spring_reference"],
        friction=values["friction"],
    )
