"""The implicit Runge-Kutta method Radau IIA of order 5, for stiff machines.

    Z_i = h Σ_j a_ij f(t + c_j h, y + Z_j),   c = (4 - √6)/10, (4 + √6)/10, 1,        y(t + h) = y + Z_3

It is stiffly accurate and stable for every decaying motion (L-stable): a stiff spring with a damper needs no short
steps once its own motion has decayed. With A⁻¹ = T Λ T⁻¹ and W = T⁻¹ Z the simplified Newton iteration splits into one
real and one complex system,

    (γ/h - J) ΔW_1 = ...,   ((α + iβ)/h - J) (ΔW_2 + iΔW_3) = ...

whose matrices are factorized (LU with partial pivoting) when J or h changes. J = ∂f/∂y is exact: column k is the
derivative of f along e_k, recorded from the trace of f (`Rates.method_kernels`). It is evaluated again unless the last
step converged at once.

The error estimate is (γ/h - J)⁻¹ (f(y) + Σ_i e_i Z_i / h), filtered once more if it would reject the step. Its order is
3, so tolerance r stands for 0.1 r^(2/3). The dense output is the collocation polynomial, of order 3.

Source: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II (1996), section IV.8.

The file is longer than others: it is one method, from its iteration to its dense output.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...native.instructions import Integers, Reals, call, compiled, greater, lesser, shifted, whole
from . import step_control
from .layout import ARGUMENT, BLAME, CONSTANTS, ERROR5, EVALUATED, KERNELS, POINT, RAW, ROWS, STATE

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

# Rows of the method, from ROWS on: Z of this step, of the saved one and of the one before; W; F; right-hand sides; the
# state and a direction (two rows); pivots of both factorizations; carried numbers; then J by columns, and the factors.
Z, HELD, BEFORE, W, F, ONE, TWO, THREE, PAIR, PIVOTS, PIVOTS_C, CARRIED, MATRICES = (
    0, 3, 6, 9, 12, 15, 16, 17, 18, 20, 21, 22, 24
)  # fmt: skip
# Indices of the carried numbers: length of the step before (0: none), of this one, of the saved one, of the
# factorization (0: none); 1 if J is that of the start; rate of convergence; 1 if the last step converged at once.
LAST_STEP, THIS_STEP, HELD_STEP, FACTORED, FRESH, RATE, GOOD = 0, 1, 2, 3, 4, 5, 6

KAPPA = 1e-2
"""The iteration ends when its remaining error is below this fraction of the tolerance."""


@compiled
def prepare(
    rates: int, t: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int, integers: Integers
) -> None:  # fmt: skip
    """Clear the carried numbers: there is no step before."""
    carried = (ROWS + CARRIED) * w
    for k in range(GOOD + 1):
        work[carried + k] = 0.0


@compiled
def derivative(
    t: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int, integers: Integers
) -> None:
    """Compute J at STATE, with column k in row k of the matrices."""
    pair, matrix = (ROWS + PAIR) * w, (ROWS + MATRICES) * w
    kernel = quaternions[nq + KERNELS]
    constants = shifted(c, quaternions[nq + CONSTANTS])
    for i in range(n):
        work[pair + i] = work[STATE * w + i]
        work[pair + n + i] = 0.0
    for k in range(n):
        work[pair + n + k] = 1.0
        call(kernel, t, work, pair, constants, work, matrix + k * w)
        work[pair + n + k] = 0.0
    integers[EVALUATED] += n


@compiled
def factorize(h: float, work: Reals, w: int, n: int) -> None:
    """Compute γ/h - J and (α + iβ)/h - J and their LU factors, by rows. Zero pivots give numbers that are not
    finite.
    """
    J = (ROWS + MATRICES) * w
    R, X, Y = J + n * w, J + 2 * n * w, J + 3 * n * w
    for i in range(n):
        for j in range(n):
            value = -work[J + j * w + i]
            work[R + i * w + j] = value
            work[X + i * w + j] = value
            work[Y + i * w + j] = 0.0
        work[R + i * w + i] += GAMMA / h
        work[X + i * w + i] += ALPHA / h
        work[Y + i * w + i] = BETA_ / h
    factorize_real(work, w, n)
    factorize_complex(work, w, n)


@compiled
def factorize_real(work: Reals, w: int, n: int) -> None:
    """Replace γ/h - J by its LU factors."""
    R, pivots = (ROWS + MATRICES + n) * w, (ROWS + PIVOTS) * w
    for k in range(n):
        p, largest = k, abs(work[R + k * w + k])
        for i in range(k + 1, n):
            size = abs(work[R + i * w + k])
            if size > largest:
                p, largest = i, size
        work[pivots + k] = p
        if p != k:
            for j in range(n):
                a = work[R + k * w + j]
                work[R + k * w + j] = work[R + p * w + j]
                work[R + p * w + j] = a
        inverse = 1.0 / work[R + k * w + k]
        for i in range(k + 1, n):
            factor = work[R + i * w + k] * inverse
            work[R + i * w + k] = factor
            if factor != 0.0:
                for j in range(k + 1, n):
                    work[R + i * w + j] -= factor * work[R + k * w + j]


@compiled
def factorize_complex(work: Reals, w: int, n: int) -> None:
    """Replace (α + iβ)/h - J by its LU factors."""
    X, Y, pivots = (ROWS + MATRICES + 2 * n) * w, (ROWS + MATRICES + 3 * n) * w, (ROWS + PIVOTS_C) * w
    for k in range(n):
        p, largest = k, abs(work[X + k * w + k]) + abs(work[Y + k * w + k])
        for i in range(k + 1, n):
            size = abs(work[X + i * w + k]) + abs(work[Y + i * w + k])
            if size > largest:
                p, largest = i, size
        work[pivots + k] = p
        if p != k:
            for j in range(n):
                a, b = work[X + k * w + j], work[Y + k * w + j]
                work[X + k * w + j] = work[X + p * w + j]
                work[Y + k * w + j] = work[Y + p * w + j]
                work[X + p * w + j] = a
                work[Y + p * w + j] = b
        x, y = work[X + k * w + k], work[Y + k * w + k]
        square = x * x + y * y
        x, y = x / square, -y / square
        for i in range(k + 1, n):
            a, b = work[X + i * w + k], work[Y + i * w + k]
            if a != 0.0 or b != 0.0:
                a, b = a * x - b * y, a * y + b * x
                work[X + i * w + k] = a
                work[Y + i * w + k] = b
                for j in range(k + 1, n):
                    d, e = work[X + k * w + j], work[Y + k * w + j]
                    work[X + i * w + j] -= a * d - b * e
                    work[Y + i * w + j] -= a * e + b * d


@compiled
def solve_real(work: Reals, w: int, n: int, b: int) -> None:
    """Solve (γ/h - J) x = b in place."""
    R, pivots = (ROWS + MATRICES + n) * w, (ROWS + PIVOTS) * w
    for k in range(n):
        p = whole(work[pivots + k])
        value = work[b + p]
        work[b + p] = work[b + k]
        work[b + k] = value
    for i in range(n):
        value = work[b + i]
        for k in range(i):
            value -= work[R + i * w + k] * work[b + k]
        work[b + i] = value
    for i in range(n - 1, -1, -1):
        value = work[b + i]
        for k in range(i + 1, n):
            value -= work[R + i * w + k] * work[b + k]
        work[b + i] = value / work[R + i * w + i]


@compiled
def solve_complex(work: Reals, w: int, n: int, b: int, d: int) -> None:
    """Solve ((α + iβ)/h - J) x = b + id in place."""
    X, Y, pivots = (ROWS + MATRICES + 2 * n) * w, (ROWS + MATRICES + 3 * n) * w, (ROWS + PIVOTS_C) * w
    for k in range(n):
        row = whole(work[pivots + k])
        x, y = work[b + row], work[d + row]
        work[b + row] = work[b + k]
        work[d + row] = work[d + k]
        work[b + k] = x
        work[d + k] = y
    for i in range(n):
        x, y = work[b + i], work[d + i]
        for k in range(i):
            p, q = work[X + i * w + k], work[Y + i * w + k]
            x -= p * work[b + k] - q * work[d + k]
            y -= p * work[d + k] + q * work[b + k]
        work[b + i] = x
        work[d + i] = y
    for i in range(n - 1, -1, -1):
        x, y = work[b + i], work[d + i]
        for k in range(i + 1, n):
            p, q = work[X + i * w + k], work[Y + i * w + k]
            x -= p * work[b + k] - q * work[d + k]
            y -= p * work[d + k] + q * work[b + k]
        p, q = work[X + i * w + i], work[Y + i * w + i]
        square = p * p + q * q
        work[b + i] = (x * p + y * q) / square
        work[d + i] = (y * p - x * q) / square


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
def guess(h: float, work: Reals, w: int, n: int) -> None:
    """Predict Z by continuing the polynomial of the step before, and W = T⁻¹ Z."""
    block = ROWS * w
    last = work[block + CARRIED * w + LAST_STEP]
    for s in range(3):
        if last == 0.0:
            for i in range(n):
                work[block + (Z + s) * w + i] = 0.0
        else:
            node = C1 if s == 0 else (C2 if s == 1 else 1.0)
            x = 1.0 + node * h / last
            a, b, d = first(x), second(x), third(x) - 1.0
            for i in range(n):
                at = block + BEFORE * w + i
                work[block + (Z + s) * w + i] = a * work[at] + b * work[at + w] + d * work[at + 2 * w]
    for i in range(n):
        at = block + Z * w + i
        a, b, d = work[at], work[at + w], work[at + 2 * w]
        work[block + W * w + i] = I00 * a + I01 * b + I02 * d
        work[block + (W + 1) * w + i] = I10 * a + I11 * b + I12 * d
        work[block + (W + 2) * w + i] = I20 * a + I21 * b + I22 * d


@compiled
def newton(
    rates: int, t: float, h: float, work: Reals, w: int, n: int, c: Reals, relative: Reals, absolute: Reals,
    integers: Integers,
) -> int:  # fmt: skip
    """Iterate Z. Return 0 if it converged, 1 if not, 2 if f is not finite."""
    block = ROWS * w
    carried = block + CARRIED * w
    guess(h, work, w, n)
    last = 0.0
    rate = 1.0
    for turn in range(10):
        for s in range(3):
            node = C1 if s == 0 else (C2 if s == 1 else 1.0)
            for i in range(n):
                work[ARGUMENT * w + i] = work[STATE * w + i] + work[block + (Z + s) * w + i]
            call(rates, t + node * h, work, ARGUMENT * w, c, work, block + (F + s) * w)
            for i in range(n):
                if not math.isfinite(work[block + (F + s) * w + i]):
                    integers[BLAME] = i
                    return 2
        integers[EVALUATED] += 3
        for i in range(n):
            f, g = block + F * w + i, block + W * w + i
            a, b, d = work[f], work[f + w], work[f + 2 * w]
            u, v = work[g + w], work[g + 2 * w]
            work[block + ONE * w + i] = I00 * a + I01 * b + I02 * d - GAMMA / h * work[g]
            work[block + TWO * w + i] = I10 * a + I11 * b + I12 * d - (ALPHA * u - BETA_ * v) / h
            work[block + THREE * w + i] = I20 * a + I21 * b + I22 * d - (BETA_ * u + ALPHA * v) / h
        solve_real(work, w, n, block + ONE * w)
        solve_complex(work, w, n, block + TWO * w, block + THREE * w)
        size, round_off = 0.0, 0.0
        for i in range(n):
            g, z = block + W * w + i, block + Z * w + i
            a, b, d = work[block + ONE * w + i], work[block + TWO * w + i], work[block + THREE * w + i]
            x, y, v = (
                T00 * a + T01 * b + T02 * d, T10 * a + T11 * b + T12 * d, T20 * a + T21 * b + T22 * d,
            )  # fmt: skip
            work[g] += a
            work[g + w] += b
            work[g + 2 * w] += d
            work[z] += x
            work[z + w] += y
            work[z + 2 * w] += v
            change = greater(abs(x), greater(abs(y), abs(v)))
            if not math.isfinite(change):
                integers[BLAME] = i
                return 1
            old = abs(work[STATE * w + i])
            ratio = change / (absolute[i] + relative[i] * old)
            if ratio > size:
                size = ratio
                integers[BLAME] = i
            round_off = greater(round_off, change / (1.0 + old))
        if turn > 0:
            rate = size / last if last > 0.0 else 0.0
            if rate >= 0.99 and round_off > 1e-13:
                return 1
        work[carried + RATE] = rate
        if size == 0.0 or round_off <= 1e-16 or (turn > 0 and rate >= 0.99):
            return 0
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
def attempt(
    rates: int, t: float, h: float, work: Reals, w: int, n: int, c: Reals, quaternions: Integers, nq: int,
    relative: Reals, absolute: Reals, integers: Integers,
) -> int:  # fmt: skip
    """Take one step of length ``h`` from STATE to RAW, and store its error in ERROR5."""
    block = ROWS * w
    carried = block + CARRIED * w
    failed = 1
    for turn in range(2):
        if work[carried + FRESH] == 0.0 and (turn > 0 or work[carried + GOOD] == 0.0):
            derivative(t, work, w, n, c, quaternions, nq, integers)
            work[carried + FRESH] = 1.0
            work[carried + FACTORED] = 0.0
        if work[carried + FACTORED] != h:
            factorize(h, work, w, n)
            work[carried + FACTORED] = h
        failed = newton(rates, t, h, work, w, n, c, relative, absolute, integers)
        if failed == 0 or work[carried + FRESH] != 0.0:
            break
    if failed == 2:
        for i in range(n):
            work[RAW * w + i] = math.nan if i == integers[BLAME] else 0.0
        return 0
    if failed != 0:
        work[carried + RATE] = 1.0
        return 1
    work[carried + THIS_STEP] = h
    for i in range(n):
        z = block + Z * w + i
        a, b, d = work[z], work[z + w], work[z + 2 * w]
        work[RAW * w + i] = work[STATE * w + i] + d
        work[block + ONE * w + i] = (E1 * a + E2 * b + E3 * d) / h
        work[ERROR5 * w + i] = work[block + ONE * w + i] + work[i]
    solve_real(work, w, n, ERROR5 * w)
    error = 0.0
    for i in range(n):
        scale = absolute[i] + relative[i] * greater(abs(work[STATE * w + i]), abs(work[RAW * w + i]))
        error = greater(error, weight(relative[i]) * abs(work[ERROR5 * w + i]) / scale)
    if error >= 1.0:
        for i in range(n):
            work[ARGUMENT * w + i] = work[STATE * w + i] + work[ERROR5 * w + i]
        call(rates, t, work, ARGUMENT * w, c, work, ERROR5 * w)
        integers[EVALUATED] += 1
        for i in range(n):
            work[ERROR5 * w + i] += work[block + ONE * w + i]
        solve_real(work, w, n, ERROR5 * w)
    return 0


@compiled
def judge(
    n: int, work: Reals, w: int, h: float, relative: Reals, absolute: Reals, integers: Integers
) -> float:
    """Return the error of the attempted step in units of the tolerance, nan if it is not finite."""
    error = 0.0
    for i in range(n):
        new, old = abs(work[RAW * w + i]), abs(work[STATE * w + i])
        ratio = (
            weight(relative[i]) * abs(work[ERROR5 * w + i]) / (absolute[i] + relative[i] * greater(new, old))
        )
        if not (math.isfinite(new) and math.isfinite(ratio)):
            return math.nan
        if ratio > error:
            error = ratio
            integers[BLAME] = i
    return error


@compiled
def interpolate(x: float, work: Reals, w: int) -> None:
    """Set row POINT: the collocation polynomial at the fraction ``x`` (0 to 1) of the step."""
    a, b, d = first(x), second(x), third(x)
    for i in range(w):
        at = (ROWS + HELD) * w + i
        work[POINT * w + i] = work[STATE * w + i] + a * work[at] + b * work[at + w] + d * work[at + 2 * w]


@compiled
def hold(work: Reals, w: int, n: int) -> None:
    """Save the stages while parts of the step are tried."""
    block = ROWS * w
    for i in range(3 * w):
        work[block + HELD * w + i] = work[block + Z * w + i]
    work[block + CARRIED * w + HELD_STEP] = work[block + CARRIED * w + THIS_STEP]


@compiled
def accept(work: Reals, w: int, n: int) -> None:
    """Make the step the previous step. J is out of date unless the iteration converged at once."""
    block = ROWS * w
    carried = block + CARRIED * w
    for i in range(3 * w):
        work[block + BEFORE * w + i] = work[block + HELD * w + i]
    work[carried + LAST_STEP] = work[carried + HELD_STEP]
    work[carried + FRESH] = 0.0
    work[carried + GOOD] = 1.0 if work[carried + RATE] < 1e-3 else 0.0


FUNCTIONS = step_control.Functions(
    {
        "prepare": prepare,
        "attempt": attempt,
        "judge": judge,
        "densify": step_control.nothing_to_densify,
        "interpolate": interpolate,
        "hold": hold,
        "accept": accept,
        "EXPONENT": 0.25,
        "SMALLEST": 0.125,
        "GREATEST": 8.0,
    }
)
