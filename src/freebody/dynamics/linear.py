"""Linear equations for any scalar, without pivoting.

A = L D Lᵀ   for symmetric positive definite matrices, which need none;   A = L U   where sliding friction makes the
matrix unsymmetric, with unknowns in an order in which the leading ones are known to have a solution by themselves.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any

from ..scalar.algebra import divide


class Factorization:
    """L D Lᵀ of a symmetric positive definite matrix, of which only the lower triangle is read.

    What is zero whatever the values (a plain number, as between bodies that nothing joins) is passed over, and the
    unknowns are eliminated in the order of :func:`minimum_degree`: tips of a tree before what carries them, and a row
    of loops from its ends, so that little else fills in. ``D`` holds the pivots in that order.
    """

    def __init__(self, A: Sequence[Sequence[Any]]) -> None:
        self.order = minimum_degree([[j for j, _ in entries(row[:i])] for i, row in enumerate(A)])
        place = {i: k for k, i in enumerate(self.order)}
        self.D: list[Any] = [A[i][i] for i in self.order]
        # the columns of what is left below the pivots, and in the end of L
        self.L: list[dict[int, Any]] = [{} for _ in A]
        for i, row in enumerate(A):
            for j, entry in entries(row[:i]):
                a, b = sorted((place[i], place[j]))
                self.L[a][b] = entry
        L, D = self.L, self.D
        for k, column in enumerate(L):
            above = {i: column[i] for i in sorted(column) if not _nothing(column[i])}  # L D
            column = L[k] = {i: divide(a, D[k]) for i, a in above.items()}
            for j, b in column.items():
                D[j] = D[j] - above[j] * b
                for i, a in above.items():
                    if i > j:
                        L[j][i] = L[j].get(i, 0) - a * b

    def solve(self, b: Sequence[Any]) -> list[Any]:
        """x with A x = b."""
        return self.back(self.forward(b))

    def forward(self, b: Sequence[Any]) -> list[Any]:
        """y with L y = b, in the order of elimination."""
        y = [b[i] for i in self.order]
        for k, column in enumerate(self.L):
            if not _nothing(y[k]):
                for i, entry in column.items():
                    y[i] = y[i] - entry * y[k]
        return y

    def divided(self, y: Sequence[Any]) -> list[Any]:
        """D⁻¹ y."""
        # by a pivot that is zero: refused, 0 too
        return [
            0 if _nothing(a) and not _nothing(d) else divide(a, d) for a, d in zip(y, self.D, strict=True)
        ]

    def back(self, y: Sequence[Any]) -> list[Any]:
        """x with D Lᵀ x = y."""
        x = self.divided(y)
        for k in range(len(x) - 1, -1, -1):
            for i in reversed(self.L[k]):
                if not _nothing(x[i]):
                    x[k] = x[k] - self.L[k][i] * x[i]
        result = [0] * len(x)
        for i, value in zip(self.order, x, strict=True):
            result[i] = value
        return result


def minimum_degree(below: Sequence[Iterable[int]]) -> list[int]:
    """An order of elimination: next is what the fewest are coupled to, of several the last, a tip before its carrier.

    ``below`` holds, for each row, the places left of the diagonal that are not zero.

    Source: Davis, Direct Methods for Sparse Linear Systems (2006), §7.1.
    """
    near: dict[int, set[int]] = {i: set() for i in range(len(below))}
    for i, places in enumerate(below):
        for j in places:
            near[i].add(j)
            near[j].add(i)
    order = []
    while near:
        k = min(near, key=lambda i: (len(near[i]), -i))
        order.append(k)
        coupled = near.pop(k)
        for i in coupled:
            near[i] |= coupled
            near[i] -= {i, k}
    return order


def entries(row: Sequence[Any]) -> list[tuple[int, Any]]:
    """(place, value) of what is not zero whatever the values."""
    return [(j, x) for j, x in enumerate(row) if not _nothing(x)]


def products(A: Sequence[Sequence[Any]], B: Sequence[Sequence[Any]]) -> list[list[Any]]:
    """A Bᵀ, both given by rows."""
    columns: dict[int, list[tuple[int, Any]]] = {}
    for k, row in enumerate(B):
        for j, x in entries(row):
            columns.setdefault(j, []).append((k, x))
    result: list[list[Any]] = [[0] * len(B) for _ in A]
    for total, row in zip(result, A, strict=True):
        for j, x in entries(row):
            for k, y in columns.get(j, ()):
                total[k] = total[k] + x * y
    return result


def applied(A: Sequence[Sequence[Any]], b: Sequence[Any]) -> list[Any]:
    """A b, A given by rows."""
    return [row[0] for row in products(A, [b])]


def combined(start: Sequence[Any], weights: Sequence[Any], A: Sequence[Sequence[Any]]) -> list[Any]:
    """start + Aᵀ weights, A given by rows."""
    result = list(start)
    for weight, row in zip(weights, A, strict=True):
        for j, x in entries(row):
            result[j] = result[j] + weight * x
    return result


def _nothing(x: Any) -> bool:
    return isinstance(x, int | Fraction) and x == 0


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
                if _nothing(self.rows[i][k]):
                    continue
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
