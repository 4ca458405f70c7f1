"""Coulomb's cones: the nearest point P, its slope, and the residual of a contact problem.

    x_N = max(low, y_N),    x_T = P(y_T): y_T, or where |y_T| > μ x_N its direction with that length

Signorini's and Coulomb's laws are x = P(x - r/s) with any s > 0: a contact presses where r_N = 0, and friction that
reaches μ x_N points against the slip r_T. The residual is s |x - P(x - r/s)|, a rate.

Source: P. Alart, A. Curnier, Comput. Methods Appl. Mech. Engrg. 92 (1991) 353-375.
"""

from __future__ import annotations

import math

from ...native.instructions import Reals, compiled, greater, inlined, lesser, root
from .contact_problem import EQUALITY, FIRST, LINE, NORMAL, Blocks, ContactProblem


@inlined
def clipped(y: float, limit: float) -> float:
    """Return the nearest number to y of those up to ±limit."""
    return y if abs(y) <= limit else (limit if y > 0.0 else -limit)


@inlined
def nearest(y_1: float, y_2: float, limit: float) -> tuple[float, float]:
    """Return the nearest point to y of the disk |T| <= limit."""
    length = root(y_1 * y_1 + y_2 * y_2)
    outside = length > limit
    return y_1 * limit / length if outside else y_1, y_2 * limit / length if outside else y_2


@compiled
def project(problem: ContactProblem, a: int, y: Reals, x: Reals) -> None:
    """Set the impulse x of row ``a``, and of the row behind it if both are tangents, to P(y)."""
    kind = problem.kinds[a]
    if kind == EQUALITY:
        x[a] = y[a]
    elif kind == NORMAL:
        x[a] = greater(problem.low[a], y[a])
    elif kind == LINE:
        x[a] = clipped(y[a], problem.mu[a] * greater(x[a - 1], 0.0))
    elif kind == FIRST:
        x[a], x[a + 1] = nearest(y[a], y[a + 1], problem.mu[a] * greater(x[a - 1], 0.0))


@compiled
def project_all(problem: ContactProblem, y: Reals, x: Reals) -> None:
    """Set x to P(y)."""
    for a in range(problem.count):
        project(problem, a, y, x)


@compiled
def slopes(problem: ContactProblem, y: Reals, H: Reals, G: Reals) -> None:
    """Set G to ∂P/∂y H, where each row of H and of G has as many numbers as there are speeds."""
    n = problem.blocks.n
    for a in range(problem.count):
        kind, mu = problem.kinds[a], problem.mu[a]
        for k in range(n):
            g, h = G[a * n + k :], H[a * n + k :]
            if kind == EQUALITY:
                g[0] = h[0]
            elif kind == NORMAL:
                g[0] = h[0] if y[a] > problem.low[a] else 0.0
            elif kind == LINE:
                limit = mu * greater(greater(problem.low[a - 1], y[a - 1]), 0.0)
                g[0] = h[0] if abs(y[a]) <= limit else (mu if y[a] > 0.0 else -mu) * G[(a - 1) * n + k]
            elif kind == FIRST:
                limit = mu * greater(greater(problem.low[a - 1], y[a - 1]), 0.0)
                length = root(y[a] * y[a] + y[a + 1] * y[a + 1])
                g[0], g[n] = h[0], h[n]
                if length > limit:
                    e, f = y[a] / length, y[a + 1] / length
                    along_e = e * h[0] + f * h[n]
                    grown = mu * G[(a - 1) * n + k]
                    part = limit / length
                    g[0] = part * (h[0] - e * along_e) + e * grown
                    g[n] = part * (h[n] - f * along_e) + f * grown


@compiled
def along(blocks: Blocks, r: int, W: Reals, v: Reals) -> float:
    """Return W_r v."""
    total, k = 0.0, blocks.at[r]
    for p in range(blocks.first[r], blocks.first[r + 1]):
        b = blocks.pieces[p]
        for i in range(blocks.starts[b], blocks.starts[b + 1]):
            total += W[k] * v[i]
            k += 1
    return total


@compiled
def add(blocks: Blocks, r: int, X: Reals, x: float, v: Reals) -> None:
    """Add X_r x to v."""
    k = blocks.at[r]
    for p in range(blocks.first[r], blocks.first[r + 1]):
        b = blocks.pieces[p]
        for i in range(blocks.starts[b], blocks.starts[b + 1]):
            v[i] += X[k] * x
            k += 1


@compiled
def add_all(problem: ContactProblem) -> None:
    """Set v to Σ X x."""
    for i in range(problem.blocks.n):
        problem.v[i] = 0.0
    for a in range(problem.count):
        add(problem.blocks, problem.rows[a], problem.X, problem.x[a], problem.v)


@compiled
def rate(problem: ContactProblem, a: int) -> float:
    """Return r_a = b_a + W_a v."""
    return problem.b[a] + along(problem.blocks, problem.rows[a], problem.W, problem.v)


@compiled
def residual(problem: ContactProblem) -> float:
    """Return the greatest violation of the laws at v, relative to the reference; set the rates r."""
    for a in range(problem.count):
        if not math.isfinite(problem.x[a]):
            return math.inf
        problem.r[a] = rate(problem, a)
    return violation(problem)


@compiled
def violation(problem: ContactProblem) -> float:
    """Return the greatest violation of the laws by x and r, relative to the reference: s |x - P(x - r/s)|."""
    worst, x, r = 0.0, problem.x, problem.r
    for a in range(problem.count):
        kind, s = problem.kinds[a], problem.scale[a]
        if kind == EQUALITY:
            worst = greater(worst, abs(r[a]))
        elif kind == NORMAL:
            worst = greater(worst, abs(lesser(r[a], s * (x[a] - problem.low[a]))))
        elif kind == LINE:
            limit = s * problem.mu[a] * greater(x[a - 1], 0.0)
            worst = greater(worst, abs(s * x[a] - clipped(s * x[a] - r[a], limit)))
        elif kind == FIRST:
            limit = s * problem.mu[a] * greater(x[a - 1], 0.0)
            p, q = nearest(s * x[a] - r[a], s * x[a + 1] - r[a + 1], limit)
            worst = greater(worst, greater(abs(s * x[a] - p), abs(s * x[a + 1] - q)))
    if not math.isfinite(problem.reference):
        return problem.reference
    return worst / problem.reference if problem.reference > 0.0 else 0.0
