"""Taylor series in time: the step of `taylor` for eight lanes (`lanes_wide`).

One kernel (`jet_wide`) fills the coefficients of eight lanes; the length of a step, its end and what its sums
lose follow from them as they do for one. They stand after the places of the lanes, since the kernel needs room there of
a length that only it knows.
"""

from __future__ import annotations

import math
from typing import Any

from ...native.instructions import Reals, compiled, greater, shifted
from ..ode.layout import END, POINT, RAW, STATE
from ..ode.taylor import (
    BEND,
    BOUND,
    EARLY,
    GROWN,
    LOSES,
    LOST,
    SERIES,
    SLOPES,
    TERMS,
    P,
    distance,
    polynomial,
    sum_of_series,
)
from .instructions_wide import blend, call_wide, decaying, lanewise, lengths, lifted
from .lanes_layout import (
    CHANGES,
    ERRORS,
    LENGTHS,
    LIMITED,
    LOGARITHMS,
    MOMENTS,
    SPANS,
    STEPS,
    TIMES,
    WIDE_PLACES,
)

HEIGHT = SERIES
TINY = 1e-300
"""A part of the tolerance that counts as nothing."""
_lengths, _decaying = lengths(P, TERMS, TINY), decaying(P, BOUND, EARLY, GROWN)


def _state(row: Any, h: Any) -> Any:
    """Row POINT: the series at the time h."""
    row[POINT] = polynomial([row[SERIES + k] for k in range(P + 1)], h)
    return row[POINT] * 0.0


_added, _summed, _missed = (lanewise(formula, HEIGHT) for formula in (sum_of_series, _state, distance))


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
def straight_wide(lane: int, n: int, wide: Reals, w: int, tolerances: Reals) -> float:
    """The series of a lane becomes that of a straight line, as long as the comparison of rates allows, if it has rates:
    see `taylor.given`. Its length, nan if it has none."""
    fast, doubt, place = 0.0, 0.0, (HEIGHT + 1) * w + WIDE_PLACES + lane
    for i in range(n):
        k = 8 * i + lane
        size = abs(wide[STATE * w + k])
        rate = abs(wide[place + 8 * i]) / (tolerances[k] + tolerances[w + k] * size)
        fast = greater(fast, rate)
        doubt += 0.0 * rate
    if not 0.0 < fast + doubt < math.inf:
        return math.nan
    for i in range(n):
        for k in range(1, P):
            wide[place + k * w + 8 * i] = 0.0
    return BEND / fast


@compiled
def attempt_wide(kernel: int, wide: Reals, w: int, c: Reals) -> None:
    """The states at the ends of the steps; the error of one is 0, or nan if the state is not finite."""
    _added(wide, w, HEIGHT * w + ERRORS, HEIGHT * w + STEPS)


@compiled
def judge_wide(rates: int, n: int, wide: Reals, w: int, c: Reals, tolerances: Reals) -> None:
    """How far the steps have gone on behind a bend, where there may be one: see `taylor.attempt`."""
    if rates != 0:
        more = HEIGHT * w
        for k in range(1, 3):
            for lane in range(8):
                wide[more + SPANS + lane] = 0.5 * k * wide[more + STEPS + lane]
                wide[more + MOMENTS + lane] = wide[more + TIMES + lane] + wide[more + SPANS + lane]
            place = RAW * w
            if k == 1:
                _summed(wide, w, more + CHANGES, more + SPANS)
                place = POINT * w
            call_wide(rates, wide, more + MOMENTS, wide, place, c, wide, SLOPES * w)
            _missed(wide, w, more + CHANGES, more + SPANS, shifted(tolerances, w), tolerances)
            for lane in range(8):
                wide[more + ERRORS + lane] += wide[more + CHANGES + lane]


@compiled
def limit_wide(wide: Reals, w: int) -> None:
    """Which steps are as long as the region of stability allows, with λ of a decay."""
    more = HEIGHT * w
    _decaying(wide, w, more + WIDE_PLACES + P * w, more + STEPS, more + LIMITED)


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


FUNCTIONS = {
    "HEIGHT": HEIGHT,
    "prepare_wide": prepare_wide,
    "blame_wide": blame_wide,
    "straight_wide": straight_wide,
    "attempt_wide": attempt_wide,
    "judge_wide": judge_wide,
    "limit_wide": limit_wide,
    "begin_wide": begin_wide,
    "tune_wide": tune_wide,
    "accept_wide": accept_wide,
    "lift": lifted([STATE, END, LOST, *range(SERIES, SERIES + P + 1)], HEIGHT),
}
