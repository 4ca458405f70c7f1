"""Contact problems of a time step on which Gauss-Seidel sweeps are slow: Newton's method on the same conditions.

Of normal rows, their tangents and bilateral rows with r = A x + b, the conditions are the zeros of

    bilateral r;    normal x - max(0, x - r/s);    tangents T - P(T - r/s),    P: the nearest point of |T| <= μ x_N

with s the row's own A. They are smooth between contact and none, stick and slip, so that Newton's method, with the
least change where impulses are not determined, is quadratic once it knows the modes.

Source: P. Alart, A. Curnier, Comput. Methods Appl. Mech. Engrg. 92 (1991) 353-375.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .path import Array


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
