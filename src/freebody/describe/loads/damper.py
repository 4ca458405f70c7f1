"""A straight damper between two points, at the distance d = |r|: F = c (r·r'/d²) r."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...scalar.algebra import divide
from ..frame import Point
from ..part import Constant
from .action import Action, PointForce
from .ends import check_ends
from .load import Load, Look


class Damper(Load, kind="damper", sections=("dampers",)):
    """A straight linear damper between two points: it resists a change of their distance."""

    start: Point
    end: Point
    damping: Constant  # c [N s/m]

    units = {"damping": "N s/m"}
    noun = "damper"
    words = {"start": "from", "end": "to"}
    look = Look("damper", "dashpot", "damping")

    def check(self) -> None:
        """Refuse two ends on one body."""
        check_ends(self.start, self.end, self.title)

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the pull at both ends."""
        line = at.line(self.start, self.end)
        length = line.norm()
        velocity = at.velocity(self.end) - at.velocity(self.start)
        pull = at.named(divide(at(self.damping) * line.dot(velocity), length * length) * line)
        yield PointForce(self.start, pull)
        yield PointForce(self.end, -pull)
