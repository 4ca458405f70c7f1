"""Gauss collocation of order 16 with step-size control, for tolerances down to round-off.

The eight stages (`collocation`) are iterated to a thousandth of the tolerance, and sums are compensated, so that the
error of a long run is that of its steps and not of its number of operations. Within a step the rates are a polynomial Σ
a_k P_k. If its coefficients fall geometrically, the error of the step falls as the square of the last coefficient:

    ε = A (L / A)^(2S/(S - 1)),   A = h max_k,i |a_k,i| / s_i,   L = h max_i (|a_7,i|, |a_6,i| / 10) / s_i

with the tolerances s_i = a_i + r_i |y_i|. The dense output is the polynomial itself, of order 8.
"""

from __future__ import annotations

import math

from ...native.instructions import compiled, greater
from .collocation import bound_to
from .run import Collocation, Run
from .step_control import Functions, Method

STAGES = 8
_bound = bound_to(STAGES, goal=1e-3, most=25)
forget, step_from, hold_step, pass_step, along = (
    _bound[name] for name in ("forget", "step_from", "hold_step", "pass_step", "along")
)


@compiled
def prepare(run: Run) -> None:
    """Take the rates at the start as a guess for those of the stages, since there is no step before."""
    own = Collocation(run.own)
    for i in range(run.n):
        own.new[i] = run.k[0, i]
    forget(own, 1.0)


@compiled
def attempt(run: Run, h: float) -> int:
    """Take one step of length ``h`` from y to y_new."""
    return step_from(run, Collocation(run.own), h)


@compiled
def judge(run: Run, h: float) -> float:
    """Return the error ε of the step in units of the tolerance, nan if it is not finite."""
    own = Collocation(run.own)
    size, largest_last = 0.0, 0.0
    for i in range(run.n):
        new, old = abs(run.y_new[i]), abs(run.y[i])
        if not math.isfinite(new):
            return math.nan
        scale = (run.absolute[i] + run.relative[i] * greater(new, old)) / abs(h)
        for k in range(STAGES):
            size = greater(size, abs(own.series[k, i]) / scale)
        last = abs(own.series[STAGES - 1, i]) / scale
        last = greater(last, 0.1 * abs(own.series[STAGES - 2, i]) / scale)
        if last > largest_last:
            largest_last = last
            run.blame = i
    if size == 0.0:
        return 0.0
    return size * (largest_last / size) ** (2.0 * STAGES / (STAGES - 1.0))


@compiled
def interpolate(run: Run, x: float) -> None:
    """Set the row point: the collocation polynomial at the fraction ``x`` (0 to 1) of the step."""
    along(Collocation(run.own), x, run.point)


@compiled
def hold(run: Run) -> None:
    """Save the coefficients while parts of the step are tried."""
    hold_step(Collocation(run.own))


@compiled
def accept(run: Run) -> None:
    """Make the step the previous step."""
    pass_step(Collocation(run.own))


METHOD = Method(
    name="gauss", order=2 * STAGES, attempt=attempt, judge=judge, interpolate=interpolate, prepare=prepare, hold=hold,
    accept=accept, alpha=1.0 / (2 * STAGES), safety=0.85, smallest=0.2, greatest=2.5,
)  # fmt: skip
FUNCTIONS = Functions(METHOD)
