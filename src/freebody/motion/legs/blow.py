"""Blows and impacts of no duration during a motion.

M Δu = Jᵀ P + Gᵀ Λ,    G Δu = 0,      work = T(u + Δu) - T(u)
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import sympy

from ...errors import ModelError, SimulationError, arguments_named
from ...scalar.algebra import Expression, Vector
from ..ending import End
from ..kernels.kernels import Kernels
from ..kernels.program import at_states
from ..ode.dense_output import Path
from ..request import Problem
from ..start.arguments import check_forwards
from ..start.initial import number
from ..start.loaded_joints import check_loads
from ..trajectory.contact_expressions import of_contacts, refuse_outputs
from ..trajectory.event import EventSpec, Happening, event, expressions_of
from ..trajectory.phases import Phases, Segment, segments_of

SOONER = 2.0 ** -np.arange(1, 31)
"""Parts of a step at which a rebound is looked for."""
NOISE = 1e-14
"""Round-off of an expression, relative to the greatest coordinate or speed."""


@dataclass(frozen=True)
class Blow:
    """An impulse that a simulation applies. Made by :func:`blow`."""

    when: Any
    name: str
    options: Mapping[str, Any]
    times: int | None


@arguments_named
def blow(
    when: Any,
    *,
    at: Any = None,
    impulse: Vector | None = None,
    moment: Vector | None = None,
    frame: Any = None,
    normal: Vector | None = None,
    restitution: Expression | None = None,
    name: str = "blow",
    count: int | None = None,
) -> Blow:
    """Return a blow, or an impact with given restitution, for ``fb.simulate(..., impulses=[...])``.

    Parameters
    ----------
    when : number, expression or event
        Time of the blow [s]; or an expression of coordinates, speeds and time, or a :func:`freebody.event` with a
        direction: the blow falls where the expression passes through zero.
    at, impulse, moment, frame, normal, restitution
        As for :func:`freebody.impulse`: the point, and the impulse [N s, N m s] or the surface that is hit.
    name : str
        Name of its events.
    count : int, optional
        Greatest number of blows, if ``when`` is an expression; no limit if not given.

    Returns
    -------
    Blow

    Raises
    ------
    SimulationError
        A blow after which its condition is fulfilled again: an endless sequence at one time.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("ball")
    >>> ball = s.body("ball", fb.particle(2))
    >>> rail = s.slider("rail", s.ground, ball, axis="x", coordinate="x")
    >>> motion = fb.simulate(s, 3, impulses=[fb.blow(1, at=ball, impulse=(4, 0, 0), name="kick")])
    >>> round(motion.at(3)["x"], 12), float(motion.energy.work[-1])
    (4.0, 4.0)
    >>> print(motion.events)
    t = 1 s: kick: x' 0 → 2
    """
    options = dict(  # those of `impulse`
        at=at, impulse=impulse, moment=moment, frame=frame, normal=normal, restitution=restitution
    )
    return Blow(when, str(name), options, count)


def blows_of(impulses: Any) -> tuple[Blow, ...]:
    """Return the blows of an argument ``impulses=``."""
    if isinstance(impulses, (tuple, list)) and not impulses:
        return ()
    if isinstance(impulses, Blow):
        impulses = [impulses]
    if isinstance(impulses, str) or not isinstance(impulses, Iterable):
        raise SimulationError(f"Expected a list of fb.blow(...) for impulses, got {impulses!r}.")
    blows = tuple(impulses)
    for blow in blows:
        if not isinstance(blow, Blow):
            raise SimulationError(
                f"Expected fb.blow(time, at=point, impulse=(Jx, Jy, Jz)) in impulses, got {blow!r}."
            )
    return blows


def located(kernels: Kernels, blow: Blow) -> bool:
    """Return True if an event calls for a blow, False if its time is given."""
    called = isinstance(blow.when, EventSpec)
    when, what = blow.when.expression if called else blow.when, f"blow '{blow.name}'"
    if of_contacts(kernels.model, when, what) is not None:
        raise SimulationError(
            f"Expected a time, or an expression of coordinates, speeds and the time, for {what}, got '{when}', a "
            "quantity of a contact. End the run there, fb.event(..., terminal=True), and begin the next one with the "
            "blow at its start."
        )
    refuse_outputs(kernels.model, when, what, "coordinates, speeds and the time")
    if called:
        return True
    names = kernels.model.names
    expression = names.expression(blow.when, f"the time of '{blow.name}'")
    return isinstance(expression, sympy.Basic) and bool(
        names.depends(expression, "coordinate", "speed", "time")
    )


def call_of(blow: Blow) -> EventSpec:
    """Return the event that calls for a blow."""
    spec = blow.when if isinstance(blow.when, EventSpec) else event(blow.when)
    return replace(spec, name=blow.name, terminal=True)


def scheduled(
    kernels: Kernels, numbers: Mapping[str, float], blows: Sequence[Blow], begin: float, end: float
) -> tuple[list[tuple[float, Blow]], list[Blow]]:
    """Return (time, blow) of blows at given times, in order, and the blows that events call for."""
    check_loads(kernels.model)
    called = [blow for blow in blows if located(kernels, blow)]
    timed = [
        (number(kernels.model, numbers, blow.when, f"the time of '{blow.name}'"), blow)
        for blow in blows
        if blow not in called
    ]
    for time, blow in timed:
        if not begin <= time <= end:
            raise SimulationError(
                f"Expected the time of '{blow.name}' within the run, {begin:g} to {end:g} s, got {time:g} s."
            )
    return sorted(timed, key=lambda entry: entry[0]), called


def watching_specs(
    kernels: Kernels, specs: Sequence[EventSpec], blows: Sequence[Blow]
) -> tuple[EventSpec, ...]:
    """Return the events of the user and, after them, the events that call for a blow."""
    return (*specs, *(call_of(blow) for blow in blows if located(kernels, blow)))


def struck_path(
    problem: Problem, advance: Callable[..., Path | Phases], state: Any, blows: Sequence[Blow]
) -> tuple[Phases, tuple[Happening, ...]]:
    """Return the path of a machine under blows, and the events that the blows cause.

    Parameters
    ----------
    advance              (state, start, end, work of the blows until then) -> Path, or Phases of a driven machine
    """
    kernels, numbers, specs = problem.kernels, problem.numbers, problem.specs  # those of blows follow
    begin, end = problem.begin, problem.end
    check_forwards(begin, end, "a run with impulses=", "blows")
    count = len(specs)
    timed, called = scheduled(kernels, numbers, blows, begin, end)
    remaining = [np.inf if blow.times is None else blow.times for blow in called]
    segments: list[Segment] = []
    happenings: list[Happening] = []
    rebounding: list[tuple[int, int]] = []
    t, y, work, last = begin, np.array(state, dtype=float), 0.0, -np.inf
    repeated = 0
    while True:
        target = timed[0][0] if timed else end
        path = advance(y, t, target, work)
        calls = [c for c in path.crossings if c.number >= count]
        for k, sign in rebounding:
            check_return(kernels, numbers, (count + k, called[k], sign), path)
        legs = segments_of(path, kernels, work)
        for leg in legs:
            own = tuple(c for c in leg.path.crossings if c.number < count)
            segments.append(replace(leg, path=replace(leg.path, crossings=own)))
        work = legs[-1].impulses
        stopped = path.status == End.TERMINAL
        last_moment = 1e-12 * max(1.0, abs(path.end))
        fallen = [c.number - count for c in calls if stopped and abs(c.time - path.end) <= last_moment]
        fallen = [k for k in fallen if remaining[k] > 0]
        now = [called[k] for k in fallen]
        signs = {c.number - count: c.sign for c in calls}
        rebounding = [(k, signs[k]) for k in fallen if called[k].options["restitution"] not in (None, 0)]
        y, t = legs[-1].path.states[-1].copy(), path.end
        if path.status == End.FINISHED and timed:
            while timed and timed[0][0] == target:
                now.append(timed.pop(0)[1])
        elif not stopped:
            return Phases(tuple(segments), path.status), tuple(happenings)
        user_stop = stopped and any(
            c.time == path.end and c.number < count and specs[c.number].terminal for c in path.crossings
        )
        for k in fallen:
            remaining[k] -= 1
        for blow in now:
            y, gained, happening = strike(kernels, numbers, t, y, blow)
            work += gained
            happenings.append(happening)
        repeated = repeated + 1 if t - last <= 1e-12 * max(1.0, abs(t)) else 0
        last = t
        if repeated > 20:
            raise SimulationError(
                f"The blow '{now[0].name if now else calls[-1].number}' falls again and again at t = {t:.9g} s: its "
                "condition is fulfilled again just after. Give it a direction, or a count."
            )
        if user_stop or (path.status == End.FINISHED and target == end and not timed):
            status = End.TERMINAL if user_stop else End.FINISHED
            tail = Path(path.rates, np.array([t]), np.empty(0), y[None], (), status, 0, 0, 0)
            if now:
                segments.append(replace(segments[-1], path=tail, impulses=work))
            return Phases(tuple(segments), status), tuple(happenings)


def check_return(
    kernels: Kernels, numbers: Mapping[str, float], rebound: tuple[int, Blow, int], path: Path | Phases
) -> None:
    """Raise if the point of a blow against a surface comes back within a part of the first step that the search for
    events does not resolve: the condition, an event of this number, has the sign that it has behind the surface again,
    without a zero.
    """
    number, blow, sign = rebound
    first = path.segments[0].path if isinstance(path, Phases) else path
    (quantity,) = expressions_of(kernels.model, (call_of(blow),))
    if len(first.times) < 2 or any(c.number == number for c in first.crossings):
        return
    h = first.times[1] - first.times[0]
    times = first.times[0] + h * np.array([1.0, *SOONER])
    states = first.sample(times)[:, : kernels.model.n_q + kernels.model.n_u]
    program = kernels.expressions((quantity,))
    values = (
        sign
        * at_states(program, "values", times, states, program.constants(kernels.parameters(numbers)))[:, 0]
    )
    noise = NOISE * (1 + np.abs(states).max())
    if values[0] > noise and values.min() < -noise:
        raise refused_return(blow, float(first.times[0]), h)


def refused_return(blow: Blow, t: float, h: float) -> SimulationError:
    """Return the error for a blow whose rebound turns round within a step."""
    return SimulationError(
        f"The blow '{blow.name}' falls again and again from t = {t:.9g} s on: loads turn its rebound round within a "
        f"step of {h:g} s. A surface on which something comes to rest is a contact: s.contact(..., restitution=e)."
    )


def strike(
    kernels: Kernels, numbers: Mapping[str, float], t: float, y: Any, blow: Blow
) -> tuple[Any, float, Happening]:
    """Return the state after a blow, its work, and its event."""
    hit = hit_by(kernels, numbers, t, y, blow)
    after = speeds_after(kernels, y, hit)
    return after, float(hit.energy_change), happening_of(kernels, t, blow.name, y, after, hit.warnings)


def hit_by(kernels: Kernels, numbers: Mapping[str, float], t: float, y: Any, blow: Blow) -> Any:
    """Return the result of a blow on a machine in a state, without contacts."""
    from ...symbolic.equations import Equations
    from .impulse import impulse as struck  # imports all rooms of equations

    model = kernels.model
    unresisted = Equations(model)  # contacts stop a body in the impact that follows the blow
    before = dict(zip(model.state_names, y.tolist(), strict=False))
    try:
        return struck(unresisted, initial=before, values=numbers, t=t, **blow.options)
    except ModelError as error:
        raise SimulationError(f"The blow '{blow.name}' at t = {t:.9g} s is impossible: {error}") from None


def speeds_after(kernels: Kernels, y: Any, hit: Any) -> Any:
    """Return a state with the speeds after a blow."""
    model, after = kernels.model, y.copy()
    after[model.n_q : model.n_q + model.n_u] = [hit.after[name] for name in model.speed_names]
    return after


def happening_of(kernels: Kernels, t: float, name: str, y: Any, after: Any, warnings: Any) -> Happening:
    """Return the event of a blow with the states before and after it."""
    model = kernels.model
    speeds = zip(model.speed_names, y[model.n_q :].tolist(), after[model.n_q :].tolist(), strict=False)
    jumps = ", ".join(f"{u} {first:.6g} → {last:.6g}" for u, first, last in speeds if last != first)
    text = f"{name}: {jumps or 'no speed changes'}"
    return Happening.between(model.state_names, t, name, (y, after), text, warnings)
