"""Compliance homotopy and proximal semismooth Newton's method for contact problems, in compiled code.

With A = H Cᵀ and v = Cᵀ λ, contacts of compliance ε press by what their rates r = H v + c demand:

    λ_N = max(low, y_N - r_N/ε),    λ_T = P(y_T - r_T/ε),    P: the nearest point of |T| <= μ λ_N
    F(v) = v - Cᵀ λ(H v + c) = 0,   F' = 1 + Cᵀ G H,         G = -∂λ/∂r

F has as many unknowns as the rows have independent directions, whatever the number of contacts.

    1. y = 0; ε falls from the mean of the diagonal of A to a thousandth of it; Newton's method at each
    2. y ← λ, again and again (the proximal point method): the exact law, also if A is singular
    3. where 2 is slow, ε falls further

The start is always zero. Of indeterminate forces the result is therefore the limit of equal compliance at all contacts,
the same for the same problem. If there are more than `DENSE` directions, Gauss-Seidel sweeps go before step 2, in place
of step 1.

W is H and X is C, x are the forces λ, and b is c. F' has entries for blocks that share a row only; a dense problem has
one block.

Sources: J. Carpentier, Q. Le Lidec, L. Montaut, From compliant to rigid contact simulation, arXiv 2405.17020 (2024);
P. Alart, A. Curnier, Comput. Methods Appl. Mech. Engrg. 92 (1991); F. Jourdan, P. Alart, M. Jean, ibid. 155 (1998).
"""

from __future__ import annotations

import math

from ...native.instructions import Integers, Reals, compiled, greater, hot, root
from .block_rows import add, along, dot
from .cone import add_all, bound, project, project_all, residual, slopes
from .contact_problem import FIRST, LINE, NORMAL, SECOND, ContactProblem, Newton, Trial
from .elimination import factored, jacobian, link, substitute

DENSE = 48
"""Number of directions up to which Newton's method starts from zero without sweeps, whose order breaks symmetries: the
problem of dominoes in a row has several solutions, and one that treats both sides alike."""
SOFTEST, STAGES = 1.0, 4
"""First compliance, relative to the mean of the diagonal of A, and the number of compliances, each a tenth."""
SOFT, MANY = 100.0, 18
"""First relative compliance, and the number of compliances, each half of the last, where those do not succeed."""
HARDEST, SLOW = 2e-8, 0.2
"""Lower limit of the relative compliance; ratio of two residuals above which it falls."""
ROUNDS, STEPS, SWEEPS, IDLE = 100, 60, 5000, 6
"""Limits on multiplier rounds, Newton steps in each, sweeps, and rounds without progress."""
ENOUGH = 1e-12
"""Relative residual at which rounds without progress end the search."""
SHORTEST, BEYOND, KINKS = 1e-4, 0.5, 10
"""Parts of a Newton step: the shortest that is tried, the one taken where |F|
falls in none, and how often."""
DRIFT = 0.02
"""Relative difference of two successive changes of λ below which they are extrapolated on a line."""
ROUGH = 1e-6
"""Relative residual at which sweeps end and Newton's method begins."""
FLAT, NEAR, TENTHS, FALLS = 1e-15, 1e-3, 100.0, 1e-4
"""|F| relative to |v| that is zero, and that ends the search at a compliance on the way; part of the goal that is zero;
least fall of |F| in a step, relative to what the slope promises."""
KINKED = 1e-9
"""|F| relative to |v| below which a kink ends Newton's method."""
KEPT = 0.1
"""Fall of |F| in a step up to which the factors of F' are kept."""
INSIDE = 1e-12
"""Relative distance from the boundary of a cone of a force that is inside."""


@compiled
def solve(problem: ContactProblem, memory: Newton, goal: float) -> int:
    """Find λ from zero; return the number of Newton steps. ``memory.residual`` becomes the least residual reached.

    The ways are tried in turn until one succeeds: compliances in a few steps, in many steps, sweeps. Large problems
    begin with the last.
    """
    n, unit, count = problem.blocks.n, 0.0, 0
    press_at_least(problem, problem.x)
    for a in range(problem.count):
        memory.best[a] = problem.x[a]
        unit += problem.scale[a] / problem.count
    memory.residual, memory.kept = measure(problem), 0.0
    for way in range(3):
        if not (memory.residual > goal and math.isfinite(memory.residual)):
            break
        if way > 0 and memory.residual <= ENOUGH:
            break
        swept = way == 0 if n > DENSE else way == 2
        fine = way == 2 if n > DENSE else way == 1
        clear(memory.y, problem.count)
        clear(memory.v, n)
        press_at_least(problem, problem.x)
        soft = SOFT * unit if fine else SOFTEST * unit
        if swept:
            sweep(problem)
            for a in range(problem.count):
                memory.y[a] = problem.x[a]
            for k in range(n):
                memory.v[k] = problem.v[k]
            for _ in range(STAGES - 1):
                soft /= 10.0
        else:
            for stage in range(MANY if fine else STAGES):
                if stage > 0:
                    soft /= 2.0 if fine else 10.0
                count += balance(problem, memory, soft, NEAR, STEPS)
        memory.softest = HARDEST * unit
        count += multiply(problem, memory, soft, goal)
        if memory.residual > ENOUGH:
            # λ that drifts on a line, along forces in balance, is seen at one compliance only
            clear(memory.y, problem.count)
            memory.softest = soft
            count += multiply(problem, memory, soft, goal)
    for a in range(problem.count):
        problem.x[a] = memory.best[a]
    return count


@compiled
def clear(x: Reals, n: int) -> None:
    """Set n numbers to zero."""
    for i in range(n):
        x[i] = 0.0


@compiled
def press_at_least(problem: ContactProblem, x: Reals) -> None:
    """Set x to the forces that act in any case."""
    for a in range(problem.count):
        x[a] = greater(problem.low[a], 0.0) if problem.kinds[a] == NORMAL else 0.0


@compiled
def measure(problem: ContactProblem) -> float:
    """Set v = Cᵀ λ; return the residual of λ."""
    add_all(problem)
    return residual(problem)


# -- Newton's method at one compliance -------------------------------------------------------------------


@compiled
def balance(problem: ContactProblem, memory: Newton, soft: float, flat: float, most: int) -> int:
    """Find v with |F(v)| <= ``flat`` |v| by Newton's method; return the number of steps, shorter where |F| would grow.

    ``memory.here.x`` becomes λ. The factors of F' are kept as long as |F| falls well by them.
    """
    n, v, tried, step, here, blocks = (
        problem.blocks.n,
        memory.v,
        memory.tried,
        memory.step,
        memory.here,
        problem.blocks,
    )
    size = error(problem, memory.y, soft, v, here)
    kinks = 0
    for turn in range(most):
        if size <= flat * root(dot(v, v, n)) or problem.stop != 0:
            return turn
        kept = memory.kept == soft
        if not kept and slope(problem, memory, soft) == 0:
            return turn
        for k in range(n):
            step[k] = -here.F[k]
        substitute(memory.J[0], blocks, memory.links, memory.order, step)
        part, shorter, new = 1.0, True, size
        while shorter:
            for k in range(n):
                tried[k] = v[k] + part * step[k]
            new = error(problem, memory.y, soft, tried, memory.there)
            shorter = not new < (1.0 - FALLS * part) * size
            part /= 2.0
            if kept:
                break
            if shorter and part < SHORTEST:
                # a kink: |F| falls in no short step, and the slope beyond it is needed
                if size <= KINKED * root(dot(v, v, n)) or kinks == KINKS or not math.isfinite(new):
                    return turn
                kinks += 1
                for k in range(n):
                    tried[k] = v[k] + BEYOND * step[k]
                new = error(problem, memory.y, soft, tried, memory.there)
                shorter = False
        if not new <= KEPT * size:
            memory.kept = 0.0
            if kept and shorter:
                continue
        size = new
        for k in range(n):
            v[k], here.F[k] = tried[k], memory.there.F[k]
        for a in range(problem.count):
            here.free[a], here.x[a] = memory.there.free[a], memory.there.x[a]
    return most


@hot
@compiled
def error(problem: ContactProblem, y: Reals, soft: float, v: Reals, trial: Trial) -> float:
    """Set y - r/ε, λ and F(v); return |F|."""
    n, F, blocks = problem.blocks.n, trial.F, problem.blocks
    for a in range(problem.count):
        trial.free[a] = y[a] - (problem.b[a] + along(blocks, problem.rows[a], problem.W, v)) / soft
    project_all(problem, trial.free, trial.x)
    for k in range(n):
        F[k] = v[k]
    for a in range(problem.count):
        if trial.x[a] != 0.0:
            add(blocks, problem.rows[a], problem.X, -trial.x[a], F)
    return root(dot(F, F, n))


@compiled
def slope(problem: ContactProblem, memory: Newton, soft: float) -> int:
    """Set the factors of F' at v; return 0 if it is singular, else 1."""
    slopes(problem, memory.here.free, problem.W, memory.G[0])
    for a in range(problem.count):  # λ = P(y - r/ε)
        for k in range(problem.blocks.at[problem.rows[a]], problem.blocks.at[problem.rows[a] + 1]):
            memory.G[0][k] /= soft
    link(problem, memory.links)
    jacobian(problem, memory.G[0], memory)
    memory.factored += 1
    memory.kept = soft
    if factored(memory.J[0], problem.blocks, memory.links, memory.order) == 0:
        memory.kept = 0.0
        return 0
    return 1


# -- multipliers -----------------------------------------------------------------------------------------


@compiled
def multiply(problem: ContactProblem, memory: Newton, soft: float, goal: float) -> int:
    """Improve λ from v and y by rounds of multipliers; return the number of Newton steps."""
    x, y, past, moved = problem.x, memory.y, memory.past, memory.moved
    for a in range(problem.count):
        past[a], moved[a] = 0.0, 0.0
    count, idle, last, flat = 0, 0, math.inf, greater(FLAT, goal / TENTHS)
    for _ in range(ROUNDS):
        count += balance(problem, memory, soft, flat, STEPS)
        for a in range(problem.count):
            x[a] = memory.here.x[a]
        size = measure(problem)
        if problem.stop != 0 or not math.isfinite(size):
            return count
        idle += 1
        if size < memory.residual:
            if size < 0.5 * memory.residual:
                idle = 0
            memory.residual = size
            for a in range(problem.count):
                memory.best[a] = x[a]
        if memory.residual <= goal or (idle > IDLE and memory.residual <= ENOUGH):
            return count
        square, turn = 0.0, 0.0
        for a in range(problem.count):
            change = x[a] - past[a]
            square += change * change
            turn += (change - moved[a]) * (change - moved[a])
            moved[a] = change
        part = reach(problem, moved) if turn < DRIFT * DRIFT * square else 0.0
        if part == 0.0 and size > SLOW * last and soft > memory.softest:
            soft /= 10.0
        for a in range(problem.count):
            y[a] = x[a] + part * moved[a]
            past[a] = y[a]
        last = size
    return count


@compiled
def reach(problem: ContactProblem, d: Reals) -> float:
    """Return the greatest factor up to which λ + t d leaves every contact inside its cone; 0 if there is no limit.

    |T + t dT| = μ (N + t dN)   or   N + t dN = low; contacts on the boundary do not count.
    """
    nearest, x = 0.0, problem.x
    for a in range(problem.count):
        t, kind = 0.0, problem.kinds[a]
        if kind == NORMAL and d[a] < 0.0 and x[a] > problem.low[a]:
            t = (problem.low[a] - x[a]) / d[a]
        elif problem.kinds[a] == LINE or problem.kinds[a] == FIRST:
            T2, d2, Td = x[a] * x[a], d[a] * d[a], x[a] * d[a]
            if kind == FIRST:
                T2 += x[a + 1] * x[a + 1]
                d2 += d[a + 1] * d[a + 1]
                Td += x[a + 1] * d[a + 1]
            limit, growth = problem.mu[a] * x[bound(problem, a)], problem.mu[a] * d[bound(problem, a)]
            a_2, h, k = d2 - growth * growth, Td - limit * growth, T2 - limit * limit
            if (
                x[bound(problem, a)] > 0.0 and k < -INSIDE * limit * limit
            ):  # the least positive root of a t² + 2 h t + k
                s = root(greater(h * h - a_2 * k, 0.0))
                if h > 0.0:
                    t = -k / (h + s)
                elif a_2 > 0.0:
                    t = (s - h) / a_2
        if t > 0.0 and (nearest == 0.0 or t < nearest):
            nearest = t
    return nearest


# -- sweeps ----------------------------------------------------------------------------------------------


@compiled
def sweep(problem: ContactProblem) -> float:
    """Improve λ by sweeps, λ ← P(λ - r/s) contact by contact, until it is within `ROUGH`; return the residual."""
    x, r = problem.x, problem.r
    left = measure(problem)
    for turn in range(SWEEPS):
        if left <= ROUGH or problem.stop != 0 or not math.isfinite(left):
            return left
        for a in range(problem.count):
            if problem.kinds[a] != SECOND:
                last = a + 2 if problem.kinds[a] == FIRST else a + 1
                for i in range(a, last):
                    rate = problem.b[i] + along(problem.blocks, i, problem.W, problem.v)
                    r[i] = x[i] - rate / problem.scale[a]
                project(problem, a, r, r)
                for i in range(a, last):
                    if r[i] != x[i]:
                        add(problem.blocks, i, problem.X, r[i] - x[i], problem.v)
                        x[i] = r[i]
        if turn % 10 == 9:
            left = measure(problem)
    return measure(problem)


# -- factors of A ----------------------------------------------------------------------------------------


@compiled
def factor(A: Reals, m: int, H: Reals, small: float, left: Reals, order: Integers) -> int:
    """Write H (m, n) of A = H Hᵀ by Cholesky's method with the largest remaining pivot first; return n.

    A row counts as dependent if less than ``small`` of its diagonal remains. ``H`` has room for m m numbers and is
    filled with stride m; ``left`` holds m numbers.
    """
    for i in range(m):
        left[i] = A[i * m + i]
        order[i] = 0
    for n in range(m):
        best, p = small, -1
        for i in range(m):
            if order[i] == 0 and A[i * m + i] > 0.0 and left[i] > best * A[i * m + i]:
                best, p = left[i] / A[i * m + i], i
        if p < 0:
            return n
        order[p] = 1
        pivot = root(left[p])
        for i in range(m):
            if order[i] == 0:
                s = (A[i * m + p] + A[p * m + i]) / 2.0
                for k in range(n):
                    s -= H[i * m + k] * H[p * m + k]
                H[i * m + n] = s / pivot
                left[i] -= H[i * m + n] * H[i * m + n]
            else:
                H[i * m + n] = pivot if i == p else 0.0
    return m
