"""Running the lanes of a batch: by the compiled loop over lanes, as lanes of a large tree, or each alone."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ..ending import BLAMED, End
from ..kernels.methods import FINE
from .alone import Alone
from .job import Job
from .lane_loop import LaneLoop
from .large_trees import LargeTrees
from .results import Results

_CONDITIONS_LOST = (End.CONTRADICTED, End.COLLAPSED, End.NOT_FINITE)
"""How a lane ends in the loop if other conditions should take over."""


def run_lanes(job: Job, results: Results, between: Callable[[float], None]) -> None:
    """Run all lanes of these results that are waiting; ``between`` gets the number of lanes that are done."""
    if job.looped:
        _run_loop(job, results, between)
    else:
        runner = LargeTrees(job, results) if job.over_links else Alone(job, results)
        runner.run(np.flatnonzero(results.waiting) + results.low, between)
    if job.limits:
        _judge_limits(job, results)


def _judge_limits(job: Job, results: Results) -> None:
    """Mark lanes that pass a limit of a one-sided force as not physical; forget passings that are negligible."""
    m = len(job.specs)
    columns, surely = slice(m - job.limits, m), results.counts[:, m:] > 0
    results.counts[:, columns][~surely] = 0
    results.event_times[:, columns][~surely] = math.nan
    first = results.event_times[:, columns, 0] * (1 if job.end >= job.begin else -1)
    earliest = m - job.limits + np.argmin(np.where(surely, first, math.inf), axis=1)
    for physical, unphysical in (
        (End.FINISHED, End.UNPHYSICAL),
        (End.TERMINAL, End.STOPPED_UNPHYSICAL),
    ):
        rows = surely.any(axis=1) & (results.status == physical)
        results.status[rows], results.blame[rows] = unphysical, earliest[rows]


def _run_loop(job: Job, results: Results, between: Callable[[float], None]) -> None:
    """Run lanes by the compiled loop, stiff ones again by an implicit method, and lanes it cannot follow alone."""
    low, high, status = results.low, results.high, results.status
    until_stiff = job.request.method == "auto" and not np.min(job.tolerances, initial=1.0) < FINE
    left_out = {*job.no_start, *job.apart}
    lanes = np.arange(low, high, dtype=np.int64)
    if left_out:
        lanes = np.array([k for k in lanes.tolist() if k not in left_out], dtype=np.int64)
    for lane in job.no_start:
        if low <= lane < high:
            status[lane - low] = End.NO_START
    loop = LaneLoop(job, job.first_method, results, until_stiff)
    # a single run changes its conditions on the way
    lost: tuple[int, ...] = _CONDITIONS_LOST if loop.program.dropped else ()
    if (
        job.kernels.active and job.request.step is None
    ):  # a single run has a step across positions that are singular
        lost = (*lost, *BLAMED)
    if loop.program.laws:  # a single run goes on with the other side of a law that switches
        lost = (*lost, End.RELEASED)
    try:
        loop.run(lanes, between)
        stiff = np.flatnonzero(status == End.STIFF)
        if stiff.size:
            results.clear(stiff)
            # with signals, a single run changes its method in the leg that is stiff
            again = Alone(job, results) if job.kernels.model.signals else LaneLoop(job, "radau", results)
            again.run(stiff + low, between)
        rows = [k - low for k in job.apart if low <= k < high]
        if lost and not (status == End.FINISHED).all():
            rows += np.flatnonzero(np.isin(status, lost)).tolist()
        if rows:
            results.clear(rows)
            Alone(job, results).run(np.array(rows, dtype=np.int64) + low, between)
    except KeyboardInterrupt:  # lanes that ended so were to be run again
        results.clear(np.flatnonzero(np.isin(status, (End.STIFF, *lost))))
        raise
