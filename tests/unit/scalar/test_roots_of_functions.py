"""The root of a function in every field: values to round-off, and all derivatives.

x + sin(x) a/2 = b
"""

import math

import numpy as np
import pytest
import sympy

from freebody.scalar.algebra import floats
from freebody.scalar.arrays import arrays, column
from freebody.scalar.derivative import forward
from freebody.scalar.dual import DualField
from freebody.scalar.polynomial import Ring
from freebody.scalar.series import SeriesField
from freebody.scalar.substitute import Substitution
from freebody.scalar.trace import Tape

A, B = 0.8, 0.7


def solution(field, a, b, ends=(-2, 3), certain=True):
    return field.root(
        lambda x: x + field.sin(x) * a / 2 - b, lambda x: 1 + field.cos(x) * a / 2, ends, "root", certain
    )


X = solution(floats, A, B)
SLOPE = 1 + A * math.cos(X) / 2


def test_numbers():
    assert X + math.sin(X) * A / 2 == pytest.approx(B, abs=1e-16)
    values = np.linspace(-1, 2, 7)
    roots = np.asarray(solution(arrays, A, column(values)))
    assert roots == pytest.approx([solution(floats, A, b) for b in values.tolist()], abs=1e-15)


def test_a_function_without_a_root_between_the_ends():
    for b, end in ((-5.0, -2), (9.0, 3)):
        assert solution(floats, A, b, certain=False) == pytest.approx(end, abs=1e-5)
    end = 0.5
    at_end = end + math.sin(end) * A / 2
    assert solution(floats, A, at_end, (end, 3), certain=False) == pytest.approx(end, abs=1e-15)
    assert solution(floats, A, B, certain=False) == pytest.approx(X, abs=1e-15)


def test_dual_numbers_and_series():
    field = DualField(floats)
    x = solution(field, field.variable(A, 0), field.variable(B, 1))
    assert x.value == pytest.approx(X, abs=1e-15)
    assert x.slopes == pytest.approx({0: -math.sin(X) / 2 / SLOPE, 1: 1 / SLOPE})
    assert solution(field, A, B) == pytest.approx(X, abs=1e-15)
    field = SeriesField(floats, 9)
    b = field.series((B, 0.3, -0.2, 0.1))
    x = solution(field, field.series((A, 0.5)), b)
    rest = x + field.sin(x) * field.series((A, 0.5)) / 2 - b
    assert rest.c == pytest.approx([0] * 10, abs=1e-14)
    assert solution(field, A, B) == pytest.approx(X, abs=1e-15)


def test_tapes_and_their_derivatives():
    """Derivatives of a recorded root are those of the series, to the order that five steps make exact."""
    tape = Tape()
    a, b = tape.input("a"), tape.input("b")
    results = [solution(tape, a, b)]
    for _ in range(5):
        results += forward(tape, results[-1:], [b], [1])
    field = SeriesField(floats, 5)
    series = solution(field, A, field.series((B, 1)))
    expected = [math.factorial(k) * c for k, c in enumerate(series.c)]
    assert tape.evaluate(results, {"a": A, "b": B}) == pytest.approx(expected, rel=1e-12, abs=1e-12)
    twice = SeriesField(tape, 1)
    (rate,) = tape.evaluate([solution(twice, a, twice.series((b, 1))).c[1]], {"a": A, "b": B})
    assert rate == pytest.approx(1 / SLOPE)


def test_formulas():
    """The root is one symbol, whose derivatives are formulas of it."""
    ring = Ring()
    a, b = sympy.symbols("a b")
    p, q = ring.generator(a), ring.generator(b)
    x = solution(ring, p, q)
    assert solution(ring, p, q) == x and str(ring.to_sympy(x)) == "root"
    assert str(ring.to_sympy(solution(ring, p, q * 2))) == "root_"
    number = Substitution(ring, floats, {a: A, b: B})
    assert number(x * x) == pytest.approx(X**2)
    assert number(ring.derivative(x, b)) == pytest.approx(1 / SLOPE)
    assert number(ring.derivative(ring.sin(x), a)) == pytest.approx(-math.cos(X) * math.sin(X) / 2 / SLOPE)
    field = SeriesField(ring, 2)
    series = solution(field, p, field.series((q, 1)))
    expected = solution(SeriesField(floats, 2), A, SeriesField(floats, 2).series((B, 1)))
    assert [number(c) for c in series.c] == pytest.approx(list(expected.c))
    # another expression in place of a symbol makes another root, a symbol that does not matter none
    put = Substitution(ring, ring, {b: q * 2})
    assert put(x) == solution(ring, p, q * 2)
    assert Substitution(ring, ring, {sympy.Symbol("c"): 1})(x) == x
    with pytest.raises(KeyError):
        Substitution(ring, floats, {a: A})(x)
