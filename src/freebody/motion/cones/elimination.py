"""Linear equations in compiled code: of a few unknowns, and of unknowns in blocks of which few share an equation."""

from __future__ import annotations

import math

from ...native.instructions import Integers, Reals, compiled, hot
from .block_rows import block_add, block_add_three
from .contact_problem import NORMAL, SECOND, Blocks, ContactProblem, Newton


@compiled
def pivot(a: Reals, n: int, k: int, end: int) -> int:
    """Return the row of the greatest entry of column k, from row k to row ``end`` - 1; -1 if that is no pivot."""
    p = k
    for i in range(k + 1, end):
        if abs(a[i * n + k]) > abs(a[p * n + k]):
            p = i
    return p if a[p * n + k] != 0.0 and math.isfinite(a[p * n + k]) else -1


@compiled
def exchange(a: Reals, n: int, k: int, p: int, end: int) -> None:
    """Exchange rows k and p, from column k to column ``end`` - 1."""
    for j in range(k, end):
        kept = a[k * n + j]
        a[k * n + j] = a[p * n + j]
        a[p * n + j] = kept


@compiled
def solved(a: Reals, n: int, b: Reals) -> int:
    """Replace b by a⁻¹ b by elimination with row exchanges; overwrite a. Return 0 if a is singular, else 1."""
    for k in range(n):
        p = pivot(a, n, k, n)
        if p < 0:
            return 0
        if p != k:
            exchange(a, n, k, p, n)
            exchanged = b[k]
            b[k] = b[p]
            b[p] = exchanged
        for i in range(k + 1, n):
            part = a[i * n + k] / a[k * n + k]
            if part != 0.0:
                for j in range(k + 1, n):
                    a[i * n + j] -= part * a[k * n + j]
                b[i] -= part * b[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            b[k] -= a[k * n + j] * b[j]
        b[k] /= a[k * n + k]
    return 1


@hot
@compiled
def factored(a: Reals, blocks: Blocks, ends: Integers, order: Integers) -> int:
    """Replace a by factors of it, with row exchanges inside blocks; return 0 if it is singular, else 1.

    Row and column k of a block b have no entries between them and ``ends[b]`` onwards, before and after elimination.
    """
    n = blocks.n
    for b in range(blocks.count):
        end = ends[b]
        for k in range(blocks.starts[b], blocks.starts[b + 1]):
            p = pivot(a, n, k, blocks.starts[b + 1])
            if p < 0:
                return 0
            order[k] = p
            if p != k:
                exchange(a, n, k, p, end)
            inverse, above = 1.0 / a[k * n + k], a[k * n :]
            for i in range(k + 1, end):
                part, row = a[i * n + k] * inverse, a[i * n :]
                row[k] = part
                if part != 0.0:
                    for j in range(k + 1, end):
                        row[j] -= part * above[j]
    return 1


@hot
@compiled
def substitute(a: Reals, blocks: Blocks, ends: Integers, order: Integers, x: Reals) -> None:
    """Replace x by the solution of the equations with this right side, by the factors that `factored` left."""
    n = blocks.n
    for b in range(blocks.count):
        for k in range(blocks.starts[b], blocks.starts[b + 1]):
            p = order[k]
            exchanged = x[p]
            x[p] = x[k]
            x[k] = exchanged
            for i in range(k + 1, ends[b]):
                x[i] -= a[i * n + k] * exchanged
    for c in range(blocks.count):
        b = blocks.count - 1 - c
        for h in range(blocks.starts[b + 1] - blocks.starts[b]):
            k = blocks.starts[b + 1] - 1 - h
            total, row = x[k], a[k * n :]
            for j in range(k + 1, ends[b]):
                total -= row[j] * x[j]
            x[k] = total / row[k]


@hot
@compiled
def jacobian(problem: ContactProblem, G: Reals, memory: Newton) -> None:
    """Set J to 1 + Cᵀ G, G stored as the rows of the problem, and the ends of its blocks."""
    blocks, n, J, ends = problem.blocks, problem.blocks.n, memory.J[0], memory.ends
    for b in range(blocks.count):
        ends[b] = blocks.starts[b + 1]
    for a in range(problem.count):
        r = problem.rows[a]
        for p in range(blocks.first[r], blocks.first[r + 1]):
            for q in range(blocks.first[r], blocks.first[r + 1]):
                one, end = blocks.pieces[p], blocks.starts[blocks.pieces[q] + 1]
                if end > ends[one]:
                    ends[one] = end
    for b in range(blocks.count):
        if b > 0 and ends[b - 1] > ends[b]:
            ends[b] = ends[b - 1]
        for k in range(blocks.starts[b], blocks.starts[b + 1]):
            for j in range(blocks.starts[b], ends[b]):
                J[k * n + j] = 0.0
                J[j * n + k] = 0.0
            J[k * n + k] = 1.0
    a = 0
    while a < problem.count:
        size = (
            3
            if a + 2 < problem.count and problem.kinds[a] == NORMAL and problem.kinds[a + 2] == SECOND
            else 1
        )
        spread(problem, a, size, G, J)
        a += size


@hot
@compiled
def spread(problem: ContactProblem, a: int, rows: int, G: Reals, J: Reals) -> None:
    """Add the part of row ``a`` to J, or of the three ``rows`` of a contact from there on, if it is not zero."""
    blocks, n, r, acts, X = problem.blocks, problem.blocks.n, problem.rows[a], 0, problem.X
    i = blocks.at[r]
    step = blocks.at[r + 1] - i
    for k in range(i, i + rows * step):
        acts = 1 if G[k] != 0.0 else acts
    for p in range(blocks.first[r], blocks.first[r + 1] if acts == 1 else blocks.first[r]):
        for k in range(blocks.starts[blocks.pieces[p]], blocks.starts[blocks.pieces[p] + 1]):
            row, j = J[k * n :], blocks.at[r]
            for q in range(blocks.first[r], blocks.first[r + 1]):
                begin = blocks.starts[blocks.pieces[q]]
                size = blocks.starts[blocks.pieces[q] + 1] - begin
                if rows == 3:
                    block_add_three(row[begin:], X, i, G[j:], step, size)
                else:
                    block_add(row[begin:], X[i], G[j:], size)
                j += size
            i += 1
