"""Steps of a run whose laws switch, in compiled code: legs between the switches, in which all laws keep their sides.

The loop of a method takes the steps of a leg. It ends where an e passes zero, and the next begins there with other
constants, so that the steps see no jump and no bend.
"""

from __future__ import annotations

from ...native.instructions import Reals, compiled, greater, inlined, lesser, run_by, whole
from ..ode.layout import FINISHED, RUNNING, STUCK, TERMINAL
from ..ode.run import Run
from ..ode.states import close_gaps, normalise
from .hoisted import Hoisted
from .renewal import renew
from .sided_run import SidedLoop, SidedRun
from .switching import (
    IS_STUCK,
    OTHER_SIDES,
    SAME,
    gauge,
    is_quiet,
    judge,
    look_back,
    same,
    see,
    settle,
    sign_of,
    switch,
)

ANY = float("inf")


@compiled
def watched(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the functions of the user, then to those that fall through zero where a law leaves its side."""
    loop = SidedLoop(c)
    s = SidedRun(loop.sided)
    loop.values(t, y, loop.values_c, out)
    for k in range(s.laws):
        e = out[loop.events + k]
        out[loop.events + k] = 1.0 if s.idle[k] != 0 else gauge(s.sides[k], e, s.bands[k])


@compiled
def pieces(loop: SidedLoop) -> int:
    """Compute a run, or its next piece, as `step_control.piece` does: one piece of every leg after the other."""
    run, inner, status = Run(loop.run), Run(loop.inner), RUNNING
    run.accepted = run.events = loop.legs = 0
    if run.taken == 0:
        status = start(loop)
    for i in range(run.n):
        inner.relative[i], inner.absolute[i] = run.relative[i], run.absolute[i]
    if inner.taken > 0:
        inner.h = run.h
    while status == RUNNING and run.accepted < run.room and run.events < run.room:
        inner.room = least(loop.piece_room, least(run.room - run.accepted, run.room - run.events))
        status = run_by(loop.piece, inner)
        take(loop)
        if status == TERMINAL:
            status = end_leg(loop)
    finish(loop)
    return status


@inlined
def least(a: int, b: int) -> int:
    """Return the lesser of two whole numbers."""
    return a if a < b else b


@compiled
def start(loop: SidedLoop) -> int:
    """Begin a run with the sides that e has; return RUNNING, or how the run ends."""
    run, inner, s = Run(loop.run), Run(loop.inner), SidedRun(loop.sided)
    inner.t, inner.h, inner.until, inner.longest, inner.start = run.t, run.h, run.until, run.longest, run.t
    inner.rejected = inner.evaluated = inner.stiffness = 0
    inner.stop_if_stiff, inner.fixed, inner.required = run.stop_if_stiff, run.fixed, run.required
    for i in range(run.n):
        inner.initial[i] = inner.y[i] = run.initial[i]
    normalise(inner, inner.y)
    loop.longest_step = run.h
    copy_row(inner.t, inner.y, run, 0)
    renew(Hoisted(s.hoisted))
    status = begin_leg(loop)
    sign_events(loop, 0)
    return status


@compiled
def begin_leg(loop: SidedLoop) -> int:
    """Begin a leg at the present state: find the sides that lead on; return RUNNING, or STUCK."""
    run, inner, s = Run(loop.run), Run(loop.inner), SidedRun(loop.sided)
    why, t, y, rates = OTHER_SIDES, inner.t, inner.y, loop.rates
    while why == OTHER_SIDES:
        inner.rates(t, y, inner.c, rates)
        if settle(s, t, y, rates, ANY) != 0:
            inner.rates(t, y, inner.c, rates)
        see(s, t, y, rates)
        why = judge(s, 0.0, 0.0)
        if why == OTHER_SIDES:
            renew(Hoisted(s.hoisted))
    if why == IS_STUCK:
        inner.blame = s.stuck
        return STUCK
    at = loop.legs
    loop.leg_rows[at] = run.accepted
    for k in range(s.laws):
        loop.leg_sides[at, k], inner.search.unjudged[loop.events + k] = s.sides[k], s.idle[k]
    for e in range(loop.events):  # one of two functions with the same zeros is enough
        inner.search.unjudged[e] = 1 - s.idle[loop.law_of[e]] if loop.law_of[e] >= 0 else 0
    loop.legs += 1
    if inner.fixed != 0:  # a whole number of equal steps
        span = abs(inner.until - t)
        longest = lesser(lesser(loop.step, inner.longest), span)
        steps = span / longest * (1.0 - SAME)
        count = whole(steps)
        count += 1 if count < steps else 0
        loop.longest_step = span / count
    inner.h, inner.start, inner.old_error = loop.longest_step, t, 0.0
    for i in range(inner.n):
        inner.initial[i] = y[i]
    inner.taken = inner.after_rejection = inner.suspect = inner.calm = inner.sampled = 0
    loop.longest_step, loop.steps, loop.begun = 0.0, 0, t
    return RUNNING


@compiled
def copy_row(t: float, y: Reals, run: Run, k: int) -> None:
    """Write a row of the path."""
    run.times[k] = t
    for i in range(run.n):
        run.states[k, i] = y[i]


@compiled
def take(loop: SidedLoop) -> None:
    """Append the steps and events of a piece of a leg."""
    run, inner, search = Run(loop.run), Run(loop.inner), Run(loop.inner).search
    n, size, at = inner.accepted, inner.n, run.accepted
    for k in range(n):
        run.lengths[at + k] = inner.times[n + 1 + k]
        loop.longest_step = greater(loop.longest_step, abs(inner.times[n + 1 + k]))
    for k in range(n + 1):
        run.times[at + k] = inner.times[k]
        for i in range(size):
            run.states[at + k, i] = inner.times[2 * n + 1 + k * size + i]
    for e in range(inner.events):
        number, way = search.log_numbers[e], search.log_signs[e]
        # the search may find a jump on both sides of a switch
        if number < loop.events and not (
            loop.ways[number] == way and same(search.log_times[e], loop.crossed_at[number])
        ):
            log_event(loop, search.log_times[e], number, way, search.log_states[e])
    run.accepted += n
    run.taken += n
    loop.steps += n


@compiled
def log_event(loop: SidedLoop, t: float, number: int, way: int, y: Reals) -> None:
    """Log an event of the user, if its direction is asked for."""
    run, log, at = Run(loop.run), Run(loop.run).search, Run(loop.run).events
    loop.signs[number] = loop.ways[number] = way
    loop.crossed_at[number] = t
    if loop.directions[number] == 0 or loop.directions[number] == way:
        log.log_times[at], log.log_numbers[at], log.log_signs[at] = t, number, way
        for i in range(run.n):
            log.log_states[at, i] = y[i]
        run.events += 1
        if loop.final[number] != 0 and t != loop.begun:
            loop.ends = 1


@compiled
def sign_events(loop: SidedLoop, logs: int) -> None:
    """Note the signs of the functions of the user; with ``logs`` log those that have jumped over zero, since the search
    finds a jump up to the error of its dense output only, which may be after the switch.
    """
    inner = Run(loop.inner)
    if loop.events == 0:
        return
    loop.values(inner.t, inner.y, loop.values_c, loop.seen)
    for e in range(loop.events):
        now = sign_of(loop.seen[e])
        if logs != 0 and now != 0 and loop.signs[e] == -now:
            log_event(loop, inner.t, e, now, inner.y)
        loop.signs[e] = now if now != 0 or logs == 0 else loop.signs[e]


@compiled
def end_leg(loop: SidedLoop) -> int:
    """Let laws switch where a leg ends, and begin the next; return RUNNING, or how the run ends."""
    inner, s, search = Run(loop.inner), SidedRun(loop.sided), Run(loop.inner).search
    sign_events(loop, 1)
    if loop.ends != 0:
        return TERMINAL
    if inner.t == inner.until:
        return FINISHED
    inner.rates(inner.t, inner.y, inner.c, loop.rates)
    see(s, inner.t, inner.y, loop.rates)
    for e in range(inner.events):
        k = search.log_numbers[e] - loop.events
        if k >= 0 and s.idle[k] == 0:
            change = abs(s.seen[3 * k + 1] * (inner.t - loop.begun))
            quiet = is_quiet(s, k, inner.t, inner.y, change) if loop.steps <= 2 else 0
            look_back(s, k, inner.t, quiet)
            switch(s, k)
    renew(Hoisted(s.hoisted))
    return begin_leg(loop)


@compiled
def finish(loop: SidedLoop) -> None:
    """Write the numbers of the run, and close the gaps in its rows."""
    run, inner = Run(loop.run), Run(loop.inner)
    close_gaps(run)
    run.t, run.h, run.blame = inner.t, inner.h, inner.blame
    run.rejected, run.evaluated, run.stiffness = inner.rejected, inner.evaluated, inner.stiffness
