"""Texts over the animation: none on another text or on the head of an arrow, none cut, and none that jumps."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

import freebody as fb
from freebody.gallery import entries
from freebody.picture.page.browser import chromium
from page_browser import PageBrowser

pytestmark = pytest.mark.skipif(chromium() is None, reason="no Chromium on this machine")

NAMES = list(dict.fromkeys(entry.name for entry in entries().values()))
MOMENTS = (0, 0.13, 0.44, 0.75)
"""Of the motion, at which its picture is looked at."""

CROWD = """
(() => {
  const random = (k) => (1e4 * Math.abs(Math.sin(k + 1))) % 1, before = {};
  const points = Array.from({ length: 40 }, (_, k) => [300 + 200 * random(2 * k), 150 + 150 * random(2 * k + 1)]);
  const full = points.slice(0, 10).map(([x, y]) => [x - 6, y - 6, x + 6, y + 6]);
  const text = ([x, y], key, by) => ({ key, at: [x + by, y], wide: 90, high: 15, toward: null });
  const place = (by) => placeTexts(points.map((at, k) => text(at, k, by)), [900, 500], full, [], [], before, 1);
  return [place(0), place(1)].map((list) => list.map((one) => one && [...one.box, one.number]));
})()
"""


@pytest.fixture(scope="module")
def browser() -> Iterator[PageBrowser]:
    with PageBrowser(1000, 800) as one:
        yield one


def overlapping(boxes: list[Any], others: list[Any]) -> list[Any]:
    return [
        (a, b)
        for a in boxes
        for b in others
        if a is not b and a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
    ]


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_no_text_lies_on_a_text_or_on_a_head(browser: PageBrowser, name: str, tmp_path: Path) -> None:
    outcome = entries()[name].run()
    browser.open(fb.report(outcome.system, outcome.trajectory, tmp_path / "x.html", equations=False))
    browser.value("freebody.show('forces', true); freebody.show('reactions', true)")
    for part in MOMENTS:
        browser.value(f"(m => freebody.seek(m.first + {part} * (m.last - m.first)))(freebody.motion)")
        found = browser.value("freebody.written")
        assert overlapping(found["texts"], [*found["texts"], *found["heads"]]) == [], part
        assert found["left"] == 0
    assert browser.errors == []


def test_a_crowd_of_texts_has_places_which_it_keeps(browser: PageBrowser) -> None:
    """Forty texts for 200 by 150 pixels: apart, on the sheet, and most where they were after all points moved a bit."""
    browser.ask("Page.navigate", url="about:blank")
    code = (files("freebody.picture.page") / "labels.js").read_text("utf-8").replace('"use strict";', "", 1)
    first, second = browser.value(f"{code}\n{CROWD}")
    for places in (first, second):
        boxes = [place[:4] for place in places if place]
        assert len(boxes) == 40 and overlapping(boxes, boxes) == []
        assert all(x >= 0 and y >= 0 and u <= 900 and v <= 500 for x, y, u, v in boxes)
    assert sum(a[4] == b[4] for a, b in zip(first, second, strict=True)) >= 36
