"""Records of lanes: one source and one declaration serve one run and eight side by side, with the same bits."""

from __future__ import annotations

import ctypes
import math
from typing import Annotated

import numpy as np
import pytest

from freebody.native import codegen
from freebody.native.functions import Compiled, components, each
from freebody.native.instructions import Reals, Truth, compiled, greater, maximum, where
from freebody.native.records import (
    Alone,
    Count,
    Kernel,
    Real,
    Record,
    Row,
    Rows,
    Whole,
    Wholes,
    record,
    record_of_lanes,
)
from freebody.native.rows import chain, combination
from freebody.native.translation import translated

WEIGHTS = {0: 0.25, 1: 0.5, 2: -1.5}
LANES = 8


@record_of_lanes
class Limits(Record):
    count: Count
    g: Annotated[Row, "count"]


@record_of_lanes
class Run(Record):
    t: Real
    h: Real
    taken: Whole
    n: Count
    width: Count
    rates: Kernel
    c: Annotated[Row, 1]
    signs: Annotated[Wholes, "n"]
    y: Annotated[Row, "width"]
    k: Annotated[Rows, 3, "width"]
    limits: Limits


OneRun = Alone(Run)


@compiled
def rates(t: float, y: Reals, c: Reals, out: Reals) -> None:
    for i in range(5):
        out[i] = c[0] * y[i] + t


@compiled
def rates_of_lanes(t: Row, y: Row, c: Row, out: Row) -> None:
    for i in range(5):
        out[i] = c[0] * y[i] + t[0]


@compiled
def growth(run: Run) -> Real:
    """Largest |k[1]| t or |y|."""
    result: Real = -math.inf
    for i in components(run.n):
        result = maximum(result, abs(run.k[1, i]) * run.t)
        result = maximum(result, abs(run.y[i]))
    return result


@compiled
def most(run: Run, good: Truth) -> Real:
    """Largest |k[1]| where good, 0 elsewhere."""
    result: Real = 0.0
    for i in range(run.n):
        result = greater(result, abs(run.k[1, i]))
        run.limits.g[0] = run.k[1, i]
    return where(good, result, 0.0)


@compiled
def step(run: Run) -> None:
    run.rates(run.t, run.y, run.c, run.k[0])
    run.k[2][:] = run.y + run.h * chain(WEIGHTS, run.k)
    run.k[1][:] = where(run.h > 0.5, run.y + run.h * combination(WEIGHTS, run.k), run.y)
    size = most(run, run.t > 0.0)
    while any(size > 2.0):
        run.taken = where(size > 2.0, run.taken + 1, run.taken)
        size = where(size > 2.0, 0.5 * size, size)
    run.h = size + growth(run)


@compiled
def lifted(run: Run, one: OneRun) -> float:
    """The lanes with h > 0.5, one after the other, in the memory of one run."""
    total, lost = 0.0, run.h
    for lane in each(run.h > 0.5):
        one.t = run.t[lane]
        for i in range(run.n):
            one.y[i] = run.y[i][lane]
            run.y[i][lane] = -1.0
        one.rates(one.t, one.y, one.c, one.k[0])
        run.taken[lane] += 3
        lost[lane] = one.k[0, 4]
        total += one.k[0, 4]
    run.h = lost
    return total


def code(lanes, **functions):
    text, _ = codegen.optimised_code(translated(functions, lanes))
    library = codegen.Library(text)
    return library, library.addresses(functions)


def called(library, address, *records, result=None):
    return ctypes.CFUNCTYPE(result, *[ctypes.c_void_p] * len(records))(address)(*(r.address for r in records))


def numbers(rng):
    """A row of one run is continued by zeros, so that its largest result is not negative."""
    return {
        "t": rng.random(LANES), "h": rng.random(LANES), "c": rng.normal(size=(1, LANES)),
        "y": rng.normal(size=(5, LANES)),
    }  # fmt: skip


@pytest.fixture(scope="module")
def built():
    one = code(1, step=step, lifted=lifted, rates=rates)
    eight = code(LANES, step=step, lifted=lifted, rates_of_lanes=rates_of_lanes)
    return one, eight


def a_run(kernel, values, lane=None):
    if lane is None:
        run = Run.of(LANES).made(n=5, width=5, count=1)
        run.t, run.h, run.c[:], run.y[:] = values["t"], values["h"], values["c"], values["y"]
    else:
        run = Run.made(n=5, width=8, count=1)
        run.t, run.h = values["t"][lane], values["h"][lane]
        run.c[:], run.y[:5] = values["c"][:, lane], values["y"][:, lane]
    run.rates = kernel
    return run


@pytest.mark.parametrize("seed", range(5))
def test_a_lane_is_the_run_that_it_would_be_alone(built, seed):
    (one, of_one), (eight, of_eight) = built
    values = numbers(np.random.default_rng(seed))
    together = a_run(of_eight["rates_of_lanes"], values)
    called(eight, of_eight["step"], together)
    for lane in range(LANES):
        alone = a_run(of_one["rates"], values, lane)
        called(one, of_one["step"], alone)
        assert (alone.h, alone.taken, alone.limits.g[0]) == (
            together.h[lane], together.taken[lane], together.limits.g[0, lane],
        )  # fmt: skip
        assert np.array_equal(alone.k[:, :5], together.k[:, :, lane])


def test_what_is_rare_goes_lane_by_lane_through_the_memory_of_one_run(built):
    (one, of_one), (eight, of_eight) = built
    values = numbers(np.random.default_rng(7))
    chosen = values["h"] > 0.5
    assert 1 < chosen.sum() < LANES
    together, single = a_run(of_eight["rates_of_lanes"], values), a_run(of_one["rates"], values, 0)
    total = called(eight, of_eight["lifted"], together, single, result=ctypes.c_double)
    ends = values["c"][0, 0] * values["y"][4] + values["t"]  # c is that of the memory of one run
    assert total == pytest.approx(ends[chosen].sum(), rel=1e-14)
    assert np.array_equal(together.h, np.where(chosen, ends, values["h"]))
    assert np.array_equal(together.taken, np.where(chosen, 3, 0))
    assert (together.y[:, chosen] == -1).all() and np.array_equal(
        together.y[:, ~chosen], values["y"][:, ~chosen]
    )


def test_the_layout_for_eight_lanes():
    """Every field takes as many words as there are lanes; counts, kernels and rows of integers are those of all."""
    wide = Run.of(LANES)
    assert wide is Run.of(LANES) and Run.of(1) is Run is wide.of(1) and Limits.of(LANES).lanes == LANES
    assert wide.size == LANES * Run.size and wide.fields["h"].place == LANES * Run.fields["h"].place
    run = wide.made(n=5, width=5, count=2)
    run.taken = np.arange(8)
    run.limits.g[1] = 2.0
    assert (run.n, run.limits.count, run.signs.shape, run.k.shape) == (5, 2, (5,), (3, 5, LANES))
    assert run.taken.tolist() == list(range(8)) and run.limits.g.tolist() == [[0.0] * 8, [2.0] * 8]
    view = run.memory[: run.size // 8].view(wide.dtype)[0]
    assert view["taken"].tolist() == list(range(8)) and view["n"] == 5
    with pytest.raises(TypeError, match="contiguous array of float64 with 2 dimensions for 'y'"):
        run.y = np.zeros(40)


@record
class Plain(Record):
    t: Real


def test_a_record_of_lanes_has_no_other_records_inside():
    class Outer(Record):
        inner: Plain

    with pytest.raises(
        TypeError, match=r"(?s)Expected a record of lanes inside 'Outer', got 'Plain'.*@record_of_lanes"
    ):
        record_of_lanes(Outer)
    assert Plain.of(LANES) is Plain


def number_of_no_lane(record: Plain, x: float) -> float:
    return x[0]


def type_without_lanes(run: Run) -> None:
    y: Row = run.y
    y[0] = 0.0


def field_with_a_type(run: Run) -> None:
    run.t: Real = 0.0


@pytest.mark.parametrize(
    ("function", "parts"),
    [
        (number_of_no_lane, ("an array that has components", "'x[0]'")),
        (type_without_lanes, ("a type and a first value for a name", "'y: Row = run.y'", "x: Real = 0.0")),
        (field_with_a_type, ("a type and a first value for a name", "'run.t: Real = 0.0'")),
    ],
)
def test_misuse_is_refused_with_its_line_and_cure(function, parts):
    with pytest.raises(TypeError) as refusal:
        translated({"f": Compiled(function)}, LANES)
    for part in (*parts, "test_records_of_lanes.py, line "):
        assert part in str(refusal.value), refusal.value
