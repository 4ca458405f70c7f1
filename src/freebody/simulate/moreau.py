"""The time-stepping loop of Moreau and Jean, compiled: contact and friction as velocities and impulses of a step.

    q_M = q + h/2 q'(q, u)
    M (u⁺ - u) = h f(t + h/2, q_M, u) + Wᵀ Λ + Gᵀ λ             (M, f, W, G at q_M)
    0 <= Λ_N ⟂ v_N⁺ + e v_N⁻ >= 0,  -Λ_T in μ Λ_N Sgn(v_T⁺),  G u⁺ + g = 0        where the gap at q_M is closed
    q⁺ = q + h q'(q_M, (u + u⁺)/2),   then moved by M⁻¹ Wᵀ to gaps >= 0 and φ = 0

The friction cones are exact: |Λ_T| <= μ Λ_N, in space the disk itself. The problem is solved by Gauss-Seidel sweeps with
projection, until every contact satisfies its law to the tolerance, as a speed relative to the greatest in the problem.

Written for `machine.compiled`: pointers, no exceptions. Sources: M. Jean, Comput. Methods Appl. Mech. Engrg. 177 (1999);
V. Acary, B. Brogliato, Numerical Methods for Nonsmooth Dynamical Systems (2008), chapters 10 and 13.
"""

# ruff: noqa: E501
from __future__ import annotations

import math

from .machine import Compiled, Integers, Reals, call, compiled, greater, lesser, root

CLOSED_GAP = 1e-10
DEEP = 1e-10


@compiled
def cholesky(M: Reals, L: Reals, n: int) -> int:
    """L Lᵀ = M; 0 if M is not positive definite."""
    for i in range(n):
        for j in range(i + 1):
            total = M[i * n + j]
            for k in range(j):
                total -= L[i * n + k] * L[j * n + k]
            if i == j:
                if not total > 0.0:
                    return 0
                L[i * n + i] = root(total)
            else:
                L[i * n + j] = total / L[j * n + j]
    return 1


@compiled
def back(L: Reals, n: int, b: Reals, at: int, x: Reals, to: int) -> None:
    """x[to:] = M⁻¹ b[at:]."""
    for i in range(n):
        total = b[at + i]
        for k in range(i):
            total -= L[i * n + k] * x[to + k]
        x[to + i] = total / L[i * n + i]
    for i in range(n - 1, -1, -1):
        total = x[to + i]
        for k in range(i + 1, n):
            total -= L[k * n + i] * x[to + k]
        x[to + i] = total / L[i * n + i]


@compiled
def couple(
    W: Reals, at: int, X: Reals, A: Reals, L: Reals, rows: Integers, count: int, n: int, width: int
) -> None:
    """X = M⁻¹ Wᵀ and A = W M⁻¹ Wᵀ of the rows at hand; A has rows of length ``width``."""
    for a in range(count):
        back(L, n, W, at + rows[a] * n, X, a * n)
    for a in range(count):
        for b in range(count):
            total = 0.0
            for k in range(n):
                total += W[at + rows[a] * n + k] * X[b * n + k]
            A[a * width + b] = total


@compiled
def _row(A: Reals, x: Reals, b: Reals, a: int, count: int, width: int) -> float:
    total = b[a]
    for k in range(count):
        total += A[a * width + k] * x[k]
    return total


@compiled
def sweep(
    A: Reals, b: Reals, x: Reals, kinds: Integers, mu: Reals, count: int, width: int, tolerance: float, most: int,
    left: Reals, place: int,
) -> int:  # fmt: skip
    """Solve the problem of one step for x; the sweeps it took, or -1. ``left[place]`` becomes the residual.

    ``kinds`` of a row: 0 bilateral; 1 normal; 2 its only tangent; 3 the first of its two tangents (the second is 4).
    ``mu`` of a tangent row is the coefficient of its contact; its normal row stands just before.
    """
    scale = 1e-300
    for a in range(count):
        scale = greater(scale, abs(b[a]))
    for k in range(most):
        worst = 0.0
        a = 0
        while a < count:
            kind = kinds[a]
            d = A[a * width + a]
            if kind == 3:
                e = a + 1
                step = greater(d, A[e * width + e]) + abs(A[a * width + e])
                r, s = _row(A, x, b, a, count, width), _row(A, x, b, e, count, width)
                limit = mu[a] * x[a - 1]
                if step > 0.0:
                    p, q = x[a] - r / step, x[e] - s / step
                    length = root(p * p + q * q)
                    if length > limit:
                        p, q = p * limit / length, q * limit / length
                    worst = greater(worst, greater(abs(p - x[a]), abs(q - x[e])) * step)
                    x[a], x[e] = p, q
                a += 2
                continue
            if d > 0.0:
                new = x[a] - _row(A, x, b, a, count, width) / d
                if kind == 1:
                    new = greater(0.0, new)
                elif kind == 2:
                    limit = mu[a] * x[a - 1]
                    new = greater(-limit, lesser(limit, new))
                worst = greater(worst, abs(new - x[a]) * d)
                x[a] = new
            a += 1
        left[place] = worst / scale
        if not math.isfinite(worst):
            return -1
        if worst <= tolerance * scale:
            return k + 1
    return -1


@compiled
def _unit(y: Reals, quaternions: Integers, nq: int) -> None:
    for k in range(nq):
        i = quaternions[k]
        length = root(y[i] * y[i] + y[i + 1] * y[i + 1] + y[i + 2] * y[i + 2] + y[i + 3] * y[i + 3])
        for j in range(4):
            y[i + j] /= length


@compiled
def closed_rows(
    out: Reals, at_gap: int, E: int, m: int, held: int, tangents: Integers, mu: Reals, restitution: Reals,
    bound: float, friction: int, rows: Integers, kinds: Integers, coefficient: Reals,
) -> int:  # fmt: skip
    """The rows of a problem, and their number: all bilateral ones, then those of contacts whose gap is at most
    ``bound``, with their tangents where ``friction`` is not 0."""
    count, row = 0, 0
    for i in range(held):
        rows[count], kinds[count], coefficient[count] = m + i, 0, 0.0
        count += 1
    for e in range(E):
        size = 1 + tangents[e]
        if out[at_gap + e] <= bound:
            for k in range(size if friction != 0 else 1):
                rows[count] = row + k
                kinds[count] = 1 if k == 0 else (2 if size == 2 else 2 + k)
                coefficient[count] = restitution[e] if k == 0 else mu[e]
                count += 1
        row += size
    return count


@compiled
def march(
    kernel: int, moving: int, c: Reals, n_q: int, n: int, E: int, m: int, held: int, tangents: Integers, mu: Reals,
    restitution: Reals, quaternions: Integers, nq: int, clock: Reals, steps: int, y: Reals, z: Reals,
    out: Reals, rate: Reals, L: Reals, X: Reals, A: Reals, b: Reals, x: Reals, memory: Reals, rows: Integers,
    kinds: Integers, coefficient: Reals, v: Reals, states: Reals, impulses: Reals, works: Reals, report: Reals,
    most: int,
) -> int:  # fmt: skip
    """``steps`` steps from ``y``; the number done, less than asked where a problem was not solved.

    ``out`` of ``kernel``: M (n n), f (n), gap (E), W over G (m + held rows of n), w over g, φ (held). ``out`` of
    ``moving``: q' (n_q), power of loads. Row k of ``states``, ``impulses``, ``works`` (contacts, loads) belongs to
    the end of step k. ``clock``: time, length of a step, tolerance. ``report``: greatest residual, sweeps, greatest depth after a step, residual of the last,
    rows of the problem of speeds that was not solved.
    """
    t, h, tolerance = clock[0], clock[1], clock[2]
    at_f, at_gap, width = n * n, n * n + n, m + held
    at_W = at_gap + E
    at_w = at_W + width * n
    at_phi = at_w + width
    done = 0
    while done < steps:
        now = t + done * h
        call(moving, now, y, 0, c, rate, 0)
        for i in range(n_q):
            z[i] = y[i] + 0.5 * h * rate[i]
        for i in range(n):
            z[n_q + i] = y[n_q + i]
        _unit(z, quaternions, nq)
        call(kernel, now + 0.5 * h, z, 0, c, out, 0)
        if cholesky(out, L, n) == 0:
            return done
        back(L, n, out, at_f, v, 0)
        for i in range(n):
            v[i] = y[n_q + i] + h * v[i]
        count = closed_rows(
            out, at_gap, E, m, held, tangents, mu, restitution, CLOSED_GAP, 1, rows, kinds, coefficient
        )
        for a in range(count):
            r = rows[a]
            before, free = out[at_w + r], out[at_w + r]
            for k in range(n):
                before += out[at_W + r * n + k] * y[n_q + k]
                free += out[at_W + r * n + k] * v[k]
            b[a] = free
            if kinds[a] == 1 and before < 0.0:
                b[a] += coefficient[a] * before
            x[a] = memory[r]
            z[n_q + n + a] = before
        couple(out, at_W, X, A, L, rows, count, n, width)
        used = 0
        report[4] = count
        if count > 0:
            used = sweep(A, b, x, kinds, coefficient, count, width, tolerance, most, report, 3)
            if used < 0:
                return done
        report[0] = greater(report[0], report[3])
        report[1] += used
        for r in range(width):
            memory[r] = 0.0
        lost = 0.0
        for a in range(count):
            memory[rows[a]] = x[a]
            for k in range(n):
                v[k] += x[a] * X[a * n + k]
        for a in range(count):
            if kinds[a] != 0:
                r = rows[a]
                after = out[at_w + r]
                for k in range(n):
                    after += out[at_W + r * n + k] * v[k]
                lost += 0.5 * x[a] * (z[n_q + n + a] + after)
        for r in range(m):
            impulses[done * m + r] = memory[r]
        report[4] = 0.0
        # positions, with the mean of the speeds
        for i in range(n):
            z[n_q + i] = 0.5 * (y[n_q + i] + v[i])
        call(moving, now + 0.5 * h, z, 0, c, rate, 0)
        works[2 * done] = lost
        works[2 * done + 1] = h * rate[n_q]
        for i in range(n_q):
            y[i] += h * rate[i]
        for i in range(n):
            y[n_q + i] = v[i]
        _unit(y, quaternions, nq)
        # back to gaps >= 0 and φ = 0, with the least motion of the masses
        depth = 0.0
        for _ in range(20):
            call(kernel, now + h, y, 0, c, out, 0)
            depth = 0.0
            for e in range(E):
                depth = greater(depth, -out[at_gap + e])
            error = depth
            for i in range(held):
                error = greater(error, abs(out[at_phi + i]))
            if error <= DEEP:
                break
            count = closed_rows(
                out, at_gap, E, m, held, tangents, mu, restitution, CLOSED_GAP, 0, rows, kinds, coefficient
            )
            row = 0
            for a in range(count):
                r = rows[a]
                x[a] = 0.0
                if r >= m:
                    b[a] = out[at_phi + r - m]
                else:
                    row, e = 0, 0
                    while row < r:
                        row += 1 + tangents[e]
                        e += 1
                    b[a] = out[at_gap + e]
            if cholesky(out, L, n) == 0:
                return done
            couple(out, at_W, X, A, L, rows, count, n, width)
            if sweep(A, b, x, kinds, coefficient, count, width, tolerance, most, report, 3) < 0:
                return done
            for i in range(n_q + n):
                z[i] = y[i]
            for i in range(n):
                total = 0.0
                for a in range(count):
                    total += x[a] * X[a * n + i]
                z[n_q + i] = total
            call(moving, now + h, z, 0, c, rate, 0)
            for i in range(n_q):
                y[i] += rate[i]
            _unit(y, quaternions, nq)
        report[2] = greater(report[2], depth)
        _keep(y, states, done * (n_q + n), n_q + n)
        done += 1
    return done


@compiled
def _keep(y: Reals, states: Reals, at: int, count: int) -> None:
    for i in range(count):
        states[at + i] = y[i]


FUNCTIONS = {name: value for name, value in globals().items() if isinstance(value, Compiled)}
