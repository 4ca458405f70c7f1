"""Sparse inertia and constraints of a time step: only contacts couple the blocks of speeds.

    M = diag(M_b),   L_b L_bᵀ = M_b,   K = M⁻¹ Gᵀ,   S = G K
    X_r = M⁻¹ (W_r - σ_r G)ᵀ,   σ_r = S⁻¹ Kᵀ W_rᵀ         change of u and of -λ per impulse along row r

Each row of G lies in one block, because speeds coupled by a constraint share a block, as those coupled by joints do. A
row of W is stored over the whole blocks of its two bodies. The cost of a stack of n boxes is therefore of order n, not
n³. All functions are for `native.instructions.compiled`; speeds are in block order.

Source of the elimination: Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 8.
"""

from __future__ import annotations

from ...native.instructions import Integers, Reals, compiled, root


@compiled
def cholesky(M: Reals, L: Reals, at: int, n: int) -> int:
    """Write L of L Lᵀ = M, both stored from ``at`` on; return 0 if M is not positive definite, else 1."""
    for i in range(n):
        for j in range(i + 1):
            total = M[at + i * n + j]
            for k in range(j):
                total -= L[at + i * n + k] * L[at + j * n + k]
            if i == j:
                if not total > 1e-14 * M[at + i * n + i]:
                    return 0
                L[at + i * n + i] = root(total)
            else:
                L[at + i * n + j] = total / L[at + j * n + j]
    return 1


@compiled
def back(L: Reals, at: int, n: int, b: Reals, source: int, x: Reals, to: int) -> None:
    """Set x[to:] = (L Lᵀ)⁻¹ b[source:]."""
    for i in range(n):
        total = b[source + i]
        for k in range(i):
            total -= L[at + i * n + k] * x[to + k]
        x[to + i] = total / L[at + i * n + i]
    for i in range(n - 1, -1, -1):
        total = x[to + i]
        for k in range(i + 1, n):
            total -= L[at + k * n + i] * x[to + k]
        x[to + i] = total / L[at + i * n + i]


@compiled
def factor(M: Reals, L: Reals, blocks: Integers, squares: Integers, count: int) -> int:
    """Factor all blocks of M; return 0 if a block is not positive definite, else 1."""
    for k in range(count):
        if cholesky(M, L, squares[k], blocks[k + 1] - blocks[k]) == 0:
            return 0
    return 1


@compiled
def dot(x: Reals, i: int, y: Reals, j: int, n: int) -> float:
    """Return x[i:] · y[j:], over n numbers."""
    total = 0.0
    for k in range(n):
        total += x[i + k] * y[j + k]
    return total


@compiled
def along(
    W: Reals, at: int, pieces: Integers, first: int, last: int, blocks: Integers, v: Reals, start: int
) -> float:
    """Return W_r v for the row whose values begin at ``at`` and cover the blocks ``pieces[first:last]``."""
    total = 0.0
    for p in range(first, last):
        for i in range(blocks[pieces[p]], blocks[pieces[p] + 1]):
            total += W[at] * v[start + i]
            at += 1
    return total


@compiled
def added(
    X: Reals, at: int, pieces: Integers, first: int, last: int, blocks: Integers, x: float, v: Reals
) -> None:
    """Add X_r x to v."""
    for p in range(first, last):
        for i in range(blocks[pieces[p]], blocks[pieces[p] + 1]):
            v[i] += X[at] * x
            at += 1


@compiled
def solved(
    L: Reals, squares: Integers, pieces: Integers, first: int, last: int, blocks: Integers, W: Reals, at: int,
    X: Reals, to: int,
) -> None:  # fmt: skip
    """Set X[to:] = M⁻¹ W_rᵀ over the blocks of a row."""
    for p in range(first, last):
        b = pieces[p]
        size = blocks[b + 1] - blocks[b]
        back(L, squares[b], size, W, at, X, to)
        at += size
        to += size


@compiled
def held(
    W: Reals, at_W: int, L: Reals, squares: Integers, pieces: Integers, row_first: Integers, row_at: Integers,
    blocks: Integers, m: int, count: int, n: int, K: Reals, S: Reals, spare: Reals,
) -> int:  # fmt: skip
    """Compute K = M⁻¹ Gᵀ and the factor of S = G K for the first ``count`` constraints, rows m, m + 1, ...

    Return 0 if S is not positive definite, else 1.
    """
    for i in range(count):
        r = m + i
        for k in range(n):
            K[i * n + k] = 0.0
        if row_first[r + 1] > row_first[r]:
            b = pieces[row_first[r]]
            back(L, squares[b], blocks[b + 1] - blocks[b], W, at_W + row_at[r], K, i * n + blocks[b])
    for i in range(count):
        r = m + i
        for j in range(count):
            spare[i * count + j] = along(
                W, at_W + row_at[r], pieces, row_first[r], row_first[r + 1], blocks, K, j * n
            )
    return cholesky(spare, S, 0, count)


@compiled
def met(
    W: Reals, at_W: int, rates: int, pieces: Integers, row_first: Integers, row_at: Integers, blocks: Integers, m: int,
    count: int, n: int, K: Reals, S: Reals, spare: Reals, v: Reals, lam: Reals,
) -> None:  # fmt: skip
    """Compute λ and replace v by v + K λ, which satisfies the first ``count`` constraints: G v + W[rates:] = 0.

    K and S are those of `held`.
    """
    for i in range(count):
        r = m + i
        spare[i] = -W[rates + i] - along(
            W, at_W + row_at[r], pieces, row_first[r], row_first[r + 1], blocks, v, 0
        )
    back(S, 0, count, spare, 0, lam, 0)
    for i in range(count):
        for k in range(n):
            v[k] += lam[i] * K[i * n + k]


@compiled
def answer(
    W: Reals, at: int, X: Reals, to: int, sigma: Reals, here: int, L: Reals, squares: Integers, pieces: Integers,
    first: int, last: int, blocks: Integers, m: int, row_first: Integers, row_at: Integers, at_W: int, count: int,
    n: int, K: Reals, S: Reals, spare: Reals,
) -> None:  # fmt: skip
    """Write X_r = M⁻¹ (W_r - σ_r G)ᵀ at ``to`` and σ_r at ``here``.

    The subtraction is done twice. The second removes the part of G that round-off leaves after the first; without it,
    rows almost fixed by the constraints would consist of round-off.
    """
    size = 0
    for p in range(first, last):
        size += blocks[pieces[p] + 1] - blocks[pieces[p]]
    for k in range(size):
        X[to + k] = W[at + k]
    for i in range(count):
        sigma[here + i] = 0.0
    for _ in range(2 if count > 0 else 0):
        for i in range(count):
            spare[i] = along(X, to, pieces, first, last, blocks, K, i * n)
        back(S, 0, count, spare, 0, spare, count)
        for i in range(count):
            sigma[here + i] += spare[count + i]
            if row_first[m + i + 1] > row_first[m + i]:
                k, own = to, pieces[row_first[m + i]]
                for p in range(first, last):
                    width = blocks[pieces[p] + 1] - blocks[pieces[p]]
                    if pieces[p] == own:
                        for j in range(width):
                            X[k + j] -= spare[count + i] * W[at_W + row_at[m + i] + j]
                    k += width
    solved(L, squares, pieces, first, last, blocks, X, to, X, to)
