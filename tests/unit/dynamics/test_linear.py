"""Linear equations over exact numbers: what is solved is solved without error."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from freebody.dynamics.linear import Elimination, Factorization, applied, combined, minimum_degree, products


def sparse(n, m, seed):
    random = np.random.default_rng(seed)
    kept = random.random((n, m)) < 0.3
    return [
        [Fraction(int(x)) if keep and x else 0 for x, keep in zip(row, keeps, strict=True)]
        for row, keeps in zip(random.integers(-5, 6, (n, m)), kept, strict=True)
    ]


def dense(A):
    return np.array(A, dtype=object)


@pytest.mark.parametrize("n", [1, 2, 5, 12])
@pytest.mark.parametrize("solver", [Factorization, Elimination])
def test_solution_is_exact(n, solver):
    B = sparse(n, n, n)
    A = products(B, B)
    for i in range(n):
        A[i][i] += Fraction(1, 3)
    b = [Fraction(i * i - 3, 7) if i % 2 else 0 for i in range(n)]
    assert applied(A, solver(A).solve(b)) == b


def test_products_leave_out_zeros_only():
    A, B = sparse(4, 6, 1), sparse(5, 6, 2)
    weights, start = [Fraction(i, 3) for i in range(4)], [Fraction(i) for i in range(6)]
    assert (dense(products(A, B)) == dense(A) @ dense(B).T).all()
    assert applied(A, start) == (dense(A) @ dense(start)).tolist()
    assert combined(start, weights, A) == (dense(start) + dense(A).T @ dense(weights)).tolist()


def test_the_hub_of_a_star_is_eliminated_last():
    n = 6
    order = minimum_degree([[], *([0] for _ in range(n - 1))])
    assert order[: n - 2] == [5, 4, 3, 2]
    A = [[n if i == j == 0 else 2 if i == j else int(0 in (i, j)) for j in range(n)] for i in range(n)]
    assert sum(map(len, Factorization(A).L)) == n - 1


def test_a_full_matrix_is_eliminated_from_its_end():
    assert minimum_degree([range(i) for i in range(7)]) == [6, 5, 4, 3, 2, 1, 0]


def test_product_through_the_inverse_needs_no_way_back():
    """G A⁻¹ bᵀ = (L⁻¹ Gᵀ)ᵀ D⁻¹ (L⁻¹ b)."""
    B, G = sparse(5, 5, 3), sparse(3, 5, 4)
    A = products(B, B)
    for i in range(5):
        A[i][i] += Fraction(1, 3)
    M, b = Factorization(A), [Fraction(i, 7) for i in range(5)]
    halves = [M.divided(M.forward(row)) for row in G]
    assert applied(halves, M.forward(b)) == applied(G, M.solve(b))
    assert M.back(M.forward(b)) == M.solve(b)
