"""The stop of a ball or free joint, and its dry friction, against turns and displacements.

The turn φ ≥ 0 of the child's joint axes from the parent's, about the unit vector n, stays below ``high``, h < π:

    g = (cos φ - cos h)/sin h,      g' = -(sin φ/sin h) n·ω,      M = -N (sin φ/sin h) n

g has the sign of h - φ, and where the stop is closed its rate is -φ' and N is the moment about n. h - φ itself has no
gradient where the axes are parallel, at φ = 0. sin φ n is half the vector of R - Rᵀ, 2 cos φ + 1 the trace of R.

Dry friction resists each component of the relative angular velocity ω in the child's joint axes by itself:

    |T_i| ≤ T_s in stick, ω_i = 0;      T_i = -T sign(ω_i) in slip

Of a free joint, it resists each component of the velocity v of the child's point as it is seen in the parent, along the
parent's joint axes: |F_i| ≤ F_s, v_i = 0, and F_i = -F sign(v_i).

Source: MuJoCo's documentation, computation, constraint model: limits of ball joints, friction loss of their degrees of
freedom.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import sympy

from ...errors import ModelError
from ...scalar.algebra import HALF, IDENTITY, FieldVector, Scalar, apply, scale
from ..constants import default_value
from ..frame import Frame
from ..joints.joint import Joint
from ..loads.action import Action, PointForce
from ..loads.torsion import against, check_turn, numbers, turned, vector_of
from ..part import Constant
from .gap import Gap
from .joint_friction import DryFriction


def is_free(joint: Joint) -> bool:
    """Return True if a joint leaves all turns and displacements free."""
    return any(motion.quaternion >= 0 and motion.slides for motion in joint.primitives)


class _Turn(Gap):
    """What stop and friction of a ball have in common."""

    joint: Joint

    on_joint: ClassVar[str] = "ball"

    def check(self) -> None:
        """Refuse a joint that does not turn freely."""
        check_turn(self)
        super().check()

    @property
    def turns(self) -> bool:
        """True: what acts are moments."""
        return True


class TurnStop(_Turn, kind="turn_stop"):
    """The stop of a ball or free joint: the angle of its turn stays below ``high``, at most π."""

    joint: Joint
    high: Constant  # [rad]

    noun = "stop"

    def check(self) -> None:
        """Refuse an angle that is no stop."""
        super().check()
        high = default_value(self.joint.parent.system, self.high)
        if high is not None and not 0 < high < float(sympy.pi):
            raise ModelError(
                f"Expected high= between 0 and π for {self.title}, the greatest angle of the turn, got {high:g} rad. "
                + (
                    "A joint that does not turn is s.weld."
                    if high <= 0
                    else "No turn is larger: leave it out."
                )
            )

    def gap(self, at: Any) -> Scalar:
        """Return (cos φ - cos h)/sin h."""
        R, high = self._turned(at), at(self.high)
        return ((R[0][0] + R[1][1] + R[2][2] - 1) * HALF - at.cos(high)) / at.sin(high)

    def normal(self, at: Any) -> Iterator[Action]:
        """Yield the moments -(sin φ/sin h) n and their opposites."""
        back = scale(-HALF / at.sin(at(self.high)), vector_of(self._turned(at)))
        axes = numbers(at, self.joint.parent_axes)
        moment = at.vector(FieldVector(at.field, apply(axes, back)), self.joint.parent)
        yield from against(self.joint, moment)

    def _turned(self, at: Any) -> Any:
        """Return R."""
        return turned(at, self.joint, numbers(at, self.joint.parent_axes))


class _AxisFriction(DryFriction):
    """What friction about the axes of a joint, and along them, have in common; an element has one ``axis``."""

    joint: Joint
    axis: int = -1

    @property
    def elements(self) -> Sequence[tuple[str, Gap]]:
        """The friction of each axis."""
        return [(letter, replace(self, axis=k)) for k, letter in enumerate("xyz")]

    def _unit(self, at: Any) -> FieldVector:
        """Return the axis, in ground axes."""
        axes, body = self._fixed
        return at.vector(FieldVector(at.field, apply(numbers(at, axes), IDENTITY[self.axis])), body)

    @property
    def _fixed(self) -> tuple[Any, Frame]:
        """The joint axes, and the body in which they are fixed."""
        return self.joint.parent_axes, self.joint.parent


class TurnFriction(_Turn, _AxisFriction, kind="turn_friction"):
    """Friction of a ball or free joint about each of the child's joint axes, up to ``friction``."""

    def tangents(self, at: Any) -> Sequence[Sequence[Action]]:
        """Return the moment about the axis."""
        return (tuple(against(self.joint, self._unit(at))),)

    def slip(self, at: Any) -> Scalar:
        """Return the component of ω."""
        joint = self.joint
        return self._unit(at).dot(at.angular_velocity(joint.child) - at.angular_velocity(joint.parent))

    @property
    def _fixed(self) -> tuple[Any, Frame]:
        return self.joint.child_axes, self.joint.child


class ShiftFriction(_AxisFriction, kind="shift_friction"):
    """Friction of a free joint along each of the parent's joint axes, up to ``friction``."""

    on_joint: ClassVar[str] = "free"

    def check(self) -> None:
        """Refuse a joint without displacements in all directions."""
        if not is_free(self.joint):
            raise ModelError(
                f"{self.heading} acts against the displacements of a free joint, but '{self.joint.name}' is a "
                f"{self.joint.type}. s.friction(name, joint, force=) resists that of a slider."
            )
        super().check()

    @property
    def turns(self) -> bool:
        """False: what acts are forces."""
        return False

    def tangents(self, at: Any) -> Sequence[Sequence[Action]]:
        """Return the force along the axis, at the child's point, and its opposite on the parent."""
        point, under = self._places(at)
        unit = self._unit(at)
        return ((PointForce(point, unit), PointForce(under, -unit)),)

    def slip(self, at: Any) -> Scalar:
        """Return the component of v."""
        point, under = self._places(at)
        return self._unit(at).dot(at.velocity(point) - at.velocity(under))

    def _places(self, at: Any) -> tuple[Any, Any]:
        """Return the child's point, and the place of the parent that is there."""
        point = self.joint.child.point(*self.joint.to)
        return point, at.spot(self.joint.parent, at.position(point))
