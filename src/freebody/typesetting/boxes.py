"""Boxes: glyphs and rules at their places, in thousandths of an em; the origin is on the baseline, y points up."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from .glyphs import Glyph, glyph


@dataclass(frozen=True)
class Placed:
    """A glyph at a place, stretched by ``across`` and ``up``."""

    glyph: Glyph
    x: float
    y: float
    across: float = 1
    up: float = 1


@dataclass(frozen=True)
class Rule:
    """A filled rectangle, from its lower left corner."""

    x: float
    y: float
    width: float
    height: float


@dataclass(frozen=True)
class Named:
    """The inside of a box that occurs often, such as a symbol with dots and subscript, at a place."""

    inside: Box
    x: float
    y: float
    scale: float = 1


Item = Placed | Rule | Named


@dataclass(frozen=True, eq=False)
class Box:
    """Own items or boxes at places, with a width, a height above the baseline and a depth below.

    The width includes the italic ``lean``. A part is (box, x, y, scale); items are placed once, when a whole formula is
    drawn, since a formula has many levels.
    """

    width: float
    height: float
    depth: float
    own: tuple[Item, ...] = ()
    lean: float = 0
    parts: tuple[tuple[Box, float, float, float], ...] = ()

    @cached_property
    def items(self) -> tuple[Item, ...]:
        """All items at their places in this box."""
        return tuple(_placed(self, 0, 0, 1))


EMPTY = Box(0, 0, 0)


def _placed(box: Box, x: float, y: float, k: float) -> Iterator[Item]:
    """Yield the items of a box of size k at (x, y)."""
    for item in box.own:
        yield item if x == y == 0 and k == 1 else _at(item, x, y, k)
    for part, across, up, size in box.parts:
        yield from _placed(part, x + k * across, y + k * up, k * size)


def _at(item: Item, x: float, y: float, k: float) -> Item:
    x, y = x + k * item.x, y + k * item.y
    if isinstance(item, Placed):
        return Placed(item.glyph, x, y, item.across * k, item.up * k)
    if isinstance(item, Rule):
        return Rule(x, y, item.width * k, item.height * k)
    return Named(item.inside, x, y, item.scale * k)


def scaled(box: Box, k: float) -> Box:
    """Return a smaller or larger box."""
    if k == 1:
        return box
    return Box(box.width * k, box.height * k, box.depth * k, (), box.lean * k, ((box, 0, 0, k),))


def raised(box: Box, up: float) -> Box:
    """Return a box whose inside is moved up."""
    return Box(box.width, box.height + up, box.depth - up, (), box.lean, ((box, 0, up, 1),))


def overlaid(parts: Sequence[tuple[Box, float, float]], width: float, lean: float = 0) -> Box:
    """Return boxes at places (x, y) as one box."""
    height = max((box.height + y for box, _, y in parts), default=0)
    depth = max((box.depth - y for box, _, y in parts), default=0)
    return Box(width, height, depth, (), lean, tuple((box, x, y, 1) for box, x, y in parts))


def joined(boxes: Sequence[Box]) -> Box:
    """Return boxes side by side."""
    parts, x = [], 0.0
    for box in boxes:
        parts.append((box, x, 0.0))
        x += box.width
    return overlaid(parts, x, boxes[-1].lean if boxes else 0)


def space(width: float) -> Box:
    """Return an empty box."""
    return Box(width, 0, 0)


def named(box: Box) -> Box:
    """Return a box whose inside is one item."""
    if len(box.items) <= 1:
        return box
    return replace(box, own=(Named(box, 0, 0),), parts=())


def flat(box: Box) -> Box:
    """Return a box without named items."""
    items: list[Item] = []
    for item in box.items:
        if isinstance(item, Named):
            items += _placed(flat(item.inside), item.x, item.y, item.scale)
        else:
            items.append(item)
    return replace(box, own=tuple(items), parts=())


def letters(text: str, style: str) -> Box:
    """Return letters side by side; the height and depth are those of the ink."""
    boxes = [_letter(glyph(style, c)) for c in text]
    return boxes[0] if len(boxes) == 1 else joined(boxes)


def _letter(g: Glyph) -> Box:
    lean = g.italic_correction
    return Box(g.advance + lean, max(0, g.box[3]), max(0, -g.box[1]), (Placed(g, 0, 0),), lean)


def rule(width: float, height: float, up: float = 0) -> Box:
    """Return a bar."""
    return Box(width, up + height, max(0.0, -up), (Rule(0, up, width, height),))


def bounds(box: Box) -> tuple[float, float, float, float]:
    """Return (left, bottom, right, top) of the ink."""
    left = bottom = float("inf")
    right = top = -float("inf")
    for item in flat(box).items:
        if isinstance(item, Rule):
            corners = (item.x, item.y, item.x + item.width, item.y + item.height)
        elif isinstance(item, Placed) and len(item.glyph.vertices):
            a, b, c, d = item.glyph.box
            corners = (
                item.x + a * item.across, item.y + b * item.up, item.x + c * item.across, item.y + d * item.up,
            )  # fmt: skip
        else:
            continue
        left, bottom = min(left, corners[0]), min(bottom, corners[1])
        right, top = max(right, corners[2]), max(top, corners[3])
    return (left, bottom, right, top) if right >= left else (0.0, 0.0, 0.0, 0.0)
