"""Gauss-Seidel sweeps over the contacts of a problem, with Anderson's mixing.

    x → g(x):  for each contact in turn, the impulses that satisfy its laws while the others are fixed

Near the solution the modes no longer change, g is almost linear, and conjugate residuals find its fixed point:
f = g(x) - x is minimized along the last differences (Anderson's mixing with orthogonal differences). If |f| grows, the
stored differences are discarded. The result is always the outcome of a sweep, so it lies within the cones; it is
accepted when every law holds to the tolerance (`cone.residual`).

The rows are normal or tangent ones, with W M Wᵀ = A symmetric, and normal impulses act from zero on, or from ``low``
where there is no friction.

Sources: M. Jean, Comput. Methods Appl. Mech. Engrg. 177 (1999); V. Acary, B. Brogliato, Numerical Methods for Nonsmooth
Dynamical Systems (2008), chapter 13; D. G. Anderson, J. ACM 12 (1965) 547-560.
"""

from __future__ import annotations

import math

from ...native.instructions import compiled, greater, hot, root
from .block_rows import add, add_three, along_three, dot
from .cone import add_all, bound, clipped, nearest, rate, residual
from .contact_problem import LINE, NORMAL, PAIRS, ContactProblem, Sweeping

SINGULAR = 1e-10
"""Fraction of a diagonal entry below which its remainder after elimination counts as round-off."""
ALIKE = 1e-9
"""Relative difference of two speeds that counts as round-off."""
NEW = 1e-20
"""Part of |Δf|² below which a difference depends on those before it."""


@hot
@compiled
def solve(problem: ContactProblem, memory: Sweeping, tolerance: float, most: int) -> int:
    """Solve for x and v, with x as the guess; return the number of sweeps, or -1 on failure."""
    count, x = problem.count, problem.x
    known, size_old, wait, mixed = 0, 0.0, 2, 0
    quiet = 0 if memory.pairs > 0 else wait
    best, since = 0.0, 0
    add_all(problem)
    problem.residual = residual(problem)
    if problem.residual <= tolerance:
        return 0
    for k in range(most):
        for a in range(count):
            memory.before[a] = x[a]
        problem.residual = sweep(problem, memory) / problem.reference
        if problem.stop != 0 or not math.isfinite(problem.residual):
            return -1
        if problem.residual <= tolerance:
            add_all(problem)
            problem.residual = residual(problem)
            if problem.residual <= tolerance:
                return k + 1
            known, memory.pairs, mixed = 0, 0, 0
            continue
        for a in range(count):
            memory.f[a] = root(greater(problem.matrix[a, 0], 0.0)) * (x[a] - memory.before[a])
        size = dot(memory.f, memory.f, count)
        if k == 0 or size < 0.25 * best:
            best, since = size, k
        if mixed > 0 and (size >= size_old or k - since > 2 * PAIRS):
            # return to the last sweep; continue without mixing for some sweeps
            for a in range(count):
                x[a] = memory.g_old[a]
            add_all(problem)
            memory.pairs, known, mixed, quiet, wait = 0, 0, 0, k + wait, 2 * wait
            best, since = size_old, k + wait
            continue
        if known > 0 and k >= quiet:
            remember(problem, memory)
        for a in range(count):
            memory.f_old[a], memory.g_old[a] = memory.f[a], x[a]
        known, size_old, mixed = 1, size, 0
        if memory.pairs > 0 and k >= quiet:
            mixed = 1
            mix(problem, memory)
    return -1


# -- one sweep -----------------------------------------------------------------------------------------


@hot
@compiled
def sweep(problem: ContactProblem, memory: Sweeping) -> float:
    """Do one sweep; return the greatest change of a speed."""
    worst, x, A, speeds = 0.0, problem.x, problem.matrix, memory.speeds
    a = 0
    while a < problem.count:
        if problem.kinds[a] > NORMAL:
            worst = greater(worst, resist(problem, a))
            a += 1 if problem.kinds[a] == LINE else 2
            continue
        size = 1
        if a + 1 < problem.count and problem.kinds[a + 1] != NORMAL and problem.between[a + 1] == 0:
            size = 2 if problem.kinds[a + 1] == LINE else 3
        speeds[0] = rate(problem, a)
        if size == 1 and problem.low[a] != 0.0:  # it may pull, too, or takes back a pull
            pull = greater(problem.low[a], x[a] - speeds[0] / A[a, 0]) if A[a, 0] > 0.0 else 0.0
            worst = greater(worst, moved(problem, a, pull))
            a += 1
            continue
        if x[a] == 0.0 and speeds[0] >= 0.0:  # open, and it remains so: friction is zero there
            a += size
            continue
        if size == 2:
            speeds[1] = rate(problem, a + 1)
        elif size == 3:
            along_three(problem.blocks, problem.rows[a], problem.W, problem.v, speeds)
            for k in range(3):
                speeds[k] += problem.b[a + k]
        speeds[0] -= A[a, 0] * x[a]
        if size > 1:
            speeds[0] -= A[a, 1] * x[a + 1]
            speeds[1] -= A[a, 1] * x[a] + A[a + 1, 0] * x[a + 1]
        if size > 2:
            speeds[0] -= A[a, 2] * x[a + 2]
            speeds[1] -= A[a + 1, 1] * x[a + 2]
            speeds[2] -= A[a, 2] * x[a] + A[a + 1, 1] * x[a + 1] + A[a + 2, 0] * x[a + 2]
        press(problem, a, size, memory)
        for k in range(size):
            speeds[k] = memory.impulses[k] - x[a + k]
            worst = greater(worst, abs(speeds[k]) * A[a + k, 0])
            x[a + k] = memory.impulses[k]
        if size == 3:
            add_three(problem.blocks, problem.rows[a], problem.X, speeds, problem.v)
        else:
            for k in range(size):
                add(problem.blocks, problem.rows[a + k], problem.X, speeds[k], problem.v)
        a += size
    return worst


@compiled
def resist(problem: ContactProblem, a: int) -> float:
    """Set the impulses of what resists rolling or spinning, the others fixed; return the greatest change of a rate."""
    A, x, worst = problem.matrix, problem.x, 0.0
    limit = problem.mu[a] * greater(x[bound(problem, a)], 0.0)
    if not problem.scale[a] > 0.0:
        return 0.0
    if problem.kinds[a] == LINE:
        p = clipped(x[a] - rate(problem, a) / A[a, 0], limit)
        worst = moved(problem, a, p)
    else:
        v, w, d, both, e = rate(problem, a), rate(problem, a + 1), A[a, 0], A[a, 1], A[a + 1, 0]
        s, det = problem.scale[a], d * e - both * both
        p, q = nearest(x[a] - v / s, x[a + 1] - w / s, limit)
        if det > SINGULAR * d * e:
            p_0, q_0 = x[a] - (e * v - both * w) / det, x[a + 1] - (d * w - both * v) / det
            if p_0 * p_0 + q_0 * q_0 <= limit * limit:
                p, q = p_0, q_0
        worst = moved(problem, a, p)
        worst = greater(worst, moved(problem, a + 1, q))
    return worst


@compiled
def moved(problem: ContactProblem, a: int, impulse: float) -> float:
    """Set the impulse of a row; return the change of its rate."""
    change = impulse - problem.x[a]
    if change != 0.0:
        add(problem.blocks, problem.rows[a], problem.X, change, problem.v)
        problem.x[a] = impulse
    return abs(change) * problem.matrix[a, 0]


@hot
@compiled
def press(problem: ContactProblem, a: int, size: int, memory: Sweeping) -> None:
    """Compute the impulses of the contact at row ``a`` from its speeds without them, the other impulses fixed.

    Open if r_N >= 0; else stick if -A⁻¹ r is within the cone; else slip: in the plane exactly, x_T = -σ μ x_N with
    σ v_T >= 0; in space by the normal impulse first, then the tangents.
    """
    A, r, x = problem.matrix, memory.speeds, memory.impulses
    for k in range(size):
        x[k] = 0.0
    if r[0] >= 0.0 or not A[a, 0] > 0.0:
        return
    if size == 1:
        x[0] = -r[0] / A[a, 0]
        return
    mu = problem.mu[a + 1]
    if stick(problem, a, size, memory) == 1 and x[1] * x[1] + x[2] * x[2] <= mu * mu * x[0] * x[0]:
        return
    x[0], x[1], x[2] = 0.0, 0.0, 0.0
    if size == 2:
        slip_in_plane(problem, a, memory)
    else:
        slip_in_space(problem, a, memory)


@hot
@compiled
def stick(problem: ContactProblem, a: int, size: int, memory: Sweeping) -> int:
    """Set x = -A⁻¹ r by elimination in the order N, 1, 2; return 1 if this is a possible sticking impulse.

    Return 0 if the normal impulse is negative or the contact cannot be stopped. A speed that vanishes together with the
    speeds before it, as on a machine with one degree of freedom, needs no impulse.
    """
    A, r = problem.matrix, memory.speeds
    d_N, c_1, d_1, r_N = A[a, 0], A[a, 1], A[a + 1, 0], r[0]
    l_1 = c_1 / d_N
    s_1, e_1 = d_1 - l_1 * c_1, r[1] - l_1 * r_N
    p, q, apart = 0.0, 0.0, 1
    if not s_1 > SINGULAR * d_1:
        apart = 0
        if abs(e_1) > ALIKE * (abs(r[1]) + abs(l_1 * r_N)):
            return 0
    if size == 3:
        c_2, both, d_2 = A[a, 2], A[a + 1, 1], A[a + 2, 0]
        l_2 = c_2 / d_N
        s_2, s_12, e_2 = d_2 - l_2 * c_2, both - l_1 * c_2, r[2] - l_2 * r_N
        whole = abs(r[2]) + abs(l_2 * r_N)
        if apart == 1:
            l_2 = s_12 / s_1
            s_2, e_2 = s_2 - l_2 * s_12, e_2 - l_2 * e_1
        if s_2 > SINGULAR * d_2:
            q = -e_2 / s_2
        elif abs(e_2) > ALIKE * whole:
            return 0
        r_N += c_2 * q
        e_1 += s_12 * q
    if apart == 1:
        p = -e_1 / s_1
        r_N += c_1 * p
    x = memory.impulses
    x[0], x[1], x[2] = -r_N / d_N, p, q
    return 1 if x[0] >= 0.0 else 0


@compiled
def slip_in_plane(problem: ContactProblem, a: int, memory: Sweeping) -> None:
    """Set the impulses of a contact that slips in its plane, x_T = -σ μ x_N with σ v_T >= 0.

    Where friction jams both slips, alternate between normal and tangent.
    """
    A, r, x, mu = problem.matrix, memory.speeds, memory.impulses, problem.mu[a + 1]
    d_N, c_1, d_1 = A[a, 0], A[a, 1], A[a + 1, 0]
    for turn in range(2):
        sign = 1.0 if (turn == 0) == (r[1] >= 0.0) else -1.0
        slope = d_N - sign * mu * c_1
        if slope > 0.0:
            p = -r[0] / slope
            if sign * (r[1] + c_1 * p - sign * mu * d_1 * p) >= 0.0:
                x[0], x[1] = p, -sign * mu * p
                return
    x[0] = greater(0.0, -(r[0] + c_1 * problem.x[a + 1]) / d_N)
    if d_1 > 0.0:
        x[1] = clipped(-(r[1] + c_1 * x[0]) / d_1, mu * x[0])


@hot
@compiled
def slip_in_space(problem: ContactProblem, a: int, memory: Sweeping) -> None:
    """Set the impulses of a contact that slips in space: the normal one beside the tangents, then those beside it.

    The tangents have the impulse that stops the slip if it is in the cone, else x_T = P(x_T - r_T/s).
    """
    A, r, x, s = problem.matrix, memory.speeds, memory.impulses, problem.scale[a + 1]
    d_N, c_1, c_2 = A[a, 0], A[a, 1], A[a, 2]
    d_1, both, d_2 = A[a + 1, 0], A[a + 1, 1], A[a + 2, 0]
    det = d_1 * d_2 - both * both
    x[1], x[2] = problem.x[a + 1], problem.x[a + 2]
    x[0] = greater(0.0, -(r[0] + c_1 * x[1] + c_2 * x[2]) / d_N)
    if s > 0.0:
        limit = problem.mu[a + 1] * x[0]
        v_1 = r[1] + c_1 * x[0] + d_1 * x[1] + both * x[2]
        v_2 = r[2] + c_2 * x[0] + both * x[1] + d_2 * x[2]
        p, q = x[1] - v_1 / s, x[2] - v_2 / s
        if det > SINGULAR * d_1 * d_2:
            p_0, q_0 = x[1] - (d_2 * v_1 - both * v_2) / det, x[2] - (d_1 * v_2 - both * v_1) / det
            if p_0 * p_0 + q_0 * q_0 <= limit * limit:
                p, q = p_0, q_0
        x[1], x[2] = nearest(p, q, limit)


# -- Anderson's mixing ---------------------------------------------------------------------------------


@hot
@compiled
def remember(problem: ContactProblem, memory: Sweeping) -> None:
    """Store the last differences of f and g, Δf orthogonal to those stored, unless it depends on them."""
    pairs, count = memory.pairs, problem.count
    slot = pairs % PAIRS
    df, dg = memory.df[slot], memory.dg[slot]
    for a in range(count):
        df[a], dg[a] = memory.f[a] - memory.f_old[a], problem.x[a] - memory.g_old[a]
    whole = dot(df, df, count)
    for j in range(pairs - PAIRS + 1 if pairs >= PAIRS else 0, pairs):
        k = j % PAIRS
        share = dot(df, memory.df[k], count) / memory.norms[k]
        for a in range(count):
            df[a] -= share * memory.df[k, a]
            dg[a] -= share * memory.dg[k, a]
    norm = dot(df, df, count)
    if norm > NEW * whole and norm > 0.0:
        memory.norms[slot] = norm
        memory.pairs += 1


@hot
@compiled
def mix(problem: ContactProblem, memory: Sweeping) -> None:
    """Replace x by the combination of the last differences of g in which |f| is least."""
    for j in range(memory.pairs - PAIRS if memory.pairs > PAIRS else 0, memory.pairs):
        k = j % PAIRS
        share = dot(memory.f, memory.df[k], problem.count) / memory.norms[k]
        for a in range(problem.count):
            problem.x[a] -= share * memory.dg[k, a]
    add_all(problem)
