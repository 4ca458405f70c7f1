"""Constraints besides the joints of the tree: closures of loops, conditions on coordinates and on speeds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...scalar.algebra import Scalar, Vector
from ..frame import Point
from ..labels import Named
from .gear import Gear as Gear


@dataclass(frozen=True, repr=False)
class Condition(Named):
    """An expression of coordinates and time that stays zero.

    ``unilateral``: the expression is kept from falling below zero only, like a bead in an open groove. The force is
    then 0 or more.
    """

    name: str
    expression: Scalar
    unilateral: bool = False


@dataclass(frozen=True, repr=False)
class SpeedCondition(Named):
    """An expression, linear in speeds, that stays zero: rolling without slip, a knife edge."""

    name: str
    expression: Scalar


@dataclass(frozen=True, repr=False)
class Rope(Named):
    """A taut, massless rope of constant length that runs without friction over points.

    ``unilateral``: it only pulls; otherwise it is a light rod, which may push.
    """

    name: str
    points: tuple[Point, ...]
    length: Scalar
    unilateral: bool = True


@dataclass(frozen=True, repr=False)
class Rolling(Named):
    """A thin wheel (or a sphere, without axis) that touches a plane of the ground and rolls on it without slip.

    ``normal`` points away from the plane, to the side of the wheel; with ``first`` and ``second`` in the plane it
    makes a right-handed set of (letter, unit vector) in ground axes. ``unilateral``: the plane only presses on the
    wheel. ``friction`` is the coefficient that bounds the rolling force; None: it is not known.
    """

    name: str
    center: Point
    axis: Vector | None
    radius: Scalar
    plane: Point
    normal: tuple[str, Vector]
    first: tuple[str, Vector]
    second: tuple[str, Vector]
    written_axis: Any = None
    """The axis as the user wrote it."""
    unilateral: bool = True
    friction: Scalar = None


Constraint = Rolling | Condition | SpeedCondition | Gear | Rope
