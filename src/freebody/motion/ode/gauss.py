"""Gauss collocation: the stages of a step, found by iteration, and the polynomial through them; the method of order 16.

    Y_i = y + h Σ_j A_ij f(t + c_j h, Y_j),    y(t + h) = y + h Σ_j b_j f(t + c_j h, Y_j),    i = 1 ... S

c are the zeros of the Legendre polynomial of degree S. The method has order 2S, is symmetric and symplectic, and
conserves every quadratic invariant. Within the step the rates are the polynomial

    f(x) = Σ_k a_k P_k(2x - 1),   a_k = (2k + 1) Σ_j b_j P_k(2c_j - 1) f_j

whose continuation predicts the stages of the next step. The stages are iterated one after the other, each with the
latest rates of the others, until the change is below the goal or is round-off. The rounding error of the sum y + h a_0
is kept and added to the next sum (compensated summation), so that the round-off of many steps does not accumulate.

The method has eight stages, for tolerances down to round-off. They are iterated to a thousandth of the tolerance, so
that the error of a long run is that of its steps and not of its number of operations. If the coefficients a_k of a step
fall geometrically, its error falls as the square of the last coefficient:

    ε = A (L / A)^(2S/(S - 1)),   A = h max_k,i |a_k,i| / s_i,   L = h max_i (|a_7,i|, |a_6,i| / 10) / s_i

with the tolerances s_i = a_i + r_i |y_i|. The dense output is the polynomial itself, of order 8.

Source: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration (2006), sections II.1.3, IV.2, VIII.6.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.polynomial import legendre

from ...native.instructions import Compiled, Parts, Reals, Truth, compiled, greater
from .method import Method
from .run import Collocation, Run
from .step_control import Functions

# Bound by a method: number of stages and tables; the change, in units of the tolerance, at which the iteration may
# stop; the maximum number of iterations; and the change, relative to the state, that may be round-off.
S = 0
A: Any = np.zeros((0, 0))
C: Any = np.zeros(0)
T: Any = np.zeros((0, 0))
GOAL, MOST, FLOOR = 0.0, 0, 0.0

part = Parts()


def tables(s: int) -> dict[str, Any]:
    """Return S, A, C and T (rows a_k from the rates f_j) of ``s`` stages."""
    x, b = legendre.leggauss(s)
    for _ in range(2):  # numpy's zeros are accurate only to a few units in the last place
        x = x - legendre.legval(x, [0] * s + [1]) / legendre.legval(x, legendre.legder([0] * s + [1]))
    b = b / 2
    P = legendre.legvander(x, s)
    T = np.array([(2 * k + 1) * b * P[:, k] for k in range(s)])
    return {"S": s, "A": integrals(x, s) @ T, "C": (x + 1) / 2, "T": T}


def bound_to(s: int, goal: float, most: int, floor: float = 1e-12) -> dict[str, Compiled]:
    """Return the functions of this module for ``s`` stages."""
    return part.bound({**globals(), **tables(s), "GOAL": goal, "MOST": most, "FLOOR": floor})


def integrals(x: Any, s: int) -> Any:
    """Return ∫_0^c P_k(2c' - 1) dc' for k < s, x = 2c - 1: (P_{k+1} - P_{k-1}) / (4k + 2), and c for k = 0."""
    P = legendre.legvander(x, s)
    rows = [(np.asarray(x) + 1) / 2, *((P[..., k + 1] - P[..., k - 1]) / (4 * k + 2) for k in range(1, s))]
    return np.stack(rows, axis=-1)


@part
def forget(own: Collocation, h: float) -> None:
    """Begin without a step before: the best guess is the rates f in the row new."""
    for i in range(own.n):
        for k in range(S):
            own.before[k, i] = 0.0
        own.before[0, i] = own.new[i]
        own.carry[i] = 0.0
    own.length_before = h
    own.continues = 0


@part
def guess(own: Collocation, h: float) -> None:
    """Predict the rates of the stages from the polynomial of the step before, or of a shorter one from the same
    start.
    """
    ratio = h / own.length_before
    origin = 1.0 if own.continues != 0 else -1.0
    for j in range(S):
        x = origin + 2.0 * ratio * C[j]
        f = own.stages[j]
        for i in range(own.n):
            f[i] = own.before[0, i]
        p0, p1 = 1.0, x
        for k in range(1, S):
            a = own.before[k]
            for i in range(own.n):
                f[i] += p1 * a[i]
            p0, p1 = p1, ((2.0 * k + 1.0) * x * p1 - k * p0) / (k + 1.0)


@part
def collocate(run: Run, own: Collocation, h: float) -> int:
    """Take a step of length ``h`` from z to z_new; return 0, or 1 if it does not converge.

    The coefficients of the rates stay in the memory of the method. There are tolerances for the first components, as
    many as the run has; the others have the tolerance of the last of these.
    """
    guess(own, h)
    n, t = own.n, run.t
    last = math.inf
    done = 0
    for turn in range(MOST):
        change, small = 0.0, 0.0
        for j in range(S):
            for i in range(n):
                total = 0.0
                for m in range(S):
                    total += A[j, m] * own.stages[m, i]
                own.argument[i] = own.z[i] + h * total
            own.f(t + C[j] * h, own.argument, own.c, own.new)
            for i in range(n):
                d = abs(h * (own.new[i] - own.stages[j, i]))
                if not math.isfinite(d):
                    if turn > 0:
                        return 1
                    for m in range(n):
                        own.z_new[m] = math.nan if not math.isfinite(own.new[m]) else 0.0
                    return 0
                size = abs(own.z[i])
                k = i if i < run.n else run.n - 1
                change = greater(change, d / (run.absolute[k] + run.relative[k] * size))
                small = greater(small, d / (1.0 + size))
                own.stages[j, i] = own.new[i]
        run.evaluated += S
        if change <= GOAL or small == 0.0 or (turn >= 2 and change >= last and small <= FLOOR):
            done = 1
            break
        if turn >= 5 and change > 2.0 * last:
            return 1
        last = change
    if done == 0:
        return 1
    complete(own, h)
    return 0


@part
def complete(own: Collocation, h: float) -> None:
    """Set z_new and the coefficients of the rates, from the rates at the stages."""
    n = own.n
    for k in range(S):
        for i in range(n):
            total = 0.0
            for m in range(S):
                total += T[k, m] * own.stages[m, i]
            own.series[k, i] = total
    for i in range(n):
        d = h * own.series[0, i] + own.carry[i]
        new = own.z[i] + d
        own.rounding[i] = d - (new - own.z[i])
        own.z_new[i] = new
    own.length = h


@part
def step_from(run: Run, own: Collocation, h: float) -> int:
    """Call `collocate`. If it fails without a step before, predict the stages by a series of shorter steps, each a
    little longer than the last.
    """
    failed = collocate(run, own, h)
    if failed == 0 or own.continues != 0:
        return failed
    for i in range(own.n):  # begin again with the rates at the start as the guess
        for k in range(1, S):
            own.before[k, i] = 0.0
    own.f(run.t, own.z, own.c, own.before[0])
    for k in range(17):
        shorter = h * (0.125 + 0.875 * k / 16.0)
        if collocate(run, own, shorter) != 0:
            return 1
        for i in range(own.n):
            for m in range(S):
                own.before[m, i] = own.series[m, i]
        own.length_before = shorter
    return 0


@part
def hold_step(own: Collocation) -> None:
    """Save the results of the whole step while parts of it are tried."""
    for i in range(own.v):
        for k in range(S):
            own.saved[k, i] = own.series[k, i]
        own.saved_rounding[i] = own.rounding[i]
    own.saved_length = own.length


@part
def pass_step(own: Collocation) -> None:
    """Make the saved step the previous step."""
    for i in range(own.v):
        for k in range(S):
            own.before[k, i] = own.saved[k, i]
        own.carry[i] = own.saved_rounding[i]
    own.length_before = own.saved_length
    own.continues = 1


@part
def along(own: Collocation, x: float, target: Reals) -> None:
    """Evaluate the polynomial of the saved step at its fraction ``x``: z + h Σ a_k ∫ P_k."""
    h = own.saved_length
    z = 2.0 * x - 1.0
    for i in range(own.v):
        target[i] = own.z[i] + h * x * own.saved[0, i]
    p0, p1 = 1.0, z
    for k in range(1, S):
        p2 = ((2.0 * k + 1.0) * z * p1 - k * p0) / (k + 1.0)
        weight = h * (p2 - p0) / (4.0 * k + 2.0)
        a = own.saved[k]
        for i in range(own.v):
            target[i] += weight * a[i]
        p0, p1 = p1, p2


# -- the method of order 16 ----------------------------------------------------------------------------

STAGES = 8
_bound = bound_to(STAGES, goal=1e-3, most=25)
_forget, _step_from, _hold, _pass, _along = (
    _bound[name] for name in ("forget", "step_from", "hold_step", "pass_step", "along")
)


@compiled
def prepare(run: Run, fresh: Truth) -> None:
    """Take the rates at the start as a guess for those of the stages, since there is no step before."""
    own = Collocation(run.own)
    for i in range(run.n):
        own.new[i] = run.k[0, i]
    _forget(own, 1.0)


@compiled
def attempt(run: Run, h: float) -> int:
    """Take one step of length ``h`` from y to y_new."""
    return _step_from(run, Collocation(run.own), h)


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
    _along(Collocation(run.own), x, run.point)


@compiled
def hold(run: Run) -> None:
    """Save the coefficients while parts of the step are tried."""
    _hold(Collocation(run.own))


@compiled
def accept(run: Run, good: Truth) -> None:
    """Make the step the previous step."""
    _pass(Collocation(run.own))


METHOD = Method(
    name="gauss", order=2 * STAGES, attempt=attempt, judge=judge, interpolate=interpolate, prepare=prepare, hold=hold,
    accept=accept, alpha=1.0 / (2 * STAGES), safety=0.85, smallest=0.2, greatest=2.5,
)  # fmt: skip
FUNCTIONS = Functions(METHOD)
