"""A spring along a displacement of a joint.

f = -k (y - y_0),        V = ½ k (y - y_0)²
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...scalar.algebra import HALF, Scalar
from ..part import Constant
from .action import Action, JointForce
from .along_joint import AlongJoint
from .load import Look


class JointSpring(AlongJoint, kind="joint_spring", sections=("springs",)):
    """A linear spring along one displacement of a joint, free of force at ``rest``."""

    stiffness: Constant  # k [N/m] or [N m/rad]
    rest: Constant = 0  # y_0 [m] or [rad]
    index: int = 0

    units = {"stiffness": "N/m", "rest": "m"}
    turning_units = {"stiffness": "N m/rad", "rest": "rad"}
    noun = "spring"
    labels = {"rest": "rest length"}
    look = Look("spring", "zigzag", "stiffness")

    def _stretch(self, at: Any) -> Scalar:
        return at.displacement(self.joint, self.index) - at(self.rest)

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the force along the joint."""
        yield JointForce(self.joint, -(at(self.stiffness) * self._stretch(at)), self.index)

    def potential(self, at: Any) -> Scalar:
        """Return ½ k (y - y_0)² [J]."""
        stretch = self._stretch(at)
        return HALF * at(self.stiffness) * stretch * stretch
