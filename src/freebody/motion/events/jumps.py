"""What jumps between phases, in compiled code: functions of the user, and loads that switch.

Within a phase `event_search` finds zeros of functions. A function that arrives at zero has its event there, and one
that leaves it in the direction from which it came.

A switch of a load (`kernels.switching`) ends a phase: forces jump, so that the modes of contacts are decided anew.
Where contacts hold a body, an e is zero but for round-off, and its law is at rest.
"""

from __future__ import annotations

import math

from ...native.instructions import Reals, compiled
from ..kernels.hoisted import Hoisted
from ..kernels.renewal import renew
from ..kernels.sided_run import SidedRun
from ..kernels.switching import (
    OTHER_SIDES,
    is_quiet,
    judge,
    look_back,
    reset,
    same,
    see,
    settle,
    sign_of,
    switch,
)
from ..ode.layout import FINISHED, STUCK
from ..ode.run import Run
from ..phase.phase_record import PhaseData
from . import event_run, limits
from .event_run import EventRun
from .log import log_crossing, log_phase, log_state
from .moment import largest


@compiled
def forget_signs(it: EventRun) -> None:
    """Know no signs and no events, as at the start of a run."""
    for e in range(it.asked):
        it.signs[e], it.ways[e], it.crossed_at[e] = event_run.UNSEEN, 0, -math.inf


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
        if now == 0 and same(it.t, it.crossed_at[e]):
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
        if (reaches or before * it.signs[e] == -1) and not same(it.t, it.crossed_at[e]):
            ends += crossed(it, run, e, -before)
    return 1 if ends > 0 else 0


# -- loads that switch ------------------------------------------------------------------------------------


@compiled
def take_sides(it: EventRun) -> None:
    """Let all that is computed follow the parameters and the sides."""
    renew(Hoisted(it.hoisted))
    show_sides(it)
    it.stale = 1


@compiled
def forget_sides(it: EventRun, start: float, until: float) -> None:
    """Know no sides, as at the start of a run."""
    reset(SidedRun(it.sided), start, until)
    take_sides(it)


@compiled
def show_sides(it: EventRun) -> None:
    """Write how far each law is from its switch into the functions that are watched: nothing is solved yet."""
    s, phase = SidedRun(it.sided), PhaseData(it.phase)
    phase.solved = 0
    for k in range(it.laws):
        phase.sides[k], phase.bands[k], phase.idle[k] = s.sides[k], s.bands[k], s.idle[k]


@compiled
def see_laws(it: EventRun) -> None:
    """Evaluate all laws at the present moment, by the rates of the phase."""
    it.rates(it.t, it.y, it.phase, it.step)
    see(SidedRun(it.sided), it.t, it.y, it.step)


@compiled
def settle_sides(it: EventRun) -> None:
    """Give laws whose e has jumped over zero, as a speed does in an impact, their other side."""
    if it.laws > 0:
        it.rates(it.t, it.y, it.phase, it.step)
        if settle(SidedRun(it.sided), it.t, it.y, it.step, it.near) != 0:
            take_sides(it)
        show_sides(it)


@compiled
def judge_sides(it: EventRun) -> int:
    """Judge the sides by the rates of the phase (`switching.judge`)."""
    s = SidedRun(it.sided)
    see_laws(it)
    why = judge(s, it.near, limits.SMALL * (1.0 + largest(it.step[it.n_q :], it.n)))
    if why == OTHER_SIDES:
        take_sides(it)
    show_sides(it)
    return why


@compiled
def switch_laws(it: EventRun, run: Run) -> int:
    """Let the laws switch whose events end the phase; return their number."""
    s, search, found = SidedRun(it.sided), run.search, 0
    steps, first = it.logged - it.first_row - 1, it.times[it.first_row]
    for e in range(run.events):
        k = search.log_numbers[e] - it.first_law
        if 0 <= k < it.laws:
            if found == 0:
                see_laws(it)
            change = abs(s.seen[3 * k + 1]) * (it.t - first)
            quiet = is_quiet(s, k, it.t, it.y, change) if steps <= 2 else 0
            look_back(s, k, it.t, quiet)
            switch(s, k)
            found += 1
    if found > 0:
        take_sides(it)
    return found


@compiled
def leave_idle(it: EventRun, run: Run) -> None:
    """Let the search for events leave laws that do not count."""
    for k in range(it.laws):
        run.search.unjudged[it.first_law + k] = SidedRun(it.sided).idle[k]


@compiled
def stick(it: EventRun) -> int:
    """End the run at the switch of a law that no side leads away, or where it is to end, if that is there."""
    code: int = STUCK
    if same(it.t, it.target):
        code, it.t = FINISHED, it.target
    it.first_row, it.blame = it.logged, SidedRun(it.sided).stuck
    log_state(it, it.t, it.y, 0.0)
    log_phase(it, code, 0, 0, 0, event_run.STEPS)
    return code
