"""Sheets as TikZ: sizes and places of labels."""

from __future__ import annotations

import re

import numpy as np
import pytest

from freebody.picture.paper.sheet import Arrow, Group, Label, Sheet, Style
from freebody.picture.paper.tikz import tikz


@pytest.mark.parametrize("size", [10.0, 20.0])
def test_a_symbol_is_as_large_as_in_the_drawing(size: float) -> None:
    """Computer Modern is 0.92 of the size of STIX at the same width; the symbol stands at the middle of its ink."""
    label = Label("$N$", np.array([30.0, 40.0]), size)
    text = tikz(Sheet(Group([label]), "one symbol"))
    (found,) = re.findall(
        r"anchor=center,.*fontsize\{(.*?)\}\{(.*?)\}\\selectfont\] at \((.*?),(.*?)\) \{\$N\$\}", text
    )
    x0, y0, x1, y1 = label.box
    assert [float(x) for x in found] == pytest.approx(
        [0.92 * size, 1.104 * size, (x0 + x1) / 2, (y0 + y1) / 2], abs=1e-3
    )


def test_a_short_length_has_an_arrow_on_each_side() -> None:
    arrow = Arrow(np.array([[0.0, 0.0], [8.0, 0.0]]), Style("#000000", 0.8), "inward")
    text = tikz(Sheet(Group([arrow]), "a short length"))
    assert len(re.findall(r"-\{Stealth", text)) == 2
    low, high = arrow.heads()
    assert low[:, 0].max() == pytest.approx(0) and high[:, 0].min() == pytest.approx(8)
