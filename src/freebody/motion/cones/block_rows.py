"""Rows over blocks of speeds (`contact_problem.Blocks`): their products with a vector, and multiples of them."""

from __future__ import annotations

from ...native.instructions import Reals, compiled, hot, inlined
from .contact_problem import Blocks

BODY = 6
"""Speeds of a free body, the most frequent block: its sums are written out, since a loop waits for each term."""


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
        total = (w[0] * x[0] + w[2] * x[2] + w[4] * x[4]) + (w[1] * x[1] + w[3] * x[3] + w[5] * x[5])
    else:
        for i in range(n):
            total += w[i] * x[i]
    return total


@inlined
def block_add(y: Reals, x: float, c: Reals, n: int) -> None:
    """Add x c to y over the speeds of a block."""
    if n == BODY:
        y[0], y[1], y[2], y[3] = y[0] + x * c[0], y[1] + x * c[1], y[2] + x * c[2], y[3] + x * c[3]
        y[4], y[5] = y[4] + x * c[4], y[5] + x * c[5]
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
