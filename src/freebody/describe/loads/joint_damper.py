"""A damper along a displacement of a joint: f = -c y'."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..joints.joint import Joint
from ..part import Constant
from .action import Action, JointForce
from .displacement import check_displacement
from .load import Load, Look


class JointDamper(Load, kind="joint_damper", sections=("dampers",)):
    """A linear damper along one displacement of a joint."""

    joint: Joint
    damping: Constant  # c [N s/m] or [N m s/rad]
    index: int = 0

    units = {"damping": "N s/m"}
    turning_units = {"damping": "N m s/rad"}
    noun = "damper"
    words = {"index": "coordinate"}
    look = Look("damper", "dashpot", "damping")

    def check(self) -> None:
        """Refuse a displacement that the joint does not have."""
        check_displacement(self.joint, self.index, self.title)

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the force along the joint."""
        yield JointForce(self.joint, -(at(self.damping) * at.rate(self.joint, self.index)), self.index)
