"""Goldfarb and Idnani's dual method for a contact problem without friction.

It is the least displacement that meets b + W v >= 0, a strictly convex problem of v; contacts that may pull to x = low
have their pull from the beginning. The method begins with x = low and takes in conditions that are violated most, again
and again: the impulses that hold the ones taken so far stay above low, and one that would fall below is let go. It ends
after finitely many steps, also where rows depend on each other.

Any set that presses is a beginning: rows with x > 0 in the guess are held at once, or those that were held at the end
of the last problem with the same rows, by its factor. Those that would fall below low are let go until none does.

Source: D. Goldfarb, A. Idnani, Mathematical Programming 27 (1983) 1-33.
"""

from __future__ import annotations

import math

from ...native.instructions import Integers, Reals, compiled, hot, inlined, lesser, muladd, root
from .block_rows import add, along, block_product, dot, wipe
from .cone import add_all, rate, residual
from .contact_problem import DEPENDENT, NORMAL, Blocks, ContactProblem, Dense

CHANGES = 10
"""Limit on the conditions that the dual method takes in, for each row of the problem."""
NEARLY = 0.5
"""Part of the greatest violation from which on conditions are taken in before all are looked at again."""


@compiled
def is_bare(problem: ContactProblem) -> int:
    """Return 1 if all rows are normals, that press from zero or from a pull on."""
    for a in range(problem.count):
        if problem.kinds[a] != NORMAL or problem.low[a] > 0.0:
            return 0
    return 1


@hot
@compiled
def take_in(problem: ContactProblem, dense: Dense, goal: float, factored: int) -> float:
    """Set x to the solution of a problem without friction, by the dual method; return its residual.

    The rows with x > 0 are held first; if ``factored`` is 1, those of the last problem, which had the same rows.
    """
    m, r, place, small = problem.count, problem.r, dense.place, 0.5 * goal * problem.reference
    if factored == 0:
        hold_first(problem, dense)
    n = begin(problem, dense)
    for _ in range(CHANGES * m):
        worst = -small
        for a in range(m):
            r[a] = rate(problem, a) if place[a] < 0 and problem.scale[a] > 0.0 else 0.0
            worst = lesser(worst, r[a])
        if worst == -small:
            break
        for a in range(m):
            if r[a] <= NEARLY * worst and place[a] < 0 and rate(problem, a) <= NEARLY * worst:
                n = hold(problem, dense, a, n)
                if n < 0:
                    return math.inf
    dense.held = n
    add_all(problem)
    return residual(problem)


@hot
@compiled
def hold_first(problem: ContactProblem, dense: Dense) -> None:
    """Hold the rows with x > 0 that do not depend on each other."""
    m, n = problem.count, 0
    for k in range(problem.blocks.n):
        dense.w[k] = 0.0
    for a in range(m):
        dense.place[a] = -1
        if problem.x[a] > 0.0:
            rest = beside(problem, dense, a, n)
            if rest > DEPENDENT * problem.scale[a]:
                dense.U[n * m + n], dense.among[n], dense.place[a] = root(rest), a, n
                n += 1
    dense.held = n


@hot
@compiled
def begin(problem: ContactProblem, dense: Dense) -> int:
    """Let go the rows that do not press beside the others; return the number of those held. Others have x = low."""
    n, among, d, x, r = dense.held, dense.among, dense.entries, problem.x, problem.r
    for a in range(problem.count):
        x[a] = problem.low[a]
    add_all(problem)
    for i in range(n):
        r[among[i]] = rate(problem, among[i])
    while shut(problem, dense, n) > 0:
        for i in range(n - 1, -1, -1):
            if d[i] < 0.0:
                n = let_go(problem, dense, i, n)
    for i in range(n):
        x[among[i]] += d[i]
    add_all(problem)
    return n


@compiled
def shut(problem: ContactProblem, dense: Dense, n: int) -> int:
    """Set d to the impulses that take their rates r from the n rows that are held; return the number of pulls."""
    m, d, U, pulls = problem.count, dense.entries, dense.U, 0
    for i in range(n):
        d[i] = -problem.r[dense.among[i]]
    for i in range(n):
        row = U[i * m :]
        d[i] /= row[i]
        for k in range(i + 1, n):
            d[k] = muladd(-d[i], row[k], d[k])
    back(dense, m, n)
    for i in range(n):
        pulls += 1 if d[i] < 0.0 else 0
    return pulls


@hot
@compiled
def back(dense: Dense, m: int, n: int) -> None:
    """Set d to U⁻¹ d, for the n rows that are held."""
    d = dense.entries
    for i in range(n - 1, -1, -1):
        row = dense.U[i * m :]
        d[i] = (d[i] - dot(row[i + 1 :], d[i + 1 :], n - 1 - i)) / row[i]


@hot
@compiled
def beside(problem: ContactProblem, dense: Dense, p: int, n: int) -> float:
    """Set d and column n of U to those of condition p beside n that are held; return the rest of its diagonal.

    Uᵀ U = A of those that are held, and Uᵀ d = A_p of them.
    """
    blocks, rows, m, U, d, w = problem.blocks, problem.rows, problem.count, dense.U, dense.entries, dense.w
    add(blocks, rows[p], problem.W, 1.0, w)
    rest = along(blocks, rows[p], problem.X, w)
    for k in range(blocks.first[rows[p]], blocks.first[rows[p] + 1]):
        dense.beside[blocks.pieces[k]] = 1
    for i in range(n):
        d[i] = shared(blocks, rows[dense.among[i]], problem.X, w, dense.beside)
    for k in range(blocks.first[rows[p]], blocks.first[rows[p] + 1]):
        dense.beside[blocks.pieces[k]] = 0
    wipe(blocks, rows[p], w)
    for i in range(n):  # sums side by side, not one after another
        row = U[i * m :]
        part = d[i] / row[i]
        if part != 0.0:
            for k in range(i + 1, n):
                d[k] = muladd(-part, row[k], d[k])
        d[i], row[n] = part, part
        rest -= part * part
    return rest


@inlined
def shared(blocks: Blocks, r: int, X: Reals, w: Reals, among: Integers) -> float:
    """Return X_r w, where w is zero but for some blocks."""
    total, k = 0.0, blocks.at[r]
    for p in range(blocks.first[r], blocks.first[r + 1]):
        b = blocks.pieces[p]
        n = blocks.starts[b + 1] - blocks.starts[b]
        if among[b] != 0:
            total += block_product(X[k:], w[blocks.starts[b] :], n)
        k += n
    return total


@hot
@compiled
def hold(problem: ContactProblem, dense: Dense, p: int, n: int) -> int:
    """Take in condition p beside the n that are held; return the new number, or -1 where none can be let go."""
    m, U, d, x, low, among = problem.count, dense.U, dense.entries, problem.x, problem.low, dense.among
    blocks, rows, v = problem.blocks, problem.rows, problem.v
    while True:
        rest = beside(problem, dense, p, n)
        back(dense, m, n)
        far, freed = math.inf, -1
        if rest > DEPENDENT * problem.scale[p]:
            far = -(problem.b[p] + along(blocks, rows[p], problem.W, v)) / rest
        for i in range(n):
            if d[i] > 0.0 and x[among[i]] - low[among[i]] < far * d[i]:
                far, freed = (x[among[i]] - low[among[i]]) / d[i], i
        if not math.isfinite(far):
            return -1
        x[p] += far
        add(blocks, rows[p], problem.X, far, v)
        for i in range(n):
            if d[i] != 0.0:
                x[among[i]] -= far * d[i]
                add(blocks, rows[among[i]], problem.X, -far * d[i], v)
        if freed < 0:
            U[n * m + n] = root(rest)
            among[n], dense.place[p] = p, n
            return n + 1
        n = let_go(problem, dense, freed, n)


@hot
@compiled
def let_go(problem: ContactProblem, dense: Dense, freed: int, n: int) -> int:
    """Let one of n conditions go, and its column of U: rotations of two rows make the rest a triangle again."""
    m, U, among = problem.count, dense.U, dense.among
    problem.x[among[freed]] = problem.low[among[freed]]
    dense.place[among[freed]] = -1
    for j in range(freed, n - 1):
        among[j] = among[j + 1]
        dense.place[among[j]] = j
    for i in range(n):
        for j in range(freed if freed > i - 1 else i - 1, n - 1):
            U[i * m + j] = U[i * m + j + 1]
    for j in range(freed, n - 1):
        upper, lower = U[j * m :], U[(j + 1) * m :]
        size = root(upper[j] * upper[j] + lower[j] * lower[j])
        c, s = upper[j] / size, lower[j] / size
        for k in range(j, n - 1):
            kept = upper[k]
            upper[k] = c * kept + s * lower[k]
            lower[k] = c * lower[k] - s * kept
    return n - 1
