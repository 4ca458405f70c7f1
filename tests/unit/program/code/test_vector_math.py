"""Elementary functions of the compiler against many digits, one lane and eight."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest

from freebody.native import codegen
from freebody.program.kernels import compile_tape
from freebody.scalar.trace import Tape

EXACT = {
    "exp": mpmath.exp, "log": mpmath.log, "tan": mpmath.tan, "atan": mpmath.atan, "asin": mpmath.asin,
    "acos": mpmath.acos, "atan2": mpmath.atan2, "pow": mpmath.power, "sqrt": mpmath.sqrt,
}  # fmt: skip
INF, NAN = math.inf, math.nan
TINY, LEAST, MOST = 2.2250738585072014e-308, 5e-324, 1.7976931348623157e308

pytestmark = pytest.mark.skipif(not codegen.fused(), reason="left to the C library")


def kernel(name):
    tape = Tape()
    xs = [tape.input(f"x{i}") for i in range(2 if name in ("atan2", "pow") else 1)]
    return compile_tape(tape, {"f": [tape.apply(name, *xs)]}, None, xs, [], batch=["f"])["f"]


@pytest.fixture(autouse=True)
def no_cache(monkeypatch):
    monkeypatch.setenv("FREEBODY_CACHE", "off")


def arguments(name, n, seed):
    """Points of the whole domain, dense where the function is hardest."""
    rng = np.random.default_rng(seed)
    wide = 10.0 ** rng.uniform(-307, 307, n)
    if name == "exp":
        return [np.r_[rng.uniform(-745, 709.7, n), rng.uniform(-1, 1, n), 10.0 ** rng.uniform(-300, 0, n)]]
    if name in ("log", "sqrt"):
        return [
            np.r_[wide, rng.uniform(0.5, 2, n), 1 + 10.0 ** rng.uniform(-16, 0, n), wide[:9] * 1e-300 + LEAST]
        ]
    if name == "tan":
        multiples = rng.integers(-2000, 2000, n) * math.pi / 4
        beside = [
            6.426511099577231e173,
            -2.4985407433100564e123,
            5.828466862870158e282,
            6381956970095103 * 2.0**797,
        ]
        return [
            np.r_[rng.uniform(-10, 10, n), rng.uniform(-4e5, 4e5, n), multiples, beside, wide[wide > 5e5]]
        ]
    if name == "atan":
        return [np.r_[rng.uniform(-3, 3, n), -wide, rng.uniform(0.35, 0.45, n), rng.uniform(2.3, 2.5, n)]]
    if name in ("asin", "acos"):
        near = 1 - 10.0 ** rng.uniform(-16, 0, n)
        return [
            np.r_[
                rng.uniform(-1, 1, n),
                near,
                -near,
                rng.uniform(0.49, 0.51, n),
                10.0 ** rng.uniform(-300, 0, n),
            ]
        ]
    if name == "atan2":
        first, second = rng.normal(size=(2, 2 * n))
        return [np.r_[first, wide], np.r_[second, rng.permutation(wide)]]
    base = [10.0 ** rng.uniform(-5, 5, n), rng.uniform(0.5, 2, n), rng.uniform(0.9, 1.1, n), wide]
    power = [
        rng.uniform(-60, 60, n),
        rng.uniform(-900, 900, n),
        rng.uniform(-6000, 6000, n),
        rng.uniform(-1, 1, n),
    ]
    return [np.concatenate(base), np.concatenate(power)]


def worst(name, n, seed):
    """Largest error in units in the last place, and that one lane gives the bits of eight."""
    f = kernel(name)
    X = np.stack(arguments(name, n, seed), axis=1)
    batch = f.batch(0.0, X, ())[:, 0]
    for i in range(0, len(X), max(1, len(X) // 300)):
        assert np.array_equal(f(0.0, X[i], ())[0], batch[i], equal_nan=True)
    errors = [0.0]
    with mpmath.workprec(1300 if name == "tan" else 300):
        for row, found in zip(X, batch, strict=True):
            exact = EXACT[name](*(mpmath.mpf(float(x)) for x in row))
            value = float(exact)
            if math.isinf(value):
                assert found == value
                continue
            errors.append(float(abs(mpmath.mpf(float(found)) - exact) / math.ulp(value)))
    return max(errors)


@pytest.mark.parametrize("name", EXACT)
def test_error_is_below_two_units_in_the_last_place(name):
    assert worst(name, 250, 0) <= 2.0


def test_what_the_sum_of_an_axis_and_an_angle_loses_is_added_again():
    """Half a unit for the last addition, half for the quotient, a quarter for the small terms."""
    rng = np.random.default_rng(1)
    a = rng.uniform(math.pi / 8, math.pi, 3000) * rng.choice([-1, 1], 3000)
    X = np.stack([np.sin(a), np.cos(a)], axis=1) * 10.0 ** rng.uniform(-3, 3, (3000, 1))
    with mpmath.workprec(200):
        for (y, x), angle in zip(X, kernel("atan2").batch(0.0, X, ())[:, 0], strict=True):
            exact = mpmath.atan2(mpmath.mpf(float(y)), mpmath.mpf(float(x)))
            assert abs(mpmath.mpf(float(angle)) - exact) <= 1.25 * math.ulp(float(angle))


@pytest.mark.slow
@pytest.mark.parametrize("name", EXACT)
def test_error_on_a_dense_sweep(name):
    assert max(worst(name, 20_000, seed) for seed in (1, 2)) <= 2.0


SPECIAL = {
    "exp": [0.0, -0.0, INF, -INF, NAN, 710.0, -746.0, 1e300, -1e300, LEAST, -745.1, 709.78],
    "log": [0.0, -0.0, 1.0, INF, -INF, NAN, -1.0, LEAST, TINY, MOST, -MOST],
    "sqrt": [0.0, -0.0, INF, NAN, -1.0, LEAST, MOST],
    "atan": [0.0, -0.0, 1.0, -1.0, INF, -INF, NAN, LEAST, MOST],
    "asin": [0.0, -0.0, 1.0, -1.0, 0.5, -0.5, 1.0000000000000002, INF, -INF, NAN, LEAST],
    "acos": [0.0, -0.0, 1.0, -1.0, 0.5, -0.5, 1.0000000000000002, INF, -INF, NAN, LEAST],
    "tan": [0.0, INF, -INF, NAN, 1e300, -1e22, LEAST],
}


@pytest.mark.parametrize("name", SPECIAL)
def test_special_arguments(name):
    """As the C library has them; the other lanes of the vector are not disturbed."""
    f = kernel(name)
    with np.errstate(all="ignore"):
        expected = getattr(np, {"asin": "arcsin", "acos": "arccos", "atan": "arctan"}.get(name, name))(
            SPECIAL[name]
        )
    usual = f(0.0, [0.7], ())[0]
    for x, value in zip(SPECIAL[name], expected, strict=True):
        for found in (f(0.0, [x], ())[0], f.batch(0.0, [[0.7]] * 3 + [[x]] + [[0.7]] * 4, ())[3, 0]):
            assert found == pytest.approx(value, rel=4.5e-16, abs=0, nan_ok=True), x
            assert np.isnan(value) or np.signbit(found) == np.signbit(value), x
        lanes = f.batch(0.0, [[0.7]] * 3 + [[x]] + [[0.7]] * 4, ())[:, 0]
        assert (np.delete(lanes, 3) == usual).all()


VALUES = [0.0, -0.0, 1.0, -1.0, 0.5, -2.0, 3.0, INF, -INF, NAN, LEAST, -LEAST, MOST, -MOST, 1e-200, 1e300]


@pytest.mark.parametrize("name", ["atan2", "pow"])
def test_special_pairs(name):
    f = kernel(name)
    pairs = np.array([[x, y] for x in VALUES for y in VALUES])
    with np.errstate(all="ignore"):
        expected = {"atan2": np.arctan2, "pow": np.power}[name](pairs[:, 0], pairs[:, 1])
    one = np.array([f(0.0, pair, ())[0] for pair in pairs])
    assert np.array_equal(one, f.batch(0.0, pairs, ())[:, 0], equal_nan=True)
    for pair, found, value in zip(pairs, one, expected, strict=True):
        assert found == pytest.approx(value, rel=4.5e-16, abs=0, nan_ok=True), pair
        assert np.isnan(value) or np.signbit(found) == np.signbit(value), pair
