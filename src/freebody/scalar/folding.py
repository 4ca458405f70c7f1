"""Functions of the numbers in a tape: exact where that is easy, else in double precision."""

from __future__ import annotations

import math
from fractions import Fraction
from numbers import Integral, Rational, Real

from ..errors import ExpressionError
from .algebra import Scalar

ODD = frozenset({"sin", "tan", "asin", "atan", "sinh", "tanh"})
EVEN = frozenset({"cos", "cosh", "abs"})


def number(x: Scalar) -> Scalar:
    """The number as an int, a Fraction or a float."""
    kind = type(x)
    if kind is int:
        return x
    if kind is float:
        return x + 0.0  # -0.0 becomes 0.0, so that equal numbers are one constant
    if isinstance(x, Integral):
        return int(x)
    if isinstance(x, Rational):
        return int(x.numerator) if x.denominator == 1 else Fraction(int(x.numerator), int(x.denominator))
    if isinstance(x, Real):
        return float(x) + 0.0
    raise ExpressionError(f"Expected a real number or a scalar of the tape, got {x!r}.")


def reciprocal(c: Scalar) -> Scalar:
    """1 / c, exact unless c is a float."""
    if c == 0:
        raise ZeroDivisionError("Expected a divisor other than 0 in a recorded program.")
    return 1 / c if isinstance(c, float) else number(1 / Fraction(c))


def fold(function: str, *numbers: Scalar) -> Scalar:
    """Value of a function of numbers: exact where that is easy, else in double precision."""
    x, *rest = (number(n) for n in numbers)
    if function == "sign":
        return (x > 0) - (x < 0)
    if function == "abs":
        return abs(x)
    if function == "min" or function == "max":
        return {"min": min, "max": max}[function](x, *rest)
    if x == 0 and (function in ODD or function == "sqrt" or (function == "atan2" and rest[0] > 0)):
        return 0
    if x == 0 and function in ("cos", "cosh", "exp"):
        return 1
    if x == 1 and function in ("log", "acos"):
        return 0
    if function == "sqrt" and x > 0 and not isinstance(x, float):
        f = Fraction(x)
        p, q = math.isqrt(f.numerator), math.isqrt(f.denominator)
        if p * p == f.numerator and q * q == f.denominator:
            return number(Fraction(p, q))
    if function == "pow" and isinstance(rest[0], int) and not isinstance(x, float):
        return number(Fraction(x) ** rest[0])
    try:
        return float(getattr(math, function)(*map(float, (x, *rest))))
    except ValueError:
        raise ExpressionError(
            f"Expected arguments where {function} is real, got {function}({', '.join(map(str, numbers))})."
        ) from None
