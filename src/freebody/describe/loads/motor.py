"""A motor on a joint: a torque that falls with the speed, behind a gear, and the inertia of its rotor.

T_m = T_s - d n y',        f = n T_m                the rotor turns at n y', n: ratio of the gear

A direct-current motor has T_s = k V/R and d = k²/R, from V = R i + k ω and T_m = k i. Its rotor adds the reflected
inertia J n² and the moments of its spin (:mod:`freebody.dynamics.armature`).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...scalar.algebra import Expression
from ..joints.joint import Joint
from ..joints.rotor import Rotor, check_single
from .action import Action, JointForce
from .displacement import check_displacement
from .load import Constant, Load, Look


class Motor(Load, kind="motor"):
    """A motor along a displacement of a joint; its stator stands in the joint's parent."""

    joint: Joint
    stall_torque: Expression  # T_s [N m]
    slope: Constant = 0  # d, fall of the torque per speed of the rotor [N m s]
    ratio: Constant = 1  # n, turns of the rotor per turn of the joint; on a slider [rad/m]
    inertia: Constant = 0  # J of the rotor [kg m²]
    index: int = 0

    noun = "motor"
    words = {"index": "coordinate"}
    look = Look("motor")

    def check(self) -> None:
        """Refuse a displacement that the joint does not have."""
        check_displacement(self.joint, self.index, self.title)
        if self.inertia != 0:
            check_single(self.title, self.joint.primitives)

    @property
    def rotors(self) -> tuple[tuple[Joint, Rotor], ...]:
        """The rotor, if it has inertia."""
        return () if self.inertia == 0 else ((self.joint, Rotor(self.inertia, self.ratio)),)

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the torque behind the gear."""
        n = at(self.ratio)
        torque = at(self.stall_torque) - at(self.slope) * n * at.rate(self.joint, self.index)
        yield JointForce(self.joint, n * torque, self.index)
