"""Newton's method on the laws of a contact problem themselves, and Goldfarb and Idnani's where there is no friction.

    e(x) = 0 (`cone.violation`),   dx = -(JᵀJ + δ)⁻¹ Jᵀ e,   J = ∂e/∂x,   in unknowns √s x and equations e/√s

The steps are least in norm where J is singular, since forces of faces on faces are open. No length of a step is
sought, nor is a step brought back to the cones: e is defined everywhere, and a step that is cut loses what all contacts
do together. From the impulses of the last trial this takes a few steps, from zero about ten; where it does not end it
goes astray, and the best x is kept. Contacts that are open and remain so take no part in the equations.

Without friction the problem is the least displacement that meets b + W v >= 0, a strictly convex one of v. The dual
method begins with v = 0 and takes in the most violated condition, again and again: the impulses x that hold the ones
taken so far stay positive, and one that would become negative is let go. It ends after finitely many steps, also where
rows depend on each other.

Sources: L. Qi, J. Sun, Mathematical Programming 58 (1993) 353-367 (Newton's method on equations with kinks);
D. Goldfarb, A. Idnani, Mathematical Programming 27 (1983) 1-33.
"""

from __future__ import annotations

import math

from ...native.instructions import Reals, compiled, root
from .cone import add_all, bound, residual, violation_slopes
from .contact_problem import DEPENDENT, NORMAL, ContactProblem, Dense

LOOSE = 1e-13
"""δ, relative to the scaled slopes, which are about 1."""
LOST = 1e6
"""Growth of the residual that ends the search."""
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


# -- with friction ---------------------------------------------------------------------------------------


@compiled
def descend(problem: ContactProblem, dense: Dense, goal: float, most: int) -> float:
    """Improve x by up to ``most`` Newton steps on the laws; return the residual of the best, which x becomes."""
    m, least, turn = problem.count, math.inf, 0
    while True:
        add_all(problem)
        size = residual(problem)
        if size < least:
            least = size
            for a in range(m):
                dense.best[a] = problem.x[a]
        if least <= goal or turn == most or not size < LOST * least or step(problem, dense) == 0:
            break
        for a in range(m):
            problem.x[a] += dense.step[a]
        turn += 1
    for a in range(m):
        problem.x[a] = dense.best[a]
    return least


@compiled
def step(problem: ContactProblem, dense: Dense) -> int:
    """Set the step of x; return 0 if it has no value."""
    m, J, x, s, place = problem.count, dense.J, problem.x, problem.scale, dense.place
    violation_slopes(problem, dense.A, J)
    k = 0
    for a in range(m):
        shut = problem.kinds[a] == NORMAL and not s[a] * (x[a] - problem.low[a]) > problem.r[a]
        if problem.kinds[a] > NORMAL:
            shut = not x[bound(problem, a)] > 0.0
        place[a], dense.step[a] = -1, 0.0
        if s[a] > 0.0:
            if problem.kinds[a] >= NORMAL and problem.e[a] == s[a] * (x[a] - problem.low[a]) and shut:
                dense.step[a] = -(x[a] - problem.low[a])
            else:
                place[a] = k
                k += 1
    return normal_equations(problem, dense, k)


@compiled
def normal_equations(problem: ContactProblem, dense: Dense, n: int) -> int:
    """Set the step in the n unknowns that have a place, the others known; return 0 if it has no value."""
    m, N, s, place, z = problem.count, dense.N, problem.scale, dense.place, dense.right
    for i in range(n):
        z[i] = 0.0
        for j in range(i + 1):
            N[i * n + j] = LOOSE if i == j else 0.0
    for a in range(m):
        if place[a] >= 0:
            rest, count, J = problem.e[a], 0, dense.J[a * m :]
            for c in range(m):
                if J[c] != 0.0:
                    if place[c] < 0:
                        rest += J[c] * dense.step[c]
                    else:
                        dense.among[count], dense.entries[count] = place[c], J[c] / root(s[a] * s[c])
                        count += 1
            for p in range(count):
                i, part = dense.among[p], dense.entries[p]
                z[i] -= part * rest / root(s[a])
                row = N[i * n :]
                for q in range(p + 1):
                    row[dense.among[q]] += part * dense.entries[q]
    if resolved(N, n, z) == 0:
        return 0
    for a in range(m):
        if place[a] >= 0:
            dense.step[a] = z[place[a]] / root(s[a])
    return 1


@compiled
def resolved(N: Reals, n: int, z: Reals) -> int:
    """Replace z by N⁻¹ z for a positive definite N, of which the lower half is given; return 0 if it is not."""
    for i in range(n):
        row = N[i * n :]
        for j in range(i + 1):
            other, total = N[j * n :], row[j]
            for k in range(j):
                total -= row[k] * other[k]
            if i == j:
                if not total > 0.0:
                    return 0
                row[j] = root(total)
            else:
                row[j] = total / other[j]
        for k in range(i):
            z[i] -= row[k] * z[k]
        z[i] /= row[i]
    for i in range(n - 1, -1, -1):
        z[i] /= N[i * n + i]
        row = N[i * n :]
        for k in range(i):
            z[k] -= row[k] * z[i]
    return 1


# -- without friction ------------------------------------------------------------------------------------


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
