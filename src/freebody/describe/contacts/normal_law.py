"""Laws of a compliant normal force: expressions of the depth of a contact and of its rate.

    N = N(d, d'),      d = -g;      Hertz: k d^(3/2);      Hunt and Crossley: k d^n (1 + c d')

`depth` and `rate` are names of the law and not of the system. The force presses only: a contact whose law would pull
opens, as one whose depth falls to zero. So a law must press as a contact begins: it grows from N = 0 with the depth.

Sources: H. Hertz, J. reine angew. Math. 92 (1882) 156-171; K. Hunt, F. Crossley, J. Appl. Mech. 42 (1975) 440-445.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy

from ...errors import FreebodyError, ModelError
from ...scalar.algebra import Expression, Scalar
from ...scalar.expression import exact
from ..constants import default_value
from ..description import Description
from .coefficients import SLIP, own_law

DEPTH = sympy.Symbol("depth", real=True)
"""Depth of the feature in the surface, -g, by the name that a law of the normal force knows it by [m]."""
RATE = sympy.Symbol("rate", real=True)
"""Rate of that depth, -g' [m/s]."""
SHALLOW = sympy.Rational(1, 2**30)
"""A depth [m] and a rate [m/s] beside which the first term of a law is all of it."""
OWN_NAMES = {x: x.name for x in (SLIP, DEPTH, RATE)}
"""Texts of the names of laws of friction and of normal forces."""


def normal_law(system: Description, value: Expression, what: str) -> Scalar:
    """Return a normal force as an expression of the system's names, DEPTH and RATE.

    Raises
    ------
    ModelError
        A law without depth, one whose force is not zero as the contact begins or does not press then, or names of the
        system's own.
    """
    law: Any = own_law(system, value, (DEPTH, RATE), what, "normal force")
    if DEPTH not in getattr(law, "free_symbols", ()):
        raise ModelError(
            f'Expected a normal force of {what} that depends on `depth`, such as "k*depth**1.5" (Hertz) or '
            f'"k*depth**1.5*(1 + c*rate)" (Hunt and Crossley), got {value}. Leave normal= out for a rigid contact.'
        )
    number = default_value(system, exact(law.xreplace({DEPTH: sympy.Integer(0), RATE: sympy.Integer(0)})))
    if number is not None and not number == 0:
        raise ModelError(
            f"Expected a normal force of {what} that is 0 at depth = 0 and rate = 0, got {number:g} N. A constant load "
            f"is s.force."
        )
    first = [default_value(system, force) for force in first_forces(law)]
    refuse_pull([x for x in first if x is not None], law, what, ModelError)
    return law


def first_forces(law: Any) -> list[Scalar]:
    """Return the forces of a law as a contact begins: at half a small depth, at that depth, and at a small rate."""
    states = (SHALLOW / 2, 0), (SHALLOW, 0), (0, SHALLOW)
    return [exact(law.xreplace({DEPTH: sympy.S(depth), RATE: sympy.S(rate)})) for depth, rate in states]


def refuse_pull(forces: Sequence[float], law: Any, what: str, error: type[FreebodyError]) -> None:
    """Refuse a law whose `first_forces`, if they are known, do not press as a contact begins."""
    if len(forces) < 3:
        return
    half, full, damped = forces
    if not 0 < half < full:
        raise error(
            f"Expected a normal force of {what} that grows from 0 with `depth`, since it only presses, got {law}: "
            f'{full:.6g} N at depth = {float(SHALLOW):.2g} m. Write a law such as "k*depth" with k > 0.'
        )
    if not damped >= 0:
        raise error(
            f"Expected a normal force of {what} that presses as the contact closes, at rate > 0, got {law}: "
            f'{damped:.6g} N at depth = 0, rate = {float(SHALLOW):.2g} m/s. A damper has c > 0 in "k*depth + c*rate".'
        )
