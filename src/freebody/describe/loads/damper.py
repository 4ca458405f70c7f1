"""A straight damper between two points, at the distance d = |r|: F = c (r·r'/d²) r."""

from __future__ import annotations

from typing import Any

from ...scalar.algebra import FieldVector, Scalar, divide
from ..part import Constant
from .load import Look
from .straight import Straight


class Damper(Straight, kind="damper", sections=("dampers",)):
    """A straight linear damper between two points: it resists a change of their distance."""

    damping: Constant  # c [N s/m]

    units = {"damping": "N s/m"}
    noun = "damper"
    look = Look("damper", "dashpot", "damping")

    def _density(self, at: Any, line: FieldVector, length: Scalar) -> Scalar:
        return divide(at(self.damping) * self._velocity_along(at, line), length * length)
