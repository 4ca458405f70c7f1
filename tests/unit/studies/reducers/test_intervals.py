"""Intervals cover as stated."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import binom, binomtest, norm

from freebody.studies.reducers.intervals import CONFIDENCE, DEVIATIONS, rank_of, ranks_around, wilson


def test_deviations() -> None:
    assert math.isclose(DEVIATIONS, norm.ppf((1 + CONFIDENCE) / 2), rel_tol=1e-15)


@pytest.mark.parametrize(("k", "n"), [(0, 1), (0, 50), (7, 50), (50, 50), (1, 10**9)])
def test_wilson(k: int, n: int) -> None:
    other = binomtest(k, n).proportion_ci(CONFIDENCE, method="wilson")
    np.testing.assert_allclose(wilson(k, n), other, rtol=1e-9, atol=1e-17)


def test_wilson_of_no_runs() -> None:
    assert all(map(math.isnan, wilson(0, 0)))


@pytest.mark.parametrize("q", [0.001, 0.1, 0.5, 0.999])
@pytest.mark.parametrize("n", [1, 10, 1000, 10**6])
def test_ranks_enclose_the_quantile(q: float, n: int) -> None:
    """P(l <= K < u) is at least 95 %, and no longer so with one rank less at either end: each tail is below 2.5 %."""
    low, high = ranks_around(q, n)
    tail = (1 - CONFIDENCE) / 2
    assert binom.cdf(low - 1, n, q) <= tail and binom.sf(high - 1, n, q) <= tail + 1e-15
    assert binom.cdf(low, n, q) > tail - 1e-15 and binom.sf(high - 2, n, q) > tail - 1e-15


def test_ranks_are_those_of_decimal_numbers() -> None:
    """0.999 n is not an integer for the float next to 0.999; the least rank is 1."""
    assert [rank_of(0.999, n) for n in (1, 999, 1000, 10**6)] == [1, 999, 999, 999000]
    assert rank_of(0.0, 5) == 1 and rank_of(1.0, 5) == 5 and rank_of(0.07, 100) == 7
