"""An interior point method for contact problems: the forces of faces on faces from zero, in a bounded number of steps.

With D = diag(1, μ, μ), x = D y and z = D r + |z_T| e_N, z_T = μ r_T, Signorini's and Coulomb's laws are those of two
vectors in second-order cones, y and z, at right angles to each other: y_N >= |y_T|, r_N = z_N - |z_T| >= 0, y·z = 0.
Newton's method follows the path

    y ∘ z = τ e_N,    r = b + W Σ X x,    y ∘ z = (y·z, y_N z_T + z_N y_T)

to τ = 0, with Nesterov's and Todd's scaling S y = S⁻¹ z, and Mehrotra's choice of τ and of the correction:

    dz = D̃ W dv - ρ,   dy = q - S⁻² dz,   (1 + Xᵀ D S⁻² D̃ W) dv = Xᵀ D (q + S⁻² ρ)

D̃ W has the slope of |z_T|, ρ is the violation of z = D r + |z_T| e_N, and q = -y + S⁻¹ (λ \\ (τ e_N - S dy ∘ S⁻¹ dz)),
λ = S y. The slope couples slip and normal force: their matrix is not symmetric, and the path may end where the slope
turns with the slip. Steps that stay short go on without it, and with it where these stay short. z moves so that r_N and
r_T are linear along a step.

The matrix is that of Newton's method on the laws (`descent`), which ends what this begins: near the solution z and y of
a contact differ by many powers of ten.

Sources: S. Mehrotra, SIAM J. Optim. 2 (1992) 575-601; Y. E. Nesterov, M. J. Todd, Math. Oper. Res. 22 (1997) 1-42;
V. Acary, P. Armand, H. M. Nguyen, Comput. Methods Appl. Mech. Engrg. 424 (2024) (friction).
"""

from __future__ import annotations

import math

from ...native.instructions import Reals, compiled, greater, inlined, lesser, root
from .block_rows import add, along
from .cone import add_all, residual
from .contact_problem import LINE, NORMAL, ContactProblem, Newton, Path
from .elimination import factored, jacobian, link, substitute

INSIDE = 0.99
"""Part of the way to the boundary of a cone that a step takes."""
SHORT, TWICE = 0.15, 2
"""Length of a step that is short, and number of them after which the slope of |z_T| is left out or taken in again."""
LEAST = 1e-300


@compiled
def is_served(problem: ContactProblem) -> int:
    """Return 1 if the rows are normals that press from zero on, some of them with friction, and nothing else."""
    friction = 0
    for a in range(problem.count):
        kind = problem.kinds[a]
        if kind < NORMAL or problem.low[a] != 0.0 or problem.between[a] != 0 or not problem.scale[a] > 0.0:
            return 0
        if kind > NORMAL:
            friction = 1
    return friction


@inlined
def size_of(problem: ContactProblem, a: int) -> int:
    """Return the number of rows of the contact whose normal is row ``a``."""
    size = 1
    if a + 1 < problem.count and problem.kinds[a + 1] != NORMAL:
        size = 2 if problem.kinds[a + 1] == LINE else 3
    return size


@inlined
def friction(problem: ContactProblem, a: int, size: int) -> float:
    """Return the coefficient of friction of the contact whose normal is row ``a``."""
    return problem.mu[a + 1] if size > 1 else 0.0


@inlined
def three(x: Reals, a: int, size: int) -> tuple[float, float, float]:
    """Return the numbers of a contact, zero for tangents that it does not have."""
    return x[a], x[a + 1] if size > 1 else 0.0, x[a + 2] if size > 2 else 0.0


@inlined
def cone_impulse(problem: ContactProblem, x: Reals, a: int, size: int) -> tuple[float, float, float]:
    """Return y, or its change, of an impulse x = D y."""
    p, q, r = three(x, a, size)
    mu = friction(problem, a, size)
    return p, q / mu if mu > 0.0 else 0.0, r / mu if mu > 0.0 else 0.0


@inlined
def across(p: float, q: float, r: float) -> tuple[float, float, float]:
    """Return |(q, r)| and its slopes."""
    length = root(q * q + r * r)
    return length, q / length if length > 0.0 else 0.0, r / length if length > 0.0 else 0.0


@inlined
def scaled(w: float, u: float, v: float, p: float, q: float, r: float) -> tuple[float, float, float]:
    """Return S x of the unit scaling (w, u, v); of (w, -u, -v) it is S⁻¹ x."""
    s = u * q + v * r
    t = p + s / (1.0 + w)
    return w * p + s, q + u * t, r + v * t


@compiled
def begin(problem: ContactProblem, path: Path, start: float, bends: float) -> None:
    """Set y and z to multiples of e_N, rates of ``start`` relative to the reference; ``bends`` 1: with the slope."""
    unit, count = 0.0, 0
    for a in range(problem.count):
        if problem.kinds[a] == NORMAL:
            unit += problem.scale[a]
            count += 1
    rate = start * problem.reference
    for a in range(problem.count):
        normal = problem.kinds[a] == NORMAL
        path.z[a], path.x[a] = rate if normal else 0.0, rate * count / unit if normal else 0.0
    path.bends, path.short = bends, 0


@compiled
def go_on(problem: ContactProblem, memory: Newton, goal: float, most: int) -> float:
    """Do up to ``most`` steps along the path, until the residual is at most ``goal``; return that of x."""
    path, size = memory.path, math.inf
    link(problem, memory.links)
    for turn in range(most + 1):
        for a in range(problem.count):
            problem.x[a] = path.x[a]
        add_all(problem)
        size = residual(problem)
        if not size > goal or not math.isfinite(size) or turn == most or problem.stop != 0:
            return size
        gap = set_equations(problem, memory)
        jacobian(problem, memory.G[0], memory)
        memory.factored += 1
        if factored(memory.J[0], problem.blocks, memory.links, memory.order) == 0:
            return size
        solve(problem, memory)
        left = complement(problem, path, lesser(1.0, room(problem, path))) / gap
        correct(problem, path, lesser(1.0, left * left) * gap)
        solve(problem, memory)
        advance(problem, path, lesser(1.0, INSIDE * room(problem, path)))
    return size


@compiled
def set_equations(problem: ContactProblem, memory: Newton) -> float:
    """Set ρ, the scaling, q = -y and G = D S⁻² D̃ W; return the mean of y·z."""
    path, blocks, W, G, gap, count = memory.path, problem.blocks, problem.W, memory.G[0], 0.0, 0
    for a in range(problem.count):
        if problem.kinds[a] != NORMAL:
            continue
        size = size_of(problem, a)
        mu = friction(problem, a, size)
        y, y_1, y_2 = cone_impulse(problem, path.x, a, size)
        z, z_1, z_2 = three(path.z, a, size)
        slip, t_1, t_2 = across(z, z_1, z_2)
        t_1, t_2 = path.bends * t_1, path.bends * t_2
        miss_1, miss_2 = 0.0, 0.0
        if size > 1:
            miss_1 = z_1 - mu * problem.r[a + 1]
            path.miss[a + 1], path.q[a + 1] = miss_1, -y_1
        if size > 2:
            miss_2 = z_2 - mu * problem.r[a + 2]
            path.miss[a + 2], path.q[a + 2] = miss_2, -y_2
        path.miss[a] = z - slip - problem.r[a] + t_1 * miss_1 + t_2 * miss_2
        path.q[a] = -y
        gap += y * z + y_1 * z_1 + y_2 * z_2
        count += 1
        # the scaling: w = (z/|z| + J y/|y|)/(2 g) with |z|² = z_N² - |z_T|², and η² = |z|/|y|
        long_y = root(greater(y * y - y_1 * y_1 - y_2 * y_2, LEAST))
        long_z = root(greater(z * z - z_1 * z_1 - z_2 * z_2, LEAST))
        product = (y * z + y_1 * z_1 + y_2 * z_2) / (long_y * long_z)
        half = 1.0 / root(2.0 + 2.0 * product)
        u, v = half * (z_1 / long_z - y_1 / long_y), half * (z_2 / long_z - y_2 / long_y)
        w, soft = root(1.0 + u * u + v * v), long_y / long_z
        path.scaling[a] = soft
        if size > 1:
            path.scaling[a + 1] = u
        if size > 2:
            path.scaling[a + 2] = v
        # S⁻² = (2 w' w'ᵀ - J) / η²,  w' = (w, -u, -v)
        i = blocks.at[problem.rows[a]]
        n = blocks.at[problem.rows[a] + 1] - i
        for k in range(i, i + n):
            c_1, c_2 = 0.0, 0.0
            if size > 1:
                c_1 = mu * W[k + n]
            if size > 2:
                c_2 = mu * W[k + 2 * n]
            c = W[k] + t_1 * c_1 + t_2 * c_2
            share = 2.0 * (w * c - u * c_1 - v * c_2)
            G[k] = soft * (w * share - c)
            if size > 1:
                G[k + n] = mu * soft * (c_1 - u * share)
            if size > 2:
                G[k + 2 * n] = mu * soft * (c_2 - v * share)
    return gap / count


@inlined
def softened(path: Path, a: int, size: int, p: float, q: float, r: float) -> tuple[float, float, float]:
    """Return S⁻² times a vector."""
    soft, u, v = three(path.scaling, a, size)
    w = root(1.0 + u * u + v * v)
    share = 2.0 * (w * p - u * q - v * r)
    return soft * (w * share - p), soft * (q - u * share), soft * (r - v * share)


@compiled
def solve(problem: ContactProblem, memory: Newton) -> None:
    """Set dv, dz and dx by the factors, from q."""
    path, blocks, dv = memory.path, problem.blocks, memory.step
    for k in range(blocks.n):
        dv[k] = 0.0
    for a in range(problem.count):
        if problem.kinds[a] == NORMAL:
            size, r = size_of(problem, a), problem.rows[a]
            mu = friction(problem, a, size)
            m, m_1, m_2 = three(path.miss, a, size)
            p, p_1, p_2 = softened(path, a, size, m, m_1, m_2)
            add(blocks, r, problem.X, path.q[a] + p, dv)
            if size > 1:
                add(blocks, r + 1, problem.X, mu * (path.q[a + 1] + p_1), dv)
            if size > 2:
                add(blocks, r + 2, problem.X, mu * (path.q[a + 2] + p_2), dv)
    substitute(memory.J[0], blocks, memory.links, memory.order, dv)
    for a in range(problem.count):
        if problem.kinds[a] == NORMAL:
            size, r = size_of(problem, a), problem.rows[a]
            mu = friction(problem, a, size)
            z, z_1, z_2 = three(path.z, a, size)
            _, t_1, t_2 = across(z, z_1, z_2)
            d, d_1, d_2 = along(blocks, r, problem.W, dv) - path.miss[a], 0.0, 0.0
            if size > 1:
                d_1 = mu * along(blocks, r + 1, problem.W, dv)
            if size > 2:
                d_2 = mu * along(blocks, r + 2, problem.W, dv)
            d += path.bends * (t_1 * d_1 + t_2 * d_2)
            if size > 1:
                d_1 -= path.miss[a + 1]
                path.dz[a + 1] = d_1
            if size > 2:
                d_2 -= path.miss[a + 2]
                path.dz[a + 2] = d_2
            path.dz[a] = d
            p, p_1, p_2 = softened(path, a, size, d, d_1, d_2)
            path.dx[a] = path.q[a] - p
            if size > 1:
                path.dx[a + 1] = mu * (path.q[a + 1] - p_1)
            if size > 2:
                path.dx[a + 2] = mu * (path.q[a + 2] - p_2)


@compiled
def room(problem: ContactProblem, path: Path) -> float:
    """Return the length of a step at which a contact reaches the boundary of a cone."""
    most = math.inf
    for a in range(problem.count):
        if problem.kinds[a] != NORMAL:
            continue
        size = size_of(problem, a)
        y, y_1, y_2 = cone_impulse(problem, path.x, a, size)
        d, d_1, d_2 = cone_impulse(problem, path.dx, a, size)
        # the least positive root of (d·Jd) t² + 2 (y·Jd) t + y·Jy
        square, half = d * d - d_1 * d_1 - d_2 * d_2, y * d - y_1 * d_1 - y_2 * d_2
        whole = greater(y * y - y_1 * y_1 - y_2 * y_2, 0.0)
        inner = half * half - square * whole
        if inner >= 0.0 and root(inner) > half:
            most = lesser(most, whole / (root(inner) - half))
        if d < 0.0:
            most = lesser(most, -y / d)
        rate, change = normal_rate(path, a, size)
        if change < 0.0:
            most = lesser(most, -rate / change)
    return most


@inlined
def normal_rate(path: Path, a: int, size: int) -> tuple[float, float]:
    """Return r_N = z_N - |z_T| and its change in a step."""
    z, z_1, z_2 = three(path.z, a, size)
    d, d_1, d_2 = three(path.dz, a, size)
    slip, t_1, t_2 = across(z, z_1, z_2)
    return z - slip, d - t_1 * d_1 - t_2 * d_2


@compiled
def complement(problem: ContactProblem, path: Path, part: float) -> float:
    """Return the mean of y·z after a part of a step."""
    total, count = 0.0, 0
    for a in range(problem.count):
        if problem.kinds[a] == NORMAL:
            size = size_of(problem, a)
            y, y_1, y_2 = cone_impulse(problem, path.x, a, size)
            d, d_1, d_2 = cone_impulse(problem, path.dx, a, size)
            z, z_1, z_2 = three(path.z, a, size)
            e, e_1, e_2 = three(path.dz, a, size)
            total += (y + part * d) * (z + part * e)
            total += (y_1 + part * d_1) * (z_1 + part * e_1) + (y_2 + part * d_2) * (z_2 + part * e_2)
            count += 1
    return total / count


@compiled
def correct(problem: ContactProblem, path: Path, tau: float) -> None:
    """Set q = -y + S⁻¹ (λ \\ (τ e_N - S dy ∘ S⁻¹ dz))."""
    for a in range(problem.count):
        if problem.kinds[a] != NORMAL:
            continue
        size = size_of(problem, a)
        y, y_1, y_2 = cone_impulse(problem, path.x, a, size)
        d, d_1, d_2 = cone_impulse(problem, path.dx, a, size)
        e, e_1, e_2 = three(path.dz, a, size)
        soft, u, v = three(path.scaling, a, size)
        w, eta = root(1.0 + u * u + v * v), root(1.0 / soft)
        lam, lam_1, lam_2 = scaled(w, u, v, eta * y, eta * y_1, eta * y_2)
        f, f_1, f_2 = scaled(w, u, v, eta * d, eta * d_1, eta * d_2)
        g, g_1, g_2 = scaled(w, -u, -v, e / eta, e_1 / eta, e_2 / eta)
        p = tau - (f * g + f_1 * g_1 + f_2 * g_2)
        p_1, p_2 = -(f * g_1 + g * f_1), -(f * g_2 + g * f_2)
        s = (lam * p - lam_1 * p_1 - lam_2 * p_2) / greater(lam * lam - lam_1 * lam_1 - lam_2 * lam_2, LEAST)
        p, p_1, p_2 = scaled(
            w, -u, -v, s / eta, (p_1 - lam_1 * s) / (lam * eta), (p_2 - lam_2 * s) / (lam * eta)
        )
        path.q[a] = p - y
        if size > 1:
            path.q[a + 1] = p_1 - y_1
        if size > 2:
            path.q[a + 2] = p_2 - y_2


@compiled
def advance(problem: ContactProblem, path: Path, part: float) -> None:
    """Do a part of the step, and leave out the slope of |z_T|, or take it in, where two steps were short."""
    for a in range(problem.count):
        if problem.kinds[a] == NORMAL:
            size = size_of(problem, a)
            rate, change = normal_rate(path, a, size)
            for k in range(a + 1, a + size):
                path.z[k] += part * path.dz[k]
            z, z_1, z_2 = three(path.z, a, size)
            slip, t_1, t_2 = across(z, z_1, z_2)
            path.z[a] = rate + part * change + slip
        path.x[a] += part * path.dx[a]
    path.short = path.short + 1 if part < SHORT else 0
    if path.short == TWICE:
        path.short, path.bends = 0, 1.0 - path.bends
