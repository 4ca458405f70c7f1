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
    """Add row p of A to the factor R of A = Rᵀ R, as column n; return the square of its diagonal entry, which is not
    set. The column stays in ``entries``.
    """
    R, d, rest = dense.N, dense.entries, dense.A[p * m + p]
    for i in range(n):
        d[i] = dense.A[p * m + dense.among[i]]
    for i in range(n):
        row = R[i * m :]
        d[i] /= row[i]
        for k in range(i + 1, n):
            d[k] -= row[k] * d[i]
        row[n] = d[i]
        rest -= d[i] * d[i]
    return rest


@compiled
def back(dense: Dense, m: int, n: int) -> None:
    """Solve R y = d in place of ``entries``."""
    R, d = dense.N, dense.entries
    for i in range(n - 1, -1, -1):
        row = R[i * m :]
        for k in range(i + 1, n):
            d[i] -= row[k] * d[k]
        d[i] /= row[i]


@compiled
def pressing(problem: ContactProblem, dense: Dense) -> int:
    """Hold the conditions whose impulses are positive, less those that would have to pull; set x and the rates, and
    return their number.
    """
    n, held = 0, -1
    for a in range(problem.count):
        if problem.x[a] > 0.0:
            dense.among[n] = a
            n += 1
    while held != n:
        held = press_together(problem, dense, n)
        n = 0
        for i in range(held):
            if problem.x[dense.among[i]] > 0.0:
                dense.among[n] = dense.among[i]
                n += 1
    return n


@compiled
def press_together(problem: ContactProblem, dense: Dense, n: int) -> int:
    """Set x so that n conditions are met as equations, without those that depend on others; return their number."""
    m, R, d, count = problem.count, dense.N, dense.entries, 0
    for i in range(n):
        p = dense.among[i]
        rest = factor(dense, m, p, count)
        if rest > DEPENDENT * dense.A[p * m + p]:
            R[count * m + count], dense.among[count] = root(rest), p
            count += 1
    for a in range(m):
        problem.x[a], dense.right[a], dense.place[a] = 0.0, problem.b[a], -1
    for i in range(count):
        d[i] = -problem.b[dense.among[i]]
    for i in range(count):
        row = R[i * m :]
        d[i] /= row[i]
        for k in range(i + 1, count):
            d[k] -= row[k] * d[i]
    back(dense, m, count)
    for i in range(count):
        p = dense.among[i]
        problem.x[p], dense.place[p] = d[i], i
        change(problem, dense, p, d[i])
    return count


@compiled
def hold(problem: ContactProblem, dense: Dense, p: int, n: int) -> int:
    """Take in condition p beside the n that are held; return the new number, or -1 where none can be let go."""
    m, A, d, x, r, place = problem.count, dense.A, dense.entries, problem.x, dense.right, dense.place
    while True:
        rest = factor(dense, m, p, n)
        back(dense, m, n)
        far, freed = math.inf, -1
        if rest > DEPENDENT * A[p * m + p]:
            far = -r[p] / rest
        for i in range(n):
            if d[i] > 0.0 and x[dense.among[i]] < far * d[i]:
                far, freed = x[dense.among[i]] / d[i], i
        if not math.isfinite(far):
            return -1
        x[p] += far
        change(problem, dense, p, far)
        for i in range(n):
            x[dense.among[i]] -= far * d[i]
            change(problem, dense, dense.among[i], -far * d[i])
        if freed < 0:
            dense.N[n * m + n] = root(rest)
            dense.among[n], place[p] = p, n
            return n + 1
        n = let_go(problem, dense, freed, n)


@compiled
def change(problem: ContactProblem, dense: Dense, p: int, x: float) -> None:
    """Change the rates by what an impulse of condition p does."""
    r, row = dense.right, dense.A[p * problem.count :]
    for a in range(problem.count):
        r[a] += row[a] * x


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
