"""Zeros of event functions inside a step, located on the dense output, in order of time.

The step is searched window by window. A function is evaluated at some points of a window. The first window is the
step; it is halved until its points show how each function runs between them (`doubt`), so that functions with many
zeros in a step lose none.

If a function changes sign between two points, the zero is bracketed (method of Chandrupatla, 1997) and distinguished
from a pole. If it dips towards zero in between, the search follows the dip.

Events are then moved to the zeros on the states of the run itself, and logged. Points and events are fractions x of the
step, 0 to 1. `step_control` binds these functions to a method.
"""

from __future__ import annotations

import math

from ...native.functions import components, unrolled
from ...native.instructions import EPS, Parts, Real, Truth, greater, lesser, maximum, root
from .run import AT_MARGIN, CLEAR, MARGIN, PARTS, Run, at_margin
from .states import are_finite, dense_state, state_in_step

part = Parts()


EVEN = (0, *range(2, PARTS + 1), PARTS + 2)
"""Rows of the table of the values at the ends of the equal parts of a window."""
FEWEST, FEW = (2, 4), (*EVEN[::4], 0, 0, *EVEN[::2])
"""Numbers of parts of which few show the functions, and the rows of their ends, five numbers for each."""
IN_THE_MIDDLE = (1 / 2, -2 / 2, 1 / 2, 0.0, 0.0, *(x / 6 for x in (1, -4, 6, -4, 1)))
CLOSE_TO_THE_END, SLOPES = (*at_margin(2), 0.0, 0.0, *at_margin(4)), tuple(n * n * MARGIN for n in FEWEST)
"""Weights of these values: the highest difference, and what the polynomial gives at MARGIN, by which slopes are told."""
FINEST = 1.0 / 4096.0
"""Shortest window, of which a step may hold MOST that do not resolve a function: it may have a jump, pole or bend."""
MOST = 64
TOO_LONG, BRIEF = -2.0, 2.0**-32
"""Answer that a step is too long for its events; length of a step, relative to 1 s or the time, that is not too long
for its dense output."""
HALF_AS_MANY = 1.0 / 256.0
"""Doubt below which a window may be doubled: Δ⁸ grows by 2⁸."""


@part
def find_events(run: Run) -> int:
    """Find the zeros of the event functions in the next window of the step, and make its end the start of the next.

    Return their number, and describe them in order of time. A change of sign through infinity is no zero. If a required
    function has no value, or too many zeros, the search ends there.

    Row k of the table holds all functions at the k-th point of the window, and x. Its first row comes from the window
    before. A function that arrives at zero is recorded there, and not again when it leaves. A function that begins at
    zero is recorded when it leaves.
    """
    search, n, named = run.search, run.search.count, run.required
    table, last = search.table, search.signs
    parts = few_parts(run)
    if parts < PARTS:
        go_on(run, PARTS + 2, parts == 2)
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
def go_on(run: Run, points: int, longer: Truth) -> None:
    """Go to the next window, twice as long if it may be; the values at the end of this one are those at its start."""
    search = run.search
    for e in range(search.count):
        search.table[0, e] = search.table[points, e]
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
def forget(run: Run) -> None:
    """Forget the values at the points of the window, except at its start."""
    search = run.search
    search.reach, search.table[0, search.count] = 2.0, search.seen
    for k in range(1, PARTS + 3):
        search.table[k, search.count] = -1.0


@part
def fill(run: Run, k: int) -> None:
    """Evaluate all functions at a point of the window, if they are not known there."""
    search, n, table = run.search, run.search.count, run.search.table
    if table[k, n] < 0.0:
        part_of_window = MARGIN if k == 1 else (1.0 - MARGIN if k == PARTS + 1 else (k - 1.0) / PARTS)
        x = search.seen + (1.0 if k == PARTS + 2 else part_of_window) * search.span
        if x == 1.0:
            run.point[:] = run.end
        else:
            dense_state(run, x)
        evaluate(run, x)
        for e in range(n):
            table[k, e] = search.g[e]
        table[k, n] = x


@part
def few_parts(run: Run) -> int:
    """Return the number of equal parts, 2 or 4, whose ends show that no function has a zero in the window, or PARTS.

    All values of a function have one sign then, and exceed the error of the polynomial through them by far, as well as
    its bends: between two points it is off its chord by an eighth of Δ². The error is that of `error_between`.
    """
    search, table, result = run.search, run.search.table, PARTS
    forget(run)
    fill(run, 1)
    fill(run, PARTS + 1)
    fill(run, PARTS + 2)
    for level in unrolled(2):
        if result == PARTS:
            for k in unrolled(1, FEWEST[level]):
                fill(run, FEW[5 * level + k])
            short: Real = -math.inf
            for e in components(search.count):
                low, high = lesser(table[1, e], table[PARTS + 1, e]), greater(table[1, e], table[PARTS + 1, e])
                middle, first, final = 0.0 * low, -table[1, e], -table[PARTS + 1, e]
                for k in unrolled(FEWEST[level] + 1):
                    value, other = table[FEW[5 * level + k], e], table[FEW[5 * level + FEWEST[level] - k], e]
                    low, high = lesser(low, value), greater(high, value)
                    middle += IN_THE_MIDDLE[5 * level + k] * value
                    first += CLOSE_TO_THE_END[5 * level + k] * value
                    final += CLOSE_TO_THE_END[5 * level + k] * other
                error = maximum(abs(middle), maximum(abs(first), abs(final)) / SLOPES[level])
                bend = CLEAR * error
                for k in unrolled(1, FEWEST[level]):
                    before, after = table[FEW[5 * level + k - 1], e], table[FEW[5 * level + k + 1], e]
                    bend = maximum(bend, abs(before - 2.0 * table[FEW[5 * level + k], e] + after))
                short = maximum(short, bend - greater(low, -high))
            if short < 0.0:
                result = FEWEST[level]
    return result


@part
def tabulate(run: Run) -> int:
    """Evaluate all functions at the points of the window; return the number of points.

    The last of them is where a required function has its last value, ``reach``.
    """
    search, n, points, k = run.search, run.search.count, PARTS + 2, 0
    table = search.table
    while k < points:
        k += 1
        fill(run, k)
        x = table[k, n]
        for e in range(run.required):
            if table[k, e] != table[k, e]:
                x = last_value(run, e, table[k - 1, n], x)
                dense_state(run, x)
                evaluate(run, x)
                for i in range(n):
                    table[k, i] = search.g[i]
                table[k, n] = search.reach = x
                search.culprit, points = e, k
    return points


@part
def doubt(run: Run, points: int) -> float:
    """Return how far the points of the window fall short of showing where the functions that are judged have zeros: 1
    or more if they do not show it.

    The polynomial through the values at the ends of the equal parts is in error by r: the value in the middle by
    Δ⁸ / 70, that at MARGIN by its distance from the value there, which shows vibrations in step with the points. Where
    the values at both ends of a part are below 16 r, zeros may lie unseen. So they may beside any zero if the error is
    that of a small fast part of the function, whose differences do not decay with their order. Noise is no doubt.
    """
    search, table, worst = run.search, run.search.table, 0.0
    if points < PARTS + 2:
        return 1.0
    for e in range(search.count):
        if search.unjudged[e] != 0:
            continue
        near, far, crossed = abs(table[0, e]), 0.0, 0
        clear = greater(near, abs(table[1, e]))
        for k in range(1, points + 1):
            before, now = table[k - 1, e], table[k, e]
            clear = lesser(clear, greater(abs(before), abs(now)))
            near, far = lesser(near, abs(now)), greater(far, abs(now))
            if (before > 0.0) != (now > 0.0):
                crossed = 1
        error = error_between(run, e)
        if e >= run.required and error != error:  # it has no value somewhere, and need not have one
            continue
        if crossed == 0 and CLEAR * error < HALF_AS_MANY * near or error <= CLEAR * CLEAR * EPS * far:
            continue
        short = CLEAR * error / clear if clear > 0.0 else math.inf
        if (crossed != 0 or near <= CLEAR * error) and not search.decay > 1.0:
            short = greater(short, 1.0)
        if short > worst and (short < 1.0 or is_noise(run, e, error) == 0):
            worst, search.culprit = short, e
    return worst


@part
def error_between(run: Run, e: int) -> float:
    """Return the error r of the polynomial through the values of a function at the ends of the equal parts.

    Set ``decay`` to the quotient of its lower differences, Δ⁵ and Δ⁶, and the higher ones, Δ⁷, Δ⁸ and 16 r.
    """
    search, table, row = run.search, run.search.table, run.search.differences
    first, final = -table[1, e], -table[PARTS + 1, e]
    for k in unrolled(0, PARTS + 1):
        row[k] = table[EVEN[k], e]
        first += AT_MARGIN[k] * table[EVEN[k], e]
        final += AT_MARGIN[k] * table[EVEN[PARTS - k], e]
    low, high = 0.0, 0.0
    for order in range(1, PARTS + 1):
        for k in range(PARTS + 1 - order):
            row[k] = row[k + 1] - row[k]
            if order > PARTS - 2:
                high = greater(high, abs(row[k]))
            elif order > PARTS - 4:
                low = greater(low, abs(row[k]))
    error = greater(abs(row[0]) / 70.0, greater(abs(first), abs(final)) / (PARTS * PARTS * MARGIN))
    search.decay = low / greater(high, CLEAR * error)
    return error


@part
def is_noise(run: Run, e: int, error: float) -> int:
    """Return 1 if the error of a function comes from round-off: the function changes as much in the shortest time."""
    search, jump = run.search, 0.0
    shortest = 64.0 * EPS * greater(1.0, abs(run.t / run.h))
    for k in range(PARTS):
        x = search.seen + (k + 0.5) / PARTS * search.span
        jump = greater(jump, abs(event_value(run, e, x + shortest) - event_value(run, e, x)))
    return 1 if error <= CLEAR * CLEAR * jump else 0


@part
def evaluate(run: Run, x: float) -> None:
    """Evaluate all event functions at the row point, the state at the fraction ``x`` of the step."""
    search = run.search
    search.functions(run.t + x * run.h, run.point, search.c, search.g)


@part
def event_value(run: Run, e: int, x: float) -> float:
    """Return event function ``e`` at the fraction ``x`` of the step."""
    dense_state(run, x)
    evaluate(run, x)
    return run.search.g[e]


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
def last_value(run: Run, e: int, lower: float, upper: float) -> float:
    """Return the last fraction of the step at which event function ``e`` has a value. It has one at ``lower``, none at
    ``upper``.
    """
    for _ in range(52):
        x = 0.5 * (lower + upper)
        gx = event_value(run, e, x)
        if gx == gx:
            lower = x
        else:
            upper = x
    return lower


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
            if abs(best + shift - x) > 0.02:
                return -1.0
            best = lesser(1.0, greater(0.0, best + shift + width / 4.0))  # just beyond the zero
        elif best == 1.0:
            return -1.0 if best - x > 0.02 else x
        else:
            best = lesser(1.0, best + width)
            width *= 2.0
    return x


@part
def log_events(run: Run, count: int, rejects: int) -> float:
    """Copy the events of a step to the log, up to the first terminal event.

    Return the fraction of the step at the terminal event, or -1. Events within 1e-12 of the terminal one count as
    simultaneous and are kept. A terminal event at the very start does not stop the run: otherwise a motion could not be
    started again from it. One that is guarded and happens after it stops the run a moment later: else what it tells,
    such as other features of a patch, would be passed over. Where a function loses its value, the step stops as at a
    terminal event.

    If ``rejects`` is 1, return `TOO_LONG` if the step is: the states have no zero where the dense output has one of a
    guarded function, or the iteration of the method does not converge for the shorter step to an event.
    """
    search, t, h = run.search, run.t, run.h
    for k in range(count):
        e, sign = search.zero_number[k], search.zero_sign[k]
        x = refined_event(run, e, sign, search.zero_x[k])
        if x < 0.0:
            x = search.zero_x[k]
            if rejects != 0 and e >= search.count - search.guarded and abs(h) > BRIEF * greater(1.0, abs(t)):
                return TOO_LONG
        if search.zero_x[k] > 0.0 and e >= search.count - search.guarded:
            x = greater(x, lesser(1.0, 2.0 * EPS * greater(1.0, abs(t / h))))
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
            latest = lesser(latest, x + 1e-12 * greater(1.0, abs(t / h)))
    if stop < 0.0 and search.reach <= 1.0:
        stop = search.reach
    if stop == 0.0:
        run.end[:] = run.y
    elif 0.0 < stop < 1.0:
        state_in_step(run, stop)
        run.end[:] = run.point
    return stop
