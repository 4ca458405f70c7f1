"""A cable between two points at the distance d: it pulls when it is longer than its length d_0, and never pushes.

T = max(k (d - d_0) + c d', 0) where d > d_0,        V = ½ k max(d - d_0, 0)²

The times at which it becomes taut or slack are located.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...scalar.algebra import HALF, Scalar, divide
from ..frame import Point
from .action import Action, PointForce
from .ends import check_ends
from .load import Constant, Load, Look


class Cable(Load, kind="cable"):
    """An elastic cable between two points, which may be slack."""

    start: Point
    end: Point
    stiffness: Constant  # k [N/m]
    length: Constant  # d_0 [m]
    damping: Constant = 0  # c [N s/m], while it is taut

    noun = "cable"
    words = {"start": "from", "end": "to"}
    look = Look("spring", "zigzag", "stiffness")
    switches = ("becomes taut", "becomes slack")

    def check(self) -> None:
        """Refuse two ends on one body."""
        check_ends(self.start, self.end, self.title)

    @property
    def is_conservative(self) -> bool:
        """True if it has no damping."""
        return bool(self.damping == 0)

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the pull at both ends."""
        line = at.line(self.start, self.end)
        length = line.norm()
        stretch = length - at(self.length)
        tension = at(self.stiffness) * stretch
        if self.damping != 0:
            rate = divide(line.dot(at.velocity(self.end) - at.velocity(self.start)), length)
            tension = at.max(tension + at(self.damping) * rate, 0)
        pull = at.named(divide(at.where(stretch, tension, 0), length) * line)
        yield PointForce(self.start, pull)
        yield PointForce(self.end, -pull)

    def potential(self, at: Any) -> Scalar:
        """Return ½ k (d - d_0)² of a taut cable, 0 of a slack one [J]."""
        stretch = at.line(self.start, self.end).norm() - at(self.length)
        return HALF * at(self.stiffness) * at.where(stretch, stretch * stretch, 0)
