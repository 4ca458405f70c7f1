"""Exact sums of numbers and of their products, as integers: no order of summation changes a bit.

    x = M 2^e,  |M| < 2^53,      x = Σ_j a_j 2^(18 j) 2^e,      x² = Σ_j b_j 2^(18 j) 2^(2 e)

Limbs a_j, b_j below 2^18 are multiplied and summed for up to 2^16 numbers at once by one product of matrices: each sum
is an integer below 2^53, so that floats hold it exactly whatever the order (Σ a_j b_k < 2^(18 + 18 + 16)). Numbers
are sorted by their exponents before, so that the sum for each exponent is one product.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SimulationError

UNIT = 1126
"""Every float is an integer multiple of 2^-UNIT, with the 53 bits of its mantissa."""
_LIMB = 18
_MASK = (1 << _LIMB) - 1
_CHUNK = 1 << 16
_LARGEST = 1 << 26
"""Numbers whose sums of limbs fit into 63 bits: 2^10 sums below 2^53."""
_ROWS = {1: 3, 2: 6}
"""Limbs of x and of x²."""
Factor = tuple[int, int]
"""A column and its power, 1 or 2."""


@dataclass(frozen=True)
class Moments:
    """Number of lanes, and Σ x₀^i x₁^j for each pair of powers in ``powers``, in units of 2^(-UNIT (i + j))."""

    powers: tuple[tuple[int, ...], ...]
    count: int
    sums: tuple[int, ...]

    def merge(self, other: Moments) -> Moments:
        """Return the sums over the lanes of both."""
        if self.powers != other.powers:
            raise SimulationError(
                "Expected weights in all blocks of a study or in none, got both. Compute all blocks the same way."
            )
        sums = tuple(a + b for a, b in zip(self.sums, other.sums, strict=True))
        return Moments(self.powers, self.count + other.count, sums)

    def sum(self, *powers: int) -> int:
        """Return one of the sums, in its unit."""
        return self.sums[self.powers.index(powers)]


def moments(columns: Sequence[NDArray[np.float64]], powers: tuple[tuple[int, ...], ...]) -> Moments:
    """Return the exact sums of products of powers of finite numbers.

    Parameters
    ----------
    columns : one or two arrays, (n,)
    powers : powers of the columns in each sum: of one column 1 to 4, of two columns 0 to 2.
    """
    count = len(columns[0])
    result = Moments(powers, 0, (0,) * len(powers))
    for low in range(0, count, _LARGEST):
        part = [column[low : low + _LARGEST] for column in columns]
        result = result.merge(Moments(powers, len(part[0]), _sums(part, powers)))
    return result


def quotient(numerator: int, denominator: int, what: str) -> float:
    """Return the nearest float of a ratio of integers; nan if the denominator is zero."""
    try:
        return numerator / denominator if denominator else math.nan
    except OverflowError:
        raise SimulationError(
            f"Expected {what} below 1.8e308, got a larger one. Divide the number by a constant."
        ) from None


def square_root(numerator: int, denominator: int) -> float:
    """Return the square root of a ratio of integers, right to one unit in the last place; nan if undefined."""
    if numerator < 0 or denominator <= 0:
        return math.nan
    shift = max(0, 130 - numerator.bit_length() + denominator.bit_length())
    shift += shift % 2
    return math.isqrt((numerator << shift) // denominator) / (1 << shift // 2)


def _factors(powers: tuple[int, ...]) -> tuple[Factor, ...]:
    """Return a product of powers as at most two factors x or x²."""
    columns = [(column, power) for column, power in enumerate(powers) if power]
    if len(columns) == 2:
        return tuple(columns)
    column, power = columns[0]
    return tuple((column, k) for k in {1: (1,), 2: (1, 1), 3: (1, 2), 4: (2, 2)}[power])


def _sums(columns: Sequence[NDArray[np.float64]], powers: tuple[tuple[int, ...], ...]) -> tuple[int, ...]:
    """Return the sums of each product of powers."""
    products = [_factors(x) for x in powers]
    places: dict[Factor, int] = {}
    rows = 1  # the first row is 1
    for factor in sorted({factor for product in products for factor in product}):
        places[factor] = rows
        rows += _ROWS[factor[1]]
    totals: dict[tuple[int, ...], Any] = {}
    table = np.ones((rows, min(_CHUNK, len(columns[0]))))
    for low in range(0, len(columns[0]), _CHUNK):
        split = [np.frexp(column[low : low + _CHUNK]) for column in columns]
        exponents = [exponent.astype(np.int16) for _, exponent in split]
        order, edges = _runs(exponents)
        for column, (mantissa, _) in enumerate(split):
            _limbs(table, mantissa if order is None else mantissa[order], column, places)
        firsts = edges[:-1] if order is None else order[edges[:-1]]
        keys = np.stack([exponent[firsts] for exponent in exponents], axis=1).tolist()
        for key, (first, last) in zip(map(tuple, keys), pairwise(edges.tolist()), strict=True):
            block = table[:, first:last]
            gram = (block @ block.T).astype(np.int64)
            totals[key] = totals[key] + gram if key in totals else gram
    result = [0] * len(powers)
    for key, gram in totals.items():
        for i, product in enumerate(products):
            result[i] += _combined(gram, product, places) << sum(
                power * (key[column] - 53 + UNIT) for column, power in product
            )
    return tuple(result)


def _runs(exponents: list[Any]) -> tuple[Any, Any]:
    """Return an order of numbers with equal exponents side by side, None if they are so, and the edges of the runs."""
    count = len(exponents[0])
    if all((x == x[0]).all() for x in exponents):
        return None, np.array([0, count])
    # by digits, for one column of 16 bits
    order = np.argsort(exponents[0], kind="stable") if len(exponents) == 1 else np.lexsort(exponents)
    change = np.zeros(count - 1, dtype=bool)
    for x in exponents:
        change |= np.diff(x[order]) != 0
    return order, np.concatenate([[0], np.flatnonzero(change) + 1, [count]])


def _limbs(table: NDArray[np.float64], mantissa: Any, column: int, places: dict[Factor, int]) -> None:
    """Write the limbs of x and x² into their rows."""
    count = len(mantissa)
    integer = np.abs(mantissa * 2.0**53).astype(np.int64)
    a = integer & _MASK, integer >> _LIMB & _MASK, integer >> 2 * _LIMB
    if (column, 1) in places:
        sign = np.sign(mantissa)
        for j, limb in enumerate(a):
            np.multiply(limb, sign, out=table[places[column, 1] + j, :count])
    if (column, 2) in places:
        products = (a[0] * a[0], 2 * a[0] * a[1], 2 * a[0] * a[2] + a[1] * a[1], 2 * a[1] * a[2], a[2] * a[2])
        carry: Any = 0
        for j, product in enumerate(products):
            carry = carry + product
            table[places[column, 2] + j, :count] = carry & _MASK
            carry = carry >> _LIMB
        table[places[column, 2] + 5, :count] = carry


def _combined(gram: Any, product: tuple[Factor, ...], places: dict[Factor, int]) -> int:
    """Return the sum of a product of factors from the sums of their limbs."""
    rows = [range(places[factor], places[factor] + _ROWS[factor[1]]) for factor in product]
    if len(rows) == 1:
        return sum(int(gram[0, p]) << _LIMB * j for j, p in enumerate(rows[0]))
    return sum(
        int(gram[p, q]) << _LIMB * (j + k) for j, p in enumerate(rows[0]) for k, q in enumerate(rows[1])
    )
