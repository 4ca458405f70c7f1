"""Tables: one row, one lane, from everything that has columns."""

from __future__ import annotations

import pickle

import numpy as np
import pandas
import pytest
import xarray

import freebody as fb
from freebody.errors import SimulationError
from freebody.studies.identity.content_digest import digest

INERTIA, RATE = [0.3, 0.5, 0.4], [1, 2, 4]
FRAME = pandas.DataFrame({"I": INERTIA, "theta'": RATE})


@pytest.mark.parametrize(
    "data",
    [
        {"I": INERTIA, "theta'": RATE},
        {"I": tuple(INERTIA), "theta'": np.array(RATE)},
        FRAME,
        FRAME.set_index(np.array([7, 8, 9])),
        FRAME.to_xarray(),
        FRAME.astype(object),
        FRAME.to_records(index=False),
        np.array(list(zip(INERTIA, RATE, strict=True)), dtype=[("I", "f8"), ("theta'", "i4")]),
    ],
    ids=["lists", "tuple", "frame", "index", "dataset", "objects", "records", "structured"],
)
def test_all_kinds_of_tables_are_one(data) -> None:
    law = fb.table(data)
    assert digest(law) == digest(fb.table({"I": INERTIA, "theta'": RATE}))
    columns = law.columns(0, 3)
    assert columns["I"].tolist() == INERTIA and columns["theta'"].tolist() == RATE
    assert repr(law) == "table of I, theta': 3 lanes"


def test_a_part_sends_its_rows_only_and_keeps_the_numbers() -> None:
    law = fb.table(I=np.arange(1e5))
    part = pickle.loads(pickle.dumps(law.part(50_000, 50_003)))
    assert part.count == 100_000 and part.columns(50_001, 50_003)["I"].tolist() == [50_001, 50_002]
    assert part.part(50_001, 50_002).columns(50_001, 50_002)["I"] == 50_001
    for low, high in ((49_999, 50_001), (50_002, 50_004)):
        with pytest.raises(
            SimulationError, match=f"lanes 50000 to 50003, .* part of a table .* got {low} to {high}"
        ):
            part.columns(low, high)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"I": [1, 2], "m": [1]}, r"one length in the table, got 2 values of 'I' and 1 of 'm'.*use fb.grid"),
        ({"I": 2}, "one number for each lane for 'I' in the table, got shape \\(\\)"),
        ({"I": []}, "one number for each lane for 'I'"),
        ({"I": [[1], [2]]}, r"one number for each lane for 'I' in the table, got shape \(2, 1\)"),
        ({"I": [1, np.inf]}, "finite numbers for 'I' in the table, got inf in row 1. Leave that row out"),
        ({"I": [1, None]}, "finite numbers for 'I' in the table, got nan in row 1"),
        ({"I": ["1", {}]}, None),
        ({"I": [1, {}]}, "Expected numbers for 'I' in the table"),
        ({}, r"Expected values by name, such as fb.table\("),
        (3, "Expected a pandas.DataFrame, an xarray.Dataset, a structured array, .* got 3"),
        (np.eye(2), "Expected a pandas.DataFrame"),
        (pandas.DataFrame([[1, 2]], columns=["I", "I"]), "Expected each name once in the table, got 'I' twice"),
        (pandas.DataFrame({"I": []}), "one number for each lane for 'I'"),
        (xarray.Dataset({"I": (("a", "b"), np.eye(2))}), "a dataset with one dimension, .* got {'a': 2, 'b': 2}"),
        (xarray.Dataset({"I": 3.0}), "a dataset with one dimension"),
        (xarray.Dataset(coords={"I": ("lane", [1.0])}), r"coordinates only: I. Write fb.table\(dataset.reset"),
    ],
)  # fmt: skip
def test_refusals(data, message: str | None) -> None:
    if message is None:  # texts wait for the model
        assert fb.table(data).count == 2
        return
    with pytest.raises(SimulationError, match=message):
        fb.table(data)


def test_the_cures_work() -> None:
    grid = xarray.Dataset({"I": (("a", "b"), np.arange(4.0).reshape(2, 2))})
    flat = grid.stack(lane=["a", "b"]).reset_index("lane").reset_coords()
    assert fb.table(flat[["I"]]).columns(0, 4)["I"].tolist() == [0, 1, 2, 3]
    assert fb.table(xarray.Dataset(coords={"I": ("lane", [1.0])}).reset_coords()).names == ("I",)
