"""Loads: forces, couples, springs and dampers, each with the name it carries in the equations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..frame import Frame, Point
from ..joints.joint import Joint
from ..said import Named

Components = tuple[Any, Any, Any]


@dataclass(frozen=True, repr=False)
class Force(Named):
    """A force at a point of a body; components in the axes of ``frame`` [N]."""

    name: str
    point: Point
    components: Components
    frame: Frame


@dataclass(frozen=True, repr=False)
class Torque(Named):
    """A couple on a body, and its opposite on ``reaction_on``; components in the axes of ``frame`` [N m]."""

    name: str
    body: Frame
    components: Components
    frame: Frame
    reaction_on: Frame | None


@dataclass(frozen=True, repr=False)
class JointForce(Named):
    """A force (slider) or moment (hinge) of a motor along one displacement of a joint."""

    name: str
    joint: Joint
    index: int
    value: Any


@dataclass(frozen=True, repr=False)
class JointSpring(Named):
    """-stiffness * (displacement - rest) along one displacement of a joint."""

    name: str
    joint: Joint
    index: int
    stiffness: Any
    rest: Any


@dataclass(frozen=True, repr=False)
class JointDamper(Named):
    """-damping * rate along one displacement of a joint."""

    name: str
    joint: Joint
    index: int
    damping: Any


@dataclass(frozen=True, repr=False)
class Spring(Named):
    """A straight spring between two points: tension stiffness * (distance - rest)."""

    name: str
    start: Point
    end: Point
    stiffness: Any
    rest: Any


@dataclass(frozen=True, repr=False)
class Damper(Named):
    """A straight damper between two points: tension damping * d(distance)/dt."""

    name: str
    start: Point
    end: Point
    damping: Any


@dataclass(frozen=True, repr=False)
class GeneralizedForce(Named):
    """A force conjugate to a coordinate."""

    name: str
    coordinate: Any
    value: Any


Load = Force | Torque | JointForce | JointSpring | JointDamper | Spring | Damper | GeneralizedForce
