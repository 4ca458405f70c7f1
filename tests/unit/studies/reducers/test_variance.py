"""Variances and covariances are those of fractions; the stated errors are those that samples have."""

from __future__ import annotations

import math
import statistics
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import freebody as fb
from freebody.errors import SimulationError

FLOATS = st.floats(-1e150, 1e150)


def result(reducer: Any, **columns: Any) -> Any:
    n = len(columns["x"])
    return reducer.result(reducer.of({name: np.asarray(x) for name, x in columns.items()}, np.arange(n)))


@given(st.lists(FLOATS, min_size=2, max_size=20))
def test_the_variance_is_the_nearest_float(x: list[float]) -> None:
    data = result(fb.variance("x"), x=x)
    assert data["value"].item() == float(statistics.variance(map(Fraction, x)))


@given(st.lists(st.tuples(FLOATS, FLOATS), min_size=2, max_size=20))
def test_the_covariance_is_the_nearest_float(rows: list[tuple[float, float]]) -> None:
    x, y = zip(*rows, strict=True)
    data = result(fb.covariance("x", "y"), x=x, y=y)
    a, b = [Fraction(v) for v in x], [Fraction(v) for v in y]
    n, ma, mb = len(a), sum(a) / len(a), sum(b) / len(b)
    exact = sum((v - ma) * (w - mb) for v, w in zip(a, b, strict=True)) / (n - 1)
    assert data["value"].item() == float(exact)
    other = result(fb.covariance("y", "x"), x=x, y=y)
    assert [other[k].item() for k in ("value",)] == [data["value"].item()]


def test_a_tiny_scatter_about_a_large_number() -> None:
    """x = 10^6 + k 2^-33: the variance of 0, 1, ..., 999 is 999 * 1000 * 1001 / (12 * 999), exactly; floats lose it."""
    x = 1e6 + np.arange(1000) * 2.0**-33
    data = result(fb.variance("x"), x=x)
    assert data["value"].item() == float(Fraction(1000 * 1001, 12) / 2**66)
    assert math.isclose(result(fb.variance("x - 1e6"), x=x)["error"], data["error"], rel_tol=1e-15)


def test_the_variance_is_the_covariance_with_itself() -> None:
    x = np.random.default_rng(0).normal(size=50)
    one, two = result(fb.variance("x"), x=x), result(fb.covariance("x", "x"), x=x)
    assert [one[k].item() for k in ("value", "error")] == [two[k].item() for k in ("value", "error")]
    assert two["correlation"].item() == 1 and "correlation" not in one
    np.testing.assert_allclose(one["value"], x.var(ddof=1), rtol=1e-14)


def test_correlation() -> None:
    rng = np.random.default_rng(0)
    x, y = rng.normal(size=(2, 40))
    data = result(fb.covariance("x", "y - x"), x=x, y=y)
    np.testing.assert_allclose(data["value"], np.cov(x, y - x)[0, 1], rtol=1e-13)
    np.testing.assert_allclose(data["correlation"], np.corrcoef(x, y - x)[0, 1], rtol=1e-13)
    assert data["correlation"] < 0
    assert np.isnan(result(fb.covariance("x", "y"), x=[1.0, 2], y=[3.0, 3])["correlation"])


def test_few_lanes() -> None:
    data = result(fb.variance("x"), x=[2.0])
    assert np.isnan(data["value"]) and np.isnan(data["error"]) and data["count"] == 1
    assert result(fb.variance("x"), x=[2.0, 2.0])["error"] == 0


@pytest.mark.parametrize("name", ["normal", "exponential", "covariance"])
def test_the_error_is_the_scatter_of_samples(name: str) -> None:
    """The mean square of the stated errors is the variance of the values over many samples, to 4 times their scatter.

    The variance of a variance scatters by sqrt((kurtosis - 1)/samples); the kurtosis of the values is below 6 here.
    """
    rng = np.random.default_rng(5)
    samples, n = (300 if name == "covariance" else 1000), 100
    reducer = fb.covariance("x", "y") if name == "covariance" else fb.variance("x")
    rows = []
    for _ in range(samples):
        x = rng.exponential(size=n) if name == "exponential" else rng.normal(size=n)
        state = reducer.of({"x": x, "y": x + rng.normal(size=n)}, np.arange(n))
        variables, _ = reducer.variables(list(state.parts.values()))
        rows.append((variables["value"][1][0], variables["error"][1][0]))
    values, errors = np.array(rows).T
    # the estimate of the fourth moment has a bias of order 1/n, which is 8/n relative for an exponential distribution
    assert abs((errors**2).mean() / values.var() - 1) < 4 * math.sqrt(5 / samples) + 8 / n


def test_the_error_of_a_covariance() -> None:
    """The variance of a sample covariance (Kendall and Stuart 1977), by fractions."""
    x, y = [Fraction(v) for v in (1, 4, 2, 8, 5)], [Fraction(v) for v in (3, 1, 4, 1, -7)]
    n = len(x)
    a, b = [v - sum(x) / n for v in x], [v - sum(y) / n for v in y]
    c, sx, sy = (sum(v * w for v, w in zip(p, q, strict=True)) / (n - 1) for p, q in ((a, b), (a, a), (b, b)))
    central = sum((v * w) ** 2 for v, w in zip(a, b, strict=True)) / n
    exact = (central - Fraction(n - 2, n - 1) * c**2 + sx * sy / (n - 1)) / n
    data = result(fb.covariance("x", "y"), x=[float(v) for v in x], y=[float(v) for v in y])
    assert math.isclose(data["error"].item(), math.sqrt(exact), rel_tol=4e-16)


def test_a_variance_beyond_floats() -> None:
    with pytest.raises(
        SimulationError, match="Expected a variance or covariance below 1.8e308, got a larger one"
    ):
        result(fb.variance("x"), x=[0.0, 1e200])
