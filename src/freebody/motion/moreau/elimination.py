"""Sparse inertia and constraints of a time step: only contacts couple the blocks of speeds.

    M = diag(M_b),   L_b L_bᵀ = M_b,   K = M⁻¹ Gᵀ,   S Sᵀ = G K
    X_r = M⁻¹ (W_r - σ_r G)ᵀ,   σ_r = (G K)⁻¹ Kᵀ W_rᵀ         change of u and of -λ per impulse along row r

Each row of G lies in one block, because speeds coupled by a constraint share a block, as those coupled by joints do. A
row of W is stored over the whole blocks of its two bodies. The cost of a stack of n boxes is therefore of order n, not
n³. All functions are for `native.instructions.compiled`; speeds are in block order.

Source of the elimination: Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 8.
"""

from __future__ import annotations

from ...native.instructions import Reals, compiled, hot, root
from ..cones.block_rows import along
from .stepping_record import Elimination

SINGULAR = 1e-14
"""Part of a diagonal entry below which its remainder is round-off."""


@hot
@compiled
def cholesky(M: Reals, L: Reals, n: int, band: int) -> int:
    """Write L of L Lᵀ = M, with 1/L_ii on its diagonal; return 0 if M is not positive definite, else 1.

    Entries further than ``band`` from the diagonal are zero, and are not read.
    """
    for i in range(n):
        begin = i - band if i > band else 0
        for j in range(begin, i + 1):
            total = M[i * n + j]
            for k in range(begin, j):
                total -= L[i * n + k] * L[j * n + k]
            if i == j:
                if not total > SINGULAR * M[i * n + i]:
                    return 0
                L[i * n + i] = 1.0 / root(total)
            else:
                L[i * n + j] = total * L[j * n + j]
    return 1


@hot
@compiled
def back(L: Reals, n: int, band: int, b: Reals, x: Reals) -> None:
    """Set x = (L Lᵀ)⁻¹ b."""
    for i in range(n):
        total = b[i]
        for k in range(i - band if i > band else 0, i):
            total -= L[i * n + k] * x[k]
        x[i] = total * L[i * n + i]
    for i in range(n - 1, -1, -1):
        total = x[i]
        for k in range(i + 1, i + band + 1 if i + band < n else n):
            total -= L[k * n + i] * x[k]
        x[i] = total * L[i * n + i]


@compiled
def factor(of: Elimination, M: Reals) -> int:
    """Factor all blocks of M; return 0 if a block is not positive definite, else 1."""
    blocks = of.blocks
    for b in range(blocks.count):
        n, block = blocks.starts[b + 1] - blocks.starts[b], M[blocks.squares[b] :]
        of.band[b] = band(block, n)
        if cholesky(block, of.L[blocks.squares[b] :], n, of.band[b]) == 0:
            return 0
    return 1


@compiled
def band(M: Reals, n: int) -> int:
    """Return the greatest distance of an entry from the diagonal: 0 for a free body in its principal axes."""
    for distance in range(n - 1, 0, -1):
        for i in range(distance, n):
            if M[i * n + i - distance] != 0.0:
                return distance
    return 0


@compiled
def block_back(of: Elimination, b: int, p: Reals, x: Reals) -> None:
    """Set x = M_b⁻¹ p for the numbers of one block."""
    blocks = of.blocks
    back(of.L[blocks.squares[b] :], blocks.starts[b + 1] - blocks.starts[b], of.band[b], p, x)


@compiled
def answer_block(of: Elimination, b: int, p: Reals, x: Reals) -> None:
    """Set x = (M_b - D_b)⁻¹ p for the numbers of one block (`spin`)."""
    block_back(of, b, p, x)
    if of.spins[b] != 0:
        C, a, c, d = of.C[b], x[0], x[1], x[2]
        for i in range(6):
            x[i] += C[3 * i] * a + C[3 * i + 1] * c + C[3 * i + 2] * d


@compiled
def hold(of: Elimination, W: Reals, count: int) -> int:
    """Compute K = M⁻¹ Gᵀ and the factor S of G K for the first ``count`` constraints.

    Return 0 if G K is not positive definite, else 1.
    """
    blocks, m = of.blocks, of.contact_rows
    for i in range(count):
        r, K = m + i, of.K[i]
        for k in range(blocks.n):
            K[k] = 0.0
        if blocks.first[r + 1] > blocks.first[r]:
            b = blocks.pieces[blocks.first[r]]
            block_back(of, b, W[blocks.at[r] :], K[blocks.starts[b] :])
    for i in range(count):
        for j in range(count):
            of.GK[i * count + j] = along(blocks, m + i, W, of.K[j])
    return cholesky(of.GK, of.S, count, count)


@compiled
def meet(of: Elimination, W: Reals, rates: Reals, count: int, v: Reals, lam: Reals) -> None:
    """Compute λ and replace v by v + K λ, which satisfies the first ``count`` constraints: G v + rates = 0."""
    for i in range(count):
        of.rates[i] = -rates[i] - along(of.blocks, of.contact_rows + i, W, v)
    back(of.S, count, count, of.rates, lam)
    for i in range(count):
        K = of.K[i]
        for k in range(of.blocks.n):
            v[k] += lam[i] * K[k]


@compiled
def answer(of: Elimination, r: int, W: Reals, X: Reals, sigma: Reals, count: int) -> None:
    """Write X_r = M⁻¹ (W_r - σ_r G)ᵀ and σ_r for the first ``count`` constraints.

    The subtraction is done twice. The second removes the part of G that round-off leaves after the first; without it,
    rows almost fixed by the constraints would consist of round-off.
    """
    blocks, m = of.blocks, of.contact_rows
    for k in range(blocks.at[r], blocks.at[r + 1]):
        X[k] = W[k]
    for i in range(count):
        sigma[i] = 0.0
    for _ in range(2 if count > 0 else 0):
        for i in range(count):
            of.rates[i] = along(blocks, r, X, of.K[i])
        back(of.S, count, count, of.rates, of.share)
        for i in range(count):
            sigma[i] += of.share[i]
            subtract(of, r, m + i, of.share[i], W, X)
    k = blocks.at[r]
    for p in range(blocks.first[r], blocks.first[r + 1]):
        b = blocks.pieces[p]
        answer_block(of, b, X[k:], X[k:])
        k += blocks.starts[b + 1] - blocks.starts[b]


@compiled
def subtract(of: Elimination, r: int, g: int, part: float, W: Reals, X: Reals) -> None:
    """Subtract a part of row ``g``, which has one block or none, from X_r."""
    blocks = of.blocks
    if blocks.first[g + 1] > blocks.first[g]:
        k, own = blocks.at[r], blocks.pieces[blocks.first[g]]
        for p in range(blocks.first[r], blocks.first[r + 1]):
            b = blocks.pieces[p]
            width = blocks.starts[b + 1] - blocks.starts[b]
            if b == own:
                for j in range(width):
                    X[k + j] -= part * W[blocks.at[g] + j]
            k += width
