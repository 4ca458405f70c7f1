"""Boxes: glyphs and rules at their places, in thousandths of an em; the origin is on the baseline, y points up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

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
    """Items with a width, a height above the baseline and a depth below; the width includes the italic ``lean``."""

    width: float
    height: float
    depth: float
    items: tuple[Item, ...] = ()
    lean: float = 0


EMPTY = Box(0, 0, 0)


def moved(item: Item, x: float, y: float) -> Item:
    """Return an item at another place."""
    return replace(item, x=item.x + x, y=item.y + y)


def scaled(box: Box, k: float) -> Box:
    """Return a smaller or larger box."""
    if k == 1:
        return box
    items: list[Item] = []
    for item in box.items:
        x, y = item.x * k, item.y * k
        if isinstance(item, Placed):
            items.append(Placed(item.glyph, x, y, item.across * k, item.up * k))
        elif isinstance(item, Rule):
            items.append(Rule(x, y, item.width * k, item.height * k))
        else:
            items.append(Named(item.inside, x, y, item.scale * k))
    return Box(box.width * k, box.height * k, box.depth * k, tuple(items), box.lean * k)


def raised(box: Box, up: float) -> Box:
    """Return a box whose inside is moved up."""
    return Box(
        box.width, box.height + up, box.depth - up, tuple(moved(i, 0, up) for i in box.items), box.lean
    )


def overlaid(parts: Sequence[tuple[Box, float, float]], width: float) -> Box:
    """Return boxes at places (x, y) as one box."""
    items = tuple(moved(item, x, y) for box, x, y in parts for item in box.items)
    height = max((box.height + y for box, _, y in parts), default=0)
    depth = max((box.depth - y for box, _, y in parts), default=0)
    return Box(width, height, depth, items)


def joined(boxes: Sequence[Box]) -> Box:
    """Return boxes side by side."""
    parts, x = [], 0.0
    for box in boxes:
        parts.append((box, x, 0.0))
        x += box.width
    return replace(overlaid(parts, x), lean=boxes[-1].lean if boxes else 0)


def space(width: float) -> Box:
    """Return an empty box."""
    return Box(width, 0, 0)


def named(box: Box) -> Box:
    """Return a box whose inside is one item."""
    if len(box.items) <= 1:
        return box
    return replace(box, items=(Named(box, 0, 0),))


def flat(box: Box) -> Box:
    """Return a box without named items."""
    items: list[Item] = []
    for item in box.items:
        if isinstance(item, Named):
            inside = scaled(flat(item.inside), item.scale)
            items += [moved(part, item.x, item.y) for part in inside.items]
        else:
            items.append(item)
    return replace(box, items=tuple(items))


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
