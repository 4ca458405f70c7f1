"""Many runs of one machine at once: arrays in place of numbers, one dataset as the answer.

    lane k:  y' = f(t, y, c(p_k)),   y(t₀) = y_k

Every lane is integrated as a run alone would be, with its own steps and events, in one compiled loop (`lanes`); threads
share the lanes. What that loop can not do, runs alone do, one by one (`batch_alone`). Only what is asked for is kept.

The file is longer than others: it reads the arguments, keeps the memory, and drives the loop.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...dynamics.mobility import check_bodies
from ...dynamics.unilateral import limits
from ...errors import ModelError, SimulationError, arguments_named, nearest
from ...model.values import check_assumptions
from ...native.registers import WIDTH
from ...program.large.tree_loop import is_large
from ..contact.impacts import ORDERS
from ..kernels.kernels import Kernels, kernels_of
from ..kernels.methods import BUDGET, FINE, check_method, check_method_of_contacts, first_method
from ..lanes import lanes_layout as at
from ..lanes import loops
from ..legs.blow import blows_of
from ..legs.driven import at_time, check_signals, intervals
from ..legs.failure import to_blame
from ..ode import layout
from ..ode.dense_output import STUCK
from ..start.arguments import (
    STORED,
    check_heeded,
    check_numbers,
    check_steps,
    largest_memory,
    most_steps,
    output_times,
    tolerances_of,
)
from ..start.initial import named_state, number, quaternions_by_joint, several
from ..trajectory.event import EventSpec, expressions_of, specs_of
from ..trajectory.one_sided_limits import NOT_PHYSICAL
from ..trajectory.outputs import TIMELINE, Output, outputs_of
from ..trajectory.progress import Progress
from .alone import NO_START, REASON, REFUSED, Alone
from .interruption import Keyboard
from .kernels import BatchProgram, OfLimit, batch_program
from .large_trees import Large
from .large_trees import applies as large
from .pool import Elsewhere, check_executor
from .start import Lanes, lanes_of
from .store import Store, check_names, dataset_of
from .threads import share

if TYPE_CHECKING:
    import xarray

Array = NDArray[np.float64]

METHODS = ("auto", "dop853", "dop54", "gauss", "radau", "taylor")
"""Those of which there is a loop over lanes."""
SAMPLES = 101
"""Output times when none are asked for."""

STATUS = {
    -1: "waiting",
    layout.FINISHED: "finished",
    layout.TERMINAL: "terminal event",
    layout.NOT_FINITE: "not finite",
    layout.COLLAPSED: "step collapsed",
    layout.DIVERGED: "iteration diverged",
    layout.UNDEFINED: "event undefined",
    at.STUCK: STUCK,
    at.TOO_MANY: "too many steps",
    at.LEFT: "constraints contradicted",
    NO_START: "no start",
    REFUSED: "refused",
    at.UNPHYSICAL: f"finished, {NOT_PHYSICAL}",
    at.STOPPED_UNPHYSICAL: f"terminal event, {NOT_PHYSICAL}",
}
"""How a lane may end."""
_LOST = (at.LEFT, layout.COLLAPSED, layout.NOT_FINITE)
BEFORE_SWITCHING = 20_000
"""Steps of a lane with a law that switches, after which it is run alone, which stops where it sticks on the law."""
_ROOM = 64  # steps between two looks at the output times
_SECONDS = 3.0  # between two writes to a store
_BLOCK = 1 << 26  # bytes of results that are held before they go to the store


@arguments_named
def simulate_batch(
    s: Any,
    until: Any,
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
    start: Any = 0,
    max_step: float | None = None,
    max_steps: int | None = None,
    progress: bool | Callable[[float], Any] | None = None,
    outputs: Any = None,
    store: Any = None,
    threads: int | None = None,
    executor: Any = None,
    sensitivities: Any = None,
) -> xarray.Dataset:
    """See :func:`freebody.simulate`, whose arguments these are; here some are arrays of one length."""
    if sensitivities is not None:
        raise SimulationError("Expected one motion for sensitivities=, got a batch. Leave one out.")
    if threads is not None and executor is not None:
        raise SimulationError(
            "Expected threads= or executor=, got both: each block that an executor runs has one thread. Leave one out."
        )
    asked = dict(
        near=near, project=project, tolerance=tolerance, events=events, impulses=impulses, impacts=impacts,
        indeterminate=indeterminate, method=method, step=step, times=times, samples=samples, start=start,
        max_step=max_step, max_steps=max_steps, outputs=outputs,
    )  # fmt: skip
    job = job_of(s, until, initial=initial, values=values, threads=threads, **asked)
    given = job.given
    check_names(job)
    elsewhere = None
    if executor is not None:
        check_executor(executor, job.kernels.model, (s, until, asked))
        elsewhere = Elsewhere(executor, job, (s, until, asked))
    kept = None if store is None else Store(store, job)
    if kept is None:
        _check_memory(job)
    nothing = Results.of(job, 0, 0)
    part = results = nothing if kept else Results.of(job, 0, given.count)
    take = kept.write if kept else results.take
    with Keyboard() as keyboard, Progress(0.0, float(given.count), progress) as shown:

        def taken(part: Results) -> None:
            with keyboard.held():
                take(part)

        def between(done: float) -> None:
            shown(done)
            keyboard.check()

        try:
            keyboard.listening = True
            if elsewhere is not None:
                elsewhere.run(_blocks(job, kept), taken, between)
            else:
                for low, high in _blocks(job, kept):
                    part = Results.of(job, low, high) if kept else results
                    job.run(part, between)
                    if kept:
                        taken(part)
                        part = nothing
            keyboard.listening = False
        except KeyboardInterrupt:  # what is done is kept
            keyboard.listening = False
            part.clear(np.flatnonzero(part.waiting))
            if kept:
                kept.write(part)
        data = kept.dataset() if kept else dataset_of(job, results)
    if elsewhere is not None:
        elsewhere.tell(data)
    if not job.looped and (data["status"] == STATUS[NO_START]).all():
        raise SimulationError(f"No lane has a start. Lane 0: {data[REASON].values[0]}")
    return data


def job_of(
    s: Any,
    until: Any,
    *,
    initial: Mapping[Any, Any] | None,
    near: Mapping[Any, Any] | None,
    project: bool,
    values: Mapping[Any, Any] | None,
    tolerance: Any,
    events: Any,
    impulses: Any,
    impacts: str,
    indeterminate: str,
    method: str,
    step: Any,
    times: Any,
    samples: int | None,
    start: Any,
    max_step: float | None,
    max_steps: int | None,
    outputs: Any,
    threads: int | None,
) -> Job:
    """What is to be run, checked."""
    kernels = kernels_of(s)
    model = kernels.model
    check_method(method, step)
    if model.contacts and method != "timestepping":
        check_method_of_contacts(method, step)
    if impacts not in ORDERS:
        raise SimulationError(f"Unknown order of impacts {impacts!r}; {nearest(str(impacts), ORDERS)}")
    blows = blows_of(impulses)
    check_numbers(samples, max_step, max_steps, 1)
    check_heeded(
        model, method, near=near, project=project, tolerance=tolerance, max_step=max_step, max_steps=max_steps,
        impacts=impacts, indeterminate=indeterminate,
    )  # fmt: skip
    if threads is not None and (isinstance(threads, bool) or not isinstance(threads, int) or threads < 1):
        raise SimulationError(f"Expected a number of threads of at least 1, got {threads!r}.")
    if times is not None and samples is not None:
        raise SimulationError("Expected times= or samples=, got both. Leave one out.")
    given = lanes_of(model, values or {}, initial or {})
    for name, value in (near or {}).items() if isinstance(near, Mapping) else ():
        if str(name) not in quaternions_by_joint(model) and several(value) is not None:
            raise SimulationError(
                f"Expected one number for '{name}' in near=, the same for all lanes, got {value!r}. What differs from "
                "lane to lane goes into initial=."
            )
    begin = _common(model, given, start, "start")
    end = _common(model, given, until, "until")
    wanted = output_times(times, begin, end)
    if wanted is None:
        count = SAMPLES if samples is None else samples
        wanted = np.linspace(begin, end, count) if begin != end else np.array([begin])
    if method != "timestepping":
        check_steps(begin, end, step, max_step, most_steps(max_steps, STORED + model.n_q + model.n_u))
    specs = specs_of(events)
    expressions = expressions_of(model, specs)
    asked = outputs_of(model, outputs, bool(model.contacts) and method != "timestepping")
    check_signals(model)
    given = replace(given, columns={**given.columns, **at_time(model, {}, begin)})
    _check_bodies(kernels, given)
    tolerances = tolerances_of(kernels, tolerance, method)
    alone = dict(
        near=near, project=project, tolerance=tolerance, events=specs, impulses=blows, impacts=impacts,
        indeterminate=indeterminate, method=method, step=step, max_step=max_step, max_steps=max_steps,
    )  # fmt: skip
    passing = limits(model)
    specs = (*specs, *(EventSpec(one.event, one.event, -1) for one in passing))
    expressions = (*expressions, *(OfLimit(k) for k in range(2 * len(passing))))
    job = Job(
        kernels, given, np.empty((1, 0)), {}, (), begin, end, wanted, specs, expressions, asked, tolerances, method,
        step, math.inf if max_step is None else float(max_step), max_steps, threads or _processors(), s, alone, False,
        len(passing),
    )  # fmt: skip
    if (
        model.contacts or model.controllers or blows or method not in METHODS or is_large(model)
        or (method == "taylor" and (begin == end or kernels.size == 0)) or large(job)
    ):  # fmt: skip
        if method == "timestepping" and "work_rate" in asked.values:
            raise SimulationError(
                "Expected outputs other than 'work_rate' for method='timestepping', whose contacts do their work in "
                "impulses. Ask for 'work'."
            )
        named_state(model, given.values_of(0), given.initial_of(0))  # names that no lane knows
        return job
    states, failed, active, apart = given.states(near or {}, begin, project, kernels)
    if model.constraints:
        kernels = kernels.holding(active)
    return replace(job, kernels=kernels, states=states, failed=failed, apart=apart, looped=True)


def _processors() -> int:
    """Those that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _common(model: Any, given: Lanes, value: Any, what: str) -> float:
    """A time that is the same in all lanes."""
    if np.ndim(value) > 0:
        raise SimulationError(
            f"Expected one number for {what}, the same for all lanes, got an array of shape {np.shape(value)}. "
            "A terminal event ends each lane at a time of its own."
        )
    first, *others = (number(model, given.values_of(k), value, what) for k in given.extremes)
    if any(x != first for x in others):
        raise SimulationError(
            f"Expected {what} to be the same for all lanes, but '{value}' depends on parameters that differ."
        )
    return first


def _check_bodies(kernels: Kernels, given: Lanes) -> None:
    """Refuse impossible bodies, and values that contradict an assumption, with the lane."""
    for lane in given.suspects():
        try:
            check_bodies(kernels.model, given.values_of(lane))
            check_assumptions(kernels.model, given.values_of(lane))
        except ModelError as error:
            raise type(error)(f"Lane {lane}: {error}" if given.count > 1 else str(error)) from None


def _check_memory(job: Job) -> None:
    """Refuse results that this computer can not hold, before anything is computed."""
    size = job.bytes_per_lane * job.given.count
    if size > largest_memory():
        raise SimulationError(
            f"Expected results that fit into memory, but {job.given.count} lanes of {len(job.asked.timed)} outputs at "
            f'{job.wanted.size} times take {size / 2**30:.3g} GiB. Pass store="lanes.nc", which writes them to a '
            "file as they come, or ask for fewer outputs= or times=."
        )


@dataclass(frozen=True, eq=False)
class Job:
    """What is to be run: everything but the memory for the results."""

    kernels: Kernels
    given: Lanes
    states: Array
    failed: Mapping[int, str]
    apart: tuple[int, ...]
    """Lanes held by other conditions than the rest."""
    begin: float
    end: float
    wanted: Array
    specs: tuple[EventSpec, ...]
    expressions: tuple[Any, ...]
    asked: Output
    tolerances: Array
    method: str
    step: float | None
    longest: float
    max_steps: int | None
    threads: int
    machine: Any
    alone: Mapping[str, Any]
    """Options of `simulate` for one lane."""
    looped: bool
    """Whether the compiled loop runs the lanes, else `simulate` each."""
    limits: int
    """How many of ``specs``, the last ones, are limits of one-sided forces; in ``expressions`` the same with what is
    negligible added stand behind them."""

    @property
    def bytes_per_lane(self) -> int:
        times = self.wanted.size if self.asked.timed else 0
        return 8 * (
            times * len(self.asked.timed) + 4 * len(self.asked.reduced) + 3 * len(self.expressions) + 6
        )

    @property
    def texts(self) -> tuple[str, ...]:
        """Names of what is kept of a lane in words."""
        if self.looped:
            return ()
        return (*((TIMELINE,) if self.asked.timeline else ()), REASON)

    @property
    def first(self) -> str:
        """The method of all lanes, but those that turn out to be stiff."""
        if self.begin == self.end:
            return "dop853" if self.method == "auto" else self.method
        return first_method(self.kernels, self.method, self.tolerances, batch=True)

    @property
    def most_steps(self) -> int:
        """Steps of a lane, which are those of a run alone."""
        model = self.kernels.model
        return most_steps(self.max_steps, STORED + model.n_q + model.n_u)

    def wide(self, method: str) -> bool:
        """Whether eight lanes run at once: by series any number, by stages where there are as many."""
        return method == "taylor" or (
            method == "dop853"
            and self.kernels.size > 0
            and self.begin != self.end
            and self.given.count >= WIDTH
        )

    def program(self, method: str) -> BatchProgram:
        """The machine code of the lanes by a method."""
        asked = self.asked
        return batch_program(
            self.kernels,
            asked.timed_values,
            asked.reduced_values,
            self.expressions,
            method,
            self.wide(method),
        )

    def run(self, part: Results, between: Callable[[float], None]) -> None:
        """Run lanes, and say of which that they are not physical."""
        self._run(part, between)
        if self.limits:
            self._passed(part)

    def _passed(self, part: Results) -> None:
        """Lanes that passed a limit by more than what is negligible; the times of the others are none."""
        m = len(self.specs)
        mine, surely = slice(m - self.limits, m), part.counts[:, m:] > 0
        part.counts[:, mine][~surely] = 0
        part.event_times[:, mine][~surely] = math.nan
        first = part.event_times[:, mine, 0] * (1 if self.end >= self.begin else -1)
        worst = m - self.limits + np.argmin(np.where(surely, first, math.inf), axis=1)
        for code, told in ((layout.FINISHED, at.UNPHYSICAL), (layout.TERMINAL, at.STOPPED_UNPHYSICAL)):
            rows = surely.any(axis=1) & (part.kept[:, 0] == code)
            part.kept[rows, 0], part.kept[rows, 3] = told, worst[rows]

    def _run(self, part: Results, between: Callable[[float], None]) -> None:
        """Run lanes, and those that turn out to be stiff once more."""
        if not self.looped:
            alone = Large(self, part, _Loop) if large(self) else Alone(self, part)
            alone.run(np.flatnonzero(part.waiting) + part.low, between)
            return
        first, watched = self.first, self.method == "auto" and not np.min(self.tolerances, initial=1.0) < FINE
        left_out = {*self.failed, *self.apart}
        todo = np.array(
            [k for k in range(part.low, part.high) if k not in left_out], dtype=np.int64
        ) if left_out else None  # fmt: skip
        for lane in self.failed:
            if part.low <= lane < part.high:
                part.kept[lane - part.low, 0] = NO_START
        loop_of_lanes = _Loop(self, first, part, watched)
        # where other conditions take over, they do for a run alone
        lost = _LOST if loop_of_lanes.program.dropped else ()
        if loop_of_lanes.limit < self.most_steps:  # a run alone sees whether it sticks
            lost = (*lost, at.TOO_MANY, layout.COLLAPSED)
        try:
            loop_of_lanes.run(todo, between)
            stiff = np.flatnonzero(part.kept[:, 0] == layout.STIFF)
            if stiff.size:
                part.clear(stiff)
                # with signals, a run alone changes its method in the leg that is stiff
                again = Alone(self, part) if self.kernels.model.signals else _Loop(self, "radau", part, False)
                again.run(stiff + part.low, between)
            apart = [k - part.low for k in self.apart if part.low <= k < part.high]
            apart += np.flatnonzero(np.isin(part.kept[:, 0], lost)).tolist()
            if apart:
                part.clear(apart)
                Alone(self, part).run(np.array(apart, dtype=np.int64) + part.low, between)
        except KeyboardInterrupt:  # so ended lanes that were to be run once more
            part.clear(np.flatnonzero(np.isin(part.kept[:, 0], (layout.STIFF, *lost))))
            raise


@dataclass(frozen=True, eq=False)
class Results:
    """What lanes ``low`` to ``high`` - 1 left."""

    low: int
    high: int
    values: Array
    reduced: Array
    event_times: Array
    counts: NDArray[np.int64]
    kept: NDArray[np.int64]
    ends: Array
    texts: NDArray[Any]

    @staticmethod
    def of(job: Job, low: int, high: int) -> Results:
        n, asked, m = high - low, job.asked, len(job.expressions)
        times = job.wanted.size if asked.timed else 0
        kept = np.zeros((n, at.KEPT), dtype=np.int64)
        kept[:, 0] = -1
        return Results(
            low, high, np.full((n, times, len(asked.timed)), math.nan),
            np.full((n, len(asked.reduced), at.EXTREMES), math.nan), np.full((n, m, 2), math.nan),
            np.zeros((n, m), dtype=np.int64), kept, np.full(n, job.begin),
            np.full((n, len(job.texts)), "", dtype=object),
        )  # fmt: skip

    def take(self, part: Results) -> None:
        """Put in place what some of the lanes left."""
        rows = slice(part.low - self.low, part.high - self.low)
        for name in ("values", "reduced", "event_times", "counts", "kept", "ends", "texts"):
            getattr(self, name)[rows] = getattr(part, name)

    def clear(self, rows: Any) -> None:
        """Forget what lanes left."""
        for array in (self.values, self.reduced, self.event_times):
            array[rows] = math.nan
        self.texts[rows] = ""
        self.counts[rows] = 0
        self.kept[rows] = (-1, 0, 0, 0)

    @property
    def waiting(self) -> NDArray[np.bool_]:
        return self.kept[:, 0] == -1


def _blocks(job: Job, kept: Any) -> Iterator[tuple[int, int]]:
    """Ranges of lanes whose results are held at once; without a store, all.

    With one they take some seconds each, so that a run that is stopped by force loses no more.
    """
    n = job.given.count
    if kept is None:
        yield 0, n
        return
    largest = max(1, min(_BLOCK // job.bytes_per_lane, 1 << 16))
    low, size = 0, min(64 if job.looped else 1, largest)
    while low < n:
        clock = perf_counter()
        high = min(low + size, n)
        # runs of lanes that are still waiting
        edges = np.flatnonzero(np.diff(kept.waiting(low, high), prepend=0, append=0))
        for first, last in zip(edges[::2], edges[1::2], strict=True):
            yield low + int(first), low + int(last)
        low = high
        if edges.size:
            size = int(max(1, min(largest, 4 * size, size * _SECONDS / max(perf_counter() - clock, 1e-6))))


class _Loop:
    """The compiled loop over lanes, ready to run."""

    def __init__(
        self, job: Job, method: str, part: Results, until_stiff: bool, program: BatchProgram | None = None,
    ) -> None:  # fmt: skip
        self.job, self.method, self.part = job, method, part
        kernels, given, model = job.kernels, job.given, job.kernels.model
        self.wide = job.wide(method)
        self.program = program = program or job.program(method)
        self.limit = min(job.most_steps, BEFORE_SWITCHING) if program.switches else job.most_steps
        n = kernels.size
        self.n, self.w = n, layout.padded(n)
        m, watched = len(job.expressions), program.watched
        outputs = len(job.asked.timed)
        times = job.wanted.size if outputs else 0
        self.addresses = np.array(
            [
                program.compiled._prologue.address, program.address("rates"), program.address("energy"),
                program.address("outputs"), program.address("reduced"), program.address("watched"),
                program.address("dropped"), program.wide_address("series" if method == "taylor" else "rates"),
                program.wide_address("projection"), program.wide_address("rates"),
                program.wide_address("watched"),
            ],
            dtype=np.int64,
        )  # fmt: skip
        sizes = np.zeros(at.SIZES, dtype=np.int64)
        sizes[at.N], sizes[at.WIDTH_OF_ROW] = n, self.w
        sizes[at.N_WORK] = layout.rows(method, n) * self.w
        sizes[at.N_QUATERNIONS], sizes[at.N_PARAMETERS] = len(model.quaternions), len(model.parameters)
        sizes[at.N_EVENTS], sizes[at.N_WATCHED] = m, watched
        sizes[at.N_OUTPUTS], sizes[at.N_TIMES], sizes[at.N_REDUCED] = outputs, times, len(job.asked.reduced)
        sizes[at.ROOM] = _ROOM
        sizes[at.LIMIT] = self.limit
        sizes[at.WORKS], sizes[at.STIFF_ASKED] = kernels.works, until_stiff
        sizes[at.BUDGET] = BUDGET if until_stiff else 0  # of "auto"
        sizes[at.N_DROPPED], sizes[at.N_LIMITS] = program.dropped, 2 * job.limits
        sizes[at.N_CONSTANTS] = program.compiled.hoisted
        self.sizes = sizes
        options = np.zeros(at.OPTIONS)
        options[at.T0], options[at.T1], options[at.LONGEST] = job.begin, job.end, job.longest
        options[at.ORDER], options[at.FINEST] = layout.ORDERS[method], FINE
        self.seen = 16 * watched if program.wide_address("watched") else 0
        if self.seen:
            sizes[at.SEEN] = self._places_of_eight()
        self.options = options
        spans, places, settings = intervals(kernels, given.values_of(0), job.begin, job.end)
        sizes[at.N_LEGS], sizes[at.N_SETTINGS] = len(spans), len(places)
        lengths = [_whole(t1 - t0, job.step, job.longest) for t0, t1 in spans]
        self.legs = np.column_stack([spans, lengths, settings])
        self.columns = np.array([*places, 0], dtype=np.int64)
        # the kernels of a method follow the quaternions; its constants are those of the rates. Parts of a step by
        # series are not compared with the rates, as steps are
        projection = program.address("projection")
        self.quaternions = np.array(
            [*model.quaternions, projection, model.n_q + model.n_u if projection else 0, 0,
             program.address("tangent"), 0],
            dtype=np.int64,
        )  # fmt: skip
        self.relative = job.tolerances
        negligible, rest = [-1] * job.limits, [0] * (watched - m)
        self.directions = np.array([*(x.direction for x in job.specs), *negligible, *rest], dtype=np.int64)
        self.terminal = np.array(
            [*(x.terminal for x in job.specs), *[0] * (watched - len(job.specs))], dtype=np.int64
        )
        backwards = job.end < job.begin
        self.order = np.argsort(-job.wanted if backwards else job.wanted, kind="stable")
        self.wanted = job.wanted[self.order]
        self.function = loops.function(method, self.wide)
        self.given = given

    def memory(self) -> tuple[Any, ...]:
        """Of one thread, in the order of the arguments."""
        if self.wide:
            return self._memory_of_eight()
        n, m = self.n, self.program.watched
        size = int(self.sizes[at.N_WORK])
        events = layout.most_events(m)
        largest = max(2, len(self.job.asked.reduced), self.program.dropped)
        return (
            np.zeros(size), np.zeros(size), self._mine(), np.zeros(max(1, self.program.compiled.hoisted)),
            np.zeros(2 * max(n, 1)),
            np.zeros(_ROOM + 1), np.zeros(_ROOM + 1), np.zeros((_ROOM + 1) * max(n, 1)),
            np.zeros(max(m, 1), dtype=np.int64), np.zeros((layout.PARTS + 3) * (m + 1)), np.zeros(max(m, 1)),
            np.zeros(max(1, events) * layout.FOUND), np.zeros((_ROOM + events + 1) * layout.LOGGED),
            np.zeros((_ROOM + events + 1) * max(n, 1)), np.zeros(max(1, self.wanted.size) * max(n, 1)),
            np.zeros(largest), np.zeros(layout.REALS), np.zeros(layout.INTEGERS, dtype=np.int64),
            np.zeros(layout.INTEGERS, dtype=np.int64),
        )  # fmt: skip

    def _places_of_eight(self) -> int:
        """Numbers of eight lanes before those of their limits."""
        numbers = layout.rows(self.method, self.n) * 8 * self.n + at.WIDE_PLACES + self.program.room
        return layout.padded(numbers)

    def _mine(self) -> Array:
        """Parameters of one lane."""
        return np.zeros(int(self.sizes[at.N_PARAMETERS]) + 1)

    def _memory_of_eight(self) -> tuple[Any, ...]:
        n, m, hoisted, size = (
            self.n,
            self.program.watched,
            self.program.compiled.hoisted,
            int(self.sizes[at.N_WORK]),
        )
        eight, events = 8 * n, layout.most_events(m)
        largest = max(2, n, len(self.job.asked.reduced), self.program.dropped)
        rows = _aligned(self._places_of_eight() + self.seen)
        return (
            np.zeros(size), np.zeros(largest), self._mine(), rows, _aligned(8 * max(1, hoisted)),
            np.zeros(8 * max(1, hoisted)), _aligned(2 * eight), np.zeros(n), np.zeros(at.WIDE_NUMBERS),
            np.zeros(at.WIDE_COUNTS, dtype=np.int64), np.zeros(8 * max(m, 1), dtype=np.int64),
            np.zeros(8 * (layout.PARTS + 3) * (m + 1)), np.zeros(max(m, 1)),
            np.zeros(max(1, events) * layout.FOUND), np.zeros((events + 1) * layout.LOGGED), np.zeros((events + 1) * n),
            np.zeros(layout.INTEGERS, dtype=np.int64),
        )  # fmt: skip

    def chunk(self, lanes: Any, memory: tuple[Any, ...]) -> None:
        """Run some lanes, given by number, and put what they left where it belongs."""
        job, part, n = self.job, self.part, len(lanes)
        rows = lanes - part.low
        initial = np.zeros((n, max(self.n, 1)))
        if self.n:
            initial = np.zeros((n, self.n))
            initial[:, : job.states.shape[1]] = job.states[lanes] if len(job.states) > 1 else job.states
        parameters = self.given.parameters(lanes)
        new = Results.of(job, 0, n)
        given = (
            0, n, self.addresses, self.sizes, self.options, initial, parameters, self.legs, self.columns, self.wanted,
            self.quaternions, self.relative, job.tolerances,
        )  # fmt: skip
        self.function(
            *given, self.directions, self.terminal, *memory, new.values, new.reduced, new.event_times, new.counts,
            new.kept, new.ends,
        )  # fmt: skip
        for k in np.flatnonzero(
            np.isin(new.kept[:, 0], (layout.NOT_FINITE, layout.COLLAPSED, layout.DIVERGED))
        ):
            rates = job.kernels.rates(parameters[k])
            blame, end = int(new.kept[k, 3]), float(new.ends[k])
            new.kept[k, 3] = to_blame(job.kernels, blame, self.method, rates, end, initial[k, : self.n])
        if new.values.size:
            part.values[rows[:, None], self.order] = new.values
        part.reduced[rows], part.event_times[rows], part.counts[rows] = (
            new.reduced,
            new.event_times,
            new.counts,
        )
        part.ends[rows] = new.ends
        part.kept[rows] = new.kept

    def run(self, todo: Any, between: Callable[[float], None]) -> None:
        """All lanes of the part, or those given by number."""
        lanes = np.arange(self.part.low, self.part.high, dtype=np.int64) if todo is None else todo
        threads = max(1, min(self.job.threads, len(lanes)))
        rooms = [self.memory() for _ in range(threads)]
        largest = max(1, _BLOCK // (8 * self.job.bytes_per_lane))
        share(
            lanes, self.chunk, rooms, 2 * WIDTH if self.wide else 1, largest,
            lambda done: between(float(self.part.low + done)),
        )  # fmt: skip


def _whole(span: float, step: float | None, longest: float) -> float:
    """Length of all steps of an interval, of which a whole number fits; 0 where none is given."""
    if step is None or span == 0:
        return 0.0
    return abs(span) / math.ceil(abs(span) / min(step, longest, abs(span)) * (1 - 1e-12))


def _aligned(count: int) -> Array:
    """Zeros that begin at a multiple of 64 bytes, as whole vector registers are read."""
    room = np.zeros(count + 8)
    shift = -(room.ctypes.data // 8) % 8
    return room[shift : shift + count]
