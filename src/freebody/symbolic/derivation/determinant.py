"""Determinants of matrices of canonical polynomials."""

from __future__ import annotations

from collections.abc import Sequence

from ...scalar.algebra import Scalar


def determinant(A: Sequence[Sequence[Scalar]]) -> Scalar:
    """Determinant of a square matrix by expansion along the first row; the matrices are small and sparse."""
    if not A:
        return 1
    total: Scalar = 0
    sign = 1
    for k, entry in enumerate(A[0]):
        if entry != 0:
            total = total + sign * entry * determinant([[*row[:k], *row[k + 1 :]] for row in A[1:]])
        sign = -sign
    return total
