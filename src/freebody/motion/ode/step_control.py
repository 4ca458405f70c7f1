"""The loop around the step of any method: control of its length, projection, located events, output.

    y' = f(t, y, c)

A method (`dop853`, `dop54`, `radau`, `gauss`, `structure`) brings what a step is; the rest is here, once. `functions`
makes the compiled loop of one method: the functions of this module with the names below bound to that method.

A step is tried, judged, and taken when its error ε is at most 1. The next is h · 0.9 ε^-(1/k - 3β/4 ...) ε_old^β (a
proportional-integral control), within bounds that the method states. Steps of a fixed length are taken whatever their
error.

Unit quaternions are normalised after each accepted step. The correction is of the size of the local error, O(h^(p+1)),
and f is taken at the corrected state, so that order p is kept. The dense output is the polynomial from the state at
the start of the step to its uncorrected end, with each quaternion divided by its norm where it is evaluated: it
meets the corrected state at the end of the step and is continuous.

The dense output serves to find events (`event_search`). It is not stored, and no result depends on it: steps are
long, and its error may exceed the tolerance. A state inside a step, of an event or for output (`sample`), is the end of
a shorter step from the same start: of the order of the method, and at the end of the step the very result of the run.
So a run keeps n numbers per step.

Kernels are called by address (`machine.call`). Arrays are pointers to their first number, so that no step allocates,
counts references, tests a bound or raises. `loop` compiles it once and keeps it on the disk; this module is imported
only for that. Each function becomes one of C (`translation`), with arguments of the types it is annotated with.

The file is longer than others: it is the one loop, which no Python may interrupt.
"""

from __future__ import annotations

import math
from typing import Any

from ...native.instructions import (
    EPS,
    Compiled,
    Integers,
    Parts,
    Reals,
    call,
    compiled,
    greater,
    integers_at,
    lesser,
    reals_at,
    root,
    whole,
)
from ...native.row_arithmetic import copied
from . import event_search
from .event_search import event_value, find_events, insert_event
from .layout import (
    ACCEPTED,
    AFTER_REJECTION,
    ARGUMENT,
    ASKED,
    BLAME,
    CALM,
    CLEARED,
    COLLAPSED,
    CULPRIT,
    DENSE,
    DIVERGED,
    END,
    ERROR5,
    EVALUATED,
    EVENTS,
    FINISHED,
    FIXED,
    FOUND,
    LOGGED,
    MANY,
    MAX_STEP,
    NAMED,
    NOT_FINITE,
    NUMBERS,
    OF_ORDER,
    OLD_ERROR,
    POINT,
    PROJECTED,
    PROJECTION,
    RAW,
    REACH,
    REJECTED,
    RUNNING,
    START,
    STATE,
    STEP,
    STIFF,
    STIFFNESS,
    SUSPECT,
    TAKEN,
    TERMINAL,
    TIME,
    UNDEFINED,
    UNTIL,
)

_EPS, _TINY = EPS, 1e-300

# What a method brings: numbers, and compiled functions (see `dop853` for their arguments).
SAFETY, SMALLEST, GREATEST = 0.9, 1.0 / 3.0, 6.0
"""Of the control: factor on the next step, and bounds of its change."""
EXPONENT, BETA = 0.125, 0.0
"""The next step goes with ε^-EXPONENT ε_old^BETA."""
COST, COST_DENSE = 0, 0
"""Evaluations of f in `attempt` and in `densify`; a method that iterates counts its own."""
LAST, LIMIT = 0, 0.0
"""Row of the last stage of an explicit method, whose time is that of the end, and where its region of stability ends
on the negative axis; 0: the method is not watched for stiffness."""

WHOLE = 0
"""1: there is one step, whose error is judged whatever its length, and states inside it are those of the dense output,
as accurate as its end; else each is the end of a shorter step."""
GIVEN = 0
"""1: the lengths of the steps follow from the state at their start, by the method's function of this name, and no
error is left to be judged; the rates at the end of a step are not needed."""

prepare: Any = None
"""(rates, t, work, w, n, c, q, nq, integers): before the first step from a new start."""
given: Any = None
"""(t, work, w, n, c, q, nq, relative, absolute, integers) -> length of the next step from STATE, where they are given;
nan if it has none."""
limited: Any = None
"""(work, w, n, h) -> 1 if stability limits the step, where the lengths are given."""
attempt: Any = None
"""(rates, t, h, work, w, n, c, q, nq, relative, absolute, integers) -> 0, or 1 where the iteration diverges: a step
from STATE, whose rates are row 0, to RAW."""
judge: Any = None
"""(n, work, w, h, relative, absolute, integers) -> error in units of the tolerance, nan if it is not finite."""
densify: Any = None
"""(rates, t, h, work, w, n, c, q, nq): prepares `interpolate`; row 12 holds the rates at END."""
interpolate: Any = None
"""(x, work, w): row POINT at the part x of the step."""
hold: Any = None
"""(work, w, n): the step will be taken; parts of it may be tried before it is."""
accept: Any = None
"""(work, w, n): the step was taken, STATE is its end."""


@compiled
def nothing_to_prepare(
    rates: int, t: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int, integers: Integers
) -> None:  # fmt: skip
    """`prepare` of a method of one step, which needs the state only."""


@compiled
def nothing_to_densify(
    rates: int, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int
) -> None:
    """`densify` of a method whose held stages are the dense output."""


@compiled
def cubic(work: Reals, w: int, h: float, last: int) -> None:
    """Rows DENSE to DENSE + 2 of the cubic through the states and rates at both ends; row ``last`` are those at the
    end."""
    for i in range(w):
        difference = work[RAW * w + i] - work[STATE * w + i]
        work[DENSE * w + i] = difference
        work[(DENSE + 1) * w + i] = h * work[i] - difference
        work[(DENSE + 2) * w + i] = 2.0 * difference - h * (work[last * w + i] + work[i])


@compiled
def nothing_to_keep(work: Reals, w: int, n: int) -> None:
    """`accept` of a method that carries the state only."""


part = Parts()


class Functions(dict[str, Compiled]):
    """The compiled loop of a method: these functions, and the method's own."""

    def __init__(self, method: dict[str, Any]) -> None:
        space = {**vars(event_search), **globals(), **method}
        given = {name: value for name, value in method.items() if isinstance(value, Compiled)}
        super().__init__({**given, **event_search.part.bound(space), **part.bound(space)})
        self.method = method


@part
def normalise(work: Reals, row: int, quaternions: Integers, nq: int) -> None:
    for k in range(nq):
        i = row + quaternions[k]
        a, b, c, d = work[i], work[i + 1], work[i + 2], work[i + 3]
        s = root(a * a + b * b + c * c + d * d)
        for j in range(4):
            work[i + j] /= s


@part
def project(t: float, work: Reals, row: int, w: int, quaternions: Integers, nq: int, c: Reals) -> float:
    """Onto the constraints, if there are any: the kernel whose address follows the places of the quaternions.

    It takes one Newton step, whose error is the square of the change: one below 1e-8 has reached round-off. The
    result is the change of the first step, relative to 1 + |value|.
    """
    first = 0.0
    if quaternions[nq + PROJECTION] != 0:
        change, k = 1.0, 0
        while change > 1e-8 and k < 5:
            call(quaternions[nq + PROJECTION], t, work, row, c, work, ERROR5 * w)
            change = 0.0
            for i in range(quaternions[nq + PROJECTED]):
                new = work[ERROR5 * w + i]
                change = greater(change, abs(new - work[row + i]) / (1.0 + abs(new)))
                work[row + i] = new
            normalise(work, row, quaternions, nq)
            if k == 0:
                first = change
            k += 1
    return first


@part
def _first_not_finite(work: Reals, w: int, n: int, row: int, rows: int) -> int:
    """The first component that is not finite in the first of ``rows`` rows that has one, or -1."""
    for k in range(row, row + rows):
        for i in range(n):
            if not math.isfinite(work[k * w + i]):
                return i
    return -1


@part
def inside(x: float, work: Reals, w: int, quaternions: Integers, nq: int) -> None:
    """Row POINT: the dense output at the part ``x`` (0 to 1) of the step, with unit quaternions."""
    interpolate(x, work, w)
    normalise(work, POINT * w, quaternions, nq)


@part
def _copy(source: Reals, row: int, target: Reals, place: int, n: int) -> None:
    for i in range(n):
        target[place + i] = source[row + i]


@part
def _shorter(
    rates: int, x: float, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int,
    relative: Reals, absolute: Reals, integers: Integers,
) -> None:  # fmt: skip
    """Row POINT: the end of a step of the length x h from the same start."""
    if attempt(rates, t, x * h, work, w, n, c, quaternions, nq, relative, absolute, integers) != 0:
        for i in range(n):
            work[RAW * w + i] = math.nan
    integers[EVALUATED] += COST
    copied(work, w, RAW, POINT)
    normalise(work, POINT * w, quaternions, nq)
    project(t + x * h, work, POINT * w, w, quaternions, nq, c)


@part
def _part(
    rates: int, x: float, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int,
    relative: Reals, absolute: Reals, integers: Integers,
) -> None:  # fmt: skip
    """Row POINT: the state at the part ``x`` of the step, by a step of its own from the same start, or, where a step is
    WHOLE, from the dense output."""
    if WHOLE != 0:
        inside(x, work, w, quaternions, nq)
    else:
        _shorter(rates, x, t, h, work, w, n, c, quaternions, nq, relative, absolute, integers)


@part
def _refine(
    rates: int, events: int, e: int, sign: int, x: float, t: float, h: float, work: Reals, w: int, n: int,
    c: Reals, ce: Reals, quaternions: Integers, nq: int, g: Reals, relative: Reals, absolute: Reals,
    integers: Integers,
) -> float:  # fmt: skip
    """An event at the part ``x`` of the step, moved from the zero on the dense output to that on `_part`.

    Newton's method with the slope of the dense output; where that is of no use, in a grazing pass, ``x`` stays.
    The result lies where the sign has changed, so that a run that starts again there does not find it once more.
    """
    d = lesser(1e-4, lesser(x, 1.0 - x))
    if d <= 0.0:
        return x
    high = event_value(events, e, x + d, t, h, work, w, ce, quaternions, nq, g)
    low = event_value(events, e, x - d, t, h, work, w, ce, quaternions, nq, g)
    slope = (high - low) / (2.0 * d)
    if not sign * slope > 0.0:
        return x
    width = 2.0 * _EPS * greater(1.0, abs(t / h))
    best = x
    for k in range(16):
        _part(rates, best, t, h, work, w, n, c, quaternions, nq, relative, absolute, integers)
        call(events, t + best * h, work, POINT * w, ce, g, 0)
        shift = -g[e] / slope
        if k < 6 and abs(shift) > width:
            if abs(best + shift - x) > 0.02:
                return x
            best = lesser(1.0, greater(0.0, best + shift))
        elif sign * g[e] >= 0.0:
            return best
        else:
            best = lesser(1.0, best + width)
            width *= 2.0
    return x


@part
def _log_events(
    rates: int, events: int, count: int, t: float, h: float, after: float, start: float, n: int,
    work: Reals, w: int, c: Reals, ce: Reals, quaternions: Integers, nq: int, g: Reals, found: Reals,
    terminal: Integers, event_log: Reals, event_states: Reals, logged: int, relative: Reals, absolute: Reals,
    integers: Integers,
) -> float:  # fmt: skip
    """Copy the events of a step to the log, up to the first terminal one, whose part of the step is returned (or -1).

    Events within 1e-12 of the terminal one happen together with it and are kept. A terminal event at the very start
    does not stop: a motion could not be started again from it. Where a function has no value any more, the step stops
    as at a terminal event. ``found[3]`` becomes the number of events that was kept.
    """
    reach = found[REACH]
    for k in range(count):
        x, e, sign = found[FOUND * k], found[FOUND * k + 1], found[FOUND * k + 2]
        x = _refine(
            rates, events, whole(e), whole(sign), x, t, h, work, w, n, c, ce, quaternions, nq, g, relative,
            absolute, integers,
        )  # fmt: skip
        insert_event(found, k, x, e, sign)
    stop, latest, kept = -1.0, reach, 0
    for k in range(count):
        x = found[FOUND * k]
        if x > latest:
            break
        moment, row = after, END * w
        if x == 0.0:
            moment, row = t, STATE * w
        elif x != 1.0:
            moment, row = t + x * h, POINT * w
            _part(rates, x, t, h, work, w, n, c, quaternions, nq, relative, absolute, integers)
        place = logged + k
        event_log[LOGGED * place] = moment
        event_log[LOGGED * place + 1] = found[FOUND * k + 1]
        event_log[LOGGED * place + 2] = found[FOUND * k + 2]
        _copy(work, row, event_states, place * n, n)
        kept += 1
        if stop < 0.0 and terminal[whole(found[FOUND * k + 1])] != 0 and moment != start:
            stop = x
            latest = lesser(latest, x + 1e-12 * greater(1.0, abs(t / h)))
    if stop < 0.0 and reach <= 1.0:
        stop = reach
    if stop == 0.0:
        _copy(work, STATE * w, work, END * w, w)
    elif 0.0 < stop < 1.0:
        _part(rates, stop, t, h, work, w, n, c, quaternions, nq, relative, absolute, integers)
        copied(work, w, POINT, END)
    found[3] = kept
    return stop


@part
def _stiff(work: Reals, w: int, n: int, h: float, integers: Integers) -> int:
    """Whether steps have been as long as the region of stability allows, h |λ| > LIMIT, for 15 steps.

    |λ| is taken from the last stage and the end of the step, two states at one time; λ must be that of a decay, since a
    vibration that an explicit method can not follow is none for an implicit one either. Six steps without suspicion end
    it (Hairer and Wanner, section IV.2).
    """
    above, below, across = 0.0, 0.0, 0.0
    if GIVEN != 0:
        suspect = limited(work, w, n, h) != 0
    else:
        for i in range(n):
            a = work[12 * w + i] - work[LAST * w + i]
            b = work[END * w + i] - work[ARGUMENT * w + i]
            above += a * a
            below += b * b
            across += a * b
        decays = h * across < -0.5 * abs(h) * root(above * below)
        suspect = decays and h * h * above > LIMIT * LIMIT * below and below > 0.0
    if suspect:
        integers[SUSPECT] += 1
        integers[CALM] = 0
    else:
        integers[CALM] += 1
        if integers[CALM] == 6:
            integers[SUSPECT] = 0
    return 1 if integers[SUSPECT] >= 15 else 0


@part
def first_length(
    rates: int, t: float, direction: float, longest: float, work: Reals, w: int, n: int, c: Reals, relative: Reals,
    absolute: Reals, order: float,
) -> float:  # fmt: skip
    """A length for the first step (Hairer, Norsett, Wanner, section II.4).

    Row STATE holds y, row 0 its rates; rows POINT and 1 are used."""
    if n == 0:
        return longest
    size, slope = 0.0, 0.0
    for i in range(n):
        scale = absolute[i] + relative[i] * abs(work[STATE * w + i])
        size = greater(size, abs(work[STATE * w + i]) / scale)
        slope = greater(slope, abs(work[i]) / scale)
    guess = 1e-6
    if not (size < 1e-5 or slope < 1e-5):
        guess = 0.01 * size / slope
    guess = lesser(guess, longest)
    for i in range(n):
        work[POINT * w + i] = work[STATE * w + i] + direction * guess * work[i]
    call(rates, t + direction * guess, work, POINT * w, c, work, w)
    curve = 0.0
    for i in range(n):
        scale = absolute[i] + relative[i] * abs(work[STATE * w + i])
        bend = abs(work[w + i] - work[i]) / scale
        if not math.isfinite(bend):
            return guess
        curve = greater(curve, bend)
    curve /= guess
    if not math.isfinite(curve):
        return guess
    steepest = greater(slope, curve)
    other = greater(1e-6, guess * 1e-3)
    if steepest > 1e-15:
        other = (0.01 / steepest) ** (1.0 / order)
    return lesser(lesser(100.0 * guess, other), longest)


@part
def launch(
    rates: int, work: Reals, w: int, n: int, c: Reals, relative: Reals, absolute: Reals, reals: Reals,
    integers: Integers,
) -> int:  # fmt: skip
    """What goes before the first step from STATE: its rates and, where none is given, its length.

    NOT_FINITE where there are no rates, FINISHED where there is nowhere to go, else RUNNING.
    """
    t, until = reals[TIME], reals[UNTIL]
    direction = 1.0 if until >= t else -1.0
    longest = lesser(reals[MAX_STEP], abs(until - t))
    reals[OLD_ERROR] = 1e-4
    if GIVEN == 0:
        call(rates, t, work, STATE * w, c, work, 0)
        integers[EVALUATED] += 1
        integers[BLAME] = _first_not_finite(work, w, n, 0, 1)
        if integers[BLAME] >= 0:
            return NOT_FINITE
        integers[BLAME] = 0
    if longest == 0.0:
        return FINISHED
    if GIVEN == 0 and reals[STEP] == 0.0:
        reals[STEP] = first_length(
            rates, t, direction, longest, work, w, n, c, relative, absolute, reals[OF_ORDER]
        )  # fmt: skip
        integers[EVALUATED] += 1
        for i in range(w):  # rows that only the first step has used
            work[POINT * w + i] = 0.0
            work[w + i] = 0.0
    reals[STEP] = direction * lesser(reals[STEP], longest)
    return RUNNING


@part
def look(
    kernel: int, t: float, work: Reals, w: int, m: int, c: Reals, table: Reals, last: Integers, integers: Integers
) -> int:  # fmt: skip
    """The event functions at STATE, and their signs: what `find_events` begins with. UNDEFINED where one has none, else
    RUNNING."""
    call(kernel, t, work, STATE * w, c, table, 0)
    for e in range(m):
        last[e] = 1 if table[e] > 0.0 else (-1 if table[e] < 0.0 else 0)
        if e < integers[NAMED] and not math.isfinite(table[e]):
            integers[BLAME] = e
            return UNDEFINED
    return RUNNING


@part
def lengthening(error: float, old: float) -> float:
    """What a step that was taken is multiplied by."""
    if error > 0.0:
        return lesser(GREATEST, greater(SMALLEST, SAFETY * old**BETA / error**EXPONENT))
    return GREATEST


@part
def advance(
    rates: int, n: int, c: Reals, work: Reals, w: int, quaternions: Integers, nq: int, relative: Reals,
    absolute: Reals, reals: Reals, integers: Integers, room: int, times: Reals, lengths: Reals,
    states: Reals, events: int, m: int, ce: Reals, directions: Integers, terminal: Integers, last: Integers,
    table: Reals, g: Reals, found: Reals, event_log: Reals, event_states: Reals,
) -> int:  # fmt: skip
    """Step until the end, a terminal event, a failure, or until the buffers are full.

    Parameters
    ----------
    rates, n, c          address of the kernel, number of components, constants of the kernel
    work, w              rows of length ``w``; row STATE holds y, row 0 its rates
    quaternions, nq      places of the unit quaternions in y, and their number; two more entries hold the address of
                         the kernel that moves a state onto the constraints, or 0, and the number of its outputs
    relative, absolute   tolerance of each component
    reals, integers      what is carried from call to call (`layout`)
    room                 number of steps the buffers hold, and of events besides those of the last step
    times, lengths, states   buffers: time, length and state at the start of each accepted step; then time and state of
                         the end of the last
    events, m, ce        address of the event functions, their number, which may be 0, and constants
    directions, terminal what is asked of each
    last, table, g, found    room for the search (`find_events`)
    event_log, event_states  buffers: (time, number, sign) and state of each event

    Returns
    -------
    int                  RUNNING, FINISHED, TERMINAL, NOT_FINITE, COLLAPSED, DIVERGED, STIFF or UNDEFINED
    """
    t, h, old = reals[TIME], reals[STEP], reals[OLD_ERROR]
    until, longest = reals[UNTIL], reals[MAX_STEP]
    direction = 1.0 if until >= t else -1.0
    accepted, logged, full = 0, 0, False
    integers[ACCEPTED] = integers[EVENTS] = 0
    status = RUNNING
    if integers[TAKEN] == 0:
        prepare(rates, t, work, w, n, c, quaternions, nq, integers)
    allowed = 0.0
    for i in range(n):
        allowed = greater(allowed, 1e3 * relative[i])
    if integers[FIXED] != 0:
        allowed = 0.1  # their error may be any
    while accepted < room and not full:
        if GIVEN != 0:
            size = given(t, work, w, n, c, quaternions, nq, relative, absolute, integers)
            if size != size:
                status = NOT_FINITE
                break
            if integers[FIXED] == 0 and integers[AFTER_REJECTION] == 0:
                h = direction * size
        if abs(h) > longest:
            h = direction * longest
        ends = (t + 1.01 * h - until) * direction >= 0.0
        if ends:
            h = until - t
        elif abs(h) <= 8.0 * _EPS * abs(t) or abs(h) < _TINY:
            status = COLLAPSED
            break
        after = until if ends else t + h
        if integers[FIXED] != 0 and not ends:
            after = reals[START] + (integers[TAKEN] + 1) * h
        failed = attempt(rates, t, h, work, w, n, c, quaternions, nq, relative, absolute, integers)
        integers[EVALUATED] += COST
        error = 1e3
        if failed == 0:
            error = judge(n, work, w, h, relative, absolute, integers)
            copied(work, w, RAW, END)
            normalise(work, END * w, quaternions, nq)
        if integers[FIXED] != 0 and error > 1.0 and failed == 0 and WHOLE == 0:
            error = 1.0
        if error <= 1.0 and not project(after, work, END * w, w, quaternions, nq, c) <= allowed:
            error = 1e3  # not the error of a step, but another branch: the constraints end here, or bend too sharply
        # a state without rates is no state: those at the end must be numbers, too
        if GIVEN == 0 and error <= 1.0:
            call(rates, after, work, END * w, c, work, 12 * w)
            integers[EVALUATED] += 1
            if _first_not_finite(work, w, n, 12, 1) >= 0:
                error = math.nan
        if not error <= 1.0:
            integers[REJECTED] += 1
            integers[AFTER_REJECTION] = 1
            if error == error:
                if integers[FIXED] != 0:
                    status = DIVERGED
                    break
                h *= greater(SMALLEST, SAFETY / error**EXPONENT)
                continue
            integers[BLAME] = _first_not_finite(work, w, n, 1, 12)
            if integers[BLAME] < 0:
                integers[BLAME] = _first_not_finite(work, w, n, RAW, 3)
            h *= 0.25
            if integers[FIXED] != 0 or abs(h) <= 16.0 * _EPS * abs(t) or abs(h) < _TINY:
                status = NOT_FINITE
                break
            continue

        times[accepted] = t
        lengths[accepted] = h
        _copy(work, STATE * w, states, accepted * n, n)
        accepted += 1
        integers[TAKEN] += 1
        hold(work, w, n)
        if (
            (LAST != 0 or GIVEN != 0)
            and _stiff(work, w, n, h, integers) != 0
            and abs(until - after) > MANY * abs(h)
        ):
            integers[STIFFNESS] += 1
            if integers[ASKED] != 0:
                status = STIFF
        if m > 0:
            densify(rates, t, h, work, w, n, c, quaternions, nq)
            integers[EVALUATED] += COST_DENSE
            count = find_events(
                events, t, h, work, w, ce, quaternions, nq, m, integers[NAMED], table, g, last, directions, found
            )  # fmt: skip
            reach = found[REACH]
            stop = _log_events(
                rates, events, count, t, h, after, reals[START], n, work, w, c, ce, quaternions, nq, g, found,
                terminal, event_log, event_states, logged, relative, absolute, integers,
            )  # fmt: skip
            logged += whole(found[3])
            full = logged > room
            if stop >= 0.0:
                status = TERMINAL
                if stop == reach:
                    status, integers[BLAME] = UNDEFINED, whole(found[CULPRIT])
                after = after if stop == 1.0 else t + stop * h
        t = after
        copied(work, w, END, STATE)
        if GIVEN == 0:
            copied(work, w, 12, 0)
        accept(work, w, n)
        stopped = status == TERMINAL or status == UNDEFINED  # "in" would call Python
        if stopped or (status == STIFF and not ends):
            break
        if ends:
            status = FINISHED
            break
        if integers[FIXED] != 0:
            continue
        factor = lengthening(error, old)
        if integers[AFTER_REJECTION] != 0:
            factor = lesser(1.0, factor)
            integers[AFTER_REJECTION] = 0
        h *= factor
        old = greater(error, 1e-4)
    times[accepted] = t
    _copy(work, STATE * w, states, accepted * n, n)
    reals[TIME], reals[STEP], reals[OLD_ERROR] = t, h, old
    integers[ACCEPTED], integers[EVENTS] = accepted, logged
    return status


@part
def run(told: Integers) -> int:
    """A run, or its next part: `advance` with its arguments in memory, numbers or addresses, in the order of `layout`.

    A run that can not begin has its start in the buffers, and no steps. In the buffers the lengths follow upon the
    times, and the states upon the lengths, without a gap.
    """
    rates, nq, quaternions, c = told[0], told[1], integers_at(told[2]), reals_at(told[3])
    events, ce, room, n, m, w = told[4], reals_at(told[5]), told[6], told[7], told[8], told[9]
    work, last, table = reals_at(told[10]), integers_at(told[11]), reals_at(told[12])
    g, found, relative = reals_at(told[13]), reals_at(told[14]), reals_at(told[15])
    absolute, start, reals = reals_at(told[16]), reals_at(told[17]), reals_at(told[18])
    integers, directions, terminal = integers_at(told[19]), integers_at(told[20]), integers_at(told[21])
    times, lengths, states = reals_at(told[22]), reals_at(told[23]), reals_at(told[24])
    status = RUNNING
    if integers[TAKEN] == 0:
        for i in range((told[NUMBERS + CLEARED] - told[NUMBERS]) // 8):
            work[i] = 0.0
        _copy(start, 0, work, STATE * w, n)
        normalise(work, STATE * w, quaternions, nq)
        times[0] = reals[TIME]
        _copy(work, STATE * w, states, 0, n)
        status = launch(rates, work, w, n, c, relative, absolute, reals, integers)
        if m > 0 and status == RUNNING:
            status = look(events, reals[TIME], work, w, m, ce, table, last, integers)
    if status == RUNNING:
        status = advance(
            rates, n, c, work, w, quaternions, nq, relative, absolute, reals, integers, room, times, lengths, states,
            events, m, ce, directions, terminal, last, table, g, found, reals_at(told[25]), reals_at(told[26]),
        )  # fmt: skip
    done = integers[ACCEPTED]
    _copy(lengths, 0, times, done + 1, done)
    _copy(states, 0, times, 2 * done + 1, (done + 1) * n)
    return status


@part
def sample(
    rates: int, n: int, c: Reals, work: Reals, w: int, quaternions: Integers, nq: int, steps: int,
    times: Reals, lengths: Reals, states: Reals, dense: int, count: int, wanted: Reals, result: Reals,
    relative: Reals, absolute: Reals, integers: Integers,
) -> None:  # fmt: skip
    """States at the times ``wanted``, each within the run.

    With ``dense`` 0 each is the end of a shorter step from the start of the step it lies in; otherwise it is taken
    from the dense output, which is faster where many lie in one step and come in the order of the run.
    """
    direction = 1.0 if times[steps] >= times[0] else -1.0
    current = -1
    for k in range(count):
        t = wanted[k]
        low, high = 0, steps  # times[low] <= t < times[high], in the direction of the run
        if current >= 0 and (t - times[current]) * direction >= 0.0 > (t - times[current + 1]) * direction:
            low, high = current, current + 1
        while high - low > 1:
            middle = (low + high) // 2
            if (t - times[middle]) * direction >= 0.0:
                low = middle
            else:
                high = middle
        if t == times[low] or t == times[high]:
            row = low if t == times[low] else high
            _copy(states, row * n, result, k * n, n)
            continue
        start, h = times[low], lengths[low]
        fresh = low != current
        if fresh:
            current = low
            _copy(states, low * n, work, STATE * w, n)
            call(rates, start, work, STATE * w, c, work, 0)
            prepare(rates, start, work, w, n, c, quaternions, nq, integers)
        x = (t - start) / h
        if (dense == 0 and WHOLE == 0) or fresh:
            _shorter(
                rates, 1.0 if dense != 0 or WHOLE != 0 else x, start, h, work, w, n, c, quaternions, nq, relative,
                absolute, integers,
            )  # fmt: skip
        if dense != 0 or WHOLE != 0:
            if fresh:
                call(rates, start + h, work, POINT * w, c, work, 12 * w)
                densify(rates, start, h, work, w, n, c, quaternions, nq)
                hold(work, w, n)
            inside(x, work, w, quaternions, nq)
        _copy(work, POINT * w, result, k * n, n)


@part
def observe(
    kernel: int, count: int, times: Reals, states: Reals, n: int, c: Reals, result: Reals, outputs: int,
) -> None:  # fmt: skip
    """Row k of ``result`` (length ``outputs``): what ``kernel`` gives at ``times[k]`` and row k of ``states``."""
    for k in range(count):
        call(kernel, times[k], states, k * n, c, result, k * outputs)
