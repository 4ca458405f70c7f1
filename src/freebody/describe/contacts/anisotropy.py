"""Friction with two coefficients, along a direction of the surface and across it: an ellipse in place of a disk.

    (T_1/μ_1)² + (T_2/μ_2)² <= N²,      γ ~ -(T_1/μ_1², T_2/μ_2²) in slip

A slip has the friction of the greatest power (maximum dissipation), which is not along γ. With ρ = μ_2/μ_1 the force
(T_1, T_2/ρ) and the slip (γ_1, ρ γ_2) have the same power, and obey Coulomb's law of the one coefficient μ_1.

Source: R. Michałowski, Z. Mróz, Associated and non-associated sliding rules in contact friction problems, Archives of
Mechanics 30 (1978) 259-276.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import sympy

from ...errors import ModelError, shown
from ...scalar.algebra import Expression, Scalar, Vector, cross
from ...scalar.expression import exact
from ..constants import check_default, constant
from ..description import Description
from ..shapes.data import unit_vector
from ..shapes.shape import ContactShape
from .coefficients import check_order


class Ellipse(NamedTuple):
    """Two coefficients of kinetic friction, and that of static friction along the first direction.

    One coefficient for all directions has no other one ``across``, and no direction.
    """

    friction: Scalar
    across: Scalar | None
    static: Scalar
    along: Vector | None


def ellipse(
    system: Description, friction: Any, static: Any, along: Any, surface: ContactShape, what: str
) -> Ellipse:
    """Return the law of friction with a pair of coefficients along a direction of the surface and across it.

    Raises
    ------
    ModelError
        Coefficients that vary or are not above 0, static ones in another ratio, no direction along the surface.
    """
    kinetic = _pair(system, friction, "friction", what)
    if along is None:
        raise ModelError(
            f"Expected along= for {what}, whose friction has two coefficients: the direction of the first, in axes of "
            f"the surface's body, such as along='x'."
        )
    body: Any = surface.body
    direction = unit_vector(body, along, f"the direction of friction of {what}")
    normal = getattr(surface, "normal", None)
    if normal is not None and all(exact(x) == 0 for x in cross(direction, normal)):
        raise ModelError(
            f"The direction of friction of {what}, along={shown(along)}, is the normal of its {surface.kind}. Give a "
            f"direction along the surface."
        )
    if static is None:
        return Ellipse(*kinetic, kinetic[0], direction)
    pair = _pair(system, static, "static friction", what)
    if exact(sympy.simplify(sympy.sympify(pair[0]) * kinetic[1] - sympy.sympify(pair[1]) * kinetic[0])) != 0:
        raise ModelError(
            f"Expected static_friction of {what} in the ratio of friction, {kinetic[0]} to {kinetic[1]}, got "
            f"{pair[0]} to {pair[1]}: the ellipses of both have one shape. Multiply both of friction by one factor."
        )
    check_order(system, kinetic[0], pair[0], what)
    return Ellipse(*kinetic, pair[0], direction)


def is_pair(friction: Any) -> bool:
    """Return True if a friction has several coefficients."""
    return isinstance(friction, tuple | list)


def _pair(system: Description, value: Any, kind: str, what: str) -> tuple[Scalar, Scalar]:
    """Return two coefficients above 0."""
    if not is_pair(value) or len(value) != 2:
        raise ModelError(
            f"Expected two coefficients of {kind} for {what}, along its direction and across it, got {shown(value)}."
        )
    first, second = (constant(system, x, f"the {kind} of {what}") for x in value)
    cure = " Without friction in one direction, take a small part of the other coefficient."
    for x in (first, second):
        check_default(system, x, lambda mu: mu > 0, f"two coefficients of {kind} above 0 for {what}", cure)
    return first, second


def one_coefficient(along: Expression, what: str) -> None:
    """Refuse a direction of friction that is the same in all directions."""
    if along is not None:
        raise ModelError(
            f"{what[0].upper()}{what[1:]} has a direction, along={shown(along)}, and one coefficient of friction, "
            f"which needs none. Give friction=(mu1, mu2), or leave along= out."
        )
