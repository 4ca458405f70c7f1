"""Histograms count every lane once, in bins that follow from the values alone."""

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
from freebody.studies.reducers.histogram import _width

FLOATS = st.floats(allow_nan=False, allow_infinity=False)


def result(reducer: Any, x: Any) -> Any:
    return reducer.result(reducer.of({"x": np.asarray(x, dtype=float)}, np.arange(len(x))))


@given(st.lists(FLOATS, min_size=1, max_size=40), st.integers(2, 12))
def test_bins_of_powers_of_two(x: list[float], bins: int) -> None:
    """Bin j holds the values with floor(x/2^k) = j, and k is the least one; all by fractions."""
    part = fb.histogram("x", bins).part([np.array(x)], None, False)
    width = Fraction(2) ** part.k
    places = [math.floor(Fraction(v) / width) for v in x]
    assert part.first == min(places) and len(part.lanes) == max(places) - min(places) + 1 <= bins
    assert part.lanes.tolist() == [places.count(part.first + j) for j in range(len(part.lanes))]
    finer = [math.floor(2 * Fraction(v) / width) for v in x]
    greatest = max(map(abs, x))
    resolved = part.k == -1074 or (greatest > 0 and part.k <= math.frexp(greatest)[1] - 53)
    assert resolved or max(finer) - min(finer) >= bins


def test_the_width_never_falls_with_more_values() -> None:
    assert _width(0.0, 0.0, 10) == _width(0.0, 5e-324, 10) == -1074 < _width(0.0, 1e-300, 10)
    assert _width(1.0, 1.0, 10) == -52 and _width(-1.7e308, 1.7e308, 2) == 1024


def test_values_of_both_signs_need_two_bins() -> None:
    with pytest.raises(SimulationError, match="Expected at least 2 bins for a histogram without range="):
        fb.histogram("x", 1)


def test_fixed_bounds_against_numpy() -> None:
    x = np.concatenate([np.random.default_rng(0).normal(size=1000), [-1, 1, 0.5, 1.5, -2]])
    data = result(fb.histogram("x", 8, range=(-1, 1)), x)
    counts, edges = np.histogram(x, 8, range=(-1, 1))
    assert data["lanes"].values.tolist() == counts.tolist()
    assert data["left"].values.tolist() == edges[:-1].tolist() and data["right"].values[-1] == 1
    assert data["below"] == (x < -1).sum() and data["above"] == (x > 1).sum()
    p = counts / len(x)
    np.testing.assert_allclose(data["value"], p)
    np.testing.assert_allclose(data["error"], np.sqrt(p * (1 - p) / (len(x) - 1)))
    assert data["count"] == len(x) == counts.sum() + data["below"] + data["above"]


def test_groups_share_their_bins() -> None:
    reducer = fb.histogram("x", 4, by="a")
    x, a = np.array([0.0, 0.1, 3.0, 3.5]), np.array([1.0, 1, 2, 2])
    data = reducer.result(reducer.of({"x": x, "a": a}, np.arange(4)))
    assert data["left"].values.tolist() == [0, 1, 2, 3]
    assert data["lanes"].values.tolist() == [[2, 0, 0, 0], [0, 0, 0, 2]]


def test_the_largest_floats() -> None:
    x = [-np.finfo(float).max, np.finfo(float).max]
    data = result(fb.histogram("x", 2), x)
    assert data["lanes"].values.tolist() == [1, 1] and data["left"].values[1] == 0
    assert data["right"].values[-1] == np.inf  # 2^1024


@pytest.mark.parametrize("bins", [0, 65537, 2.0, True])
def test_refused_bins(bins: Any) -> None:
    with pytest.raises(SimulationError, match="to 65536 for bins= of histogram, got"):
        fb.histogram("x", bins)


@pytest.mark.parametrize("bounds", [(1, 0), (0, 0), (0, math.inf), 3, "ab", (1, 2, 3), (-1.7e308, 1.7e308)])
def test_refused_bounds(bounds: Any) -> None:
    with pytest.raises(SimulationError, match="Expected two rising numbers for range= of histogram, such as"):
        fb.histogram("x", 2, range=bounds)


def test_bins_narrower_than_floats() -> None:
    with pytest.raises(SimulationError, match="wide enough for 10 bins of floats, got .*Take fewer bins"):
        fb.histogram("x", 10, range=(1, 1 + 2.0**-50))
