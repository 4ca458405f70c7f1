"""Constants of a description: numbers and expressions of parameters."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

from ..errors import ModelError
from ..scalar.algebra import Expression, Scalar
from .description import Description, parameters_of, varying


def is_number(value: Any) -> bool:
    """Return True for a plain number, False for an expression with names."""
    return isinstance(value, int | float | Fraction) or bool(getattr(value, "is_number", False))


def constant(system: Description, value: Expression, what: str) -> Scalar:
    """Return an expression of parameters.

    Raises
    ------
    ModelError
        An expression of coordinates, speeds or time.
    """
    expression = system.expression(value, what)
    moving = varying(system, expression)
    if moving:
        raise ModelError(
            f"{what[0].upper()}{what[1:]} cannot depend on {', '.join(moving)}. Use numbers and parameters."
        )
    return expression


def unchanging(system: Description, value: Expression, what: str, cure: str) -> Scalar:
    """Return an expression of parameters for data that stay as they are in a motion; refuse others with the cure."""
    expression = system.expression(value, what)
    moving = varying(system, expression)
    if moving:
        raise ModelError(
            f"{what[0].upper()}{what[1:]} must be constant, but it depends on {', '.join(moving)}. {cure}"
        )
    return expression


def default_value(system: Description, expression: Scalar) -> float | None:
    """Return the value of a constant at the default values of its parameters, or None if one has no default."""
    if is_number(expression):
        return float(expression)
    defaults = {p.symbol: p.default for p in parameters_of(system)}
    if any(defaults.get(symbol) is None for symbol in expression.free_symbols):
        return None
    return float(expression.subs({symbol: defaults[symbol] for symbol in expression.free_symbols}))


def check_default(
    system: Description, expression: Scalar, holds: Callable[[float], bool], expected: str, cure: str = ""
) -> None:
    """Refuse a constant for whose default value a condition does not hold; without a default it is not known."""
    number = default_value(system, expression)
    if number is not None and not holds(number):
        raise ModelError(f"Expected {expected}, got {number:g}.{cure}")
