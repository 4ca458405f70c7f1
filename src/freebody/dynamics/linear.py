"""Linear equations for any scalar, without pivoting.

A = L D Lᵀ   for symmetric positive definite matrices, which need none;   A = L U   where sliding friction makes the
matrix unsymmetric, with unknowns in an order in which the leading ones are known to have a solution by themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..scalar.algebra import divide


class Factorization:
    """L D Lᵀ of a symmetric positive definite matrix, of which only the lower triangle is read.

    What is zero whatever the values (an ``int``, as between bodies that nothing joins) is passed over.
    """

    def __init__(self, A: Sequence[Sequence[Any]]) -> None:
        n = len(A)
        self.L: list[dict[int, Any]] = [{} for _ in range(n)]
        self.D: list[Any] = [0] * n
        L, D = self.L, self.D
        for i in range(n):
            for j in range(i):
                c = A[i][j]
                for k, entry in L[j].items():
                    if k in L[i]:
                        c = c - L[i][k] * entry * D[k]
                if not _nothing(c):
                    L[i][j] = divide(c, D[j])
            D[i] = A[i][i]
            for k, entry in L[i].items():
                D[i] = D[i] - entry * entry * D[k]

    def solve(self, b: Sequence[Any]) -> list[Any]:
        """x with A x = b."""
        x = list(b)
        for i, row in enumerate(self.L):
            for k, entry in row.items():
                x[i] = x[i] - entry * x[k]
        x = [divide(value, pivot) for value, pivot in zip(x, self.D, strict=True)]
        for i in range(len(x) - 1, -1, -1):
            for k, entry in self.L[i].items():
                x[k] = x[k] - entry * x[i]
        return x


def _nothing(x: Any) -> bool:
    return isinstance(x, int) and x == 0


def solve_symmetric(A: Sequence[Sequence[Any]], b: Sequence[Any]) -> list[Any]:
    """x with A x = b."""
    return Factorization(A).solve(b)


class Elimination:
    """L U of a square matrix of which no leading minor is zero; L has units on its diagonal."""

    def __init__(self, A: Sequence[Sequence[Any]]) -> None:
        self.rows: list[list[Any]] = [list(row) for row in A]
        n = len(self.rows)
        for k in range(n):
            for i in range(k + 1, n):
                factor = divide(self.rows[i][k], self.rows[k][k])
                self.rows[i][k] = factor
                for j in range(k + 1, n):
                    self.rows[i][j] = self.rows[i][j] - factor * self.rows[k][j]

    def solve(self, b: Sequence[Any]) -> list[Any]:
        """x with A x = b."""
        n = len(b)
        x = list(b)
        for i in range(n):
            for k in range(i):
                x[i] = x[i] - self.rows[i][k] * x[k]
        for i in range(n - 1, -1, -1):
            for k in range(i + 1, n):
                x[i] = x[i] - self.rows[i][k] * x[k]
            x[i] = divide(x[i], self.rows[i][i])
        return x
