"""A straight spring between two points, at the distance d = |r|:

F = k (d - d_0) r/d,        V = ½ k (d - d_0)²
"""

from __future__ import annotations

from typing import Any

from ...scalar.algebra import HALF, FieldVector, Scalar, divide
from ..part import Constant
from .load import Look
from .straight import Straight


class Spring(Straight, kind="spring", sections=("springs",)):
    """A straight linear spring between two points, free of force at the distance ``rest``."""

    stiffness: Constant  # k [N/m]
    rest: Constant = 0  # d_0 [m]

    units = {"stiffness": "N/m", "rest": "m"}
    noun = "spring"
    labels = {"rest": "rest length"}
    look = Look("spring", "zigzag", "stiffness")

    def _density(self, at: Any, line: FieldVector, length: Scalar) -> Scalar:
        return divide(at(self.stiffness) * (length - at(self.rest)), length)

    def potential(self, at: Any) -> Scalar:
        """Return ½ k (d - d_0)² [J]."""
        stretch = at.line(self.start, self.end).norm() - at(self.rest)
        return HALF * at(self.stiffness) * stretch * stretch
