"""Linear equations in compiled code: of a few unknowns, and of unknowns in blocks of which few share an equation."""

from __future__ import annotations

import math

from ...native.instructions import Integers, Reals, compiled, hot, inlined, muladd
from .block_rows import BODY, block_add, block_product, three_added, three_taken
from .cone import joined
from .contact_problem import Blocks, ContactProblem, Links, Newton


@compiled
def pivot(a: Reals, n: int, k: int, end: int) -> int:
    """Return the row of the greatest entry of column k, from row k to row ``end`` - 1; -1 if that is no pivot."""
    p = k
    for i in range(k + 1, end):
        if abs(a[i * n + k]) > abs(a[p * n + k]):
            p = i
    return p if a[p * n + k] != 0.0 and math.isfinite(a[p * n + k]) else -1


@compiled
def exchange(a: Reals, n: int, k: int, p: int, begin: int, end: int) -> None:
    """Exchange rows k and p, from column ``begin`` to column ``end`` - 1."""
    for j in range(begin, end):
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
            exchange(a, n, k, p, k, n)
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
def factored(a: Reals, blocks: Blocks, links: Links, order: Integers) -> int:
    """Replace a by factors of it, with row exchanges inside blocks; return 0 if it is singular, else 1.

    Rows and columns of a block have entries in it and in the blocks that are linked with it, before and after
    elimination (`fill_in`).
    """
    n, starts = blocks.n, blocks.starts
    for b in range(blocks.count):
        first, last, linked, count = (
            starts[b],
            starts[b + 1],
            links.blocks[b * blocks.count :],
            links.later[b],
        )
        if divided(a, n, first, last, order) == 0:
            return 0
        for h in range(count):
            c = linked[h]
            for k in range(first, last):
                above = a[k * n :]
                if order[k] != k:
                    exchange(a, n, k, order[k], starts[c], starts[c + 1])
                for i in range(k + 1, last):
                    block_add(
                        a[i * n + starts[c] :], -a[i * n + k], above[starts[c] :], starts[c + 1] - starts[c]
                    )
        for h in range(count):
            for i in range(starts[linked[h]], starts[linked[h] + 1]):
                if last - first == BODY:
                    eliminate_six(a[i * n :], a[first * n :], n, first, starts, linked, count)
                else:
                    eliminate(a[i * n :], a[first * n :], n, first, last, starts, linked, count)
    return 1


@hot
@compiled
def divided(a: Reals, n: int, first: int, last: int, order: Integers) -> int:
    """Replace a block on the diagonal by its factors, with inverse pivots; return 0 if it is singular, else 1."""
    for k in range(first, last):
        p = pivot(a, n, k, last)
        if p < 0:
            return 0
        order[k] = p
        if p != k:
            exchange(a, n, k, p, k, last)
        a[k * n + k] = 1.0 / a[k * n + k]
        for i in range(k + 1, last):
            a[i * n + k] *= a[k * n + k]
            take(a[i * n :], a[k * n :], a[i * n + k], k + 1, last)
    return 1


@inlined
def take(row: Reals, above: Reals, part: float, begin: int, end: int) -> None:
    """Take a part of another row from one, in some columns."""
    if part != 0.0:
        for j in range(begin, end):
            row[j] = muladd(-part, above[j], row[j])


@inlined
def eliminate(
    row: Reals, block: Reals, n: int, first: int, last: int, starts: Integers, linked: Integers, count: int
) -> None:
    """Take the columns of a block from a row below it, by the rows of the block; keep the multiples in their place."""
    for k in range(first, last):
        above = block[(k - first) * n :]
        part = row[k] * above[k]
        row[k] = part
        take(row, above, part, k + 1, last)
        for h in range(count):
            take(row, above, part, starts[linked[h]], starts[linked[h] + 1])


@inlined
def eliminate_six(
    row: Reals, block: Reals, n: int, first: int, starts: Integers, linked: Integers, count: int
) -> None:
    """Do the same for a block of six: each number of the row is read and written once."""
    a, b, c, d, e, f = block, block[n:], block[2 * n :], block[3 * n :], block[4 * n :], block[5 * n :]
    x, A, B, C, D, E, F = row[first:], a[first:], b[first:], c[first:], d[first:], e[first:], f[first:]
    p = x[0] * A[0]
    q = (x[1] - p * A[1]) * B[1]
    r = (x[2] - p * A[2] - q * B[2]) * C[2]
    s = (x[3] - p * A[3] - q * B[3] - r * C[3]) * D[3]
    t = (x[4] - p * A[4] - q * B[4] - r * C[4] - s * D[4]) * E[4]
    u = (x[5] - p * A[5] - q * B[5] - r * C[5] - s * D[5] - t * E[5]) * F[5]
    x[0], x[1], x[2], x[3], x[4], x[5] = p, q, r, s, t, u
    if p != 0.0 or q != 0.0 or r != 0.0 or s != 0.0 or t != 0.0 or u != 0.0:
        for h in range(count):
            j = starts[linked[h]]
            y, A, B, C, D, E, F = row[j:], a[j:], b[j:], c[j:], d[j:], e[j:], f[j:]
            if starts[linked[h] + 1] - j == BODY:
                y[0], y[1], y[2], y[3] = (
                    three_taken(three_taken(y[0], p, A[0], q, B[0], r, C[0]), s, D[0], t, E[0], u, F[0]),
                    three_taken(three_taken(y[1], p, A[1], q, B[1], r, C[1]), s, D[1], t, E[1], u, F[1]),
                    three_taken(three_taken(y[2], p, A[2], q, B[2], r, C[2]), s, D[2], t, E[2], u, F[2]),
                    three_taken(three_taken(y[3], p, A[3], q, B[3], r, C[3]), s, D[3], t, E[3], u, F[3]),
                )
                y[4], y[5] = (
                    three_taken(three_taken(y[4], p, A[4], q, B[4], r, C[4]), s, D[4], t, E[4], u, F[4]),
                    three_taken(three_taken(y[5], p, A[5], q, B[5], r, C[5]), s, D[5], t, E[5], u, F[5]),
                )
            else:
                for k in range(starts[linked[h] + 1] - j):
                    y[k] -= (p * A[k] + q * B[k]) + (r * C[k] + s * D[k]) + (t * E[k] + u * F[k])


@hot
@compiled
def substitute(a: Reals, blocks: Blocks, links: Links, order: Integers, x: Reals) -> None:
    """Replace x by the solution of the equations with this right side, by the factors that `factored` left."""
    n, starts = blocks.n, blocks.starts
    for b in range(blocks.count):
        first, last, linked = starts[b], starts[b + 1], links.blocks[b * blocks.count :]
        for k in range(first, last):
            p = order[k]
            exchanged = x[p]
            x[p] = x[k]
            x[k] = exchanged
            for i in range(k + 1, last):
                x[i] -= a[i * n + k] * exchanged
        for h in range(links.later[b]):
            for i in range(starts[linked[h]], starts[linked[h] + 1]):
                x[i] -= block_product(a[i * n + first :], x[first:], last - first)
    for g in range(blocks.count):
        b = blocks.count - 1 - g
        first, last, linked = starts[b], starts[b + 1], links.blocks[b * blocks.count :]
        for h in range(links.later[b]):
            c = starts[linked[h]]
            for k in range(first, last):
                x[k] -= block_product(a[k * n + c :], x[c:], starts[linked[h] + 1] - c)
        for h in range(last - first):
            k = last - 1 - h
            for j in range(k + 1, last):
                x[k] -= a[k * n + j] * x[j]
            x[k] *= a[k * n + k]


@hot
@compiled
def jacobian(problem: ContactProblem, G: Reals, memory: Newton) -> None:
    """Set J to 1 + Cᵀ G, G stored as the rows of the problem, whose links are known (`link`)."""
    blocks, n, J, links, starts = (
        problem.blocks,
        problem.blocks.n,
        memory.J[0],
        memory.links,
        problem.blocks.starts,
    )
    for b in range(blocks.count):
        linked = links.blocks[b * blocks.count :]
        empty(J, n, starts[b], starts[b + 1], starts[b], starts[b + 1])
        for h in range(links.later[b]):
            c = linked[h]
            empty(J, n, starts[b], starts[b + 1], starts[c], starts[c + 1])
            empty(J, n, starts[c], starts[c + 1], starts[b], starts[b + 1])
    for k in range(n):
        J[k * n + k] = 1.0
    a = 0
    while a < problem.count:
        size = joined(problem, a)
        spread(problem, a, size, G, J)
        a += size


@inlined
def empty(J: Reals, n: int, first: int, last: int, begin: int, end: int) -> None:
    """Set a block of J to zero; one of six columns without a loop, which would be a call for each row."""
    for k in range(first, last):
        row = J[k * n + begin :]
        if end - begin == BODY:
            row[0], row[1], row[2], row[3], row[4], row[5] = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        else:
            for j in range(end - begin):
                row[j] = 0.0


@compiled
def link(problem: ContactProblem, links: Links) -> None:
    """Link the blocks that share a row, and those that elimination lets share one."""
    blocks, count, pieces, a = problem.blocks, problem.blocks.count, problem.blocks.pieces, 0
    for k in range(count * count):
        links.blocks[k] = 0
    while a < problem.count:
        r = problem.rows[a]
        for p in range(blocks.first[r], blocks.first[r + 1]):
            for q in range(p + 1, blocks.first[r + 1]):
                low, high = pieces[p], pieces[q]
                if high < low:
                    low, high = high, low
                links.blocks[low * count + high] = 1
        a += joined(problem, a)
    fill_in(links, count)


@compiled
def fill_in(links: Links, count: int) -> None:
    """Replace the marks of later blocks that each block is linked with by their numbers, with those that come in.

    The first of them inherits the others: what a block leaves when it is eliminated.
    """
    for b in range(count):
        linked, later = links.blocks[b * count :], 0
        for c in range(b + 1, count):
            if linked[c] != 0:
                linked[later] = c
                later += 1
        links.later[b] = later
        for h in range(1, later):
            links.blocks[linked[0] * count + linked[h]] = 1


@hot
@compiled
def least_linked(links: Links, degree: Integers, sequence: Integers, count: int) -> None:
    """Set a sequence in which blocks, whose links are marked on both sides, are eliminated with few links.

    The next one is one that has the fewest left; ``degree`` becomes -1.

    Source: W. F. Tinney, J. W. Walker, Proc. IEEE 55 (1967) 1801-1809.
    """
    for b in range(count):
        degree[b] = 0
        for c in range(count):
            degree[b] += links.blocks[b * count + c]
    for k in range(count):
        b = -1
        for c in range(count):
            if degree[c] >= 0 and (b < 0 or degree[c] < degree[b]):
                b = c
        sequence[k], degree[b] = b, -1
        for c in range(count):
            if links.blocks[b * count + c] != 0 and degree[c] >= 0:
                degree[c] -= 1
                for d in range(c + 1, count):
                    if (
                        links.blocks[b * count + d] != 0
                        and degree[d] >= 0
                        and links.blocks[c * count + d] == 0
                    ):
                        links.blocks[c * count + d] = links.blocks[d * count + c] = 1
                        degree[c] += 1
                        degree[d] += 1


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
                three_added(row[0], p, c_0, q, d_0, r, e_0),
                three_added(row[1], p, c_1, q, d_1, r, e_1),
                three_added(row[2], p, c_2, q, d_2, r, e_2),
                three_added(row[3], p, c_3, q, d_3, r, e_3),
            )
            row[4], row[5] = (
                three_added(row[4], p, c_4, q, d_4, r, e_4),
                three_added(row[5], p, c_5, q, d_5, r, e_5),
            )
    else:
        for k in range(height):
            for j in range(size):
                J[k * n + j] += x[k] * c[j] + y[k] * d[j] + z[k] * e[j]
