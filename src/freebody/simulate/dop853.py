"""Adaptive Runge-Kutta method of order 8 with dense output and located events, compiled once for every model.

    y' = f(t, y, c)

A step, its error and its control follow Hairer, Norsett and Wanner (`tableau`): the estimate

    ε = |h| e5² / sqrt(e5² + e3²/100),   e = max_i |error_i| / (a_i + r_i max(|y_i|, |y_i(t + h)|))

is taken in the greatest component and not in the mean, so that a tolerance holds for every coordinate of a large
machine. The next step is h · 0.9 ε^-(1/8 - β/5) ε_old^β (a proportional-integral control), between h/3 and 6h.

Unit quaternions are normalised after each accepted step. The correction is of the size of the local error, O(h⁹),
and f is taken at the corrected state, so that order 8 is kept. The dense output is the polynomial from the state at
the start of the step to its uncorrected end, with each quaternion divided by its norm where it is evaluated: it
meets the corrected state at the end of the step and is continuous.

The dense output serves to find events. It is not stored, and no result depends on it: steps are long, and its error
may exceed the tolerance. A state inside a step, of an event or for output (`sample`), is the end of a shorter step
from the same start: of order 8, and at the end of the step the very result of the run. So a run keeps n numbers per
step and not 8n.

Everything here is compiled by numba with fixed signatures and lies in numba's cache on disk. Kernels are called by
address (`machine.call`). No step allocates.

One file, because numba notices a change only in the file of the function that Python calls, not in what that calls.
"""

from __future__ import annotations

import math
from functools import cache, partial

import numpy as np
from numba import int64, njit

from . import tableau
from .machine import call, linear

# rows of the work array, each as long as the padded state
STATE, ARGUMENT, RAW, ERROR5, ERROR3, DENSE, POINT, END, ROWS = 16, 17, 18, 19, 20, 21, 28, 29, 30

# what `advance` reports
RUNNING, FINISHED, TERMINAL, NOT_FINITE, COLLAPSED = 0, 1, 2, 3, 4

# places in the array of real numbers that `advance` carries from one call to the next
TIME, STEP, OLD_ERROR, UNTIL, MAX_STEP, START = 0, 1, 2, 3, 4, 5
REALS = 6
# places in its array of integers: counts, and the component that is to blame for a stop
ACCEPTED, REJECTED, EVALUATED, EVENTS, BLAME, AFTER_REJECTION = 0, 1, 2, 3, 4, 5
INTEGERS = 6

PARTS = 8  # of a step at which event functions are looked at, besides one point close to either end
MARGIN = 0.001  # distance of those two points from the ends, as a part of the step: they show the slope there

_EPS, _TINY = float(np.finfo(float).eps), 1e-300
_SAFETY, _SMALLEST, _GREATEST, _BETA = 0.9, 1.0 / 3.0, 6.0, 0.04
_C1, _C2, _C3, _C4, _C5, _C6, _C7, _C8, _C9, _C10, _C11 = tableau.C[1:12]
_C13, _C14, _C15 = tableau.C[13:16]
_a1, _a2, _a3, _a4, _a5, _a6, _a7, _a8, _a9, _a10, _a11 = (linear(row) for row in tableau.A[1:12])
_a13, _a14, _a15 = (linear(row) for row in tableau.A[13:16])
_b, _e5, _e3 = linear(tableau.B), linear(tableau.E5), linear(tableau.E3)
_d3, _d4, _d5, _d6 = (linear(row) for row in tableau.D)

_outer = partial(njit, cache=True, nogil=True, error_model="numpy", no_cfunc_wrapper=True)
# no signature: when the callers come from the cache, these are not even loaded
_inner = njit(error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)


@_inner
def _normalise(work, row, quaternions):
    for k in range(quaternions.size):
        i = row + quaternions[k]
        s = math.sqrt(work[i] ** 2 + work[i + 1] ** 2 + work[i + 2] ** 2 + work[i + 3] ** 2)
        for j in range(4):
            work[i + j] /= s


@_inner
def attempt(rates, t, h, work, w, c):
    """One step of length ``h`` from STATE, whose rates are row 0: fills rows 1 to 11, RAW, ERROR5 and ERROR3."""
    a = ARGUMENT * w
    _a1(work, w, ARGUMENT, STATE, h)
    call(rates, t + _C1 * h, work, a, c, work, w)
    _a2(work, w, ARGUMENT, STATE, h)
    call(rates, t + _C2 * h, work, a, c, work, 2 * w)
    _a3(work, w, ARGUMENT, STATE, h)
    call(rates, t + _C3 * h, work, a, c, work, 3 * w)
    _a4(work, w, ARGUMENT, STATE, h)
    call(rates, t + _C4 * h, work, a, c, work, 4 * w)
    _a5(work, w, ARGUMENT, STATE, h)
    call(rates, t + _C5 * h, work, a, c, work, 5 * w)
    _a6(work, w, ARGUMENT, STATE, h)
    call(rates, t + _C6 * h, work, a, c, work, 6 * w)
    _a7(work, w, ARGUMENT, STATE, h)
    call(rates, t + _C7 * h, work, a, c, work, 7 * w)
    _a8(work, w, ARGUMENT, STATE, h)
    call(rates, t + _C8 * h, work, a, c, work, 8 * w)
    _a9(work, w, ARGUMENT, STATE, h)
    call(rates, t + _C9 * h, work, a, c, work, 9 * w)
    _a10(work, w, ARGUMENT, STATE, h)
    call(rates, t + _C10 * h, work, a, c, work, 10 * w)
    _a11(work, w, ARGUMENT, STATE, h)
    call(rates, t + _C11 * h, work, a, c, work, 11 * w)
    _b(work, w, RAW, STATE, h)
    _e5(work, w, ERROR5, -1, h)
    _e3(work, w, ERROR3, -1, h)


@_inner
def densify(rates, t, h, work, w, c):
    """Rows DENSE to DENSE + 6 of the dense output of the step in ``work``, whose row 12 holds the rates at its end."""
    a = ARGUMENT * w
    _a13(work, w, ARGUMENT, STATE, h)
    call(rates, t + _C13 * h, work, a, c, work, 13 * w)
    _a14(work, w, ARGUMENT, STATE, h)
    call(rates, t + _C14 * h, work, a, c, work, 14 * w)
    _a15(work, w, ARGUMENT, STATE, h)
    call(rates, t + _C15 * h, work, a, c, work, 15 * w)
    for i in range(w):
        difference = work[RAW * w + i] - work[STATE * w + i]
        first, last = work[i], work[12 * w + i]
        work[DENSE * w + i] = difference
        work[(DENSE + 1) * w + i] = h * first - difference
        work[(DENSE + 2) * w + i] = 2.0 * difference - h * (last + first)
    _d3(work, w, DENSE + 3, -1, h)
    _d4(work, w, DENSE + 4, -1, h)
    _d5(work, w, DENSE + 5, -1, h)
    _d6(work, w, DENSE + 6, -1, h)


@_inner
def interpolate(x, work, w, quaternions):
    """Row POINT: the dense output at the part ``x`` (0 to 1) of the step."""
    z = 1.0 - x
    d = DENSE * w
    for i in range(w):
        p = work[d + 5 * w + i] + x * work[d + 6 * w + i]
        p = work[d + 3 * w + i] + x * (work[d + 4 * w + i] + z * p)
        p = work[d + 1 * w + i] + x * (work[d + 2 * w + i] + z * p)
        work[POINT * w + i] = work[STATE * w + i] + x * (work[d + i] + z * p)
    _normalise(work, POINT * w, quaternions)


@_inner
def _first_not_finite(work, w, n, row, rows):
    """The first component that is not finite in the first of ``rows`` rows that has one, or -1."""
    for k in range(row, row + rows):
        for i in range(n):
            if not math.isfinite(work[k * w + i]):
                return i
    return -1


@_inner
def _value(kernel, e, x, t, h, work, w, c, quaternions, g):
    """Event function ``e`` at the part ``x`` of the step."""
    interpolate(x, work, w, quaternions)
    call(kernel, t + x * h, work, POINT * w, c, g, 0)
    return g[e]


@_inner
def _root(kernel, e, before, after, g_before, g_after, t, h, work, w, c, quaternions, g):
    """The part of the step where event function ``e`` has just changed its sign (method of Chandrupatla, 1997).

    The bracket is closed to a few units in the last place of the time; its later end is returned, so that a run
    that is started again there does not find the same event once more.
    """
    width = 2.0 * _EPS * max(1.0, abs(t / h))
    a, b, ga, gb = after, before, g_after, g_before
    other, g_other = a, ga
    part = 0.5
    for _ in range(100):
        x = a + part * (b - a)
        gx = _value(kernel, e, x, t, h, work, w, c, quaternions, g)
        if gx == 0.0:
            return x
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
        part = min(1.0 - least, max(least, part))
    return max(a, b)


@_inner
def _dip(kernel, e, x0, x1, x2, g0, g1, g2, t, h, work, w, c, quaternions, g):
    """Where between ``x0`` and ``x2`` an event function that dips towards zero at ``x1`` reaches it, or -1.

    Parabolas and golden sections close in on the extremum. The search ends as soon as the sign changes, or when
    the parabola through the three points stays well clear of zero.
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
        gx = _value(kernel, e, x, t, h, work, w, c, quaternions, g)
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


@_inner
def _note(found, count, x, e, sign, directions):
    """Insert an event of this step, in order of time, if its direction is asked for."""
    if directions[e] != 0 and directions[e] != sign:
        return count
    k = count
    while k > 0 and found[k - 1, 0] > x:
        for j in range(3):
            found[k, j] = found[k - 1, j]
        k -= 1
    found[k, 0] = x
    found[k, 1] = e
    found[k, 2] = sign
    return count + 1


@_inner
def find_events(kernel, t, h, work, w, c, quaternions, table, g, last, directions, found):
    """Zeros of the event functions in the step in ``work``; their number, described in ``found`` in order of time.

    ``table[k]`` holds all functions at the k-th point of the step; its first row comes from the step before.
    ``last`` holds the last sign of each that was not zero, 0 until there is one. A function that arrives at zero is
    recorded there and not again when it leaves; one that begins at zero is recorded when it leaves.
    """
    points = PARTS + 2
    n = directions.size
    for k in range(1, points + 1):
        if k == points:
            for i in range(w):
                work[POINT * w + i] = work[END * w + i]
            x = 1.0
        else:
            x = MARGIN if k == 1 else (1.0 - MARGIN if k == points - 1 else (k - 1.0) / PARTS)
            interpolate(x, work, w, quaternions)
        call(kernel, t + x * h, work, POINT * w, c, g, 0)
        for e in range(n):
            table[k, e] = g[e]
        table[k, n] = x
    count = int64(0)
    for e in range(n):
        for k in range(1, points + 1):
            a, b = table[k - 1, e], table[k, e]
            xa, xb = table[k - 1, n], table[k, n]
            if b == 0.0:
                if a != 0.0:
                    count = _note(found, count, xb, e, -1 if a > 0.0 else 1, directions)
                continue
            sign = 1 if b > 0.0 else -1
            if a == 0.0:
                if last[e] == 0:
                    count = _note(found, count, xa, e, sign, directions)
            elif (a > 0.0) != (b > 0.0):
                x = _root(kernel, e, xa, xb, a, b, t, h, work, w, c, quaternions, g)
                count = _note(found, count, x, e, sign, directions)
            elif k > 1:
                o, xo = table[k - 2, e], table[k - 2, n]
                if o != 0.0 and (o > 0.0) == (a > 0.0) and abs(a) < abs(o) and abs(a) <= abs(b):
                    x = _dip(kernel, e, xo, xa, xb, o, a, b, t, h, work, w, c, quaternions, g)
                    if x >= 0.0:
                        gx = _value(kernel, e, x, t, h, work, w, c, quaternions, g)
                        if gx == 0.0:
                            count = _note(found, count, x, e, -sign, directions)
                        else:
                            y = _root(kernel, e, xo, x, o, gx, t, h, work, w, c, quaternions, g)
                            count = _note(found, count, y, e, -sign, directions)
                            y = _root(kernel, e, x, xb, gx, b, t, h, work, w, c, quaternions, g)
                            count = _note(found, count, y, e, sign, directions)
            last[e] = sign
    for e in range(n):  # the next step begins where this one ends
        table[0, e] = table[points, e]
    return count


@_inner
def _judge(n, work, w, quaternions, relative, absolute, integers):
    """Error of the attempted step in units of the tolerance, nan if it is not finite; fills row END."""
    error5, error3 = 0.0, 0.0
    for i in range(n):
        new = work[RAW * w + i]
        scale = absolute[i] + relative[i] * max(abs(work[STATE * w + i]), abs(new))
        one, two = abs(work[ERROR5 * w + i]) / scale, abs(work[ERROR3 * w + i]) / scale
        if not (math.isfinite(new) and math.isfinite(one) and math.isfinite(two)):
            return math.nan
        if one > error5:
            error5 = one
            integers[BLAME] = i
        error3 = max(error3, two)
    for i in range(w):
        work[END * w + i] = work[RAW * w + i]
    _normalise(work, END * w, quaternions)
    if error5 == 0.0:
        return 0.0
    return error5 * error5 / math.sqrt(error5 * error5 + 0.01 * error3 * error3)


@_inner
def _copy(work, row, target, n):
    for i in range(n):
        target[i] = work[row + i]


@_inner
def _part(rates, x, t, h, work, w, c, quaternions, integers):
    """Row POINT: the state at the part ``x`` of the step, by a step of its own from the same start."""
    attempt(rates, t, x * h, work, w, c)
    integers[EVALUATED] += 11
    for i in range(w):
        work[POINT * w + i] = work[RAW * w + i]
    _normalise(work, POINT * w, quaternions)


@_inner
def _refine(rates, events, e, sign, x, t, h, work, w, c, ce, quaternions, g, integers):
    """An event at the part ``x`` of the step, moved from the zero on the dense output to that on `_part`.

    Newton's method with the slope of the dense output; where that is of no use, in a grazing pass, ``x`` stays.
    The result lies where the sign has changed, so that a run that starts again there does not find it once more.
    """
    d = min(1e-4, x, 1.0 - x)
    if d <= 0.0:
        return x
    high = _value(events, e, x + d, t, h, work, w, ce, quaternions, g)
    low = _value(events, e, x - d, t, h, work, w, ce, quaternions, g)
    slope = (high - low) / (2.0 * d)
    if not sign * slope > 0.0:
        return x
    width = 2.0 * _EPS * max(1.0, abs(t / h))
    best = x
    for k in range(16):
        _part(rates, best, t, h, work, w, c, quaternions, integers)
        call(events, t + best * h, work, POINT * w, ce, g, 0)
        shift = -g[e] / slope
        if k < 6 and abs(shift) > width:
            if abs(best + shift - x) > 0.02:
                return x
            best = min(1.0, max(0.0, best + shift))
        elif sign * g[e] >= 0.0:
            return best
        else:
            best = min(1.0, best + width)
            width *= 2.0
    return x


@_inner
def _log_events(
    rates, events, count, t, h, after, start, n, work, w, c, ce, quaternions, g, found, terminal,
    event_log, event_states, logged, integers,
):  # fmt: skip
    """Copy the events of a step to the log, up to the first terminal one, whose part of the step is returned (or -1).

    Events within 1e-12 of the terminal one happen together with it and are kept. A terminal event at the very start
    does not stop: a motion could not be started again from it. ``found[0, 3]`` becomes the number that was kept.
    """
    for k in range(count):
        x, e, sign = found[k, 0], found[k, 1], found[k, 2]
        x = _refine(rates, events, int(e), sign, x, t, h, work, w, c, ce, quaternions, g, integers)
        i = k
        while i > 0 and found[i - 1, 0] > x:
            for j in range(3):
                found[i, j] = found[i - 1, j]
            i -= 1
        found[i, 0] = x
        found[i, 1] = e
        found[i, 2] = sign
    stop, latest, kept = -1.0, 2.0, int64(0)
    for k in range(count):
        x = found[k, 0]
        if x > latest:
            break
        moment, row = after, END * w
        if x != 1.0:
            moment, row = t + x * h, POINT * w
            _part(rates, x, t, h, work, w, c, quaternions, integers)
        event_log[logged + k, 0] = moment
        event_log[logged + k, 1] = found[k, 1]
        event_log[logged + k, 2] = found[k, 2]
        _copy(work, row, event_states[logged + k], n)
        kept += 1
        if stop < 0.0 and terminal[int(found[k, 1])] != 0 and moment != start:
            stop = x
            latest = x + 1e-12 * max(1.0, abs(t / h))
    if 0.0 <= stop < 1.0:
        _part(rates, stop, t, h, work, w, c, quaternions, integers)
        for i in range(w):
            work[END * w + i] = work[POINT * w + i]
    found[0, 3] = kept
    return stop


def _advance(
    rates, n, c, work, w, quaternions, relative, absolute, reals, integers, times, lengths, states, watch
):  # fmt: skip
    """Step until the end, a terminal event, a failure, or until the buffers are full.

    Parameters
    ----------
    rates, n, c          address of the kernel, number of components, constants of the kernel
    work, w              rows of length ``w``; row STATE holds y, row 0 its rates
    quaternions          places of the unit quaternions in y
    relative, absolute   tolerance of each component
    reals, integers      what is carried from call to call (see the names above)
    times, lengths, states   buffers: time, length and state at the start of each accepted step
    watch                None, or (events, ce, directions, terminal, last, table, g, found, event_log, event_states):
                         address of the event functions and their constants, what is asked of each, room for the
                         search (see `find_events`), and buffers for (time, number, sign) and state of each event

    Returns
    -------
    int                  RUNNING, FINISHED, TERMINAL, NOT_FINITE or COLLAPSED
    """
    room = times.size
    t, h, old = reals[TIME], reals[STEP], reals[OLD_ERROR]
    until, longest = reals[UNTIL], reals[MAX_STEP]
    direction = 1.0 if until >= t else -1.0
    accepted, logged, full = int64(0), int64(0), False
    integers[ACCEPTED] = integers[EVENTS] = 0
    status = RUNNING
    while accepted < room and not full:
        if abs(h) > longest:
            h = direction * longest
        ends = (t + 1.01 * h - until) * direction >= 0.0
        if ends:
            h = until - t
        elif abs(h) <= 8.0 * _EPS * abs(t) or abs(h) < _TINY:
            status = COLLAPSED
            break
        attempt(rates, t, h, work, w, c)
        integers[EVALUATED] += 11
        error = _judge(n, work, w, quaternions, relative, absolute, integers)
        after = until if ends else t + h
        if error <= 1.0:  # also the rates at the end must be numbers: a state without rates is no state
            call(rates, after, work, END * w, c, work, 12 * w)
            integers[EVALUATED] += 1
            if _first_not_finite(work, w, n, int64(12), int64(1)) >= 0:
                error = math.nan
        if not error <= 1.0:
            integers[REJECTED] += 1
            integers[AFTER_REJECTION] = 1
            if error == error:
                h *= max(_SMALLEST, _SAFETY / error ** (0.125 - 0.2 * _BETA))
                continue
            integers[BLAME] = _first_not_finite(work, w, n, int64(1), int64(12))
            if integers[BLAME] < 0:
                integers[BLAME] = _first_not_finite(work, w, n, int64(RAW), int64(3))
            h *= 0.25
            if abs(h) <= 16.0 * _EPS * abs(t) or abs(h) < _TINY:
                status = NOT_FINITE
                break
            continue

        times[accepted] = t
        lengths[accepted] = h
        _copy(work, STATE * w, states[accepted], n)
        accepted += 1
        if watch is not None:  # numba leaves this branch out of the code for None
            events, ce, directions, terminal, last, table, g, found, event_log, event_states = watch
            densify(rates, t, h, work, w, c)
            integers[EVALUATED] += 3
            count = find_events(events, t, h, work, w, ce, quaternions, table, g, last, directions, found)
            stop = _log_events(
                rates, events, count, t, h, after, reals[START], n, work, w, c, ce, quaternions, g, found,
                terminal, event_log, event_states, logged, integers,
            )  # fmt: skip
            logged += int(found[0, 3])
            full = logged + found.shape[0] > event_log.shape[0]
            if stop >= 0.0:
                status = TERMINAL
                after = after if stop == 1.0 else t + stop * h
        t = after
        for i in range(w):
            work[STATE * w + i] = work[END * w + i]
            work[i] = work[12 * w + i]
        if status == TERMINAL:
            break
        if ends:
            status = FINISHED
            break
        factor = _GREATEST
        if error > 0.0:
            factor = _SAFETY * old**_BETA / error ** (0.125 - 0.2 * _BETA)
            factor = min(_GREATEST, max(_SMALLEST, factor))
        if integers[AFTER_REJECTION] != 0:
            factor = min(1.0, factor)
            integers[AFTER_REJECTION] = 0
        h *= factor
        old = max(error, 1e-4)
    reals[TIME], reals[STEP], reals[OLD_ERROR] = t, h, old
    integers[ACCEPTED], integers[EVENTS] = accepted, logged
    return status


_INT, _REAL, _MATRIX = "int64[::1]", "float64[::1]", "float64[:,::1]"
_SIGNATURE = (
    f"int64(int64,int64,{_REAL},{_REAL},int64,{_INT},{_REAL},{_REAL},{_REAL},{_INT},"
    f"{_REAL},{_REAL},{_MATRIX},%s)"
)
advance = _outer(_SIGNATURE % "none")(_advance)


@cache
def advance_watching():
    """`advance` with events: compiled, or loaded, only when there are any."""
    watch = f"Tuple((int64,{_REAL},{_INT},{_INT},{_INT},{_MATRIX},{_REAL},{_MATRIX},{_MATRIX},{_MATRIX}))"
    return _outer(_SIGNATURE % watch)(_advance)


@_outer(f"void(int64,int64,{_REAL},{_REAL},int64,{_INT},{_REAL},{_REAL},{_MATRIX},int64,{_REAL},{_MATRIX})")
def sample(rates, n, c, work, w, quaternions, times, lengths, states, dense, wanted, result):
    """States at the times ``wanted``, each within the run.

    With ``dense`` 0 each is the end of a shorter step from the start of the step it lies in; otherwise it is taken
    from the dense output, which is faster where many lie in one step and come in the order of the run.
    """
    steps = lengths.size
    direction = 1.0 if times[steps] >= times[0] else -1.0
    current = -1
    for k in range(wanted.size):
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
            for i in range(n):
                result[k, i] = states[row, i]
            continue
        start, h = times[low], lengths[low]
        fresh = low != current
        if fresh:
            current = low
            for i in range(n):
                work[STATE * w + i] = states[low, i]
            call(rates, start, work, STATE * w, c, work, 0)
        x = (t - start) / h
        if dense == 0 or fresh:
            attempt(rates, start, h if dense != 0 else x * h, work, w, c)
            for i in range(w):
                work[POINT * w + i] = work[RAW * w + i]
            _normalise(work, POINT * w, quaternions)
        if dense != 0:
            if fresh:
                call(rates, start + h, work, POINT * w, c, work, 12 * w)
                densify(rates, start, h, work, w, c)
            interpolate(x, work, w, quaternions)
        for i in range(n):
            result[k, i] = work[POINT * w + i]


@_outer(f"void(int64,{_REAL},{_REAL},int64,{_REAL},{_REAL},int64)")
def observe(kernel, times, states, n, c, result, outputs):
    """Row k of ``result`` (length ``outputs``): what ``kernel`` gives at ``times[k]`` and row k of ``states``."""
    for k in range(times.size):
        call(kernel, times[k], states, k * n, c, result, k * outputs)
