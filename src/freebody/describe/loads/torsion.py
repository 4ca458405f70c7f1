"""A spring or damper against the turn of a ball or free joint, the same about all axes.

With the rotation vector φ of the child's joint axes from where they rest, |φ| ≤ π, and the relative angular velocity ω,

M = -k φ,    V = ½ k φ·φ            and            M = -c ω

The rate of |φ| is the component of ω along φ, so that M is the gradient of V. The law jumps where |φ| = π. Half the
angle, h, is found from R: x = 1 + tr R is 4 cos² h, the vector a of R - Rᵀ is 4 cos h sin h n, so that x² + a·a = 4 x.
The left side keeps its digits where x is small.

Source: MuJoCo's documentation, computation, passive forces: the same law for the same joints.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...errors import ModelError
from ...scalar.algebra import (
    HALF,
    IDENTITY,
    FieldVector,
    Matrix,
    Vector,
    apply,
    divide,
    dot,
    multiply,
    scale,
    transpose,
)
from ..joints.joint import Axes, Joint, turns_freely
from ..part import Constant
from .action import Action, Couple
from .load import Load


def check_turn(part: Any) -> None:
    """Refuse a part on a joint without a ball, of which all turns are."""
    if not turns_freely(part.joint):
        raise ModelError(
            f"{part.heading} acts against the turn of a ball or free joint, but '{part.joint.name}' is a "
            f"{part.joint.type}. s.bushing acts between any two bodies."
        )
    if sum(motion.turns for motion in part.joint.primitives) > 1:
        raise ModelError(
            f"{part.heading} acts against the turn of a ball, but {part.joint.title} turns about other axes beside it. "
            "Put a body between them, and give the ball a joint of its own."
        )


def turned(at: Any, joint: Joint, axes: Matrix) -> Matrix:
    """Return the rotation of the child's joint axes from ``axes`` in the parent."""
    first = multiply(at.rotation(joint.parent), axes)
    return multiply(transpose(first), multiply(at.rotation(joint.child), numbers(at, joint.child_axes)))


def vector_of(R: Matrix) -> Vector:
    """Return the vector of R - Rᵀ: 2 sin φ n of a turn φ about n."""
    return (R[2][1] - R[1][2], R[0][2] - R[2][0], R[1][0] - R[0][1])


def against(joint: Joint, moment: FieldVector) -> Iterator[Action]:
    """Yield a moment on the child and its opposite on the parent."""
    yield Couple(joint.child, moment)
    yield Couple(joint.parent, -moment)


class _Torsion(Load):
    """What springs and dampers against a turn have in common."""

    on_joint = "ball"

    joint: Joint

    def check(self) -> None:
        """Refuse a joint that does not turn freely."""
        check_turn(self)


class TorsionSpring(_Torsion, kind="torsion_spring"):
    """A linear spring along the rotation vector of a ball or free joint, free of moment at ``rest``."""

    stiffness: Constant  # k [N m/rad]
    rest: Axes = IDENTITY  # the child's joint axes in the parent's

    units = {"stiffness": "N m/rad"}

    def _axes(self, at: Any) -> Matrix:
        """Return the axes, in the parent, from which φ turns."""
        return multiply(numbers(at, self.joint.parent_axes), numbers(at, self.rest))

    def _turn(self, at: Any) -> FieldVector:
        """Return φ in these axes."""
        R = turned(at, self.joint, self._axes(at))
        x, a = 1 + R[0][0] + R[1][1] + R[2][2], vector_of(R)
        cosine = HALF * HALF * at.sqrt(x * x + dot(a, a))
        return FieldVector(at.field, scale(divide(at.field.arc_over_sine(cosine), 2 * cosine), a))

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the moments on both bodies."""
        turn = FieldVector(at.field, apply(self._axes(at), self._turn(at).components))
        yield from against(self.joint, -at(self.stiffness) * at.vector(turn, self.joint.parent))

    def potential(self, at: Any) -> Any:
        """Return ½ k φ·φ [J]."""
        turn = self._turn(at)
        return HALF * at(self.stiffness) * turn.dot(turn)


class TorsionDamper(_Torsion, kind="torsion_damper"):
    """A linear damper against the relative angular velocity of a ball or free joint."""

    damping: Constant  # c [N m s/rad]

    units = {"damping": "N m s"}

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the moments on both bodies."""
        relative = at.angular_velocity(self.joint.child) - at.angular_velocity(self.joint.parent)
        yield from against(self.joint, -at(self.damping) * relative)


def numbers(at: Any, axes: Matrix) -> Matrix:
    """Return a matrix of expressions as scalars."""
    first, second, third = ((at(x), at(y), at(z)) for x, y, z in axes)
    return (first, second, third)
