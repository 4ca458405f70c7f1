"""A damper along a displacement of a joint: f = -c y'."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..part import Constant
from .action import Action, JointForce
from .along_joint import AlongJoint
from .load import Look


class JointDamper(AlongJoint, kind="joint_damper", sections=("dampers",)):
    """A linear damper along one displacement of a joint."""

    damping: Constant  # c [N s/m] or [N m s/rad]
    index: int = 0

    units = {"damping": "N s/m"}
    turning_units = {"damping": "N m s/rad"}
    noun = "damper"
    look = Look("damper", "dashpot", "damping")

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the force along the joint."""
        yield JointForce(self.joint, -(at(self.damping) * at.rate(self.joint, self.index)), self.index)
