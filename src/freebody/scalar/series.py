"""Truncated power series in time over any field: exact time derivatives of the results of any algorithm.

    x(t + τ) = x_0 + x_1 τ + x_2 τ² + ...          x_k = x^(k) / k!

An algorithm that runs on series gives the derivatives of its result along a motion, without difference quotients. The
same code serves floats, polynomials and tapes.

Source: Griewank & Walther, Evaluating Derivatives (2008), §13.2 (the recurrences of table 13.2).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

from ..errors import FreebodyError
from .algebra import Field, FieldVector, Scalar, divide, is_always_zero


class SeriesField(Field):
    """The field of series of one order over a field."""

    def __init__(self, base: Field, order: int) -> None:
        self.base = base
        self.order = order
        # series of series: the coefficients of the outer series are the inner series
        self.level: int = base.level + 1 if isinstance(base, SeriesField) else 1

    def constant(self, value: int | Fraction | float | str) -> Scalar:
        """A number of the base field."""
        return self.base.constant(value)

    def datum(self, value: int | Fraction | float) -> Scalar:
        """A number of a model as the base field takes it."""
        return self.base.datum(value)

    def series(self, coefficients: Sequence[Scalar]) -> Series:
        """The series with these Taylor coefficients; missing coefficients are zero."""
        missing = self.order + 1 - len(coefficients)
        return Series(self, (*coefficients[: self.order + 1], *(0,) * missing))

    def vanishing(self, square: Scalar) -> Scalar:
        """1 where the constant term of a square is 0, else 0."""
        return self.base.vanishing(self._first(square))

    def root(
        self,
        function: Callable[[Scalar], Scalar],
        slope: Callable[[Scalar], Scalar],
        ends: tuple[Scalar, Scalar],
        name: str,
        certain: bool = True,
    ) -> Scalar:
        """The root of the constant terms, then steps of Newton's method, each of which doubles the order."""
        x = self.base.root(
            lambda x: self._first(function(x)),
            lambda x: self._first(slope(x)),
            (self._first(ends[0]), self._first(ends[1])),
            name,
            certain,
        )
        inside = 1 if certain else self.changes_sign(function, ends)
        for _ in range(self.order.bit_length()):
            change = inside * divide(function(x), slope(x))
            if self._contains(change):
                x = x - self.series((0, *change.c[1:]))
        return x

    def _first(self, x: Scalar) -> Scalar:
        """The constant term."""
        return x.c[0] if self._contains(x) else x

    def apply(self, function: str, *arguments: Scalar) -> Scalar:
        """``function`` of series and constants, by its recurrence."""
        if not any(map(self._contains, arguments)):
            return self.base.apply(function, *arguments)
        rule = _RULES.get(function)
        if rule is None:
            raise FreebodyError(
                f"The time derivative of '{function}' is not known. Known: {', '.join(sorted(_RULES))}. "
                f"Write it in terms of these."
            )
        return rule(self, *(x if self._contains(x) else self.series([x]) for x in arguments))

    def _contains(self, x: Scalar) -> bool:
        """True for a series of this level, False for its constants."""
        return isinstance(x, Series) and x.field.level == self.level


class Series:
    """A truncated series, made by :meth:`SeriesField.series`."""

    __slots__ = ("c", "field")

    def __init__(self, field: SeriesField, coefficients: tuple[Scalar, ...]) -> None:
        self.field = field
        self.c = coefficients

    def derivative(self, k: int = 1) -> Scalar:
        """The k-th time derivative, k! x_k."""
        factor = 1
        for i in range(2, k + 1):
            factor *= i
        return factor * self.c[k]

    def _level(self, other: Scalar) -> int:
        """0 if ``other`` has this level, negative if it is a constant of it, positive if its level is above."""
        return (other.field.level if isinstance(other, Series) else 0) - self.field.level

    def __add__(self, other: Scalar) -> Scalar:
        level = self._level(other)
        if level > 0:
            return other + self
        if level < 0:
            return Series(self.field, (self.c[0] + other, *self.c[1:]))
        return Series(self.field, tuple(a + b for a, b in zip(self.c, other.c, strict=True)))

    __radd__ = __add__

    def __neg__(self) -> Series:
        return Series(self.field, tuple(-a for a in self.c))

    def __sub__(self, other: Scalar) -> Scalar:
        level = self._level(other)
        if level > 0:
            return -other + self
        if level < 0:
            return Series(self.field, (self.c[0] - other, *self.c[1:]))
        return Series(self.field, tuple(a - b for a, b in zip(self.c, other.c, strict=True)))

    def __rsub__(self, other: Scalar) -> Series:
        return (-self) + other

    def __mul__(self, other: Scalar) -> Scalar:
        if type(other) is FieldVector:
            return NotImplemented
        level = self._level(other)
        if level > 0:
            return other * self
        if level < 0:
            if isinstance(other, int) and other == 0:
                return 0
            return Series(self.field, tuple(a * other for a in self.c))
        return Series(
            self.field, tuple(_convolution(self.c, other.c, k) for k in range(self.field.order + 1))
        )

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Scalar:
        level = self._level(other)
        if level > 0:
            return other.field.series([self]) / other
        if level < 0:
            return Series(self.field, tuple(divide(a, other) for a in self.c))
        quotient: list[Scalar] = []
        for k in range(self.field.order + 1):
            rest = self.c[k]
            for i in range(1, k + 1):
                rest = rest - other.c[i] * quotient[k - i]
            quotient.append(divide(rest, other.c[0]))
        return Series(self.field, tuple(quotient))

    def __rtruediv__(self, other: Scalar) -> Series:
        return self.field.series([other]) / self

    def __pow__(self, n: int) -> Scalar:
        if not isinstance(n, int):
            return self.field.apply("pow", self, n)
        if n < 0:
            return 1 / self**-n
        result: Scalar = 1
        for _ in range(n):
            result = result * self
        return result

    def __repr__(self) -> str:
        return f"Series{self.c}"


def _convolution(a: Sequence[Scalar], b: Sequence[Scalar], k: int) -> Scalar:
    total: Scalar = 0
    for i in range(k + 1):
        total = total + a[i] * b[k - i]
    return total


def _sin_cos(field: SeriesField, x: Series) -> tuple[Series, Series]:
    """k s_k = Σ i x_i c_(k-i),  k c_k = -Σ i x_i s_(k-i)."""
    s, c = [field.base.apply("sin", x.c[0])], [field.base.apply("cos", x.c[0])]
    for k in range(1, field.order + 1):
        sine: Scalar = 0
        cosine: Scalar = 0
        for i in range(1, k + 1):
            sine = sine + i * x.c[i] * c[k - i]
            cosine = cosine - i * x.c[i] * s[k - i]
        s.append(divide(sine, k))
        c.append(divide(cosine, k))
    return Series(field, tuple(s)), Series(field, tuple(c))


def _sqrt(field: SeriesField, x: Series) -> Scalar:
    """2 r_0 r_k = x_k - Σ r_i r_(k-i), 0 < i < k; 0 for a series of zeros."""
    if all(is_always_zero(c) for c in x.c):
        return 0
    r = [field.base.apply("sqrt", x.c[0])]
    for k in range(1, field.order + 1):
        rest = x.c[k]
        for i in range(1, k):
            rest = rest - r[i] * r[k - i]
        r.append(divide(rest, 2 * r[0]))
    return Series(field, tuple(r))


def _integrated(field: SeriesField, first: Scalar, rate: Scalar, x: Series) -> Series:
    """y with y_0 = first and y' = rate x', where ``rate`` is a series or a constant."""
    r = rate.c if isinstance(rate, Series) else (rate, *(0,) * field.order)
    y = [first]
    for k in range(1, field.order + 1):
        total: Scalar = 0
        for i in range(1, k + 1):
            total = total + i * x.c[i] * r[k - i]
        y.append(divide(total, k))
    return Series(field, tuple(y))


def _exp(field: SeriesField, x: Series) -> Series:
    y = [field.base.apply("exp", x.c[0])]
    for k in range(1, field.order + 1):
        total: Scalar = 0
        for i in range(1, k + 1):
            total = total + i * x.c[i] * y[k - i]
        y.append(divide(total, k))
    return Series(field, tuple(y))


def _rule(name: str, rate: Any) -> Any:
    """Rule of a function of one argument from its derivative, a function of the argument."""

    def rule(field: SeriesField, x: Series) -> Series:
        return _integrated(field, field.base.apply(name, x.c[0]), rate(field, x), x)

    return rule


def _atan2(field: SeriesField, y: Series, x: Series) -> Series:
    """d atan2(y, x) = (x dy - y dx) / (x² + y²)."""
    square = x * x + y * y
    along = _integrated(field, 0, x / square, y) - _integrated(field, 0, y / square, x)
    return Series(field, (field.base.apply("atan2", y.c[0], x.c[0]), *along.c[1:]))


def _abs(field: SeriesField, x: Series) -> Series:
    return _integrated(field, field.base.apply("abs", x.c[0]), field.base.apply("sign", x.c[0]), x)


def _pow(field: SeriesField, x: Series, y: Series) -> Series:
    """x^y = exp(y log x)."""
    power: Series = _exp(field, y * _RULES["log"](field, x))
    return power


_RULES: dict[str, Any] = {
    "sin": lambda f, x: _sin_cos(f, x)[0],
    "cos": lambda f, x: _sin_cos(f, x)[1],
    "tan": lambda f, x: _sin_cos(f, x)[0] / _sin_cos(f, x)[1],
    "sqrt": _sqrt,
    "exp": _exp,
    "log": _rule("log", lambda f, x: 1 / x),
    "atan": _rule("atan", lambda f, x: 1 / (x * x + 1)),
    "asin": _rule("asin", lambda f, x: 1 / _sqrt(f, 1 - x * x)),
    "acos": _rule("acos", lambda f, x: -1 / _sqrt(f, 1 - x * x)),
    "sinh": lambda f, x: (_exp(f, x) - _exp(f, -x)) / 2,
    "cosh": lambda f, x: (_exp(f, x) + _exp(f, -x)) / 2,
    "tanh": lambda f, x: 1 - 2 / (_exp(f, 2 * x) + 1),
    "atan2": _atan2,
    "abs": _abs,
    "sign": lambda f, x: f.base.apply("sign", x.c[0]),  # constant, but where x passes through 0
    "pow": _pow,
}


def value_at_start(x: Scalar) -> Scalar:
    """Return x_0 of a series; a scalar of another kind is constant."""
    return x.c[0] if isinstance(x, Series) else x


def derivative_at_start(x: Scalar, k: int = 1) -> Scalar:
    """Return the k-th time derivative of a series at its start, 0 of a scalar of another kind."""
    return x.derivative(k) if isinstance(x, Series) else 0
