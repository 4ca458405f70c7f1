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

A problem is one block of real numbers: H (m n), C (m n), c, μ, low, scale, λ (m each), then `room(m, n)` numbers. The
kind of a row: 0 equality, 1 normal, 2 the only tangent of the row before it, 3 and 4 two tangents of the normal before.

Sources: J. Carpentier, Q. Le Lidec, L. Montaut, From compliant to rigid contact simulation, arXiv 2405.17020 (2024);
P. Alart, A. Curnier, Comput. Methods Appl. Mech. Engrg. 92 (1991); F. Jourdan, P. Alart, M. Jean, ibid. 155 (1998).
"""

from __future__ import annotations

import math

from ...native.instructions import Integers, Reals, compiled, greater, root, shifted
from ..phase.elimination import solved

EQUALITY, NORMAL, LINE, FIRST, SECOND = range(5)
"""Kinds of rows."""
DENSE = 24
"""Number of directions up to which Newton's method starts from zero without sweeps."""
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


def room(m: int, n: int) -> int:
    """Return how many numbers the solution of m rows with n directions needs beside its problem."""
    return 2 * m * n + n * n + 5 * n + 14 * m


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


@compiled
def dot(a: Reals, b: Reals, n: int) -> float:
    """Return a · b."""
    s = 0.0
    for k in range(n):
        s += a[k] * b[k]
    return s


@compiled
def pressed(kinds: Integers, free: Reals, mu: Reals, low: Reals, m: int, x: Reals) -> None:
    """Set x to the forces of compliant contacts at ``free`` = y - r/ε."""
    for i in range(m):
        if kinds[i] == EQUALITY:
            x[i] = free[i]
        elif kinds[i] == NORMAL:
            x[i] = greater(low[i], free[i])
        elif kinds[i] == LINE:
            limit = mu[i] * greater(x[i - 1], 0.0)
            x[i] = free[i] if abs(free[i]) <= limit else (limit if free[i] > 0.0 else -limit)
        elif kinds[i] == FIRST:
            limit = mu[i] * greater(x[i - 1], 0.0)
            length = root(free[i] * free[i] + free[i + 1] * free[i + 1])
            part = 1.0 if length <= limit else limit / length
            x[i] = part * free[i]
            x[i + 1] = part * free[i + 1]


@compiled
def slopes(kinds: Integers, free: Reals, mu: Reals, low: Reals, H: Reals, m: int, n: int, G: Reals) -> None:
    """Set G (m, n) to ∂λ/∂(y - r/ε) H."""
    for i in range(m):
        for k in range(n):
            if kinds[i] == EQUALITY:
                G[i * n + k] = H[i * n + k]
            elif kinds[i] == NORMAL:
                G[i * n + k] = H[i * n + k] if free[i] > low[i] else 0.0
            elif kinds[i] == LINE:
                normal = greater(low[i - 1], free[i - 1])
                limit = mu[i] * greater(normal, 0.0)
                if abs(free[i]) <= limit:
                    G[i * n + k] = H[i * n + k]
                else:
                    G[i * n + k] = (mu[i] if free[i] > 0.0 else -mu[i]) * G[(i - 1) * n + k]
            elif kinds[i] == FIRST:
                normal = greater(low[i - 1], free[i - 1])
                limit = mu[i] * greater(normal, 0.0)
                length = root(free[i] * free[i] + free[i + 1] * free[i + 1])
                a, b = H[i * n + k], H[(i + 1) * n + k]
                if length <= limit:
                    G[i * n + k], G[(i + 1) * n + k] = a, b
                else:
                    e, f = free[i] / length, free[i + 1] / length
                    along = e * a + f * b
                    grown = mu[i] * G[(i - 1) * n + k]
                    part = limit / length
                    G[i * n + k] = part * (a - e * along) + e * grown
                    G[(i + 1) * n + k] = part * (b - f * along) + f * grown


@compiled
def missed(problem: Reals, kinds: Integers, m: int, n: int, w: Reals, rates: Reals) -> float:
    """Return the residual of λ, relative to its size: the one of `ConeProblem.residual`.

    ``w`` (n) becomes Cᵀ λ and ``rates`` (m) become r.
    """
    H, C, c = problem, shifted(problem, m * n), shifted(problem, 2 * m * n)
    mu, low, scale, x = shifted(c, m), shifted(c, 2 * m), shifted(c, 3 * m), shifted(c, 4 * m)
    for k in range(n):
        w[k] = 0.0
    worst, size = 0.0, 0.0
    for i in range(m):
        size = greater(size, greater(abs(c[i]), scale[i] * abs(low[i])))
        if not math.isfinite(x[i]):
            return math.inf
        for k in range(n):
            w[k] += C[i * n + k] * x[i]
    for i in range(m):
        rates[i] = c[i] + dot(shifted(H, i * n), w, n)
    for i in range(m):
        s, r = scale[i], rates[i]
        if kinds[i] == EQUALITY:
            worst = greater(worst, abs(r))
        elif kinds[i] == NORMAL:
            gap = s * (x[i] - low[i])
            worst = greater(worst, abs(r if r < gap else gap))
        elif kinds[i] == LINE:
            limit, free = s * mu[i] * greater(x[i - 1], 0.0), s * x[i] - r
            near = free if abs(free) <= limit else (limit if free > 0.0 else -limit)
            worst = greater(worst, abs(s * x[i] - near))
        elif kinds[i] == FIRST:
            p, q = s * x[i] - r, s * x[i + 1] - rates[i + 1]
            limit, length = s * mu[i] * greater(x[i - 1], 0.0), root(p * p + q * q)
            part = 1.0 if length <= limit else limit / length
            worst = greater(worst, greater(abs(s * x[i] - part * p), abs(s * x[i + 1] - part * q)))
    if not math.isfinite(size):
        return size
    return worst / size if size > 0.0 else 0.0


@compiled
def error(
    problem: Reals, kinds: Integers, m: int, n: int, soft: float, y: Reals, v: Reals, room: Reals
) -> float:
    """Write y - r/ε, λ and F(v) to ``room`` (2 m + n numbers); return |F|."""
    H, C, c = problem, shifted(problem, m * n), shifted(problem, 2 * m * n)
    mu, low = shifted(c, m), shifted(c, 2 * m)
    free, x, F = room, shifted(room, m), shifted(room, 2 * m)
    for i in range(m):
        free[i] = y[i] - (c[i] + dot(shifted(H, i * n), v, n)) / soft
    pressed(kinds, free, mu, low, m, x)
    for k in range(n):
        F[k] = v[k]
    for i in range(m):
        if x[i] != 0.0:
            for k in range(n):
                F[k] -= C[i * n + k] * x[i]
    return root(dot(F, F, n))


@compiled
def jacobian(C: Reals, G: Reals, m: int, n: int, soft: float, J: Reals) -> None:
    """Set J (n, n) to 1 + Cᵀ G/ε."""
    for k in range(n):
        for j in range(n):
            J[k * n + j] = 1.0 if k == j else 0.0
    for i in range(m):
        for k in range(n):
            if C[i * n + k] != 0.0:
                for j in range(n):
                    J[k * n + j] += C[i * n + k] * G[i * n + j] / soft


@compiled
def balanced(
    problem: Reals, kinds: Integers, m: int, n: int, soft: float, y: Reals, v: Reals, room: Reals
) -> int:
    """Find v with F(v) = 0 by Newton's method with shorter steps where |F| would grow; return the number of steps.

    ``room``: 2 (2 m + n) + m n + n n + 2 n numbers; its second m numbers become λ.
    """
    H, C, c = problem, shifted(problem, m * n), shifted(problem, 2 * m * n)
    mu, low = shifted(c, m), shifted(c, 2 * m)
    other = shifted(room, 2 * m + n)
    G = shifted(other, 2 * m + n)
    J = shifted(G, m * n)
    step, trial = shifted(J, n * n), shifted(J, n * n + n)
    size = error(problem, kinds, m, n, soft, y, v, room)
    kinks = 0
    for turn in range(STEPS):
        if size <= 1e-15 * root(dot(v, v, n)):
            return turn
        slopes(kinds, room, mu, low, H, m, n, G)
        for k in range(n):
            step[k] = -room[2 * m + k]
        jacobian(C, G, m, n, soft, J)
        if solved(J, n, step) == 0:
            return turn
        part, shorter = 1.0, True
        while shorter:
            for k in range(n):
                trial[k] = v[k] + part * step[k]
            new = error(problem, kinds, m, n, soft, y, trial, other)
            shorter = not new < (1.0 - 1e-4 * part) * size
            part /= 2.0
            if (
                shorter and part < SHORTEST
            ):  # a kink: |F| falls in no short step, and the slope beyond it is needed
                if size <= 1e-9 * root(dot(v, v, n)) or kinks == KINKS or not math.isfinite(new):
                    return turn
                kinks += 1
                for k in range(n):
                    trial[k] = v[k] + BEYOND * step[k]
                shorter = False
        size = error(problem, kinds, m, n, soft, y, trial, room)
        for k in range(n):
            v[k] = trial[k]
    return STEPS


@compiled
def swept(problem: Reals, kinds: Integers, m: int, n: int, w: Reals, rates: Reals) -> float:
    """Improve λ by Gauss-Seidel sweeps over the contacts until its residual is below `ROUGH`; return the residual."""
    H, C, c = problem, shifted(problem, m * n), shifted(problem, 2 * m * n)
    mu, low, scale, x = shifted(c, m), shifted(c, 2 * m), shifted(c, 3 * m), shifted(c, 4 * m)
    left = missed(problem, kinds, m, n, w, rates)
    for turn in range(SWEEPS):
        if left <= ROUGH or not math.isfinite(left):
            return left
        for i in range(m):
            if kinds[i] != SECOND:
                width = 2 if kinds[i] == FIRST else 1
                for j in range(i, i + width):
                    rates[j] = x[j] - (c[j] + dot(shifted(H, j * n), w, n)) / scale[i]
                if kinds[i] == NORMAL:
                    rates[i] = greater(low[i], rates[i])
                elif kinds[i] != EQUALITY:
                    limit, length = mu[i] * greater(x[i - 1], 0.0), abs(rates[i])
                    if width == 2:
                        length = root(rates[i] * rates[i] + rates[i + 1] * rates[i + 1])
                    if length > limit:
                        for j in range(i, i + width):
                            rates[j] *= limit / length
                for j in range(i, i + width):
                    change = rates[j] - x[j]
                    if change != 0.0:
                        for k in range(n):
                            w[k] += change * C[j * n + k]
                        x[j] = rates[j]
        if turn % 10 == 9:
            left = missed(problem, kinds, m, n, w, rates)
    return missed(problem, kinds, m, n, w, rates)


@compiled
def reach(kinds: Integers, mu: Reals, low: Reals, m: int, x: Reals, d: Reals) -> float:
    """Return the greatest factor up to which x + t d leaves every contact inside its cone; 0 if there is no limit.

    |T + t dT| = μ (N + t dN)   or   N + t dN = low; contacts on the boundary do not count.
    """
    nearest = 0.0
    for i in range(m):
        t = 0.0
        if kinds[i] == NORMAL and d[i] < 0.0 and x[i] > low[i]:
            t = (low[i] - x[i]) / d[i]
        elif kinds[i] == LINE or kinds[i] == FIRST:
            T2, d2, Td = x[i] * x[i], d[i] * d[i], x[i] * d[i]
            if kinds[i] == FIRST:
                T2 += x[i + 1] * x[i + 1]
                d2 += d[i + 1] * d[i + 1]
                Td += x[i + 1] * d[i + 1]
            limit, growth = mu[i] * x[i - 1], mu[i] * d[i - 1]
            a, h, k = d2 - growth * growth, Td - limit * growth, T2 - limit * limit
            if (
                x[i - 1] > 0.0 and k < -1e-12 * limit * limit
            ):  # the smallest positive root of a t² + 2 h t + k
                s = root(greater(h * h - a * k, 0.0))
                if h > 0.0:
                    t = -k / (h + s)
                elif a > 0.0:
                    t = (s - h) / a
        if t > 0.0 and (nearest == 0.0 or t < nearest):
            nearest = t
    return nearest


@compiled
def multiplied(
    problem: Reals, kinds: Integers, m: int, n: int, soft: float, goal: float, y: Reals, result: Reals
) -> int:
    """Improve λ from v and y by rounds of multipliers; return the number of Newton steps.

    ``result`` holds the least residual so far and the limit of the compliance. ``y`` stands with its room in the block.
    """
    c = shifted(problem, 2 * m * n)
    mu, low, x = shifted(c, m), shifted(c, 2 * m), shifted(c, 4 * m)
    best, rates, past, moved = shifted(y, m), shifted(y, 2 * m), shifted(y, 3 * m), shifted(y, 4 * m)
    v, w = shifted(y, 5 * m), shifted(y, 5 * m + n)
    work = shifted(w, n)
    for i in range(m):
        past[i], moved[i] = 0.0, 0.0
    count, idle, last = 0, 0, math.inf
    for _ in range(ROUNDS):
        count += balanced(problem, kinds, m, n, soft, y, v, work)
        for i in range(m):
            x[i] = work[m + i]
        size = missed(problem, kinds, m, n, w, rates)
        if not math.isfinite(size):
            return count
        idle += 1
        if size < result[0]:
            if size < 0.5 * result[0]:
                idle = 0
            result[0] = size
            for i in range(m):
                best[i] = x[i]
        if result[0] <= goal or (idle > IDLE and result[0] <= ENOUGH):
            return count
        square, turn = 0.0, 0.0
        for i in range(m):
            change = x[i] - past[i]
            square += change * change
            turn += (change - moved[i]) * (change - moved[i])
            moved[i] = change
        part = reach(kinds, mu, low, m, x, moved) if turn < DRIFT * DRIFT * square else 0.0
        if part == 0.0 and size > SLOW * last and soft > result[1]:
            soft /= 10.0
        for i in range(m):
            y[i] = x[i] + part * moved[i]
            past[i] = y[i]
        last = size
    return count


@compiled
def solve(problem: Reals, kinds: Integers, m: int, n: int, goal: float, result: Reals) -> int:
    """Find λ from zero; return the number of Newton steps. ``result[0]`` becomes the least residual reached.

    The ways are tried in turn until one succeeds: compliances in a few steps, in many steps, sweeps. Large problems
    begin with the last. ``result`` has two numbers.
    """
    c = shifted(problem, 2 * m * n)
    low, scale, x = shifted(c, 2 * m), shifted(c, 3 * m), shifted(c, 4 * m)
    y = shifted(x, m)
    best, rates, v = shifted(y, m), shifted(y, 2 * m), shifted(y, 5 * m)
    work = shifted(v, 2 * n)
    unit, count = 0.0, 0
    for i in range(m):
        x[i] = greater(low[i], 0.0) if kinds[i] == NORMAL else 0.0
        best[i] = x[i]
        unit += scale[i] / m
    result[0] = missed(problem, kinds, m, n, v, rates)
    for way in range(3):
        if not (result[0] > goal and math.isfinite(result[0])) or (way > 0 and result[0] <= ENOUGH):
            break
        fine = way == 1 if n <= DENSE else way == 2
        soft = SOFT * unit if fine else SOFTEST * unit
        for i in range(m):
            y[i] = 0.0
            x[i] = greater(low[i], 0.0) if kinds[i] == NORMAL else 0.0
        for k in range(n):
            v[k] = 0.0
        if (way == 0 and n > DENSE) or (way == 2 and n <= DENSE):
            swept(problem, kinds, m, n, v, rates)
            for i in range(m):
                y[i] = x[i]
            for _ in range(STAGES - 1):
                soft /= 10.0
        else:
            for stage in range(MANY if fine else STAGES):
                if stage > 0:
                    soft /= 2.0 if fine else 10.0
                count += balanced(problem, kinds, m, n, soft, y, v, work)
        result[1] = HARDEST * unit
        count += multiplied(problem, kinds, m, n, soft, goal, y, result)
        if (
            result[0] > ENOUGH
        ):  # λ that drifts on a line, along forces in balance, is seen at one compliance only
            for i in range(m):
                y[i] = 0.0
            result[1] = soft
            count += multiplied(problem, kinds, m, n, soft, goal, y, result)
    for i in range(m):
        x[i] = best[i]
    return count
