"""Bounds hold for every place in a range, and are narrow for narrow ranges."""

import math

import numpy as np
import pytest
import sympy

from freebody.motion.start.intervals import Interval, interval, intervals
from freebody.scalar.arrays import arrays, column
from freebody.scalar.expression import evaluate

x = sympy.Symbol("x", real=True)
EXPRESSIONS = [
    sympy.sin(3 * x) * x - sympy.cos(x) ** 2,
    sympy.exp(-(x**2)) / (1 + x**2),
    sympy.sqrt(2 + x) * sympy.tanh(x) + sympy.pi,
    sympy.log(1 + x**2) - sympy.atan(5 * x) + sympy.Abs(x),
    (1 + x**2) ** sympy.Rational(-3, 2) * sympy.sinh(x) + sympy.cosh(x),
    sympy.Max(x, x**3) - sympy.Min(x, sympy.Rational(1, 3)) + sympy.sign(x),
    sympy.tan(x / 2) + sympy.asin(x / 4) - sympy.acos(x / 3) + (3 + x) ** sympy.Rational(1, 3),
    x**5 - 3 * x**4 + sympy.E,
]


@pytest.mark.parametrize("expression", EXPRESSIONS, ids=str)
def test_values_are_within_the_bounds(expression):
    random = np.random.default_rng(1)
    low = random.uniform(-1.5, 1.2, 200)
    high = low + 10.0 ** random.uniform(-9, 0.3, 200)
    with np.errstate(all="ignore"):
        bounds = evaluate(expression, {x: Interval(low, high)}, intervals)
        for share in np.linspace(0, 1, 21):
            value = np.asarray(evaluate(expression, {x: column(low + share * (high - low))}, arrays))
            known = np.isfinite(value)
            assert (bounds.low[known] <= value[known]).all() and (value[known] <= bounds.high[known]).all()
    narrow = high - low < 1e-6
    assert (bounds.high - bounds.low)[narrow].max() < 1e-3


def test_waves_of_many_turns_and_divisors_around_zero():
    far = Interval(np.array([0.0, 2.0**50, 1.0]), np.array([100.0, 2.0**50 + 1, 1.5]))
    wave = intervals.apply("sin", far)
    assert list(wave.low[:2]) == [-1, -1] and list(wave.high[:2]) == [1, 1]
    assert wave.low[2] == pytest.approx(math.sin(1)) and wave.high[2] == pytest.approx(math.sin(1.5))
    with np.errstate(all="ignore"):
        over = 1 / Interval(np.array([-1.0, 2.0]), np.array([1.0, 4.0]))
        unknown = intervals.apply("atan2", interval(1), interval(2))
    assert (over.low[0], over.high[0]) == (-math.inf, math.inf)
    assert over.low[1] == pytest.approx(0.25) and over.high[1] == pytest.approx(0.5)
    assert unknown.low == -math.inf and unknown.high == math.inf
