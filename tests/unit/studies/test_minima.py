"""Fits from many starts: the best minimum, all others with the starts that lead to them, and refusals."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.errors import SimulationError

TIMES = np.linspace(0, 10, 41)


def oscillator() -> fb.System:
    s = fb.System("oscillator")
    k = s.parameters(k=1.0)
    slide = s.slider("guide", s.ground, s.body("block", fb.particle(1)), axis="x", coordinate="x")
    s.spring("k", slide, stiffness=k)
    return s


DATA = {"time": TIMES, "x": np.cos(2 * TIMES)}  # k = 4
STARTS = np.array([0.3, 1.0, 3.9, 4.1, 9.0, 16.0])


def cost(k: float) -> float:
    return float(((np.cos(np.sqrt(k) * TIMES) - DATA["x"]) ** 2).sum())


def test_the_best_of_several_minima() -> None:
    """x = cos(√k t): the cost as a function of k has a minimum for each wave too few or too many."""
    result = fb.fit(oscillator(), DATA, ["k"], initial={"x": 1}, starts=fb.table({"k": STARTS}))
    assert result.values["k"] == pytest.approx(4, rel=1e-7)
    assert len(result.minima) >= 3
    assert sum(x.starts for x in result.minima) + result.failed_starts == len(STARTS)
    assert result.minima[0].starts >= 2  # 3.9 and 4.1 lead to 4
    assert result.cost == result.minima[0].cost < 1e-12
    for one in result.minima:
        k = one.values["k"]
        assert one.cost == pytest.approx(cost(k), rel=1e-6, abs=1e-12)
        assert min(cost(0.99 * k), cost(1.01 * k)) > one.cost
    assert f"from {result.minima[0].starts}" in repr(result)


def test_one_start_alone_finds_the_nearest() -> None:
    alone = fb.fit(oscillator(), DATA, {"k": 16.0}, initial={"x": 1})
    assert alone.cost > 1 and alone.minima == ()


def test_refusals() -> None:
    def fit(starts: object) -> object:
        return fb.fit(oscillator(), DATA, ["k"], initial={"x": 1}, starts=starts)

    with pytest.raises(SimulationError, match=r"Expected starts=fb\.sample\(\.\.\.\), .* got \[1, 2\]"):
        fit([1, 2])
    with pytest.raises(SimulationError, match="Expected starts of the unknowns k, got 'x'"):
        fit(fb.table({"x": [1.0, 2.0]}))
    with pytest.raises(SimulationError, match="None of the 2 starts led to a fit. The first: "):
        fb.fit(
            oscillator(),
            {"time": [1.0], "x": [np.nan]},
            ["k"],
            initial={"x": 1},
            starts=fb.table({"k": [1.0, 2.0]}),
        )
