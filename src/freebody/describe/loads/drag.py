"""Drag of a fluid at a point of a body, which moves at v relative to the wind, and Stokes' moment on its turning.

F = -(c + k |v|) v,        M = -c_r w
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...errors import ModelError
from ...scalar.algebra import Expression, Vector
from ..description import Description
from ..frame import Point
from ..part import add
from .action import Action, Couple, PointForce
from .load import Load


class Drag(Load, kind="drag"):
    """Drag at a point of a body: quadratic, k = ½ ρ C_d A, and linear, Stokes' c = 6 π μ R."""

    point: Point
    quadratic: Expression = 0  # k [N s²/m²]
    linear: Expression = 0  # c [N s/m]
    turning: Expression = 0  # c_r [N m s/rad]
    wind: Vector = (0, 0, 0)  # velocity of the fluid, in ground axes [m/s]

    units = {"quadratic": "N s^2/m^2", "linear": "N s/m", "turning": "N m s", "wind": "m/s"}
    noun = "drag"
    words = {"point": "at"}

    def check(self) -> None:
        """Refuse drag on the ground, and drag without a coefficient."""
        if self.point.body.is_ground:
            raise ModelError(
                f"{self.heading} acts on the ground, which nothing moves: it would have no effect. Name a "
                f"body, or a point of one."
            )
        if self.quadratic == 0 and self.linear == 0 and self.turning == 0:
            raise ModelError(
                f"Expected a coefficient of {self.title}: quadratic= (½ ρ C_d A, in N s²/m²), linear= (6 π μ R, in "
                f"N s/m) or turning= (8 π μ R³, in N m s)."
            )

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the force against the motion through the fluid, and the moment against the turning."""
        if self.quadratic != 0 or self.linear != 0:
            v = at.velocity(self.point) - at.vector(self.wind)
            factor = at(self.linear)
            if self.quadratic != 0:
                factor = factor + at(self.quadratic) * v.norm()
            yield PointForce(self.point, -factor * v)
        if self.turning != 0:
            yield Couple(self.point.body, -at(self.turning) * at.angular_velocity(self.point.body))


def drag(
    system: Description,
    name: str,
    at: Any,
    *,
    quadratic: Expression = 0,
    linear: Expression = 0,
    turning: Expression = 0,
    wind: Any = (0, 0, 0),
) -> Load:
    """Add the drag of a fluid at a point of a body: -(c + k |v|) v, v the velocity relative to the wind.

    Parameters
    ----------
    name : str
    at : Point, or Body (its mass centre)
    quadratic : expression
        k = ½ ρ C_d A [N s²/m²].
    linear : expression
        Stokes' c, 6 π μ R of a small sphere [N s/m].
    turning : expression
        Stokes' moment per angular velocity, 8 π μ R³ of a small sphere [N m s].
    wind : three expressions
        Velocity of the fluid in ground axes [m/s].

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("falling ball")
    >>> m, g, k = s.parameters(m=1.0, g=9.81, k=0.1)
    >>> s.gravity = (0, -g, 0)
    >>> ball = s.body("ball", fb.particle(m))
    >>> guide = s.slider("guide", s.ground, ball, axis="-y", coordinate="y")
    >>> air = s.drag("air", ball, quadratic=k)
    >>> print(fb.equations(s).text())
    m*y'' - m*g = -k*y'*abs(y')
    """
    place = at.point(*at.mass_properties.center) if getattr(at, "mass_properties", None) is not None else at
    return add(system, name, Drag(place, quadratic, linear, turning, wind))
