"""Solver for the contact problem of a time step: Signorini's and Coulomb's conditions in impulses and speeds.

    r = b + W Δu,   Δu = Σ X x
    0 <= x_N ⟂ r_N >= 0,     x_T = P(x_T - r_T/s),   P: the nearest point of |T| <= μ x_N (in space the disk itself)

A Gauss-Seidel sweep x → g(x) solves one contact after another. Near the solution the modes no longer change, g is
almost linear, and conjugate residuals find its fixed point: f = g(x) - x is minimized along the last differences
(Anderson's mixing with orthogonal differences). If |f| grows, the stored differences are discarded. The result is
always the outcome of a sweep, so it lies within the cones; it is accepted when every condition holds to the tolerance.

Sources: M. Jean, Comput. Methods Appl. Mech. Engrg. 177 (1999); V. Acary, B. Brogliato, Numerical Methods for Nonsmooth
Dynamical Systems (2008), chapter 13; D. G. Anderson, J. ACM 12 (1965) 547-560.
"""

from __future__ import annotations

import math

from ...native.instructions import Integers, Reals, compiled, greater, lesser, root
from .moreau_rows import added, along, dot

PAIRS = 12
"""Number of stored differences."""
TURNS = 8
"""Alternations between normal and tangents in a slipping contact in space."""
SINGULAR = 1e-10
"""Fraction of a diagonal entry below which its remainder after elimination counts as round-off."""
ALIKE = 1e-9
"""Relative difference of two speeds that counts as round-off."""


@compiled
def _tangent(
    d: Reals, at: int, v_1: float, v_2: float, x_1: float, x_2: float, limit: float, found: Reals, place: int
) -> None:
    """Write the new friction in space: the impulse that stops the slip if it is in the cone, else P(x_T - v_T/s)."""
    d_1, both, s, d_2 = d[at], d[at + 1], d[at + 2], d[at + 3]
    det = d_1 * d_2 - both * both
    p, q = x_1 - v_1 / s, x_2 - v_2 / s
    if det > SINGULAR * d_1 * d_2:
        p, q = x_1 - (d_2 * v_1 - both * v_2) / det, x_2 - (d_1 * v_2 - both * v_1) / det
        if p * p + q * q > limit * limit:
            p, q = x_1 - v_1 / s, x_2 - v_2 / s
    length = root(p * p + q * q)
    if length > limit:
        p, q = p * limit / length, q * limit / length
    found[place], found[place + 1] = p, q


@compiled
def _held(d: Reals, at: int, size: int, r: Reals) -> int:
    """Set r[3:] = -A⁻¹ r by elimination in the order N, 1, 2; return 1 if this is a possible sticking impulse.

    Return 0 if the normal impulse is negative or the contact cannot be stopped. A speed that vanishes together with the
    speeds before it, as on a machine with one degree of freedom, needs no impulse.
    """
    d_N, c_1, d_1, r_N = d[at], d[at + 1], d[at + 3], r[0]
    l_1 = c_1 / d_N
    s_1, e_1 = d_1 - l_1 * c_1, r[1] - l_1 * r_N
    p, q, apart = 0.0, 0.0, 1
    if not s_1 > SINGULAR * d_1:
        apart = 0
        if abs(e_1) > ALIKE * (abs(r[1]) + abs(l_1 * r_N)):
            return 0
    if size == 3:
        c_2, both, d_2 = d[at + 2], d[at + 4], d[at + 6]
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
    r[3], r[4], r[5] = -r_N / d_N, p, q
    return 1 if r[3] >= 0.0 else 0


@compiled
def _local(d: Reals, at: int, size: int, mu: float, r: Reals, x: Reals, a: int) -> None:
    """Compute the impulses ``r[3:]`` of one contact from its speeds ``r`` without them, the other impulses fixed.

    Open if r_N >= 0; else stick if -A⁻¹ r is within the cone; else slip: in the plane exactly, x_T = -σ μ x_N with
    σ v_T >= 0; in space by ``TURNS`` alternations between the normal and the tangents.
    """
    d_N = d[at]
    for k in range(size):
        r[3 + k] = 0.0
    if r[0] >= 0.0 or not d_N > 0.0:
        return
    if size == 1:
        r[3] = -r[0] / d_N
        return
    c_1, d_1 = d[at + 1], d[at + 3]
    if _held(d, at, size, r) == 1 and r[4] * r[4] + r[5] * r[5] <= mu * mu * r[3] * r[3]:
        return
    r[3], r[4], r[5] = 0.0, 0.0, 0.0
    if size == 2:
        for turn in range(2):
            sign = 1.0 if (turn == 0) == (r[1] >= 0.0) else -1.0
            slope = d_N - sign * mu * c_1
            if slope > 0.0:
                p = -r[0] / slope
                if sign * (r[1] + c_1 * p - sign * mu * d_1 * p) >= 0.0:
                    r[3], r[4] = p, -sign * mu * p
                    return
        r[3] = greater(0.0, -(r[0] + c_1 * x[a + 1]) / d_N)
        limit = mu * r[3]
        if d_1 > 0.0:
            r[4] = greater(-limit, lesser(limit, -(r[1] + c_1 * r[3]) / d_1))
        return
    c_2, both, d_2 = d[at + 2], d[at + 4], d[at + 6]
    r[4], r[5] = x[a + 1], x[a + 2]
    for _ in range(TURNS):
        r[3] = greater(0.0, -(r[0] + c_1 * r[4] + c_2 * r[5]) / d_N)
        if d[at + 5] > 0.0:
            v_1 = r[1] + c_1 * r[3] + d_1 * r[4] + both * r[5]
            v_2 = r[2] + c_2 * r[3] + both * r[4] + d_2 * r[5]
            _tangent(d, at + 3, v_1, v_2, r[4], r[5], mu * r[3], r, 4)


@compiled
def sweep(
    W: Reals, at_W: int, X: Reals, pieces: Integers, row_first: Integers, row_at: Integers, blocks: Integers,
    rows: Integers, kinds: Integers, mu: Reals, d: Reals, b: Reals, x: Reals, count: int, v: Reals, local: Reals,
) -> float:  # fmt: skip
    """Do one sweep; return the greatest change of a speed.

    ``kinds`` of a row: 1 normal; 2 the only tangent; 3 and 4 the first and second of two tangents. The tangent rows of
    a contact follow its normal row; their ``mu`` is its coefficient of friction. ``d`` has three numbers for each row:
    normal A_NN, A_N1, A_N2; first tangent A_11, A_12, s; second tangent A_22. ``local``: 6 numbers.
    """
    worst = 0.0
    a = 0
    while a < count:
        size = 1
        if a + 1 < count and kinds[a + 1] != 1:
            size = 2 if kinds[a + 1] == 2 else 3
        for k in range(size):
            r = rows[a + k]
            local[k] = b[a + k] + along(
                W, at_W + row_at[r], pieces, row_first[r], row_first[r + 1], blocks, v, 0
            )
        at = 3 * a
        local[0] -= d[at] * x[a]
        if size > 1:
            local[0] -= d[at + 1] * x[a + 1]
            local[1] -= d[at + 1] * x[a] + d[at + 3] * x[a + 1]
        if size > 2:
            local[0] -= d[at + 2] * x[a + 2]
            local[1] -= d[at + 4] * x[a + 2]
            local[2] -= d[at + 2] * x[a] + d[at + 4] * x[a + 1] + d[at + 6] * x[a + 2]
        _local(d, at, size, mu[a + 1] if size > 1 else 0.0, local, x, a)
        for k in range(size):
            change, r = local[3 + k] - x[a + k], rows[a + k]
            if change != 0.0:
                worst = greater(worst, abs(change) * d[3 * (a + k)])
                added(X, row_at[r], pieces, row_first[r], row_first[r + 1], blocks, change, v)
                x[a + k] = local[3 + k]
        a += size
    return worst


@compiled
def missed(
    W: Reals, at_W: int, pieces: Integers, row_first: Integers, row_at: Integers, blocks: Integers, rows: Integers,
    kinds: Integers, mu: Reals, d: Reals, b: Reals, x: Reals, count: int, v: Reals,
) -> float:  # fmt: skip
    """Return the residual, a speed: the greatest |min(v_N, A_NN x_N)| or |x_T - P(x_T - v_T/s)| s of any contact."""
    worst, gone, first = 0.0, 0.0, 0.0
    for a in range(count):
        r = rows[a]
        speed = b[a] + along(W, at_W + row_at[r], pieces, row_first[r], row_first[r + 1], blocks, v, 0)
        if kinds[a] == 1:
            worst = greater(worst, abs(lesser(speed, d[3 * a] * x[a])))
        elif kinds[a] == 2:
            s, limit = d[3 * a], mu[a] * x[a - 1]
            worst = greater(worst, abs(s * x[a] - greater(-s * limit, lesser(s * limit, s * x[a] - speed))))
        elif kinds[a] == 3:
            first = speed
        else:
            s, limit = d[3 * a - 1], mu[a - 1] * x[a - 2]
            p, q = s * x[a - 1] - first, s * x[a] - speed
            length = root(p * p + q * q)
            gone = 1.0 if length <= s * limit else s * limit / length
            worst = greater(worst, greater(abs(s * x[a - 1] - gone * p), abs(s * x[a] - gone * q)))
    return worst


@compiled
def moved(
    X: Reals, pieces: Integers, row_first: Integers, row_at: Integers, blocks: Integers, rows: Integers, x: Reals,
    count: int, n: int, v: Reals,
) -> None:  # fmt: skip
    """Set v to Δu = Σ X x."""
    for i in range(n):
        v[i] = 0.0
    for a in range(count):
        r = rows[a]
        added(X, row_at[r], pieces, row_first[r], row_first[r + 1], blocks, x[a], v)


@compiled
def solve(
    W: Reals, at_W: int, X: Reals, pieces: Integers, row_first: Integers, row_at: Integers, blocks: Integers,
    rows: Integers, kinds: Integers, mu: Reals, d: Reals, b: Reals, x: Reals, count: int, n: int, v: Reals,
    past: Reals, local: Reals, scale: float, tolerance: float, most: int, left: Reals, place: int,
) -> int:  # fmt: skip
    """Solve for x and v, with x as the guess; return the number of sweeps, or -1 on failure.

    ``left[place]`` becomes the residual, relative to ``scale``. ``past``: 4 + 2 PAIRS rows of ``count`` numbers (x
    before the sweep, f, the last f, the last g, then differences of f and g in turn), followed by |Δf|² of each.
    """
    f, f_old, g_old, first, sizes = count, 2 * count, 3 * count, 4 * count, (4 + 2 * PAIRS) * count
    pairs, known, size_old, quiet, wait, mixed = 0, 0, 0.0, 2, 2, 0
    best, since = 0.0, 0
    moved(X, pieces, row_first, row_at, blocks, rows, x, count, n, v)
    left[place] = (
        missed(W, at_W, pieces, row_first, row_at, blocks, rows, kinds, mu, d, b, x, count, v) / scale
    )
    if left[place] <= tolerance:
        return 0
    for k in range(most):
        for a in range(count):
            past[a] = x[a]
        worst = sweep(
            W, at_W, X, pieces, row_first, row_at, blocks, rows, kinds, mu, d, b, x, count, v, local
        )
        left[place] = worst / scale
        if not math.isfinite(worst):
            return -1
        if worst <= tolerance * scale:
            moved(X, pieces, row_first, row_at, blocks, rows, x, count, n, v)
            worst = missed(W, at_W, pieces, row_first, row_at, blocks, rows, kinds, mu, d, b, x, count, v)
            left[place] = worst / scale
            if worst <= tolerance * scale:
                return k + 1
            known, pairs, mixed = 0, 0, 0
            continue
        for a in range(count):
            past[f + a] = root(greater(d[3 * a], 0.0)) * (x[a] - past[a])
        size = dot(past, f, past, f, count)
        if k == 0 or size < 0.25 * best:
            best, since = size, k
        if mixed > 0 and (
            size >= size_old or k - since > 2 * PAIRS
        ):  # return to the last sweep; continue without mixing for some sweeps
            for a in range(count):
                x[a] = past[g_old + a]
            moved(X, pieces, row_first, row_at, blocks, rows, x, count, n, v)
            pairs, known, mixed, quiet, wait = 0, 0, 0, k + wait, 2 * wait
            best, since = size_old, k + wait
            continue
        if known > 0 and k >= quiet:
            slot = pairs % PAIRS
            q = first + 2 * slot * count
            p = q + count
            for a in range(count):
                past[q + a], past[p + a] = past[f + a] - past[f_old + a], x[a] - past[g_old + a]
            whole = dot(past, q, past, q, count)
            for j in range(pairs - PAIRS + 1 if pairs >= PAIRS else 0, pairs):
                o = first + 2 * (j % PAIRS) * count
                share = dot(past, q, past, o, count) / past[sizes + j % PAIRS]
                for a in range(count):
                    past[q + a] -= share * past[o + a]
                    past[p + a] -= share * past[o + count + a]
            norm = dot(past, q, past, q, count)
            if norm > 1e-20 * whole and norm > 0.0:
                past[sizes + slot] = norm
                pairs += 1
        for a in range(count):
            past[f_old + a], past[g_old + a] = past[f + a], x[a]
        known, size_old, mixed = 1, size, 0
        if pairs > 0 and k >= quiet:
            mixed = 1
            for j in range(pairs - PAIRS if pairs > PAIRS else 0, pairs):
                o = first + 2 * (j % PAIRS) * count
                share = dot(past, f, past, o, count) / past[sizes + j % PAIRS]
                for a in range(count):
                    x[a] -= share * past[o + count + a]
            moved(X, pieces, row_first, row_at, blocks, rows, x, count, n, v)
    return -1
