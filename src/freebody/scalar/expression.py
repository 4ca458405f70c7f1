"""Conversion from SymPy: an expression of the user becomes a scalar of any field."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import reduce
from operator import add, mul
from typing import Any

import sympy

from ..errors import ExpressionError
from .algebra import Expression, Field, Scalar, exact_constant
from .element import Polynomial

# SymPy's class -> name of the function in `algebra.FUNCTIONS`
_NAMES: dict[Any, str] = {
    sympy.sin: "sin", sympy.cos: "cos", sympy.tan: "tan",
    sympy.asin: "asin", sympy.acos: "acos", sympy.atan: "atan", sympy.atan2: "atan2",
    sympy.sinh: "sinh", sympy.cosh: "cosh", sympy.tanh: "tanh",
    sympy.log: "log", sympy.exp: "exp", sympy.Abs: "abs", sympy.sign: "sign",
    sympy.Min: "min", sympy.Max: "max",
}  # fmt: skip

RATIOS: dict[Any, Callable[[Any], Any]] = {
    sympy.cot: lambda x: sympy.cos(x) * sympy.sin(x) ** -1,
    sympy.sec: lambda x: sympy.cos(x) ** -1,
    sympy.csc: lambda x: sympy.sin(x) ** -1,
}
"""Functions that SymPy makes of others, such as cot(x) of tan(pi/2 - x), as ratios."""


def exact(value: Expression) -> Any:
    """A number as an exact constant, anything else as a SymPy expression.

    A float stands for the decimal it prints as: 0.1 is 1/10.

    >>> exact(0.1), exact(2), exact("x + 1/2")
    (Fraction(1, 10), 2, x + 1/2)
    """
    if isinstance(value, bool):
        raise ExpressionError(f"Expected a number or an expression, got {value!r}.")
    number = exact_constant(value)
    if number is not None:
        return number
    if isinstance(value, sympy.Basic):
        return value
    # strict: SymPy would iterate over a sequence
    expression = sympy.sympify(value, strict=not isinstance(value, str))
    number = exact_constant(expression)
    return expression if number is None else number


def evaluate(
    expression: Expression,
    lookup: Mapping[Any, Scalar] | Callable[[Any], Scalar],
    field: Field,
    memo: dict[Any, Scalar] | None = None,
) -> Scalar:
    """Value of ``expression`` in ``field``.

    Parameters
    ----------
    expression : int, Fraction, float or SymPy expression
    lookup : mapping or callable
        Symbols, functions of time and their derivatives -> scalars of the field.
    field : Field
    memo : dict, optional
        Values computed before, by expression; new ones are added.
    """
    if not isinstance(expression, sympy.Basic):
        if isinstance(expression, (int, Fraction)):
            return field.datum(expression)
        if isinstance(expression, float):
            return field.datum(exact(expression))
        expression = sympy.sympify(expression)
    memo = {} if memo is None else memo
    get = lookup.__getitem__ if isinstance(lookup, (dict, Mapping)) else lookup

    def value(e: Any) -> Any:
        if e in memo:
            return memo[e]
        if e.is_Rational or e.is_Float:
            result: Any = exact_constant(e)
        elif e is sympy.pi:
            result = field.constant("pi")
        elif e is sympy.E:
            result = field.constant("E")
        elif e.is_Add:
            result = reduce(add, map(value, e.args))
        elif e.is_Mul:
            result = reduce(mul, map(value, _with_one_exponential(e.args)))
        elif e.is_Pow:
            result = _power(e, value, field)
        elif e.func in _NAMES:
            result = field.apply(_NAMES[e.func], *map(value, e.args))
        elif e.func in RATIOS:
            result = value(RATIOS[e.func](*e.args))
        else:
            try:
                result = get(e)
            except KeyError:
                raise ExpressionError(
                    f"Expected a symbol of the system or a known function, got '{e}'. "
                    f"Known functions: {', '.join(sorted(_NAMES.values()))}, sqrt."
                ) from None
        memo[e] = result
        return result

    return value(expression)


def _with_one_exponential(factors: Sequence[Any]) -> Sequence[Any]:
    """Return factors with exp(a) exp(b) as exp(a + b): of canonical factors one may be beyond the greatest float."""
    exponents = [x.args[0] for x in factors if x.func is sympy.exp]
    if len(exponents) < 2:
        return factors
    return [*(x for x in factors if x.func is not sympy.exp), sympy.exp(sympy.Add(*exponents))]


def _power(e: Any, value: Callable[[Any], Any], field: Field) -> Any:
    base, exponent = e.args
    if base is sympy.E:
        return field.apply("exp", value(exponent))
    if exponent.is_Integer:
        n = int(exponent)
        power = _integer_power(value(base), abs(n))
        if n > 0:
            return power
        return Fraction(1) / power if isinstance(power, int) else 1 / power
    if exponent.is_Rational and exponent.q == 2:
        n = int(exponent.p)
        power = _integer_power(field.apply("sqrt", value(base)), abs(n))
        return power if n > 0 else 1 / power
    return field.apply("pow", value(base), value(exponent))


def _integer_power(x: Any, n: int) -> Any:
    if type(x) is Polynomial:
        return x**n
    if n == 1:
        return x
    half = _integer_power(x, n // 2)
    return half * half if n % 2 == 0 else half * half * x
