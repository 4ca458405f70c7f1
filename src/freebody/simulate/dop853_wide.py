"""Explicit Runge-Kutta of order 8, Dormand and Prince: the step of `dop853` for eight lanes (`lanes_wide`)."""

from __future__ import annotations

import math

from . import dop853, tableau
from .lanes_layout import ERRORS, LIMITED, MOMENTS, STEPS, TIMES
from .layout import ARGUMENT, END, ERROR3, ERROR5, RAW, ROWS, STATE
from .machine import Reals, compiled, greater, linear, root
from .machine_wide import blend, call_wide

HEIGHT = ROWS
LAST, STABLE = dop853.CONTROL["LAST"], dop853.CONTROL["LIMIT"]

_C1, _C2, _C3, _C4, _C5, _C6, _C7, _C8, _C9, _C10, _C11 = tableau.C[1:12]
_a1, _a2, _a3, _a4, _a5, _a6, _a7, _a8, _a9, _a10, _a11 = (
    linear(row, chained=True, lanes=True) for row in tableau.A[1:12]
)
_b, _e5, _e3 = (linear(row, lanes=True) for row in (tableau.B, tableau.E5, tableau.E3))


@compiled
def prepare_wide(kernel: int, wide: Reals, w: int, c: Reals, tolerances: Reals) -> None:
    """Nothing: the rates at STATE are those at the end of the step before."""


@compiled
def stage(kernel: int, fraction: float, k: int, wide: Reals, w: int, c: Reals) -> None:
    """Row k: the rates at row ARGUMENT, at the part ``fraction`` of every lane's step."""
    more = ROWS * w
    for lane in range(8):
        wide[more + MOMENTS + lane] = wide[more + TIMES + lane] + fraction * wide[more + STEPS + lane]
    call_wide(kernel, wide, more + MOMENTS, wide, ARGUMENT * w, c, wide, k * w)


@compiled
def attempt_wide(kernel: int, wide: Reals, w: int, c: Reals) -> None:
    """One step of each lane from STATE, whose rates are row 0: see `dop853.attempt`."""
    h = ROWS * w + STEPS
    _a1(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C1, 1, wide, w, c)
    _a2(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C2, 2, wide, w, c)
    _a3(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C3, 3, wide, w, c)
    _a4(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C4, 4, wide, w, c)
    _a5(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C5, 5, wide, w, c)
    _a6(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C6, 6, wide, w, c)
    _a7(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C7, 7, wide, w, c)
    _a8(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C8, 8, wide, w, c)
    _a9(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C9, 9, wide, w, c)
    _a10(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C10, 10, wide, w, c)
    _a11(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C11, 11, wide, w, c)
    _b(wide, w, RAW, STATE, h)
    _e5(wide, w, ERROR5, -1, h)
    _e3(wide, w, ERROR3, -1, h)


@compiled
def _judge(lane: int, n: int, wide: Reals, w: int, tolerances: Reals) -> float:
    """See `dop853.judge`."""
    error5, error3 = 0.0, 0.0
    for i in range(n):
        k = 8 * i + lane
        new = wide[RAW * w + k]
        scale = tolerances[k] + tolerances[w + k] * greater(abs(wide[STATE * w + k]), abs(new))
        one, two = abs(wide[ERROR5 * w + k]) / scale, abs(wide[ERROR3 * w + k]) / scale
        if not (math.isfinite(new) and math.isfinite(one) and math.isfinite(two)):
            return math.nan
        error5 = greater(one, error5)
        error3 = greater(error3, two)
    if error5 == 0.0:
        return 0.0
    return error5 * error5 / root(error5 * error5 + 0.01 * error3 * error3)


@compiled
def judge_wide(rates: int, n: int, wide: Reals, w: int, c: Reals, tolerances: Reals) -> None:
    """Errors of the steps in units of their tolerances, nan if they are not finite."""
    for lane in range(8):
        wide[ROWS * w + ERRORS + lane] = _judge(lane, n, wide, w, tolerances)


@compiled
def limit_wide(n: int, wide: Reals, w: int) -> None:
    """Which steps are as long as the region of stability allows: see `stepping._stiff`."""
    for lane in range(8):
        h = wide[ROWS * w + STEPS + lane]
        above, below, across = 0.0, 0.0, 0.0
        for i in range(n):
            k = 8 * i + lane
            a = wide[12 * w + k] - wide[LAST * w + k]
            b = wide[END * w + k] - wide[ARGUMENT * w + k]
            above += a * a
            below += b * b
            across += a * b
        decays = h * across < -0.5 * abs(h) * root(above * below)
        limited = decays and h * h * above > STABLE * STABLE * below and below > 0.0
        wide[ROWS * w + LIMITED + lane] = 1.0 if limited else 0.0


@compiled
def begin_wide(lane: int, n: int, wide: Reals, w: int) -> None:
    """Nothing is carried from step to step but the state and its rates."""


@compiled
def tune_wide(lane: int, n: int, wide: Reals, w: int, tolerances: Reals) -> None:
    """Nothing follows from the tolerances."""


@compiled
def accept_wide(wide: Reals, w: int, wanted: int) -> None:
    """The rates at the end are those of the next step."""
    blend(wide, w, 12 * w, 0, wanted)


@compiled
def lift(lane: int, n: int, wide: Reals, w: int, work: Reals, w1: int) -> None:
    """The step of one lane in a work array of its own."""
    for k in range(END + 1):
        for i in range(n):
            work[k * w1 + i] = wide[k * w + 8 * i + lane]


FUNCTIONS = {
    "HEIGHT": HEIGHT,
    "prepare_wide": prepare_wide,
    "attempt_wide": attempt_wide,
    "judge_wide": judge_wide,
    "limit_wide": limit_wide,
    "begin_wide": begin_wide,
    "tune_wide": tune_wide,
    "accept_wide": accept_wide,
    "lift": lift,
}
