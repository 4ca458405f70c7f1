"""Truncated series: every rule against SymPy's derivatives at a point."""

import math

import pytest
import sympy

from freebody.errors import FreebodyError
from freebody.scalar.algebra import floats
from freebody.scalar.series import SeriesField

t = sympy.Symbol("t")
X = sympy.Rational(3, 10) + t / 2 - t**2 / 3 + t**3 / 5
Y = sympy.Rational(7, 10) - t / 4 + t**2 + t**3 / 7
ORDER = 5


def derivatives(expression, order=ORDER):
    """The derivatives at t = 0, of order 0, 1, ..."""
    for _ in range(order + 1):
        yield float(expression.subs(t, 0))
        expression = expression.diff(t)


def series(expression, order=ORDER):
    field = SeriesField(floats, order)
    taylor = [x / math.factorial(k) for k, x in enumerate(derivatives(expression, order))]
    return field, field.series(taylor)


CASES = {
    "sin": sympy.sin, "cos": sympy.cos, "tan": sympy.tan, "sqrt": sympy.sqrt, "exp": sympy.exp, "log": sympy.log,
    "atan": sympy.atan, "asin": sympy.asin, "acos": sympy.acos, "sinh": sympy.sinh, "cosh": sympy.cosh,
    "tanh": sympy.tanh, "abs": sympy.Abs,
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_function_of_one_argument(name):
    field, x = series(X)
    result = field.apply(name, x)
    for k, exact in enumerate(derivatives(X if name == "abs" else CASES[name](X))):
        assert result.derivative(k) == pytest.approx(exact, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("name, exact", [("atan2", sympy.atan2(X, Y)), ("pow", X**Y)])
def test_function_of_two_arguments(name, exact):
    field, x = series(X)
    result = field.apply(name, x, series(Y)[1])
    for k, expected in enumerate(derivatives(exact)):
        assert result.derivative(k) == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize(
    "operation",
    [lambda x, y: x * y, lambda x, y: x / y, lambda x, y: 2 - x, lambda x, y: 1 / y, lambda x, y: x**3],
)
def test_arithmetic(operation):
    x, y = series(X)[1], series(Y)[1]
    result, exact = operation(x, y), operation(X, Y)
    for k in range(ORDER + 1):
        assert result.derivative(k) == pytest.approx(
            float(sympy.diff(exact, t, k).subs(t, 0)), rel=1e-12, abs=1e-13
        )


def test_unknown_function_is_named():
    field, x = series(X)
    with pytest.raises(FreebodyError, match="time derivative of 'max' is not known.*Known: .*atan2"):
        field.apply("max", x, x)


def test_series_of_series_is_a_mixed_derivative():
    inner = SeriesField(floats, 1)
    outer = SeriesField(inner, 1)
    x = outer.series([inner.series([0.3, 1.0]), 0])
    y = outer.series([0.7, 1])
    one = inner.series([2.0, 0])
    result = outer.sin(x * y) / y - one * x + (1 - x) * one
    p, q = sympy.symbols("p q")
    exact = sympy.sin(p * q) / q - 2 * p + (1 - p) * 2
    value = float(sympy.diff(exact, p, q).subs({p: 0.3, q: 0.7}))
    assert result.derivative(1).derivative(1) == pytest.approx(value, rel=1e-13)
