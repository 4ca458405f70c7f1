"""Grids: all combinations, the last name fastest."""

from __future__ import annotations

import itertools
import time

import numpy as np
import pytest

import freebody as fb
from freebody.errors import SimulationError


def test_a_grid_is_the_product_of_its_axes() -> None:
    axes = {"a": [1.0, 5.0, 2.0], "b": [0.25], "c": [7.0, -1.0, 0.5, 9.0]}
    law = fb.grid(axes)
    rows = np.array(list(itertools.product(*axes.values())))
    columns = law.columns(0, law.count)
    assert law.shape == (3, 1, 4) and law.count == 12
    for j, name in enumerate(axes):
        assert np.array_equal(columns[name], rows[:, j])


def test_a_huge_grid_is_index_arithmetic() -> None:
    """Digits of the number of the lane; a block of one lane takes some 10 µs an axis."""
    law = fb.grid({f"x{i}": range(10) for i in range(12)})
    assert law.count == 10**12
    clock = time.process_time()
    for lane in (0, 123_456_789_012, 10**11 - 1, 10**11, 10**12 - 1):
        columns = law.columns(lane, lane + 1)
        assert "".join(str(int(x[0])) for x in columns.values()) == f"{lane:012d}"
    assert time.process_time() - clock < 0.05
    across = law.columns(999_999_999_990, 10**12)
    assert np.array_equal(across["x11"], np.arange(10.0)) and (across["x0"] == 9).all()


def test_print() -> None:
    assert repr(fb.grid(I=[1, 2, 3], theta=np.linspace(0, 1, 200))) == "grid of 3 I × 200 theta: 600 lanes"
    assert repr(fb.grid(I=[1])) == "grid of 1 I: 1 lane"


def test_a_dataset_takes_the_shape_of_the_grid() -> None:
    s = fb.System("stone")
    g = s.parameters(g=9.81)
    s.gravity = (0, -g, 0)
    s.slider("up", s.ground, s.body("stone", fb.particle(1)), axis="y", coordinate="y")
    law = fb.grid({"g": [1.0, 2.0], "y'": [3.0, 4.0, 5.0]}).resolved(fb.assemble(s))
    columns = law.columns(0, 6)
    data = fb.simulate(s, 1, values={"g": columns["g"]}, initial={"y'": columns["y'"]}, outputs="final(y)")
    shaped = law.shaped(data)
    assert shaped["final(y)"].dims == ("g", "y'_start")
    exact = shaped["y'_start"] - shaped["g"] / 2
    assert np.allclose(shaped["final(y)"], exact.transpose("g", "y'_start"), rtol=1e-12)
    assert shaped.identical(fb.sweep(s, {"g": [1, 2], "y'": [3, 4, 5]}, 1, outputs="final(y)"))


@pytest.mark.parametrize(
    ("axes", "message"),
    [
        (
            {"L": []},
            r"at least one number for 'L' in the grid, got \[\]\. Write fb.grid\({'L': \[1, 2, 3\]}\)",
        ),
        ({"L": 2}, "at least one number for 'L' in the grid, got 2"),
        ({"L": [[1, 2]]}, "at least one number for 'L' in the grid"),
        ({"L": [1, 1.0]}, "Expected different numbers for 'L' in the grid"),
        ({"L": ["1 m", "1 m"]}, "Expected different numbers for 'L' in the grid"),
        ({"L": [1, np.nan]}, "Expected finite numbers for 'L' in the grid"),
        ({"L": [1, 2j]}, "Expected numbers for 'L' in the grid"),
        ({"L": [None, {}]}, "Expected numbers for 'L' in the grid"),
        ({"L": {1, 2}}, "Expected numbers for 'L' in the grid"),
        ({"L": np.array(["2026-01-01"], dtype="M8[D]")}, "Expected numbers for 'L' in the grid"),
        ({"L": [[1], [1, 2]]}, "Expected numbers for 'L' in the grid"),
        ({f"x{i}": range(10) for i in range(13)}, r"Expected fewer than 10\^12 runs. Vary fewer"),
    ],
)
def test_refusals(axes: dict, message: str) -> None:
    with pytest.raises(SimulationError, match=message):
        fb.grid(axes)


def test_units_may_make_numbers_equal() -> None:
    s = fb.System("x")
    s.parameters(L=1.0)
    s.body("b", fb.particle(1))
    s.hinge("pin", s.ground, "b", to=(0, "L", 0), axis="z", coordinate="theta")
    with pytest.raises(SimulationError, match="Expected different numbers for 'L' in lanes"):
        fb.grid(L=["1 m", "100 cm"]).resolved(fb.assemble(s))
