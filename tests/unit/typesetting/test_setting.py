"""Sizes and spaces of set formulas, in thousandths of an em."""

from __future__ import annotations

import pytest

from freebody.typesetting.boxes import Box, Placed, Rule, bounds, flat
from freebody.typesetting.latex import parse
from freebody.typesetting.setting import AXIS, MEDIUM, THICK, THIN, Style, line, setting


def box(tex: str) -> Box:
    return setting(parse(tex), Style())


def width(tex: str) -> float:
    return box(tex).width


@pytest.mark.parametrize(
    ("together", "parts", "space"),
    [
        (r"g \cos\theta", ("g", r"\cos", r"\theta"), 2 * THIN),
        ("a + b", ("a", "+", "b"), 2 * MEDIUM),
        ("a = b", ("a", "=", "b"), 2 * THICK),
        ("a = - b", ("a", "=", "-", "b"), 2 * THICK),
        ("- b", ("-", "b"), 0),
        (r"a \left(b\right)", ("a", r"\left(b\right)"), 0),
        ("a, b", ("a", ",", "b"), THIN),
        (r"\sin\left(b\right)", (r"\sin", r"\left(b\right)"), 0),
        (r"\cos\theta \sin\theta", (r"\cos", r"\theta", r"\sin", r"\theta"), 3 * THIN),
    ],
)
def test_spaces(together: str, parts: tuple[str, ...], space: float) -> None:
    assert width(together) == pytest.approx(sum(map(width, parts)) + space)


def test_scripts_are_set_tight() -> None:
    assert width("x_{a + b}") - width("x_{a}") == pytest.approx(0.7 * (width("+") + width("b")))


@pytest.mark.parametrize(
    "inside", ["x", r"\frac{1}{2}", r"\frac{\frac{a}{b}}{c}", r"\begin{matrix}1\\2\\3\\4\\5\end{matrix}"]
)
def test_brackets_have_the_height_of_what_they_enclose(inside: str) -> None:
    """Their middle is on the axis; they are not lower than 0.8 of the whole, and not a size too high."""
    body = box(inside)
    reach = max(body.height - AXIS, body.depth + AXIS)
    left = flat(box(rf"\left({inside}\right)")).items[0]
    assert isinstance(left, Placed)
    low, high = (left.y + left.up * left.glyph.box[i] for i in (1, 3))
    assert (low + high) / 2 == pytest.approx(AXIS)
    assert 1.6 * reach - 1 <= high - low <= max(2 * reach + 500, 900)


def test_a_fraction_has_its_bar_between_its_parts() -> None:
    items = flat(box(r"\frac{a}{b}")).items
    bar = next(item for item in items if isinstance(item, Rule))
    top, below = (item for item in items if isinstance(item, Placed))
    assert bar.y + bar.height / 2 == AXIS
    assert top.y + top.glyph.box[1] > bar.y + bar.height and below.y + below.glyph.box[3] < bar.y


def test_a_root_covers_its_body() -> None:
    for body in ("x", r"\frac{3 g}{L}", r"\frac{a}{\frac{b}{c}}"):
        shape = flat(box(rf"\sqrt{{{body}}}"))
        line = max((item for item in shape.items if isinstance(item, Rule)), key=lambda item: item.y)
        assert line.width > box(body).width and line.y > bounds(box(body))[3]
        assert bounds(shape)[1] <= bounds(box(body))[1]


def test_dots_are_above_the_letter() -> None:
    items = flat(box(r"\dot{\theta}")).items
    letter, dot = items
    assert isinstance(letter, Placed) and isinstance(dot, Placed)
    assert dot.y + dot.glyph.box[1] > letter.glyph.box[3]


def test_text_between_formulas() -> None:
    assert line("mass $m$").width == pytest.approx(
        line("mass ").width + setting(parse("m"), Style(0, False)).width
    )
    assert line("").width == 0
