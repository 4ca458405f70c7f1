"""Newton's method for the contact problems of a time step on which Gauss-Seidel sweeps are slow.

With r = A x + b, the conditions of bilateral rows, normal rows and their tangents are the zeros of

    bilateral r;    normal x - max(0, x - r/s);    tangents T - P(T - r/s),    P: the nearest point of |T| <= μ x_N

where s is the row's diagonal element of A. These functions are smooth except where a contact changes between open and
closed or between stick and slip. Newton's method therefore converges quadratically once the modes are right
(`polished`). Where the impulses are not determined, it takes the smallest change.

If many corners of one face share few degrees of freedom, these slopes are singular and the modes are not known
approximately. The contacts are then made compliant first (`eased`): with A = H Hᵀ, v = Hᵀ x and impulses that follow
from the speeds r = H v + b,

    x_N = max(0, y_N - r_N/ε),    x_T = P(y_T - r_T/ε),    F(v) = v - Hᵀ x(H v + b) = 0

has a regular slope I + Hᵀ G H. It has as many unknowns as there are degrees of freedom, whatever the number of
contacts. ε is first lowered from the size of A, with y = 0. Then y follows x (the method of multipliers), which removes
the effect of the compliance: the result satisfies the exact laws.

If the corners of a face cannot all stick because that would stretch the face between them, forces along the face arise
that accelerate nothing. They grow by the same amount in each round, so they are extended in one step to the point where
the first corner slips. The iteration starts from zero impulses. Its result is the limit of equal compliance at all
contacts, and thus always the same for the same problem.

Sources: P. Alart, A. Curnier, Comput. Methods Appl. Mech. Engrg. 92 (1991) 353-375; J. Carpentier, Q. Le Lidec,
L. Montaut, arXiv 2405.17020 (2024).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..ode.dense_output import Array
from .friction_cone import FrictionCones


def polished(
    A: Array, b: Array, kinds: Any, mu: Array, x: Array, goal: float, most: int = 60, least: Any = 0.0
) -> Array | None:
    """Return impulses near ``x`` that satisfy the conditions to ``goal``; None if none are found.

    ``kinds`` is defined in `moreau_problem.sweep`. ``least`` gives, for each row, a normal impulse that acts in any
    case: max(least, x - r/s) then replaces max(0, x - r/s).
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
    """Return the residuals of the conditions, as speeds, and their slope."""
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
                turn = limit / length * (np.eye(2) - np.outer(e, e))  # slope of the projection onto the disk
                error[two] = s * (x[two] - limit * e)
                slope[two] = s * (
                    one[two]
                    - mu[a] * (x[a - 1] > 0) * np.outer(e, one[a - 1])
                    - turn @ (one[two] - A[two] / s)
                )
    return error, slope


SOFTEST = (1.0, 0.1, 0.01, 0.001)
"""Compliances of the successive solutions, relative to the mean of the diagonal of A."""
DRIFT = 0.02
"""Relative difference of two successive changes of the multipliers, below which they are extrapolated on a line."""
SLOW, HARDEST = 0.2, 1e-9
"""Ratio of successive residuals above which the compliance is divided by 10, and its relative lower limit."""
ROUNDS, STEPS = 300, 60  # multiplier updates; Newton steps in each


def eased(A: Array, b: Array, kinds: Any, mu: Array, goal: float) -> Array | None:
    """Return impulses that satisfy the conditions to ``goal``, starting from zero; None if none are found.

    The arguments are those of `polished`, without bilateral rows.
    """
    if not (np.isfinite(A).all() and np.isfinite(b).all()):
        return None
    values, vectors = np.linalg.eigh((A + A.T) / 2)
    kept = values > 1e-13 * max(values[-1], 0.0)
    if not kept.any():
        return None
    H = vectors[:, kept] * np.sqrt(values[kept])
    cones = FrictionCones(kinds, mu)
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
    A: Array, H: Array, b: Array, kinds: Any, mu: Array, cones: FrictionCones, soft: float, hardest: float, v: Array,
    goal: float,
) -> tuple[float, Array]:  # fmt: skip
    """Return the least residual and its impulses by multipliers; the compliance falls if they converge slowly."""
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


def _balanced(H: Array, b: Array, cones: FrictionCones, y: Array, soft: float, v: Array) -> Array:
    """Return v with F(v) = 0, by Newton's method with shorter steps where |F| would grow."""
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
