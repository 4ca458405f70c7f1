"""Simulation of a machine with contacts, from the initial state to the trajectory."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...describe.contacts.normal_law import first_forces, refuse_pull
from ...errors import SimulationError, nearest
from ...model.family import contact_laws
from ..ending import FAILED, End
from ..events.event_run import ORDERS
from ..legs.blow import blows_of, scheduled
from ..legs.failure import failure
from ..phase.scene import scene_of
from ..request import Problem, Request, problem_of
from ..start.arguments import check_forwards
from ..start.initial import number
from ..trajectory.progress import Progress
from ..trajectory.trajectory import Trajectory
from .course import Touching
from .history import History
from .refusals import dynamic_jam, flat
from .run import run
from .state import CHOICES, ContactRun


def touching_motion(request: Request) -> Trajectory:
    """Return the motion of a machine with contacts.

    Raises
    ------
    SimulationError
        For impossible coefficients, initial states with bodies inside each other, Painlevé's paradoxes, and all that
        `simulate` refuses.
    """
    problem = problem_of(request)
    with problem.progress() as between:
        return touching_motion_of(problem, between)[0]


def touching_motion_of(problem: Problem, between: Progress, sided: bool = True) -> tuple[Trajectory, History]:
    """Return the motion of a problem, and its history; with ``sided`` it is located where laws of loads switch."""
    p, request, kernels, model = problem, problem.request, problem.kernels, problem.model
    check_order(request)
    if request.indeterminate not in CHOICES:
        raise SimulationError(
            "Expected indeterminate='compliance' (the limit of equal compliance) or 'refuse', got "
            f"{request.indeterminate!r}."
        )
    check_forwards(p.begin, p.end, "a machine with contacts", "friction and impacts")
    scene = scene_of(kernels)
    if scene.checked != p.numbers:
        check_coefficients(model, p.numbers)
        scene.checked = dict(p.numbers)
    timed, called = scheduled(kernels, p.numbers, blows_of(request.impulses), p.begin, p.end)
    n = model.n_q + model.n_u
    relative = np.concatenate([p.tolerances[:n], [p.tolerances[:n].max(initial=1e-12)] * 2])
    absolute = relative.copy()
    work = ContactRun.of(p, relative, absolute, timed, called, sided)
    try:
        status = run(work, p.state[:n], p.begin, p.end, between)
    except SimulationError as error:
        if work.it.phases and getattr(error, "trajectory", None) is None:
            error.trajectory = _trajectory(problem, History(work, End.BROKEN_OFF))  # type: ignore[attr-defined]
        raise
    history = History(work, status)
    jam = dynamic_jam(work) if status in (End.COLLAPSED, End.NOT_FINITE) else ""
    work.give_back()
    trajectory = _trajectory(problem, history)
    if status in FAILED:
        why = failure(trajectory, history.path, kernels, p.end, work.specs)
        if jam:
            why.args = (jam,)
        elif status == End.COLLAPSED:
            modes = history.path.segments[-1].modes
            why.args = (f"{why}{flat(work, [k for k, mode in enumerate(modes) if mode != 'open'])}",)
        raise why
    return trajectory, history


def check_order(request: Request) -> None:
    """Refuse an order of impacts that does not exist."""
    if request.impacts not in ORDERS:
        raise SimulationError(
            f"Unknown order of impacts {request.impacts!r}; {nearest(str(request.impacts), ORDERS)}"
        )


def _expect(holds: bool, expected: str, value: float) -> None:
    """Refuse a number for which a condition does not hold."""
    if not holds:
        raise SimulationError(f"Expected {expected}, got {value:g}.")


def _trajectory(problem: Problem, history: History) -> Trajectory:
    request = problem.request
    trajectory = Trajectory(*problem.outcome(history.path), course=Touching(history))
    return trajectory.begun(request.initial, request.near)


def check_coefficients(model: Any, values: Mapping[str, float]) -> None:
    """Raise unless the coefficients of friction and restitution are in their ranges."""
    for c in contact_laws(model):
        for name in ("radius", "length") if c.loaded else ():
            given = getattr(c.law, name)
            size = (
                1.0 if given is None else number(model, values, given, f"the {name} of friction '{c.name}'")
            )
            _expect(size > 0, f"{name}= above 0 m for friction '{c.name}'", size)
        laws = (c.friction_at_rest, c.static_friction)
        if c.presser:
            law: Any = c.law
            length = number(model, values, c.friction, f"{law.about}= of contact '{c.owner}'")
            _expect(length >= 0, f"{law.about}= of 0 m or more for contact '{c.owner}'", length)
            continue
        varies = any(model.names.depends(law, "coordinate", "speed", "time") for law in laws)
        words = (f"the {kind} of contact '{c.name}'" for kind in ("friction", "static friction"))
        mu, static = (
            (0.0, 0.0) if varies else (number(model, values, *law) for law in zip(laws, words, strict=True))
        )
        if c.slows and static == 0 and not varies:
            raise SimulationError(
                f"Expected a friction of contact '{c.name}' above 0 at rest, since it depends on slip; got 0 at "
                f"slip = 0. A force that grows from 0 with the speed is a damper."
            )
        if c.compliant and not model.names.depends(c.normal_force, "coordinate", "speed", "time"):
            what = f"contact '{c.name}'"
            first = [
                number(model, values, x, f"the normal force of {what}") for x in first_forces(c.normal_force)
            ]
            refuse_pull(first, c.normal_force, what, SimulationError)
        e = number(model, values, c.restitution, f"the restitution of contact '{c.name}'")
        pull = number(model, values, c.adhesion, f"the adhesion of contact '{c.name}'")
        across = (
            number(model, values, c.coefficients[1], "a friction") if c.friction_across is not None else 1.0
        )
        if c.friction_across is not None and not (mu > 0 and across > 0):
            raise SimulationError(
                f"Expected two coefficients of friction above 0 of contact '{c.name}', got {mu:g} and {across:g}."
            )
        of = f"of contact '{c.name}'"
        _expect(pull >= 0, f"an adhesion {of} of at least 0 N", pull)
        _expect(mu >= 0, f"a friction {of} of at least 0", mu)
        _expect(static >= mu, f"a static friction {of} of at least the kinetic one, {mu:g}", static)
        _expect(0 <= e <= 1, f"a restitution {of} from 0 (no rebound) to 1 (no loss)", e)
