"""One block of lanes, run where it is sent: in this process, in another, or on another computer.

    work  --(sent once, kept under its key)-->  ready job  --(low, high)-->  report

The ready job holds the machine, its kernels and all that does not depend on the lanes, so that a block costs its lanes
and little else. A lane that cannot be run takes no other along: a block that is refused is halved, until the lane that
is refused is alone.
"""

from __future__ import annotations

import pickle
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from threading import Lock
from time import perf_counter
from typing import Any, Protocol

import numpy as np

from ...errors import FreebodyError
from ...motion.batch.job import Job, job_of
from ...motion.batch.results import Results
from ...motion.batch.run import run_lanes
from ...motion.batch.start import lanes_of
from ...motion.ending import End
from ...motion.request import Request


class Delivery(Protocol):
    """What becomes of the results of a block, where it runs."""

    def deliver(self, job: Job, source: Any, part: Results, report: Report) -> Any:
        """Keep or reduce the results of a block; what is returned is sent back."""


@dataclass(frozen=True)
class Whole:
    """Results are sent back as they are."""

    def deliver(self, job: Job, source: Any, part: Results, report: Report) -> Results:
        """Return the results."""
        return part


@dataclass(frozen=True, eq=False)
class Work:
    """What a process needs to run any block of a study.

    ``request``    values and initial values of some lanes, by which the job is read and checked, and all that is the
                   same for all lanes
    ``count``      number of lanes of the study
    ``source``     values of all lanes; None if each block brings its own
    """

    request: Request
    count: int
    source: Any


@dataclass
class Report:
    """How a block went.

    ``done``      number of lanes that were run
    ``seconds``   time that it took
    ``ended``     number of lanes by the code of their status
    ``reasons``   why lanes were refused, by lane
    ``content``   what the delivery sends back
    ``interrupted``   True if Ctrl-C stopped it
    """

    low: int
    high: int
    done: int = 0
    seconds: float = 0.0
    ended: dict[int, int] = field(default_factory=dict)
    reasons: dict[int, str] = field(default_factory=dict)
    content: Any = None
    interrupted: bool = False


class Ready:
    """A study that is ready to run blocks."""

    def __init__(self, work: Work, threads: int | None = 1) -> None:
        self.work = work
        self.job = job_of(replace(work.request, threads=threads), work.count)

    def run(
        self, low: int, high: int, delivery: Delivery, source: Any = None,
        between: Callable[[float], None] = lambda done: None,
    ) -> Report:  # fmt: skip
        """Run a block and deliver its results. Ctrl-C leaves lanes of the block waiting."""
        clock = perf_counter()
        source = source or self.work.source
        part, report = self.job.results(low, high), Report(low, high)
        try:
            self._fill(source, part, report, between)
        except KeyboardInterrupt:
            report.interrupted = True
            part.clear(np.flatnonzero(part.waiting))
        return finished(report, part, delivery.deliver(self.job, source, part, report), clock)

    def _fill(self, source: Any, part: Results, report: Report, between: Callable[[float], None]) -> None:
        """Run the lanes of results; halve them if they are refused."""
        low, high = part.low, part.high
        try:
            values, initial = source.arguments(low, high)
            job = self.job.over(lanes_of(self.job.kernels.model, values, initial))
            run_lanes(job, replace(part, low=0, high=high - low), lambda done: between(low + done))
        except FreebodyError as error:
            if high - low == 1:
                part.status[0] = End.REFUSED
                report.reasons[low] = str(error)
                return
            middle = (low + high) // 2
            part.clear(slice(None))
            for rows in (part.rows(low, middle), part.rows(middle, high)):
                self._fill(source, rows, report, between)
            return
        report.reasons |= {low + lane: reason for lane, reason in job.no_start.items()}
        if job.texts:
            told = np.flatnonzero(part.texts[:, -1] != "")
            report.reasons |= {low + lane: part.texts[lane, -1] for lane in told.tolist()}


def finished(report: Report, part: Results, content: Any, clock: float) -> Report:
    """Return the report of a block that began at a time and has these results."""
    codes, counts = np.unique(part.status, return_counts=True)
    report.ended = dict(zip(codes.tolist(), counts.tolist(), strict=True))
    report.done = int((~part.waiting).sum())
    report.content, report.seconds = content, perf_counter() - clock
    return report


_READY: OrderedDict[str, Ready] = OrderedDict()
"""Ready jobs of this process by the key of their work."""
_KEPT = 4
_BUILDING = Lock()


def ready(work_key: str, work: bytes) -> Ready:
    """Return the ready job of some work; the last ones are kept."""
    with _BUILDING:
        entry = _READY.get(work_key)
        if entry is None:
            entry = _READY[work_key] = Ready(pickle.loads(work))
            while len(_READY) > _KEPT:
                _READY.popitem(last=False)
        _READY.move_to_end(work_key)
        return entry


def run_block(low: int, high: int, delivery: Delivery, source: Any, work_key: str, work: bytes) -> Report:
    """Run a block in this process."""
    return ready(work_key, work).run(low, high, delivery, source)


def packed_block(low: int, high: int, delivery: Delivery, source: Any, work_key: str, work: bytes) -> bytes:
    """Run a block, and return its report pickled: a message of one part, which dask sends twice as fast as ten."""
    return pickle.dumps(run_block(low, high, delivery, source, work_key, work), protocol=5)


def same(work: bytes) -> bytes:
    """Return the work that is given."""
    return work
