"""The motion of a machine in one leg: a run without interruption.

A machine with constraints that comes near a position in which its conditions are dependent (`branch`) goes on in
several legs.
"""

from __future__ import annotations

import contextlib
from typing import Any

from ..ending import FAILED, End
from ..kernels.methods import Way
from ..kernels.sided_way import way_of
from ..kernels.switches import switches
from ..ode import layout, loops
from ..ode.dense_output import Rates
from ..request import Problem, Request, problem_of
from ..trajectory.event import watching
from ..trajectory.in_legs import ONE_LEG
from ..trajectory.phases import joined
from ..trajectory.progress import Progress
from ..trajectory.trajectory import Trajectory
from .branch import meeting, meets
from .failure import failure, massless
from .several_legs import legs_of, with_work

SEVERAL = 5
"""Number of bodies from which the method "auto" begins with "dop853" as a rule, and compiling takes a while."""


def motion_in_one_leg(request: Request) -> Trajectory:
    """Return the motion of a machine without contacts, signals, controllers and blows.

    Raises
    ------
    SimulationError
        A motion that cannot be continued.
    """
    several = len(request.model.bodies) >= SEVERAL
    method = "dop853" if request.method == "auto" else request.method
    with loops.ahead(method, _watched(request)) if several else contextlib.nullcontext():
        problem = problem_of(request)
    with problem.progress() as between:
        if problem.kernels.dropped:
            return legs_of(problem, between)
        trajectory = _in_one_leg(problem, between)
        return legs_of(problem, between, finer=True) if trajectory is None else trajectory


def _watched(request: Request) -> bool:
    """Return whether the run will have event functions."""
    none = isinstance(request.events, tuple | list) and not request.events
    return not none or bool(switches(request.model))


def _in_one_leg(problem: Problem, between: Progress) -> Trajectory | None:
    """Return the motion; None if it comes near a position that one leg does not pass."""
    p, request, kernels = problem, problem.request, problem.kernels
    parameters, rates = kernels.at(p.numbers)
    state, absolute = with_work(problem, rates)
    way = _way(problem, parameters, rates)
    passing = kernels.active and request.step is None
    halt = meeting(kernels, rates) if passing and kernels.size >= layout.MANY_COMPONENTS else None
    path = joined(way.paths(state, p.begin, p.end, absolute, between, halt), kernels)
    if passing and (
        path.status == End.RELEASED or meets(kernels, rates, path.times, path.states, path.method)
    ):
        return None
    trajectory = Trajectory(*p.outcome(path), course=ONE_LEG).begun(request.initial, request.near)
    if path.status in FAILED:
        raise failure(trajectory, path, kernels, p.end, p.specs)
    return trajectory


def _way(problem: Problem, parameters: Any, rates: Rates) -> Way:
    """Return the way of a run; that of the last run with the same numbers and options serves again."""
    p, request, kernels = problem, problem.request, problem.kernels
    options = request.method, request.tolerance, request.longest_step, p.most_steps
    again = not p.specs and request.step is None and isinstance(request.tolerance, float)
    way: Way | None = rates.ways.get(options) if again else None
    if way is None:
        way = way_of(
            kernels, parameters, request.method, rates, p.tolerances, step=request.step,
            max_step=request.longest_step, max_steps=p.most_steps,
            watch=watching(kernels, parameters, p.specs, p.expressions),
            stalls=lambda t, y: bool(massless(kernels, p.numbers, t, y)),
        )  # fmt: skip
        if again:
            rates.ways.clear()
            rates.ways[options] = way
    return way
