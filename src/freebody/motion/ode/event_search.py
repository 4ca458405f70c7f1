"""Zeros of event functions inside a step, located on the dense output, in order of time.

A function is evaluated at some points of the step. If it changes sign between two of them, the zero is bracketed
(method of Chandrupatla, 1997) and distinguished from a pole. If it dips towards zero in between, the search follows the
dip.

Each function here becomes a C function. `step_control` binds them to a method.
"""

from __future__ import annotations

import math
from typing import Any

from ...native.instructions import EPS, Integers, Parts, Reals, call, greater, lesser, root
from ...native.row_arithmetic import copied
from .layout import CULPRIT, END, EVENT_SIZE, MARGIN, PARTS, POINT, REACH

part = Parts()

# bound to the function of a method
dense_state: Any = None
"""`step_control.dense_state`."""


@part
def find_events(
    kernel: int, t: float, h: float, work: Reals, w: int, c: Reals, quaternions: Integers, nq: int, n: int,
    named: int, table: Reals, g: Reals, last: Integers, directions: Integers, zeros: Reals,
) -> int:  # fmt: skip
    """Find the zeros of the event functions in the step in ``work``.

    Return their number, and describe them in ``zeros`` in order of time. A change of sign through infinity is no zero.
    If one of the first ``named`` functions has no value, the search ends there: REACH of ``zeros`` is the fraction of
    the step up to which all these functions have values, and CULPRIT is the function without a value.

    Row k of ``table`` holds all ``n`` functions at the k-th point of the step, and the fraction of the step at that
    point. Its first row comes from the step before. ``last`` holds the last nonzero sign of each function, 0 until
    there is one. A function that arrives at zero is recorded there, and not again when it leaves. A function that
    begins at zero is recorded when it leaves.
    """
    points, row, k = PARTS + 2, n + 1, 0
    reach, culprit = 2.0, 0
    while k < points:
        k += 1
        if k == points:
            copied(work, w, END, POINT)
            x = 1.0
        else:
            x = MARGIN if k == 1 else (1.0 - MARGIN if k == points - 1 else (k - 1.0) / PARTS)
            dense_state(x, work, w, quaternions, nq)
        call(kernel, t + x * h, work, POINT * w, c, g, 0)
        for e in range(n):
            table[k * row + e] = g[e]
        table[k * row + n] = x
        for e in range(named):
            if table[k * row + e] != table[k * row + e]:
                x = last_value(kernel, e, table[(k - 1) * row + n], x, t, h, work, w, c, quaternions, nq, g)
                dense_state(x, work, w, quaternions, nq)
                call(kernel, t + x * h, work, POINT * w, c, g, 0)
                for i in range(n):
                    table[k * row + i] = g[i]
                table[k * row + n] = reach = x
                culprit, points = e, k
    count = 0
    for e in range(n):
        for k in range(1, points + 1):
            a, b = table[(k - 1) * row + e], table[k * row + e]
            xa, xb = table[(k - 1) * row + n], table[k * row + n]
            if b == 0.0:
                if a != 0.0:
                    count = record_event(zeros, count, xb, e, -1 if a > 0.0 else 1, directions)
                continue
            sign = 1 if b > 0.0 else -1
            if a == 0.0:
                if last[e] == 0:
                    count = record_event(zeros, count, xa, e, sign, directions)
            elif (a > 0.0) != (b > 0.0):
                x = _root(kernel, e, xa, xb, a, b, t, h, work, w, c, quaternions, nq, g)
                if x >= 0.0:
                    count = record_event(zeros, count, x, e, sign, directions)
                elif x < -1.0 and e < named:
                    reach, culprit = lesser(reach, xa), e
            elif k > 1:
                o, xo = table[(k - 2) * row + e], table[(k - 2) * row + n]
                if o != 0.0 and (o > 0.0) == (a > 0.0) and abs(a) < abs(o) and abs(a) <= abs(b):
                    x = _dip(kernel, e, xo, xa, xb, o, a, b, t, h, work, w, c, quaternions, nq, g)
                    if x < -1.0 and e < named:
                        reach, culprit = lesser(reach, xo), e
                    if x >= 0.0:
                        gx = event_value(kernel, e, x, t, h, work, w, c, quaternions, nq, g)
                        if gx == 0.0:
                            count = record_event(zeros, count, x, e, -sign, directions)
                        else:
                            y = _root(kernel, e, xo, x, o, gx, t, h, work, w, c, quaternions, nq, g)
                            if y >= 0.0:
                                count = record_event(zeros, count, y, e, -sign, directions)
                            y = _root(kernel, e, x, xb, gx, b, t, h, work, w, c, quaternions, nq, g)
                            if y >= 0.0:
                                count = record_event(zeros, count, y, e, sign, directions)
            last[e] = sign
    for e in range(n):  # the values at the end are those at the start of the next step
        table[e] = table[points * row + e]
    zeros[REACH], zeros[CULPRIT] = reach, culprit
    return count


@part
def event_value(
    kernel: int, e: int, x: float, t: float, h: float, work: Reals, w: int, c: Reals, quaternions: Integers,
    nq: int, g: Reals,
) -> float:  # fmt: skip
    """Return event function ``e`` at the fraction ``x`` of the step."""
    dense_state(x, work, w, quaternions, nq)
    call(kernel, t + x * h, work, POINT * w, c, g, 0)
    return g[e]


@part
def _root(
    kernel: int, e: int, before: float, after: float, g_before: float, g_after: float, t: float, h: float,
    work: Reals, w: int, c: Reals, quaternions: Integers, nq: int, g: Reals,
) -> float:  # fmt: skip
    """Return the fraction of the step at which event function ``e`` has just changed its sign (method of Chandrupatla,
    1997).

    Return -1 if it changed sign through infinity, -2 if it has no value there.

    The bracket is narrowed to a few units in the last place of the time. Its later end is returned, so that a run that
    is started again there does not find the same event once more.

    As the bracket narrows, the function falls near a zero, grows near a pole, and stays constant at a jump. It has a
    pole if its final values exceed those at the ends of the interval, and are four times the values half-way, on a
    logarithmic scale, between the bracket and these ends.
    """
    width = 2.0 * EPS * greater(1.0, abs(t / h))
    half, size = root(width * (after - before)), greater(abs(g_before), abs(g_after))
    a, b, ga, gb = after, before, g_after, g_before
    other, g_other = a, ga
    part = 0.5
    for _ in range(100):
        x = a + part * (b - a)
        gx = event_value(kernel, e, x, t, h, work, w, c, quaternions, nq, g)
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
    under = abs(event_value(kernel, e, greater(before, low - half), t, h, work, w, c, quaternions, nq, g))
    over = abs(event_value(kernel, e, lesser(after, high + half), t, h, work, w, c, quaternions, nq, g))
    at_low, at_high = abs(ga) if a < b else abs(gb), abs(gb) if a < b else abs(ga)
    grown, peak = at_low > 4.0 * under or at_high > 4.0 * over, greater(at_low, at_high)
    return -1.0 if peak == math.inf or (grown and (peak > size or size == math.inf)) else high


@part
def _dip(
    kernel: int, e: int, x0: float, x1: float, x2: float, g0: float, g1: float, g2: float, t: float,
    h: float, work: Reals, w: int, c: Reals, quaternions: Integers, nq: int, g: Reals,
) -> float:  # fmt: skip
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
        gx = event_value(kernel, e, x, t, h, work, w, c, quaternions, nq, g)
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
def last_value(
    kernel: int, e: int, lower: float, upper: float, t: float, h: float, work: Reals, w: int, c: Reals,
    quaternions: Integers, nq: int, g: Reals,
) -> float:  # fmt: skip
    """Return the last fraction of the step at which event function ``e`` has a value. It has one at ``lower``, none at
    ``upper``.
    """
    for _ in range(52):
        x = 0.5 * (lower + upper)
        gx = event_value(kernel, e, x, t, h, work, w, c, quaternions, nq, g)
        if gx == gx:
            lower = x
        else:
            upper = x
    return lower


@part
def insert_event(zeros: Reals, count: int, x: float, e: float, sign: float) -> None:
    """Insert an event into the first ``count`` events, in order of time."""
    k = count
    while k > 0 and zeros[EVENT_SIZE * (k - 1)] > x:
        for j in range(3):
            zeros[EVENT_SIZE * k + j] = zeros[EVENT_SIZE * (k - 1) + j]
        k -= 1
    zeros[EVENT_SIZE * k] = x
    zeros[EVENT_SIZE * k + 1] = e
    zeros[EVENT_SIZE * k + 2] = sign


@part
def record_event(zeros: Reals, count: int, x: float, e: int, sign: int, directions: Integers) -> int:
    """Insert an event of this step if its direction is to be reported. Return the number of events."""
    if directions[e] != 0 and directions[e] != sign:
        return count
    insert_event(zeros, count, x, e, sign)
    return count + 1
