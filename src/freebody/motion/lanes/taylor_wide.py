"""Taylor series in time: the step of `taylor` for eight lanes (`lanes_wide`).

One kernel (`jet_wide`) fills the coefficients of eight lanes. The length of a step, its end and the rounding errors of
its sums follow from them as for one lane. The coefficients are stored after the places of the lanes, since the kernel
needs memory there whose size only the kernel knows.
"""

from __future__ import annotations

import math
from typing import Any

from ...native.instructions import Reals, compiled, greater, shifted
from ..ode.run import Run, Series
from ..ode.taylor import BEND, BOUND, EARLY, GROWN, TERMS, P, distance, polynomial, sum_of_series
from .instructions_wide import blend, call_wide, decaying, lanewise, lengths, lifted
from .lanes_layout import (
    CHANGES,
    END,
    ERRORS,
    LENGTHS,
    LIMITED,
    LOGARITHMS,
    MOMENTS,
    POINT,
    RAW,
    ROWS,
    SPANS,
    STATE,
    STEPS,
    TIMES,
    WIDE_PLACES,
)

LOST, LOSES, SERIES, SLOPES = ROWS, ROWS + 1, ROWS + 2, 12
"""Rows of the method: rounding errors of the sum before the step and in it; its coefficients; rates at the end."""
HEIGHT = SERIES
PLACES = {"k": 0, "y": STATE, "y_new": RAW, "point": POINT, "lost": LOST, "loses": LOSES, "terms": SERIES}
TINY = 1e-300
"""Fraction of the tolerance that counts as zero."""
_lengths, _decaying = lengths(P, TERMS, TINY), decaying(P, BOUND, EARLY, GROWN)


def _state(row: Any, h: Any) -> Any:
    """Set row POINT: the series at the time h."""
    row.point = polynomial([row.terms[k] for k in range(P + 1)], h)
    return row.point * 0.0


_added, _summed, _missed = (
    lanewise(formula, PLACES, HEIGHT) for formula in (sum_of_series, _state, distance)
)


@compiled
def prepare_wide(kernel: int, wide: Reals, w: int, c: Reals, tolerances: Reals) -> None:
    """Compute the coefficients through STATE, and the lengths of the steps."""
    places = HEIGHT * w
    series = places + WIDE_PLACES
    call_wide(kernel, wide, places + TIMES, wide, STATE * w, c, wide, series)
    _lengths(wide, w, series, STATE * w, tolerances, places + LOGARITHMS, places + LENGTHS)


@compiled
def blame_wide(lane: int, n: int, wide: Reals, w: int) -> int:
    """Return the component of a lane to blame for what is not finite (`taylor.blamed`)."""
    for j in range(1, P + 1):
        for i in range(n):
            if not math.isfinite(wide[(HEIGHT + j) * w + WIDE_PLACES + 8 * i + lane]):
                return i
    for i in range(n):
        if not math.isfinite(wide[SLOPES * w + 8 * i + lane]):
            return i
    for i in range(n):
        if not math.isfinite(wide[RAW * w + 8 * i + lane]):
            return i
    return 0


@compiled
def straight_wide(lane: int, n: int, wide: Reals, w: int, tolerances: Reals) -> float:
    """Replace the series of a lane by that of a straight line, if it has rates (`taylor.predicted_length`).

    Return its length, which the comparison of rates allows, or nan if there are no rates.
    """
    greatest_rate, doubt, place = 0.0, 0.0, (HEIGHT + 1) * w + WIDE_PLACES + lane
    for i in range(n):
        k = 8 * i + lane
        size = abs(wide[STATE * w + k])
        rate = abs(wide[place + 8 * i]) / (tolerances[k] + tolerances[w + k] * size)
        greatest_rate = greater(greatest_rate, rate)
        doubt += 0.0 * rate
    if not 0.0 < greatest_rate + doubt < math.inf:
        return math.nan
    for i in range(n):
        for k in range(1, P):
            wide[place + k * w + 8 * i] = 0.0
    return BEND / greatest_rate


@compiled
def attempt_wide(kernel: int, wide: Reals, w: int, c: Reals) -> None:
    """Compute the states at the ends of the steps. The error of a step is 0, or nan if its state is not finite."""
    _added(wide, w, HEIGHT * w + ERRORS, HEIGHT * w + STEPS)


@compiled
def judge_wide(rates: int, n: int, wide: Reals, w: int, c: Reals, tolerances: Reals) -> None:
    """Add the errors of steps that continued past a bend, if there may be one (`taylor.attempt`)."""
    if rates != 0:
        places = HEIGHT * w
        for k in range(1, 3):
            for lane in range(8):
                wide[places + SPANS + lane] = 0.5 * k * wide[places + STEPS + lane]
                wide[places + MOMENTS + lane] = wide[places + TIMES + lane] + wide[places + SPANS + lane]
            place = RAW * w
            if k == 1:
                _summed(wide, w, places + CHANGES, places + SPANS)
                place = POINT * w
            call_wide(rates, wide, places + MOMENTS, wide, place, c, wide, SLOPES * w)
            _missed(wide, w, places + CHANGES, places + SPANS, shifted(tolerances, w), tolerances)
            for lane in range(8):
                wide[places + ERRORS + lane] += wide[places + CHANGES + lane]


@compiled
def limit_wide(wide: Reals, w: int) -> None:
    """Mark the steps that are as long as the region of stability allows, with λ of a decay."""
    places = HEIGHT * w
    _decaying(wide, w, places + WIDE_PLACES + P * w, places + STEPS, places + LIMITED)


@compiled
def begin_wide(lane: int, n: int, wide: Reals, w: int) -> None:
    """Clear the rounding errors of the sums of a lane."""
    for i in range(n):
        wide[LOST * w + 8 * i + lane] = 0.0


@compiled
def tune_wide(lane: int, n: int, wide: Reals, w: int, tolerances: Reals) -> None:
    """Set log₂ r / p, with r the coarsest relative tolerance."""
    coarsest = 1e-16
    for i in range(n):
        coarsest = greater(coarsest, tolerances[w + 8 * i + lane])
    wide[HEIGHT * w + LOGARITHMS + lane] = math.log2(coarsest) / P


@compiled
def accept_wide(wide: Reals, w: int, selected: int) -> None:
    """Pass the rounding errors of the sums to the next step."""
    blend(wide, w, LOSES * w, LOST * w, selected)


_lift = lifted(
    {
        STATE: (False, STATE),
        END: (False, END),
        LOST: (True, 0),
        **{SERIES + k: (True, 3 + k) for k in range(P + 1)},
    },
    HEIGHT,
)


@compiled
def lift(lane: int, wide: Reals, w: int, run: Run) -> None:
    """Copy the step of a lane into the memory of a run."""
    _lift(lane, run.n, wide, w, run.k[0], Series(run.own).lost, run.width)


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
    "lift": lift,
}
