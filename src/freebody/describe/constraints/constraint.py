"""Constraints besides the joints of the tree: closures of loops, conditions on coordinates and on speeds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..frame import Point
from ..joints.joint import Joint
from ..said import Named


@dataclass(frozen=True, repr=False)
class Condition(Named):
    """An expression of coordinates and time that stays zero.

    ``unilateral``: it is kept from below only, as a bead in an open groove is. Its force is then 0 or more.
    """

    name: str
    expression: Any
    unilateral: bool = False


@dataclass(frozen=True, repr=False)
class SpeedCondition(Named):
    """An expression, linear in speeds, that stays zero: rolling without slip, a knife edge."""

    name: str
    expression: Any


@dataclass(frozen=True, repr=False)
class Gear(Named):
    """Displacement of the first joint = ratio times that of the second; the pressure angle of the teeth, if known."""

    name: str
    first: Joint
    second: Joint
    ratio: Any
    pressure_angle: Any = None


@dataclass(frozen=True, repr=False)
class Rope(Named):
    """A taut, massless rope of constant length that runs without friction over points.

    ``unilateral``: it only pulls; else it is a light rod, which may push.
    """

    name: str
    points: tuple[Point, ...]
    length: Any
    unilateral: bool = True


@dataclass(frozen=True, repr=False)
class Rolling(Named):
    """A thin wheel (or a sphere, without axis) that touches a plane of the ground and rolls on it without slip.

    ``normal`` points away from the plane, to the side of the wheel; with ``first`` and ``second`` in the plane it
    makes a right-handed set of (letter, unit vector) in ground axes. ``unilateral``: the plane only presses on the
    wheel. ``friction`` is the coefficient that the rolling is not to ask more than; None: it is not known.
    """

    name: str
    center: Point
    axis: Any
    radius: Any
    plane: Point
    normal: tuple[str, Any]
    first: tuple[str, Any]
    second: tuple[str, Any]
    written_axis: Any = None
    """The axis as the user wrote it."""
    unilateral: bool = True
    friction: Any = None


Constraint = Rolling | Condition | SpeedCondition | Gear | Rope
