"""The data of a page: what is packed is what is read, values over time to a step that nobody sees."""

from __future__ import annotations

import numpy as np
import pytest

from freebody.picture.page.browser import chromium
from freebody.picture.page.packing import FINE, SINGLE, packed
from freebody.picture.page.page import script
from page_browser import PageBrowser
from page_data import unpacked

RANDOM = np.random.default_rng(0)
T = np.linspace(0, 10, 501)
VALUES = {
    "smooth": np.sin(T),
    "noise": RANDOM.normal(size=501),
    "jump": np.where(T > 5, -1e6, 1e-3 * T),
    "still": np.full(501, 1e9),
    "nothing": np.zeros(501),
    "far": 1e4 + 1e-3 * np.sin(T),
    "vector": np.column_stack([np.cos(3 * T), np.zeros(501), -T]),
    "one": np.array([2.5]),
}


def coarse(values: np.ndarray) -> np.ndarray:
    """Half a step of each column, and the round-off of a 32-bit float."""
    single = np.abs(values).max(axis=0) * 2.0**-SINGLE
    return np.maximum(np.ptp(values, axis=0) * 2.0**-FINE, single) / 2 + single


@pytest.mark.parametrize("name", VALUES)
def test_values_over_time_are_within_half_a_step(name: str) -> None:
    read = unpacked(packed({"x": VALUES[name]}))["x"]
    assert read.shape == VALUES[name].shape
    assert (np.abs(read - VALUES[name]) <= coarse(VALUES[name])).all()


def test_decimals_stay_themselves_and_equal_moments_stay_equal() -> None:
    values = np.array([0.3, 0.0, 0.7, 0.7, -1.1])
    read = unpacked(packed({"x": values}))["x"]
    assert read[1] == 0 and read[2] == read[3] and (read == values.astype(np.float32)).all()


def test_other_arrays_are_exact_and_what_is_equal_is_stored_once() -> None:
    exact = {
        "t": RANDOM.normal(size=40).astype(np.float32),
        "faces": RANDOM.integers(0, 2**32, 30).astype(np.uint32),
        "closed": RANDOM.integers(0, 2, 20).astype(np.uint8),
        "unknown": np.array([1.5, np.nan]),
        "tree": [{"name": "</script>", "number": 1.25}],
    }
    read = unpacked(packed(exact))
    for name in ("t", "faces", "closed"):
        assert np.array_equal(read[name], exact[name])
    assert read["unknown"][0] == 1.5 and np.isnan(read["unknown"][1]) and read["tree"] == exact["tree"]
    noise = RANDOM.normal(size=2000)
    assert len(packed({"a": noise, "b": noise.copy()})) < 1.1 * len(packed({"a": noise}))
    with pytest.raises(TypeError, match="no data of a page"):
        packed({"x": {1, 2}})


@pytest.mark.skipif(chromium() is None, reason="no Chromium on this machine")
def test_the_page_reads_the_same_numbers() -> None:
    text = packed({**VALUES, "t": T.astype(np.float32), "closed": np.array([0, 1], dtype=np.uint8)})
    expected = unpacked(text)
    code = script(("data.js",)).removeprefix("(() => {").removesuffix("})();\n")
    with PageBrowser() as browser:
        browser.ask("Page.navigate", url="about:blank")
        read = browser.value(
            f"{code}; unpacked('{text}').then((data) => Object.entries(data).map(([name, x]) => [name, [...x]]))"
        )
    assert {name for name, _ in read} == {*expected}
    for name, x in read:
        assert np.array_equal(np.array(x, dtype=np.float32), expected[name].ravel().astype(np.float32)), name
