"""The error of a run that could not continue: the time, the cause, and the cure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...describe.loads.action import Action, Couple, PointForce
from ...dynamics.conditions.constraints import rows
from ...dynamics.conditions.contact import friction_coefficient
from ...dynamics.conditions.mobility import massless_motion
from ...dynamics.loads.actions import actions
from ...dynamics.state import State, state_at
from ...errors import ModelError, SimulationError
from ..ending import End
from ..kernels.contact_quantities import OfContacts
from ..kernels.kernels import Kernels
from ..kernels.sides import sides_of
from ..ode.dense_output import Array, Rates
from ..ode.layout import EXPLICIT
from ..start.loop_closure import nearly_dependent
from ..trajectory.event import EventSpec, expressions_of
from ..trajectory.path import SampledPath
from ..trajectory.phases import Phases
from ..trajectory.trajectory import Trajectory
from .independent_conditions import taking_over

OF_EVENTS = (End.UNDEFINED, End.UNRESOLVED)
"""Ends for which an event is to blame."""
MOVING = ("coordinate", "speed", "time")
NEGLIGIBLE = 1e-6
"""Coefficient of friction, relative to 1 + μ_s, that counts as zero where a motion ends by it."""


def culprit(path: SampledPath, kernels: Kernels) -> int:
    """Return the component, or event, that stopped a run.

    For the work, which follows from the motion, and for the length of a series, which depends on all components, it is
    the speed that changes fastest.
    """
    if path.status in OF_EVENTS:
        return path.blame
    reported = path.blame if path.method != "taylor" or path.status == End.NOT_FINITE else None
    return to_blame(kernels, reported, path.rates, path.end, path.states[-1])


def to_blame(kernels: Kernels, reported: int | None, rates: Rates, t: float, y: Array) -> int:
    """Return the component that stopped a run at a state; ``reported`` is that of the method, if it knows one."""
    n_q, n_u = kernels.model.n_q, kernels.model.n_u
    if reported is not None and reported < n_q + n_u:
        return reported
    if not n_u:
        return 0
    derivative = rates.at(t, y)
    fast = np.abs(derivative[n_q : n_q + n_u]) / (1 + np.abs(y[n_q : n_q + n_u]))
    return n_q + int(np.argmax(np.where(np.isfinite(fast), fast, math.inf)))


def _last_state(path: SampledPath, kernels: Kernels, trajectory: Trajectory) -> State:
    """Return the last good state."""
    return state_at(kernels.model, path.states[-1], path.end, trajectory.numbers)


def _loads_without_value(path: SampledPath, kernels: Kernels, trajectory: Trajectory) -> str:
    """Return the sentence about loads whose force is not finite at the last state, such as a slip at rest."""
    model, state, names = kernels.model, _last_state(path, kernels, trajectory), []
    for name in model.loads:
        try:
            forces = actions(model, state, name)
            finite = all(math.isfinite(float(x)) for action in forces for x in _numbers(action))
        except (ModelError, ArithmeticError, ValueError):
            finite = False
        if not finite:
            names.append(f"'{name}'")
    return f" In the last good state {' and '.join(names)} has no finite value." if names else ""


def _negative_friction(path: SampledPath, kernels: Kernels, trajectory: Trajectory) -> str:
    """Return the sentence about laws of friction that reach zero at the last state, up to the length of a step, or
    have no value there.
    """
    state, model = _last_state(path, kernels, trajectory), kernels.model
    falling, undefined = [], []
    for c in model.contacts:
        if not (c.slows or model.names.depends(c.friction, *MOVING)):
            continue
        try:
            if not friction_coefficient(model, state, c) > NEGLIGIBLE * (1 + state(c.static_friction)):
                falling.append(f"'{c.name}'")
        except (ArithmeticError, ValueError):
            undefined.append(f"'{c.name}'")
    text = ""
    if falling:
        laws = f"The friction of contact {' and '.join(falling)} falls to 0 there, and friction below 0 would drive."
        text += f" {laws} Write a law that stays above 0."
    if undefined:
        laws = f"The friction of contact {' and '.join(undefined)} has no value there."
        text += f" {laws} Write a law that has one wherever the contact is closed."
    return text


def _numbers(action: Action) -> Sequence[Any]:
    """Return the components of an action."""
    match action:
        case PointForce(_, vector) | Couple(_, vector):
            return vector
        case _:
            return (action.value,)


def massless(kernels: Kernels, values: Mapping[str, float], t: float, y: Array) -> tuple[str, ...]:
    """Return the speeds that together move no mass at a state."""
    return massless_motion(kernels.model, state_at(kernels.model, y, t, values))


def _singular(path: SampledPath, kernels: Kernels, trajectory: Trajectory) -> str:
    """Return the sentence about constraints that are dependent where the step collapsed; empty if none are.

    Other conditions that could take over have done so, except in runs with derivatives.
    """
    better = taking_over(kernels, kernels.parameters(trajectory.numbers), path.end, path.states[-1])
    if better != kernels.active and trajectory.course.derivatives is not None:
        conditions = [row.name for row in rows(kernels.model)]
        lost, gained = (
            " and ".join(repr(conditions[i]) for i in these if i not in those)
            for these, those in ((kernels.active, better), (better, kernels.active))
        )
        return (
            f" The machine can move on, but {lost}, active from the start, becomes dependent on other conditions "
            f"there, and {gained} must take over, which derivatives do not follow. Leave out sensitivities=, or end "
            "before."
        )
    names = nearly_dependent(kernels.model, _last_state(path, kernels, trajectory), kernels.active)
    if not names:
        return ""
    return (
        f" The machine locks up there, or could go on in more ways than one: {' and '.join(map(repr, names))} "
        f"{'becomes' if len(names) == 1 else 'become'} dependent, as where bars come into line. Stop before with a "
        "terminal event, or change the lengths; a machine that passes such positions does with steps of one length, "
        "step=, too."
    )


def _undefined(trajectory: Trajectory, path: SampledPath, kernels: Kernels, spec: EventSpec) -> str:
    (expression,) = expressions_of(kernels.model, (spec,))
    last = path.segments[-1].path if isinstance(path, Phases) else path
    if last.steps == 0 and isinstance(expression, OfContacts):
        return (
            f"expected a number for event '{spec.name}' at t = {path.end:.9g} s, where it begins. A division by a "
            "force or slip that is zero does this: watch what passes through zero itself, or start elsewhere."
        )
    if last.steps == 0:
        program = kernels.expressions((expression,))
        (value,) = trajectory._observed(program, "values", path.times[-1:], path.states[-1:])[0]
        return (
            f"expected a number for event '{spec.name}' at t = {path.end:.9g} s, where it begins, got {value:g} for "
            f"{expression}. A division by zero, or a root or logarithm of a negative number, does this: watch what "
            "passes through zero itself, or start elsewhere."
        )
    return (
        f"event '{spec.name}' has no value just after t = {path.end:.9g} s: expected a number for {expression}, got "
        "nan. A root or logarithm of a negative number, or 0/0, does this: watch its argument, or stop before "
        "with a terminal event."
    )


def _stuck(path: SampledPath, kernels: Kernels) -> str:
    sides = sides_of(kernels)
    assert sides is not None
    e = sides.laws[path.blame].text
    return (
        f"it sticks at t = {path.end:.9g} s, where {e} = 0: a law with sign({e}) drives it back from either side, and "
        "states no force that holds it there. Friction that holds is that of a joint, s.friction(..., force=F) or "
        "torque=T, or of a contact, s.contact(..., friction=mu). "
        f"Or give the jump a width of your choice, tanh(({e})/width), or stop there with a terminal event."
    )


_MODES = 200
"""Greatest number of components for which the fastest motion is sought."""


def _fastest(path: SampledPath, kernels: Kernels) -> str:
    """Return the sentence about the fastest motion near the last state, by the eigenvalues of the rates' derivative."""
    n = kernels.model.n_q + kernels.model.n_u
    if not 0 < n <= _MODES:
        return ""
    y = path.states[-1]
    steps = 6e-6 * (1 + np.abs(y[:n]))  # cube root of the rounding unit
    around = np.repeat(y[None], 2 * n, axis=0)
    around[np.arange(n), np.arange(n)] += steps
    around[np.arange(n, 2 * n), np.arange(n)] -= steps
    rates = path.rates.along(np.full(2 * n, path.end), around)[:, :n]
    slopes = ((rates[:n] - rates[n:]) / (2 * steps[:, None])).T
    if not np.isfinite(slopes).all():
        return ""
    values, vectors = np.linalg.eig(slopes)
    k = int(np.argmax(np.abs(values)))
    rate, name = values[k], kernels.names[int(np.argmax(np.abs(vectors[:, k])))]
    kind = "vibration" if abs(rate.imag) > abs(rate.real) else "decay" if rate.real < 0 else "growth"
    return f" The fastest motion there is a {kind} at {abs(rate):.3g} 1/s, mostly of '{name}'."


def failure(
    trajectory: Trajectory, path: SampledPath, kernels: Kernels, end: float, watched: Sequence[EventSpec]
) -> SimulationError:
    """Return the error of a run that could not continue; ``watched`` are events, and events that call for blows."""
    stuck = path.status == End.STUCK
    name = "" if path.status in OF_EVENTS or stuck else kernels.names[culprit(path, kernels)]
    idle: tuple[str, ...] = ()
    if path.status in (End.NOT_FINITE, End.TOO_MANY_STEPS):
        idle = massless(kernels, trajectory.numbers, path.end, path.states[-1])
    if path.status == End.UNRESOLVED:
        what = (
            f"the event '{watched[path.blame].name}' has more zeros than can be told apart in one step, from "
            f"t = {path.end:.9g} s on. Pass a smaller max_step=, or an event that changes less often."
        )
    elif path.status == End.UNDEFINED:
        what = _undefined(trajectory, path, kernels, watched[path.blame])
    elif stuck:
        what = _stuck(path, kernels)
    elif idle:
        what = (
            f"the mass matrix is singular at t = {path.end:.9g} s: there {' and '.join(map(repr, idle))} together "
            "move no mass. Euler angles whose axes line up do this: start or describe the body in another sequence "
            "of angles, or use a ball joint, which has no such attitude. So do bodies with masses but without moments "
            "of inertia: give them some, or their joints an armature= (the inertia of a rotor), or weld the joints."
        )
    elif path.status == End.NOT_FINITE:
        what = (
            f"the rate of '{name}' is not a finite number just after t = {path.end:.9g} s. A division by zero, a "
            "root or logarithm of a negative number, or a singular mass matrix does this: check the loads, masses "
            f"and angles there, or stop before with a terminal event.{_loads_without_value(path, kernels, trajectory)}"
            f"{_negative_friction(path, kernels, trajectory)}"
        )
    elif path.status == End.COLLAPSED:
        what = (
            f"the step collapsed at t = {path.end:.9g} s: '{name}' changes faster than any step can follow."
        )
        if singular := kernels.model.constraints and _singular(path, kernels, trajectory):
            what += singular
        else:
            what += (
                " A quantity that grows without bound, or a load that jumps, does this; stop before with a terminal "
                "event, or loosen the tolerance."
            )
            if kernels.model.constraints:
                what += " So do constraints that end: bars that come into line, points of a rope that meet."
            if path.method in EXPLICIT:
                what += ' If a spring or damper is very stiff, method="radau" follows it.'
    elif path.status == End.DIVERGED:
        what = (
            f"the step from t = {path.end:.9g} s is too long for its iteration to converge. A smaller step= converges; "
            'where a spring is very stiff, method="radau" with a tolerance is the better choice.'
        )
    else:
        what = (
            f"max_steps = {trajectory.steps} steps reached only t = {path.end:.9g} s of {end:g} s; '{name}' "
            "asked for the smallest steps. Raise max_steps, or loosen the tolerance."
        ) + _fastest(path, kernels)
        if path.stiff:
            what += ' The machine is stiff: method="radau" takes long steps.'
    state = ", ".join(f"{n} = {x:.9g}" for n, x in zip(kernels.names[:12], path.states[-1], strict=False))
    more = ", ..." if len(kernels.names) > 12 else ""
    error = SimulationError(
        f"The motion of '{kernels.model.name}' cannot be continued: {what} "
        f"Last good state: {state}{more}. The motion up to there is error.trajectory."
    )
    error.trajectory = trajectory  # type: ignore[attr-defined]
    return error
