"""The explicit Runge-Kutta method of order 5(4) of Dormand and Prince, for coarse tolerances.

    k_i = f(t + c_i h, y + h Σ_j a_ij k_j),   i = 0 ... 6,        y(t + h) = y + h Σ_j b_j k_j

The error is the difference from the embedded result of order 4. The dense output has order 4. A step needs seven
evaluations of f, and its start an eighth; a step of order 8 needs twelve. At relative accuracies coarser than about
1e-5 this method is the cheaper.

Source: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I (1993), sections II.5 (table 5.2)
and II.6.
"""

from __future__ import annotations

import math

from ...native.instructions import Integers, Reals, call, compiled, linear
from . import step_control
from .layout import ARGUMENT, BLAME, DENSE, ERROR5, POINT, RAW, STATE
from .step_control import cubic, nothing_to_keep, nothing_to_prepare

_a1 = linear({0: 1 / 5}, chained=True)
_a2 = linear({0: 3 / 40, 1: 9 / 40}, chained=True)
_a3 = linear({0: 44 / 45, 1: -56 / 15, 2: 32 / 9}, chained=True)
_a4 = linear({0: 19372 / 6561, 1: -25360 / 2187, 2: 64448 / 6561, 3: -212 / 729}, chained=True)
_a5 = linear({0: 9017 / 3168, 1: -355 / 33, 2: 46732 / 5247, 3: 49 / 176, 4: -5103 / 18656}, chained=True)
_b = linear({0: 35 / 384, 2: 500 / 1113, 3: 125 / 192, 4: -2187 / 6784, 5: 11 / 84})
_e = linear(
    {0: 71 / 57600, 2: -71 / 16695, 3: 71 / 1920, 4: -17253 / 339200, 5: 22 / 525, 6: -1 / 40}
)  # fmt: skip
_d = linear(
    {
        0: -12715105075 / 11282082432, 2: 87487479700 / 32700410799, 3: -10690763975 / 1880347072,
        4: 701980252875 / 199316789632, 5: -1453857185 / 822651844, 6: 69997945 / 29380423,
    }
)  # fmt: skip


@compiled
def attempt(
    rates: int, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int,
    relative: Reals, absolute: Reals, integers: Integers,
) -> int:  # fmt: skip
    """Take one step of length ``h`` from STATE, whose rates are row 0: fill rows 1 to 6, RAW and ERROR5."""
    a = ARGUMENT * w
    _a1(work, w, ARGUMENT, STATE, h)
    call(rates, t + 0.2 * h, work, a, c, work, w)
    _a2(work, w, ARGUMENT, STATE, h)
    call(rates, t + 0.3 * h, work, a, c, work, 2 * w)
    _a3(work, w, ARGUMENT, STATE, h)
    call(rates, t + 0.8 * h, work, a, c, work, 3 * w)
    _a4(work, w, ARGUMENT, STATE, h)
    call(rates, t + 8.0 / 9.0 * h, work, a, c, work, 4 * w)
    _a5(work, w, ARGUMENT, STATE, h)
    call(rates, t + h, work, a, c, work, 5 * w)
    _b(work, w, RAW, STATE, h)
    call(rates, t + h, work, RAW * w, c, work, 6 * w)
    _e(work, w, ERROR5, -1, h)
    return 0


@compiled
def densify(
    rates: int, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int
) -> None:
    """Set rows DENSE to DENSE + 3 of the dense output of the step in ``work``."""
    cubic(work, w, h, 6)
    _d(work, w, DENSE + 3, -1, h)


@compiled
def interpolate(x: float, work: Reals, w: int) -> None:
    """Set row POINT: the dense output at the fraction ``x`` (0 to 1) of the step."""
    z = 1.0 - x
    d = DENSE * w
    for i in range(w):
        p = work[d + 2 * w + i] + z * work[d + 3 * w + i]
        work[POINT * w + i] = work[STATE * w + i] + x * (work[d + i] + z * (work[d + w + i] + x * p))


@compiled
def judge(
    n: int, work: Reals, w: int, h: float, relative: Reals, absolute: Reals, integers: Integers
) -> float:
    """Return the error of the attempted step in units of the tolerance, nan if it is not finite."""
    error = 0.0
    for i in range(n):
        new = abs(work[RAW * w + i])
        old = abs(work[STATE * w + i])
        ratio = abs(work[ERROR5 * w + i]) / (absolute[i] + relative[i] * (new if new > old else old))
        if not (math.isfinite(new) and math.isfinite(ratio)):
            return math.nan
        if ratio > error:
            error = ratio
            integers[BLAME] = i
    return error


_BETA = 0.04
FUNCTIONS = step_control.Functions(
    {
        "EXPONENT": 0.2 - 0.75 * _BETA,
        "BETA": _BETA,
        "SMALLEST": 0.2,
        "GREATEST": 10.0,
        "COST": 6,
        "LAST": 5,
        "LIMIT": 3.25,
        "prepare": nothing_to_prepare,
        "attempt": attempt,
        "judge": judge,
        "densify": densify,
        "interpolate": interpolate,
        "hold": nothing_to_keep,
        "accept": nothing_to_keep,
    }
)
