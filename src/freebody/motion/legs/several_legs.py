"""The motion of a machine in several legs: between blows, while signals and controllers keep their constants, and while
the same conditions are independent.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..ending import FAILED
from ..kernels.kernels import Kernels
from ..kernels.methods import first_method
from ..kernels.sided_way import way_of
from ..ode import loops
from ..ode.dense_output import Array, Path, Rates, Watch
from ..ode.integration import Halt
from ..request import Problem, Request, problem_of
from ..trajectory.event import Happening, expressions_of, watching
from ..trajectory.in_legs import InLegs
from ..trajectory.phases import Phases, joined
from ..trajectory.progress import Progress
from ..trajectory.trajectory import Trajectory
from .blow import Blow, blows_of, struck_path, watching_specs
from .driven import Drives, driven_path
from .failure import failure
from .independent_conditions import Holding, check_redundant


def motion_in_legs(request: Request) -> Trajectory:
    """Return the motion of a machine without contacts, with blows, signals or controllers.

    Raises
    ------
    SimulationError
        A motion that cannot be continued.
    """
    problem = problem_of(request)
    with problem.progress() as between:
        return legs_of(problem, between, blows_of(request.impulses))


def legs_of(
    problem: Problem, between: Progress, blows: tuple[Blow, ...] = (), finer: bool = False
) -> Trajectory:
    """Return the motion in legs; with ``finer`` steps before a singular position keep a part of the tolerance."""
    p, kernels = problem, problem.kernels
    legs = _Legs(problem, between, blows)
    if finer and legs.conditions.crossing is not None:
        legs.conditions.crossing.refine()
    happenings: tuple[Happening, ...] = ()
    path: Path | Phases
    if blows:
        path, happenings = struck_path(problem, legs.advance, legs.state, blows)
    else:
        path = legs.advance(legs.state, p.begin, p.end)
    sense = 1.0 if p.end >= p.begin else -1.0
    in_order = sorted(
        (*happenings, *legs.conditions.happenings), key=lambda happening: sense * happening.time
    )
    trajectory = Trajectory(*p.outcome(path), course=InLegs(tuple(in_order)))
    if path.status in FAILED:
        raise failure(trajectory, path, legs.conditions.current, p.end, legs.specs)
    if kernels.model.constraints:
        check_redundant(trajectory)
    return trajectory


def with_work(problem: Problem, rates: Rates) -> tuple[Array, Array]:
    """Return the state at the start and its absolute tolerances, with the work if it is a component of the state.

    The tolerance of the work is multiplied by the energy at the start.
    """
    kernels, tolerances = problem.kernels, problem.tolerances
    if not kernels.works:
        return problem.state, tolerances
    state = np.append(problem.state, 0.0)
    # the energy is observed by the loop of the method, so that no other loop is compiled
    loops.use(first_method(kernels, problem.request.method, tolerances), bool(problem.specs))
    energies = loops.observed(kernels.motion().address("energy"), 2, problem.begin, state, rates.constants_at)
    energy = max(map(abs, energies))
    absolute = tolerances.copy()
    absolute[-1] *= energy if energy > 0 and all(map(math.isfinite, energies)) else 1.0
    return state, absolute


class _Legs:
    """Legs of a motion, each by the method that is asked for, with the steps that remain.

    ``conditions``   independent conditions in the course of the motion
    ``specs``        events of the user and, after them, those that call for a blow
    """

    def __init__(self, problem: Problem, between: Progress, blows: tuple[Blow, ...]) -> None:
        p, kernels, request = problem, problem.kernels, problem.request
        self.problem, self.between = problem, between
        self.parameters, self.rates = kernels.at(p.numbers)
        self.state, self.absolute = with_work(problem, self.rates)
        self.specs = watching_specs(kernels, p.specs, blows)
        expressions = expressions_of(kernels.model, self.specs)
        self.watch: Watch | None = watching(kernels, self.parameters, self.specs, expressions)
        self.remaining_steps = p.most_steps
        finest = float(p.tolerances.min(initial=1.0)) if request.step is None else None
        self.conditions = Holding(kernels, finest, request.method)
        self.drives = (
            Drives(kernels, p.numbers, p.begin, p.end, p.most_steps) if kernels.model.switched else None
        )

    def advance(self, state: Array, start: float, until: float, work: float = 0.0) -> Path | Phases:
        """Return the path from a state, until a terminal event at most; ``work`` is that of blows until then."""
        if self.drives is None:
            return self.leg(self.parameters, self.rates, state, start, until, work, watch=self.watch)
        return driven_path(self.drives, self.leg, self.rates, self.watch, state, start, until, work)

    def leg(
        self, parameters: Array, rates: Rates, state: Array, start: float, until: float, work: float = 0.0, *,
        method: str | None = None, **options: Any,
    ) -> Path | Phases:  # fmt: skip
        """Return the path from a state with these values of the parameters, while the conditions may change."""
        part = _Part(self, parameters, method or self.problem.request.method, work, options)
        watched = options.get("watch") is not None
        return self.conditions.path(part, parameters, rates, state, start, until, work, watched)


@dataclass(frozen=True, eq=False)
class _Part:
    """Part of a leg in which the same conditions are independent.

    ``method``    method of ordinary steps
    ``work``      work of blows until now
    ``options``   further arguments of `Way`
    """

    legs: _Legs
    parameters: Array
    method: str
    work: float = 0.0
    options: Mapping[str, Any] = field(default_factory=dict)

    def __call__(
        self, kernels: Kernels, rates: Rates, state: Array, start: float, until: float, halt: Halt | None,
        method: str | None = None, watched: bool = True,
    ) -> Path | Phases:  # fmt: skip
        """Return the path from a state."""
        legs, request = self.legs, self.legs.problem.request
        step, finer = request.step, legs.conditions.finer
        longest = min(request.longest_step, legs.conditions.longest)
        if method is not None:  # across a position in which conditions are dependent: one step
            step, longest, finer = abs(until - start), math.inf, 1.0
        options = self.options if watched else {**self.options, "watch": None}
        way = way_of(
            kernels, self.parameters, method or self.method, rates, finer * legs.problem.tolerances, step=step,
            max_step=longest, max_steps=legs.remaining_steps, **options,
        )  # fmt: skip
        paths = way.paths(state, start, until, finer * legs.absolute, legs.between, halt)
        path = joined(paths, kernels, self.work)
        legs.remaining_steps -= path.steps
        return path
