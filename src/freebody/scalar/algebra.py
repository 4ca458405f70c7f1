"""Operations that every algorithm may use on a number, whatever its type.

A *scalar* is an element of a field: a float, a canonical polynomial (`polynomial`), or a node
of a tape (`trace`). Plain ``int`` and ``Fraction`` are constants of every field, so
that ``0 * x`` is the exact ``0`` and a zero needs no type. Vectors are tuples of three scalars,
matrices are tuples of three rows: small, immutable, and the same for every field.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from decimal import Decimal
from fractions import Fraction
from typing import Any, TypeAlias

from ..errors import ExpressionError

Scalar: TypeAlias = Any
"""A number of any field: a float, a canonical polynomial, a node of a tape, an int or a Fraction."""
Expression: TypeAlias = Any
"""A number as a user may write it: int, float, Fraction, SymPy expression, or text that the parser reads."""
Vector: TypeAlias = tuple[Scalar, Scalar, Scalar]
"""Three components."""
Matrix: TypeAlias = tuple[Vector, Vector, Vector]
"""Three rows of three entries."""

ZERO: Vector = (0, 0, 0)
IDENTITY: Matrix = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


class Field(ABC):
    """The scalars of one computation: their constants and functions."""

    @abstractmethod
    def constant(self, value: int | Fraction | float | str) -> Scalar:
        """A number of this field; a string names an irrational one (``"pi"``, ``"E"``)."""

    def datum(self, value: int | Fraction | float) -> Scalar:
        """A number of a model as this field takes it: itself, where it is not data of a program."""
        return value

    @abstractmethod
    def apply(self, function: str, *arguments: Scalar) -> Scalar:
        """``function`` (sin, cos, tan, sqrt, exp, log, atan2, ...) of scalars of this field."""

    def sin(self, x: Scalar) -> Scalar:
        """Sine of x [rad]."""
        return self.apply("sin", x)

    def cos(self, x: Scalar) -> Scalar:
        """Cosine of x [rad]."""
        return self.apply("cos", x)

    def sqrt(self, x: Scalar) -> Scalar:
        """Square root of x."""
        return self.apply("sqrt", x)

    def unit(self, v: Vector) -> Vector:
        """v/|v|, or zeros for a zero vector, which has no direction."""
        square = dot(v, v)
        return scale(divide(1, self.sqrt(square + self.vanishing(square))), v)

    def arc_over_sine(self, cosine: Scalar) -> Scalar:
        """h / sin h of the angle h from 0 to π/2 with this cosine; it and its derivatives have values at h = 0, too.

        sin h = 8 cos(h/2) cos(h/4) cos(h/8) sin(h/8), and arcsin s = s Σ (2n)! s²ⁿ / (4ⁿ n!² (2n + 1)), where
        s² < 0.0381: what is left out is below 1e-20.
        """
        product: Scalar = 1
        square: Scalar = 0
        for _ in range(3):
            square = HALF * (1 - cosine)
            cosine = self.sqrt(HALF * (1 + cosine))
            product = product * cosine
        series: Scalar = 0
        for n in reversed(range(14)):
            series = Fraction(math.comb(2 * n, n), 4**n * (2 * n + 1)) + square * series
        return divide(series, product)

    def vanishing(self, square: Scalar) -> Scalar:
        """1 where a square is 0, else 0."""
        return 1 - self.apply("sign", square)

    def root(
        self,
        function: Callable[[Scalar], Scalar],
        slope: Callable[[Scalar], Scalar],
        ends: tuple[Scalar, Scalar],
        name: str,
        certain: bool = True,
    ) -> Scalar:
        """The root of a function that increases from one end to the other, or where it has none, the end nearest to it.

        Bisections bring it within 1e-6 of the range, Newton's method to round-off. Each of its steps doubles the order
        up to which derivatives are exact, in series and in what is made of a tape.

        Parameters
        ----------
        function, slope : callable
            The function and its derivative.
        ends : tuple of scalars
        name : str
            Name of its symbol in formulas.
        certain : bool
            True if there is a root between the ends.
        """
        x, radius = HALF * (ends[0] + ends[1]), HALF * (ends[1] - ends[0])
        for _ in range(BISECTIONS):
            radius = HALF * radius
            x = x - self.apply("sign", function(x)) * radius
        inside = 1 if certain else self.changes_sign(function, ends)
        for _ in range(NEWTON):
            x = x - inside * divide(function(x), slope(x))
        return x

    def changes_sign(self, function: Callable[[Scalar], Scalar], ends: tuple[Scalar, Scalar]) -> Scalar:
        """1 if an increasing function has a root between two ends, or at one of them; else 0."""
        low, high = (self.apply("sign", function(end)) for end in ends)
        return (1 - HALF * low * (low + 1)) * (1 - HALF * high * (high - 1))


BISECTIONS, NEWTON = 20, 5
"""Numbers of steps of :meth:`Field.root`."""

FUNCTIONS = (
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh",
    "sqrt", "exp", "log", "abs", "sign", "pow", "min", "max",
)  # fmt: skip


class Floats(Field):
    """The field of Python floats."""

    _math = {
        **{name: getattr(math, name) for name in FUNCTIONS if hasattr(math, name)},
        "abs": abs,
        "sign": lambda x: (x > 0) - (x < 0),
        "min": min,
        "max": max,
    }

    def constant(self, value: int | Fraction | float | str) -> float:
        """The number as a float."""
        if isinstance(value, str):
            return {"pi": math.pi, "E": math.e}[value]
        return float(value)

    def apply(self, function: str, *arguments: Scalar) -> Scalar:
        """``function`` of floats; the exact 0 where sin, tan or sqrt of 0 is asked for."""
        if all(argument == 0 for argument in arguments) and function in ("sin", "tan", "sqrt"):
            return 0
        return self._math[function](*arguments)


floats = Floats()


HALF = Fraction(1, 2)


def divide(a: Scalar, b: Scalar) -> Scalar:
    """a / b, exact when both are int or Fraction (Python's quotient of two ints is a float)."""
    if isinstance(b, int):
        b = Fraction(b)
    return a / b


def is_always_zero(x: Scalar) -> bool:
    """Return True for a result of a trace that is zero whatever its inputs, also if numbers of the model are floats.

    In an algorithm on floats, 0.0 is a value.
    """
    return isinstance(x, int | float | Fraction) and x == 0


def exact_constant(value: Expression) -> int | Fraction | None:
    """Exact value of an int, Fraction, float, NumPy number or SymPy number; None for anything else.

    A float stands for the decimal it prints as: 0.1 is 1/10.
    """
    if isinstance(value, int):
        return value
    # a float before a Fraction, whose abstract class takes longer to ask
    if isinstance(value, float) or type(value).__module__ == "numpy":
        value = float(value)
        if not math.isfinite(value):
            raise ExpressionError(f"Expected a finite number, got {value!r}.")
        value = Fraction(*Decimal(repr(value)).as_integer_ratio())
    if isinstance(value, Fraction):
        return value.numerator if value.denominator == 1 else value
    if getattr(value, "is_Rational", False):
        return exact_constant(Fraction(int(value.p), int(value.q)))
    if getattr(value, "is_Float", False):
        return exact_constant(Fraction(str(value)))
    return None


def dot(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    """a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """a × b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def add(a: Vector, b: Vector) -> Vector:
    """a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def subtract(a: Vector, b: Vector) -> Vector:
    """a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def negate(a: Vector) -> Vector:
    """-a."""
    return (-a[0], -a[1], -a[2])


def scale(s: Scalar, a: Vector) -> Vector:
    """s a."""
    return (s * a[0], s * a[1], s * a[2])


def outer(a: Vector, b: Vector) -> Matrix:
    """a bᵀ."""
    return (scale(a[0], b), scale(a[1], b), scale(a[2], b))


def skew(a: Vector) -> Matrix:
    """The matrix of ``a ×``."""
    return ((0, -a[2], a[1]), (a[2], 0, -a[0]), (-a[1], a[0], 0))


def transpose(A: Matrix) -> Matrix:
    """Aᵀ."""
    return (
        (A[0][0], A[1][0], A[2][0]),
        (A[0][1], A[1][1], A[2][1]),
        (A[0][2], A[1][2], A[2][2]),
    )


def apply(A: Matrix, b: Vector) -> Vector:
    """A b."""
    return (dot(A[0], b), dot(A[1], b), dot(A[2], b))


def apply_transpose(A: Matrix, b: Vector) -> Vector:
    """Aᵀ b."""
    return (
        A[0][0] * b[0] + A[1][0] * b[1] + A[2][0] * b[2],
        A[0][1] * b[0] + A[1][1] * b[1] + A[2][1] * b[2],
        A[0][2] * b[0] + A[1][2] * b[1] + A[2][2] * b[2],
    )


def multiply(A: Matrix, B: Matrix) -> Matrix:
    """A B."""
    T = transpose(B)
    return (
        (dot(A[0], T[0]), dot(A[0], T[1]), dot(A[0], T[2])),
        (dot(A[1], T[0]), dot(A[1], T[1]), dot(A[1], T[2])),
        (dot(A[2], T[0]), dot(A[2], T[1]), dot(A[2], T[2])),
    )


def add_matrices(A: Matrix, B: Matrix) -> Matrix:
    """A + B."""
    return (add(A[0], B[0]), add(A[1], B[1]), add(A[2], B[2]))


def subtract_matrices(A: Matrix, B: Matrix) -> Matrix:
    """A - B."""
    return (subtract(A[0], B[0]), subtract(A[1], B[1]), subtract(A[2], B[2]))


def congruence(R: Matrix, A: Matrix) -> Matrix:
    """R A Rᵀ for a symmetric A; six entries are computed and three mirrored."""
    B = multiply(R, A)
    xx, xy, xz = dot(B[0], R[0]), dot(B[0], R[1]), dot(B[0], R[2])
    yy, yz, zz = dot(B[1], R[1]), dot(B[1], R[2]), dot(B[2], R[2])
    return ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))


class FieldVector:
    """Three components with the operators of a vector, in which users write the physics of a load.

    ``v + w``, ``v - w``, ``-v``, ``s * v``, ``v / s``, ``v.dot(w)``, ``v.cross(w)``, ``v.norm()``; the other operand
    may be a tuple of three components.

    Examples
    --------
    >>> v = FieldVector(floats, (3.0, 4.0, 0.0))
    >>> v.norm(), tuple(2 * v - (1, 0, 0)), v.x
    (5.0, (5.0, 8.0, 0.0), 3.0)
    """

    __slots__ = ("components", "field")
    __array_ufunc__ = None  # NumPy numbers leave the product to this class

    def __init__(self, field: Field, components: Vector) -> None:
        self.field = field
        self.components = components

    @property
    def x(self) -> Scalar:
        """First component."""
        return self.components[0]

    @property
    def y(self) -> Scalar:
        """Second component."""
        return self.components[1]

    @property
    def z(self) -> Scalar:
        """Third component."""
        return self.components[2]

    def norm(self) -> Scalar:
        """|v|."""
        return self.field.sqrt(dot(self.components, self.components))

    def dot(self, other: Any) -> Scalar:
        """v · w."""
        return dot(self.components, three(other))

    def cross(self, other: Any) -> FieldVector:
        """v × w."""
        return FieldVector(self.field, cross(self.components, three(other)))

    def __add__(self, other: Any) -> FieldVector:
        return FieldVector(self.field, add(self.components, three(other)))

    __radd__ = __add__

    def __sub__(self, other: Any) -> FieldVector:
        return FieldVector(self.field, subtract(self.components, three(other)))

    def __rsub__(self, other: Any) -> FieldVector:
        return FieldVector(self.field, subtract(three(other), self.components))

    def __neg__(self) -> FieldVector:
        return FieldVector(self.field, negate(self.components))

    def __mul__(self, factor: Scalar) -> FieldVector:
        if isinstance(factor, FieldVector | Sequence):
            raise TypeError("Expected a number times a vector; two vectors have v.dot(w) and v.cross(w).")
        return FieldVector(self.field, scale(factor, self.components))

    __rmul__ = __mul__

    def __truediv__(self, divisor: Scalar) -> FieldVector:
        x, y, z = self.components
        return FieldVector(self.field, (divide(x, divisor), divide(y, divisor), divide(z, divisor)))

    def __iter__(self) -> Iterator[Scalar]:
        return iter(self.components)

    def __getitem__(self, i: int) -> Scalar:
        return self.components[i]

    def __len__(self) -> int:
        return 3

    def __repr__(self) -> str:
        return f"FieldVector{self.components}"


def three(components: Any) -> Vector:
    """Three components of a vector, a tuple or a list.

    Raises
    ------
    TypeError
        Anything else.
    """
    if isinstance(components, str) or not hasattr(components, "__len__") or len(components) != 3:
        raise TypeError(f"Expected a vector of three components, got {components!r}.")
    x, y, z = components
    return (x, y, z)
