"""Dual numbers over any field: scalars that carry their derivatives by several variables through an algorithm.

    x + ε·∂x,      ε_i ε_j = 0

The derivatives are exact on floats, polynomials and tapes: no difference quotient is taken. Only derivatives that are
not zero are stored, so that a variable without influence costs nothing.

Source: A. Griewank, A. Walther, Evaluating Derivatives (2008), chapter 3 (forward mode, vector version).
"""

from __future__ import annotations

import numbers
import operator
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

from .algebra import HALF, Field, FieldVector, Scalar, divide
from .series import Series


class DualField(Field):
    """The field of dual numbers over a field.

    Examples
    --------
    >>> from freebody.scalar.algebra import floats
    >>> field = DualField(floats)
    >>> x = field.variable(2.0, 0)
    >>> y = x * x * x
    >>> y.value, y.slopes
    (8.0, {0: 12.0})
    """

    def __init__(self, base: Field) -> None:
        self.base = base

    def constant(self, value: int | Fraction | float | str) -> Scalar:
        """A number of the base field."""
        return self.base.constant(value)

    def variable(self, value: Scalar, index: int) -> Dual:
        """The variable of an index, whose derivative by itself is 1."""
        return Dual(self.base, value, {index: 1})

    def dual(self, value: Scalar, slopes: Mapping[int, Scalar]) -> Scalar:
        """A scalar with derivatives by index; the value itself if all are zero."""
        return _dual(self.base, value, {i: d for i, d in slopes.items() if not _is_zero(d)})

    def vanishing(self, square: Scalar) -> Scalar:
        """1 where the value of a square is 0, else 0."""
        return self.base.vanishing(_value(square))

    def root(
        self,
        function: Callable[[Scalar], Scalar],
        slope: Callable[[Scalar], Scalar],
        ends: tuple[Scalar, Scalar],
        name: str,
        certain: bool = True,
    ) -> Scalar:
        """The root of the values, with the derivatives -∂f/f'."""
        x = self.base.root(
            lambda x: _value(function(x)),
            lambda x: _value(slope(x)),
            (_value(ends[0]), _value(ends[1])),
            name,
            certain,
        )
        inside = 1 if certain else self.changes_sign(function, ends)
        change = inside * divide(function(x), _value(slope(x)))
        return self.dual(x, {i: -d for i, d in change.slopes.items()}) if type(change) is Dual else x

    def apply(self, function: str, *arguments: Scalar) -> Scalar:
        """``function`` of dual numbers and constants, by the chain rule."""
        if not any(type(x) is Dual for x in arguments):
            return self.base.apply(function, *arguments)
        values = list(map(_value, arguments))
        value = self.base.apply(function, *values)
        if len(arguments) == 1:
            return _chain(self.base, value, [(_UNARY[function](self.base, values[0], value), arguments[0])])
        rates = _BINARY[function](self.base, *values, value, *(type(x) is Dual for x in arguments))
        return _chain(self.base, value, list(zip(rates, arguments, strict=True)))


class Dual:
    """A scalar with its derivatives, made by :class:`DualField`."""

    __slots__ = ("base", "slopes", "value")
    __array_ufunc__ = None  # NumPy numbers leave the operation to this class

    def __init__(self, base: Field, value: Scalar, slopes: dict[int, Scalar]) -> None:
        self.base = base
        self.value = value
        self.slopes = slopes

    def __add__(self, other: Scalar) -> Scalar:
        if type(other) is not Dual:
            return (
                NotImplemented if type(other) is Series else Dual(self.base, self.value + other, self.slopes)
            )
        slopes = dict(self.slopes)
        for i, d in other.slopes.items():
            if i in slopes:
                d = slopes[i] + d
                if _is_zero(d):
                    del slopes[i]
                    continue
            slopes[i] = d
        return _dual(self.base, self.value + other.value, slopes)

    __radd__ = __add__

    def __neg__(self) -> Dual:
        return Dual(self.base, -self.value, {i: -d for i, d in self.slopes.items()})

    def __sub__(self, other: Scalar) -> Scalar:
        return self + (-other)

    def __rsub__(self, other: Scalar) -> Scalar:
        return -self + other

    def __mul__(self, other: Scalar) -> Scalar:
        if type(other) is not Dual:
            if type(other) in (Series, FieldVector):
                return NotImplemented
            if _is_zero(other):
                return 0
            return Dual(self.base, self.value * other, {i: d * other for i, d in self.slopes.items()})
        return _chain(self.base, self.value * other.value, [(other.value, self), (self.value, other)])

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Scalar:
        if type(other) is Series:
            return NotImplemented
        if type(other) is not Dual:
            slopes = {i: divide(d, other) for i, d in self.slopes.items()}
            return Dual(self.base, divide(self.value, other), slopes)
        inverse = divide(1, other.value)
        value = self.value * inverse
        return _chain(self.base, value, [(inverse, self), (-(value * inverse), other)])

    def __rtruediv__(self, other: Scalar) -> Scalar:
        inverse = divide(1, self.value)
        value = other * inverse
        return _chain(self.base, value, [(-(value * inverse), self)])

    def __pow__(self, n: Scalar) -> Scalar:
        if not isinstance(n, int):
            return DualField(self.base).apply("pow", self, n)
        if n < 0:
            return 1 / self**-n
        result: Scalar = 1
        for _ in range(n):
            result = self * result
        return result

    def __repr__(self) -> str:
        return f"Dual({self.value}, {self.slopes})"


class NumericDual:
    """A dual number over floats for functions of a user: it compares by its value, and NumPy's functions take it.

    It is no float: what asks for one, such as ``math.sin`` or ``float``, would lose the derivatives, and raises
    TypeError.

    Examples
    --------
    >>> import numpy as np
    >>> from freebody.scalar.algebra import floats
    >>> x = NumericDual(DualField(floats).variable(0.0, 0))
    >>> y = np.sin(3 * x) if x < 1 else x
    >>> y.dual.slopes
    {0: 3.0}

    Raises
    ------
    ArithmeticError
        A comparison of values that are equal and whose derivatives differ: what follows is no differentiable function.
    """

    __slots__ = ("dual",)
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, dual: Dual) -> None:
        self.dual = dual

    @property
    def value(self) -> float:
        """The number without its derivatives."""
        return float(self.dual.value)

    @property
    def slopes(self) -> dict[int, Scalar]:
        """Derivatives by index."""
        return self.dual.slopes

    def __repr__(self) -> str:
        return f"{self.value:g} with derivatives"

    def __format__(self, how: str) -> str:
        return format(self.value, how)

    def __add__(self, other: Any) -> Any:
        return _made(other, lambda x: self.dual + x)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        return _made(other, lambda x: self.dual - x)

    def __rsub__(self, other: Any) -> Any:
        return _made(other, lambda x: x - self.dual)

    def __mul__(self, other: Any) -> Any:
        return _made(other, lambda x: self.dual * x)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        return _made(other, lambda x: self.dual / x)

    def __rtruediv__(self, other: Any) -> Any:
        return _made(other, lambda x: x / self.dual)

    def __pow__(self, other: Any) -> Any:
        return _made(other, self._raised)

    def __rpow__(self, other: Any) -> Any:
        return _made(other, lambda x: self._applied("pow", x, self.dual))

    def __neg__(self) -> Any:
        return NumericDual(-self.dual)

    def __pos__(self) -> Any:
        return self

    def __abs__(self) -> Any:
        return -self if self < 0 else self

    def __bool__(self) -> bool:
        return bool(self != 0)

    def __eq__(self, other: Any) -> Any:
        return self._compared(other, operator.eq)

    def __lt__(self, other: Any) -> Any:
        return self._compared(other, operator.lt)

    def __le__(self, other: Any) -> Any:
        return self._compared(other, operator.le)

    def __gt__(self, other: Any) -> Any:
        return self._compared(other, operator.gt)

    def __ge__(self, other: Any) -> Any:
        return self._compared(other, operator.ge)

    def arctan2(self, other: Any) -> Any:
        """The angle whose tangent is self/other."""
        return _made(other, lambda x: self._applied("atan2", self.dual, x))

    def __getattr__(self, name: str) -> Any:
        if name not in _OF_NUMPY:
            raise AttributeError(f"'{type(self).__name__}' object has no attribute {name!r}")
        return lambda: _number(self._applied(_OF_NUMPY[name], self.dual))

    def _raised(self, x: Any) -> Scalar:
        whole = type(x) is float and x.is_integer()
        return self.dual ** int(x) if whole else self._applied("pow", self.dual, x)

    def _applied(self, function: str, *arguments: Scalar) -> Scalar:
        return DualField(self.dual.base).apply(function, *arguments)

    def _compared(self, other: Any, relation: Callable[[Any, Any], bool]) -> Any:
        number = _plain(other)
        if number is None:
            return NotImplemented
        difference = self.dual - number
        if type(difference) is Dual and difference.value == 0:
            raise ArithmeticError(
                f"it compares {self.dual.value:g} with the same number, and a derivative decides"
            )
        return relation(_value(difference), 0)


_OF_NUMPY = {
    **{name: name for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "sqrt", "exp", "log")},
    "arcsin": "asin",
    "arccos": "acos",
    "arctan": "atan",
}
"""Functions that NumPy asks elements for, by its name."""


def _plain(x: Any) -> Any:
    """A number, or the dual number of one; None for anything else."""
    if type(x) is NumericDual:
        return x.dual
    return float(x) if isinstance(x, numbers.Real) or type(x).__module__ == "numpy" and not x.shape else None


def _made(other: Any, operation: Callable[[Any], Any]) -> Any:
    number = _plain(other)
    return NotImplemented if number is None else _number(operation(number))


def _number(x: Scalar) -> Any:
    return NumericDual(x) if type(x) is Dual else x


_DUALS = (Dual, NumericDual)


def value_of(x: Scalar) -> Scalar:
    """The scalar without its derivatives."""
    return x.value if type(x) in _DUALS else x


def slope_of(x: Scalar, index: int) -> Scalar:
    """Derivative by the variable of an index."""
    return x.slopes.get(index, 0) if type(x) in _DUALS else 0


def _value(x: Scalar) -> Scalar:
    return x.value if type(x) is Dual else x


def _is_zero(x: Scalar) -> bool:
    return type(x) is int and x == 0


def _dual(base: Field, value: Scalar, slopes: dict[int, Scalar]) -> Scalar:
    return Dual(base, value, slopes) if slopes else value


def _chain(base: Field, value: Scalar, parts: list[tuple[Scalar, Scalar]]) -> Scalar:
    """The value with the derivatives Σ rate · ∂x over the parts (rate, x)."""
    slopes: dict[int, Scalar] = {}
    for rate, x in parts:
        if type(x) is not Dual or _is_zero(rate):
            continue
        for i, d in x.slopes.items():
            d = rate * d
            if i in slopes:
                d = slopes[i] + d
                if _is_zero(d):
                    del slopes[i]
                    continue
            elif _is_zero(d):
                continue
            slopes[i] = d
    return _dual(base, value, slopes)


_UNARY: dict[str, Callable[[Field, Scalar, Scalar], Scalar]] = {
    "sin": lambda f, x, v: f.apply("cos", x),
    "cos": lambda f, x, v: -f.apply("sin", x),
    "tan": lambda f, x, v: v * v + 1,
    "asin": lambda f, x, v: divide(1, f.apply("sqrt", 1 - x * x)),
    "acos": lambda f, x, v: divide(-1, f.apply("sqrt", 1 - x * x)),
    "atan": lambda f, x, v: divide(1, x * x + 1),
    "sinh": lambda f, x, v: f.apply("cosh", x),
    "cosh": lambda f, x, v: f.apply("sinh", x),
    "tanh": lambda f, x, v: 1 - v * v,
    "sqrt": lambda f, x, v: divide(1, 2 * v),
    "exp": lambda f, x, v: v,
    "log": lambda f, x, v: divide(1, x),
    "abs": lambda f, x, v: f.apply("sign", x),
    "sign": lambda f, x, v: 0,
}


def _atan2(f: Field, y: Scalar, x: Scalar, v: Scalar, *used: bool) -> tuple[Scalar, Scalar]:
    square = x * x + y * y
    return divide(x, square), -divide(y, square)


def _pow(f: Field, x: Scalar, y: Scalar, v: Scalar, first: bool, second: bool) -> tuple[Scalar, Scalar]:
    return (y * f.apply("pow", x, y - 1) if first else 0, v * f.apply("log", x) if second else 0)


def _choice(f: Field, side: Scalar, x: Scalar, y: Scalar) -> Scalar:
    return side * HALF * f.apply("sign", x - y)


_BINARY: dict[str, Callable[..., tuple[Scalar, Scalar]]] = {
    "atan2": _atan2,
    "pow": _pow,
    # the mean of both derivatives where the operands are equal
    "max": lambda f, x, y, v, *used: (HALF + _choice(f, 1, x, y), HALF - _choice(f, 1, x, y)),
    "min": lambda f, x, y, v, *used: (HALF - _choice(f, 1, x, y), HALF + _choice(f, 1, x, y)),
}
