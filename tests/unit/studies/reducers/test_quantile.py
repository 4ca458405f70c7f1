"""Quantiles of few lanes are exact; of many, they lie in the bucket that is stated."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import freebody as fb
from freebody.errors import SimulationError
from freebody.studies.reducers import quantile as room

FLOATS = st.floats(allow_nan=False, allow_infinity=False)


def result(reducer: Any, x: Any) -> Any:
    return reducer.result(reducer.of({"x": np.asarray(x)}, np.arange(len(x))))


@given(st.lists(FLOATS, min_size=1, max_size=40), st.floats(0, 1))
def test_of_few_lanes(x: list[float], q: float) -> None:
    data = result(fb.quantile("x", q), x)
    k = room.rank_of(q, len(x))
    value = sorted(x)[k - 1]
    assert data["value"].item() == data["lower"].item() == data["upper"].item() == value
    assert data["quantile"].item() == q


def test_of_few_lanes_against_numpy() -> None:
    x = np.random.default_rng(0).normal(size=1001)
    q = [0.0, 0.1, 0.5, 0.9, 1.0]
    np.testing.assert_array_equal(
        result(fb.quantile("x", q), x)["value"], np.quantile(x, q, method="inverted_cdf")
    )


@given(st.lists(FLOATS, min_size=17, max_size=80, unique=True), st.floats(0, 1))
def test_the_bucket_holds_the_quantile(x: list[float], q: float) -> None:
    data = result(fb.quantile("x", q, buckets=16), x)
    value = sorted(x)[room.rank_of(q, len(x)) - 1]
    assert data["lower"].item() <= value <= data["upper"].item()
    assert data["lower"].item() <= data["value"].item() <= data["upper"].item()
    assert data["low"].item() <= value <= data["high"].item()


@pytest.mark.parametrize("n", [*range(14, 34), 100, 1000])
@pytest.mark.parametrize("buckets", [16, 17, 20])
def test_the_number_of_bits_is_the_greatest(n: int, buckets: int) -> None:
    """One bit more would give more buckets than there may be; all lanes are counted."""
    x = np.linspace(-1.0, 3.0, n)
    part = fb.quantile("x", 0.5, buckets=buckets).part([x], None, False)
    bits = x + 0.0
    keys = {
        int(k)
        for k in np.where(bits.view(np.int64) < 0, ~bits.view(np.uint64), bits.view(np.uint64) | 1 << 63)
    }
    assert len({k >> 64 - part.bits for k in keys}) == len(part.beginnings) <= buckets
    assert part.bits == 64 or len({k >> 63 - part.bits for k in keys}) > buckets
    assert part.count == len(x) and (np.diff(part.beginnings.astype(object)) > 0).all()


def test_the_width_of_a_bucket_of_many_lanes() -> None:
    """Within a factor 2^k the buckets are narrower than 2^(1 + log2 k)/4096, and a tiny scatter is resolved as well."""
    rng = np.random.default_rng(0)
    for x, scale in ((1 + rng.random(10**5), 2 / 4096), (1e6 + 1e-3 * rng.random(10**5), 2e-9 / 4096)):
        data = result(fb.quantile("x", 0.5), x)
        exact = np.quantile(x, 0.5, method="inverted_cdf")
        width = (data["upper"] - data["lower"]).item()
        assert width <= scale * exact
        assert abs(data["value"].item() - exact) < width
        assert data["low"].item() <= exact <= data["high"].item()


@pytest.mark.parametrize("q", [0.1, 0.5])
def test_the_interval_covers_the_true_quantile(q: float) -> None:
    """At least 95 % of 1000 samples, less 4 standard deviations; no more than 99 %, since 100 ranks are fine enough."""
    rng = np.random.default_rng(7)
    reducer = fb.quantile("x", q)
    hits = 0
    for _ in range(1000):
        part = reducer.part([rng.random(100)], None, False)
        _, _, _, _, low, high = room._statistics(part, q)
        hits += low <= q <= high
    assert 0.95 - 4 * math.sqrt(0.05 * 0.95 / 1000) < hits / 1000 < 0.99


def test_too_few_lanes_have_no_bounds() -> None:
    data = result(fb.quantile("x", [0.001, 0.5, 0.999]), np.arange(100.0))
    assert data["low"].values[0] == -np.inf and data["high"].values[2] == np.inf
    assert np.isinf(data["error"].values[[0, 2]]).all() and np.isfinite(data["error"].values[1])
    assert not fb.error("q", absolute=1e9, least=2).met({"q": data})


def test_a_million_lanes_in_a_bucket() -> None:
    assert result(fb.quantile("x", [0, 0.5, 1]), np.full(200000, -2.5))["value"].values.tolist() == [-2.5] * 3


@pytest.mark.parametrize("q", [-0.1, 1.5, [], [[0.5]], "half", [0.5, math.nan], None])
def test_refused_probabilities(q: Any) -> None:
    with pytest.raises(SimulationError, match="Expected probabilities from 0 to 1 for q= of quantile, got"):
        fb.quantile("x", q)


@pytest.mark.parametrize("buckets", [15, 65537, 100.0, True])
def test_refused_buckets(buckets: Any) -> None:
    with pytest.raises(SimulationError, match="Expected from 16 to 65536 for buckets= of quantile, got"):
        fb.quantile("x", 0.5, buckets=buckets)
