"""Linear equations in compiled code: of a few unknowns, and of unknowns in blocks of which few share an equation."""

from __future__ import annotations

import math

from ...native.instructions import Integers, Reals, compiled, hot, inlined
from .block_rows import BODY, block_add, block_product, dot
from .cone import joined
from .contact_problem import Blocks, ContactProblem, Newton


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
        first, last, end = blocks.starts[b], blocks.starts[b + 1], ends[b]
        for k in range(first, last):
            p = pivot(a, n, k, last)
            if p < 0:
                return 0
            order[k] = p
            if p != k:
                exchange(a, n, k, p, end)
            inverse, above = 1.0 / a[k * n + k], a[k * n :]
            for i in range(k + 1, last):
                part, row = a[i * n + k] * inverse, a[i * n :]
                row[k] = part
                if part != 0.0:
                    for j in range(k + 1, end):
                        row[j] -= part * above[j]
        if last - first == BODY:
            eliminate_six(a[first * n :], n, first, end)
        else:
            for i in range(last, end):
                eliminate(a[i * n :], a[first * n :], n, first, last, end)
    return 1


@inlined
def eliminate(row: Reals, block: Reals, n: int, first: int, last: int, end: int) -> None:
    """Take the columns of a block from a row below it, by the rows of the block; keep the multiples in their place."""
    for k in range(first, last):
        above = block[(k - first) * n :]
        part = row[k] / above[k]
        row[k] = part
        if part != 0.0:
            for j in range(k + 1, end):
                row[j] -= part * above[j]


@inlined
def eliminate_six(block: Reals, n: int, first: int, end: int) -> None:
    """Do the same for all rows below a block of six: each number of a row is read and written once."""
    a, b, c, d, e, f = (
        block[first:],
        block[n + first :],
        block[2 * n + first :],
        block[3 * n + first :],
        block[4 * n + first :],
        block[5 * n + first :],
    )
    a_0, b_1, c_2, d_3, e_4, f_5 = 1.0 / a[0], 1.0 / b[1], 1.0 / c[2], 1.0 / d[3], 1.0 / e[4], 1.0 / f[5]
    a_1, a_2, a_3, a_4, a_5 = a[1], a[2], a[3], a[4], a[5]
    b_2, b_3, b_4, b_5, c_3, c_4, c_5 = b[2], b[3], b[4], b[5], c[3], c[4], c[5]
    d_4, d_5, e_5 = d[4], d[5], e[5]
    for i in range(BODY, end - first):
        row = block[i * n + first :]
        p = row[0] * a_0
        q = (row[1] - p * a_1) * b_1
        r = (row[2] - p * a_2 - q * b_2) * c_2
        s = (row[3] - p * a_3 - q * b_3 - r * c_3) * d_3
        t = (row[4] - p * a_4 - q * b_4 - r * c_4 - s * d_4) * e_4
        u = (row[5] - p * a_5 - q * b_5 - r * c_5 - s * d_5 - t * e_5) * f_5
        row[0], row[1], row[2], row[3], row[4], row[5] = p, q, r, s, t, u
        if p != 0.0 or q != 0.0 or r != 0.0 or s != 0.0 or t != 0.0 or u != 0.0:
            for j in range(BODY, end - first):
                row[j] -= (p * a[j] + q * b[j]) + (r * c[j] + s * d[j]) + (t * e[j] + u * f[j])


@hot
@compiled
def substitute(a: Reals, blocks: Blocks, ends: Integers, order: Integers, x: Reals) -> None:
    """Replace x by the solution of the equations with this right side, by the factors that `factored` left."""
    n = blocks.n
    for b in range(blocks.count):
        first, last = blocks.starts[b], blocks.starts[b + 1]
        for k in range(first, last):
            p = order[k]
            exchanged = x[p]
            x[p] = x[k]
            x[k] = exchanged
            for i in range(k + 1, last):
                x[i] -= a[i * n + k] * exchanged
        for i in range(last, ends[b]):
            x[i] -= block_product(a[i * n + first :], x[first:], last - first)
    for c in range(blocks.count):
        b = blocks.count - 1 - c
        for h in range(blocks.starts[b + 1] - blocks.starts[b]):
            k = blocks.starts[b + 1] - 1 - h
            row = a[k * n :]
            x[k] = (x[k] - dot(row[k + 1 :], x[k + 1 :], ends[b] - 1 - k)) / row[k]


@hot
@compiled
def jacobian(problem: ContactProblem, G: Reals, memory: Newton) -> None:
    """Set J to 1 + Cᵀ G, G stored as the rows of the problem, and the ends of its blocks."""
    blocks, n, J, ends, far = problem.blocks, problem.blocks.n, memory.J[0], memory.ends, 0
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
        while ends[far] <= blocks.starts[b]:
            far += 1
        for k in range(blocks.starts[b], blocks.starts[b + 1]):
            row = J[k * n :]
            for j in range(blocks.starts[far], ends[b]):
                row[j] = 0.0
            row[k] = 1.0
    a = 0
    while a < problem.count:
        size = joined(problem, a)
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
    at_p = i
    for p in range(blocks.first[r], blocks.first[r + 1] if acts == 1 else blocks.first[r]):
        over = blocks.starts[blocks.pieces[p]]
        height = blocks.starts[blocks.pieces[p] + 1] - over
        at_q = i
        for q in range(blocks.first[r], blocks.first[r + 1]):
            begin = blocks.starts[blocks.pieces[q]]
            size = blocks.starts[blocks.pieces[q] + 1] - begin
            place = J[over * n + begin :]
            if rows == 3:
                square_add(place, n, X[at_p:], G[at_q:], step, height, size)
            else:
                for k in range(height):
                    block_add(place[k * n :], X[at_p + k], G[at_q:], size)
            at_q += size
        at_p += height


@inlined
def square_add(J: Reals, n: int, x: Reals, c: Reals, step: int, height: int, size: int) -> None:
    """Add Σ x cᵀ of three rows to a block of J; the rows stand ``step`` apart."""
    y, z, d, e = x[step:], x[2 * step :], c[step:], c[2 * step :]
    if size == BODY:
        c_0, c_1, c_2, c_3, c_4, c_5 = c[0], c[1], c[2], c[3], c[4], c[5]
        d_0, d_1, d_2, d_3, d_4, d_5 = d[0], d[1], d[2], d[3], d[4], d[5]
        e_0, e_1, e_2, e_3, e_4, e_5 = e[0], e[1], e[2], e[3], e[4], e[5]
        for k in range(height):  # c, d and e stay in registers
            p, q, r, row = x[k], y[k], z[k], J[k * n :]
            row[0], row[1], row[2], row[3] = (
                row[0] + p * c_0 + q * d_0 + r * e_0,
                row[1] + p * c_1 + q * d_1 + r * e_1,
                row[2] + p * c_2 + q * d_2 + r * e_2,
                row[3] + p * c_3 + q * d_3 + r * e_3,
            )
            row[4], row[5] = row[4] + p * c_4 + q * d_4 + r * e_4, row[5] + p * c_5 + q * d_5 + r * e_5
    else:
        for k in range(height):
            for j in range(size):
                J[k * n + j] += x[k] * c[j] + y[k] * d[j] + z[k] * e[j]
