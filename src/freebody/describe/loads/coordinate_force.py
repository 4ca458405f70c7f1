"""A force conjugate to a coordinate."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...scalar.algebra import Expression
from ..part import Coordinate
from .action import Action, GeneralizedForce
from .load import Load


class CoordinateForce(Load, kind="generalized_force", sections=("generalized_forces",)):
    """A force on a coordinate; its power is the value times the coordinate's speed."""

    coordinate: Coordinate
    value: Expression

    noun = "generalized force"

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the force."""
        yield GeneralizedForce(self.coordinate, at(self.value))
