"""Results of a study in memory."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...motion.batch.dataset import (
    TEXTS,
    arrays_of,
    attributes_of,
    blamable,
    blamed,
    coordinates_of,
    dataset_of,
    flags,
    tell_waiting,
    variables_of,
)
from ...motion.batch.job import Job
from ...motion.batch.results import REASON, Results
from ...motion.ending import STATUS, End
from ..blocks.block import Report, Whole
from ..blocks.schedule import Range

if TYPE_CHECKING:
    import xarray


class Memory:
    """Results in memory; ``results`` has a row for each lane."""

    delivery = Whole()

    def __init__(self, job: Job, results: Results) -> None:
        self.job, self.results = job, results
        self.lost: dict[int, str] = {}
        self.reasons: dict[int, str] = {}

    def missing(self, blocks: Sequence[Range]) -> Iterable[Range]:
        """Return the blocks with lanes that were not run: all of them."""
        return blocks

    def receive(self, report: Report) -> None:
        """Take the results of a block."""
        if report.content is not self.results:
            self.results.take(report.content)
        self.reasons |= report.reasons

    def lose(self, lost: dict[int, str]) -> None:
        """Note lanes that are lost, and why."""
        self.lost |= lost
        self.results.status[list(lost)] = End.LOST

    def enough(self) -> bool:
        """Return False: all lanes are kept."""
        return False

    def dataset(self) -> xarray.Dataset:
        """Return the results as they are given to users of ``simulate`` and ``sweep``."""
        return with_lost(dataset_of(explained_starts(self.job, self.reasons), self.results), self.lost)


class Flagged(Memory):
    """Results of a study in memory, given back with statuses as numbers.

    ``whole``   returns the job with the values of all lanes, which are the coordinates of the dataset
    """

    def __init__(self, job: Job, results: Results, whole: Callable[[], Job]) -> None:
        super().__init__(job, results)
        self.whole = whole

    def dataset(self) -> xarray.Dataset:
        """Return the results; the reasons of lanes that failed stand beside them."""
        import xarray

        self.results.clear(np.flatnonzero(self.results.waiting | (self.results.status == End.LOST)))
        self.results.status[list(self.lost)] = End.LOST
        job = self.whole()
        arrays = arrays_of(job, self.results)
        variables = {
            name: (dims, arrays[name] if kind == "text" else arrays[name].astype(kind, copy=False), about)
            for name, (dims, kind, about) in variables_of(job).items()
            if name != REASON
        }
        coordinates = coordinates_of(job)
        del coordinates["lane"]
        data = xarray.Dataset(variables, coordinates, attributes_of(job))
        return flagged(data, arrays["status"], arrays["blame"], job, self.reasons | self.lost)


def flagged(
    data: xarray.Dataset, codes: Any, blame: Any, job: Job, reasons: Mapping[int, str]
) -> xarray.Dataset:
    """Return the dataset with statuses as flags, and the reasons of the lanes that failed."""
    meanings = meanings_of(job)
    for name, array in (("blame", blamed(codes, blame, job)), ("status", codes)):
        kind, about = variables_of(job)[name][1:]
        data[name] = ("lane", np.asarray(array).astype(kind, copy=False), about | meanings[name])
    if reasons:
        lanes = sorted(reasons)
        texts = np.array([reasons[k] for k in lanes], dtype=object)
        data[REASON] = ("failed", texts, {"long_name": TEXTS[REASON]})
        about = {"long_name": "lane that failed"}
        data = data.assign_coords(failed_lane=("failed", np.array(lanes), about))
    tell_waiting(data, codes)
    return data


def meanings_of(job: Job) -> dict[str, Any]:
    """Return the attributes that give the numbers of ``status`` and ``blame`` their meanings."""
    names = blamable(job)
    return {
        "status": flags(STATUS.values(), STATUS),
        "blame": flags(["nothing", *names], range(-1, len(names))),
    }


def explained_starts(job: Job, reasons: Mapping[int, str]) -> Job:
    """Return a job that knows why lanes have no start whose starts were solved for in blocks."""
    if job.has_starts or not job.looped:
        return job
    return replace(job, no_start={**job.no_start, **dict(sorted(reasons.items()))})


def with_lost(data: xarray.Dataset, lost: dict[int, str]) -> xarray.Dataset:
    """Return a dataset that tells which lanes were lost, and why."""
    if lost:
        count = len(data["status"])
        reasons = data[REASON].values.copy() if REASON in data else np.full(count, "", dtype=object)
        reasons[list(lost)] = list(lost.values())
        data[REASON] = ("lane", reasons, {"long_name": TEXTS[REASON]})
        status = data["status"].values.copy()
        status[list(lost)] = "lost"
        data["status"] = ("lane", status, data["status"].attrs)
    return data
