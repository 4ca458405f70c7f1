"""The job of a batch: arguments of `simulate` for many lanes, read and checked."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...dynamics.conditions.mobility import check_bodies
from ...dynamics.conditions.unilateral import limits
from ...errors import ModelError, SimulationError
from ...model import Model
from ...model.values import check_assumptions
from ...native.records import WIDTH
from ...program.large.tree_loop import is_large
from ...scalar.algebra import Expression
from ..contact.derivatives.sensitivity import check_derivable
from ..contact.motion import check_order
from ..ending import End
from ..kernels.kernels import Kernels
from ..kernels.methods import FINE, first_method
from ..kernels.sides import sides_of
from ..legs.blow import blows_of
from ..legs.variation import unknowns_of
from ..ode.dense_output import Array
from ..ode.layout import EXPLICIT
from ..request import Request
from ..start.arguments import (
    STORED,
    check_steps,
    largest_memory,
    most_steps,
    output_times,
    tolerances_of,
)
from ..start.initial import named_state, number, quaternions_by_joint, several
from ..start.signals import at_time, check_signals
from ..trajectory.event import EventSpec, expressions_of, specs_of
from ..trajectory.outputs import TIMELINE, OfReaction, Output, outputs_of
from .kernels import BatchProgram, OfLimit, batch_program
from .results import REASON, Results
from .start import Lanes, lanes_of


def has_lanes(method: str) -> bool:
    """Return True if there is a compiled loop over lanes of a method."""
    return method in ("auto", *EXPLICIT, "gauss", "radau", "taylor")


FEW = 64
"""Number of lanes whose starts are solved for, in a machine with constraints, before any lane runs."""
SAMPLES = 101
"""Number of output times if none are given."""


@dataclass(frozen=True, eq=False)
class Job:
    """A batch to run: everything but the memory for its results.

    ``kernels``          programs of the machine, with the conditions that are independent in the first lane
    ``lanes``            parameters and initial values
    ``states``           (q, u) at ``begin``, one row per lane, or one row for all; of a machine with constraints the
                         first lanes may have them only, since each start is solved for: `over` has those of others
    ``no_start``         lanes without an initial state, and why
    ``apart``            lanes in which other conditions are independent
    ``specs``            events; the last ``limits`` of them are limits of one-sided forces
    ``expressions``      what they watch; then the limits again, with negligible parts of the forces added
    ``request``          what was asked for, with all that lanes share; its values and initial values count for no lane
    ``looped``           True if the compiled loop runs the lanes; else each is a run by itself (`alone`)
    ``count``            number of lanes of the study, of which these may be a block
    """

    request: Request
    kernels: Kernels
    lanes: Lanes
    states: Array
    no_start: Mapping[int, str]
    apart: tuple[int, ...]
    begin: float
    end: float
    times: Array
    specs: tuple[EventSpec, ...]
    expressions: tuple[Expression | OfLimit, ...]
    outputs: Output
    tolerances: Array
    threads: int
    looped: bool
    limits: int
    count: int
    unknowns: tuple[str, ...] = ()

    def over(self, lanes: Lanes) -> Job:
        """Return the job of other lanes of the same study: a lane runs as it would among any others.

        Raises
        ------
        FreebodyError
            A lane whose values or initial values are impossible.
        """
        lanes = replace(lanes, columns={**lanes.columns, **at_time(lanes.model, {}, self.begin)})
        _check_bodies(self.kernels.model, lanes, lanes.suspects())
        states, no_start, apart = self.states, self.no_start, self.apart
        if self.looped:
            states, no_start, _, apart = lanes.states(
                self.request.near or {}, self.begin, self.request.project, self.request.kernels,
                self.kernels.active if self.kernels.model.constraints else None,
            )  # fmt: skip
        return replace(self, lanes=lanes, states=states, no_start=no_start, apart=apart)

    @property
    def has_starts(self) -> bool:
        """True if ``states`` holds those of all lanes."""
        return len(self.states) in (1, self.lanes.count)

    @property
    def slopes(self) -> dict[str, tuple[str, ...]]:
        """Dimensions, after the lane, of the derivatives by the unknowns, by name such as "d(theta)"."""
        if not self.unknowns:
            return {}
        result: dict[str, tuple[str, ...]] = {f"d({name})": ("time", "by") for name in self.outputs.timed}
        result |= {f"d({name})": ("by",) for name in self.outputs.numbers}
        if self.specs:
            result |= {f"d({name})": ("event", "by") for name in ("event_time", "event_last")}
        return {**result, "d(end)": ("by",)}

    @property
    def bytes_per_lane(self) -> int:
        """Memory for the results of one lane."""
        timed = len(self.outputs.timed)
        numbers = 4 * len(self.outputs.reduced) + 3 * len(self.expressions) + 6
        sizes = {"time": self.times.size, "event": len(self.specs), "by": len(self.unknowns)}
        slopes = sum(math.prod(sizes[d] for d in dims) for dims in self.slopes.values())
        return 8 * (self.times.size * timed + numbers + slopes)

    @property
    def texts(self) -> tuple[str, ...]:
        """Names of the results that are texts."""
        if self.looped:
            return ()
        return (*((TIMELINE,) if self.outputs.timeline else ()), REASON)

    @property
    def first_method(self) -> str:
        """The method by which every lane begins; stiff lanes leave it."""
        method = self.request.method
        if self.begin == self.end:
            return "dop853" if method == "auto" else method
        return first_method(self.kernels, method, self.tolerances, batch=True)

    @property
    def most_steps(self) -> int:
        """Number of steps at which a lane ends, the same as for a single run."""
        model = self.kernels.model
        return most_steps(self.request.max_steps, STORED + model.n_q + model.n_u)

    @property
    def over_links(self) -> bool:
        """True if kernels that loop over links run the lanes (`large_trees`)."""
        model, outputs, request = self.kernels.model, self.outputs, self.request
        return (
            is_large(model, "forward_dynamics")
            and request.method in ("auto", "dop853")
            and not (request.method == "auto" and self.tolerances.min() < FINE)
            and not (model.contacts or model.controllers or model.signals or request.struck)
            and not (
                self.unknowns
                or self.specs
                or outputs.reduced
                or any(isinstance(x, str | OfReaction) for x in outputs.timed_values)
            )
            and not self.lanes.varied[0]
            and request.step is None
            and self.begin != self.end
        )

    def wide(self, method: str) -> bool:
        """True if eight lanes run at once: any number of lanes by series, at least eight by stages."""
        return method == "taylor" or (
            method in EXPLICIT and self.kernels.size > 0 and self.begin != self.end and self.count >= WIDTH
        )

    def program(self, method: str) -> BatchProgram:
        """Return the machine code of the lanes for a method."""
        timed, reduced = self.outputs.timed_values, self.outputs.reduced_values
        return batch_program(self.kernels, timed, reduced, self.expressions, method, self.wide(method))

    def results(self, low: int, high: int) -> Results:
        """Return empty results of the lanes ``low`` to ``high`` - 1."""
        result = self.room(low, high)
        result.clear(slice(None))
        return result

    def room(self, low: int, high: int) -> Results:
        """Return room for the results of the lanes ``low`` to ``high`` - 1, all of them waiting.

        Other numbers are not set: memory is taken from the system as lanes are written.
        """
        sizes = {"time": self.times.size, "event": len(self.specs), "by": len(self.unknowns)}
        n, events, outputs = high - low, len(self.expressions), self.outputs
        times = self.times.size if outputs.timed else 0
        status, (steps, rejected, blame) = (
            np.full(n, End.WAITING, dtype=np.int64),
            np.empty((3, n), dtype=np.int64),
        )
        return Results(
            low, high, np.empty((n, times, len(outputs.timed))), np.empty((n, len(outputs.reduced), 4)),
            np.empty((n, events, 2)), np.empty((n, events), dtype=np.int64), status, steps, rejected, blame,
            np.empty(n),
            np.full((n, len(self.texts)), "", dtype=object),
            {name: np.empty((n, *(sizes[d] for d in dims))) for name, dims in self.slopes.items()}, self.begin,
        )  # fmt: skip


def job_of(request: Request, count: int | None = None) -> Job:
    """Return the job of a request for many motions; ``count`` is the number of lanes of a study of which these are
    some.

    Raises
    ------
    FreebodyError
        An argument that a batch cannot use, or values that no lane can have.
    """
    kernels, model, method, threads = request.kernels, request.model, request.method, request.threads
    near, project = request.near, request.project
    check_order(request)
    blows = blows_of(request.impulses)
    if request.executor not in (None, "threads"):
        threads = 1  # of each block, which the executor runs
    if threads is not None and (isinstance(threads, bool) or not isinstance(threads, int) or threads < 1):
        raise SimulationError(f"Expected a number of threads of at least 1, got {threads!r}.")
    lanes = lanes_of(model, request.values or {}, request.initial or {})
    _check_near(model, near)
    begin = _common_time(model, lanes, request.start, "start")
    end = _common_time(model, lanes, request.until, "until")
    times = output_times(request.times, begin, end)
    if times is None:
        number_of_times = SAMPLES if request.samples is None else request.samples
        times = np.linspace(begin, end, number_of_times) if begin != end else np.array([begin])
    if method != "timestepping":
        most = most_steps(request.max_steps, STORED + model.n_q + model.n_u)
        check_steps(begin, end, request.step, request.max_step, most)
    specs = specs_of(request.events)
    expressions = expressions_of(model, specs)
    asked_outputs = outputs_of(model, request.outputs, bool(model.contacts) and method != "timestepping")
    check_signals(model)
    lanes = replace(lanes, columns={**lanes.columns, **at_time(model, {}, begin)})
    _check_bodies(model, lanes, (0, *lanes.suspects()))  # lane 0 tells what is the same in all
    tolerances = tolerances_of(kernels, request.tolerance, method)
    unknowns: tuple[str, ...] = ()
    if request.sensitivities is not None:
        check_derivable(request)
        unknowns = tuple(
            x.name for x in unknowns_of(model, request.sensitivities, lanes.initial_of(0), "sensitivities")
        )
    request = replace(
        request, until=end, start=begin, events=specs, impulses=blows, sensitivities=list(unknowns) or None,
        times=times, samples=None, values=None, initial=None, outputs=None, store=None, threads=None, executor=None,
        progress=False,
    )  # fmt: skip
    one_sided = limits(model)
    specs = (*specs, *(EventSpec(limit.event, limit.event, -1) for limit in one_sided))
    expressions = (*expressions, *(OfLimit(k) for k in range(2 * len(one_sided))))
    job = Job(
        request, kernels, lanes, np.empty((1, 0)), {}, (), begin, end, times, specs, expressions, asked_outputs,
        tolerances, threads or _processors(), False, len(one_sided), lanes.count if count is None else count, unknowns,
    )  # fmt: skip
    if (
        unknowns or model.contacts or model.controllers or blows or not has_lanes(method) or is_large(model)
        or (method == "taylor" and (begin == end or kernels.size == 0)) or job.over_links
        or (model.signals and sides_of(kernels) is not None)
    ):  # fmt: skip
        if method == "timestepping" and "work_rate" in asked_outputs.values:
            raise SimulationError(
                "Expected outputs other than 'work_rate' for method='timestepping', whose contacts do their work in "
                "impulses. Ask for 'work'."
            )
        named_state(
            model, lanes.values_of(0), lanes.initial_of(0)
        )  # refuses names that are unknown in all lanes
        return job
    first = lanes if not model.constraints else lanes.first(FEW)
    try:
        states, no_start, active, apart = first.states(near or {}, begin, project, kernels)
    except SimulationError:
        if first.count == lanes.count:
            raise
        states, no_start, active, apart = lanes.states(near or {}, begin, project, kernels)
    if model.constraints:
        kernels = kernels.holding(active)
    return replace(job, kernels=kernels, states=states, no_start=no_start, apart=apart, looped=True)


def _processors() -> int:
    """Return the number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _check_near(model: Model, near: Any) -> None:
    """Refuse arrays among the guesses, which all lanes share."""
    for name, value in (near or {}).items() if isinstance(near, Mapping) else ():
        if str(name) not in quaternions_by_joint(model) and several(value) is not None:
            raise SimulationError(
                f"Expected one number for '{name}' in near=, the same for all lanes, got {value!r}. What differs from "
                "lane to lane goes into initial=."
            )


def _common_time(model: Model, lanes: Lanes, value: Expression, what: str) -> float:
    """Return a time, which must be the same in all lanes."""
    if np.ndim(value) > 0:
        raise SimulationError(
            f"Expected one number for {what}, the same for all lanes, got an array of shape {np.shape(value)}. "
            "A terminal event ends each lane at a time of its own."
        )
    first, *others = (number(model, lanes.values_of(k), value, what) for k in lanes.extremes)
    if any(x != first for x in others):
        raise SimulationError(
            f"Expected {what} to be the same for all lanes, but '{value}' depends on parameters that differ."
        )
    return first


def _check_bodies(model: Model, lanes: Lanes, suspects: Iterable[int]) -> None:
    """Refuse impossible bodies, and values that contradict an assumption, and name the lane."""
    for lane in suspects:
        try:
            check_bodies(model, lanes.values_of(lane))
            check_assumptions(model, lanes.values_of(lane))
        except ModelError as error:
            raise type(error)(f"Lane {lane}: {error}" if lanes.count > 1 else str(error)) from None


def check_memory(job: Job) -> None:
    """Refuse results that this computer cannot hold, before anything is computed."""
    size = job.bytes_per_lane * job.count
    if size > largest_memory():
        raise SimulationError(
            f"Expected results that fit into memory, but {job.count} lanes of {len(job.outputs.timed)} outputs "
            f'at {job.times.size} times take {size / 2**30:.3g} GiB. Pass store="lanes.nc", which writes them to a '
            "file as they come, or ask for fewer outputs= or times=."
        )
