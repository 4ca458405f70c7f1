"""Blows and impacts of no duration in the middle of a motion.

M Δu = Jᵀ P + Gᵀ Λ,    G Δu = 0,      work = T(u + Δu) - T(u)
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import sympy

from ...errors import ModelError, SimulationError, arguments_named
from ..kernels.kernels import Kernels
from ..ode.dense_output import FINISHED, TERMINAL, Array, Path, Watch
from ..start.arguments import check_forwards
from ..start.initial import number
from ..trajectory.event import EventSpec, Happening, event, expressions_of, watching
from ..trajectory.phases import Phases, Segment, segments_of


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
    impulse: Any = None,
    moment: Any = None,
    frame: Any = None,
    normal: Any = None,
    restitution: Any = None,
    name: str = "blow",
    count: int | None = None,
) -> Blow:
    """A blow, or an impact with given restitution, for ``fb.simulate(..., impulses=[...])``.

    Parameters
    ----------
    when : number, expression or event
        The time [s]; or an expression of coordinates, speeds and time (or :func:`freebody.event` of one, with a
        direction): the blow falls where it passes through zero.
    at, impulse, moment, frame, normal, restitution
        As of :func:`freebody.impulse`: where, and what [N s, N m s] or against which surface.
    name : str
        By which it is found among the events.
    count : int, optional
        Greatest number of times it falls, where ``when`` is located; no limit if not given.

    Returns
    -------
    Blow

    Raises
    ------
    SimulationError
        A blow after which the machine would be where it has just been: an endless sequence at one moment.

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
    options = {
        "at": at,
        "impulse": impulse,
        "moment": moment,
        "frame": frame,
        "normal": normal,
        "restitution": restitution,
    }
    return Blow(when, str(name), options, count)


def blows_of(given: Any) -> tuple[Blow, ...]:
    """The blows asked for."""
    if isinstance(given, (tuple, list)) and not given:
        return ()
    if isinstance(given, Blow):
        given = [given]
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise SimulationError(f"Expected a list of fb.blow(...) for impulses, got {given!r}.")
    given = tuple(given)
    for one in given:
        if not isinstance(one, Blow):
            raise SimulationError(
                f"Expected fb.blow(time, at=point, impulse=(Jx, Jy, Jz)) in impulses, got {one!r}."
            )
    return given


def located(kernels: Kernels, one: Blow) -> bool:
    """Whether the moment of a blow is to be found on the way."""
    if isinstance(one.when, EventSpec):
        return True
    names = kernels.model.names
    expression = names.expression(one.when, f"the time of '{one.name}'")
    return isinstance(expression, sympy.Basic) and bool(
        names.depends(expression, "coordinate", "speed", "time")
    )


def call_of(one: Blow) -> EventSpec:
    """The event that calls for a blow."""
    given = one.when if isinstance(one.when, EventSpec) else event(one.when)
    return replace(given, name=one.name, terminal=True)


def scheduled(
    kernels: Kernels, numbers: Mapping[str, float], blows: Sequence[Blow], begin: float, end: float
) -> tuple[list[tuple[float, Blow]], list[Blow]]:
    """(time, blow) of those at given times, in their order, and those that events call for."""
    called = [one for one in blows if located(kernels, one)]
    timed = [
        (number(kernels.model, numbers, one.when, f"the time of '{one.name}'"), one)
        for one in blows
        if one not in called
    ]
    for time, one in timed:
        if not begin <= time <= end:
            raise SimulationError(
                f"Expected the time of '{one.name}' within the run, {begin:g} to {end:g} s, got {time:g} s."
            )
    return sorted(timed, key=lambda entry: entry[0]), called


def watching_specs(
    kernels: Kernels, specs: Sequence[EventSpec], blows: Sequence[Blow]
) -> tuple[EventSpec, ...]:
    """The events of the user and, after them, those that call for a blow."""
    return (*specs, *(call_of(one) for one in blows if located(kernels, one)))


def watching_blows(
    kernels: Kernels, parameters: Array, specs: Sequence[EventSpec], blows: Sequence[Blow]
) -> Watch | None:
    """The compiled functions of these."""
    everything = watching_specs(kernels, specs, blows)
    return watching(kernels, parameters, everything, expressions_of(kernels.model, everything))


def struck_path(
    kernels: Kernels,
    numbers: Mapping[str, float],
    advance: Callable[..., Path | Phases],
    state: Any,
    begin: float,
    end: float,
    specs: Sequence[EventSpec],
    blows: Sequence[Blow],
) -> tuple[Phases, tuple[Happening, ...]]:
    """The path of a machine that is struck on its way.

    Parameters
    ----------
    advance              (state, from, to, work of the blows until then) -> Path, or Phases of a driven machine
    specs                events of the user, which stand before those of the blows
    """
    check_forwards(begin, end, "a run with impulses=", "blows")
    asked = len(specs)
    timed, called = scheduled(kernels, numbers, blows, begin, end)
    left = {id(one): np.inf if one.times is None else one.times for one in called}
    segments: list[Segment] = []
    happenings: list[Happening] = []
    t, y, work, last = begin, np.array(state, dtype=float), 0.0, -np.inf
    repeated = 0
    while True:
        target = timed[0][0] if timed else end
        path = advance(y, t, target, work)
        mine = [c for c in path.crossings if c.number >= asked]
        legs = segments_of(path, kernels, work)
        for leg in legs:
            shown = tuple(c for c in leg.path.crossings if c.number < asked)
            segments.append(replace(leg, path=replace(leg.path, crossings=shown)))
        work = legs[-1].impulses
        stopped = path.status == TERMINAL
        now = [
            called[c.number - asked]
            for c in mine
            if stopped and abs(c.time - path.end) <= 1e-12 * max(1.0, abs(path.end))
        ]
        y, t = legs[-1].path.states[-1].copy(), path.end
        if path.status == FINISHED and timed:
            while timed and timed[0][0] == target:
                now.append(timed.pop(0)[1])
        elif not stopped:
            return Phases(tuple(segments), path.status), tuple(happenings)
        user_stop = stopped and any(
            c.time == path.end and c.number < asked and specs[c.number].terminal for c in path.crossings
        )
        now = [one for one in now if left.get(id(one), 1) > 0]
        for one in now:
            if id(one) in left:
                left[id(one)] -= 1
            y, gained, told = strike(kernels, numbers, t, y, one)
            work += gained
            happenings.append(told)
        repeated = repeated + 1 if t - last <= 1e-12 * max(1.0, abs(t)) else 0
        last = t
        if repeated > 20:
            raise SimulationError(
                f"The blow '{now[0].name if now else mine[-1].number}' falls again and again at t = {t:.9g} s: what "
                "calls for it is still so just after. Give it a direction, or a count."
            )
        if user_stop or (path.status == FINISHED and target == end and not timed):
            status = TERMINAL if user_stop else FINISHED
            tail = Path(path.rates, np.array([t]), np.empty(0), y[None], (), status, 0, 0, 0)
            if now:
                segments.append(replace(segments[-1], path=tail, impulses=work))
            return Phases(tuple(segments), status), tuple(happenings)


def strike(
    kernels: Kernels, numbers: Mapping[str, float], t: float, y: Any, one: Blow
) -> tuple[Any, float, Happening]:
    """State after a blow, the work it does, and what is told of it."""
    from .impulse import impulse as struck  # and with it all of the equations

    model = kernels.model
    names = [*model.coordinate_names, *model.speed_names]
    before = dict(zip(names, y.tolist(), strict=False))
    try:
        hit = struck(model, initial=before, values=numbers, t=t, **one.options)
    except ModelError as error:
        raise SimulationError(f"The blow '{one.name}' at t = {t:.9g} s can not be: {error}") from None
    after = y.copy()
    after[model.n_q : model.n_q + model.n_u] = [hit.after[name] for name in model.speed_names]
    jumps = ", ".join(
        f"{name} {hit.before[name]:.6g} → {hit.after[name]:.6g}"
        for name in model.speed_names
        if hit.after[name] != hit.before[name]
    )
    told = Happening(
        t,
        one.name,
        0,
        before,
        f"{one.name}: {jumps or 'no speed changes'}",
        dict(zip(names, after.tolist(), strict=False)),
        hit.warnings,
    )
    return after, float(hit.energy_change), told
