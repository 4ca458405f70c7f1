"""Sums of powers are the sums of the fractions that floats are."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from freebody.errors import SimulationError
from freebody.studies.reducers import exact_moments
from freebody.studies.reducers.exact_moments import UNIT, Moments, moments, quotient, square_root

FLOATS = st.floats(allow_nan=False, allow_infinity=False)
ONE = ((1,), (2,), (3,), (4,))
TWO = ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (2, 1), (1, 2), (2, 2))


def exact(columns: list[list[float]], powers: tuple[int, ...]) -> Fraction:
    rows = zip(*columns, strict=True)
    return sum(
        (math.prod(Fraction(x) ** k for x, k in zip(row, powers, strict=True)) for row in rows), Fraction(0)
    )


@given(st.lists(FLOATS, max_size=20))
def test_of_one_column(x: list[float]) -> None:
    part = moments([np.array(x)], ONE)
    assert part.count == len(x)
    assert [Fraction(s, 2 ** (UNIT * k)) for k, s in enumerate(part.sums, 1)] == [exact([x], k) for k in ONE]


@given(st.lists(st.tuples(FLOATS, FLOATS), max_size=20))
def test_of_two_columns(rows: list[tuple[float, float]]) -> None:
    columns = [[row[i] for row in rows] for i in (0, 1)]
    part = moments([np.array(x) for x in columns], TWO)
    for powers, s in zip(TWO, part.sums, strict=True):
        assert Fraction(s, 2 ** (UNIT * sum(powers))) == exact(columns, powers)


def test_of_full_limbs_and_many_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """The largest mantissas, as many as a product of matrices takes and more: no sum of limbs loses its last bit."""
    integers = 2**53 - 1 - 2 * np.random.default_rng(0).integers(0, 2**10, 3 * exact_moments._CHUNK + 5)
    monkeypatch.setattr(exact_moments, "_LARGEST", 2 * exact_moments._CHUNK)  # also in two runs of chunks
    part = moments([-integers.astype(float)], ONE)
    values, counts = np.unique(integers, return_counts=True)
    for k, s in enumerate(part.sums, 1):
        exact = sum(n * (-x) ** k for x, n in zip(values.tolist(), counts.tolist(), strict=True))
        assert s == exact << UNIT * k


def test_weights_in_all_blocks_or_in_none() -> None:
    with pytest.raises(
        SimulationError, match="Expected weights in all blocks of a study or in none, got both"
    ):
        Moments(((1,),), 0, (0,)).merge(Moments(((1, 1),), 0, (0,)))


def test_quotient() -> None:
    assert quotient(1, 3, "a mean") == 1 / 3
    assert math.isnan(quotient(1, 0, "a mean"))
    with pytest.raises(SimulationError, match="Expected a variance below 1.8e308, got a larger one. Divide"):
        quotient(1 << 2000, 1, "a variance")


@given(st.integers(0, 1 << 4000), st.integers(1, 1 << 4000))
def test_square_root(p: int, q: int) -> None:
    """r (1 - 2^-53) <= sqrt(p/q) <= r (1 + 2^-53), but for the 64 bits of the integer root and underflow."""
    try:
        root = square_root(p, q)
    except OverflowError:
        assert p > q << 2047
        return
    bound = Fraction(1, 2**53) + Fraction(1, 2**62)
    if root > 2.3e-308:
        assert (Fraction(root) * (1 - bound)) ** 2 <= Fraction(p, q) <= (Fraction(root) * (1 + bound)) ** 2


def test_square_root_of_nothing() -> None:
    assert math.isnan(square_root(-1, 1)) and math.isnan(square_root(0, 0))
