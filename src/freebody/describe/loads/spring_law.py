"""Springs and dampers of any law f(stretch, rate), straight between two points or along a joint.

A straight one pulls its ends together with f where stretch = d - d_0; along a joint the force is -f, stretch = y - y_0.
A law of the stretch alone, as a polynomial or a table, has the potential V = ∫ f ds.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...scalar.algebra import Scalar, divide
from ..frame import Point
from ..joints.joint import Joint
from ..part import Constant
from .action import Action, JointForce, PointForce
from .displacement import check_displacement
from .ends import check_ends
from .law import Law
from .load import Load, Look


class SpringLaw(Load, kind="spring_law"):
    """A straight spring or damper of any law between two points."""

    start: Point
    end: Point
    law: Law  # f [N], positive where the ends are pulled together
    rest: Constant = 0  # d_0 [m]

    noun = "spring"
    words = {"start": "from", "end": "to", "law": "force"}
    labels = {"rest": "rest length"}
    look = Look("spring", "zigzag")

    def check(self) -> None:
        """Refuse two ends on one body."""
        check_ends(self.start, self.end, self.title)

    @property
    def is_conservative(self) -> bool:
        """True if the law has a potential that is known."""
        return self.law.is_conservative

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the pull at both ends."""
        line = at.line(self.start, self.end)
        length = line.norm()
        rate: Scalar = 0
        if self.law.has_rate:
            rate = divide(line.dot(at.velocity(self.end) - at.velocity(self.start)), length)
        pull = at.named(divide(self.law.force(at, length - at(self.rest), rate), length) * line)
        yield PointForce(self.start, pull)
        yield PointForce(self.end, -pull)

    def potential(self, at: Any) -> Scalar:
        """Return ∫ f ds from the rest length [J]."""
        return self.law.energy(at, at.line(self.start, self.end).norm() - at(self.rest))


class JointSpringLaw(Load, kind="joint_spring_law"):
    """A spring or damper of any law along one displacement of a joint."""

    joint: Joint
    law: Law  # f [N] or [N m], positive where it resists a positive displacement
    rest: Constant = 0  # y_0 [m] or [rad]
    index: int = 0

    noun = "spring"
    words = {"index": "coordinate", "law": "force"}
    labels = {"rest": "rest length"}
    look = Look("spring", "zigzag")

    def check(self) -> None:
        """Refuse a displacement that the joint does not have."""
        check_displacement(self.joint, self.index, self.title)

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
