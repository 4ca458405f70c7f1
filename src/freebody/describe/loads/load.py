"""Loads: forces, couples, springs and dampers, each with its name in the equations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...scalar.algebra import Scalar, Vector
from ..frame import Frame, Point
from ..joints.joint import Joint
from ..labels import Named


@dataclass(frozen=True, repr=False)
class Force(Named):
    """A force at a point of a body; components in the axes of ``frame`` [N]."""

    name: str
    point: Point
    components: Vector
    frame: Frame


@dataclass(frozen=True, repr=False)
class Torque(Named):
    """A couple on a body, and its opposite on ``reaction_on``; components in the axes of ``frame`` [N m]."""

    name: str
    body: Frame
    components: Vector
    frame: Frame
    reaction_on: Frame | None


@dataclass(frozen=True, repr=False)
class JointForce(Named):
    """A force (slider) or moment (hinge) of a motor along one displacement of a joint."""

    name: str
    joint: Joint
    index: int
    value: Scalar


@dataclass(frozen=True, repr=False)
class JointSpring(Named):
    """A spring along one displacement of a joint: force -stiffness * (displacement - rest)."""

    name: str
    joint: Joint
    index: int
    stiffness: Scalar
    rest: Scalar


@dataclass(frozen=True, repr=False)
class JointDamper(Named):
    """A damper along one displacement of a joint: force -damping * rate."""

    name: str
    joint: Joint
    index: int
    damping: Scalar


@dataclass(frozen=True, repr=False)
class Spring(Named):
    """A straight spring between two points: tension stiffness * (distance - rest)."""

    name: str
    start: Point
    end: Point
    stiffness: Scalar
    rest: Scalar


@dataclass(frozen=True, repr=False)
class Damper(Named):
    """A straight damper between two points: tension damping * d(distance)/dt."""

    name: str
    start: Point
    end: Point
    damping: Scalar


@dataclass(frozen=True, repr=False)
class GeneralizedForce(Named):
    """A force conjugate to a coordinate."""

    name: str
    coordinate: Any
    value: Scalar


Load = Force | Torque | JointForce | JointSpring | JointDamper | Spring | Damper | GeneralizedForce
