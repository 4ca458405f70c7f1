"""Contact problems of a time step on which Gauss-Seidel sweeps are slow: Newton's method on the same conditions.

Of normal rows, their tangents and bilateral rows with r = A x + b, the conditions are the zeros of

    bilateral r;    normal x - max(0, x - r/s);    tangents T - P(T - r/s),    P: the nearest point of |T| <= μ x_N

with s the row's own A. They are smooth between contact and none, stick and slip, so that Newton's method, with the
least change where impulses are not determined, is quadratic once it knows the modes (`polished`).

Where many corners of one face share few freedoms, these slopes are singular and the modes are not near. There the
contacts are made compliant first (`eased`): with A = H Hᵀ, v = Hᵀ x and impulses that follow from the speeds
r = H v + b,

    x_N = max(0, y_N - r_N/ε),    x_T = P(y_T - r_T/ε),    F(v) = v - Hᵀ x(H v + b) = 0

has a regular slope I + Hᵀ G H in as many unknowns as there are freedoms, whatever the number of contacts. ε falls from
the size of A, with y = 0; then y follows x (the method of multipliers), and the compliance is gone: what is solved in
the end are the exact laws. Corners that can not all stick, since that would stretch the face between them, drive forces
along the face that accelerate nothing: these grow by the same in each round, and go at once to where the first corner
slips. Begun from nothing, it is the limit of equal compliance at all contacts, and so the same for
the same problem.

Sources: P. Alart, A. Curnier, Comput. Methods Appl. Mech. Engrg. 92 (1991) 353-375; J. Carpentier, Q. Le Lidec,
L. Montaut, arXiv 2405.17020 (2024).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..ode.dense_output import Array


def polished(
    A: Array, b: Array, kinds: Any, mu: Array, x: Array, goal: float, most: int = 60, least: Any = 0.0
) -> Array | None:
    """Impulses near ``x`` that satisfy the conditions to ``goal``; None if there are none found.

    ``kinds`` as of `moreau_problem.sweep`; ``least``, of each row, are normal impulses that act in any case: of these
    rows max(least, x - r/s) takes the place of max(0, x - r/s).
    """
    least = np.broadcast_to(least, len(x))
    error, slope = _conditions(A, b, kinds, mu, x, least)
    for _ in range(most):
        size = float(np.abs(error).max(initial=0))
        if size <= goal:
            return x
        step = np.linalg.lstsq(slope, -error, rcond=1e-12)[0]
        part, length = 1.0, float(np.linalg.norm(error))
        while True:
            other = x + part * step
            new, bent = _conditions(A, b, kinds, mu, other, least)
            if float(np.linalg.norm(new)) < (1 - 1e-4 * part) * length or part < 1e-3:
                break
            part /= 2
        x, error, slope = other, new, bent
    return x if float(np.abs(error).max(initial=0)) <= goal else None


def _conditions(A: Array, b: Array, kinds: Any, mu: Array, x: Array, least: Array) -> tuple[Array, Array]:
    """What the conditions are missed by, as speeds, and their slope."""
    r = A @ x + b
    error, slope = r.copy(), A.copy()
    one = np.eye(len(x))
    for a, kind in enumerate(kinds):
        d = A[a, a]
        if kind == 1:
            if d * (x[a] - least[a]) - r[a] <= 0:
                error[a], slope[a] = d * (x[a] - least[a]), d * one[a]
        elif kind == 2:
            limit, free = mu[a] * max(x[a - 1], 0.0), x[a] - r[a] / d
            if abs(free) > limit:
                sign = np.sign(free)
                error[a] = d * (x[a] - sign * limit)
                slope[a] = d * (one[a] - sign * mu[a] * (x[a - 1] > 0) * one[a - 1])
        elif kind == 3:
            two = slice(a, a + 2)
            s = max(d, A[a + 1, a + 1]) + abs(A[a, a + 1])
            free = x[two] - r[two] / s
            length, limit = float(np.linalg.norm(free)), mu[a] * max(x[a - 1], 0.0)
            if length > limit:
                e = free / length
                turn = limit / length * (np.eye(2) - np.outer(e, e))  # of the nearest point with the point
                error[two] = s * (x[two] - limit * e)
                slope[two] = s * (
                    one[two]
                    - mu[a] * (x[a - 1] > 0) * np.outer(e, one[a - 1])
                    - turn @ (one[two] - A[two] / s)
                )
    return error, slope


SOFTEST = (1.0, 0.1, 0.01, 0.001)
"""Compliances that are gone through, in parts of the mean of the diagonal of A."""
DRIFT = 0.02
"""Change of what multipliers change by, in its parts, below which they go along a line."""
SLOW, HARDEST = 0.2, 1e-9
"""Ratio of two residuals beyond which the compliance becomes a tenth, and the least of it, in the same parts."""
ROUNDS, STEPS = 300, 60  # of multipliers; of Newton's method in each


def eased(A: Array, b: Array, kinds: Any, mu: Array, goal: float) -> Array | None:
    """Impulses that satisfy the conditions to ``goal``, from nothing; None if there are none found.

    Arguments as of `polished`, without bilateral rows.
    """
    if not (np.isfinite(A).all() and np.isfinite(b).all()):
        return None
    values, vectors = np.linalg.eigh((A + A.T) / 2)
    kept = values > 1e-13 * max(values[-1], 0.0)
    if not kept.any():
        return None
    H = vectors[:, kept] * np.sqrt(values[kept])
    cones = _Cones(kinds, mu)
    unit = float(np.mean(A.diagonal()))
    y, v = np.zeros(len(b)), np.zeros(H.shape[1])
    for part in SOFTEST:
        v = _balanced(H, b, cones, y, part * unit, v)
    best: tuple[float, Array] = np.inf, y
    for hardest in (SOFTEST[-1] * unit, HARDEST * unit):
        found = _multiplied(A, H, b, kinds, mu, cones, SOFTEST[-1] * unit, hardest, v, goal)
        if found[0] <= goal:
            return found[1]
        best = min(best, found, key=lambda one: one[0])
    return polished(A, b, kinds, mu, best[1], goal)


def _multiplied(
    A: Array, H: Array, b: Array, kinds: Any, mu: Array, cones: _Cones, soft: float, hardest: float, v: Array,
    goal: float,
) -> tuple[float, Array]:  # fmt: skip
    """What is missed least, and by which impulses: y follows x, and the compliance falls where that is slow."""
    y, last = np.zeros(len(b)), np.inf
    best: tuple[float, Array] = np.inf, y
    before, moved = y, np.zeros(len(b))
    for _ in range(ROUNDS):
        y = cones.impulses(y - (H @ v + b) / soft)
        size = float(np.abs(_conditions(A, b, kinds, mu, y, np.zeros(len(b)))[0]).max())
        if size < best[0]:
            best = size, y
        if size <= goal or not np.isfinite(size):
            break
        change = y - before
        if np.linalg.norm(change - moved) < DRIFT * np.linalg.norm(change):
            y = y + cones.reach(y, change) * change
        elif size > SLOW * last and soft > hardest:
            soft /= 10
        before, moved, last = y, change, size
        v = _balanced(H, b, cones, y, soft, v)
    return best


class _Cones:
    """The impulses that belong to y - r/ε, and their slope: the nearest within x_N >= 0 and the disk μ x_N."""

    def __init__(self, kinds: Any, mu: Array) -> None:
        kinds = np.asarray(kinds)
        self.normal = np.flatnonzero(kinds == 1)
        first = np.flatnonzero((kinds == 2) | (kinds == 3))
        self.of = first - 1  # the normal row of each contact with friction
        self.mu = np.asarray(mu, dtype=float)[first]
        # a contact with one tangent has none for its second: a row beyond the last
        self.tangents = np.stack([first, np.where(kinds[first] == 3, first + 1, len(kinds))])

    def impulses(self, free: Array) -> Array:
        x = np.zeros(len(free) + 1)
        x[self.normal] = np.maximum(free[self.normal], 0.0)
        T = np.append(free, 0.0)[self.tangents]
        limit, length = self.mu * x[self.of], np.hypot(*T)
        x[self.tangents] = T * np.where(length > limit, limit / np.where(length > 0, length, 1.0), 1.0)
        return x[:-1]

    def reach(self, x: Array, d: Array) -> float:
        """The part of a change of impulses at which the first contact comes to the end of its cone; 0 if none does.

        |T + t dT| = μ (N + t dN), N + t dN = 0
        """
        N, dN = x[self.of], d[self.of]
        T, dT = np.append(x, 0.0)[self.tangents], np.append(d, 0.0)[self.tangents]
        a = (dT * dT).sum(axis=0) - (self.mu * dN) ** 2
        h = (T * dT).sum(axis=0) - self.mu**2 * N * dN
        c = np.minimum((T * T).sum(axis=0) - (self.mu * N) ** 2, 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            root = np.sqrt(np.maximum(h * h - a * c, 0.0))
            # of a t² + 2 h t + c = 0, c <= 0, the root beside 0 in the direction of the change
            cone = np.where(h > 0, -c / (h + root), np.where(a > 0, (root - h) / a, np.inf))
            lift = np.where(d[self.normal] < 0, -x[self.normal] / d[self.normal], np.inf)
        inside = (N > 0) & (c < -1e-12 * (self.mu * N) ** 2)
        ends = np.concatenate([cone[inside], lift[x[self.normal] > 0]])
        ends = ends[np.isfinite(ends) & (ends > 0)]
        return float(ends.min()) if len(ends) else 0.0

    def slope(self, free: Array) -> Array:
        """∂x/∂(y - r/ε)."""
        n = len(free)
        D = np.zeros((n + 1, n + 1))
        pressed = free[self.normal] > 0
        D[self.normal, self.normal] = pressed
        x_N, (p, q) = np.maximum(free[self.of], 0.0), self.tangents
        T = np.append(free, 0.0)[self.tangents]
        limit, length = self.mu * x_N, np.hypot(*T)
        out = length > limit
        size = np.where(length > 0, length, 1.0)
        e, share = T / size, np.where(out, limit / size, 1.0)
        for i, row in enumerate((p, q)):
            for j, column in enumerate((p, q)):
                D[row, column] = share * ((i == j) - np.where(out, e[i] * e[j], 0.0))
            D[row, self.of] = np.where(out & (free[self.of] > 0), self.mu * e[i], 0.0)
        return D[:-1, :-1]


def _balanced(H: Array, b: Array, cones: _Cones, y: Array, soft: float, v: Array) -> Array:
    """v with F(v) = 0, by Newton's method with shorter steps where |F| would grow."""
    F = v - H.T @ cones.impulses(y - (H @ v + b) / soft)
    for _ in range(STEPS):
        size = float(np.linalg.norm(F))
        if size <= 1e-15 * (1e-300 + float(np.linalg.norm(v))):
            break
        slope = np.eye(len(v)) + H.T @ (cones.slope(y - (H @ v + b) / soft) @ H) / soft
        try:
            step = np.linalg.solve(slope, -F)
        except np.linalg.LinAlgError:
            step = np.linalg.lstsq(slope, -F, rcond=1e-12)[0]
        part = 1.0
        while True:
            other = v + part * step
            new = other - H.T @ cones.impulses(y - (H @ other + b) / soft)
            if float(np.linalg.norm(new)) < (1 - 1e-4 * part) * size:
                break
            part /= 2
            if part < 1e-6:
                return v
        v, F = other, new
    return v
