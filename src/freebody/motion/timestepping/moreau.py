"""The compiled time-stepping loop of Moreau and Jean: contact and friction in velocities and impulses of a step.

    q_M = q + h/2 q'(q, u),   ū = (u + u⁺)/2
    M (u⁺ - u) = h f(t + h/2, q_M, ū) + J + Wᵀ Λ + Gᵀ λ            (M, f, W, G at q_M;  J: blows in the step)
    0 <= Λ_N ⟂ v_N⁺ + e v_N⁻ >= 0,  -Λ_T in μ Λ_N Sgn(v_T⁺),  G u⁺ + g = 0        for contacts closed at q_M
    R⁺ = R (1 - h/2 ω̄×)⁻¹ (1 + h/2 ω̄×),   other q⁺ = q + h/2 (q'(q, u) + q'(q⁺, u⁺)),
    then corrected along M⁻¹ Wᵀ and M⁻¹ Gᵀ until gaps >= 0, φ = 0

Without contact this is of second order. For a free body with f = -ω̄ × J ω̄ the step conserves energy and angular
momentum: J (ω⁺ - ω) · ω̄ = 0, and R⁺ J ω⁺ = R J ω is (1 + h/2 ω̄×) J ω⁺ = (1 - h/2 ω̄×) J ω. The quaternion of
Cayley's turn is q + h q'(q, ω̄), normalized.

The friction cones are exact: |Λ_T| <= μ Λ_N, in space the disk itself, not a polygon (`moreau_problem`). Constraints
are eliminated (`moreau_rows`). Speeds are in block order here: entry i is speed ``order[i]`` of the model.

The impulse p = h f(ū) is the fixed point of p → p + r (h f(ū(p)) - p), where ū(p) solves the contacts. r is 1, and
less where bodies turn far in a step: with the last change Δe of e = h f - p it minimizes |e + r Δe/r_last|.

Written for `native.instructions.compiled`: pointers, no exceptions.

Sources: M. Jean, Comput. Methods Appl. Mech. Engrg. 177 (1999); V. Acary, B. Brogliato, Numerical Methods for Nonsmooth
Dynamical Systems (2008), chapters 10 and 13; M. Austin, P. S. Krishnaprasad, L.-S. Wang, J. Comput. Phys. 107 (1993)
105-117 (midpoint rule of a rigid body); J. Barzilai, J. M. Borwein, IMA J. Numer. Anal. 8 (1988) 141-148 (r).
"""

from __future__ import annotations

import math

from ...native.instructions import Integers, Reals, call, compiled, greater, lesser, root
from .moreau_problem import solve
from .moreau_rows import along, answer, back, dot, factor, held, met

CLOSED_GAP = 1e-10
DEEP = 1e-10
FAR = 1e300
CLOSINGS = 200
"""Limit on the Newton steps that remove overlap. An almost flat edge, lifted at its lowest point, dips on the other
side, three fifths as deep, so this case takes many steps."""
BALANCED, ROUNDED = 4e-16, 1e-12
"""Energy norm of h f - p, relative to that of the motion, at which the loads of a step are accepted: at once, and if
it has not halved ``IDLE`` times in a row."""
IDLE = 8
MEANS = 2000
"""Limit on the evaluations of the loads in a step."""
SHORTEST = 1e-4
"""Least r."""


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
def unbalanced(
    mean: Reals, h: float, u: Reals, L: Reals, blocks: Integers, squares: Integers, nb: int, n: int
) -> float:
    """Set e = h f - p and M⁻¹ e in ``mean``; return |e| relative to the motion, √(e·M⁻¹e / (u·M u + p·M⁻¹p))."""
    whole = 1e-300
    for i in range(n):
        mean[3 * n + i] = h * mean[2 * n + i] - mean[i]
    for k in range(nb):
        first, size = blocks[k], blocks[k + 1] - blocks[k]
        back(L, squares[k], size, mean, first, mean, 4 * n + first)
        whole += dot(mean, first, mean, 4 * n + first, size)
        back(L, squares[k], size, mean, 3 * n + first, mean, 4 * n + first)
        for j in range(size):  # Lᵀ u
            total = 0.0
            for i in range(j, size):
                total += L[squares[k] + i * size + j] * u[first + i]
            whole += total * total
    return root(dot(mean, 3 * n, mean, 4 * n, n) / whole)


@compiled
def advanced_loads(mean: Reals, r: float, first: int, n: int) -> float:
    """Add r e to p, with the r that minimizes |e + r Δe/r_last| (1 the first time); return r."""
    if first == 0:
        along_e, whole = 0.0, 0.0
        for i in range(n):
            change = mean[5 * n + i] - mean[3 * n + i]
            along_e += change * mean[6 * n + i]
            whole += change * (mean[6 * n + i] - mean[4 * n + i])
        r = 1.0 if whole == 0.0 else lesser(1.0, greater(SHORTEST, r * along_e / whole))
    for i in range(n):
        mean[5 * n + i], mean[6 * n + i] = mean[3 * n + i], mean[4 * n + i]
        mean[i] += r * mean[3 * n + i]
    return r


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
    system: int, closing: int, moving: int, loading: int, turning: int, c: Reals, n_q: int, n: int, E: int, m: int,
    constraints: int, holonomic: int, order: Integers, blocks: Integers, squares: Integers, nb: int, pieces: Integers,
    row_first: Integers, row_at: Integers, tangents: Integers, reach_of: Integers, reaches: int,
    quaternions: Integers, nq: int, mu: Reals, restitution: Reals, clock: Reals, steps: int, kick: Reals,
    y: Reals, z: Reals, out: Reals, rate: Reals, u: Reals, v: Reals, dv: Reals, L: Reals, X: Reals, K: Reals,
    S: Reals, sigma: Reals, spare: Reals, d: Reals, b: Reals, x: Reals, before: Reals, past: Reals, local: Reals,
    memory: Reals, lam: Reals, mean: Reals, first_rate: Reals, rows: Integers, kinds: Integers, coefficient: Reals,
    states: Reals,
    impulses: Reals, works: Reals, modes: Integers, report: Reals, most: int,
) -> int:  # fmt: skip
    """Advance ``y`` by ``steps`` steps; return the number done. If a step fails, ``report[4]`` holds the reason.

    Outputs of ``system``, in ``out``: M by blocks, f (n), gap (E), reaches, rates of contacts (m) and constraints,
    φ (holonomic), W over G by rows. Outputs of ``closing``: gap, reaches, φ. Outputs of ``moving``: q' (n_q), power of
    loads. Outputs of ``loading``: f (n), which depends on the speeds if ``turning`` is 1. ``mean``: rows of n numbers,
    p, p - h f(u), f(ū), e = h f(ū) - p, M⁻¹ e, and the last two before the last change of p. Row k of ``states``,
    ``impulses`` (m and constraints), ``works`` (contacts and blows; loads and constraints)
    and ``modes`` (E: 0 open, 1 stick, 2 slip, 3 slip+, 4 slip-) belongs to step k. ``clock``: time, step size,
    tolerance. ``kick``: J of the first step. ``report``: greatest residual, number of sweeps, greatest depth after a
    step, residual of the last problem, reason of failure (1 contacts, 2 mass matrix, 3 constraints, 4 overlap, 5 not
    finite, 6 loads), depth or number of rows, greatest speed of these rows, relative size of the first e of a step.
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
        call(moving, now, y, 0, c, first_rate, 0)
        for i in range(n_q):
            z[i] = y[i] + 0.5 * h * first_rate[i]
        for i in range(n):
            z[n_q + i] = y[n_q + i]
            u[i] = y[n_q + order[i]]
        _unit(z, quaternions, nq)
        call(system, now + 0.5 * h, z, 0, c, out, 0)
        _hidden(out, at_gap, at_reach, reach_of, reaches)
        if factor(out, L, blocks, squares, nb) == 0:
            report[4] = 2.0
            return done
        if held(
            out, at_W, L, squares, pieces, row_first, row_at, blocks, m, constraints, n, K, S, spare
        ) == 0:  # fmt: skip
            report[4] = 3.0
            return done
        count = closed_rows(out, at_gap, E, tangents, mu, restitution, 1, rows, kinds, coefficient)
        for a in range(count):
            before[a], x[a] = out[at_rate + rows[a]], memory[rows[a]]
        answers(
            out, at_W, X, sigma, L, squares, pieces, row_first, row_at, blocks, m, constraints, n, K, S, spare, rows,
            kinds, d, count,
        )  # fmt: skip
        for i in range(n):
            mean[i] = h * out[at_f + i] + mean[n + i]
        size, best, idle = 0.0, 0.0, 0
        share, scale, trials, changes, goal = 1.0, 1e-300, 0, 0, tolerance
        if turning == 1:
            goal = greater(tolerance, 0.1 * report[7])
        while True:
            # v: change of the speeds without contact impulses; lam: impulses of the constraints
            for i in range(n):
                spare[i] = mean[i]
                mean[n + i] = mean[i] - h * out[at_f + i]
                if done == 0:
                    spare[i] += kick[i]
            for k in range(nb):
                back(L, squares[k], blocks[k + 1] - blocks[k], spare, blocks[k], v, blocks[k])
            met(
                out,
                at_W,
                at_rate + m,
                pieces,
                row_first,
                row_at,
                blocks,
                m,
                constraints,
                n,
                K,
                S,
                spare,
                v,
                lam,
            )
            for a in range(count):
                r = rows[a]
                b[a] = before[a] + along(
                    out, at_W + row_at[r], pieces, row_first[r], row_first[r + 1], blocks, v, 0
                )
                if trials == 0:
                    # no rebound if the forces of a single step reverse it: it ends within the step
                    if kinds[a] == 1 and not -coefficient[a] * before[a] > before[a] - b[a]:
                        coefficient[a] = 0.0
                    k, total = at_W + row_at[r], 0.0
                    for p in range(row_first[r], row_first[r + 1]):
                        for i in range(blocks[pieces[p]], blocks[pieces[p] + 1]):
                            total += abs(out[k] * (u[i] + v[i]))
                            k += 1
                    scale = greater(scale, total)
                if kinds[a] == 1:
                    b[a] += coefficient[a] * before[a]
                if trials == 0:
                    scale = greater(scale, abs(b[a]))
            used = solve(
                out, at_W, X, pieces, row_first, row_at, blocks, rows, kinds, coefficient, d, b, x, count, n, dv,
                past, local, scale, goal, most, report, 3,
            )  # fmt: skip
            if used < 0:
                report[4] = 1.0
                report[5], report[6] = count, scale
                return done
            report[1] += used
            if turning == 0:
                break
            for i in range(n):
                z[n_q + order[i]] = u[i] + 0.5 * (v[i] + dv[i])
            call(loading, now + 0.5 * h, z, 0, c, mean, 2 * n)
            size = unbalanced(mean, h, u, L, blocks, squares, nb, n)
            trials += 1
            if not math.isfinite(size):
                report[4] = 5.0
                return done
            idle += 1
            if trials == 1 or size < 0.5 * best:
                best, idle = size, 0
            if trials == 1:
                report[7] = lesser(size, 0.01)
            if size <= BALANCED or (size <= ROUNDED and idle >= IDLE):
                if goal <= tolerance:
                    break
                goal = tolerance
                continue
            if trials > MEANS:
                report[4] = 6.0
                return done
            share = advanced_loads(mean, share, 1 if changes == 0 else 0, n)
            changes += 1
            goal = greater(tolerance, 0.1 * size)
        report[0] = greater(report[0], report[3])
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
        for i in range(n):
            z[n_q + order[i]] = 0.5 * (u[i] + v[i])
            if done == 0:
                lost += 0.5 * kick[i] * (u[i] + v[i])
        call(moving, now + 0.5 * h, z, 0, c, rate, 0)
        works[2 * done] = lost
        works[2 * done + 1] = h * rate[n_q] + given
        if nq > 0:
            for i in range(n_q):
                z[i] = y[i]
            call(moving, now, z, 0, c, rate, 0)
        for i in range(n_q):
            z[i] = y[i] + h * rate[i]
        for i in range(n):
            z[n_q + order[i]] = v[i]
        if nq > 0:
            _unit(z, quaternions, nq)
            call(moving, now + h, z, 0, c, rate, 0)
            k = 0
            for i in range(n_q):
                while k < nq and i >= quaternions[k] + 4:
                    k += 1
                if k == nq or i < quaternions[k]:
                    z[i] = y[i] + 0.5 * h * (first_rate[i] + rate[i])
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
            if held(
                out, at_W, L, squares, pieces, row_first, row_at, blocks, m, holonomic, n, K, S, spare
            ) == 0:  # fmt: skip
                report[4] = 3.0
                return done
            met(out, at_W, at_phi, pieces, row_first, row_at, blocks, m, holonomic, n, K, S, spare, v, lam)
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
