"""Goldfarb and Idnani's dual method for a contact problem without friction.

It is the least displacement that meets b + W v >= 0, a strictly convex problem of v. The method begins with the
conditions that press already, less those that would have to pull, and takes in the most violated condition, again and
again: the impulses x that hold the ones taken so far stay positive, and one that would become negative is let go. It
ends after finitely many steps, also where rows depend on each other.

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
                        for k in range(size):
                            total += problem.W[i + k] * problem.X[j + k]
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


@compiled
def take_in(problem: ContactProblem, dense: Dense, goal: float) -> float:
    """Set x to the solution of a problem without friction, by the dual method; return its residual.

    The rows whose x is positive are held at the start.
    """
    m, r, place, n = problem.count, dense.right, dense.place, pressing(problem, dense)
    for a in range(m):
        r[a] = problem.b[a]
        for i in range(n):
            r[a] += dense.A[a * m + dense.among[i]] * problem.x[dense.among[i]]
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
def factor(dense: Dense, m: int, p: int, n: int) -> float:
    """Set row n of the factor to that of row p of A; return the square of its diagonal entry, which is not set."""
    A, L = dense.A, dense.N
    rest, row = A[p * m + p], L[n * m :]
    for i in range(n):
        total, other = A[p * m + dense.among[i]], L[i * m :]
        for k in range(i):
            total -= other[k] * row[k]
        row[i] = total / other[i]
        rest -= row[i] * row[i]
    return rest


@compiled
def pressing(problem: ContactProblem, dense: Dense) -> int:
    """Hold the conditions whose impulses are positive, without those that depend on others or would have to pull; set
    x and return their number.
    """
    m, L, y, x, place, n, pull = problem.count, dense.N, dense.entries, problem.x, dense.place, 0, 1
    for a in range(m):
        if x[a] > 0.0:
            dense.among[n] = a
            n += 1
        x[a], place[a] = 0.0, -1
    while pull != 0:
        count, pull = 0, 0
        for i in range(n):
            p = dense.among[i]
            rest = factor(dense, m, p, count)
            if rest > DEPENDENT * dense.A[p * m + p]:
                L[count * m + count], dense.among[count] = root(rest), p
                count += 1
        n = count
        for i in range(n):
            y[i] = -problem.b[dense.among[i]]
            for k in range(i):
                y[i] -= L[i * m + k] * y[k]
            y[i] /= L[i * m + i]
        count = 0
        for i in range(n - 1, -1, -1):
            y[i] /= L[i * m + i]
            for k in range(i):
                y[k] -= L[i * m + k] * y[i]
        for i in range(n):
            if y[i] > 0.0:
                dense.among[count] = dense.among[i]
                y[count] = y[i]
                count += 1
        n, pull = count, 1 if count < n else 0
    for i in range(n):
        x[dense.among[i]], place[dense.among[i]] = y[i], i
    return n


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
        rest = factor(dense, m, p, n)
        for i in range(n):
            d[i] = L[n * m + i]
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
    m = problem.count
    problem.x[dense.among[freed]] = 0.0
    dense.place[dense.among[freed]] = -1
    for i in range(freed, n - 1):
        dense.among[i] = dense.among[i + 1]
        dense.place[dense.among[i]] = i
        dense.N[i * m + i] = root(factor(dense, m, dense.among[i], i))
    return n - 1
