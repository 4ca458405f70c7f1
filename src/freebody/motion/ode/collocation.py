"""Gauss collocation: the stages of a step, found by iteration, and the polynomial through them.

    Y_i = y + h Σ_j A_ij f(t + c_j h, Y_j),    y(t + h) = y + h Σ_j b_j f(t + c_j h, Y_j),    i = 1 ... S

c are the zeros of the Legendre polynomial of degree S. The method has order 2S, is symmetric and symplectic, and
conserves every quadratic invariant. Within the step the rates are the polynomial

    f(x) = Σ_k a_k P_k(2x - 1),   a_k = (2k + 1) Σ_j b_j P_k(2c_j - 1) f_j

whose continuation predicts the stages of the next step. The stages are iterated one after the other, each with the
latest rates of the others, until the change is below the goal or is round-off. The rounding error of the sum y + h a_0
is kept and added to the next sum (compensated summation), so that the round-off of many steps does not accumulate.

Source: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration (2006), sections II.1.3, IV.2, VIII.6.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.polynomial import legendre

from ...native.instructions import Compiled, Integers, Parts, Reals, call, greater
from .layout import EVALUATED

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


# Rows of the method's own block, each of width v: rates of the stages; coefficients of this step, of the last one, of
# the saved one; an argument; new rates; rounding errors of the sum in the last step, in this one and in the saved one.
# F = 0 ... S - 1, COEFFICIENTS = S, BEFORE = 2S, HELD = 3S, then:
ARGUMENT_, NEW_, LOST, LOSES, HOLDS, LENGTHS = 0, 1, 2, 3, 4, 5
ORIGIN = 3
"""Index in row LENGTHS, after the lengths of the step before, of this one and of the saved one: 1 if there is a step
before."""


@part
def forget(work: Reals, block: int, v: int, n: int, h: float) -> None:
    """Begin without a step before: the best guess is the rates f in row NEW_."""
    for i in range(n):
        for k in range(S):
            work[block + (2 * S + k) * v + i] = 0.0
        work[block + 2 * S * v + i] = work[block + (4 * S + NEW_) * v + i]
        work[block + (4 * S + LOST) * v + i] = 0.0
    work[block + (4 * S + LENGTHS) * v] = h
    work[block + (4 * S + LENGTHS) * v + ORIGIN] = 0.0


@part
def guess(work: Reals, block: int, v: int, n: int, h: float) -> None:
    """Predict the rates of the stages from the polynomial of the step before, or of a shorter one from the same
    start.
    """
    ratio = h / work[block + (4 * S + LENGTHS) * v]
    origin = 1.0 if work[block + (4 * S + LENGTHS) * v + ORIGIN] != 0.0 else -1.0
    for j in range(S):
        x = origin + 2.0 * ratio * C[j]
        f = block + j * v
        for i in range(n):
            work[f + i] = work[block + 2 * S * v + i]
        p0, p1 = 1.0, x
        for k in range(1, S):
            a = block + (2 * S + k) * v
            for i in range(n):
                work[f + i] += p1 * work[a + i]
            p0, p1 = p1, ((2.0 * k + 1.0) * x * p1 - k * p0) / (k + 1.0)


@part
def collocate(
    rates: int, t: float, h: float, work: Reals, start: int, end: int, block: int, v: int, n: int, c: Reals,
    relative: Reals, absolute: Reals, components: int, integers: Integers,
) -> int:  # fmt: skip
    """Take a step of length ``h`` from the state at ``work[start]`` to ``work[end]``; return 0, or 1 if it does not
    converge.

    The coefficients of the rates stay in the block of the method. There are tolerances for the first ``components``
    components; the others have the tolerance of the last of these.
    """
    guess(work, block, v, n, h)
    argument, new = block + (4 * S + ARGUMENT_) * v, block + (4 * S + NEW_) * v
    last = math.inf
    done = 0
    for turn in range(MOST):
        change, small = 0.0, 0.0
        for j in range(S):
            for i in range(n):
                total = 0.0
                for m in range(S):
                    total += A[j, m] * work[block + m * v + i]
                work[argument + i] = work[start + i] + h * total
            call(rates, t + C[j] * h, work, argument, c, work, new)
            for i in range(n):
                d = abs(h * (work[new + i] - work[block + j * v + i]))
                if not math.isfinite(d):
                    if turn > 0:
                        return 1
                    for m in range(n):
                        work[end + m] = math.nan if not math.isfinite(work[new + m]) else 0.0
                    return 0
                size = abs(work[start + i])
                k = i if i < components else components - 1
                change = greater(change, d / (absolute[k] + relative[k] * size))
                small = greater(small, d / (1.0 + size))
                work[block + j * v + i] = work[new + i]
        integers[EVALUATED] += S
        if change <= GOAL or small == 0.0 or (turn >= 2 and change >= last and small <= FLOOR):
            done = 1
            break
        if turn >= 5 and change > 2.0 * last:
            return 1
        last = change
    if done == 0:
        return 1
    for k in range(S):
        a = block + (S + k) * v
        for i in range(n):
            total = 0.0
            for m in range(S):
                total += T[k, m] * work[block + m * v + i]
            work[a + i] = total
    for i in range(n):
        d = h * work[block + S * v + i] + work[block + (4 * S + LOST) * v + i]
        new_state = work[start + i] + d
        work[block + (4 * S + LOSES) * v + i] = d - (new_state - work[start + i])
        work[end + i] = new_state
    work[block + (4 * S + LENGTHS) * v + 1] = h
    return 0


@part
def step_from(
    rates: int, t: float, h: float, work: Reals, start: int, end: int, block: int, v: int, n: int, c: Reals,
    relative: Reals, absolute: Reals, components: int, integers: Integers,
) -> int:  # fmt: skip
    """Call `collocate`. If it fails without a step before, predict the stages by a series of shorter steps, each a
    little longer than the last.
    """
    failed = collocate(
        rates, t, h, work, start, end, block, v, n, c, relative, absolute, components, integers
    )
    lengths = block + (4 * S + LENGTHS) * v
    if failed == 0 or work[lengths + ORIGIN] != 0.0:
        return failed
    for i in range(n):  # begin again with the rates at the start as the guess
        for k in range(1, S):
            work[block + (2 * S + k) * v + i] = 0.0
    call(rates, t, work, start, c, work, block + 2 * S * v)
    for k in range(17):
        part = h * (0.125 + 0.875 * k / 16.0)
        if (
            collocate(
                rates, t, part, work, start, end, block, v, n, c, relative, absolute, components, integers
            )
            != 0
        ):
            return 1
        for i in range(n):
            for m in range(S):
                work[block + (2 * S + m) * v + i] = work[block + (S + m) * v + i]
        work[lengths] = part
    return 0


@part
def hold_step(work: Reals, block: int, v: int, n: int) -> None:
    """Save the results of the whole step while parts of it are tried."""
    for i in range(n):
        for k in range(S):
            work[block + (3 * S + k) * v + i] = work[block + (S + k) * v + i]
        work[block + (4 * S + HOLDS) * v + i] = work[block + (4 * S + LOSES) * v + i]
    work[block + (4 * S + LENGTHS) * v + 2] = work[block + (4 * S + LENGTHS) * v + 1]


@part
def pass_step(work: Reals, block: int, v: int, n: int) -> None:
    """Make the saved step the previous step."""
    for i in range(n):
        for k in range(S):
            work[block + (2 * S + k) * v + i] = work[block + (3 * S + k) * v + i]
        work[block + (4 * S + LOST) * v + i] = work[block + (4 * S + HOLDS) * v + i]
    work[block + (4 * S + LENGTHS) * v] = work[block + (4 * S + LENGTHS) * v + 2]
    work[block + (4 * S + LENGTHS) * v + ORIGIN] = 1.0


@part
def along(x: float, work: Reals, start: int, block: int, v: int, n: int, target: int) -> None:
    """Evaluate the polynomial of the saved step at its fraction ``x``: y + h Σ a_k ∫ P_k."""
    h = work[block + (4 * S + LENGTHS) * v + 2]
    z = 2.0 * x - 1.0
    for i in range(n):
        work[target + i] = work[start + i] + h * x * work[block + 3 * S * v + i]
    p0, p1 = 1.0, z
    for k in range(1, S):
        p2 = ((2.0 * k + 1.0) * z * p1 - k * p0) / (k + 1.0)
        weight = h * (p2 - p0) / (4.0 * k + 2.0)
        a = block + (3 * S + k) * v
        for i in range(n):
            work[target + i] += weight * work[a + i]
        p0, p1 = p1, p2
