"""A study reduced where it runs: statistics of all lanes, in memory that does not depend on their number.

    state of all lanes = state of block 1 ⊕ state of block 2 ⊕ ...

⊕ is exactly associative and commutative (`reducers`), so that the result has the same bits for any blocks, workers and
order. A rule by which the study stops is asked after 1024 lanes, and then whenever half as many more have ended: the
lanes that count are the first of the law, whoever ran them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import SimulationError
from ..motion.batch.dataset import arrays_of
from ..motion.batch.job import Job
from ..motion.batch.results import LOST, Results
from ..motion.batch.start import lanes_of
from .blocks.block import Delivery, Report
from .blocks.schedule import Range
from .reducers.failures import Failures, state_of_block
from .reducers.number import EVENTS, event_column
from .reducers.reducer import Reducer, State

if TYPE_CHECKING:
    import xarray

_FIRST = 1024  # lanes after which a rule is asked first


def known_names(job: Job) -> list[str]:
    """Return the names that a reducer may read, besides outputs: parameters, starts that vary, and what runs tell."""
    starts = [f"{name}_start" for name in job.lanes.varied[1]]
    events = [event_column(kind, spec.name) for kind in EVENTS for spec in job.specs]
    return [*job.lanes.columns, *starts, "end", "steps", *events]


def columns_of(job: Job, source: Any, part: Results) -> dict[str, Any]:
    """Return the numbers of the lanes of a block, by the names that reducers read."""
    arrays = arrays_of(job, part)
    count = part.high - part.low
    lanes = lanes_of(job.kernels.model, *source.arguments(part.low, part.high))
    columns = {name: np.broadcast_to(x, (count,)) for name, x in lanes.columns.items()}
    columns |= {f"{name}_start": np.asarray(lanes.initial[name], dtype=float) for name in lanes.varied[1]}
    columns |= {name: arrays[name] for name in (*job.outputs.numbers, "end", "steps")}
    for i, spec in enumerate(job.specs):
        columns |= {event_column(kind, spec.name): arrays[kind][:, i] for kind in EVENTS}
    return columns


@dataclass(frozen=True)
class Reduced:
    """Results are reduced where they are made; states are sent back, or the text of an error."""

    reducers: Mapping[str, Reducer]
    failed: str

    def deliver(self, job: Job, source: Any, part: Results, report: Report) -> Any:
        """Return the states of a block, and its failures."""
        ended = ~part.waiting
        lanes, status = np.arange(part.low, part.high)[ended], part.outcomes[ended, 0]
        weights = source.weights(part.low, part.high)
        weights = None if weights is None else weights[ended]
        columns = {name: x[ended] for name, x in columns_of(job, source, part).items()}
        try:
            states = {
                name: state_of_block(reducer, columns, lanes, status, weights=weights, failed=self.failed)
                for name, reducer in self.reducers.items()
            }
        except SimulationError as error:
            return str(error)
        return states, Failures.of(status, lanes)


class Reduction:
    """States of the lanes that have ended.

    ``done``   number of lanes whose states are here: the first of the law, when a stage has ended
    """

    def __init__(self, reducers: Mapping[str, Reducer], failed: str) -> None:
        self.reducers, self.failed = reducers, failed
        self.delivery: Delivery = Reduced(reducers, failed)
        self.states: dict[str, State] = {}
        self.failures = Failures()
        self.before = self.done = 0

    def missing(self, blocks: Iterable[Range]) -> Iterator[Range]:
        """Yield the blocks behind the stages before."""
        self.before = self.done
        for low, high in blocks:
            if high > self.before:
                yield max(low, self.before), high

    def receive(self, report: Report) -> None:
        """Merge the states of a block.

        Raises
        ------
        SimulationError
            A lane without the number that is asked for, or a failed lane where it is an error.
        """
        if isinstance(report.content, str):
            raise SimulationError(report.content)
        states, failures = report.content
        self.failures = self.failures.merge(failures)
        self.failures.check(self.failed)
        for name, state in states.items():
            self.states[name] = self.states[name].merge(state) if name in self.states else state
        self.done += report.done

    def lose(self, lost: dict[int, str]) -> None:
        """Count lanes that are lost as failed."""
        self.failures = self.failures.merge(Failures.of([LOST] * len(lost), list(lost)))
        self.failures.check(self.failed)
        if self.failed == "count":
            raise SimulationError(
                f'Expected failed="skip" for lanes that end their process, got "count" and {len(lost)} of them, lane '
                f"{min(lost)} the first: {lost[min(lost)]}."
            )
        self.done += len(lost)

    @property
    def results(self) -> dict[str, xarray.Dataset]:
        """Result of each reducer by name."""
        return {
            name: self.reducers[name].result(state, self.failures.count, self.failed)
            for name, state in self.states.items()
        }

    def dataset(self) -> xarray.Dataset:
        """Return all results in one dataset: ``p``, ``p_error``, ``p_count``, ..."""
        import xarray

        parts = []
        for name, result in self.results.items():
            groups = [number.text for number in self.reducers[name].by]
            names = {x: name if x == "value" else f"{name}_{x}" for x in result.variables if x not in groups}
            names |= {x: f"{name}_{x}" for x in result.dims if x not in groups and x not in result.variables}
            parts.append(
                result.drop_vars(("failed",)).rename({x: y for x, y in names.items() if x != "failed"})
            )
        data = xarray.merge(parts, join="outer", combine_attrs="drop", compat="no_conflicts")
        data.attrs = {"lanes": self.done, "failed": self.failures.count, "failed_means": self.failed}
        data.attrs |= {name: result.attrs["summary"] for name, result in self.results.items()}
        return data


def stages(most: int, has_rule: bool) -> Iterator[int]:
    """Yield the numbers of lanes after which a rule is asked."""
    lanes = _FIRST
    while has_rule and lanes < most:
        yield lanes
        lanes += lanes // 2
    yield most
