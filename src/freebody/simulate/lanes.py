"""The loop over lanes: many runs of one machine, one after another, without Python between them.

A lane is a run with its own parameters and start. It goes through the loop of `stepping` exactly as a run alone does:
the same first step, the same control, the same states between steps, to the last bit. What a lane leaves is what was
asked for: outputs at given times, extremes, first and last times of events, and how it ended; its steps are forgotten.

Outputs at given times are ends of shorter steps (`stepping.sample`), made in memory of their own, so that they do not
disturb the run. Extremes are looked for at the start and the end of every step and at the zeros of the rate of what is
asked for, which are watched as events are.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable
from typing import Any

from . import stepping
from .lanes_layout import (
    BUDGET,
    DROPPED,
    ENDED,
    ENERGY,
    EXTREMES,
    FINEST,
    FIRST_STEP,
    KEPT,
    LEFT,
    LIMIT,
    LONGEST,
    N_DROPPED,
    N_EVENTS,
    N_OUTPUTS,
    N_PARAMETERS,
    N_QUATERNIONS,
    N_REDUCED,
    N_TIMES,
    N_WATCHED,
    N_WORK,
    ORDER,
    OUTPUTS,
    PROLOGUE,
    RATES,
    REDUCED,
    ROOM,
    STIFF_ASKED,
    T0,
    T1,
    TOO_MANY,
    WATCHED,
    WIDTH_OF_ROW,
    WORKS,
    N,
)
from .layout import (
    ACCEPTED,
    ASKED,
    BLAME,
    EVENTS,
    FIXED,
    INTEGERS,
    LOGGED,
    MAX_STEP,
    NOT_FINITE,
    OLD_ERROR,
    POINT,
    REALS,
    REJECTED,
    RUNNING,
    START,
    STATE,
    STEP,
    TAKEN,
    TIME,
    UNTIL,
)
from .machine import Compiled, Integers, Reals, call, greater, lesser, shifted, whole

__all__ = ["functions"]

_PARTS: list[Callable[..., Any]] = []

# what `functions` puts in place: the compiled loop of a method
normalise: Any = None
advance: Any = None
sample: Any = None


def part(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function of the loop over lanes."""
    _PARTS.append(function)
    return function


def functions(method: str) -> dict[str, Compiled]:
    """The compiled loop over lanes of a method, with the method's own functions."""
    given = importlib.import_module(f".{method}", __package__).FUNCTIONS
    return {**given, **stepping.bound(_PARTS, {**globals(), **given})}


@part
def first_length(
    rates: int, t: float, direction: float, longest: float, work: Reals, w: int, n: int, c: Reals, relative: Reals,
    absolute: Reals, order: float,
) -> float:  # fmt: skip
    """A length for the first step, as `integrate` chooses it (Hairer, Norsett, Wanner, section II.4).

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
def tightening(steps: int, done: float, left: float, order: float, least: float) -> float:
    """What tolerances are multiplied by where a run has used its budget of steps: see `integrate`.

    ``done`` and ``left`` are the times behind and ahead; with ``least`` the smallest relative tolerance is the finest.
    """
    ahead = steps * left / done
    factor = 1.0
    if ahead > steps:
        factor = (steps / ahead) ** (order / (order - 1.0))
    return greater(factor, lesser(1.0, least))


@part
def widen(
    kernel: int, t: float, states: Reals, place: int, c: Reals, spare: Reals, count: int, reduced: Reals, j: int
) -> None:  # fmt: skip
    """Greatest, smallest and last value of each of ``count`` quantities, with those at one more state."""
    call(kernel, t, states, place, c, spare, 0)
    for k in range(count):
        x = spare[k]
        row = j + EXTREMES * k
        if not reduced[row] >= x:  # nothing yet is nan
            reduced[row] = x
        if not reduced[row + 1] <= x:
            reduced[row + 1] = x
        reduced[row + 3] = x


@part
def lanes(
    begin: int, end: int, kernels: Integers, sizes: Integers, options: Reals, initial: Reals, parameters: Reals,
    wanted: Reals, quaternions: Integers, relative: Reals, tolerances: Reals, directions: Integers,
    terminal: Integers, work: Reals, other: Reals, c: Reals, absolute: Reals, times: Reals, lengths: Reals,
    states: Reals, last: Integers, table: Reals, g: Reals, found: Reals, event_log: Reals, event_states: Reals,
    sampled: Reals, spare: Reals, reals: Reals, integers: Integers, spare_integers: Integers, values: Reals,
    reduced: Reals, event_times: Reals, counts: Integers, kept: Integers, ends: Reals,
) -> None:  # fmt: skip
    """Runs ``begin`` to ``end`` - 1.

    Parameters
    ----------
    kernels, sizes, options      addresses, counts and numbers (`lanes_layout`)
    initial, parameters          rows of each lane: y, and the parameters
    wanted                       output times, in the order of the run
    quaternions                  as for `stepping.advance`
    relative, tolerances         of each component; the last of ``tolerances``, of the work, in parts of the energy
    directions, terminal         of the events, and of the rates of extremes after them
    work ... spare_integers      memory of this thread; ``absolute`` holds a lane's relative tolerances, too
    values                       rows of each lane: outputs at each time; nan where it did not come so far
    reduced                      rows of each lane: greatest, smallest, first and last value of each quantity
    event_times                  rows of each lane: first and last time of each event
    counts                       rows of each lane: how often each event happened
    kept, ends                   rows of each lane: how it ended, steps, rejected steps, component to blame; when
    """
    n, w, nq = sizes[N], sizes[WIDTH_OF_ROW], sizes[N_QUATERNIONS]
    p, m, asked = sizes[N_PARAMETERS], sizes[N_WATCHED], sizes[N_EVENTS]
    outputs, count, many = sizes[N_OUTPUTS], sizes[N_TIMES], sizes[N_REDUCED]
    room = sizes[ROOM]
    rates, start, until = kernels[RATES], options[T0], options[T1]
    direction = 1.0 if until >= start else -1.0
    longest = lesser(options[LONGEST], abs(until - start))
    own = shifted(absolute, n)
    for lane in range(begin, end):
        call(kernels[PROLOGUE], 0.0, parameters, lane * p, c, c, 0)
        for i in range(sizes[N_WORK]):
            work[i] = 0.0
        for i in range(n):
            work[STATE * w + i] = initial[lane * n + i]
            absolute[i] = tolerances[i]
            own[i] = relative[i]
        normalise(work, STATE * w, quaternions, nq)
        for k in range(INTEGERS):
            integers[k] = 0
        for k in range(REALS):
            reals[k] = 0.0
        reals[TIME] = reals[START] = start
        call(rates, start, work, STATE * w, c, work, 0)
        code = RUNNING
        for i in range(n):
            if not math.isfinite(work[i]) and code == RUNNING:
                code = NOT_FINITE
                integers[BLAME] = i
        if sizes[WORKS] != 0 and code == RUNNING:
            call(kernels[ENERGY], start, work, STATE * w, c, spare, 0)
            energy = greater(abs(spare[0]), abs(spare[1]))
            if 0.0 < energy < math.inf:
                absolute[n - 1] *= energy
        step = options[FIRST_STEP]
        if step == 0.0:
            step = first_length(
                rates, start, direction, longest, work, w, n, c, relative, absolute, options[ORDER]
            )  # fmt: skip
        for i in range(w):  # rows that only the first step has used
            work[POINT * w + i] = 0.0
            work[w + i] = 0.0
        integers[ASKED] = sizes[STIFF_ASKED]
        if options[FIRST_STEP] != 0.0:
            integers[FIXED] = 1
        reals[UNTIL], reals[MAX_STEP] = until, options[LONGEST]
        reals[STEP], reals[OLD_ERROR] = direction * lesser(step, longest), 1e-4
        if m > 0:
            call(kernels[WATCHED], start, work, STATE * w, c, table, 0)
            for e in range(m):
                last[e] = 1 if table[e] > 0.0 else (-1 if table[e] < 0.0 else 0)
        if many > 0:
            place = lane * many * EXTREMES
            widen(kernels[REDUCED], start, work, STATE * w, c, spare, many, reduced, place)
            for k in range(many):
                reduced[place + EXTREMES * k + 2] = spare[k]
        done, given = 0, 0
        left, budget = sizes[LIMIT], sizes[BUDGET]
        if longest == 0.0 and code == RUNNING:
            code = ENDED
            for k in range(count):
                call(kernels[OUTPUTS], start, work, STATE * w, c, values, (lane * count + k) * outputs)
        while code == RUNNING:
            allowed = room if left > room else left
            if 0 < budget < allowed:
                allowed = budget
            code = advance(
                rates, n, c, work, w, quaternions, nq, own, absolute, reals, integers, allowed, times, lengths,
                states, kernels[WATCHED], m, c, directions, terminal, last, table, g, found, event_log, event_states,
            )  # fmt: skip
            done = integers[ACCEPTED]
            left -= done
            now = reals[TIME]
            if budget > 0 and done > 0:
                budget -= done
                if budget == 0:
                    finest = own[0]
                    for i in range(n):
                        finest = lesser(own[i], finest)
                    tighter = tightening(
                        sizes[BUDGET], now - start, until - now, options[ORDER], options[FINEST] / finest
                    )
                    for i in range(n):
                        own[i] *= tighter
                        absolute[i] *= tighter
                    reals[STEP] *= tighter ** (1.0 / options[ORDER])
            times[done] = now
            for i in range(n):
                states[done * n + i] = work[STATE * w + i]
            for k in range(integers[EVENTS]):
                e = whole(event_log[LOGGED * k + 1])
                if e < asked:
                    row = (lane * asked + e) * 2
                    if counts[lane * asked + e] == 0:
                        event_times[row] = event_log[LOGGED * k]
                    event_times[row + 1] = event_log[LOGGED * k]
                    counts[lane * asked + e] += 1
                if many > 0:
                    widen(
                        kernels[REDUCED], event_log[LOGGED * k], event_states, k * n, c, spare, many, reduced,
                        lane * many * EXTREMES,
                    )  # fmt: skip
            if many > 0:
                for k in range(1, done + 1):
                    widen(
                        kernels[REDUCED],
                        times[k],
                        states,
                        k * n,
                        c,
                        spare,
                        many,
                        reduced,
                        lane * many * EXTREMES,
                    )
            reach = given
            while reach < count and (wanted[reach] - now) * direction <= 0.0:
                reach += 1
            if reach > given:
                for i in range(sizes[N_WORK]):
                    other[i] = 0.0
                sample(
                    rates, n, c, other, w, quaternions, nq, done, times, lengths, states, 0, reach - given,
                    shifted(wanted, given), sampled, own, absolute, spare_integers,
                )  # fmt: skip
                for k in range(given, reach):
                    call(
                        kernels[OUTPUTS], wanted[k], sampled, (k - given) * n, c, values,
                        (lane * count + k) * outputs,
                    )  # fmt: skip
                given = reach
            if sizes[N_DROPPED] > 0:
                for k in range(done + 1):
                    size = 0.0
                    for i in range(n):
                        size = greater(size, abs(states[k * n + i]))
                    call(kernels[DROPPED], times[k], states, k * n, c, spare, 0)
                    for j in range(sizes[N_DROPPED]):
                        if abs(spare[j]) > 1e-6 * (1.0 + size):
                            code = LEFT
            if code == RUNNING and left <= 0:
                code = TOO_MANY
        kept[KEPT * lane] = code
        kept[KEPT * lane + 1] = integers[TAKEN]
        kept[KEPT * lane + 2] = integers[REJECTED]
        kept[KEPT * lane + 3] = integers[BLAME]
        ends[lane] = reals[TIME]
