"""Coefficients of friction and restitution: expressions of parameters; friction also of `slip` and of the state.

    T = -μ(γ) N γ/|γ|,      slip = |γ|

`slip` is a name of the law and not of the system. Such a law has Stribeck's curve, a viscous part, ice behind a line.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy

from ...errors import ExpressionError, ModelError
from ...scalar.algebra import Expression, Scalar
from ...scalar.expression import exact
from ...scalar.parser import parse
from ..constants import check_default, constant, default_value
from ..description import Description, names_of

SLIP = sympy.Symbol("slip", real=True)
"""The slip speed, by the name that an expression of friction knows it by [m/s] or [rad/s]."""


def own_law(system: Description, value: Expression, own: Sequence[Any], what: str, kind: str) -> Scalar:
    """Return a law as an expression of the system's names and of symbols of its ``own``.

    Raises
    ------
    ModelError
        Unknown names, or a name of the system's own that is one of the law.
    """
    names, title = names_of(system), f"the {kind} of {what}"
    if isinstance(value, str):
        try:
            law = exact(parse(value, {**names.atoms, **{x.name: x for x in own}}))
        except ExpressionError as error:
            raise ExpressionError(f"In {title}: {error}") from None
    elif isinstance(value, sympy.Basic):
        symbols = {x.name: x for x in own}
        law = value.xreplace({x: symbols[x.name] for x in value.free_symbols if x.name in symbols})
    else:
        law = value
    used = [x for x in own if x in getattr(law, "free_symbols", ())]
    for x in used:
        if x.name in names.kinds:
            raise ModelError(
                f"The {kind} of {what} is an expression of `{x.name}`, {MEANINGS[x.name]}, but this system has a "
                f"{names.kinds[x.name]} '{x.name}'. Give that another name."
            )
    if not used:
        return system.expression(value, title)
    system.expression(law.xreplace({x: sympy.Integer(1) for x in used}), title)  # it refuses unknown names
    return law


MEANINGS = {
    "slip": "the slip speed",
    "depth": "the depth of the contact",
    "rate": "the rate of its depth",
}
"""What the names of laws mean."""


def friction_law(system: Description, value: Expression, what: str, kind: str = "friction") -> Scalar:
    """Return a coefficient of friction as an expression of the system's names and SLIP.

    Raises
    ------
    ModelError
        A coefficient that is negative at rest, or a name `slip` of the system's own.
    """
    law = own_law(system, value, (SLIP,), what, kind)
    check_default(system, at_rest(law), lambda x: x >= 0, f"a {kind} of 0 or more for {what}")
    return law


def static_law(system: Description, value: Expression, friction: Scalar, what: str) -> Scalar:
    """Return the coefficient of static friction: as given, or that of ``friction`` at rest.

    Raises
    ------
    ModelError
        A static friction that depends on slip, or is below the kinetic friction at rest.
    """
    if value is None:
        return at_rest(friction)
    law = friction_law(system, value, what, "static friction")
    if depends_on_slip(law):
        raise ModelError(
            f"The static friction of {what} acts at rest and cannot depend on slip. Give its value, or leave it out: "
            f"it is then the friction at slip = 0."
        )
    check_order(system, at_rest(friction), law, what)
    return law


def check_order(system: Description, kinetic: Scalar, static: Scalar, what: str) -> None:
    """Raise ModelError if static friction is below kinetic friction, by their default values."""
    low, high = default_value(system, kinetic), default_value(system, static)
    if low is not None and high is not None and high < low:
        raise ModelError(
            f"The static friction of {what} is {high:g}, below its kinetic friction {low:g}. Static friction is at "
            f"least as large as kinetic friction: exchange them."
        )


def coefficient(system: Description, value: Expression, what: str) -> Scalar:
    """Return a coefficient of friction as an expression of parameters.

    Raises
    ------
    ModelError
        An expression that varies, or whose default value is negative.
    """
    expression = constant(system, value, what)
    check_default(system, expression, lambda x: not x < 0, f"a coefficient of 0 or more for {what}")
    return expression


def bounce(system: Description, value: Expression, what: str) -> Scalar:
    """Return a restitution as an expression of parameters.

    Raises
    ------
    ModelError
        An expression that varies, or whose default value is not between 0 and 1.
    """
    expression = constant(system, value, f"the restitution of {what}")
    expected = f"a restitution between 0 (no bounce) and 1 (full bounce) for {what}"
    check_default(system, expression, lambda e: 0 <= e <= 1, expected)
    return expression


def depends_on_slip(law: Any) -> bool:
    """Return True if a coefficient is an expression of SLIP."""
    return SLIP in getattr(law, "free_symbols", ())


def at_rest(law: Any) -> Any:
    """Return a coefficient of kinetic friction as slip begins."""
    return exact(law.xreplace({SLIP: sympy.Integer(0)})) if depends_on_slip(law) else law
