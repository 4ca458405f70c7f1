"""The loop around the steps of any method: step-size control, projection, located events, output.

    y' = f(t, y, c)

A method (`dop853`, `dop54`, `radau`, `gauss`, `structure`, `taylor`) defines a step. Everything else is here, once.
`Functions` makes the compiled loop of one method: the functions of this module, with the names below bound to that
method.

A step is attempted, judged, and accepted if its error ε is at most 1. The next step is h · 0.9 ε^-(1/k - 3β/4 ...)
ε_old^β (proportional-integral control), within bounds that the method states. Steps of fixed length are accepted
whatever their error.

Unit quaternions are normalised after each accepted step. The correction is of the size of the local error, O(h^(p+1)),
and f is evaluated at the corrected state, so that the order p is kept. The dense output is the polynomial from the
state at the start of the step to its uncorrected end. Each quaternion is divided by its norm where the dense output is
evaluated, so that it meets the corrected state at the end of the step and is continuous.

The dense output serves to find events (`event_search`). It is not stored, and no result depends on it: steps are long,
and its error may exceed the tolerance. A state inside a step, of an event or for output (`sample`), is the end of a
shorter step from the same start. It has the order of the method, and at the end of the step it equals the result of the
run. So a run stores n numbers per step.

Kernels are called by address (`instructions.call`). Arrays are pointers to their first number: no step allocates,
counts references, tests a bound or raises. `loop` compiles this module once and keeps the result on the disk; the
module is imported only for that. Each function becomes a C function (`translation`) with the annotated argument types.

The file is longer than others: it is one loop, which Python may not interrupt.
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
    BLAME,
    CALM,
    CLEARED_ARRAYS,
    COLLAPSED,
    CULPRIT,
    DENSE,
    DIVERGED,
    END,
    ERROR5,
    EVALUATED,
    EVENT_SIZE,
    EVENTS,
    FINISHED,
    FIXED,
    LOG_SIZE,
    MANY,
    MAX_STEP,
    METHOD_ORDER,
    NOT_FINITE,
    NUMBERS,
    OLD_ERROR,
    POINT,
    PROJECTED,
    PROJECTION,
    RAW,
    REACH,
    REJECTED,
    REQUIRED,
    RUNNING,
    SAMPLED,
    START,
    STATE,
    STEP,
    STIFF,
    STIFFNESS,
    STOP_IF_STIFF,
    SUSPECT,
    TAKEN,
    TERMINAL,
    TIME,
    UNDEFINED,
    UNTIL,
)

_EPS, _TINY = EPS, 1e-300

# Bound to the numbers and compiled functions of a method (see `dop853`).
SAFETY, SMALLEST, GREATEST = 0.9, 1.0 / 3.0, 6.0
"""Constants of the control: factor on the next step, and bounds of its change."""
EXPONENT, BETA = 0.125, 0.0
"""The next step is proportional to ε^-EXPONENT ε_old^BETA."""
COST, COST_DENSE = 0, 0
"""Number of evaluations of f in `attempt` and in `densify`; 0 for a method that iterates and counts its own."""
LAST, LIMIT = 0, 0.0
"""Row of the last stage of an explicit method, whose time is that of the end, and the end of its region of stability on
the negative axis; 0 for a method that is not watched for stiffness."""

SINGLE_STEP = 0
"""1 if there is only one step. Its error is judged whatever its length, and states inside it come from the dense
output, which is as accurate as its end. Otherwise a state inside a step is the end of a shorter step."""
PREDICTED = 0
"""1 if the lengths of steps follow from the state at their start (`predicted_length`). No error has to be judged then,
and the rates at the end of a step are not needed."""

prepare: Any = None
"""(rates, t, work, w, n, c, q, nq, integers): called before the first step from a new start."""
predicted_length: Any = None
"""(t, work, w, n, c, q, nq, relative, absolute, integers) -> length of the next step from STATE, if lengths are
predicted; nan if there is none."""
limited_by_stability: Any = None
"""(work, w, n, h) -> 1 if stability limits the step, if lengths are predicted."""
attempt: Any = None
"""(rates, t, h, work, w, n, c, q, nq, relative, absolute, integers) -> 0, or 1 if the iteration diverges: one step from
STATE, whose rates are row 0, to RAW."""
judge: Any = None
"""(n, work, w, h, relative, absolute, integers) -> error in units of the tolerance, nan if it is not finite."""
densify: Any = None
"""(rates, t, h, work, w, n, c, q, nq): prepares `interpolate`; row 12 holds the rates at END."""
interpolate: Any = None
"""(x, work, w): sets row POINT at the fraction x of the step."""
hold: Any = None
"""(work, w, n): saves an accepted step, since shorter steps may be tried before `accept`."""
accept: Any = None
"""(work, w, n): the step was taken, and STATE is its end."""


@compiled
def nothing_to_prepare(
    rates: int, t: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int, integers: Integers
) -> None:  # fmt: skip
    """Do nothing: `prepare` of a one-step method, which needs only the state."""


@compiled
def nothing_to_densify(
    rates: int, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int
) -> None:
    """Do nothing: `densify` of a method whose saved stages are the dense output."""


@compiled
def cubic(work: Reals, w: int, h: float, last: int) -> None:
    """Set rows DENSE to DENSE + 2 of the cubic through the states and rates at both ends. Row ``last`` holds the rates
    at the end.
    """
    for i in range(w):
        difference = work[RAW * w + i] - work[STATE * w + i]
        work[DENSE * w + i] = difference
        work[(DENSE + 1) * w + i] = h * work[i] - difference
        work[(DENSE + 2) * w + i] = 2.0 * difference - h * (work[last * w + i] + work[i])


@compiled
def nothing_to_keep(work: Reals, w: int, n: int) -> None:
    """Do nothing: `hold` and `accept` of a method that carries only the state."""


part = Parts()


class Functions(dict[str, Compiled]):
    """The compiled loop of a method: the functions of this module, and the method's own."""

    def __init__(self, method: dict[str, Any]) -> None:
        space = {**vars(event_search), **globals(), **method}
        functions = {name: value for name, value in method.items() if isinstance(value, Compiled)}
        super().__init__({**functions, **event_search.part.bound(space), **part.bound(space)})
        self.method = method


@part
def normalise(work: Reals, row: int, quaternions: Integers, nq: int) -> None:
    """Divide each quaternion of a row by its norm."""
    for k in range(nq):
        i = row + quaternions[k]
        a, b, c, d = work[i], work[i + 1], work[i + 2], work[i + 3]
        s = root(a * a + b * b + c * c + d * d)
        for j in range(4):
            work[i + j] /= s


@part
def project(t: float, work: Reals, row: int, w: int, quaternions: Integers, nq: int, c: Reals) -> float:
    """Move a row onto the constraints, if there are any. The address of the kernel follows the indices of the
    quaternions.

    The kernel takes one Newton step, whose error is the square of the change: after a change below 1e-8 the result has
    reached round-off. Return the change of the first step, relative to 1 + |value|.
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
    """Return the first component that is not finite in the first of ``rows`` rows that has one, or -1."""
    for k in range(row, row + rows):
        for i in range(n):
            if not math.isfinite(work[k * w + i]):
                return i
    return -1


@part
def dense_state(x: float, work: Reals, w: int, quaternions: Integers, nq: int) -> None:
    """Set row POINT: the dense output at the fraction ``x`` (0 to 1) of the step, with unit quaternions."""
    interpolate(x, work, w)
    normalise(work, POINT * w, quaternions, nq)


@part
def _copy(source: Reals, row: int, target: Reals, place: int, n: int) -> None:
    """Copy ``n`` numbers."""
    for i in range(n):
        target[place + i] = source[row + i]


@part
def shorter_step(
    rates: int, x: float, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int,
    relative: Reals, absolute: Reals, integers: Integers,
) -> None:  # fmt: skip
    """Set row POINT: the end of a step of the length x h from the same start."""
    if attempt(rates, t, x * h, work, w, n, c, quaternions, nq, relative, absolute, integers) != 0:
        for i in range(n):
            work[RAW * w + i] = math.nan
    integers[EVALUATED] += COST
    copied(work, w, RAW, POINT)
    normalise(work, POINT * w, quaternions, nq)
    project(t + x * h, work, POINT * w, w, quaternions, nq, c)


@part
def state_in_step(
    rates: int, x: float, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int,
    relative: Reals, absolute: Reals, integers: Integers,
) -> None:  # fmt: skip
    """Set row POINT: the state at the fraction ``x`` of the step, by a shorter step from the same start, or, for a
    SINGLE_STEP, from the dense output.
    """
    if SINGLE_STEP != 0:
        dense_state(x, work, w, quaternions, nq)
    else:
        shorter_step(rates, x, t, h, work, w, n, c, quaternions, nq, relative, absolute, integers)


@part
def refined_event(
    rates: int, events: int, e: int, sign: int, x: float, t: float, h: float, work: Reals, w: int, n: int,
    c: Reals, ce: Reals, quaternions: Integers, nq: int, g: Reals, relative: Reals, absolute: Reals,
    integers: Integers,
) -> float:  # fmt: skip
    """Move an event at the fraction ``x`` of the step from the zero on the dense output to the zero on `state_in_step`.

    Newton's method uses the slope of the dense output. If the slope is useless, in a grazing pass, ``x`` stays. The
    sign has changed at the result, so that a run that starts again there does not find the event once more.
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
        state_in_step(rates, best, t, h, work, w, n, c, quaternions, nq, relative, absolute, integers)
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
def log_events(
    rates: int, events: int, count: int, t: float, h: float, after: float, start: float, n: int,
    work: Reals, w: int, c: Reals, ce: Reals, quaternions: Integers, nq: int, g: Reals, zeros: Reals,
    terminal: Integers, event_log: Reals, event_states: Reals, logged: int, relative: Reals, absolute: Reals,
    integers: Integers,
) -> float:  # fmt: skip
    """Copy the events of a step to the log, up to the first terminal event.

    Return the fraction of the step at the terminal event, or -1. Events within 1e-12 of the terminal one count as
    simultaneous and are kept. A terminal event at the very start does not stop the run: otherwise a motion could not be
    started again from it. Where a function loses its value, the step stops as at a terminal event. ``zeros[3]`` becomes
    the number of events kept.
    """
    reach = zeros[REACH]
    for k in range(count):
        x, e, sign = zeros[EVENT_SIZE * k], zeros[EVENT_SIZE * k + 1], zeros[EVENT_SIZE * k + 2]
        x = refined_event(
            rates, events, whole(e), whole(sign), x, t, h, work, w, n, c, ce, quaternions, nq, g, relative,
            absolute, integers,
        )  # fmt: skip
        insert_event(zeros, k, x, e, sign)
    stop, latest, logged_count = -1.0, reach, 0
    for k in range(count):
        x = zeros[EVENT_SIZE * k]
        if x > latest:
            break
        moment, row = after, END * w
        if x == 0.0:
            moment, row = t, STATE * w
        elif x != 1.0:
            moment, row = t + x * h, POINT * w
            state_in_step(rates, x, t, h, work, w, n, c, quaternions, nq, relative, absolute, integers)
        place = logged + k
        event_log[LOG_SIZE * place] = moment
        event_log[LOG_SIZE * place + 1] = zeros[EVENT_SIZE * k + 1]
        event_log[LOG_SIZE * place + 2] = zeros[EVENT_SIZE * k + 2]
        _copy(work, row, event_states, place * n, n)
        logged_count += 1
        if stop < 0.0 and terminal[whole(zeros[EVENT_SIZE * k + 1])] != 0 and moment != start:
            stop = x
            latest = lesser(latest, x + 1e-12 * greater(1.0, abs(t / h)))
    if stop < 0.0 and reach <= 1.0:
        stop = reach
    if stop == 0.0:
        _copy(work, STATE * w, work, END * w, w)
    elif 0.0 < stop < 1.0:
        state_in_step(rates, stop, t, h, work, w, n, c, quaternions, nq, relative, absolute, integers)
        copied(work, w, POINT, END)
    zeros[3] = logged_count
    return stop


@part
def is_stiff(work: Reals, w: int, n: int, h: float, integers: Integers) -> int:
    """Return 1 if steps were as long as the region of stability allows, h |λ| > LIMIT, for 15 steps.

    |λ| is estimated from the last stage and the end of the step, two states at one time. λ must be that of a decay: a
    vibration too fast for an explicit method is too fast for an implicit one, too. Six steps without suspicion reset
    the count (Hairer and Wanner, section IV.2).
    """
    above, below, across = 0.0, 0.0, 0.0
    if PREDICTED != 0:
        suspect = limited_by_stability(work, w, n, h) != 0
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
    """Return a length for the first step (Hairer, Norsett, Wanner, section II.4).

    Row STATE holds y, row 0 its rates. Rows POINT and 1 are overwritten.
    """
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
    """Prepare the first step from STATE: compute its rates and, if none is prescribed, its length.

    Return NOT_FINITE if there are no rates, FINISHED if the run has length zero, else RUNNING.
    """
    t, until = reals[TIME], reals[UNTIL]
    direction = 1.0 if until >= t else -1.0
    longest = lesser(reals[MAX_STEP], abs(until - t))
    reals[OLD_ERROR] = 1e-4
    if PREDICTED == 0:
        call(rates, t, work, STATE * w, c, work, 0)
        integers[EVALUATED] += 1
        integers[BLAME] = _first_not_finite(work, w, n, 0, 1)
        if integers[BLAME] >= 0:
            return NOT_FINITE
        integers[BLAME] = 0
    if longest == 0.0:
        return FINISHED
    if PREDICTED == 0 and reals[STEP] == 0.0:
        reals[STEP] = first_length(
            rates, t, direction, longest, work, w, n, c, relative, absolute, reals[METHOD_ORDER]
        )  # fmt: skip
        integers[EVALUATED] += 1
        for i in range(w):  # clear the rows used above
            work[POINT * w + i] = 0.0
            work[w + i] = 0.0
    reals[STEP] = direction * lesser(reals[STEP], longest)
    return RUNNING


@part
def look(
    kernel: int, t: float, work: Reals, w: int, m: int, c: Reals, table: Reals, last: Integers, integers: Integers
) -> int:  # fmt: skip
    """Evaluate the event functions at STATE, and their signs, for the first `find_events`.

    Return UNDEFINED if a required function has no value, else RUNNING.
    """
    call(kernel, t, work, STATE * w, c, table, 0)
    for e in range(m):
        last[e] = 1 if table[e] > 0.0 else (-1 if table[e] < 0.0 else 0)
        if e < integers[REQUIRED] and not math.isfinite(table[e]):
            integers[BLAME] = e
            return UNDEFINED
    return RUNNING


@part
def lengthening(error: float, old: float) -> float:
    """Return the factor from an accepted step to the next."""
    if error > 0.0:
        return lesser(GREATEST, greater(SMALLEST, SAFETY * old**BETA / error**EXPONENT))
    return GREATEST


@part
def advance(
    rates: int, n: int, c: Reals, work: Reals, w: int, quaternions: Integers, nq: int, relative: Reals,
    absolute: Reals, reals: Reals, integers: Integers, room: int, times: Reals, lengths: Reals,
    states: Reals, events: int, m: int, ce: Reals, directions: Integers, terminal: Integers, last: Integers,
    table: Reals, g: Reals, zeros: Reals, event_log: Reals, event_states: Reals,
) -> int:  # fmt: skip
    """Step until the end, a terminal event, a failure, or until the buffers are full.

    Parameters
    ----------
    rates, n, c          address of the kernel, number of components, constants of the kernel
    work, w              rows of length ``w``; row STATE holds y, row 0 its rates
    quaternions, nq      indices of the unit quaternions in y, and their number; two more entries hold the address of
                         the kernel that moves a state onto the constraints, or 0, and the number of its outputs
    relative, absolute   tolerance of each component
    reals, integers      numbers carried from call to call (`layout`)
    room                 number of steps that the buffers hold, and of events besides those of the last step
    times, lengths, states   buffers: time, length and state at the start of each accepted step; then time and state of
                         the end of the last
    events, m, ce        address of the event functions, their number, which may be 0, and constants
    directions, terminal directions and flags of the events
    last, table, g, zeros    memory of the search (`find_events`)
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
        allowed = 0.1  # steps of fixed length may have any error
    while accepted < room and not full:
        if PREDICTED != 0:
            size = predicted_length(t, work, w, n, c, quaternions, nq, relative, absolute, integers)
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
        if integers[FIXED] != 0 and error > 1.0 and failed == 0 and SINGLE_STEP == 0:
            error = 1.0
        if error <= 1.0 and not project(after, work, END * w, w, quaternions, nq, c) <= allowed:
            error = 1e3  # not a step error: another branch, or the constraints end or bend too sharply here
        # a state without rates is invalid: the rates at the end must be finite, too
        if PREDICTED == 0 and error <= 1.0:
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
            if PREDICTED == 0:  # the others have told it, since they have other rows
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
            (LAST != 0 or PREDICTED != 0)
            and is_stiff(work, w, n, h, integers) != 0
            and abs(until - after) > MANY * abs(h)
        ):
            integers[STIFFNESS] += 1
            if integers[STOP_IF_STIFF] != 0:
                status = STIFF
        if m > 0:
            densify(rates, t, h, work, w, n, c, quaternions, nq)
            integers[EVALUATED] += COST_DENSE
            count = find_events(
                events, t, h, work, w, ce, quaternions, nq, m, integers[REQUIRED], table, g, last, directions, zeros
            )  # fmt: skip
            reach = zeros[REACH]
            stop = log_events(
                rates, events, count, t, h, after, reals[START], n, work, w, c, ce, quaternions, nq, g, zeros,
                terminal, event_log, event_states, logged, relative, absolute, integers,
            )  # fmt: skip
            logged += whole(zeros[3])
            full = logged > room
            if stop >= 0.0:
                status = TERMINAL
                if stop == reach:
                    status, integers[BLAME] = UNDEFINED, whole(zeros[CULPRIT])
                after = after if stop == 1.0 else t + stop * h
        t = after
        copied(work, w, END, STATE)
        if PREDICTED == 0:
            copied(work, w, 12, 0)
        accept(work, w, n)
        stopped = status == TERMINAL or status == UNDEFINED  # "in" cannot be compiled
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
def run(arguments: Integers) -> int:
    """Compute a run, or its next piece: `advance` with its arguments in memory, numbers or addresses, in the order of
    `layout`.

    If a run cannot begin, the buffers hold its start and no steps. In the buffers the lengths follow the times, and the
    states follow the lengths, without gaps.
    """
    rates, nq, quaternions, c = arguments[0], arguments[1], integers_at(arguments[2]), reals_at(arguments[3])
    events, ce, room, n, m, w = (
        arguments[4],
        reals_at(arguments[5]),
        arguments[6],
        arguments[7],
        arguments[8],
        arguments[9],
    )
    work, last, table = reals_at(arguments[10]), integers_at(arguments[11]), reals_at(arguments[12])
    g, zeros, relative = reals_at(arguments[13]), reals_at(arguments[14]), reals_at(arguments[15])
    absolute, start, reals = reals_at(arguments[16]), reals_at(arguments[17]), reals_at(arguments[18])
    integers, directions, terminal = (
        integers_at(arguments[19]),
        integers_at(arguments[20]),
        integers_at(arguments[21]),
    )
    times, lengths, states = reals_at(arguments[22]), reals_at(arguments[23]), reals_at(arguments[24])
    status = RUNNING
    if integers[TAKEN] == 0:
        for i in range((arguments[NUMBERS + CLEARED_ARRAYS] - arguments[NUMBERS]) // 8):
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
            events, m, ce, directions, terminal, last, table, g, zeros, reals_at(arguments[25]),
            reals_at(arguments[26]),
        )  # fmt: skip
    done = integers[ACCEPTED]
    _copy(lengths, 0, times, done + 1, done)
    _copy(states, 0, times, 2 * done + 1, (done + 1) * n)
    return status


@part
def sample(
    rates: int, n: int, c: Reals, work: Reals, w: int, quaternions: Integers, nq: int, steps: int,
    times: Reals, lengths: Reals, states: Reals, dense: int, count: int, moments: Reals, result: Reals,
    relative: Reals, absolute: Reals, integers: Integers,
) -> None:  # fmt: skip
    """Compute the states at the times ``moments``, each within the run.

    If ``dense`` is 0, each is the end of a shorter step from the start of the step that contains its time. Otherwise it
    is taken from the dense output, which is faster if many times lie in one step and are in the order of the run. The
    step that ``work`` holds from the last call (SAMPLED) is not taken again.
    """
    direction = 1.0 if times[steps] >= times[0] else -1.0
    current = integers[SAMPLED] - 1
    for k in range(count):
        t = moments[k]
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
            integers[SAMPLED] = low + 1
            _copy(states, low * n, work, STATE * w, n)
            call(rates, start, work, STATE * w, c, work, 0)
            prepare(rates, start, work, w, n, c, quaternions, nq, integers)
        x = (t - start) / h
        if (dense == 0 and SINGLE_STEP == 0) or fresh:
            shorter_step(
                rates, 1.0 if dense != 0 or SINGLE_STEP != 0 else x, start, h, work, w, n, c, quaternions, nq, relative,
                absolute, integers,
            )  # fmt: skip
        if dense != 0 or SINGLE_STEP != 0:
            if fresh:
                call(rates, start + h, work, POINT * w, c, work, 12 * w)
                densify(rates, start, h, work, w, n, c, quaternions, nq)
                hold(work, w, n)
            dense_state(x, work, w, quaternions, nq)
        _copy(work, POINT * w, result, k * n, n)


@part
def observe(
    kernel: int, count: int, times: Reals, states: Reals, n: int, c: Reals, result: Reals, outputs: int,
) -> None:  # fmt: skip
    """Set row k of ``result`` (length ``outputs``) to the outputs of ``kernel`` at ``times[k]`` and row k of
    ``states``.
    """
    for k in range(count):
        call(kernel, times[k], states, k * n, c, result, k * outputs)
