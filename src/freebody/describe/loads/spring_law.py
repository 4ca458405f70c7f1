"""Springs and dampers of any law f(stretch, rate), straight between two points or along a joint.

A straight one pulls its ends together with f where stretch = d - d_0; along a joint the force is -f, stretch = y - y_0.
A law of the stretch alone, as a polynomial or a table, has the potential V = ∫ f ds.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...scalar.algebra import FieldVector, Scalar, divide
from ..part import Constant
from .action import Action, JointForce
from .along_joint import AlongJoint
from .law import Law
from .load import Look
from .straight import Straight


class SpringLaw(Straight, kind="spring_law"):
    """A straight spring or damper of any law between two points."""

    law: Law  # f [N], positive where the ends are pulled together
    rest: Constant = 0  # d_0 [m]

    noun = "spring"
    words = {**Straight.words, "law": "force"}
    labels = {"rest": "rest length"}
    look = Look("spring", "zigzag")

    @property
    def is_conservative(self) -> bool:
        """True if the law has a potential that is known."""
        return self.law.is_conservative

    def _density(self, at: Any, line: FieldVector, length: Scalar) -> Scalar:
        rate = self._rate(at, line, length) if self.law.has_rate else 0
        return divide(self.law.force(at, length - at(self.rest), rate), length)

    def potential(self, at: Any) -> Scalar:
        """Return ∫ f ds from the rest length [J]."""
        return self.law.energy(at, at.line(self.start, self.end).norm() - at(self.rest))


class JointSpringLaw(AlongJoint, kind="joint_spring_law"):
    """A spring or damper of any law along one displacement of a joint."""

    law: Law  # f [N] or [N m], positive where it resists a positive displacement
    rest: Constant = 0  # y_0 [m] or [rad]
    index: int = 0

    noun = "spring"
    words = {**AlongJoint.words, "law": "force"}
    labels = {"rest": "rest length"}
    look = Look("spring", "zigzag")

    @property
    def is_conservative(self) -> bool:
        """True if the law has a potential that is known."""
        return self.law.is_conservative

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the force along the joint."""
        stretch = at.displacement(self.joint, self.index) - at(self.rest)
        rate = at.rate(self.joint, self.index) if self.law.has_rate else 0
        yield JointForce(self.joint, -self.law.force(at, stretch, rate), self.index)

    def potential(self, at: Any) -> Scalar:
        """Return ∫ f dy from the rest position [J]."""
        return self.law.energy(at, at.displacement(self.joint, self.index) - at(self.rest))
