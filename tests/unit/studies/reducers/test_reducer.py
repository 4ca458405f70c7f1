"""Any blocks, merged in any order, give the same state; groups; numbers without a value; refusals."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import freebody as fb
from freebody.errors import SimulationError
from freebody.studies.identity.content_digest import digest
from freebody.studies.reducers.reducer import GROUPS, Reducer, State

FLOATS = st.floats(allow_nan=False, allow_infinity=False)
NUMBERS = st.one_of(
    FLOATS,
    st.sampled_from([0.0, -0.0, 5e-324, -5e-324, 2.2e-308, 1e6, -1.5]),  # ties
    st.floats(1, 2),
    st.floats(-1e-3, 1e-3).map(lambda x: 1e6 + x),
)
REDUCERS = [
    fb.mean("max(x)"),
    fb.mean("max(x) > 1", by="floor(b)"),
    fb.variance("max(x)/1e160"),
    fb.covariance("max(x)/1e160", "max(y)/1e160"),
    fb.quantile("max(x)", [0, 0.01, 0.5, 0.9, 1], buckets=16),
    fb.quantile("max(x)", 0.5, by=["floor(b)", "c"], buckets=17),
    fb.histogram("max(x)", 3),
    fb.histogram("max(x)", 7, by="floor(b)"),
    fb.histogram("max(x)", 5, range=(-1, 1e6)),
    fb.largest("max(x)", 3),
    fb.smallest("max(x)", 2, by="c"),
]


def columns_of(rows: list[tuple[float, float, float]]) -> dict[str, Any]:
    x, y, b = np.array(rows, dtype=float).reshape(-1, 3).T
    return {"max(x)": x, "max(y)": y, "b": b, "c": np.floor(b) % 2}


def merged(states: list[State], draw: Any) -> State:
    """Merge two states that are drawn, until one is left; each has been to another process."""
    states = list(states)
    while len(states) > 1:
        first = states.pop(draw(st.integers(0, len(states) - 1)))
        second = states.pop(draw(st.integers(0, len(states) - 1)))
        states.append(pickle.loads(pickle.dumps(first)).merge(pickle.loads(pickle.dumps(second))))
    return states[0]


@pytest.mark.parametrize("reducer", REDUCERS, ids=str)
@settings(max_examples=50)  # the first call imports SciPy and xarray
@given(rows=st.lists(st.tuples(NUMBERS, NUMBERS, st.floats(-2, 2)), min_size=1, max_size=60), data=st.data())
def test_blocks_and_their_order_change_no_bit(reducer: Reducer, rows: Any, data: Any) -> None:
    n = len(rows)
    columns, lanes = columns_of(rows), np.arange(n) + 1000
    whole = reducer.of(columns, lanes)
    order = np.array(data.draw(st.permutations(range(n))))
    cuts = sorted(data.draw(st.lists(st.integers(0, n), max_size=6)))  # blocks may be empty
    blocks = np.split(order, cuts)
    states = [reducer.of({k: x[block] for k, x in columns.items()}, lanes[block]) for block in blocks]
    state = merged(states, data.draw)
    assert digest(state) == digest(whole)
    assert pickle.dumps(reducer.result(state).to_dict()) == pickle.dumps(reducer.result(whole).to_dict())


@given(rows=st.lists(st.tuples(NUMBERS, st.floats(0, 1e6)), min_size=1, max_size=60), data=st.data())
def test_the_same_with_weights(rows: Any, data: Any) -> None:
    reducer = fb.mean("x/1e80")
    x, weights = np.array(rows).T
    lanes = np.arange(len(rows))
    blocks = np.split(
        np.array(data.draw(st.permutations(range(len(rows))))), [data.draw(st.integers(0, len(rows)))]
    )
    states = [reducer.of({"x": x[b]}, lanes[b], weights[b]) for b in blocks if b.size]
    assert digest(merged(states, data.draw)) == digest(reducer.of({"x": x}, lanes, weights))


@pytest.mark.parametrize("reducer", REDUCERS, ids=str)
def test_more_lanes_take_no_more_memory(reducer: Reducer) -> None:
    """A state has at most ``entries`` entries of 16 bytes for each group; sums grow by log2 of the lanes."""
    rng = np.random.default_rng(1)
    rows = rng.normal(size=(20000, 3)).tolist()
    sizes = []
    state = None
    for low in range(0, 20000, 2500):
        part = reducer.of(columns_of(rows[low : low + 2500]), np.arange(low, low + 2500))
        state = part if state is None else state.merge(part)
        sizes.append(len(pickle.dumps(state)))
    assert state is not None
    assert sizes[-1] <= len(state.parts) * (16 * reducer.entries + 3000) + 1000


def test_a_reducer_is_a_value() -> None:
    for reducer in REDUCERS:
        again = pickle.loads(pickle.dumps(reducer))
        assert again == reducer and digest(again) == digest(reducer) and hash(again) == hash(reducer)
    assert len({digest(reducer) for reducer in REDUCERS}) == len(REDUCERS)


@pytest.mark.parametrize(
    "text",
    [
        "mean('max(x) > 1', by='floor(b)')",
        "variance('max(x)')",
        "covariance('max(x)', 'I', missing=\"skip\")",
        "quantile('max(x)', [0.5, 0.9])",
        "quantile('max(x)', 0.5, buckets=64, by=['a', 'b'])",
        "histogram('max(x)', 20, range=(0.0, 1.0))",
        "largest('max(x)', 3)",
        "smallest('end', 2)",
    ],
)
def test_a_reducer_prints_the_call_that_makes_it(text: str) -> None:
    reducer = eval(f"fb.{text}")
    assert repr(reducer) == text
    assert eval(f"fb.{reducer!r}") == reducer


def test_what_a_reducer_reads() -> None:
    reducer = fb.covariance(
        "max(theta') + end", "final(x)*I", by=["I", "event_count['hit']", "final(floor.mode)"]
    )
    assert reducer.wanted == ("max(theta')", "final(x)", "final(floor.mode)")
    assert reducer.names == ("end", "I", 'event_count["hit"]')
    reducer.check(["I", "end", 'event_count["hit"]', "steps"])
    with pytest.raises(
        SimulationError, match="Unknown name 'I' in covariance.* known names: end, .*max\\(I\\)"
    ):
        reducer.check(["end", 'event_count["hit"]'])


# -- groups --------------------------------------------------------------------------------------------------


def test_groups() -> None:
    """Each group has the result of its lanes alone; -0 and 0 are one group."""
    x, a, b = np.arange(6.0), np.array([1, 1, -0.0, 0.0, 1, 2]), np.array([5.0, 5, 5, 5, 7, 5])
    reducer = fb.mean("x", by=["a", "b"])
    data = reducer.result(reducer.of({"x": x, "a": a, "b": b}, np.arange(6)))
    assert data.a.values.tolist() == [0, 1, 2] and data.b.values.tolist() == [5, 7]
    assert data["value"].dims == ("a", "b")
    np.testing.assert_array_equal(data["value"], [[2.5, np.nan], [0.5, 4], [5, np.nan]])
    np.testing.assert_array_equal(data["count"], [[2, 0], [2, 1], [1, 0]])
    assert data.summary == "3 a x 2 b (6 runs)"
    for key, rows in {(0.0, 5.0): [2, 3], (1.0, 5.0): [0, 1]}.items():
        alone = fb.mean("x").result(fb.mean("x").of({"x": x[rows]}, np.array(rows)))
        part = data.sel(a=key[0], b=key[1])
        assert [part[k].item() for k in ("value", "error")] == [alone[k].item() for k in ("value", "error")]


def test_no_lanes() -> None:
    empty = np.zeros(0)
    for reducer in REDUCERS:
        data = reducer.result(reducer.of({k: empty for k in ("max(x)", "max(y)", "b", "c")}, empty))
        assert data["count"].sum() == 0
    data = fb.mean("x").result(fb.mean("x").of({"x": empty}, empty))
    assert np.isnan(data["value"]) and np.isnan(data["error"]) and data.summary == "nan (0 runs)"


def test_too_many_groups() -> None:
    n = GROUPS + 1
    reducer = fb.mean("x", by="a")
    lanes = np.arange(n)
    message = (
        rf"Expected at most {GROUPS} groups by a, got {n}. Group by fewer names, .* by=\"floor\(a\)\"\.$"
    )
    with pytest.raises(SimulationError, match=message):
        reducer.of({"x": lanes, "a": lanes}, lanes)
    halves = [
        reducer.of({"x": lanes[half], "a": lanes[half]}, lanes[half]) for half in (slice(9), slice(9, n))
    ]
    with pytest.raises(SimulationError, match=message):
        halves[0].merge(halves[1])
    with pytest.raises(SimulationError, match="at most 4096 groups by a, b, got 70 x 70"):
        fb.mean("x", by=["a", "b"]).of({"x": lanes[:70], "a": lanes[:70], "b": lanes[:70]}, lanes[:70])
    many = fb.largest("x", 1 << 16, by="a")
    with pytest.raises(
        SimulationError, match="at most 16 groups by a, got 17.*or take fewer buckets, bins or values"
    ):
        many.of({"x": lanes[:17], "a": lanes[:17]}, lanes[:17])


def test_names_of_groups_are_checked() -> None:
    with pytest.raises(
        SimulationError, match="Expected other names for by= of mean than value, .*, got 'count'. Write"
    ):
        fb.mean("x", by="count")
    fb.mean("x", by="count + 0")
    with pytest.raises(SimulationError, match="each once, got 'a'"):
        fb.mean("x", by=["a", "a"])
    with pytest.raises(SimulationError, match="Expected a name or a list of names for by= of mean, got 3"):
        fb.mean("x", by=3)
    with pytest.raises(SimulationError, match="Expected a number of a run for by= of mean"):
        fb.mean("x", by=[3])


# -- numbers without a value ------------------------------------------------------------------------------------


def test_a_number_without_a_value_names_the_lane() -> None:
    x = np.array([1.0, np.nan, 2.0, np.inf])
    lanes = np.array([9, 8, 7, 6])
    message = (
        r"Expected a finite number in every run for mean\('2\*x'\), but '2\*x' has none in lane 6: "
        'missing="skip" leaves such runs out'
    )
    with pytest.raises(SimulationError, match=message):
        fb.mean("2*x").of({"x": x}, lanes)
    skip = fb.mean("2*x", missing="skip")
    state = skip.of({"x": x}, lanes).merge(skip.of({"x": x[:2]}, lanes[:2]))
    data = skip.result(state)
    assert (data["missing"].item(), data["count"].item(), data["value"].item()) == (3, 3, 8 / 3)
    both = fb.covariance("x", "y", missing="skip")
    data = both.result(both.of({"x": x, "y": np.array([np.nan, 1, 2, 3])}, lanes))
    assert (data["missing"].item(), data["count"].item()) == (3, 1)
    with pytest.raises(SimulationError, match="for covariance.*but 'y' has none in lane 9"):
        fb.covariance("x", "y").of({"x": x[::2], "y": np.array([np.nan, 1])}, lanes[:2])


def test_the_time_of_an_event_that_did_not_happen_has_a_cure() -> None:
    name = 'event_time["hit"]'
    with pytest.raises(
        SimulationError, match='in lane 0: an event .* may begin with event_count."hit". > 0 and; missing'
    ):
        fb.mean(f"{name} < 3").of({name: np.array([np.nan])}, [0])


def test_a_group_needs_a_value() -> None:
    with pytest.raises(SimulationError, match="but 'a' has none in lane 5"):
        fb.mean("x", by="a", missing="skip").of({"x": [1.0], "a": [np.nan]}, [5])


def test_missing_is_a_word() -> None:
    for word in ("ignore", None, ["skip"]):
        with pytest.raises(SimulationError, match='Expected missing="raise" or missing="skip" for mean, got'):
            fb.mean("x", missing=word)  # type: ignore[arg-type]


# -- weights -----------------------------------------------------------------------------------------------------


def test_weights_are_checked() -> None:
    with pytest.raises(
        SimulationError, match=r"Expected no weights for variance\('x'\): only fb.mean takes them"
    ):
        fb.variance("x").of({"x": [1.0]}, [0], [1.0])
    for weight in (-1.0, np.nan, np.inf):
        with pytest.raises(
            SimulationError, match="one finite weight of at least 0 for each lane, got lane 4"
        ):
            fb.mean("x").of({"x": [1.0, 2.0]}, [3, 4], [1.0, weight])
    with pytest.raises(SimulationError, match=r"for each lane, got the shape \(1,\)"):
        fb.mean("x").of({"x": [1.0, 2.0]}, [3, 4], [1.0])


def test_every_result_tells_what_its_errors_mean() -> None:
    data = fb.mean("x").result(fb.mean("x").of({"x": [1.0, 2.0]}, [0, 1]), failures=3, failed="skip")
    assert "Owen 1997" in data.attrs["errors"] and data.attrs["reducer"] == "mean('x')"
    assert data["failed"].item() == 3 and data["failed"].attrs["long_name"] == "runs that failed, left out"
    assert data.summary == "1.50 ± 0.5 (2 runs)"
