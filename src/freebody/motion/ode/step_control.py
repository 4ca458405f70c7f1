"""The loop around the steps of any method: step-size control, projection, located events, output.

    y' = f(t, y, c)

A method (`dop853`, `dop54`, `tsit5`, `radau`, `gauss`, `structure`, `taylor`) defines a step, as a value (`Method`).
Everything else is here, once. A step is attempted, judged, and accepted if its error ε is at most 1. The next step is

    h_new = h · min(G, max(S, safety · ε_old^β / ε^α))

(proportional-integral control), with S = 1/3 and G = 6 unless the method states others, times the trend of the lengths
that errors allow, h/ε^α: their ratio from one step to the next, if it was above 1 twice, or below 1 twice, the nearer
to 1 of the two. A motion that comes near a singularity shortens each of its steps by the same part, and every second
one would be rejected. A rejected step is repeated with h_new, and β = 0. Steps of fixed length are accepted whatever
their error.

Unit quaternions are normalised after each accepted step. The correction is of the size of the local error, O(h^(p+1)),
and f is evaluated at the corrected state, so that the order p is kept. The dense output is the polynomial from the
state at the start of the step to its uncorrected end. Each quaternion is divided by its norm where the dense output is
evaluated, so that it meets the corrected state at the end of the step and is continuous.

The dense output serves to find events (`event_search`). It is not stored, and no result depends on it: steps are long,
and its error may exceed the tolerance. States inside a step come from shorter steps (`states`), so that a run stores n
numbers per step.

The memory of a run is a record (`run.Run`). No step allocates, counts references, tests a bound or raises. `loop`
compiles this module once and keeps the result on the disk; the module is imported only for that.

Source: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I (1993), section II.4; E. Hairer,
G. Wanner, Solving Ordinary Differential Equations II (1996), section IV.2.
"""

from __future__ import annotations

import math
from typing import Any

from ...native.functions import components, each
from ...native.instructions import (
    EPS,
    Compiled,
    Parts,
    Real,
    Truth,
    Whole,
    greater,
    lesser,
    maximum,
    root,
    where,
)
from . import event_search, states, window
from .event_search import MOST, TOO_LONG, find_events, log_events
from .layout import (
    COLLAPSED,
    DIVERGED,
    FINISHED,
    MANY,
    NOT_FINITE,
    RUNNING,
    STIFF,
    TERMINAL,
    UNDEFINED,
    UNRESOLVED,
)
from .method import Method
from .run import STAGES, Run
from .states import are_finite, close_gaps, normalise, not_finite, project

TINY = 1e-300
LEAST_ERROR = 1e-4
"""Least error of a step that the control of the next one uses."""


method: Any = None
"""The method, in the functions below."""
watched: bool = True
"""False in the functions of runs without event functions."""

part = Parts()


class Functions(dict[str, Compiled]):
    """The compiled loop of a method: the functions of this module, with ``method`` as a constant.

    The search for events is half of the code: runs without event functions have a loop without it.
    """

    def __init__(self, method: Method, watched: bool = True) -> None:
        space = {
            **vars(states), **vars(window), **vars(event_search), **globals(), "method": method, "watched": watched,
        }  # fmt: skip
        bound = (module.part.bound(space) for module in (states, window, event_search))
        super().__init__(
            {name: f for functions in bound for name, f in functions.items()} | part.bound(space)
        )
        self.method = method
        # no matrices, and few rounds beside the evaluation of the rates or of the series
        self.passes = "few" if method.stable > 0 or method.length is not None else "all"


# -- the length of steps -------------------------------------------------------------------------------


@part
def first_length(run: Run, direction: float, longest: float) -> float:
    """Return a length for the first step (Hairer, Norsett, Wanner, II.4): d_0 = |y|, d_1 = |f|, d_2 = |Δf| / h_0.

    Row point and k[1] are overwritten.
    """
    if run.n == 0:
        return longest
    d0, d1, d2 = 0.0, 0.0, 0.0
    for i in components(run.n):
        scale = run.absolute[i] + run.relative[i] * abs(run.y[i])
        d0 = maximum(d0, abs(run.y[i]) / scale)
        d1 = maximum(d1, abs(run.k[0, i]) / scale)
    h0 = 1e-6 if d0 < 1e-5 or d1 < 1e-5 else 0.01 * d0 / d1
    h0 = greater(h0, 8192.0 * EPS * abs(run.t))  # a y of round-off would ask for less than t resolves
    h0 = lesser(h0, longest)
    for i in components(run.n):
        run.point[i] = run.y[i] + direction * h0 * run.k[0, i]
    run.rates(run.t + direction * h0, run.point, run.c, run.k[1])
    for i in components(run.n):
        scale = run.absolute[i] + run.relative[i] * abs(run.y[i])
        d2 = maximum(d2, abs(run.k[1, i] - run.k[0, i]) / scale / h0)
    if not math.isfinite(d2):
        return h0
    h1 = greater(1e-6, h0 * 1e-3)
    steepest = greater(d1, d2)
    if steepest > 1e-15:
        h1 = (0.01 / steepest) ** (1.0 / method.order)
    return lesser(lesser(100.0 * h0, h1), longest)


@part.inlined
def choose_length(run: Run) -> Whole:
    """Set h, the end of the step and whether it ends the run; return RUNNING, NOT_FINITE or COLLAPSED."""
    t, h = run.t, run.h
    direction: Real = where(run.until >= t, 1.0, -1.0)
    status: Whole = RUNNING
    if method.length is not None:
        size = method.length(run)
        status = where(size == size, RUNNING, NOT_FINITE)
        h = where(size == size and run.fixed == 0 and run.after_rejection == 0, direction * size, h)
    h = where(abs(h) > run.longest, direction * run.longest, h)
    last = (t + 1.01 * h - run.until) * direction >= 0.0
    short = abs(h) <= 8.0 * EPS * abs(t) or abs(h) < TINY
    status = where(short and not last and status == RUNNING, COLLAPSED, status)
    after = t + h
    if any(run.fixed != 0):
        after = where(run.fixed != 0, run.start + (run.taken + 1) * h, after)
    run.last = where(last, 1, 0)
    run.h = where(last, run.until - t, h)
    run.after = where(last, run.until, after)
    return status


@part
def is_stiff(run: Run, good: Truth) -> Truth:
    """Return whether steps were as long as the region of stability allows, h |λ| > stable, for 15 steps.

    |λ| is estimated from the last stage and the end of the step, two states at one time. λ must be that of a decay: a
    vibration too fast for an explicit method is too fast for an implicit one, too. Six steps without suspicion reset
    the count (Hairer and Wanner, section IV.2). Steps that are not ``good`` do not count.
    """
    h = run.h
    if method.limited is not None:
        suspect = method.limited(run, h) and good
    else:
        above: Real = 0.0
        below: Real = 0.0
        across: Real = 0.0
        for i in range(run.n):
            a = run.k[12, i] - run.k[method.last_stage, i]
            b = run.end[i] - run.argument[i]
            above += a * a
            below += b * b
            across += a * b
        decays = h * across < -0.5 * abs(h) * root(above * below)
        limited = h * h * above > method.stable * method.stable * below
        suspect = good and decays and limited and below > 0.0
    calm = where(suspect, 0, run.calm + 1)
    count = where(suspect, run.suspect + 1, where(calm == 6, 0, run.suspect))
    run.calm = where(good, calm, run.calm)
    run.suspect = where(good, count, run.suspect)
    return good and count >= 15 and abs(run.until - run.after) > MANY * abs(h)


@part.inlined
def trend(run: Run, latest: Real) -> Real:
    """Return the part by which the allowed length is going to change, from its last change and the one before."""
    before = run.trend
    shrinks = where(latest < 1.0 and before < 1.0, greater(latest, before), 1.0)
    return where(latest > 1.0 and before > 1.0, lesser(latest, before), shrinks)


@part.inlined
def change_length(run: Run, error: Real, good: Truth) -> Whole:
    """Lengthen the step for the next one where it is good, and shorten it for the next attempt where it is not.

    Return RUNNING; DIVERGED if the length is fixed; NOT_FINITE if there is no state at the end of any step.
    """
    if method.length is None:  # the others have told what is to blame, since they have other rows
        for lane in each(not good and error != error):
            run.blame[lane] = blamed(run, lane)
    power = error**method.alpha
    longer: Real = 1.0
    if method.length is None:
        allowed = abs(run.h) / greater(power, LEAST_ERROR**method.alpha)
        latest = where(run.allowed > 0.0, allowed / run.allowed, 1.0)
        longer = method.safety * run.old_error**method.beta / power * trend(run, latest)
        longer = where(
            error > 0.0, lesser(method.greatest, greater(method.smallest, longer)), method.greatest
        )
        run.trend = where(good, latest, run.trend)
        run.allowed = where(good, allowed, run.allowed)
    judged, fixed = error > 1.0, run.fixed != 0
    shorter = run.h * where(judged, greater(method.smallest, method.safety / power), 0.25)
    ends = fixed or not judged and (abs(shorter) <= 16.0 * EPS * abs(run.t) or abs(shorter) < TINY)
    longer = run.h * where(run.after_rejection == 0, longer, lesser(1.0, longer))
    run.h = where(good, where(fixed, run.h, longer), shorter)
    run.old_error = where(good, greater(error, LEAST_ERROR), run.old_error)
    run.rejected = where(good, run.rejected, run.rejected + 1)
    run.after_rejection = where(good, 0, 1)
    return where(good or not ends, RUNNING, where(judged, DIVERGED, NOT_FINITE))


# -- steps ---------------------------------------------------------------------------------------------


@part
def launch(run: Run) -> int:
    """Prepare the first step from y: compute its rates and, if none is prescribed, its length.

    Return NOT_FINITE if there are no rates, FINISHED if the run has length zero, else RUNNING.
    """
    direction = 1.0 if run.until >= run.t else -1.0
    longest = lesser(run.longest, abs(run.until - run.t))
    run.old_error, run.allowed, run.trend, run.search.seen = LEAST_ERROR, 0.0, 1.0, 1.0
    if method.length is None:
        run.rates(run.t, run.y, run.c, run.k[0])
        run.evaluated += 1
        run.blame = not_finite(run.k[0], run.n, 0)
        if run.blame >= 0:
            return NOT_FINITE
        run.blame = 0
    if longest == 0.0:
        return FINISHED
    if method.length is None and run.h == 0.0:
        run.h = first_length(run, direction, longest)
        run.evaluated += 1
        run.point[:] = 0.0
        run.k[1][:] = 0.0
    run.h = direction * lesser(run.h, longest)
    return RUNNING


@part
def look(run: Run) -> int:
    """Evaluate the event functions at y, and their signs, for the first `find_events`.

    Return UNDEFINED if a required function has no value, else RUNNING. Those that are guarded may be infinite.
    """
    search, values = run.search, run.search.table[0]
    search.has_slopes, search.past_length = 0, 0.0
    search.functions(run.t, run.y, search.c, values)
    for e in range(search.count):
        search.signs[e] = 1 if values[e] > 0.0 else (-1 if values[e] < 0.0 else 0)
        finite = math.isfinite(values[e]) or (e >= search.count - search.guarded and values[e] == values[e])
        if e < run.required and not finite:
            run.blame = e
            return UNDEFINED
    return RUNNING


@part.inlined
def error_of_step(run: Run) -> Real:
    """Attempt a step, and return its error ε; 1000 if another reason shortens it, nan if the state at its end, or its
    rates, are not finite.
    """
    error: Real = 1e3
    run.evaluated += method.cost
    if method.attempt(run, run.h) == 0:
        error = method.judge(run, run.h)
        run.end[:] = run.y_new
        normalise(run, run.end)
        if not method.single_step:
            error = where(error > 1.0 and run.fixed != 0, 1.0, error)
        if run.projection is not None and any(error <= 1.0):
            change = project(run, run.after, run.end, error <= 1.0)
            relative: Real = 0.0
            for i in components(run.n):
                relative = maximum(relative, run.relative[i])
            # a greater change is no error of the step: another branch, or constraints that end or bend sharply here.
            # Steps of fixed length may have any error
            allowed = where(run.fixed != 0, 0.1, 1e3 * relative)
            error = where(error <= 1.0 and not change <= allowed, 1e3, error)
        if method.length is None and any(error <= 1.0):  # a state without rates is invalid
            run.rates(run.after, run.end, run.c, run.k[12])
            run.evaluated += 1
            finite = are_finite(run.k[12], run.n)
            error = where(error <= 1.0 and not finite, math.nan, error)
    return error


@part
def blamed(run: Run, lane: int) -> int:
    """Return the first component of a lane that is not finite, in the first row that has one, or -1."""
    for j in range(1, 13):
        i = not_finite(run.k[j], run.n, lane)
        if i >= 0:
            return i
    i = not_finite(run.y_new, run.n, lane)
    if i < 0:
        i = not_finite(run.error5, run.n, lane)
    if i < 0:
        i = not_finite(run.error3, run.n, lane)
    return i


@part
def follow_events(run: Run) -> int:
    """Find and log the events of an accepted step, or, if its search has begun, of what is left of it.

    If the log is full, the search goes on at the next call, and ``seen`` is below 1 until then. Return RUNNING,
    TERMINAL, UNDEFINED, UNRESOLVED, or DIVERGED: the step is to be a shorter one.
    """
    search, status, logged = run.search, RUNNING, -1
    if search.seen == 1.0:
        logged = run.events
        if method.expect is not None:
            method.expect(run, run.h)
        search.seen, search.span, search.unresolved = 0.0, 1.0, 0
        run.reached = run.base = -1.0
    first = True
    while status == RUNNING and search.seen < 1.0 and (first or run.events <= run.room):
        first, rejects = False, 1 if logged >= 0 and run.fixed == 0 else 0
        stop = log_events(run, find_events(run, rejects), rejects)
        if stop == TOO_LONG:
            run.events, search.seen = logged, 1.0
            return DIVERGED
        if stop >= 0.0:
            status = TERMINAL
            if stop == search.reach:
                status = UNDEFINED if search.unresolved <= MOST else UNRESOLVED
                run.blame = search.culprit
            if stop != 1.0:
                run.after = run.t + stop * run.h
            search.seen = 1.0
    return status


@part.inlined
def pass_step(run: Run, good: Truth) -> None:
    """Make the end of a good step the start of the next."""
    run.t = where(good, run.after, run.t)
    run.y[:] = where(good, run.end, run.y)
    if method.length is None:
        run.k[0][:] = where(good, run.k[12], run.k[0])
    else:
        run.after_rejection = where(good, 0, run.after_rejection)
    if method.accept is not None:
        method.accept(run, good)


@part
def accept(run: Run) -> int:
    """Take a step, whose start goes to the buffers, or go on with its events.

    If the log of events is full, the step is taken at the next call. A step too long for its events is rejected.
    Return RUNNING, FINISHED, TERMINAL, STIFF, UNDEFINED or UNRESOLVED.
    """
    search, status = run.search, RUNNING
    if search.seen == 1.0:
        run.taken += 1
        if method.hold is not None:
            method.hold(run)
        if (method.last_stage != 0 or method.limited is not None) and is_stiff(run, True):
            run.stiffness += 1
            if run.stop_if_stiff != 0:
                status = STIFF
    if watched and search.count > 0:
        stop = follow_events(run)
        if search.seen < 1.0:
            return RUNNING
        if stop == DIVERGED:
            run.error = math.nan
            if method.prepare is not None:
                method.prepare(run, True)
            return look(run)
        if stop != RUNNING:
            status, run.last = stop, 0
    k = run.accepted
    run.times[k], run.lengths[k] = run.t, run.h
    for i in range(run.n):
        run.states[k, i] = run.y[i]
    run.accepted = k + 1
    pass_step(run, True)
    return FINISHED if run.last != 0 else status


@part
def advance(run: Run) -> int:
    """Step until the end, a terminal event, a failure, or until the buffers are full.

    Return RUNNING, FINISHED, TERMINAL, NOT_FINITE, COLLAPSED, DIVERGED, STIFF, UNDEFINED or UNRESOLVED.
    """
    run.accepted = run.events = 0
    if run.taken == 0 and method.prepare is not None:
        method.prepare(run, True)
    status = RUNNING
    while status == RUNNING and run.accepted < run.room and run.events <= run.room:
        begins = run.search.seen == 1.0
        if begins:
            status = choose_length(run)
        if status == RUNNING:
            if begins:
                run.error = error_of_step(run)
            good = run.error <= 1.0
            if good:
                status = accept(run)
                good = run.error <= 1.0
            if (method.length is None or not good) and status == RUNNING and run.search.seen == 1.0:
                status = change_length(run, run.error, good)
    k = run.accepted
    run.times[k] = run.t
    for i in range(run.n):
        run.states[k, i] = run.y[i]
    return status


@part
def clear(run: Run) -> None:
    """Set the rows of a step to zero, but not its state."""
    for j in range(STAGES):
        run.k[j][:] = 0.0
    run.argument[:] = 0.0
    run.y_new[:] = 0.0
    run.error5[:] = 0.0
    run.error3[:] = 0.0
    run.end[:] = 0.0


@part
def piece(run: Run) -> int:
    """Compute a run, or its next piece.

    If a run cannot begin, the buffers hold its start and no steps. In the buffers the lengths follow the times, and the
    states follow the lengths, without gaps.
    """
    status = RUNNING
    if run.taken == 0:
        clear(run)
        for i in range(run.n):
            run.y[i] = run.initial[i]
        normalise(run, run.y)
        run.times[0] = run.t
        for i in range(run.n):
            run.states[0, i] = run.y[i]
        status = launch(run)
        if watched and run.search.count > 0 and status == RUNNING:
            status = look(run)
    if status == RUNNING:
        status = advance(run)
    close_gaps(run)
    return status
