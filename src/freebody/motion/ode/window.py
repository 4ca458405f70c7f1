"""Event functions at points of a window of a step, and what the points show of them.

Points are the ends of equal parts of the window, and one more point close to either of its ends. Most steps have no
event, and few parts show that: two, then four. Where they do not, there are eight, by which `doubt` judges. Points are
fractions x of the step, 0 to 1. `step_control` binds these functions to a method.
"""

from __future__ import annotations

import math
from typing import Any

from ...native.functions import components, unrolled
from ...native.instructions import EPS, Parts, Real, Truth, greater, lesser, maximum
from .run import AT_MARGIN, BEFORE, CLEAR, MARGIN, PARTS, Run, at_margin
from .states import dense_state, state_in_step

part = Parts()

method: Any = None
"""The method (`method.Method`), in the functions below."""
EVEN = (0, *range(2, PARTS + 1), PARTS + 2)
"""Rows of the table of the values at the ends of the equal parts of a window."""
FEWEST, FEW = (2, 4), (*EVEN[::4], 0, 0, *EVEN[::2])
"""Numbers of parts of which few show the functions, and the rows of their ends, five numbers for each."""
IN_THE_MIDDLE = (1 / 2, -2 / 2, 1 / 2, 0.0, 0.0, *(x / 6 for x in (1, -4, 6, -4, 1)))
CLOSE_TO_THE_END, SLOPES = (*at_margin(2), 0.0, 0.0, *at_margin(4)), tuple(n * n * MARGIN for n in FEWEST)
"""Weights of these values: the highest difference, and what the polynomial gives at MARGIN, for slopes."""
HALF_AS_MANY = 1.0 / 256.0
"""Doubt below which a window may be doubled: Δ⁸ grows by 2⁸."""


@part
def forget(run: Run) -> None:
    """Forget the values at the points of the window, except at its start."""
    search = run.search
    search.reach, search.table[0, search.count] = 2.0, search.seen
    for k in range(1, PARTS + 3):
        search.table[k, search.count] = -1.0


@part
def carry_slopes(run: Run) -> None:
    """Take the slopes at the end of the window before for those at the start of this one: both are one moment."""
    search, table = run.search, run.search.table
    if search.has_slopes != 0:
        length = MARGIN * search.span * run.h
        for e in range(search.count):
            table[1, e] = table[0, e] + length * search.slopes[e]
        table[1, search.count] = search.seen + MARGIN * search.span


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
def at_ends(run: Run) -> Truth:
    """Return whether the ends of the window, and the start of that before, show that no function has a zero in it.

    All values of a function have one sign then, and exceed by far what the parabola through them is off its chord by
    between the ends, a fourth of its coefficient. A step resolves how the state bends, and so how functions do that run
    as it does (`Search.smooth`). Others may vibrate in between.
    """
    search, table = run.search, run.search.table
    if search.smooth == 0 or search.past_length == 0.0:
        return False
    part_before = search.past_length / (search.span * run.h)
    short: Real = -math.inf
    for e in components(search.count):
        start, end = table[0, e], table[PARTS + 2, e]
        bend = abs(end - start - (start - table[BEFORE, e]) / part_before) / (1.0 + part_before)
        short = maximum(short, CLEAR / 4.0 * bend - greater(lesser(start, end), -greater(start, end)))
    return short < 0.0


@part
def few_parts(run: Run) -> int:
    """Return the number of equal parts, 1, 2 or 4, whose ends show that no function has a zero in the window, or PARTS.

    All values of a function have one sign then, and exceed the error of the polynomial through them by far, as well as
    its bends: between two points it is off its chord by an eighth of Δ². The error is that of `error_between`.
    """
    search, table, result = run.search, run.search.table, PARTS
    forget(run)
    fill(run, PARTS + 2)  # the state whose rates were the last that were asked for
    if at_ends(run):
        return 1
    if search.seen == 0.0 and method.densify is not None:
        method.densify(run)
    carry_slopes(run)
    fill(run, 1)
    fill(run, PARTS + 1)
    for level in unrolled(2):
        if result == PARTS:
            for k in unrolled(1, FEWEST[level]):
                fill(run, FEW[5 * level + k])
            short: Real = -math.inf
            for e in components(search.count):
                low, high = (
                    lesser(table[1, e], table[PARTS + 1, e]),
                    greater(table[1, e], table[PARTS + 1, e]),
                )
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
    if search.has_slopes != 0 and result == PARTS:
        table[1, search.count] = -1.0
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
        if worst >= 1.0:  # the window is halved anyway
            break
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
    shortest = 64.0 * EPS * greater(1.0, abs(run.t / run.h))
    for k in range(PARTS):
        x = run.search.seen + (k + 0.5) / PARTS * run.search.span
        jump = abs(event_value(run, e, x + shortest) - event_value(run, e, x))
        if error <= CLEAR * CLEAR * jump:
            return 1
    return 0


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
def has_passed(run: Run, e: int, sign: int, x: float) -> int:
    """Return 1 if an event function has the sign after its event in the state at the fraction ``x`` of the step."""
    state_in_step(run, x)
    evaluate(run, x)
    return 1 if sign * run.search.g[e] >= 0.0 else 0


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
