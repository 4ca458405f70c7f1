"""Many motions of one machine at once: arrays in place of numbers, one dataset as the answer.

    lane k:  y' = f(t, y, c(p_k)),   y(t₀) = y_k

Every lane is integrated as a single run would be, with its own steps and events, in one compiled loop (`lanes`);
threads share the lanes. Lanes that this loop cannot run are run one by one (`alone`). Only the outputs are kept.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import SimulationError, arguments_named
from ..motion.batch.dataset import check_names, dataset_of
from ..motion.batch.interruption import Keyboard
from ..motion.batch.job import Job, check_memory, job_of
from ..motion.batch.lane_loop import LARGEST_BLOCK
from ..motion.batch.results import NO_START, REASON, STATUS, Results
from ..motion.batch.run import run_lanes
from ..motion.trajectory.progress import Progress
from ..scalar.algebra import Expression
from .blocks.pool import Elsewhere, check_executor
from .stores.netcdf import Store

if TYPE_CHECKING:
    import xarray

_SECONDS = 3.0  # between two writes to a store


@arguments_named
def simulate_batch(
    s: Any,
    until: Expression,
    *,
    initial: Mapping[Any, Any] | None = None,
    near: Mapping[Any, Any] | None = None,
    project: bool = False,
    values: Mapping[Any, Any] | None = None,
    tolerance: Any = 1e-9,
    events: Any = (),
    impulses: Any = (),
    impacts: str = "simultaneous",
    indeterminate: str = "refuse",
    method: str = "auto",
    step: Any = None,
    times: Any = None,
    samples: int | None = None,
    start: Expression = 0,
    max_step: float | None = None,
    max_steps: int | None = None,
    progress: bool | Callable[[float], Any] | None = None,
    outputs: Any = None,
    store: Any = None,
    threads: int | None = None,
    executor: Any = None,
    sensitivities: Any = None,
) -> xarray.Dataset:
    """Return the dataset of a batch; arguments as of :func:`freebody.simulate`, some of them arrays of one length."""
    if threads is not None and executor is not None:
        raise SimulationError(
            "Expected threads= or executor=, got both: each block that an executor runs has one thread. Leave one out."
        )
    options = dict(
        near=near, project=project, tolerance=tolerance, events=events, impulses=impulses, impacts=impacts,
        indeterminate=indeterminate, method=method, step=step, times=times, samples=samples, start=start,
        max_step=max_step, max_steps=max_steps, outputs=outputs,
        sensitivities=sensitivities,
    )  # fmt: skip
    job = job_of(s, until, initial=initial, values=values, threads=threads, **options)
    count = job.lanes.count
    check_names(job)
    elsewhere = None
    if executor is not None:
        check_executor(executor, job.kernels.model, (s, until, options))
        elsewhere = Elsewhere(executor, job, (s, until, options))
    file = None if store is None else Store(store, job)
    if file is None:
        check_memory(job)
    nothing = job.results(0, 0)
    part = results = nothing if file else job.results(0, count)
    store_part = file.write if file else results.take
    with Keyboard() as keyboard, Progress(0.0, float(count), progress) as bar:

        def take(part: Results) -> None:
            with keyboard.held():
                store_part(part)

        def between(done: float) -> None:
            bar(done)
            keyboard.check()

        try:
            keyboard.listening = True
            if elsewhere is not None:
                elsewhere.run(_blocks(job, file), take, between)
            else:
                for low, high in _blocks(job, file):
                    part = job.results(low, high) if file else results
                    run_lanes(job, part, between)
                    if file:
                        take(part)
                        part = nothing
            keyboard.listening = False
        except KeyboardInterrupt:  # lanes that are done are kept
            keyboard.listening = False
            part.clear(np.flatnonzero(part.waiting))
            if file:
                file.write(part)
        data = file.dataset() if file else dataset_of(job, results)
    if elsewhere is not None:
        elsewhere.report_lost_lanes(data)
    if not job.looped and (data["status"] == STATUS[NO_START]).all():
        raise SimulationError(f"No lane has a start. Lane 0: {data[REASON].values[0]}")
    return data


def _blocks(job: Job, file: Store | None) -> Iterator[tuple[int, int]]:
    """Yield ranges of lanes whose results are held in memory together: all lanes, if there is no store.

    With a store, a block takes some seconds, so that a run that is stopped by force loses no more.
    """
    n = job.lanes.count
    if file is None:
        yield 0, n
        return
    largest = max(1, min(LARGEST_BLOCK // job.bytes_per_lane, 1 << 16))
    low, size = 0, min(64 if job.looped else 1, largest)
    while low < n:
        clock = perf_counter()
        high = min(low + size, n)
        # ranges of lanes that are still waiting
        edges = np.flatnonzero(np.diff(file.waiting(low, high), prepend=0, append=0))
        for first, last in zip(edges[::2], edges[1::2], strict=True):
            yield low + int(first), low + int(last)
        low = high
        if edges.size:
            size = int(max(1, min(largest, 4 * size, size * _SECONDS / max(perf_counter() - clock, 1e-6))))
