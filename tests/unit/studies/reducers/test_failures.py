"""Failed lanes are refused, left out or counted, never silently lost."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import freebody as fb
from freebody.errors import SimulationError
from freebody.motion.ending import STATUS, End
from freebody.studies.identity.content_digest import digest
from freebody.studies.reducers.failures import Failures, check_failed, good_lanes, state_of_block

X = np.array([1.0, 9.0, np.nan, 2.0, np.nan])
LANES = np.array([10, 11, 12, 13, 14])
CODES = np.array([End.FINISHED, End.TERMINAL, End.NO_START, End.FINISHED, End.COLLAPSED])
COLUMNS = {"x": X, "a": np.array([0.0, 0, 0, 1, 1])}


def test_only_runs_that_end_well_are_good() -> None:
    good = {code for code, here in zip(STATUS, good_lanes(list(STATUS)), strict=True) if here}
    assert good == {End.FINISHED, End.TERMINAL} and End.UNPHYSICAL not in good


def test_failures_merge_in_any_order() -> None:
    whole = Failures.of(CODES, LANES)
    assert whole.lanes == ((End.COLLAPSED, 1, 14), (End.NO_START, 1, 12)) and whole.count == 2
    parts = [Failures.of(CODES[[i]], LANES[[i]]) for i in (4, 0, 2, 1, 3)]
    total = Failures()
    for part in parts:
        total = total.merge(part)
    assert total == whole and digest(total) == digest(whole)
    assert whole.merge(Failures.of([End.NO_START], [3])).lanes[1] == (End.NO_START, 2, 3)


def test_failures_are_errors() -> None:
    failures = Failures.of(CODES, LANES)
    with pytest.raises(SimulationError) as info:
        failures.check("raise")
    assert str(info.value) == (
        "Expected all runs to end well, but 2 failed, the first in lane 12: 1 'step collapsed' (first in lane 14); "
        "1 'no start' (first in lane 12). Leave them out by failed=\"skip\", or count them as runs in which the "
        'conditions hold by failed="count".'
    )
    with pytest.raises(SimulationError, match="1 '77' .first in lane 3"):
        Failures(((77, 1, 3),)).check("raise")
    failures.check("skip")
    failures.check("count")
    Failures().check("raise")


@pytest.mark.parametrize("weights", [None, np.array([1.0, 2, 3, 4, 5])])
def test_skip_and_count(weights: Any) -> None:
    condition = fb.mean("x > 5", by="a")
    good = np.isfinite(X)
    part = None if weights is None else weights[good]
    skip = state_of_block(condition, COLUMNS, LANES, CODES, weights=weights, failed="skip")
    assert digest(skip) == digest(condition.of({k: x[good] for k, x in COLUMNS.items()}, LANES[good], part))
    count = state_of_block(condition, COLUMNS, LANES, CODES, weights=weights, failed="count")
    as_if = {**COLUMNS, "x": np.where(good, X, 99.0)}
    assert digest(count) == digest(condition.of(as_if, LANES, weights))
    data = condition.result(count, 2, "count")
    assert data["failed"].item() == 2
    assert (
        data["failed"].attrs["long_name"] == "runs that failed, counted as runs in which the condition holds"
    )


def test_meanings() -> None:
    condition = fb.mean("x > 5")
    check_failed("count", [condition])
    for how in ("raise", "skip"):
        check_failed(how, [condition, fb.variance("x")])
    for word in ("ignore", None, ["skip"]):
        with pytest.raises(SimulationError, match='Expected failed="raise", "skip" or "count", got'):
            check_failed(word, [])
    for reducer in (fb.mean("x"), fb.quantile("x > 5", 0.5), fb.largest("x")):
        with pytest.raises(
            SimulationError, match='Expected means of conditions for failed="count", got .*no number'
        ):
            check_failed("count", [condition, reducer])
