"""A straight spring between two points, at the distance d = |r|:

F = k (d - d_0) r/d,        V = ½ k (d - d_0)²
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...scalar.algebra import HALF, Scalar, divide
from ..frame import Point
from ..part import Constant
from .action import Action, PointForce
from .ends import check_ends
from .load import Load, Look


class Spring(Load, kind="spring", sections=("springs",)):
    """A straight linear spring between two points, free of force at the distance ``rest``."""

    start: Point
    end: Point
    stiffness: Constant  # k [N/m]
    rest: Constant = 0  # d_0 [m]

    units = {"stiffness": "N/m", "rest": "m"}
    noun = "spring"
    words = {"start": "from", "end": "to"}
    labels = {"rest": "rest length"}
    look = Look("spring", "zigzag", "stiffness")

    def check(self) -> None:
        """Refuse two ends on one body."""
        check_ends(self.start, self.end, self.title)

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the pull at both ends."""
        line = at.line(self.start, self.end)
        length = line.norm()
        pull = at.named(divide(at(self.stiffness) * (length - at(self.rest)), length) * line)
        yield PointForce(self.start, pull)
        yield PointForce(self.end, -pull)

    def potential(self, at: Any) -> Scalar:
        """Return ½ k (d - d_0)² [J]."""
        stretch = at.line(self.start, self.end).norm() - at(self.rest)
        return HALF * at(self.stiffness) * stretch * stretch
