"""One motion of a machine: its arguments are read and checked once, then one of five ways computes it.

sensitivities   the motion and its derivatives               (`legs.sensitivity`)
time steps      equal steps of Moreau and Jean               (`timestepping`)
contacts        phases between events of contacts            (`contact.motion`)
one leg         a run without interruption
several legs    blows, signals, controllers, or independent conditions that change on the way
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import SimulationError
from ..scalar.algebra import Expression
from .kernels.kernels import Kernels, kernels_of
from .kernels.methods import Way, check_method, check_method_of_contacts, first_method
from .legs.blow import Blow, blows_of, struck_path, watching_blows, watching_specs
from .legs.branch import meeting, meets
from .legs.driven import Drives, at_time, check_signals, driven_path, refuse_switched
from .legs.failure import failure
from .legs.independent_conditions import Holding, check_redundant
from .ode import dense_output as runs
from .ode import layout, loops
from .ode.dense_output import Array, Path, Rates, Watch
from .ode.integration import Halt
from .start.arguments import (
    STORED,
    check_heeded,
    check_numbers,
    check_steps,
    most_steps,
    output_times,
    tolerances_of,
)
from .start.initial import initial_state, number
from .start.loop_closure import closed_start
from .trajectory.event import EventSpec, Happening, expressions_of, specs_of, watching
from .trajectory.phased_trajectory import PhasedTrajectory
from .trajectory.phases import Phases
from .trajectory.progress import Progress
from .trajectory.trajectory import Trajectory


@dataclass(frozen=True, eq=False, slots=True)
class Request:
    """One motion to compute: arguments of :func:`freebody.simulate`, read and checked.

    ``kernels``      programs of the machine, with the conditions that are independent at the start
    ``numbers``      value of every parameter, by name
    ``state``        (q, u) at ``begin``
    ``specs``        events, and ``expressions``, what they watch
    ``tolerances``   relative tolerance of each component of the state
    ``times``        output times, or None; ``samples`` their number, or None
    ``most_steps``   number of steps at which the run ends with an error
    """

    kernels: Kernels
    numbers: Mapping[str, float]
    state: Array
    begin: float
    end: float
    specs: tuple[EventSpec, ...]
    expressions: tuple[Expression, ...]
    tolerances: Array
    times: Array | None
    samples: int | None
    method: str
    step: float | None
    max_step: float | None
    max_steps: int | None
    most_steps: int
    impulses: Any


def single_motion(
    machine: Any,
    until: Expression,
    *,
    initial: Mapping[Any, Any] | None = None,
    near: Mapping[Any, Any] | None = None,
    project: bool = False,
    values: Mapping[Any, Any] | None = None,
    tolerance: float | Mapping[Any, float] = 1e-9,
    events: Any = (),
    impulses: Any = (),
    impacts: str = "simultaneous",
    indeterminate: str = "compliance",
    method: str = "auto",
    step: float | None = None,
    times: ArrayLike | None = None,
    samples: int | None = None,
    start: Expression = 0,
    max_step: float | None = None,
    max_steps: int | None = None,
    progress: bool | Callable[[float], Any] | None = None,
    sensitivities: Any = None,
) -> Trajectory:
    """Return one motion of a System or a Model; arguments as of :func:`freebody.simulate`."""
    kernels = kernels_of(machine)
    model = kernels.model
    if model.contacts and method != "timestepping":
        check_method_of_contacts(method, step)
    check_method(method, step)
    check_numbers(samples, max_step, max_steps, 1 + model.n_q + model.n_u)
    check_heeded(
        model, method, near=near, project=project, tolerance=tolerance, max_step=max_step, max_steps=max_steps,
        impacts=impacts, indeterminate=indeterminate,
    )  # fmt: skip
    numbers: Mapping[str, float] = kernels.values(values)
    begin = number(model, numbers, start, "start")
    numbers = at_time(model, numbers, begin)
    kernels.check(numbers)
    end = number(model, numbers, until, "until")
    if times is not None and samples is not None:
        raise SimulationError("Expected times= or samples=, got both. Leave one out.")
    most = most_steps(max_steps, STORED + model.n_q + model.n_u)
    if method != "timestepping":
        check_steps(begin, end, step, max_step, most)
    moments = output_times(times, begin, end)
    specs = specs_of(events)
    expressions = expressions_of(model, specs)
    check_signals(model)
    if model.constraints:
        state, active = closed_start(
            kernels, numbers, {} if initial is None else initial, near or {}, begin, bool(project)
        )
        kernels = kernels.holding(active)
    else:
        state = initial_state(model, numbers, {} if initial is None else initial)
    tolerances = tolerances_of(kernels, tolerance, method)
    request = Request(
        kernels, numbers, state, begin, end, specs, expressions, tolerances, moments, samples, method, step, max_step,
        max_steps, most, impulses,
    )  # fmt: skip
    with Progress(begin, end, progress) as between:
        if sensitivities is not None:
            return _sensitive_motion(
                request, sensitivities, initial or {}, near or {}, project, (start, until), between
            )
        if method == "timestepping":
            return _stepped_motion(request, between)
        if model.contacts:
            return _touching_motion(request, impacts, indeterminate, between)
        return _smooth_motion(request, between)


def _sensitive_motion(
    request: Request, unknowns: Any, initial: Mapping[Any, Any], near: Mapping[Any, Any], project: bool,
    moments: tuple[Expression, Expression], between: Progress,
) -> Trajectory:  # fmt: skip
    from .legs.sensitivity import check_sensitive, sensitive_motion

    r = request
    check_sensitive(r.kernels.model, r.method, project, r.impulses)
    trajectory = sensitive_motion(
        r.kernels, r.numbers, unknowns, initial, near, r.state, r.begin, r.end, r.specs, r.expressions, r.tolerances,
        r.times, r.samples, moments=moments, method=r.method, step=r.step, max_step=r.max_step, max_steps=r.max_steps,
        between=between,
    )  # fmt: skip
    if trajectory.path.status in runs.FAILED:
        raise failure(trajectory, trajectory.path, r.kernels, r.end, r.specs)
    return trajectory


def _stepped_motion(request: Request, between: Progress) -> Trajectory:
    from .timestepping.timestepping import stepped_motion

    r = request
    refuse_switched(r.kernels.model, 'method="timestepping"')
    return stepped_motion(
        r.kernels, r.numbers, r.state, r.begin, r.end, r.specs, r.expressions, r.tolerances, r.times, r.samples,
        step=r.step, max_steps=r.max_steps, impulses=r.impulses, between=between,
    )  # fmt: skip


def _touching_motion(request: Request, impacts: str, indeterminate: str, between: Progress) -> Trajectory:
    from .contact.motion import touching_motion

    r = request
    refuse_switched(r.kernels.model, "a machine with contacts")
    return touching_motion(
        r.kernels, r.numbers, r.state, r.begin, r.end, r.specs, r.expressions, r.tolerances, r.times, r.samples,
        order=impacts, indeterminate=indeterminate, method=r.method, max_step=r.max_step, max_steps=r.most_steps,
        impulses=r.impulses, between=between,
    )  # fmt: skip


def _smooth_motion(request: Request, between: Progress) -> Trajectory:
    """The motion of a machine without contacts, in one leg if it can be."""
    kernels, state = request.kernels, request.state
    parameters, rates = kernels.at(request.numbers)
    blows = blows_of(request.impulses)
    absolute = request.tolerances
    if kernels.works:
        state = np.append(state, 0.0)
        absolute = _absolute_tolerances(request, state, rates)
    in_one_leg = not (blows or kernels.model.switched or kernels.dropped)
    if in_one_leg:
        trajectory = _motion_in_one_leg(request, parameters, rates, state, absolute, between)
        if trajectory is not None:
            return trajectory
    legs = _Legs(request, blows, parameters, rates, absolute, between)
    if in_one_leg and legs.conditions.crossing is not None:
        legs.conditions.crossing.refine()
    return _motion_in_legs(request, blows, state, legs)


def _absolute_tolerances(request: Request, state: Array, rates: Rates) -> Array:
    """The tolerances, that of the work multiplied by the energy at the start."""
    kernels, tolerances = request.kernels, request.tolerances
    # the energy is observed by the loop of the method, so that no other loop is compiled
    loops.use(first_method(kernels, request.method, tolerances))
    energies = loops.observed(kernels.motion().address("energy"), 2, request.begin, state, rates.constants_at)
    energy = max(map(abs, energies))
    result = tolerances.copy()
    result[-1] *= energy if energy > 0 and all(map(math.isfinite, energies)) else 1.0
    return result


def _motion_in_one_leg(
    request: Request, parameters: Array, rates: Rates, state: Array, absolute: Array, between: Progress
) -> Trajectory | None:
    """The motion in one leg; None if it comes near a position that one leg does not pass (`legs.branch`)."""
    r, kernels = request, request.kernels
    way = Way(
        kernels, parameters, r.method, rates, r.tolerances, step=r.step, max_step=_longest(r), max_steps=r.most_steps,
        watch=watching(kernels, parameters, r.specs, r.expressions),
    )  # fmt: skip
    passing = kernels.active and r.step is None
    halt = meeting(kernels, rates) if passing and kernels.size >= layout.MANY_COMPONENTS else None
    path = way.path(state, r.begin, r.end, absolute, between, halt)
    if passing and (
        path.status == runs.RELEASED or meets(kernels, rates, path.times, path.states, path.method)
    ):
        return None
    trajectory = Trajectory(kernels, r.numbers, path, r.specs, r.tolerances, r.times, r.samples)
    if path.status in runs.FAILED:
        raise failure(trajectory, path, kernels, r.end, r.specs)
    return trajectory


def _motion_in_legs(request: Request, blows: tuple[Blow, ...], state: Array, legs: _Legs) -> Trajectory:
    r, kernels = request, request.kernels
    happenings: tuple[Happening, ...] = ()
    path: Any
    if blows:
        path, happenings = struck_path(
            kernels, r.numbers, legs.advance, state, r.begin, r.end, r.specs, blows
        )
    else:
        path = legs.advance(state, r.begin, r.end)
    arguments = (kernels, r.numbers, path, r.specs, r.tolerances, r.times, r.samples)
    trajectory: Trajectory
    if isinstance(path, Phases):
        sense = 1.0 if r.end >= r.begin else -1.0
        in_order = sorted(
            (*happenings, *legs.conditions.happenings), key=lambda happening: sense * happening.time
        )
        trajectory = PhasedTrajectory(*arguments, happenings=in_order)
    else:
        trajectory = Trajectory(*arguments)
    if path.status in runs.FAILED:
        raise failure(trajectory, path, legs.conditions.current, r.end, legs.specs)
    if kernels.model.constraints:
        check_redundant(trajectory)
    return trajectory


def _longest(request: Request) -> float:
    return math.inf if request.max_step is None else float(request.max_step)


class _Legs:
    """Legs of a motion, each by the method that is asked for, with the steps that remain.

    ``conditions``   independent conditions in the course of the motion
    ``specs``        events of the user and, after them, those that call for a blow
    """

    def __init__(
        self, request: Request, blows: tuple[Blow, ...], parameters: Array, rates: Rates, absolute: Array,
        between: Progress,
    ) -> None:  # fmt: skip
        r, kernels = request, request.kernels
        self.request, self.parameters, self.rates = request, parameters, rates
        self.absolute, self.between = absolute, between
        self.specs = watching_specs(kernels, r.specs, blows)
        self.watch: Watch | None = watching_blows(kernels, parameters, r.specs, blows)
        self.remaining_steps = r.most_steps
        finest = float(r.tolerances.min(initial=1.0)) if r.step is None else None
        self.conditions = Holding(kernels, finest, r.method)
        self.drives = (
            Drives(kernels, r.numbers, r.begin, r.end, r.most_steps) if kernels.model.switched else None
        )

    def advance(self, state: Array, start: float, until: float, work: float = 0.0) -> Path | Phases:
        """The path from a state, until a terminal event at most; ``work`` is that of blows until then."""
        if self.drives is None:
            return self.leg(self.parameters, self.rates, state, start, until, work, watch=self.watch)
        return driven_path(
            self.drives, self.leg, self.rates, self.watch, self.specs, state, start, until, work
        )

    def leg(
        self, parameters: Array, rates: Rates, state: Array, start: float, until: float, work: float = 0.0, *,
        method: str | None = None, **options: Any,
    ) -> Path | Phases:  # fmt: skip
        """The path from a state with these values of the parameters, while the conditions may change."""
        r, usual = self.request, method or self.request.method

        def part(
            kernels: Kernels, rates: Rates, state: Array, start: float, until: float, halt: Halt | None,
            method: str = usual, watched: bool = True,
        ) -> Path:  # fmt: skip
            step, finer = r.step, self.conditions.finer
            longest = min(_longest(r), self.conditions.longest)
            if method != usual:  # across a position in which conditions are dependent: one step
                step, longest, finer = abs(until - start), math.inf, 1.0
            watch = options if watched else {**options, "watch": None}
            way = Way(
                kernels, parameters, method, rates, finer * r.tolerances, step=step, max_step=longest,
                max_steps=self.remaining_steps, **watch,
            )  # fmt: skip
            path = way.path(state, start, until, finer * self.absolute, self.between, halt)
            self.remaining_steps -= path.steps
            return path

        watched = options.get("watch") is not None
        return self.conditions.path(part, parameters, rates, state, start, until, work, watched)
