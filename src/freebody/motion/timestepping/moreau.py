"""The compiled time-stepping loop of Moreau and Jean: contact and friction in velocities and impulses of a step.

    q_M = q + h/2 q'(q, u)
    M (u⁺ - u) = h f(t + h/2, q_M, u) + J + Wᵀ Λ + Gᵀ λ            (M, f, W, G at q_M;  J: blows in the step)
    0 <= Λ_N ⟂ v_N⁺ + e v_N⁻ >= 0,  -Λ_T in μ Λ_N Sgn(v_T⁺),  G u⁺ + g = 0        for contacts closed at q_M
    q⁺ = q + h q'(q_M, (u + u⁺)/2),   then corrected along M⁻¹ Wᵀ and M⁻¹ Gᵀ until gaps >= 0, φ = 0

The friction cones are exact: |Λ_T| <= μ Λ_N, in space the disk itself, not a polygon (`moreau_problem`). Constraints
are eliminated (`moreau_rows`). Speeds are in block order here: entry i is speed ``order[i]`` of the model.

Written for `native.instructions.compiled`: pointers, no exceptions.

Sources: M. Jean, Comput. Methods Appl. Mech. Engrg. 177 (1999); V. Acary, B. Brogliato, Numerical Methods for Nonsmooth
Dynamical Systems (2008), chapters 10 and 13.
"""

from __future__ import annotations

import math

from ...native.instructions import Integers, Reals, call, compiled, greater, root
from .moreau_problem import solve
from .moreau_rows import along, answer, back, dot, factor, met

CLOSED_GAP = 1e-10
DEEP = 1e-10
FAR = 1e300
CLOSINGS = 200
"""Limit on the Newton steps that remove overlap. An almost flat edge, lifted at its lowest point, dips on the other
side, three fifths as deep, so this case takes many steps."""


@compiled
def _unit(y: Reals, quaternions: Integers, nq: int) -> None:
    for k in range(nq):
        i = quaternions[k]
        length = root(y[i] * y[i] + y[i + 1] * y[i + 1] + y[i + 2] * y[i + 2] + y[i + 3] * y[i + 3])
        for j in range(4):
            y[i + j] /= length


@compiled
def _hidden(out: Reals, at_gap: int, at_reach: int, reach_of: Integers, reaches: int) -> None:
    """Set the gap of a contact to ``FAR`` if its foot lies beyond the end of its side."""
    for k in range(reaches):
        if out[at_reach + k] < 0.0:
            out[at_gap + reach_of[k]] = FAR


@compiled
def closed_rows(
    out: Reals, at_gap: int, E: int, tangents: Integers, mu: Reals, restitution: Reals, friction: int,
    rows: Integers, kinds: Integers, coefficient: Reals,
) -> int:  # fmt: skip
    """Write the rows of the closed contacts and return their number; tangent rows only if ``friction`` is not 0."""
    count, row = 0, 0
    for e in range(E):
        size = 1 + tangents[e]
        if out[at_gap + e] <= CLOSED_GAP:
            for k in range(size if friction != 0 else 1):
                rows[count] = row + k
                kinds[count] = 1 if k == 0 else (2 if size == 2 else 2 + k)
                coefficient[count] = restitution[e] if k == 0 else mu[e]
                count += 1
        row += size
    return count


@compiled
def answers(
    W: Reals, at_W: int, X: Reals, sigma: Reals, L: Reals, squares: Integers, pieces: Integers,
    row_first: Integers, row_at: Integers, blocks: Integers, m: int, constraints: int, n: int, K: Reals, S: Reals,
    spare: Reals, rows: Integers, kinds: Integers, d: Reals, count: int,
) -> None:  # fmt: skip
    """Compute X, σ and the numbers ``d`` of `moreau_problem.sweep` for the first ``count`` rows."""
    for a in range(count):
        r = rows[a]
        answer(
            W, at_W + row_at[r], X, row_at[r], sigma, a * constraints, L, squares, pieces, row_first[r],
            row_first[r + 1], blocks, m, row_first, row_at, at_W, constraints, n, K, S, spare,
        )  # fmt: skip
        d[3 * a] = dot(W, at_W + row_at[r], X, row_at[r], row_at[r + 1] - row_at[r])
    for a in range(count):  # all rows of a contact cover the same blocks
        here, size = row_at[rows[a]], row_at[rows[a] + 1] - row_at[rows[a]]
        if kinds[a] == 2 or kinds[a] == 3:
            d[3 * a - 2] = dot(W, at_W + row_at[rows[a - 1]], X, here, size)
        if kinds[a] == 3:
            other = row_at[rows[a + 1]]
            d[3 * a - 1] = dot(W, at_W + row_at[rows[a - 1]], X, other, size)
            d[3 * a + 1] = dot(W, at_W + here, X, other, size)
            d[3 * a + 2] = greater(d[3 * a], d[3 * a + 3]) + abs(d[3 * a + 1])


@compiled
def settled(
    W: Reals, at_W: int, X: Reals, sigma: Reals, L: Reals, squares: Integers, pieces: Integers, row_first: Integers,
    row_at: Integers, blocks: Integers, m: int, constraints: int, n: int, K: Reals, S: Reals, spare: Reals,
    rows: Integers, kinds: Integers, coefficient: Reals, d: Reals, b: Reals, x: Reals, count: int, v: Reals,
    past: Reals, local: Reals, scale: float, tolerance: float, most: int, left: Reals, place: int,
) -> int:  # fmt: skip
    """Call `answers`, then `moreau_problem.solve`, for the first ``count`` rows; return the result of the latter."""
    answers(
        W, at_W, X, sigma, L, squares, pieces, row_first, row_at, blocks, m, constraints, n, K, S, spare, rows, kinds,
        d, count,
    )  # fmt: skip
    return solve(
        W, at_W, X, pieces, row_first, row_at, blocks, rows, kinds, coefficient, d, b, x, count, n, v, past, local,
        scale, tolerance, most, left, place,
    )  # fmt: skip


@compiled
def march(
    system: int, closing: int, moving: int, c: Reals, n_q: int, n: int, E: int, m: int, constraints: int,
    holonomic: int, order: Integers, blocks: Integers, squares: Integers, nb: int, pieces: Integers,
    row_first: Integers, row_at: Integers, tangents: Integers, reach_of: Integers, reaches: int,
    quaternions: Integers, nq: int, mu: Reals, restitution: Reals, clock: Reals, steps: int, kick: Reals,
    y: Reals, z: Reals, out: Reals, rate: Reals, u: Reals, v: Reals, dv: Reals, L: Reals, X: Reals, K: Reals,
    S: Reals, sigma: Reals, spare: Reals, d: Reals, b: Reals, x: Reals, before: Reals, past: Reals, local: Reals,
    memory: Reals, lam: Reals, rows: Integers, kinds: Integers, coefficient: Reals, states: Reals,
    impulses: Reals, works: Reals, modes: Integers, report: Reals, most: int,
) -> int:  # fmt: skip
    """Advance ``y`` by ``steps`` steps; return the number done. If a step fails, ``report[4]`` holds the reason.

    Outputs of ``system``, in ``out``: M by blocks, f (n), gap (E), reaches, rates of contacts (m) and constraints,
    φ (holonomic), W over G by rows. Outputs of ``closing``: gap, reaches, φ. Outputs of ``moving``: q' (n_q), power of
    loads. Row k of ``states``, ``impulses`` (m and constraints), ``works`` (contacts and blows; loads and constraints)
    and ``modes`` (E: 0 open, 1 stick, 2 slip, 3 slip+, 4 slip-) belongs to step k. ``clock``: time, step size,
    tolerance. ``kick``: J of the first step. ``report``: greatest residual, number of sweeps, greatest depth after a
    step, residual of the last problem, reason of failure (1 contacts, 2 mass matrix, 3 constraints, 4 overlap, 5 not
    finite), depth or number of rows, greatest speed of these rows.
    """
    t, h, tolerance = clock[0], clock[1], clock[2]
    at_f = squares[nb]
    at_gap = at_f + n
    at_reach = at_gap + E
    at_rate = at_reach + reaches
    at_phi = at_rate + m + constraints
    at_W = at_phi + holonomic
    width = m + constraints
    report[4] = 0.0
    done = 0
    while done < steps:
        now = t + done * h
        call(moving, now, y, 0, c, rate, 0)
        for i in range(n_q):
            z[i] = y[i] + 0.5 * h * rate[i]
        for i in range(n):
            z[n_q + i] = y[n_q + i]
            u[i] = y[n_q + order[i]]
        _unit(z, quaternions, nq)
        call(system, now + 0.5 * h, z, 0, c, out, 0)
        _hidden(out, at_gap, at_reach, reach_of, reaches)
        if factor(out, L, blocks, squares, nb) == 0:
            report[4] = 2.0
            return done
        # v: change of the speeds without contact impulses; lam: impulses of the constraints
        for i in range(n):
            spare[i] = h * out[at_f + i]
            if done == 0:
                spare[i] += kick[i]
        for k in range(nb):
            back(L, squares[k], blocks[k + 1] - blocks[k], spare, blocks[k], v, blocks[k])
        if met(
            out, at_W, at_rate + m, L, squares, pieces, row_first, row_at, blocks, m, constraints, n, K, S, spare, v,
            lam,
        ) == 0:  # fmt: skip
            report[4] = 3.0
            return done
        count = closed_rows(out, at_gap, E, tangents, mu, restitution, 1, rows, kinds, coefficient)
        scale = 1e-300
        for a in range(count):
            r = rows[a]
            before[a] = out[at_rate + r]
            b[a] = before[a] + along(
                out, at_W + row_at[r], pieces, row_first[r], row_first[r + 1], blocks, v, 0
            )
            # no rebound if the forces of a single step reverse it: it ends within the step
            if kinds[a] == 1 and -coefficient[a] * before[a] > before[a] - b[a]:
                b[a] += coefficient[a] * before[a]
            x[a] = memory[r]
            k, total = at_W + row_at[r], 0.0
            for p in range(row_first[r], row_first[r + 1]):
                for i in range(blocks[pieces[p]], blocks[pieces[p] + 1]):
                    total += abs(out[k] * (u[i] + v[i]))
                    k += 1
            scale = greater(scale, greater(abs(b[a]), total))
        used = settled(
            out, at_W, X, sigma, L, squares, pieces, row_first, row_at, blocks, m, constraints, n, K, S, spare, rows,
            kinds, coefficient, d, b, x, count, dv, past, local, scale, tolerance, most, report, 3,
        )  # fmt: skip
        if used < 0:
            report[4] = 1.0
            report[5], report[6] = count, scale
            return done
        report[0] = greater(report[0], report[3])
        report[1] += used
        for i in range(n):
            v[i] += u[i] + dv[i]
            if not math.isfinite(v[i]):
                report[4] = 5.0
                return done
        for r in range(m):
            memory[r] = 0.0
        lost = 0.0
        for a in range(count):
            r = rows[a]
            memory[r] = x[a]
            for i in range(constraints):
                lam[i] -= sigma[a * constraints + i] * x[a]
            b[a] = before[a]
            k = at_W + row_at[r]
            for p in range(row_first[r], row_first[r + 1]):
                for i in range(blocks[pieces[p]], blocks[pieces[p] + 1]):
                    b[a] += out[k] * (v[i] - u[i])
                    k += 1
            lost += 0.5 * x[a] * (before[a] + b[a])
        for e in range(E):
            modes[done * E + e] = 0
        e, row = 0, 0
        for a in range(count):
            r = rows[a]
            if kinds[a] == 1:
                while row < r:
                    row += 1 + tangents[e]
                    e += 1
                if x[a] > 0.0:
                    still = 100.0 * tolerance * scale
                    mode = 1
                    if tangents[e] == 1:
                        if b[a + 1] > still:
                            mode = 3
                        elif b[a + 1] < -still:
                            mode = 4
                    elif tangents[e] == 2 and b[a + 1] * b[a + 1] + b[a + 2] * b[a + 2] > still * still:
                        mode = 2
                    modes[done * E + e] = mode
        for r in range(m):
            impulses[done * width + r] = memory[r]
        given = 0.0
        for i in range(constraints):
            r = m + i
            impulses[done * width + r] = lam[i]
            k = at_W + row_at[r]
            for p in range(row_first[r], row_first[r + 1]):
                for j in range(blocks[pieces[p]], blocks[pieces[p] + 1]):
                    given += 0.5 * lam[i] * out[k] * (u[j] + v[j])
                    k += 1
        # positions advance with the mean of the old and new speeds
        for i in range(n):
            z[n_q + order[i]] = 0.5 * (u[i] + v[i])
            if done == 0:
                lost += 0.5 * kick[i] * (u[i] + v[i])
        call(moving, now + 0.5 * h, z, 0, c, rate, 0)
        works[2 * done] = lost
        works[2 * done + 1] = h * rate[n_q] + given
        for i in range(n_q):
            z[i] = y[i] + h * rate[i]
        for i in range(n):
            z[n_q + order[i]] = v[i]
        _unit(z, quaternions, nq)
        # correction to gaps >= 0 and φ = 0, the smallest in the norm of the mass matrix
        depth, error, tries = 0.0, 0.0, 0
        while tries < CLOSINGS:
            tries += 1
            call(closing, now + h, z, 0, c, out, 0)
            _hidden(out, 0, E, reach_of, reaches)
            depth = 0.0
            for e in range(E):
                depth = greater(depth, -out[e])
            error = depth
            for i in range(holonomic):
                error = greater(error, abs(out[E + reaches + i]))
            if error <= DEEP or not math.isfinite(error):
                break
            call(system, now + h, z, 0, c, out, 0)
            _hidden(out, at_gap, at_reach, reach_of, reaches)
            if factor(out, L, blocks, squares, nb) == 0:
                report[4] = 2.0
                return done
            for k in range(n):
                v[k] = 0.0
            if met(
                out, at_W, at_phi, L, squares, pieces, row_first, row_at, blocks, m, holonomic, n, K, S, spare, v, lam
            ) == 0:  # fmt: skip
                report[4] = 3.0
                return done
            count = closed_rows(out, at_gap, E, tangents, mu, restitution, 0, rows, kinds, coefficient)
            row, e, scale = 0, 0, 1e-300
            for a in range(count):
                r = rows[a]
                while row < r:
                    row += 1 + tangents[e]
                    e += 1
                x[a] = 0.0
                b[a] = out[at_gap + e] + along(
                    out, at_W + row_at[r], pieces, row_first[r], row_first[r + 1], blocks, v, 0
                )
                scale = greater(scale, abs(b[a]))
            used = settled(
                out, at_W, X, sigma, L, squares, pieces, row_first, row_at, blocks, m, holonomic, n, K, S, spare, rows,
                kinds, coefficient, d, b, x, count, dv, past, local, scale, greater(1e-9, 0.1 * DEEP / scale), most,
                report, 3,
            )  # fmt: skip
            if used < 0:
                report[4] = 4.0
                report[5] = depth
                return done
            for i in range(n):
                before[i] = z[n_q + order[i]]
                z[n_q + order[i]] = v[i] + dv[i]
            call(moving, now + h, z, 0, c, rate, 0)
            for i in range(n_q):
                z[i] += rate[i]
            for i in range(n):
                z[n_q + order[i]] = before[i]
            _unit(z, quaternions, nq)
        if not error <= DEEP:
            report[4] = 4.0 if math.isfinite(error) else 5.0
            report[5] = error
            return done
        report[2] = greater(report[2], depth)
        for i in range(n_q + n):
            y[i] = z[i]
            states[done * (n_q + n) + i] = z[i]
        done += 1
    return done
