"""Rows over blocks of speeds (`contact_problem.Blocks`): their products with a vector, and multiples of them."""

from __future__ import annotations

from ...native.instructions import Reals, compiled
from .contact_problem import Blocks


@compiled
def dot(x: Reals, y: Reals, n: int) -> float:
    """Return x · y."""
    total = 0.0
    for k in range(n):
        total += x[k] * y[k]
    return total


@compiled
def along(blocks: Blocks, r: int, W: Reals, v: Reals) -> float:
    """Return W_r v."""
    total, k = 0.0, blocks.at[r]
    for p in range(blocks.first[r], blocks.first[r + 1]):
        b = blocks.pieces[p]
        for i in range(blocks.starts[b], blocks.starts[b + 1]):
            total += W[k] * v[i]
            k += 1
    return total


@compiled
def add(blocks: Blocks, r: int, X: Reals, x: float, v: Reals) -> None:
    """Add X_r x to v."""
    k = blocks.at[r]
    for p in range(blocks.first[r], blocks.first[r + 1]):
        b = blocks.pieces[p]
        for i in range(blocks.starts[b], blocks.starts[b + 1]):
            v[i] += X[k] * x
            k += 1


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
