"""Zeros of event functions inside a step, located on the dense output, in order of time.

The step is searched window by window. A function is evaluated at some points of a window (`window`). The first window
is the step; it is halved until its points show how each function runs between them (`doubt`), so that functions with
many zeros in a step lose none.

If a function changes sign between two points, the zero is bracketed (method of Chandrupatla, 1997) and distinguished
from a pole. If it dips towards zero in between, the search follows the dip.

Events are then moved to the zeros on the states of the run itself, and logged. Points and events are fractions x of the
step, 0 to 1. `step_control` binds these functions to a method.
"""

from __future__ import annotations

import math

from ...native.instructions import EPS, Parts, Truth, greater, lesser, root
from .run import BEFORE, MARGIN, PARTS, Run
from .states import are_finite, dense_state, state_in_step
from .window import HALF_AS_MANY, doubt, evaluate, event_value, few_parts, forget, has_passed, tabulate

part = Parts()


FINEST = 1.0 / 4096.0
"""Shortest window, of which a step may hold MOST that do not resolve a function: it may have a jump, pole or bend."""
MOST = 64
FARTHEST = 0.02
"""Greatest fraction of the step by which an event moves from the dense output to the states."""
THROUGH_INFINITY = -1
"""In place of a number of events: a guarded function passes through infinity, as the force of a contact does where its
slip turns round unseen."""
TOO_LONG, BRIEF = -2.0, 2.0**-32
"""Answer that a step is too long for its events; length of a step, relative to 1 s or the time, that is not too long
for its dense output."""


@part
def find_events(run: Run, rejects: int) -> int:
    """Find the zeros of the event functions in the next window of the step, and make its end the start of the next.

    Return their number, and describe them in order of time. A change of sign through infinity is no zero. If a required
    function has no value, or too many zeros, the search ends there. If a guarded function changes its sign through
    infinity and ``rejects`` is 1, return `THROUGH_INFINITY`; in a brief step that is an event.

    Row k of the table holds all functions at the k-th point of the window, and x. Its first row comes from the window
    before. A function that arrives at zero is recorded there, and not again when it leaves. A function that begins at
    zero is recorded when it leaves.
    """
    search, n, named = run.search, run.search.count, run.required
    table, last = search.table, search.signs
    parts = few_parts(run)
    if parts < PARTS:
        go_on(run, PARTS + 2, parts <= 2)
        return 0
    points = tabulate(run)
    unknown = doubt(run, points)
    while search.span > FINEST and unknown >= 1.0:
        search.span *= 0.5
        forget(run)
        points = tabulate(run)
        unknown = doubt(run, points)
    reach, culprit = search.reach, search.culprit
    if unknown >= 1.0 and reach > 1.0 and culprit < n - search.guarded:
        search.unresolved += 1
        if search.unresolved > MOST:
            search.reach, search.seen = search.seen, 1.0
            return 0
    count = 0
    for e in range(n):
        for k in range(1, points + 1):
            a, b = table[k - 1, e], table[k, e]
            xa, xb = table[k - 1, n], table[k, n]
            if b == 0.0:
                if a != 0.0:
                    count = record_event(run, count, xb, e, -1 if a > 0.0 else 1)
                continue
            sign = 1 if b > 0.0 else -1
            if a == 0.0:
                if last[e] == 0:
                    count = record_event(run, count, xa, e, sign)
            elif (a > 0.0) != (b > 0.0):
                x = _root(run, e, xa, xb, a, b)
                if x >= 0.0:
                    count = record_event(run, count, x, e, sign)
                elif x < -1.0 and e < named:
                    reach, culprit = lesser(reach, xa), e
                elif e >= n - search.guarded and abs(a) + abs(b) < math.inf:
                    if rejects != 0 and is_long(run):
                        return THROUGH_INFINITY
                    count = record_event(run, count, xb, e, sign)
            elif k > 1:
                o, xo = table[k - 2, e], table[k - 2, n]
                if o != 0.0 and (o > 0.0) == (a > 0.0) and abs(a) < abs(o) and abs(a) <= abs(b):
                    x = _dip(run, e, xo, xa, xb, o, a, b)
                    if x < -1.0 and e < named:
                        reach, culprit = lesser(reach, xo), e
                    if x >= 0.0:
                        gx = event_value(run, e, x)
                        if gx == 0.0:
                            count = record_event(run, count, x, e, -sign)
                        else:
                            y = _root(run, e, xo, x, o, gx)
                            if y >= 0.0:
                                count = record_event(run, count, y, e, -sign)
                            y = _root(run, e, x, xb, gx, b)
                            if y >= 0.0:
                                count = record_event(run, count, y, e, sign)
            last[e] = sign
    count = zeros_before_stop(run, points, count)
    search.reach, search.culprit = reach, culprit
    go_on(run, points, unknown < HALF_AS_MANY)
    return count


@part
def is_long(run: Run) -> Truth:
    """Return whether the step is not brief."""
    return abs(run.h) > BRIEF * greater(1.0, abs(run.t))


@part
def go_on(run: Run, points: int, longer: Truth) -> None:
    """Go to the next window, twice as long if it may be; the values at the end of this one are those at its start."""
    search, table = run.search, run.search.table
    search.has_slopes = 1 if points == PARTS + 2 and table[PARTS + 1, search.count] >= 0.0 else 0
    search.past_length = search.span * run.h
    for e in range(search.count):
        search.slopes[e] = (table[points, e] - table[PARTS + 1, e]) / (MARGIN * search.span * run.h)
        table[BEFORE, e], table[0, e] = table[0, e], table[points, e]
    search.seen = 1.0 if search.reach <= 1.0 else search.seen + search.span
    if longer:
        search.span *= 2.0
    search.span = lesser(search.span, 1.0 - search.seen)


@part
def zeros_before_stop(run: Run, points: int, count: int) -> int:
    """Add zeros before the first terminal event, at which the run stops; return the number of events.

    A function that jumps there and back and there again between two points shows one zero, which may be the last. Its
    sign where the run stops tells that there is one before.
    """
    search, n, table, e = run.search, run.search.count, run.search.table, 0
    stop, fresh, most = first_stop(run, count), 0, count + n
    while e < n and stop < 1.0 and count < most:
        if fresh == 0:
            dense_state(run, stop)
            evaluate(run, stop)
        k, known, before = points, 0, count
        while k > 0 and table[k, n] >= stop:
            k -= 1
        a, b, start = table[k, e], search.g[e], table[k, n]
        for i in range(count):
            if search.zero_number[i] == e and start < search.zero_x[i] <= stop:
                known = 1
        fresh = 1
        if known == 0 and (a < 0.0 < b or b < 0.0 < a):
            x, fresh = _root(run, e, start, stop, a, b), 0
            if x >= 0.0:
                count = record_event(run, count, x, e, 1 if b > 0.0 else -1)
        e += 1
        if count > before:
            stop, e = first_stop(run, count), 0
    return count


@part
def first_stop(run: Run, count: int) -> float:
    """Return the fraction of the step at the first terminal event after its start; 2 if there is none."""
    search = run.search
    for k in range(count):
        if search.terminal[search.zero_number[k]] != 0 and search.zero_x[k] > 0.0:
            return search.zero_x[k]
    return 2.0


@part
def _root(run: Run, e: int, before: float, after: float, g_before: float, g_after: float) -> float:
    """Return the fraction of the step at which event function ``e`` has just changed its sign (method of Chandrupatla,
    1997).

    Return -1 if it changed sign through infinity, -2 if it has no value there.

    The bracket is narrowed to a few units in the last place of the time. Its later end is returned, so that a run that
    is started again there does not find the same event once more.

    As the bracket narrows, the function falls near a zero, grows near a pole, and stays constant at a jump. It has a
    pole if its final values exceed those at the ends of the interval, and are four times the values half-way, on a
    logarithmic scale, between the bracket and these ends.
    """
    width = 2.0 * EPS * greater(1.0, abs(run.t / run.h))
    half, size = root(width * (after - before)), greater(abs(g_before), abs(g_after))
    a, b, ga, gb = after, before, g_after, g_before
    other, g_other = a, ga
    part = 0.5
    for _ in range(100):
        x = a + part * (b - a)
        gx = event_value(run, e, x)
        if gx == 0.0:
            return x
        if gx != gx:
            return -2.0
        if (gx > 0.0) == (ga > 0.0):
            other, g_other = a, ga
        else:
            other, g_other = b, gb
            b, gb = a, ga
        a, ga = x, gx
        gap = abs(b - a)
        if gap <= width:
            break
        least = 0.5 * width / gap
        xi = (a - b) / (other - b)
        phi = (ga - gb) / (g_other - gb)
        if phi * phi < xi and (1.0 - phi) * (1.0 - phi) < 1.0 - xi:
            part = ga / (gb - ga) * g_other / (gb - g_other)
            part += (other - a) / (b - a) * ga / (g_other - ga) * gb / (g_other - gb)
        else:
            part = 0.5
        part = lesser(1.0 - least, greater(least, part))
    low, high = lesser(a, b), greater(a, b)
    under = abs(event_value(run, e, greater(before, low - half)))
    over = abs(event_value(run, e, lesser(after, high + half)))
    at_low, at_high = abs(ga) if a < b else abs(gb), abs(gb) if a < b else abs(ga)
    grown, peak = at_low > 4.0 * under or at_high > 4.0 * over, greater(at_low, at_high)
    return -1.0 if peak == math.inf or (grown and (peak > size or size == math.inf)) else high


@part
def _dip(run: Run, e: int, x0: float, x1: float, x2: float, g0: float, g1: float, g2: float) -> float:
    """Return the point between ``x0`` and ``x2`` at which an event function that dips towards zero at ``x1`` reaches
    zero.

    Return -1 if it does not reach zero, -2 if it has no value there. Parabolas and golden sections approach the
    extremum. The search ends when the sign changes, or when the parabola through the three points stays well clear of
    zero.
    """
    sign = 1.0 if g1 > 0.0 else -1.0
    for _ in range(60):
        if sign * g1 <= 0.0:
            return x1
        if x2 - x0 < 1e-8:
            break
        p, q = (x1 - x0) * (g1 - g2), (x1 - x2) * (g1 - g0)
        curve = p - q
        x = x1
        if curve != 0.0:
            shift = 0.5 * ((x1 - x0) * p - (x1 - x2) * q) / curve
            x = x1 - shift
            slope01 = (g1 - g0) / (x1 - x0)
            second = ((g2 - g1) / (x2 - x1) - slope01) / (x2 - x0)
            slope = slope01 + second * (x1 - x0)
            vertex = g1 - shift * slope + second * shift * shift
            if sign * vertex > 0.5 * sign * g1:
                break
        if not (x0 < x < x2) or abs(x - x1) < 1e-3 * (x2 - x0):
            x = x1 + 0.3 * (x2 - x1) if x2 - x1 > x1 - x0 else x1 - 0.3 * (x1 - x0)
        gx = event_value(run, e, x)
        if gx != gx:
            return -2.0
        if sign * gx <= sign * g1:
            if x < x1:
                x2, g2 = x1, g1
            else:
                x0, g0 = x1, g1
            x1, g1 = x, gx
        elif x < x1:
            x0, g0 = x, gx
        else:
            x2, g2 = x, gx
    return -1.0


@part
def insert_event(run: Run, count: int, x: float, e: int, sign: int) -> None:
    """Insert an event into the first ``count`` events, in order of time."""
    search, k = run.search, count
    while k > 0 and search.zero_x[k - 1] > x:
        search.zero_x[k] = search.zero_x[k - 1]
        search.zero_number[k] = search.zero_number[k - 1]
        search.zero_sign[k] = search.zero_sign[k - 1]
        k -= 1
    search.zero_x[k], search.zero_number[k], search.zero_sign[k] = x, e, sign


@part
def record_event(run: Run, count: int, x: float, e: int, sign: int) -> int:
    """Insert an event of this step if its direction is to be reported. Return the number of events."""
    direction = run.search.directions[e]
    if direction != 0 and direction != sign:
        return count
    insert_event(run, count, x, e, sign)
    return count + 1


@part
def refined_event(run: Run, e: int, sign: int, x: float) -> float:
    """Move an event at the fraction ``x`` of the step from the zero on the dense output to the zero on `state_in_step`.

    Newton's method uses the slope of the dense output. If the slope is useless, in a grazing pass, ``x`` stays. The
    sign has changed at the result, so that a run that starts again there does not find the event once more: where the
    states change it later, as by round-off, or at a jump, the result is later. Return -1 if they have no zero near
    ``x``, or if the iteration of the method does not converge there.
    """
    d = lesser(1e-4, lesser(x, 1.0 - x))
    if d <= 0.0:
        return x
    high = event_value(run, e, x + d)
    low = event_value(run, e, x - d)
    slope = (high - low) / (2.0 * d)
    if not sign * slope > 0.0:
        return x
    width = 2.0 * EPS * greater(1.0, abs(run.t / run.h))
    best = x
    for k in range(64):  # the last steps double, up to the end
        state_in_step(run, best)
        if not are_finite(run.point, run.n):
            return -1.0
        evaluate(run, best)
        value = run.search.g[e]
        shift = -value / slope
        if sign * value >= 0.0 and (k >= 6 or abs(shift) <= width):
            return best
        if k < 6 and abs(shift) > width:
            if abs(best + shift - x) > FARTHEST:
                return -1.0
            best = lesser(1.0, greater(0.0, best + shift + width / 4.0))  # just beyond the zero
        elif best == 1.0:
            return -1.0 if best - x > FARTHEST else x
        else:
            best = lesser(1.0, best + width)
            width *= 2.0
    return x


@part
def log_events(run: Run, count: int, rejects: int) -> float:
    """Copy the events of a step to the log, up to the first terminal event.

    Return the fraction of the step at the terminal event, or -1. Events within 1e-12 of the terminal one count as
    simultaneous and are kept; a function that has not passed by then passes later. A terminal event at the very start
    does not stop the run: otherwise a motion could not be started again from it. One that is guarded and happens after
    it stops the run a moment later: else what it tells, such as other features of a patch, would be passed over. Where
    a function loses its value, the step stops as at a terminal event.

    If ``rejects`` is 1, return `TOO_LONG` if the step is: the states have no zero where the dense output has one of a
    guarded function, such a function passes through infinity, or the iteration of the method does not converge for the
    shorter step to an event.
    """
    search, t, h, first = run.search, run.t, run.h, math.inf
    tie = 1e-12 * greater(1.0, abs(t / h))
    if count == THROUGH_INFINITY:
        return TOO_LONG
    for k in range(count):
        if search.zero_x[k] > first + FARTHEST:  # the run stops before it
            break
        e, sign = search.zero_number[k], search.zero_sign[k]
        later = search.zero_x[k] > first and has_passed(run, e, sign, lesser(1.0, first + tie)) == 0
        x = math.inf if later else refined_event(run, e, sign, search.zero_x[k])
        if x < 0.0:
            x = search.zero_x[k]
            if rejects != 0 and e >= search.count - search.guarded and is_long(run):
                return TOO_LONG
        if search.zero_x[k] > 0.0 and e >= search.count - search.guarded:
            x = greater(x, lesser(1.0, 2.0 * EPS * greater(1.0, abs(t / h))))
        if search.terminal[e] != 0 and t + x * h != run.start:
            first = lesser(first, x)
        insert_event(run, k, x, e, sign)
    stop, latest = -1.0, search.reach
    for k in range(count):
        x = search.zero_x[k]
        if x > latest:
            break
        moment, state = run.after, run.end
        if x == 0.0:
            moment, state = t, run.y
        elif x != 1.0:
            state_in_step(run, x)
            moment, state = t + x * h, run.point
            if rejects != 0 and not are_finite(state, run.n):
                return TOO_LONG
        place, e = run.events, search.zero_number[k]
        search.log_times[place], search.log_numbers[place] = moment, e
        search.log_signs[place] = search.zero_sign[k]
        for i in range(run.n):
            search.log_states[place, i] = state[i]
        run.events = place + 1
        if stop < 0.0 and search.terminal[e] != 0 and moment != run.start:
            stop = x
            latest = lesser(latest, x + tie)
    if stop < 0.0 and search.reach <= 1.0:
        stop = search.reach
    if stop == 0.0:
        run.end[:] = run.y
    elif 0.0 < stop < 1.0:
        state_in_step(run, stop)
        run.end[:] = run.point
    return stop
