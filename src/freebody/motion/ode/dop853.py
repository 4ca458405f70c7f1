"""The explicit Runge-Kutta method of order 8(5,3) of Dormand and Prince.

A step, its error and its control follow Hairer, Norsett and Wanner (`tableau`). The estimate

    ε = |h| e5² / sqrt(e5² + e3²/100),   e = max_i |error_i| / (a_i + r_i max(|y_i|, |y_i(t + h)|))

uses the greatest component and not the mean, so that a tolerance holds for every coordinate of a large machine. The
next step is h · 0.9 ε^-(1/8 - β/5) ε_old^β, between h/3 and 6h. The dense output has order 7.
"""

from __future__ import annotations

import math

from ...native.instructions import Integers, Reals, call, compiled, greater, linear, root
from . import step_control, tableau
from .layout import ARGUMENT, BLAME, DENSE, ERROR3, ERROR5, POINT, RAW, STATE
from .step_control import cubic, nothing_to_keep, nothing_to_prepare

_C1, _C2, _C3, _C4, _C5, _C6, _C7, _C8, _C9, _C10, _C11 = tableau.C[1:12]
_C13, _C14, _C15 = tableau.C[13:16]
_a1, _a2, _a3, _a4, _a5, _a6, _a7, _a8, _a9, _a10, _a11 = (
    linear(row, chained=True) for row in tableau.A[1:12]
)
_a13, _a14, _a15 = (linear(row) for row in tableau.A[13:16])
_b, _e5, _e3 = linear(tableau.B), linear(tableau.E5), linear(tableau.E3)
_d3, _d4, _d5, _d6 = (linear(row) for row in tableau.D)


@compiled
def attempt(
    rates: int, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int,
    relative: Reals, absolute: Reals, integers: Integers,
) -> int:  # fmt: skip
    """Take one step of length ``h`` from STATE, whose rates are row 0: fill rows 1 to 11, RAW, ERROR5 and ERROR3."""
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
    return 0


@compiled
def densify(
    rates: int, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int
) -> None:
    """Set rows DENSE to DENSE + 6 of the dense output of the step in ``work``; row 12 holds the rates at its end."""
    a = ARGUMENT * w
    _a13(work, w, ARGUMENT, STATE, h)
    call(rates, t + _C13 * h, work, a, c, work, 13 * w)
    _a14(work, w, ARGUMENT, STATE, h)
    call(rates, t + _C14 * h, work, a, c, work, 14 * w)
    _a15(work, w, ARGUMENT, STATE, h)
    call(rates, t + _C15 * h, work, a, c, work, 15 * w)
    cubic(work, w, h, 12)
    _d3(work, w, DENSE + 3, -1, h)
    _d4(work, w, DENSE + 4, -1, h)
    _d5(work, w, DENSE + 5, -1, h)
    _d6(work, w, DENSE + 6, -1, h)


@compiled
def interpolate(x: float, work: Reals, w: int) -> None:
    """Set row POINT: the dense output at the fraction ``x`` (0 to 1) of the step."""
    z = 1.0 - x
    d = DENSE * w
    for i in range(w):
        p = work[d + 5 * w + i] + x * work[d + 6 * w + i]
        p = work[d + 3 * w + i] + x * (work[d + 4 * w + i] + z * p)
        p = work[d + 1 * w + i] + x * (work[d + 2 * w + i] + z * p)
        work[POINT * w + i] = work[STATE * w + i] + x * (work[d + i] + z * p)


@compiled
def judge(
    n: int, work: Reals, w: int, h: float, relative: Reals, absolute: Reals, integers: Integers
) -> float:
    """Return the error of the attempted step in units of the tolerance, nan if it is not finite."""
    error5, error3 = 0.0, 0.0
    for i in range(n):
        new = work[RAW * w + i]
        scale = absolute[i] + relative[i] * greater(abs(work[STATE * w + i]), abs(new))
        ratio5, ratio3 = abs(work[ERROR5 * w + i]) / scale, abs(work[ERROR3 * w + i]) / scale
        if not (math.isfinite(new) and math.isfinite(ratio5) and math.isfinite(ratio3)):
            return math.nan
        if ratio5 > error5:
            error5 = ratio5
            integers[BLAME] = i
        error3 = greater(error3, ratio3)
    if error5 == 0.0:
        return 0.0
    return error5 * error5 / root(error5 * error5 + 0.01 * error3 * error3)


_BETA = 0.04
CONTROL = {
    "EXPONENT": 0.125 - 0.2 * _BETA, "BETA": _BETA, "COST": 11, "COST_DENSE": 3, "LAST": 11, "LIMIT": 6.1,
}  # fmt: skip
FUNCTIONS = step_control.Functions(
    {
        **CONTROL,
        "prepare": nothing_to_prepare,
        "attempt": attempt,
        "judge": judge,
        "densify": densify,
        "interpolate": interpolate,
        "hold": nothing_to_keep,
        "accept": nothing_to_keep,
    }
)
