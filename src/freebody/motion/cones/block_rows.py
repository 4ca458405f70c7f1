"""Rows over blocks of speeds (`contact_problem.Blocks`): their products with a vector, multiples of them, and islands.

An island is a set of blocks that rows join; no row of another island has speeds of it.
"""

from __future__ import annotations

from ...native.instructions import Integers, Reals, compiled, hot, inlined, muladd
from .contact_problem import Blocks

BODY = 6
"""Speeds of a free body, the most frequent block: its sums are written out, since a loop waits for each term."""


@compiled
def root_of(parent: Integers, b: int) -> int:
    """Return the first block of the island of a block."""
    while parent[b] != b:
        parent[b] = parent[parent[b]]
        b = parent[b]
    return b


@compiled
def join(parent: Integers, a: int, b: int) -> None:
    """Let two blocks be of one island."""
    one, other = root_of(parent, a), root_of(parent, b)
    if one < other:
        parent[other] = one
    else:
        parent[one] = other


@hot
@compiled
def dot(x: Reals, y: Reals, n: int) -> float:
    """Return x · y, by four sums side by side, since one waits for each term."""
    a, b, c, d, k = 0.0, 0.0, 0.0, 0.0, 0
    while k + 4 <= n:
        a += x[k] * y[k]
        b += x[k + 1] * y[k + 1]
        c += x[k + 2] * y[k + 2]
        d += x[k + 3] * y[k + 3]
        k += 4
    while k < n:
        a += x[k] * y[k]
        k += 1
    return (a + b) + (c + d)


@inlined
def block_product(w: Reals, x: Reals, n: int) -> float:
    """Return w · x over the speeds of a block."""
    total = 0.0
    if n == BODY:
        total = muladd(w[4], x[4], muladd(w[2], x[2], w[0] * x[0])) + muladd(
            w[5], x[5], muladd(w[3], x[3], w[1] * x[1])
        )
    else:
        for i in range(n):
            total += w[i] * x[i]
    return total


@inlined
def block_add(y: Reals, x: float, c: Reals, n: int) -> None:
    """Add x c to y over the speeds of a block."""
    if n == BODY:
        y[0], y[1], y[2], y[3] = (
            muladd(x, c[0], y[0]),
            muladd(x, c[1], y[1]),
            muladd(x, c[2], y[2]),
            muladd(x, c[3], y[3]),
        )
        y[4], y[5] = muladd(x, c[4], y[4]), muladd(x, c[5], y[5])
    else:
        for i in range(n):
            y[i] += x * c[i]


@inlined
def product(blocks: Blocks, r: int, W: Reals, v: Reals) -> float:
    """Return W_r v; `along` where a call costs little beside the rest."""
    total, k = 0.0, blocks.at[r]
    for p in range(blocks.first[r], blocks.first[r + 1]):
        b = blocks.pieces[p]
        n = blocks.starts[b + 1] - blocks.starts[b]
        total += block_product(W[k:], v[blocks.starts[b] :], n)
        k += n
    return total


@hot
@compiled
def along(blocks: Blocks, r: int, W: Reals, v: Reals) -> float:
    """Return W_r v."""
    return product(blocks, r, W, v)


@hot
@compiled
def add(blocks: Blocks, r: int, X: Reals, x: float, v: Reals) -> None:
    """Add X_r x to v."""
    k = blocks.at[r]
    for p in range(blocks.first[r], blocks.first[r + 1]):
        b = blocks.pieces[p]
        n = blocks.starts[b + 1] - blocks.starts[b]
        block_add(v[blocks.starts[b] :], x, X[k:], n)
        k += n


@hot
@compiled
def along_three(blocks: Blocks, r: int, W: Reals, v: Reals, result: Reals) -> None:
    """Set ``result`` to W v of the three rows of a contact from r on, which cover the same blocks."""
    k, a, b, c = blocks.at[r], 0.0, 0.0, 0.0
    step = blocks.at[r + 1] - k
    for p in range(blocks.first[r], blocks.first[r + 1]):
        first = blocks.starts[blocks.pieces[p]]
        n = blocks.starts[blocks.pieces[p] + 1] - first
        a += block_product(W[k:], v[first:], n)
        b += block_product(W[k + step :], v[first:], n)
        c += block_product(W[k + 2 * step :], v[first:], n)
        k += n
    result[0], result[1], result[2] = a, b, c


@hot
@compiled
def add_three(blocks: Blocks, r: int, X: Reals, x: Reals, v: Reals) -> None:
    """Add X x of the three rows of a contact from r on to v."""
    k, a, b, c = blocks.at[r], x[0], x[1], x[2]
    step = blocks.at[r + 1] - k
    for p in range(blocks.first[r], blocks.first[r + 1]):
        first = blocks.starts[blocks.pieces[p]]
        n = blocks.starts[blocks.pieces[p] + 1] - first
        y, d, e, f = v[first:], X[k:], X[k + step :], X[k + 2 * step :]
        if n == BODY:
            y[0], y[1], y[2], y[3] = (
                three_added(y[0], a, d[0], b, e[0], c, f[0]),
                three_added(y[1], a, d[1], b, e[1], c, f[1]),
                three_added(y[2], a, d[2], b, e[2], c, f[2]),
                three_added(y[3], a, d[3], b, e[3], c, f[3]),
            )
            y[4], y[5] = (
                three_added(y[4], a, d[4], b, e[4], c, f[4]),
                three_added(y[5], a, d[5], b, e[5], c, f[5]),
            )
        else:
            for i in range(n):
                y[i] += a * d[i] + b * e[i] + c * f[i]
        k += n


@inlined
def three_added(y: float, a: float, d: float, b: float, e: float, c: float, f: float) -> float:
    """Return y + a d + b e + c f."""
    return muladd(c, f, muladd(b, e, muladd(a, d, y)))


@inlined
def three_taken(y: float, a: float, d: float, b: float, e: float, c: float, f: float) -> float:
    """Return y - a d - b e - c f."""
    return muladd(-c, f, muladd(-b, e, muladd(-a, d, y)))


@hot
@compiled
def wipe(blocks: Blocks, r: int, v: Reals) -> None:
    """Set the speeds of the blocks of row r to zero."""
    for p in range(blocks.first[r], blocks.first[r + 1]):
        for i in range(blocks.starts[blocks.pieces[p]], blocks.starts[blocks.pieces[p] + 1]):
            v[i] = 0.0


@compiled
def magnitude(blocks: Blocks, r: int, W: Reals, u: Reals, v: Reals) -> float:
    """Return Σ |W_ri (u + v)_i|."""
    total, k = 0.0, blocks.at[r]
    for p in range(blocks.first[r], blocks.first[r + 1]):
        b = blocks.pieces[p]
        for i in range(blocks.starts[b], blocks.starts[b + 1]):
            total += abs(W[k] * (u[i] + v[i]))
            k += 1
    return total
