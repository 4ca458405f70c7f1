"""Linear equations for any scalar, without pivoting.

A = L D Lᵀ   for symmetric positive definite matrices, which need no pivoting;   A = L U   for matrices that sliding
friction makes unsymmetric, with the unknowns ordered so that all leading minors are known to differ from zero.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction

from ..scalar.algebra import Scalar, divide


class Factorization:
    """L D Lᵀ of a symmetric positive definite matrix, of which only the lower triangle is read.

    Entries that are zero whatever the values (plain numbers, as between bodies that nothing joins) are skipped. The
    unknowns are eliminated in the order of :func:`minimum_degree`: tips of a tree before the links that carry them, and
    a row of loops from its ends, so that few other entries fill in. ``D`` holds the pivots in that order.
    """

    def __init__(self, A: Sequence[Sequence[Scalar]]) -> None:
        self.order = minimum_degree([[j for j, _ in entries(row[:i])] for i, row in enumerate(A)])
        place = {i: k for k, i in enumerate(self.order)}
        self.D: list[Scalar] = [A[i][i] for i in self.order]
        # columns of the remainder below the pivots, and at the end of L
        self.L: list[dict[int, Scalar]] = [{} for _ in A]
        for i, row in enumerate(A):
            for j, entry in entries(row[:i]):
                a, b = sorted((place[i], place[j]))
                self.L[a][b] = entry
        L, D = self.L, self.D
        for k, column in enumerate(L):
            above = {i: column[i] for i in sorted(column) if not is_zero(column[i])}  # L D
            column = L[k] = {i: divide(a, D[k]) for i, a in above.items()}
            for j, b in column.items():
                D[j] = D[j] - above[j] * b
                for i, a in above.items():
                    if i > j:
                        L[j][i] = L[j].get(i, 0) - a * b

    def solve(self, b: Sequence[Scalar]) -> list[Scalar]:
        """Return x with A x = b."""
        return self.back(self.forward(b))

    def forward(self, b: Sequence[Scalar]) -> list[Scalar]:
        """Return y with L y = b, in the order of elimination."""
        y = [b[i] for i in self.order]
        for k, column in enumerate(self.L):
            if not is_zero(y[k]):
                for i, entry in column.items():
                    y[i] = y[i] - entry * y[k]
        return y

    def divided(self, y: Sequence[Scalar]) -> list[Scalar]:
        """Return D⁻¹ y."""
        # a pivot of zero is refused, even for 0/0
        return [0 if is_zero(a) and not is_zero(d) else divide(a, d) for a, d in zip(y, self.D, strict=True)]

    def back(self, y: Sequence[Scalar]) -> list[Scalar]:
        """Return x with D Lᵀ x = y."""
        x = self.divided(y)
        for k in range(len(x) - 1, -1, -1):
            for i in reversed(self.L[k]):
                if not is_zero(x[i]):
                    x[k] = x[k] - self.L[k][i] * x[i]
        result = [0] * len(x)
        for i, value in zip(self.order, x, strict=True):
            result[i] = value
        return result


def minimum_degree(below: Sequence[Iterable[int]]) -> list[int]:
    """Return an order of elimination: next is the unknown coupled to the fewest others, and the last of several.

    So a tip comes before its carrier. ``below`` holds, for each row, the nonzero columns left of the diagonal.

    Source: Davis, Direct Methods for Sparse Linear Systems (2006), §7.1.
    """
    neighbours: dict[int, set[int]] = {i: set() for i in range(len(below))}
    for i, places in enumerate(below):
        for j in places:
            neighbours[i].add(j)
            neighbours[j].add(i)
    order = []
    waiting = [(len(coupled), -i) for i, coupled in neighbours.items()]
    heapq.heapify(waiting)
    while neighbours:
        degree, k = heapq.heappop(waiting)
        k = -k
        if k not in neighbours or len(neighbours[k]) != degree:  # its degree has changed since
            continue
        order.append(k)
        coupled = neighbours.pop(k)
        for i in coupled:
            neighbours[i] |= coupled
            neighbours[i] -= {i, k}
            heapq.heappush(waiting, (len(neighbours[i]), -i))
    return order


@dataclass(frozen=True)
class Selection:
    """Unknowns and equations of a system that are known only when it is solved: 1 for those that take part, else 0.

    ``free``     for each unknown; the others are 0
    ``active``   for each equation; the others are left out
    """

    free: Sequence[Scalar]
    active: Sequence[Scalar]

    def rows(self, G: Sequence[Sequence[Scalar]]) -> list[list[Scalar]]:
        """Return G with zeros in the rows and columns that take no part."""
        result: list[list[Scalar]] = [[0] * len(self.free) for _ in G]
        for a, row, target in zip(self.active, G, result, strict=True):
            for j, x in entries(row):
                target[j] = a * (self.free[j] * x)
        return result

    def masses(self, M: Sequence[Sequence[Scalar]]) -> list[list[Scalar]]:
        """Return M with the rows and columns of unknowns that take no part replaced by those of the unit matrix."""
        result: list[list[Scalar]] = [[0] * len(M) for _ in M]
        for i, row in enumerate(M):
            for j, x in entries(row):
                f = self.free[i]
                result[i][j] = f * (self.free[j] * x) if i != j else f * x + (1 - f)
        return result


def entries(row: Sequence[Scalar]) -> list[tuple[int, Scalar]]:
    """Return (index, value) of the entries that are not zero whatever the values."""
    return [(j, x) for j, x in enumerate(row) if not is_zero(x)]


def products(A: Sequence[Sequence[Scalar]], B: Sequence[Sequence[Scalar]]) -> list[list[Scalar]]:
    """Return A Bᵀ, both given by rows."""
    columns: dict[int, list[tuple[int, Scalar]]] = {}
    for k, row in enumerate(B):
        for j, x in entries(row):
            columns.setdefault(j, []).append((k, x))
    result: list[list[Scalar]] = [[0] * len(B) for _ in A]
    for total, row in zip(result, A, strict=True):
        for j, x in entries(row):
            for k, y in columns.get(j, ()):
                total[k] = total[k] + x * y
    return result


def applied(A: Sequence[Sequence[Scalar]], b: Sequence[Scalar]) -> list[Scalar]:
    """Return A b, A given by rows."""
    return [row[0] for row in products(A, [b])]


def combined(
    start: Sequence[Scalar], weights: Sequence[Scalar], A: Sequence[Sequence[Scalar]]
) -> list[Scalar]:
    """Return start + Aᵀ weights, A given by rows."""
    result = list(start)
    for weight, row in zip(weights, A, strict=True):
        for j, x in entries(row):
            result[j] = result[j] + weight * x
    return result


def scalar_product(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    """Return Σ a_i b_i."""
    total: Scalar = 0
    for x, y in zip(a, b, strict=True):
        total = total + x * y
    return total


def is_zero(x: Scalar) -> bool:
    """Return True for a plain zero, which is zero whatever the values."""
    return isinstance(x, int | Fraction) and x == 0


def solve_symmetric(A: Sequence[Sequence[Scalar]], b: Sequence[Scalar]) -> list[Scalar]:
    """Return x with A x = b."""
    return Factorization(A).solve(b)


class Elimination:
    """L U of a square matrix without zero leading minors; L has units on its diagonal."""

    def __init__(self, A: Sequence[Sequence[Scalar]]) -> None:
        self.rows: list[list[Scalar]] = [list(row) for row in A]
        n = len(self.rows)
        for k in range(n):
            for i in range(k + 1, n):
                if is_zero(self.rows[i][k]):
                    continue
                factor = divide(self.rows[i][k], self.rows[k][k])
                self.rows[i][k] = factor
                for j in range(k + 1, n):
                    self.rows[i][j] = self.rows[i][j] - factor * self.rows[k][j]

    def solve(self, b: Sequence[Scalar]) -> list[Scalar]:
        """Return x with A x = b."""
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
