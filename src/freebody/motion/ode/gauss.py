"""Gauss collocation of order 16 with step-size control, for tolerances down to round-off.

The eight stages (`collocation`) are iterated to a thousandth of the tolerance, and sums are compensated, so that the
error of a long run is that of its steps and not of its number of operations. Within a step the rates are a polynomial Σ
a_k P_k. If its coefficients fall geometrically, the error of the step falls as the square of the last coefficient:

    ε = A (L / A)^(2S/(S - 1)),   A = h max_k,i |a_k,i| / s_i,   L = h max_i (|a_7,i|, |a_6,i| / 10) / s_i

with the tolerances s_i = a_i + r_i |y_i|. The dense output is the polynomial itself, of order 8.
"""

from __future__ import annotations

import math

from ...native.instructions import Integers, Reals, compiled, greater
from . import step_control
from .collocation import NEW_, bound_to
from .layout import BLAME, POINT, RAW, ROWS, STATE

STAGES = 8
_bound = bound_to(STAGES, goal=1e-3, most=25)
forget, step_from, hold_step, pass_step, along = (
    _bound[name] for name in ("forget", "step_from", "hold_step", "pass_step", "along")
)


@compiled
def prepare(
    rates: int, t: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int, integers: Integers
) -> None:  # fmt: skip
    """Take the rates at the start as a guess for those of the stages, since there is no step before."""
    block = ROWS * w
    for i in range(n):
        work[block + (4 * STAGES + NEW_) * w + i] = work[i]
    forget(work, block, w, n, 1.0)


@compiled
def attempt(
    rates: int, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int,
    relative: Reals, absolute: Reals, integers: Integers,
) -> int:  # fmt: skip
    """Take one step of length ``h`` from STATE to RAW."""
    return step_from(
        rates, t, h, work, STATE * w, RAW * w, ROWS * w, w, n, c, relative, absolute, n, integers
    )


@compiled
def judge(
    n: int, work: Reals, w: int, h: float, relative: Reals, absolute: Reals, integers: Integers
) -> float:
    """Return the error of the attempted step in units of the tolerance, nan if it is not finite."""
    block = ROWS * w
    size, largest_last = 0.0, 0.0
    for i in range(n):
        new, old = abs(work[RAW * w + i]), abs(work[STATE * w + i])
        if not math.isfinite(new):
            return math.nan
        scale = (absolute[i] + relative[i] * greater(new, old)) / abs(h)
        for k in range(STAGES):
            size = greater(size, abs(work[block + (STAGES + k) * w + i]) / scale)
        last = abs(work[block + (2 * STAGES - 1) * w + i]) / scale
        second_last = 0.1 * abs(work[block + (2 * STAGES - 2) * w + i]) / scale
        last = greater(last, second_last)
        if last > largest_last:
            largest_last = last
            integers[BLAME] = i
    if size == 0.0:
        return 0.0
    return size * (largest_last / size) ** (2.0 * STAGES / (STAGES - 1.0))


@compiled
def interpolate(x: float, work: Reals, w: int) -> None:
    """Set row POINT: the collocation polynomial at the fraction ``x`` (0 to 1) of the step."""
    along(x, work, STATE * w, ROWS * w, w, w, POINT * w)


@compiled
def hold(work: Reals, w: int, n: int) -> None:
    """Save the coefficients while parts of the step are tried."""
    hold_step(work, ROWS * w, w, w)


@compiled
def accept(work: Reals, w: int, n: int) -> None:
    """Make the step the previous step."""
    pass_step(work, ROWS * w, w, w)


FUNCTIONS = step_control.Functions(
    {
        "EXPONENT": 1.0 / (2 * STAGES),
        "SAFETY": 0.85,
        "SMALLEST": 0.2,
        "GREATEST": 2.5,
        "prepare": prepare,
        "attempt": attempt,
        "judge": judge,
        "densify": step_control.nothing_to_densify,
        "interpolate": interpolate,
        "hold": hold,
        "accept": accept,
    }
)
