"""Goldfarb and Idnani's dual method for a contact problem without friction.

It is the least displacement that meets b + W v >= 0, a strictly convex problem of v. The method begins with v = 0 and
takes in the most violated condition, again and again: the impulses x that hold the ones taken so far stay positive, and
one that would become negative is let go. It ends after finitely many steps, also where rows depend on each other.

Source: D. Goldfarb, A. Idnani, Mathematical Programming 27 (1983) 1-33.
"""

from __future__ import annotations

import math

from ...native.instructions import compiled, hot, root
from .block_rows import add, along, block_product, dot
from .cone import add_all, residual
from .contact_problem import DEPENDENT, NORMAL, ContactProblem, Dense

CHANGES = 10
"""Limit on the conditions that the dual method takes in, for each row of the problem."""


@hot
@compiled
def lay_dense(problem: ContactProblem, dense: Dense) -> None:
    """Set A = W Xᵀ, which is symmetric."""
    blocks, m, A = problem.blocks, problem.count, dense.A
    for a in range(m):
        for c in range(a + 1):
            r, q, total = problem.rows[a], problem.rows[c], 0.0
            i = blocks.at[r]
            for p in range(blocks.first[r], blocks.first[r + 1]):
                b, j = blocks.pieces[p], blocks.at[q]
                size = blocks.starts[b + 1] - blocks.starts[b]
                for s in range(blocks.first[q], blocks.first[q + 1]):
                    other = blocks.pieces[s]
                    if other == b:
                        total += block_product(problem.W[i:], problem.X[j:], size)
                    j += blocks.starts[other + 1] - blocks.starts[other]
                i += size
            A[a * m + c] = A[c * m + a] = total


@compiled
def is_bare(problem: ContactProblem) -> int:
    """Return 1 if all rows are normals that press from zero on."""
    for a in range(problem.count):
        if problem.kinds[a] != NORMAL or problem.low[a] != 0.0:
            return 0
    return 1


@hot
@compiled
def take_in(problem: ContactProblem, dense: Dense, goal: float) -> float:
    """Set x to the solution of a problem without friction from zero, by the dual method; return its residual."""
    m, n, r, place = problem.count, 0, problem.r, dense.place
    for a in range(m):
        problem.x[a], r[a], place[a] = 0.0, problem.b[a], -1
    for k in range(problem.blocks.n):
        problem.v[k] = 0.0
    for _ in range(CHANGES * m):
        p, worst = -1, -0.5 * goal * problem.reference
        for a in range(m):
            if place[a] < 0 and r[a] < worst and dense.A[a * m + a] > 0.0:
                p, worst = a, r[a]
        if p < 0:
            break
        n = hold(problem, dense, p, n)
        if n < 0:
            return math.inf
        for a in range(m):
            r[a] = problem.b[a] + along(problem.blocks, problem.rows[a], problem.W, problem.v)
    add_all(problem)
    return residual(problem)


@hot
@compiled
def hold(problem: ContactProblem, dense: Dense, p: int, n: int) -> int:
    """Take in condition p beside the n that are held; return the new number, or -1 where none can be let go.

    Uᵀ U = A of those that are held, and A d = A_p of them.
    """
    m, A, U, d, x, among = problem.count, dense.A, dense.U, dense.entries, problem.x, dense.among
    blocks, rows, v = problem.blocks, problem.rows, problem.v
    while True:
        rest = A[p * m + p]
        for i in range(n):
            d[i] = A[p * m + among[i]]
        for i in range(n):  # sums side by side, not one after another
            row = U[i * m :]
            part = d[i] / row[i]
            for k in range(i + 1, n):
                d[k] -= part * row[k]
            d[i], row[n] = part, part
            rest -= part * part
        for i in range(n - 1, -1, -1):
            row = U[i * m :]
            d[i] = (d[i] - dot(row[i + 1 :], d[i + 1 :], n - 1 - i)) / row[i]
        far, freed = math.inf, -1
        if rest > DEPENDENT * A[p * m + p]:
            far = -(problem.b[p] + along(blocks, rows[p], problem.W, v)) / rest
        for i in range(n):
            if d[i] > 0.0 and x[among[i]] < far * d[i]:
                far, freed = x[among[i]] / d[i], i
        if not math.isfinite(far):
            return -1
        x[p] += far
        add(blocks, rows[p], problem.X, far, v)
        for i in range(n):
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
    problem.x[among[freed]] = 0.0
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
