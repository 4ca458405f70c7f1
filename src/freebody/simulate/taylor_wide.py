"""Taylor series in time: the step of `taylor` for eight lanes (`lanes_wide`).

One kernel (`compile.jet_wide`) fills the coefficients of eight lanes; the length of a step, its end and what its sums
lose follow from them as they do for one. They stand after the places of the lanes, since the kernel needs room there of
a length that only it knows.
"""

from __future__ import annotations

import math

from .lanes_layout import CHANGES, ERRORS, LENGTHS, LIMITED, LOGARITHMS, MOMENTS, STEPS, TIMES, WIDE_PLACES
from .layout import RAW, STATE
from .machine import Reals, compiled, greater, shifted
from .machine_wide import blend, call_wide, decaying, lanewise, lengths
from .taylor import BOUND, EARLY, GROWN, LOSES, LOST, SERIES, SLOPES, TERMS, P, distance, sum_of_series

HEIGHT = SERIES
TINY = 1e-300
"""A part of the tolerance that counts as nothing."""
_lengths, _decaying = lengths(P, TERMS, TINY), decaying(P, BOUND, EARLY, GROWN)
_added, _missed = lanewise(sum_of_series, HEIGHT), lanewise(distance, HEIGHT)


@compiled
def prepare_wide(kernel: int, wide: Reals, w: int, c: Reals, tolerances: Reals) -> None:
    """The coefficients through STATE, and the lengths of the steps."""
    more = HEIGHT * w
    series = more + WIDE_PLACES
    call_wide(kernel, wide, more + TIMES, wide, STATE * w, c, wide, series)
    _lengths(wide, w, series, STATE * w, tolerances, more + LOGARITHMS, more + LENGTHS)


@compiled
def blame_wide(lane: int, n: int, wide: Reals, w: int) -> int:
    """The first component whose last coefficients are not finite."""
    for i in range(n):
        for j in range(TERMS):
            if not math.isfinite(wide[(HEIGHT + P - j) * w + WIDE_PLACES + 8 * i + lane]):
                return i
    return 0


@compiled
def attempt_wide(kernel: int, wide: Reals, w: int, c: Reals) -> None:
    """The states at the ends of the steps; the error of one is 0, or nan if the state is not finite."""
    more = HEIGHT * w
    series = more + WIDE_PLACES
    _added(wide, w, more + ERRORS, more + STEPS)
    _decaying(wide, w, series + P * w, more + STEPS, more + LIMITED)


@compiled
def judge_wide(rates: int, n: int, wide: Reals, w: int, c: Reals, tolerances: Reals) -> None:
    """How far the steps have gone on behind a bend, where there may be one: see `taylor.attempt`."""
    if rates != 0:
        more = HEIGHT * w
        for lane in range(8):
            wide[more + MOMENTS + lane] = wide[more + TIMES + lane] + wide[more + STEPS + lane]
        call_wide(rates, wide, more + MOMENTS, wide, RAW * w, c, wide, SLOPES * w)
        _missed(wide, w, more + CHANGES, more + STEPS, shifted(tolerances, w), tolerances)
        for lane in range(8):
            wide[more + ERRORS + lane] += wide[more + CHANGES + lane]


@compiled
def limit_wide(n: int, wide: Reals, w: int) -> None:
    """Nothing: `attempt_wide` has seen it."""


@compiled
def begin_wide(lane: int, n: int, wide: Reals, w: int) -> None:
    """No sum has lost anything yet."""
    for i in range(n):
        wide[LOST * w + 8 * i + lane] = 0.0


@compiled
def tune_wide(lane: int, n: int, wide: Reals, w: int, tolerances: Reals) -> None:
    """log₂ r / p, r the coarsest of the relative tolerances."""
    coarsest = 1e-16
    for i in range(n):
        coarsest = greater(coarsest, tolerances[w + 8 * i + lane])
    wide[HEIGHT * w + LOGARITHMS + lane] = math.log2(coarsest) / P


@compiled
def accept_wide(wide: Reals, w: int, wanted: int) -> None:
    """What the sums of this step lost is added to the next."""
    blend(wide, w, LOSES * w, LOST * w, wanted)


@compiled
def lift(lane: int, n: int, wide: Reals, w: int, work: Reals, w1: int) -> None:
    """The step of one lane in a work array of its own."""
    for k in range(STATE, SERIES + P + 1):
        row = k * w + lane
        if k >= HEIGHT:
            row += WIDE_PLACES
        for i in range(n):
            work[k * w1 + i] = wide[row + 8 * i]


FUNCTIONS = {
    "HEIGHT": HEIGHT,
    "prepare_wide": prepare_wide,
    "blame_wide": blame_wide,
    "attempt_wide": attempt_wide,
    "judge_wide": judge_wide,
    "limit_wide": limit_wide,
    "begin_wide": begin_wide,
    "tune_wide": tune_wide,
    "accept_wide": accept_wide,
    "lift": lift,
}
