"""Rules are met by small errors alone: not by zeros, few runs or unknown errors."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import freebody as fb
from freebody.errors import SimulationError
from freebody.studies.reducers.stopping import rules_of


def result(reducer: Any, x: Any, **more: Any) -> Any:
    return reducer.result(reducer.of({"x": np.asarray(x, dtype=float), **more}, np.arange(len(x))))


def test_bounds_of_a_mean() -> None:
    data = result(fb.mean("x"), np.tile([1.0, 3.0], 200))
    value, error = data["value"].item(), data["error"].item()
    for factor, met in ((1 + 1e-12, True), (1 - 1e-12, False)):
        assert fb.error("p", absolute=error * factor).met({"p": data}) is met
        assert fb.error("p", relative=error / value * factor).met({"p": data}) is met
    assert fb.error("p", relative=error / value * 1.1).met(
        {"p": result(fb.mean("-x"), np.tile([1.0, 3.0], 200))}
    )


def test_a_mean_of_zero_has_no_relative_error() -> None:
    zeros = result(fb.mean("x"), np.zeros(1000))
    assert zeros["error"] == 0
    assert not fb.error("p", relative=0.5).met({"p": zeros})
    assert fb.error("p", absolute=0.5).met({"p": zeros})


def test_no_hit_is_no_small_error() -> None:
    """0 of 1000 runs: the standard error is 0, but Wilson's interval reaches to 0.0038."""
    data = result(fb.mean("x > 1"), np.zeros(1000))
    assert data["error"] == 0
    assert not fb.error("p", absolute=0.0009).met({"p": data})
    assert fb.error("p", absolute=0.001).met({"p": data})


def test_few_runs() -> None:
    data = result(fb.mean("x"), np.ones(99))
    assert not fb.error("p", relative=0.5).met({"p": data})
    assert fb.error("p", relative=0.5, least=99).met({"p": data})
    assert not fb.error("p", absolute=9, least=2).met({"p": result(fb.mean("x"), [])})


def test_all_groups_and_quantiles_count() -> None:
    x = np.concatenate([np.ones(200), np.tile([0.0, 2.0], 100)])
    data = result(fb.mean("x", by="a"), x, a=np.repeat([0.0, 1.0], 200))
    assert not fb.error("p", absolute=0.05).met({"p": data})
    assert fb.error("p", absolute=0.08).met({"p": data})
    data = result(fb.quantile("x", [0.5, 0.9999]), np.arange(1000))
    assert not fb.error("q", absolute=1e6).met({"q": data})
    assert fb.error("q", absolute=1e6).met({"q": data.isel(quantile=[0])})


def test_rules_in_a_list() -> None:
    one, two = fb.error("p", relative=0.1), fb.error("q", absolute=1)
    assert rules_of(None) == () and rules_of(one) == (one,) and rules_of([one, two]) == (one, two)
    for value in ("p", 3, [one, "p"]):
        with pytest.raises(
            SimulationError, match=r"Expected fb.error\(...\) or a list of them for until= of a study"
        ):
            rules_of(value)


def test_results_of_rules_exist() -> None:
    reducers = {"prob": fb.mean("x"), "worst": fb.largest("x")}
    fb.error("prob", relative=0.1).check(reducers)
    with pytest.raises(SimulationError, match="Unknown result 'prop' in fb.error; did you mean 'prob'"):
        fb.error("prop", relative=0.1).check(reducers)
    with pytest.raises(
        SimulationError, match=r"with a standard error for fb.error\('worst'\), got largest\('x', 10\)"
    ):
        fb.error("worst", relative=0.1).check(reducers)


def test_refusals() -> None:
    with pytest.raises(SimulationError, match="Expected the name of a result for fb.error, got 3"):
        fb.error(3, relative=1)  # type: ignore[arg-type]
    with pytest.raises(
        SimulationError, match=r"relative= or absolute= for fb.error\('p'\), got neither. Rules"
    ):
        fb.error("p")
    with pytest.raises(SimulationError, match=r"relative= or absolute= for fb.error\('p'\), got both. Rules"):
        fb.error("p", relative=1, absolute=1)
    for bound in (0, -1, np.nan, np.inf, "small"):
        with pytest.raises(
            SimulationError, match=r"Expected a positive number for absolute= of fb.error\('p'\), got"
        ):
            fb.error("p", absolute=bound)
    for least in (1, 10.0, True):
        with pytest.raises(SimulationError, match=r"Expected at least 2 for least= of fb.error\('p'\), got"):
            fb.error("p", absolute=1, least=least)  # type: ignore[arg-type]
