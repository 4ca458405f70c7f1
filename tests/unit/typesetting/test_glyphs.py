"""Outlines of letters: the ink is inside the box, a path is the outline, and no letter is missing without a word."""

from __future__ import annotations

import re

import numpy as np
import pytest

from freebody.errors import FreebodyError
from freebody.typesetting.glyphs import CLOSE, FACES, glyph, has
from freebody.typesetting.latex import ACCENTS, CAPITALS, CHARACTERS, GREEK, SIGNS


@pytest.mark.parametrize("style", FACES)
def test_the_ink_fills_its_box(style: str) -> None:
    g = glyph(style, "(")
    ink = g.vertices[np.array(g.codes) != CLOSE]
    assert (*ink.min(axis=0), *ink.max(axis=0)) == g.box
    assert g.advance > 0 and g.box[3] > g.box[1]


def test_brackets_grow() -> None:
    heights = [glyph(style, "(").box[3] - glyph(style, "(").box[1] for style in "rstuv"]
    assert heights == sorted(set(heights))


def end(data: str) -> tuple[list[tuple[int, int]], int]:
    """The end of each contour of relative SVG data, and the number of contours."""
    here = begin = np.zeros(2, dtype=int)
    ends = []
    for letter, text in re.findall(r"([mlqcz])([^mlqcz]*)", data):
        numbers = np.array(list(map(int, re.findall(r"-?\d+", text)))).reshape(-1, 2)
        if letter == "z":
            here = begin
            continue
        here = here + numbers[-1]
        if letter == "m":
            begin = here
        ends.append((int(here[0]), int(here[1])))
    return ends, data.count("z")


def test_a_path_passes_through_the_points_of_the_outline() -> None:
    g = glyph("i", "θ")
    ends, contours = end(g.path())
    counts = {1: 1, 2: 1, 3: 2, 4: 3, CLOSE: 1}
    expected, k = [], 0
    while k < len(g.codes):
        n = counts[g.codes[k]]
        if g.codes[k] != CLOSE:
            x, y = g.vertices[k + n - 1]
            expected.append((int(x), -int(y)))
        k += n
    assert ends == expected and contours == g.codes.count(CLOSE) > 1


def test_every_sign_has_a_glyph() -> None:
    signs = [text for text, _ in (*SIGNS.values(), *CHARACTERS.values())]
    for char in (*signs, *GREEK.values(), *CAPITALS.values(), *ACCENTS.values()):
        assert has(glyph("i", char).key[0], char), char


def test_a_character_without_a_glyph_is_refused() -> None:
    with pytest.raises(
        FreebodyError, match=r"characters that the STIX fonts have in a formula, got '漢' \(U\+6F22\)"
    ):
        glyph("i", "漢")
