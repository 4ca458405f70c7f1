"""Goldfarb and Idnani's dual method for a contact problem without friction.

It is the least displacement that meets b + W v >= 0, a strictly convex problem of v. The method begins with v = 0 and
takes in the most violated condition, again and again: the impulses x that hold the ones taken so far stay positive, and
one that would become negative is let go. It ends after finitely many steps, also where rows depend on each other.

Source: D. Goldfarb, A. Idnani, Mathematical Programming 27 (1983) 1-33.
"""

from __future__ import annotations

import math

from ...native.instructions import compiled, root
from .cone import add_all, residual
from .contact_problem import DEPENDENT, NORMAL, ContactProblem, Dense

CHANGES = 10
"""Limit on the conditions that the dual method takes in, for each row of the problem."""


@compiled
def lay_dense(problem: ContactProblem, dense: Dense) -> None:
    """Set A = W Xᵀ."""
    blocks, m, A = problem.blocks, problem.count, dense.A
    for a in range(m):
        for c in range(m):
            r, q, total = problem.rows[a], problem.rows[c], 0.0
            i = blocks.at[r]
            for p in range(blocks.first[r], blocks.first[r + 1]):
                b, j = blocks.pieces[p], blocks.at[q]
                size = blocks.starts[b + 1] - blocks.starts[b]
                for s in range(blocks.first[q], blocks.first[q + 1]):
                    other = blocks.pieces[s]
                    if other == b:
                        for k in range(size):
                            total += problem.W[i + k] * problem.X[j + k]
                    j += blocks.starts[other + 1] - blocks.starts[other]
                i += size
            A[a * m + c] = total


@compiled
def is_bare(problem: ContactProblem) -> int:
    """Return 1 if all rows are normals that press from zero on."""
    for a in range(problem.count):
        if problem.kinds[a] != NORMAL or problem.low[a] != 0.0:
            return 0
    return 1


@compiled
def take_in(problem: ContactProblem, dense: Dense, goal: float) -> float:
    """Set x to the solution of a problem without friction from zero, by the dual method; return its residual."""
    m, n, r, place = problem.count, 0, dense.right, dense.place
    for a in range(m):
        problem.x[a], r[a], place[a] = 0.0, problem.b[a], -1
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
    add_all(problem)
    return residual(problem)


@compiled
def hold(problem: ContactProblem, dense: Dense, p: int, n: int) -> int:
    """Take in condition p beside the n that are held; return the new number, or -1 where none can be let go."""
    m, A, L, d, x, r, place = (
        problem.count,
        dense.A,
        dense.N,
        dense.entries,
        problem.x,
        dense.right,
        dense.place,
    )
    while True:
        rest = A[p * m + p]
        for i in range(n):
            total, row = A[dense.among[i] * m + p], L[i * m :]
            for k in range(i):
                total -= row[k] * d[k]
            d[i] = total / row[i]
            rest -= d[i] * d[i]
            L[n * m + i] = d[i]
        for i in range(n - 1, -1, -1):
            d[i] /= L[i * m + i]
            for k in range(i):
                d[k] -= L[i * m + k] * d[i]
        far, freed = math.inf, -1
        if rest > DEPENDENT * A[p * m + p]:
            far = -r[p] / rest
        for i in range(n):
            if d[i] > 0.0 and x[dense.among[i]] < far * d[i]:
                far, freed = x[dense.among[i]] / d[i], i
        if not math.isfinite(far):
            return -1
        x[p] += far
        for i in range(n):
            x[dense.among[i]] -= far * d[i]
        for a in range(m):
            total = A[a * m + p]
            for i in range(n):
                total -= A[a * m + dense.among[i]] * d[i]
            r[a] += far * total
        if freed < 0:
            L[n * m + n] = root(rest)
            dense.among[n], place[p] = p, n
            return n + 1
        n = let_go(problem, dense, freed, n)


@compiled
def let_go(problem: ContactProblem, dense: Dense, freed: int, n: int) -> int:
    """Let one of n conditions go, and factor the matrix of the rest; return their number."""
    m, A, L = problem.count, dense.A, dense.N
    problem.x[dense.among[freed]] = 0.0
    dense.place[dense.among[freed]] = -1
    for i in range(freed, n - 1):
        dense.among[i] = dense.among[i + 1]
        dense.place[dense.among[i]] = i
        for j in range(i + 1):
            total = A[dense.among[i] * m + dense.among[j]]
            for k in range(j):
                total -= L[i * m + k] * L[j * m + k]
            L[i * m + j] = root(total) if i == j else total / L[j * m + j]
    return n - 1
