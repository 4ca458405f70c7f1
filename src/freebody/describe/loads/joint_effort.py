"""The force or moment of a motor along the displacement of a joint."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...errors import ModelError
from ...scalar.algebra import Expression
from ..joints.joint import Joint
from .action import Action, JointForce
from .displacement import check_displacement
from .load import Load, Look


class JointEffort(Load, kind="joint_effort", sections=("forces", "torques")):
    """A force [N] of a motor along a slider, or its moment [N m] along a hinge or a screw, conjugate to the angle."""

    joint: Joint
    value: Expression

    units = {"value": "N"}
    turning_units = {"value": "N m"}
    look = Look("motor")

    @property
    def title(self) -> str:
        """Kind and name, as messages write them."""
        return f"{'force' if self.slides else 'torque'} '{self.name}'"

    @property
    def slides(self) -> bool:
        """True if the joint is a slider."""
        return not self.joint.primitives[0].turns

    @property
    def section(self) -> str:
        """Section of model files in which the load stands."""
        return "forces" if self.slides else "torques"

    def check(self) -> None:
        """Refuse a joint with more than one displacement."""
        check_displacement(self.joint, 0, self.title)
        if len(self.joint.primitives) != 1:
            raise ModelError(
                f"{self.title[0].upper()}{self.title[1:]} acts along a slider, a hinge or a screw, but "
                f"'{self.joint.name}' is a {self.joint.type}. Act on the body, or use s.generalized_force on one of "
                f"the joint's coordinates."
            )

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the force along the joint."""
        yield JointForce(self.joint, at(self.value))
