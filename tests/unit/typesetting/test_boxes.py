"""Boxes side by side, smaller and higher."""

from __future__ import annotations

from freebody.typesetting.boxes import (
    bounds,
    flat,
    joined,
    letters,
    named,
    overlaid,
    raised,
    rule,
    scaled,
    space,
)


def test_boxes_side_by_side() -> None:
    a, b = letters("a", "i"), letters("b", "i")
    both = joined([a, space(100), b])
    assert both.width == a.width + 100 + b.width
    assert both.items[1].x == a.width + 100
    assert both.height == max(a.height, b.height)


def test_smaller_and_higher() -> None:
    a = letters("a", "i")
    left, low, right, high = bounds(a)
    moved = raised(scaled(named(joined([a, a])), 0.5), 300)
    assert bounds(moved) == (left / 2, low / 2 + 300, (a.width + right) / 2, high / 2 + 300)
    assert moved.width == a.width
    assert len(moved.items) == 1 and len(flat(moved).items) == 2


def test_a_bar() -> None:
    assert bounds(overlaid([(rule(500, 60, 258), 10, 0)], 600)) == (10, 258, 510, 318)
    assert bounds(space(5)) == (0, 0, 0, 0)
