"""Sine and cosine of the compiler against 50-digit values."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest

from freebody.native import codegen
from freebody.program.kernels import compile_tape
from freebody.scalar.trace import Tape

LANES = {"one": 1, "two": 2, "four": 3, "eight": 8}  # 3 arguments take 4 lanes


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FREEBODY_CACHE", "off")
        return _compiled()


def _compiled():
    tape = Tape()
    xs = [tape.input(f"x{i}") for i in range(8)]
    functions = {
        name: [f(x) for x in xs[:count] for f in (tape.sin, tape.cos)] for name, count in LANES.items()
    }
    return compile_tape(tape, functions, None, xs, [], batch=["one"])


def sweep():
    random = np.random.default_rng(1)
    near = np.arange(-600, 600) * math.pi / 2
    large = random.integers(1, 318000, 800) * math.pi / 2  # nearest doubles to multiples of π/2
    x = np.concatenate([
        np.linspace(-10, 10, 2001), near, np.nextafter(near, 9e9), np.nextafter(near, -9e9), large,
        large + math.pi / 4, random.uniform(-5e5, 5e5, 1000), 10.0 ** random.uniform(-300, -1, 300),
        [0.0, 5e-324, -1e-310, 2.3e-308, math.pi / 4, -math.pi / 4, 5e5, -5e5],
    ])  # fmt: skip
    return x[: len(x) // 8 * 8]


def test_error_is_below_one_unit_in_the_last_place(compiled):
    x = sweep()
    worst = 0.0
    with mpmath.workprec(300):
        for v in x:
            found = compiled["one"](0.0, np.r_[v, np.zeros(7)], ())
            for value, exact in zip(
                found, (mpmath.sin(mpmath.mpf(v)), mpmath.cos(mpmath.mpf(v))), strict=True
            ):
                worst = max(worst, float(abs(mpmath.mpf(float(value)) - exact) / math.ulp(float(exact))))
    assert worst < 1.0


@pytest.mark.parametrize("name", ["two", "four", "eight"])
def test_every_width_gives_the_same_bits(compiled, name):
    x = sweep()[: 3 * 800].reshape(-1, LANES[name]) if LANES[name] == 3 else sweep().reshape(-1, LANES[name])
    rows = np.zeros((len(x), 8))
    rows[:, : x.shape[1]] = x
    wide = np.stack([compiled[name](0.0, row, ()) for row in rows]).reshape(-1, 2)
    one = np.stack([compiled["one"](0.0, np.r_[v, np.zeros(7)], ()) for v in x.ravel()])
    assert np.array_equal(wide, one)


def test_batch_gives_the_same_bits(compiled):
    x = sweep()
    rows = np.zeros((len(x), 8))
    rows[:, 0] = x
    one = np.stack([compiled["one"](0.0, row, ()) for row in rows])
    assert np.array_equal(compiled["one"].batch(0.0, rows, ()), one)


@pytest.mark.parametrize("v", [5.1e5, -1e6, 1e22, -1e300, 1.7976931348623157e308])
@pytest.mark.parametrize("name", LANES)
def test_huge_arguments_in_one_lane(compiled, name, v):
    row = np.zeros(8)
    row[LANES[name] - 1] = v
    found = compiled[name](0.0, row, ())[-2:]
    with mpmath.workprec(1200):
        exact = [mpmath.sin(mpmath.mpf(v)), mpmath.cos(mpmath.mpf(v))]
        for value, e in zip(found, exact, strict=True):
            assert abs(mpmath.mpf(float(value)) - e) < math.ulp(float(e))


def nearest_to_zeros():
    """Doubles M 2^E near multiples of π/2: M the denominators of the continued fraction of 2^E 2/π."""
    found = [6381956970095103 * 2.0**797]  # the nearest of all
    with mpmath.workprec(1400):
        for power in range(0, 971, 19):
            x, before, q = mpmath.mpf(2) ** power * 2 / mpmath.pi, 1, 0
            while q < 2**53:
                found += [q * 2.0**power] if q > 2**45 else []
                whole = int(mpmath.floor(x))
                before, q = q, whole * q + before
                x = 1 / (x - whole)
    return np.array([v for v in found if 5e5 < v < math.inf])


def test_huge_arguments_next_to_zeros(compiled):
    x = nearest_to_zeros()
    assert len(x) > 100
    rows = np.zeros((2 * len(x), 8))
    rows[:, 0] = np.r_[x, -x]
    values = compiled["one"].batch(0.0, rows, ())
    with mpmath.workprec(1400):
        smallest = 1.0
        for v, pair in zip(rows[:, 0], values, strict=True):
            for value, function in zip(pair, (mpmath.sin, mpmath.cos), strict=True):
                exact = function(mpmath.mpf(float(v)))
                smallest = min(smallest, abs(float(exact)))
                assert abs(mpmath.mpf(float(value)) - exact) < math.ulp(float(exact)), (v, function)
    assert smallest < 1e-18


@pytest.mark.parametrize("v", [5.1e5, 1e300, math.inf, math.nan])
def test_lanes_beside_a_huge_argument_keep_their_bits(compiled, v):
    x = sweep()
    x = x[np.abs(x) < 5e5][:1600]
    rows = np.zeros((len(x), 8))
    rows[:, 0] = x
    alone = compiled["one"].batch(0.0, rows, ())
    rows[::8, 0] = v
    kept = np.arange(len(x)) % 8 != 0
    assert np.array_equal(compiled["one"].batch(0.0, rows, ())[kept], alone[kept])
    wide = np.stack([compiled["eight"](0.0, row, ()) for row in rows[:, 0].reshape(-1, 8)]).reshape(-1, 2)
    assert np.array_equal(wide[kept], alone[kept])


@pytest.mark.parametrize("v", [math.inf, -math.inf, math.nan])
@pytest.mark.parametrize("name", LANES)
def test_no_number_gives_nan_in_its_own_lane_only(compiled, name, v):
    row = np.full(8, 0.5)
    row[0] = v
    found = compiled[name](0.0, row, ())
    assert np.isnan(found[:2]).all()
    assert np.allclose(found[2:].reshape(-1, 2), [math.sin(0.5), math.cos(0.5)], rtol=1e-15)


def test_without_fused_multiply_add_the_library_answers(monkeypatch):
    monkeypatch.setenv("FREEBODY_CACHE", "off")
    monkeypatch.setattr(codegen, "fused", lambda *target: False)
    assert not codegen.fused()
    row = np.linspace(-3, 3, 8)
    found = _compiled()["eight"](0.0, row, ()).reshape(-1, 2)
    assert np.array_equal(found, [[math.sin(v), math.cos(v)] for v in row])
