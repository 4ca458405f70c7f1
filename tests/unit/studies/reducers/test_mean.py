"""Means are right to the last bit; the stated errors are those that samples have."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import freebody as fb
from freebody.errors import SimulationError
from freebody.studies.reducers.intervals import DEVIATIONS


def result(reducer: Any, x: Any, weights: Any = None) -> Any:
    return reducer.result(reducer.of({"x": np.asarray(x)}, np.arange(len(x)), weights))


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=2, max_size=30))
def test_the_mean_is_the_nearest_float(x: list[float]) -> None:
    exact = [Fraction(v) for v in x]
    data = result(fb.mean("x"), x)
    n, m = len(x), sum(exact) / len(x)
    assert data["value"].item() == float(m) and data["count"].item() == n
    square = sum((v - m) ** 2 for v in exact) / (n * (n - 1))
    error = Fraction(data["error"].item())
    if error > 2.3e-308:
        assert abs(error**2 / square - 1) <= Fraction(3, 2**53)


def test_a_fraction_is_the_mean_of_ones() -> None:
    x = np.arange(10)
    data, number = result(fb.mean("x > 6"), x), result(fb.mean("(x > 6) + 0"), x)
    assert [data[k].item() for k in ("value", "error")] == [number[k].item() for k in ("value", "error")]
    assert data["value"].item() == 0.3 and math.isclose(data["error"].item(), math.sqrt(0.3 * 0.7 / 9))
    assert 0 < data["low"].item() < 0.3 < data["high"].item() < 1
    assert "low" not in number


def test_one_lane_has_no_error() -> None:
    data = result(fb.mean("x"), [3.0])
    assert data["value"].item() == 3 and np.isnan(data["error"].item())


@pytest.mark.parametrize("condition", [False, True])
def test_the_error_covers_the_true_value(condition: bool) -> None:
    """Of 2000 samples of 200 runs, 95 % ± 4 standard deviations of a binomial, and 1 % for the finite sample."""
    rng = np.random.default_rng(3)
    reducer = fb.mean("x > 0.9") if condition else fb.mean("x")
    true = 0.1 if condition else 0.5
    hits, samples = 0, 2000
    for _ in range(samples):
        state = reducer.of({"x": rng.random(200)}, np.arange(200))
        variables, _ = reducer.variables(list(state.parts.values()))
        number = {name: rows[0] for name, (_, rows, _) in variables.items()}
        if condition:
            hits += number["low"] <= true <= number["high"]
        else:
            hits += abs(number["value"] - true) <= DEVIATIONS * number["error"]
    assert abs(hits / samples - 0.95) < 4 * math.sqrt(0.95 * 0.05 / samples) + 0.01


def test_weights() -> None:
    x, w = np.array([1.0, 2.0, 4.0]), np.array([0.5, 0.0, 3.0])
    data = result(fb.mean("x"), x, w)
    y = x * w
    assert data["value"].item() == y.mean()
    assert math.isclose(data["error"].item(), y.std(ddof=1) / math.sqrt(3), rel_tol=1e-15)
    assert data["effective"].item() == w.sum() ** 2 / (w**2).sum()


def test_importance_sampling_of_a_rare_event() -> None:
    """P(X > 4) of a normal distribution is 3.17e-5: from 20,000 runs about X = 4, to 1.5 %."""
    rng = np.random.default_rng(0)
    x = rng.normal(4, 1, 20000)
    data = result(fb.mean("x > 4"), x, np.exp(8 - 4 * x))
    true = 0.5 * math.erfc(4 / math.sqrt(2))
    assert data["error"].item() < 0.015 * true
    assert abs(data["value"].item() - true) < 4 * data["error"].item()
    assert "low" not in data


def test_no_hit_with_weights_tells_nothing_of_the_error() -> None:
    data = result(fb.mean("x > 4"), [1.0, 2.0], [1.0, 1.0])
    assert data["value"].item() == 0 and np.isnan(data["error"].item())
    assert not fb.error("p", absolute=1, least=2).met({"p": data})


def test_refusals() -> None:
    with pytest.raises(SimulationError, match="Expected a number of a run for mean"):
        fb.mean("")
    with pytest.raises(fb.errors.ArgumentError, match="Expected an argument of mean, got 'weight='"):
        fb.mean("x", weight=1)  # type: ignore[call-arg]
