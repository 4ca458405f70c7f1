"""Studies that are reduced: the statistics are those of the lanes, for any workers, blocks and order."""

from __future__ import annotations

import math
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
import scipy.stats

import freebody as fb
from batch_machines import pendulum
from freebody.errors import SimulationError
from freebody.studies.reduction import stages

REDUCERS = {
    "p": fb.mean("range(theta') > 2"),
    "speed": fb.mean("range(theta')"),
    "spread": fb.variance("range(theta')"),
    "tail": fb.quantile("range(theta')", [0.5, 0.9]),
    "worst": fb.largest("range(theta')", 3),
    "by_mass": fb.mean("end", by="floor(m)"),
}


def swings(n: int = 3000, **options) -> fb.Study:
    lanes = fb.sample({"theta": scipy.stats.uniform(0.1, 2), "m": (1, 3)}, n=n, by="random", seed=1)
    return fb.study(pendulum(), until=1, lanes=lanes, **options)


def test_results_are_those_of_the_lanes() -> None:
    study = swings()
    data = study.reduce(REDUCERS, progress=False)
    x = fb.study(study.machine, until=1, lanes=study.lanes, outputs="range(theta')").run(progress=False)
    x = x["range(theta')"].values
    assert data.p == np.mean(x > 2) and data.p_count == 3000
    assert data.speed.item() == pytest.approx(x.mean(), rel=1e-15)
    assert data.spread.item() == pytest.approx(x.var(ddof=1), rel=1e-12)
    assert data.speed_error.item() == pytest.approx(x.std(ddof=1) / np.sqrt(3000), rel=1e-3)
    assert np.array_equal(np.sort(data.worst.values), np.sort(x)[-3:])
    assert np.array_equal(np.sort(data.worst_lane.values), np.sort(np.argsort(x)[-3:]))
    assert data.by_mass.sizes == {"floor(m)": 2} and (data.by_mass == 1).all()
    assert data.attrs["lanes"] == 3000 and data.attrs["failed"] == 0


def test_bits_do_not_depend_on_workers_or_blocks() -> None:
    study = swings()
    here = study.reduce(REDUCERS, progress=False, threads=1)
    assert study.reduce(REDUCERS, progress=False, threads=2).identical(here)
    with ProcessPoolExecutor(2) as pool:
        assert study.reduce(REDUCERS, pool, progress=False).identical(here)


def test_a_rule_stops_at_the_same_lane_whoever_runs_them() -> None:
    study = swings(20000)
    options = {"until": fb.error("p", relative=0.01), "progress": False}
    data = study.reduce({"p": REDUCERS["p"]}, **options)
    assert data.attrs["lanes"] in stages(20000, True) and 1024 < data.attrs["lanes"] < 20000
    assert data.p_error <= 0.01 * data.p
    with ProcessPoolExecutor(2) as pool:
        assert study.reduce({"p": REDUCERS["p"]}, pool, **options).identical(data)
    assert study.reduce({"p": REDUCERS["p"]}, most=500, progress=False).attrs["lanes"] == 500


def test_failed_lanes_mean_what_they_are_told_to() -> None:
    lanes = fb.grid(theta=np.linspace(0.1, 1, 20))
    study = fb.study(pendulum(), until=1, lanes=lanes, max_steps=4)
    with pytest.raises(
        SimulationError, match=r"Expected all runs to end well, but \d+ failed, the first in lane \d+"
    ):
        study.reduce({"p": fb.mean("range(theta') > 0")}, progress=False)
    left = study.reduce({"p": fb.mean("range(theta') > 9")}, progress=False, failed="skip")
    assert 0 < left.attrs["failed"] == 20 - int(left.p_count) and left.p == 0
    counted = study.reduce({"p": fb.mean("range(theta') > 9")}, progress=False, failed="count")
    assert counted.p == left.attrs["failed"] / 20


def test_nonsense_is_refused() -> None:
    study = swings(10)
    for reducers, message in (
        ({}, "Expected reducers by name, such as"),
        ({"p": "range(theta')"}, "Expected a reducer such as fb.mean"),
        ({"p": fb.mean("endd")}, "endd"),
        ({"p": fb.mean("max(thete)")}, "thete"),
    ):
        with pytest.raises(SimulationError, match=message):
            study.reduce(reducers, progress=False)
    for most in (11, 1.5, "many", True, float("nan"), 0):
        message = f"Expected a whole number most= from 1 to 10, the number of lanes, got {most!r}"
        with pytest.raises(SimulationError, match=message):
            study.reduce({"p": fb.mean("end")}, most=most)
    with pytest.raises(SimulationError, match="Unknown result 'q' in fb.error"):
        study.reduce({"p": fb.mean("end")}, until=fb.error("q", relative=0.1))
    with pytest.raises(SimulationError, match="has none in lane"):
        study.reduce({"p": fb.mean("1/(end - 1)")}, progress=False)


def test_a_rare_event_by_importance_sampling() -> None:
    """A stone without gravity, v ~ N(5, 1), is beyond 10 m after 1 s: P(v > 10) = Φ(-5) = 2.9e-7."""
    s = fb.System("stone")
    s.slider("fall", s.ground, s.body("stone", fb.particle(1)), axis="y", coordinate="y")
    lanes = fb.sample(
        {"y'": scipy.stats.norm(5, 1)}, n=4000, by="random", seed=2, proposal={"y'": scipy.stats.norm(10, 1)}
    )
    study = fb.study(s, until=1, lanes=lanes, outputs="final(y)")
    answer = study.reduce({"p": fb.mean("final(y) > 10")})
    chance, error = float(answer.p), float(answer.p_error)
    exact = scipy.stats.norm.sf(5)
    # of one lane, by proposal: E w² - p² with w = φ(x)/φ(x - 5), E w² over x > 5: e^25 Φ(-10)
    assert error == pytest.approx(
        math.sqrt((math.exp(25) * scipy.stats.norm.sf(10) - exact**2) / 4000), rel=0.2
    )
    assert error < 0.05 * exact
    assert abs(chance - exact) < 4 * error
