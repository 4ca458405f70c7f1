"""A compliant stop of a joint: a spring and a damper at the depth d by which its displacement is beyond the stop.

f = max(k d + c d', 0) where d > 0,        V = ½ k max(d, 0)²

It pushes the joint back and never pulls. The times at which it touches and leaves are located.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...errors import ModelError
from ...scalar.algebra import HALF, Scalar
from ..constants import default_value
from ..part import Constant
from .action import Action, JointForce
from .along_joint import AlongJoint
from .load import Look


class JointStop(AlongJoint, kind="joint_stop"):
    """A compliant stop along one displacement of a joint, beyond ``low`` and beyond ``high``."""

    stiffness: Constant  # k [N/m] or [N m/rad]
    low: Constant = None  # [m] or [rad]
    high: Constant = None
    damping: Constant = 0  # c [N s/m] or [N m s/rad]
    index: int = 0

    units = {"stiffness": "N/m", "low": "m", "high": "m", "damping": "N s/m"}
    turning_units = {"stiffness": "N m/rad", "low": "rad", "high": "rad", "damping": "N m s/rad"}
    noun = "stop"
    look = Look("spring", "zigzag", "stiffness")
    switches = ("touches", "leaves")

    def check(self) -> None:
        """Refuse a displacement that the joint does not have, a stop at no end, and one that pulls or drives."""
        super().check()
        if self.low is None and self.high is None:
            raise ModelError(f"{self.heading} stops nothing. Give low= or high=, or both.")
        for name in ("stiffness", "damping"):
            value = default_value(self.joint.parent.system, getattr(self, name))
            if value is not None and value < 0:
                raise ModelError(
                    f"Expected 0 or more for {name}= of {self.title}, got {value:g}. A stop pushes its joint back and "
                    "takes energy; what pulls or drives is a spring or a force."
                )

    @property
    def is_conservative(self) -> bool:
        """True if it has no damping."""
        return bool(self.damping == 0)

    def _depths(self, at: Any) -> Iterator[tuple[Scalar, int]]:
        y = at.displacement(self.joint, self.index)
        if self.low is not None:
            yield at(self.low) - y, 1
        if self.high is not None:
            yield y - at(self.high), -1

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the force along the joint, one for each end."""
        for depth, sign in self._depths(at):
            push = at(self.stiffness) * depth
            if self.damping != 0:
                push = at.max(push - sign * at(self.damping) * at.rate(self.joint, self.index), 0)
            yield JointForce(self.joint, sign * at.where(depth, push, 0), self.index)

    def potential(self, at: Any) -> Scalar:
        """Return ½ k d² beyond an end [J]."""
        total: Scalar = 0
        for depth, _ in self._depths(at):
            total = total + HALF * at(self.stiffness) * at.where(depth, depth * depth, 0)
        return total
