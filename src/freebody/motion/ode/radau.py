"""The implicit Runge-Kutta method Radau IIA of order 5, for stiff machines.

    Z_i = h Σ_j a_ij f(t + c_j h, y + Z_j),   c = (4 - √6)/10, (4 + √6)/10, 1,        y(t + h) = y + Z_3

It is stiffly accurate and stable for every decaying motion (L-stable): a stiff spring with a damper needs no short
steps once its own motion has decayed. With A⁻¹ = T Λ T⁻¹ and W = T⁻¹ Z the simplified Newton iteration splits into one
real and one complex system,

    (γ/h - J) ΔW_1 = ...,   ((α + iβ)/h - J) (ΔW_2 + iΔW_3) = ...

whose matrices are factorized (LU with partial pivoting) when J or h changes. J = ∂f/∂y is exact: column k is the
derivative of f along e_k, recorded from the trace of f (`Rates.method_kernels`); of a phase of contacts it is a
difference (`phase_kernels.tangent`). It is kept while turns beyond the first take at most half of its n evaluations.

The error estimate is (γ/h - J)⁻¹ (f(y) + Σ_i e_i Z_i / h), filtered once more if it would reject the step. Its order is
3, so tolerance r stands for 0.1 r^(2/3). The dense output is the collocation polynomial, of order 3.

Source: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II (1996), section IV.8.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...native.functions import unrolled
from ...native.instructions import Reals, Truth, compiled, greater, lesser
from .method import Method
from .run import Newton, Run
from .step_control import Functions

_ROOT = 6**0.5
C1, C2 = (4 - _ROOT) / 10, (4 + _ROOT) / 10
E1, E2, E3 = -(13 + 7 * _ROOT) / 3, (-13 + 7 * _ROOT) / 3, -1 / 3


def _transformed() -> tuple[float, float, float, Any, Any]:
    """Return γ, α, β, T, T⁻¹ with A⁻¹ = T [[γ, 0, 0], [0, α, -β], [0, β, α]] T⁻¹."""
    c = np.array([C1, C2, 1.0])
    powers = np.vander(c, 3, increasing=True)
    A = (c[:, None] ** np.arange(1, 4) / np.arange(1, 4)) @ np.linalg.inv(powers)
    values, vectors = np.linalg.eig(np.linalg.inv(A))
    real = int(np.argmin(abs(values.imag)))
    pair = int(np.argmin(values.imag))  # α - iβ
    T = np.stack([vectors[:, real].real, vectors[:, pair].real, vectors[:, pair].imag], axis=1)
    return float(values[real].real), float(values[pair].real), -float(values[pair].imag), T, np.linalg.inv(T)


GAMMA, ALPHA, BETA_, _T, _TI = _transformed()
T00, T01, T02, T10, T11, T12, T20, T21, T22 = (float(x) for x in _T.flat)
I00, I01, I02, I10, I11, I12, I20, I21, I22 = (float(x) for x in _TI.flat)

NODES = (C1, C2, 1.0)
GREATEST = 2.0
"""Greatest quotient of a step and the one before: farther on the polynomial of that step is a bad guess of the stages,
from which the iteration does not converge where friction turns."""
KAPPA = 1e-2
"""The iteration ends when its remaining error is below this fraction of the tolerance."""
TURNS, TURNS_OF_KNOWN = 10, 1000
"""Limits on the turns of the iteration: of a step that may be shortened, and of one that is part of a known step, where
the change may grow in between."""


@compiled
def prepare(run: Run, fresh: Truth) -> None:
    """Clear what is carried from step to step: there is no step before."""
    own = Newton(run.own)
    own.length_before = own.length = own.saved_length = own.factored = 0.0
    own.fresh = own.good = 0


@compiled
def expect(run: Run, length: float) -> None:
    """Let `guess` take the parabola from y to ``end`` with the rates there, as if a step backwards came before.

    The rates at y may belong to a motion that has decayed at the end.
    """
    own = Newton(run.own)
    own.length_before = -length
    for s in unrolled(3):
        x = 1.0 - NODES[s]
        for i in range(run.n):
            change = run.end[i] - run.y[i]
            own.before[s, i] = (x - 1.0) * (change + x * (length * run.k[12, i] - change))


@compiled
def derivative(run: Run, own: Newton, y: Reals) -> None:
    """Compute J at a state by columns."""
    n, pair = run.n, own.pair
    for i in range(n):
        pair[i] = y[i]
        pair[n + i] = 0.0
    for k in range(n):
        pair[n + k] = 1.0
        own.derivative(run.t, pair, own.c, own.J[k])
        pair[n + k] = 0.0
    run.evaluated += n


@compiled
def factorize(own: Newton, n: int, h: float) -> None:
    """Compute γ/h - J and (α + iβ)/h - J and their LU factors, by rows. Zero pivots give numbers that are not
    finite.
    """
    for i in range(n):
        for j in range(n):
            value = -own.J[j, i]
            own.real[i, j] = value
            own.re[i, j] = value
            own.im[i, j] = 0.0
        own.real[i, i] += GAMMA / h
        own.re[i, i] += ALPHA / h
        own.im[i, i] = BETA_ / h
    factorize_real(own, n)
    factorize_complex(own, n)


@compiled
def factorize_real(own: Newton, n: int) -> None:
    """Replace γ/h - J by its LU factors."""
    R = own.real
    for k in range(n):
        p, largest = k, abs(R[k, k])
        for i in range(k + 1, n):
            size = abs(R[i, k])
            if size > largest:
                p, largest = i, size
        own.pivots[k] = p
        if p != k:
            for j in range(n):
                R[k, j], R[p, j] = R[p, j], R[k, j]
        inverse = 1.0 / R[k, k]
        for i in range(k + 1, n):
            factor = R[i, k] * inverse
            R[i, k] = factor
            if factor != 0.0:
                for j in range(k + 1, n):
                    R[i, j] -= factor * R[k, j]


@compiled
def factorize_complex(own: Newton, n: int) -> None:
    """Replace (α + iβ)/h - J by its LU factors."""
    X, Y = own.re, own.im
    for k in range(n):
        p, largest = k, abs(X[k, k]) + abs(Y[k, k])
        for i in range(k + 1, n):
            size = abs(X[i, k]) + abs(Y[i, k])
            if size > largest:
                p, largest = i, size
        own.complex_pivots[k] = p
        if p != k:
            for j in range(n):
                X[k, j], X[p, j] = X[p, j], X[k, j]
                Y[k, j], Y[p, j] = Y[p, j], Y[k, j]
        x, y = X[k, k], Y[k, k]
        square = x * x + y * y
        x, y = x / square, -y / square
        for i in range(k + 1, n):
            a, b = X[i, k], Y[i, k]
            if a != 0.0 or b != 0.0:
                a, b = a * x - b * y, a * y + b * x
                X[i, k] = a
                Y[i, k] = b
                for j in range(k + 1, n):
                    d, e = X[k, j], Y[k, j]
                    X[i, j] -= a * d - b * e
                    Y[i, j] -= a * e + b * d


@compiled
def solve_real(own: Newton, n: int, b: Reals) -> None:
    """Solve (γ/h - J) x = b in place."""
    R = own.real
    for k in range(n):
        p = own.pivots[k]
        b[k], b[p] = b[p], b[k]
    for i in range(n):
        value = b[i]
        for k in range(i):
            value -= R[i, k] * b[k]
        b[i] = value
    for i in range(n - 1, -1, -1):
        value = b[i]
        for k in range(i + 1, n):
            value -= R[i, k] * b[k]
        b[i] = value / R[i, i]


@compiled
def solve_complex(own: Newton, n: int, b: Reals, d: Reals) -> None:
    """Solve ((α + iβ)/h - J) x = b + id in place."""
    X, Y = own.re, own.im
    for k in range(n):
        row = own.complex_pivots[k]
        b[k], b[row] = b[row], b[k]
        d[k], d[row] = d[row], d[k]
    for i in range(n):
        x, y = b[i], d[i]
        for k in range(i):
            p, q = X[i, k], Y[i, k]
            x -= p * b[k] - q * d[k]
            y -= p * d[k] + q * b[k]
        b[i] = x
        d[i] = y
    for i in range(n - 1, -1, -1):
        x, y = b[i], d[i]
        for k in range(i + 1, n):
            p, q = X[i, k], Y[i, k]
            x -= p * b[k] - q * d[k]
            y -= p * d[k] + q * b[k]
        p, q = X[i, i], Y[i, i]
        square = p * p + q * q
        b[i] = (x * p + y * q) / square
        d[i] = (y * p - x * q) / square


@compiled
def first(x: float) -> float:
    """Return the polynomial of degree 3 that is 1 at c_1 and 0 at 0, c_2 and 1."""
    return x * (x - C2) * (x - 1.0) / (C1 * (C1 - C2) * (C1 - 1.0))


@compiled
def second(x: float) -> float:
    """Return the polynomial of degree 3 that is 1 at c_2 and 0 at 0, c_1 and 1."""
    return x * (x - C1) * (x - 1.0) / (C2 * (C2 - C1) * (C2 - 1.0))


@compiled
def third(x: float) -> float:
    """Return the polynomial of degree 3 that is 1 at 1 and 0 at 0, c_1 and c_2."""
    return x * (x - C1) * (x - C2) / ((1.0 - C1) * (1.0 - C2))


@compiled
def guess(run: Run, own: Newton, h: float) -> None:
    """Predict Z by continuing the polynomial of the step before, and W = T⁻¹ Z."""
    last, z = own.length_before, own.z
    for s in unrolled(3):
        if last == 0.0:
            for i in range(run.n):
                z[s, i] = 0.0
        else:
            x = 1.0 + NODES[s] * h / last
            a, b, d = first(x), second(x), third(x) - 1.0
            for i in range(run.n):
                z[s, i] = a * own.before[0, i] + b * own.before[1, i] + d * own.before[2, i]
    for i in range(run.n):
        a, b, d = z[0, i], z[1, i], z[2, i]
        own.w[0, i] = I00 * a + I01 * b + I02 * d
        own.w[1, i] = I10 * a + I11 * b + I12 * d
        own.w[2, i] = I20 * a + I21 * b + I22 * d


@compiled
def newton(run: Run, own: Newton, h: float) -> int:
    """Iterate Z. Return 0 if it converged, 1 if not, 2 if f is not finite."""
    n, z, w, f, sides = run.n, own.z, own.w, own.f, own.sides
    guess(run, own, h)
    last = 0.0
    rate = 1.0
    for turn in range(TURNS if own.length_before >= 0.0 else TURNS_OF_KNOWN):
        own.turns = turn + 1
        for s in unrolled(3):
            for i in range(n):
                run.argument[i] = run.y[i] + z[s, i]
            run.rates(run.t + NODES[s] * h, run.argument, run.c, f[s])
            for i in range(n):
                if not math.isfinite(f[s, i]):
                    run.blame = i
                    return 2
        run.evaluated += 3
        for i in range(n):
            a, b, d = f[0, i], f[1, i], f[2, i]
            u, v = w[1, i], w[2, i]
            sides[0, i] = I00 * a + I01 * b + I02 * d - GAMMA / h * w[0, i]
            sides[1, i] = I10 * a + I11 * b + I12 * d - (ALPHA * u - BETA_ * v) / h
            sides[2, i] = I20 * a + I21 * b + I22 * d - (BETA_ * u + ALPHA * v) / h
        solve_real(own, n, sides[0])
        solve_complex(own, n, sides[1], sides[2])
        size, round_off = 0.0, 0.0
        for i in range(n):
            a, b, d = sides[0, i], sides[1, i], sides[2, i]
            x, y, v = (
                T00 * a + T01 * b + T02 * d, T10 * a + T11 * b + T12 * d, T20 * a + T21 * b + T22 * d,
            )  # fmt: skip
            w[0, i] += a
            w[1, i] += b
            w[2, i] += d
            z[0, i] += x
            z[1, i] += y
            z[2, i] += v
            change = greater(abs(x), greater(abs(y), abs(v)))
            if not math.isfinite(change):
                run.blame = i
                return 1
            old = abs(run.y[i])
            ratio = change / (run.absolute[i] + run.relative[i] * old)
            if ratio > size:
                size = ratio
                run.blame = i
            round_off = greater(round_off, change / (1.0 + old))
        if turn > 0:
            rate = size / last if last > 0.0 else 0.0
        if size == 0.0 or round_off <= 1e-16:
            return 0
        if turn > 0 and rate >= 0.99 and (round_off <= 1e-13 or size <= KAPPA):
            return 0
        if turn > 0 and rate >= 0.99 and own.length_before >= 0.0:
            return 1
        if turn > 0 and rate < 1.0 and rate / (1.0 - rate) * size <= KAPPA:
            return 0
        last = size
    return 1


@compiled
def weight(relative: float) -> float:
    """Return the weight of the estimate, whose order is two below that of the method: tolerance r stands for 0.1
    r^(2/3) (Hairer).
    """
    return lesser(1.0, 10.0 * relative ** (1.0 / 3.0))


@compiled
def attempt(run: Run, h: float) -> int:
    """Take one step of length ``h`` from y to y_new, with its error."""
    own, n = Newton(run.own), run.n
    failed, known = 1, own.length_before < 0.0
    for turn in range(2):
        if own.fresh == 0 and (turn > 0 or own.good == 0):
            derivative(run, own, run.y)
            own.fresh = 1
            own.factored = 0.0
        elif turn > 0:  # of a known step, where the motion may decay faster at the end
            derivative(run, own, run.end)
            own.factored = 0.0
        if own.factored != h:
            factorize(own, n, h)
            own.factored = h
        failed = newton(run, own, h)
        if failed == 0 or (own.fresh != 0 and not known):
            if turn > 0 and known:
                own.fresh = 0
            break
    if failed == 2:
        for i in range(n):
            run.y_new[i] = math.nan if i == run.blame else 0.0
        return 0
    if failed != 0:
        return 1
    own.length = h
    estimate, error = own.sides[0], run.error5
    for i in range(n):
        a, b, d = own.z[0, i], own.z[1, i], own.z[2, i]
        run.y_new[i] = run.y[i] + d
        estimate[i] = (E1 * a + E2 * b + E3 * d) / h
        error[i] = estimate[i] + run.k[0, i]
    solve_real(own, n, error)
    if largest_error(run) >= 1.0:
        for i in range(n):
            run.argument[i] = run.y[i] + error[i]
        run.rates(run.t, run.argument, run.c, error)
        run.evaluated += 1
        for i in range(n):
            error[i] += estimate[i]
        solve_real(own, n, error)
    return 0


@compiled
def largest_error(run: Run) -> float:
    """Return the largest error of the step in units of the tolerance; an error that is nan does not count."""
    error = 0.0
    for i in range(run.n):
        scale = run.absolute[i] + run.relative[i] * greater(abs(run.y[i]), abs(run.y_new[i]))
        error = greater(error, weight(run.relative[i]) * abs(run.error5[i]) / scale)
    return error


@compiled
def judge(run: Run, h: float) -> float:
    """Return the error ε of the step in units of the tolerance, nan if it is not finite."""
    error = 0.0
    for i in range(run.n):
        new, old = abs(run.y_new[i]), abs(run.y[i])
        scale = run.absolute[i] + run.relative[i] * greater(new, old)
        ratio = weight(run.relative[i]) * abs(run.error5[i]) / scale
        if not (math.isfinite(new) and math.isfinite(ratio)):
            return math.nan
        if ratio > error:
            error = ratio
            run.blame = i
    return error


@compiled
def interpolate(run: Run, x: float) -> None:
    """Set the row point: the collocation polynomial at the fraction ``x`` (0 to 1) of the step."""
    saved = Newton(run.own).saved
    a, b, d = first(x), second(x), third(x)
    for i in range(run.width):
        run.point[i] = run.y[i] + a * saved[0, i] + b * saved[1, i] + d * saved[2, i]


@compiled
def hold(run: Run) -> None:
    """Save the stages while parts of the step are tried."""
    own = Newton(run.own)
    for s in unrolled(3):
        own.saved[s][:] = own.z[s]
    own.saved_length = own.length


@compiled
def accept(run: Run, good: Truth) -> None:
    """Make the step the previous step. J is kept unless turns of the iteration take longer."""
    own = Newton(run.own)
    for s in unrolled(3):
        own.before[s][:] = own.saved[s]
    own.length_before = own.saved_length
    own.fresh = 0
    own.good = 1 if 6 * (own.turns - 1) <= run.n else 0  # a turn takes three evaluations


METHOD = Method(
    name="radau", order=5, attempt=attempt, judge=judge, interpolate=interpolate, prepare=prepare, expect=expect,
    hold=hold, accept=accept, alpha=0.25, smallest=0.125, greatest=GREATEST,
)  # fmt: skip
FUNCTIONS = Functions(METHOD)
