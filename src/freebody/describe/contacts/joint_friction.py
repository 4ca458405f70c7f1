"""Dry friction in a joint: a force along its displacement y, whatever presses the joint.

|T| ≤ F_s in stick, y' = 0;      T = -F sign(y') in slip
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from ...scalar.algebra import Scalar
from ..joints.joint import Joint
from ..loads.action import Action, JointForce
from ..loads.displacement import check_displacement
from .gap import Gap


class DryFriction(Gap):
    """Friction that no force of the machine presses: it is closed always."""

    joint: Joint

    noun = "friction"
    held = True

    def gap(self, at: Any) -> Scalar:
        """Return 0."""
        return 0

    def normal(self, at: Any) -> Iterator[Action]:
        """Yield nothing."""
        yield from ()


class JointFriction(DryFriction, kind="joint_friction"):
    """Friction along a displacement of a joint, up to ``friction``, while it sticks up to ``static_friction``."""

    joint: Joint
    index: int = 0

    words = {"index": "coordinate"}

    def check(self) -> None:
        """Refuse a joint without such a displacement."""
        check_displacement(self.joint, self.index, self.title)
        super().check()

    def tangents(self, at: Any) -> Sequence[Sequence[Action]]:
        """Return the force along the joint."""
        return ((JointForce(self.joint, 1, self.index),),)

    def slip(self, at: Any) -> Scalar:
        """Return the rate of the displacement."""
        return at.rate(self.joint, self.index)
