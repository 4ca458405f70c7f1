"""The extreme values are those of the sorted lanes; equal values stand in the order of the lanes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import freebody as fb
from freebody.errors import SimulationError

VALUES = st.lists(st.sampled_from([-0.0, 0.0, 1.0, 2.0, 5e-324, -1e308]), min_size=1, max_size=60)


@given(VALUES, st.integers(1, 7), st.booleans())
def test_against_sorting(x: list[float], n: int, greatest: bool) -> None:
    lanes = np.arange(len(x))[::-1] * 3
    reducer = (fb.largest if greatest else fb.smallest)("x", n)
    data = reducer.result(reducer.of({"x": np.array(x)}, lanes))
    rows = sorted(((-v if greatest else v) + 0.0, lane) for v, lane in zip(x, lanes.tolist(), strict=True))[
        :n
    ]
    assert data["lane"].values.tolist() == [lane for _, lane in rows]
    assert data["value"].values.tolist() == [-v if greatest else v for v, _ in rows]
    assert data["rank"].values.tolist() == list(range(1, len(rows) + 1)) and data["count"] == len(x)


def test_a_group_with_fewer_lanes() -> None:
    reducer = fb.largest("x", 2, by="a")
    data = reducer.result(reducer.of({"x": np.array([1.0, 2, 3]), "a": np.array([0.0, 0, 1])}, np.arange(3)))
    np.testing.assert_array_equal(data["value"], [[2, 1], [3, np.nan]])
    assert data["lane"].values.tolist() == [[1, 0], [2, -1]]
    assert "error" not in data


@pytest.mark.parametrize("n", [0, 65537, 1.0, True])
@pytest.mark.parametrize("name", ["largest", "smallest"])
def test_refused_numbers(name: str, n: Any) -> None:
    with pytest.raises(SimulationError, match=f"Expected from 1 to 65536 for n= of {name}, got"):
        getattr(fb, name)("x", n)
