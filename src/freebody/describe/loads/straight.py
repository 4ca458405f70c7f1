"""What loads straight between two points have in common: they pull their ends together by q r, at the distance r.

q = T/|r| is the force density of a tension T.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...errors import ModelError
from ...scalar.algebra import FieldVector, Scalar, divide
from ..frame import Point
from .action import Action, PointForce
from .load import Load


def check_ends(start: Point, end: Point, title: str) -> None:
    """Refuse two ends on one body."""
    if start.body is end.body:
        raise ModelError(
            f"Both ends of {title} are on '{start.body.name}', so it does nothing. Put one end on another body."
        )


class Straight(Load):
    """A load straight between two points, with the force density of its kind."""

    start: Point
    end: Point

    words = {"start": "from", "end": "to"}

    def check(self) -> None:
        """Refuse two ends on one body."""
        check_ends(self.start, self.end, self.title)

    def _density(self, at: Any, line: FieldVector, length: Scalar) -> Scalar:
        """Return q, positive where the ends are pulled together [N/m]."""
        raise NotImplementedError

    def _velocity_along(self, at: Any, line: FieldVector) -> Scalar:
        """Return r·r'."""
        return line.dot(at.velocity(self.end) - at.velocity(self.start))

    def _rate(self, at: Any, line: FieldVector, length: Scalar) -> Scalar:
        """Return the rate of the distance [m/s]."""
        return divide(self._velocity_along(at, line), length)

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the pull at both ends."""
        line = at.line(self.start, self.end)
        pull = at.named(self._density(at, line, line.norm()) * line)
        yield PointForce(self.start, pull)
        yield PointForce(self.end, -pull)
