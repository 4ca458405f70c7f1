"""A study reduced where it runs: statistics of all lanes, in memory that does not depend on their number.

    state of all lanes = state of block 1 ⊕ state of block 2 ⊕ ...

⊕ is exactly associative and commutative (`reducers`), so that the result has the same bits for any blocks, workers and
order. A rule by which the study stops is asked after 1024 lanes, and then whenever half as many more have ended: the
lanes that count are the first of the law, whoever ran them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import cloudpickle
import numpy as np

from ..errors import SimulationError, path_of
from ..motion.batch.dataset import arrays_of
from ..motion.batch.job import Job
from ..motion.batch.results import Results
from ..motion.batch.start import lanes_of
from ..motion.ending import End
from .blocks.block import Delivery, Ready, Report
from .blocks.executors import sent
from .blocks.run import run
from .blocks.schedule import Range
from .identity.content_digest import digest
from .reducers.failures import Failures, check_failed, state_of_block
from .reducers.number import EVENTS, event_column
from .reducers.reducer import NAMES, Reducer, State
from .reducers.stopping import ErrorRule, rules_of
from .stores.states import StateStore
from .stores.zarr import size_of_block

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
        lanes, status = np.arange(part.low, part.high)[ended], part.status[ended]
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

    def __init__(
        self, reducers: Mapping[str, Reducer], failed: str, rules: Sequence[ErrorRule] = (),
        store: StateStore | None = None,
    ) -> None:  # fmt: skip
        self.reducers, self.failed, self.rules, self.store = reducers, failed, rules, store
        reduced = Reduced(reducers, failed)
        self.delivery: Delivery = reduced if store is None else store.delivery(reduced)
        self.states: dict[str, State] = {}
        self.failures = Failures()
        self.before = self.done = self.stage = 0

    def missing(self, blocks: Sequence[Range]) -> Iterator[Range]:
        """Yield the ranges of a stage, behind the stages before, whose states are missing; kept states are merged."""
        self.before = self.done
        size, count = blocks[0][1], blocks[-1][1]
        self.stage = count
        kept = self.store.kept(self.before, count) if self.store else [((self.before, count), None)]
        for (low, high), content in kept:
            if content is None:
                yield from ((x, min(x + size, high)) for x in range(low, high, size))
            else:
                self._merge(content)
                self.done += high - low

    def receive(self, report: Report) -> None:
        """Merge the states of a block.

        Raises
        ------
        SimulationError
            A lane without the number that is asked for, or a failed lane where it is an error.
        """
        if isinstance(report.content, str):
            raise SimulationError(report.content)
        self._merge(report.content)
        self.done += report.done

    def _merge(self, content: tuple[dict[str, State], Failures]) -> None:
        states, failures = content
        self.failures = self.failures.merge(failures)
        self.failures.check(self.failed)
        for name, state in states.items():
            self.states[name] = self.states[name].merge(state) if name in self.states else state

    def lose(self, lost: dict[int, str]) -> None:
        """Count lanes that are lost as failed."""
        self.failures = self.failures.merge(Failures.of([End.LOST] * len(lost), list(lost)))
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

    def enough(self) -> bool:
        """Return True if all rules are met."""
        return bool(self.rules) and all(rule.met(self.results) for rule in self.rules)

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
        if self.done < self.stage:
            data.attrs["interrupted"] = f"{self.stage - self.done} of {self.stage} lanes were not run"
        data.attrs |= {name: result.attrs["summary"] for name, result in self.results.items()}
        return data


def stages(most: int, has_rule: bool) -> Iterator[int]:
    """Yield the numbers of lanes after which a rule is asked."""
    lanes = _FIRST
    while has_rule and lanes < most:
        yield lanes
        lanes += lanes // 2
    yield most


_RESERVED = ("lanes", "failed", "failed_means", "lost", "interrupted")
"""Attributes of the dataset, beside which a result of the same name would not be seen."""


@dataclass(frozen=True)
class ReducerOptions:
    """How a study is reduced, besides by what; see :meth:`freebody.Study.reduce`."""

    until: Any
    most: int
    failed: str
    store: Any


def reduce(
    study: Any,
    reducers: Mapping[str, Reducer],
    options: ReducerOptions,
    executor: Any,
    *,
    progress: bool | Callable[[Any], Any] | None,
    threads: int | None,
) -> xarray.Dataset:
    """Return statistics of the lanes of a study; see :meth:`freebody.Study.reduce`."""
    rules, most = _checked(study, reducers, options)
    wanted = list(dict.fromkeys(x for reducer in reducers.values() for x in reducer.wanted))
    lanes = replace(study, outputs=wanted or [f"final({study.machine.coordinate_names[0]})"])
    here = executor is None or executor == "threads"
    if threads is not None and not here:
        raise SimulationError(
            "Expected threads= or executor=, got both: each block that an executor runs has one thread. Leave one out."
        )
    ready = Ready(lanes._work, threads if here else 1)
    for reducer in reducers.values():
        reducer.check(known_names(ready.job))
    path = None if options.store is None else path_of(options.store, "store=", SimulationError)

    def sink_of(size: int) -> Reduction:
        if path is None:
            return Reduction(reducers, options.failed, rules)
        parts = {**lanes._parts, "reducers": digest([sorted(reducers.items()), options.failed])}
        kept = bytes(cloudpickle.dumps((study, (reducers, options))))
        store = StateStore(path, parts, size, lambda: kept, repr(study.lanes), study.count)
        return Reduction(reducers, options.failed, rules, store)

    return run(
        ready, lanes._source, None if here else executor, sink_of, progress=progress,
        size=None if path is None else size_of_block(path), stages=stages(most, bool(rules)),
        pack=lambda: sent(lanes._work, lanes.machine),
    )  # fmt: skip


def _checked(
    study: Any, reducers: Mapping[str, Reducer], options: ReducerOptions
) -> tuple[tuple[ErrorRule, ...], int]:
    """Return the rules and the greatest number of lanes; refuse what cannot be reduced."""
    if not isinstance(reducers, Mapping) or not reducers:
        raise SimulationError(
            f"Expected reducers by name, such as {{'p': fb.mean('max(x) > 1')}}, got {reducers!r}."
        )
    for name, reducer in reducers.items():
        if not isinstance(name, str) or not isinstance(reducer, Reducer):
            raise SimulationError(
                f"Expected a reducer such as fb.mean('max(x) > 1') for {name!r}, got {reducer!r}."
            )
        _check_name(name, reducers)
    check_failed(options.failed, reducers.values())
    rules = rules_of(options.until)
    for rule in rules:
        rule.check(reducers)
    most = options.most
    number = isinstance(most, int | float | np.integer | np.floating) and not isinstance(most, bool)
    if not (number and 0 < most <= study.count and most == int(most)):
        raise SimulationError(
            f"Expected a whole number most= from 1 to {study.count}, the number of lanes, got {most!r}."
        )
    return rules, int(most)


def _check_name(name: str, reducers: Mapping[str, Reducer]) -> None:
    """Refuse a name that hides something else of the result."""
    groups = [number.text for reducer in reducers.values() for number in reducer.by]
    what = "an attribute" if name in _RESERVED else "an axis of groups" if name in groups else ""
    for other in reducers:
        if name.startswith(f"{other}_") and name[len(other) + 1 :] in NAMES:
            what = f"the {name[len(other) + 1 :]} of '{other}'"
    if what:
        raise SimulationError(
            f"Expected another name for the reducer '{name}', which in the result is {what}. Name it, for example, "
            f"'my_{name}'."
        )
