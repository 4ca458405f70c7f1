"""Dry friction of a bearing: the load of a joint presses it, and bounds the force along its displacement.

    slides    |T| ≤ μ (|F_a| + |F_b|)                         F_a, F_b the forces of the joint across its axis
    turns     |T| ≤ r sin φ (|F_a| + |F_b|),  tan φ = μ       r the radius of the pin

A pin that turns in its hole touches it along a line, where friction is μ N; the reaction F = √(N² + (μ N)²) then passes
the axis at r sin φ, the radius of the circle of friction. The joint bears its load at one place, |F| alone, or at two
places a `length` apart along the axis, which also bear the moment M across it:

    F_a, F_b = F/2 ± (M × n)/length

Source: F. P. Beer, E. R. Johnston, Vector Mechanics for Engineers: Statics, section 8.6 (journal bearings).
"""

from __future__ import annotations

from typing import Any, ClassVar

import sympy

from ...errors import ModelError, shown
from ...scalar.algebra import Expression
from ...scalar.expression import exact
from ..constants import default_value
from ..part import Constant
from .joint_friction import JointFriction


class BearingFriction(JointFriction, kind="bearing_friction"):
    """Friction of a joint up to ``friction`` times its load, that of a pin of a ``radius``."""

    radius: Constant = None  # [m]
    length: Constant = None  # [m]

    loaded: ClassVar[bool] = True

    def check(self) -> None:
        """Refuse joints that share their load in a way that these data do not say, and impossible sizes."""
        super().check()
        joint, title = self.joint, self.title
        motion = joint.primitives[0]
        if len(joint.primitives) != 1 or motion.turns == motion.slides:
            raise ModelError(
                f"{self.heading} has a coefficient, which hinges and sliders have: the load of "
                f"{joint.type} '{joint.name}' bounds the friction of several displacements, or of a thread, together. "
                f"Give torque= or force=, or describe its parts as contacts, s.contact."
            )
        turns = joint.primitives[0].turns
        if turns and self.radius is None:
            raise ModelError(
                f"Expected radius= for {title}, since joint '{joint.name}' turns: the radius of its pin, on which the "
                f"load acts."
            )
        if not turns and self.radius is not None:
            raise ModelError(
                f"{self.heading} has a radius, but joint '{joint.name}' slides. Leave radius= out; length= is the "
                f"distance of two places that bear it."
            )
        for name in ("radius", "length"):
            size = getattr(self, name)
            value = None if size is None else default_value(joint.parent.system, size)
            if value is not None and not value > 0:
                raise ModelError(f"Expected {name}= above 0 m for {title}, got {shown(value)}.")

    @property
    def limits(self) -> tuple[Any, Any]:
        """The coefficients of slip and of stick: of a pin those of its whole load, sin φ with tan φ = μ."""
        kinetic, static = super().limits
        return (_sine(kinetic), _sine(static)) if self.turns else (kinetic, static)

    @property
    def arm(self) -> Expression:
        """The lever of the friction: the radius of a pin [m], 1 where it slides."""
        return self.radius if self.turns else 1


def _sine(mu: Any) -> Any:
    """Return sin φ of an angle of friction with tan φ = μ."""
    return exact(mu / sympy.sqrt(1 + sympy.sympify(mu) ** 2))
