"""Interval arithmetic: bounds of an expression over many ranges of its variables at once.

    [a, b] + [c, d] = [a + c, b + d],     [a, b] [c, d] = [min(ac, ad, bc, bd), max(ac, ad, bc, bd)]

Bounds are rounded outward. Where an operation has no value, the bounds are infinite.

Source: Moore, Kearfott & Cloud, Introduction to Interval Analysis (2009), chapters 2 and 5.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...scalar.algebra import FUNCTIONS, Field, Scalar
from ...scalar.arrays import function_of_arrays

Array = NDArray[np.float64]

OUTWARD = 2.0**-50
"""Share of a bound by which it is moved outward: four times the error of an operation or function of NumPy."""
MANY_TURNS = 2.0**40
"""Angle beyond which sines are bounded by -1 and 1."""


class Intervals(Field):
    """The field of intervals."""

    def constant(self, value: int | Fraction | float | str) -> Scalar:
        """The number as a narrow interval."""
        if isinstance(value, str):
            value = {"pi": math.pi, "E": math.e}[value]
        return interval(value)

    def apply(self, function: str, *arguments: Scalar) -> Scalar:
        """Bounds of ``function``; those of functions without a rule are infinite."""
        return _RULES[function](*map(interval, arguments))


class Interval:
    """Ranges from ``low`` to ``high``, arrays of one shape."""

    __slots__ = ("high", "low")
    __array_ufunc__ = None

    def __init__(self, low: Any, high: Any) -> None:
        self.low, self.high = low, high

    def __add__(self, other: Any) -> Interval:
        other = interval(other)
        return _outward(self.low + other.low, self.high + other.high)

    __radd__ = __add__

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)

    def __sub__(self, other: Any) -> Interval:
        return self + (-interval(other))

    def __rsub__(self, other: Any) -> Interval:
        return interval(other) - self

    def __mul__(self, other: Any) -> Interval:
        other = interval(other)
        if other is self:  # a square
            size = _rising(np.square)(_absolute(self))
            return Interval(np.maximum(size.low, 0.0), size.high)
        products = [a * b for a in (self.low, self.high) for b in (other.low, other.high)]
        return _outward(_least(products), _greatest(products))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Interval:
        other = interval(other)
        over = (other.low > 0) | (other.high < 0)
        low = np.where(over, 1 / np.where(over, other.high, 1.0), -np.inf)
        high = np.where(over, 1 / np.where(over, other.low, 1.0), np.inf)
        return self * _outward(low, high)

    def __rtruediv__(self, other: Any) -> Interval:
        return interval(other) / self


def interval(x: Any) -> Interval:
    """Return a number as an interval that has it inside."""
    return x if isinstance(x, Interval) else _outward(float(x), float(x))


def _outward(low: Any, high: Any) -> Interval:
    """Return the interval with room for rounding; infinite where a bound is no number."""
    low, high = low - OUTWARD * np.abs(low), high + OUTWARD * np.abs(high)
    lost = np.isnan(low) | np.isnan(high)
    return Interval(np.where(lost, -np.inf, low), np.where(lost, np.inf, high))


def _least(values: list[Any]) -> Any:
    return np.minimum(np.minimum(values[0], values[1]), np.minimum(values[2], values[3]))


def _greatest(values: list[Any]) -> Any:
    return np.maximum(np.maximum(values[0], values[1]), np.maximum(values[2], values[3]))


def _rising(function: Callable[..., Any]) -> Callable[..., Interval]:
    """Return the rule of a function that rises in each argument, where it is defined."""
    return lambda *x: _outward(function(*(one.low for one in x)), function(*(one.high for one in x)))


def _absolute(x: Interval) -> Interval:
    a, b = np.abs(x.low), np.abs(x.high)
    return Interval(np.where((x.low <= 0) & (x.high >= 0), 0.0, np.minimum(a, b)), np.maximum(a, b))


def _clipped(function: Callable[[Any], Any], least: float, greatest: float) -> Callable[[Interval], Interval]:
    """Return the rule of a rising function on its domain."""
    rule = _rising(function)
    return lambda x: rule(
        Interval(
            np.where(x.high < least, np.nan, np.maximum(x.low, least)),
            np.where(x.low > greatest, np.nan, np.minimum(x.high, greatest)),
        )
    )


def _cosine(x: Interval) -> Interval:
    """Bounds at the ends, 1 if a multiple of 2π is between them, -1 if an odd multiple of π is."""
    narrow = (np.abs(x.low) < MANY_TURNS) & (np.abs(x.high) < MANY_TURNS)
    a, b = (np.where(narrow, end, 0.0) for end in (x.low, x.high))
    turns = 2 * np.pi

    def between(shift: float) -> Any:
        return ~narrow | (np.ceil((a - shift) / turns - OUTWARD) <= np.floor((b - shift) / turns + OUTWARD))

    ends = _outward(np.minimum(np.cos(a), np.cos(b)), np.maximum(np.cos(a), np.cos(b)))
    return Interval(np.where(between(np.pi), -1.0, ends.low), np.where(between(0.0), 1.0, ends.high))


def _sine(x: Interval) -> Interval:
    return _cosine(x - np.pi / 2)


def _power(x: Interval, y: Interval) -> Interval:
    return _RULES["exp"](y * _RULES["log"](x))


def _unknown(*x: Interval) -> Interval:
    everywhere = np.full(np.shape(x[0].low), np.inf)
    return Interval(-everywhere, everywhere)


_RULES: dict[str, Callable[..., Interval]] = {
    **dict.fromkeys(FUNCTIONS, _unknown),
    **{name: _rising(function_of_arrays(name)) for name in ("atan", "exp", "max", "min", "sign", "sinh", "tanh")},
    "abs": _absolute,
    "sin": _sine,
    "cos": _cosine,
    "tan": lambda x: _sine(x) / _cosine(x),
    "cosh": lambda x: _rising(np.cosh)(_absolute(x)),
    "sqrt": _clipped(np.sqrt, 0.0, np.inf),
    "log": _clipped(np.log, 0.0, np.inf),
    "asin": _clipped(np.arcsin, -1.0, 1.0),
    "acos": lambda x: -_clipped(lambda y: -np.arccos(y), -1.0, 1.0)(x),
    "pow": _power,
}  # fmt: skip

intervals = Intervals()
