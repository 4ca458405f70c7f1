"""Coulomb's cones: the nearest point P, its slope, and the residual of a contact problem.

    x_N = max(low, y_N),    x_T = P(y_T): y_T, or where |y_T| > μ x_N its direction with that length

Signorini's and Coulomb's laws are x = P(x - r/s) with any s > 0: a contact presses where r_N = 0, and friction that
reaches μ x_N points against the slip r_T. The residual is s |x - P(x - r/s)|, a rate.

Source: P. Alart, A. Curnier, Comput. Methods Appl. Mech. Engrg. 92 (1991) 353-375.
"""

from __future__ import annotations

import math

from ...native.instructions import Reals, compiled, greater, hot, inlined, lesser, root
from .block_rows import add, add_three, along_three, product
from .contact_problem import EQUALITY, FIRST, LINE, NORMAL, SECOND, ContactProblem


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


@inlined
def clipped_slope(y: float, limit: float, dy: float, growth: float) -> float:
    """Return the change of `clipped` with those of y and of the limit."""
    return dy if abs(y) <= limit else (growth if y > 0.0 else -growth)


@inlined
def bend(y_1: float, y_2: float, limit: float) -> tuple[float, float, float]:
    """Return e and p of the change of `nearest` with those of y and of the limit: p (1 - e eᵀ) dy + e dlimit."""
    length = root(y_1 * y_1 + y_2 * y_2)
    outside = length > limit
    return (
        y_1 / length if outside else 0.0,
        y_2 / length if outside else 0.0,
        limit / length if outside else 1.0,
    )


@inlined
def bound(problem: ContactProblem, a: int) -> int:
    """Return the normal row that bounds a tangent."""
    return a - 1 - problem.between[a]


@inlined
def joined(problem: ContactProblem, a: int) -> int:
    """Return the number of rows from row ``a`` on that are taken together: a normal with two tangents, or one."""
    return 3 if a + 2 < problem.count and problem.kinds[a + 2] == SECOND and problem.kinds[a] == NORMAL else 1


@compiled
def project(problem: ContactProblem, a: int, y: Reals, x: Reals) -> None:
    """Set the impulse x of row ``a``, and of the row behind it if both are tangents, to P(y)."""
    kind = problem.kinds[a]
    if kind == EQUALITY:
        x[a] = y[a]
    elif kind == NORMAL:
        x[a] = greater(problem.low[a], y[a])
    elif kind == LINE:
        x[a] = clipped(y[a], problem.mu[a] * greater(x[bound(problem, a)], 0.0))
    elif kind == FIRST:
        x[a], x[a + 1] = nearest(y[a], y[a + 1], problem.mu[a] * greater(x[bound(problem, a)], 0.0))


@compiled
def project_all(problem: ContactProblem, y: Reals, x: Reals) -> None:
    """Set x to P(y)."""
    for a in range(problem.count):
        project(problem, a, y, x)


@hot
@compiled
def slopes(problem: ContactProblem, y: Reals, H: Reals, G: Reals) -> None:
    """Set G to ∂P/∂y H, both stored as the rows of the problem. The rows of a contact cover the same blocks."""
    at = problem.blocks.at
    for a in range(problem.count):
        r, kind, mu = problem.rows[a], problem.kinds[a], problem.mu[a]
        begin, n = at[r], at[r + 1] - at[r]
        h, g = H[begin:], G[begin:]
        under = at[problem.rows[bound(problem, a)]] if kind > NORMAL else begin
        limit, e, f, p, whole = 0.0, 0.0, 0.0, 1.0, kind == EQUALITY or y[a] > problem.low[a]
        if kind == LINE or kind == FIRST:  # noqa: SIM109
            limit = mu * greater(greater(problem.low[bound(problem, a)], y[bound(problem, a)]), 0.0)
        if kind == FIRST:
            e, f, p = bend(y[a], y[a + 1], limit)
        for k in range(n):
            if kind <= NORMAL:
                g[k] = h[k] if whole else 0.0
            elif kind == LINE:
                g[k] = clipped_slope(y[a], limit, h[k], mu * G[under + k])
            elif kind == FIRST:
                along_e, growth = e * h[k] + f * h[n + k], mu * G[under + k]
                g[k], g[n + k] = (
                    p * (h[k] - e * along_e) + e * growth,
                    p * (h[n + k] - f * along_e) + f * growth,
                )


@compiled
def add_all(problem: ContactProblem) -> None:
    """Set v to Σ X x."""
    combine(problem, problem.x, problem.v)


@hot
@compiled
def combine(problem: ContactProblem, x: Reals, v: Reals) -> None:
    """Set v to Σ X x of the rows of a problem."""
    a = 0
    for i in range(problem.blocks.n):
        v[i] = 0.0
    while a < problem.count:
        size = joined(problem, a)
        if size == 3 and (x[a] != 0.0 or x[a + 1] != 0.0 or x[a + 2] != 0.0):
            add_three(problem.blocks, problem.rows[a], problem.X, x[a:], v)
        elif size == 1 and x[a] != 0.0:
            add(problem.blocks, problem.rows[a], problem.X, x[a], v)
        a += size


@hot
@compiled
def along_all(problem: ContactProblem, W: Reals, v: Reals, r: Reals) -> None:
    """Set r to W v of the rows of a problem."""
    a = 0
    while a < problem.count:
        size = joined(problem, a)
        if size == 3:
            along_three(problem.blocks, problem.rows[a], W, v, r[a:])
        else:
            r[a] = product(problem.blocks, problem.rows[a], W, v)
        a += size


@hot
@compiled
def rate(problem: ContactProblem, a: int) -> float:
    """Return r_a = b_a + W_a v."""
    return problem.b[a] + product(problem.blocks, problem.rows[a], problem.W, problem.v)


@hot
@compiled
def residual(problem: ContactProblem) -> float:
    """Return the greatest violation of the laws at v, relative to the reference; set the rates r."""
    for a in range(problem.count):
        if not math.isfinite(problem.x[a]):
            return math.inf
    along_all(problem, problem.W, problem.v, problem.r)
    for a in range(problem.count):
        problem.r[a] += problem.b[a]
    return violation(problem)


@hot
@compiled
def violation(problem: ContactProblem) -> float:
    """Return the greatest violation of the laws by x and r, relative to the reference; set the violations e.

    e = s x - P(s x - r),  P with the limits s μ x_N: the same as s (x - P(x - r/s)), also where s = 0
    """
    worst, x, r, e = 0.0, problem.x, problem.r, problem.e
    for a in range(problem.count):
        kind, s = problem.kinds[a], problem.scale[a]
        if kind == EQUALITY:
            e[a] = r[a]
        elif kind == NORMAL:
            e[a] = lesser(r[a], s * (x[a] - problem.low[a]))
        elif kind == LINE:
            e[a] = s * x[a] - clipped(s * x[a] - r[a], s * problem.mu[a] * greater(x[bound(problem, a)], 0.0))
        elif kind == FIRST:
            limit = s * problem.mu[a] * greater(x[bound(problem, a)], 0.0)
            p, q = nearest(s * x[a] - r[a], s * x[a + 1] - r[a + 1], limit)
            e[a], e[a + 1] = s * x[a] - p, s * x[a + 1] - q
    for a in range(problem.count):
        worst = greater(worst, abs(e[a]))
    if not math.isfinite(problem.reference):
        return problem.reference
    return worst / problem.reference if problem.reference > 0.0 else 0.0


@compiled
def violation_slopes(problem: ContactProblem, A: Reals, slope: Reals) -> None:
    """Set ``slope`` to ∂e/∂x, where ∂r/∂x = A; both have as many columns as rows."""
    m, x, r = problem.count, problem.x, problem.r
    for a in range(m):
        kind, s, mu = problem.kinds[a], problem.scale[a], problem.mu[a]
        limit, grown, e, f, p = 0.0, 0.0, 0.0, 0.0, 1.0
        if kind == LINE or kind == FIRST:  # noqa: SIM109
            limit, grown = (
                s * mu * greater(x[bound(problem, a)], 0.0),
                s * mu if x[bound(problem, a)] > 0.0 else 0.0,
            )
        if kind == FIRST:
            e, f, p = bend(s * x[a] - r[a], s * x[a + 1] - r[a + 1], limit)
        for k in range(m):
            i = a * m + k
            one, normal = s if k == a else 0.0, grown if kind > NORMAL and k == bound(problem, a) else 0.0
            if kind == EQUALITY:
                slope[i] = A[i]
            elif kind == NORMAL:
                slope[i] = A[i] if s * (x[a] - problem.low[a]) > r[a] else one
            elif kind == LINE:
                slope[i] = one - clipped_slope(s * x[a] - r[a], limit, one - A[i], normal)
            elif kind == FIRST:
                other = s if k == a + 1 else 0.0
                dy, dz = one - A[i], other - A[i + m]
                along_e = e * dy + f * dz
                slope[i] = one - p * (dy - e * along_e) - e * normal
                slope[i + m] = other - p * (dz - f * along_e) - f * normal


@hot
@compiled
def law_slopes(problem: ContactProblem, loose: float, augmented: int, g: Reals, G: Reals) -> None:
    """Set g and G, stored as the rows of the problem, of the changes dx = -(g + G dv) that would let e vanish.

    e + E_r W dv + (E_x + δ s) dx = 0 contact by contact, with δ = ``loose``. With ``augmented`` 1, two tangents have
    the limit μ s P(x_N - r_N/s_N) of Alart and Curnier in place of μ s x_N, in e, too; both have the same zeros.
    """
    at, x, r, e = problem.blocks.at, problem.x, problem.r, problem.e
    for a in range(problem.count):
        row, kind, s, mu = problem.rows[a], problem.kinds[a], problem.scale[a], problem.mu[a]
        begin, n = at[row], at[row + 1] - at[row]
        over = at[problem.rows[bound(problem, a)]] if kind > NORMAL else begin
        w, part = problem.W[begin:], G[begin:]
        soft = 1.0 / (loose * s) if s > 0.0 else 0.0
        hard = 1.0 / s if s > 0.0 else 0.0
        pressed = x[bound(problem, a)] > 0.0 if kind > NORMAL else True
        limit, growth = 0.0, 0.0
        if kind > NORMAL and pressed:
            limit, growth = s * mu * x[bound(problem, a)], mu
        if kind <= NORMAL:
            held = kind == EQUALITY or s * (x[a] - problem.low[a]) > r[a]
            g[a] = e[a] * (soft if held else hard)
            for k in range(n):
                part[k] = soft * w[k] if held else 0.0
        elif kind == LINE:
            y = s * x[a] - r[a]
            share = growth if y > 0.0 else -growth
            held = abs(y) <= limit
            g[a] = e[a] * soft if held else e[a] * hard + share * g[bound(problem, a)]
            for k in range(n):
                part[k] = soft * w[k] if held else share * G[over + k]
        elif kind == FIRST:
            under, compliance = problem.W[over:], 0.0
            if augmented == 1 and problem.scale[bound(problem, a)] > 0.0 and problem.between[a] == 0:
                limit, growth, compliance = augmented_limit(problem, a)
                p, q = nearest(s * x[a] - r[a], s * x[a + 1] - r[a + 1], limit)
                e[a], e[a + 1] = s * x[a] - p, s * x[a + 1] - q
            d, f, p = bend(s * x[a] - r[a], s * x[a + 1] - r[a + 1], limit)
            # held: d = f = 0, p = 1
            across = 1.0 / (s * (1.0 - p) + loose * s) if s > 0.0 else 0.0
            ahead = d * e[a] + f * e[a + 1]
            push = hard * ahead + growth * g[bound(problem, a)]
            g[a] = across * (e[a] - d * ahead) + d * push
            g[a + 1] = across * (e[a + 1] - f * ahead) + f * push
            for k in range(n):
                forward = d * w[k] + f * w[n + k]
                grown = growth * (G[over + k] + compliance * under[k])
                part[k] = across * p * (w[k] - d * forward) + d * grown
                part[n + k] = across * p * (w[n + k] - f * forward) + f * grown


@inlined
def augmented_limit(problem: ContactProblem, a: int) -> tuple[float, float, float]:
    """Return μ s P(y) of two tangents from row ``a`` on, y = x_N - r_N/s_N; μ and 1/s_N, or 0 where P(y) is not y."""
    normal = bound(problem, a)
    y, low = problem.x[normal] - problem.r[normal] / problem.scale[normal], problem.low[normal]
    presses = y > low and y > 0.0
    return (
        problem.scale[a] * problem.mu[a] * greater(greater(y, low), 0.0),
        problem.mu[a] if presses else 0.0,
        1.0 / problem.scale[normal] if presses else 0.0,
    )


@compiled
def set_scales(problem: ContactProblem) -> None:
    """Set the scales: the diagonal of A, and for two tangents a bound on the eigenvalues of A_TT (Gershgorin)."""
    A, s = problem.matrix, problem.scale
    for a in range(problem.count):
        s[a] = A[a, 0]
    for a in range(problem.count):
        if problem.kinds[a] == FIRST:
            s[a] = greater(A[a, 0], A[a + 1, 0]) + abs(A[a, 1])
            s[a + 1] = s[a]
