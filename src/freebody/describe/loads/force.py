"""A force at a point of a body."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...errors import ModelError
from ...scalar.algebra import Vector
from ..frame import Frame, Point
from .action import Action, PointForce
from .load import Load


class Force(Load, kind="force", sections=("forces",)):
    """A force at a point of a body, components [N] in the axes of ``frame``, by default the ground's."""

    point: Point
    components: Vector
    frame: Frame | None = None

    units = {"components": "N"}
    noun = "force"
    words = {"point": "at"}

    def check(self) -> None:
        """Refuse a force on the ground."""
        if self.point.body.is_ground:
            raise ModelError(
                f"Force '{self.name}' acts on the ground, which nothing moves: it would have no effect. Name a point "
                f"of a body."
            )

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the force."""
        yield PointForce(self.point, at.vector(self.components, self.frame))
