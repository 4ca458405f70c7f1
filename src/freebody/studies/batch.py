"""Many motions of one machine at once: arrays in place of numbers, one dataset as the answer.

    lane k:  y' = f(t, y, c(p_k)),   y(t₀) = y_k

Every lane is integrated as a single run would be, with its own steps and events, in one compiled loop (`lanes`);
threads share the lanes. Lanes that this loop cannot run are run one by one (`alone`). Only the outputs are kept.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import SimulationError
from ..motion.batch.dataset import check_names
from ..motion.batch.job import Job, check_memory, job_of
from ..motion.batch.results import REASON, Results
from ..motion.batch.run import run_lanes
from ..motion.batch.start import lanes_of
from ..motion.ending import STATUS, End
from ..motion.request import Request
from .blocks.block import Delivery, Report, Work, finished
from .blocks.cutting import FEW
from .blocks.executors import sent
from .blocks.run import run
from .blocks.source import ByArrays
from .identity.study_identity import parts
from .stores.memory import Memory
from .stores.netcdf import NetCDF

if TYPE_CHECKING:
    import xarray


def batch(request: Request) -> xarray.Dataset:
    """Return the dataset of many motions; some values or initial values of the request are arrays of one length.

    Raises
    ------
    SimulationError
        An argument that the batch cannot use, a store of other runs, or no lane that has a start.
    """
    job, store = job_of(request), request.store
    check_names(job)
    nothing_kept = store is None
    if nothing_kept:
        check_memory(job)
    file = None if nothing_kept else NetCDF(store, job, parts(job))
    results = job.results(0, job.count if nothing_kept else 0)
    source = ByArrays.of(job.lanes)
    values, initial = source.arguments(0, min(FEW, job.count))
    shared = replace(request, values=values, initial=initial, store=None, executor=None, progress=None)
    work = Work(shared, job.count, None)

    def sink_of(size: int) -> Any:
        return file or Memory(job, results)

    data = run(
        AllLanes(job, results if nothing_kept else None), source, request.executor, sink_of, in_order=True,
        progress=request.progress,
        size=job.count if nothing_kept and request.executor is None and job.has_starts else None,
        pack=lambda: sent(work, job.kernels.model),
    )  # fmt: skip
    if not job.looped and (data["status"] == STATUS[End.NO_START]).all():
        raise SimulationError(f"No lane has a start. Lane 0: {data[REASON].values[0]}")
    return data


class AllLanes:
    """A batch whose job holds all lanes, and whose results may have their place already."""

    def __init__(self, job: Job, results: Results | None) -> None:
        self.job, self.results = job, results

    def run(
        self, low: int, high: int, delivery: Delivery, source: Any = None,
        between: Callable[[float], None] = lambda done: None,
    ) -> Report:  # fmt: skip
        """Run a block."""
        report = Report(low, high)
        clock = perf_counter()
        part = self.job.results(low, high) if self.results is None else self.results.rows(low, high)
        try:
            if self.job.has_starts:
                run_lanes(self.job, part, between)
            else:  # the starts of this block are solved for here
                job = self.job.over(lanes_of(self.job.kernels.model, *source.arguments(low, high)))
                run_lanes(job, replace(part, low=0, high=high - low), lambda done: between(low + done))
                report.reasons = {low + lane: reason for lane, reason in job.no_start.items()}
        except KeyboardInterrupt:  # lanes that are done are kept
            report.interrupted = True
            part.clear(np.flatnonzero(part.waiting))
        return finished(report, part, delivery.deliver(self.job, source, part, report), clock)
