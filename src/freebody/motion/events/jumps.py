"""Events of the user between phases, in compiled code: functions that jump through zero, or reach it as a gap closes.

Within a phase `event_search` finds them. A function that arrives at zero has its event there, and one that leaves it in
the direction from which it came.
"""

from __future__ import annotations

import math

from ...native.instructions import Reals, Truth, compiled, greater, inlined
from ..ode.run import Run
from ..phase.phase_record import PhaseData
from . import event_run
from .event_run import EventRun
from .log import log_crossing

SAME = 1e-12
"""Time, relative to 1 s or the time, within which an event is the same one, as in a step."""


@compiled
def forget_signs(it: EventRun) -> None:
    """Know no signs and no events, as at the start of a run."""
    for e in range(it.asked):
        it.signs[e], it.ways[e], it.crossed_at[e] = event_run.UNSEEN, 0, -math.inf


@compiled
def sign_of(x: float) -> int:
    """Return 1, -1, or 0 for zero and for what is no number."""
    return 1 if x > 0.0 else (-1 if x < 0.0 else 0)


@compiled
def take_crossing(it: EventRun, t: float, e: int, way: int, y: Reals) -> None:
    """Log an event of a function at t, as its last one."""
    log_crossing(it, t, e, way, y)
    it.ways[e], it.crossed_at[e] = way, t


@compiled
def crossed(it: EventRun, run: Run, e: int, way: int) -> int:
    """Log an event now if its direction is asked for; return 1 if it ends the run, else 0."""
    asked = run.search.directions[e]
    if asked != 0 and asked != way:
        return 0
    take_crossing(it, it.t, e, way, it.y)
    return 1 if it.final[e] != 0 else 0


@inlined
def same(t: float, other: float) -> Truth:
    """Return True if two times are those of one event."""
    return abs(t - other) <= SAME * greater(1.0, abs(t))


@compiled
def just_crossed(it: EventRun, e: int) -> int:
    """Return 1 if a function has had its event now, else 0."""
    return 1 if same(it.t, it.crossed_at[e]) else 0


@compiled
def jumped(it: EventRun, run: Run) -> int:
    """Log the functions whose signs changed since the end of the last phase; return 1 if one ends the run, else 0."""
    ends = 0
    if it.asked > 0:
        it.watched(it.t, it.y, it.phase, it.watch)
    for e in range(it.asked):
        now, before = sign_of(it.watch[e]), it.signs[e]
        it.signs[e] = now
        if before == event_run.UNSEEN or now == before:
            continue
        if now == 0 and just_crossed(it, e) != 0:
            continue
        if before == 0 and now == it.ways[e]:  # it passes
            continue
        ends += crossed(it, run, e, now if now != 0 else -before)
    return 1 if ends > 0 else 0


@compiled
def arrived(it: EventRun, run: Run) -> int:
    """Log the functions that reach zero as a gap closes at the end of a phase, or jump over it where a law switches;
    return 1 if one ends the run, else 0.

    A gap at round-off is zero there. All signs are those at the end. The search finds a jump up to the error of its
    dense output only, which may be after the switch.
    """
    ends, phase = 0, PhaseData(it.phase)
    if it.asked == 0:
        return 0
    it.watched(it.t, it.y, it.phase, it.watch)
    phase.near = it.near
    it.watched(it.t, it.y, it.phase, it.watch_later)
    phase.near = 0.0
    for e in range(it.asked):
        before = it.signs[e]
        it.signs[e] = sign_of(it.watch_later[e])
        reaches = it.watch_later[e] == 0.0 and it.watch[e] != 0.0 and (before == 1 or before == -1)
        if (reaches or before * it.signs[e] == -1) and just_crossed(it, e) == 0:
            ends += crossed(it, run, e, -before)
    return 1 if ends > 0 else 0
