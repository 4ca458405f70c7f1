"""Contents of a drawing before it is written in any format: lines, circles, arrows and labels on a sheet, in points.

x points right, y up. Groups carry the attributes by which a drawing is read back.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .labels import outline
from .palette import INK

Array = NDArray[np.float64]
Box = tuple[float, float, float, float]

HEAD = (8.0, 2.7)
"""Length and half width of the head of an arrow whose line is 1.5 pt wide [pt]."""

TAIL = 16.0
"""Length of an arrow that points inward at the end of a short line [pt]."""


@dataclass(frozen=True)
class Style:
    """Colour, width [pt] and dashes of a line, and the fill inside it."""

    stroke: str | None = INK
    width: float = 1.0
    dash: tuple[float, ...] = ()
    fill: str | None = None


@dataclass(frozen=True, eq=False)
class Line:
    """A polyline, or a polygon if it is closed."""

    points: Array
    style: Style = Style()
    closed: bool = False


@dataclass(frozen=True, eq=False)
class Circle:
    """A circle."""

    center: Array
    radius: float
    style: Style = Style()


@dataclass(frozen=True, eq=False)
class Arrow:
    """A polyline with a head: "full", "open" (hollow), "double" (vector of a couple), "both" (one at each end).

    With head "inward" two arrows point at the ends of a short line, from outside.
    """

    points: Array
    style: Style = Style(width=1.5)
    head: str = "full"

    @property
    def tip(self) -> Array:
        """Last point of the arrow."""
        return self.points[-1]

    def heads(self) -> list[Array]:
        """Corners of each head."""
        scale = self.size
        if self.head == "inward":
            d = self._direction()
            return [_head(self.points[0], d, scale), _head(self.points[-1], -d, scale)]
        result = [_head(self.points[-1], self._direction(), scale)]
        if self.head == "double":
            result.append(
                _head(self.points[-1] - 0.75 * HEAD[0] * scale * self._direction(), self._direction(), scale)
            )
        if self.head == "both":
            back = self.points[0] - self.points[1]
            result.append(_head(self.points[0], back / np.linalg.norm(back), scale))
        return result

    def shaft(self) -> Array:
        """The line without the part that the heads cover."""
        scale = self.size
        if self.head == "inward":
            d = self._direction()
            return np.array([self.points[0] - TAIL * d, *self.points, self.points[-1] + TAIL * d])
        points = shortened(self.points, 0.8 * HEAD[0] * scale)
        if self.head == "both":
            points = shortened(points[::-1], 0.8 * HEAD[0] * scale)[::-1]
        return points

    @property
    def size(self) -> float:
        """Scale of the heads: it follows the width of the line, and is smaller on a short arrow."""
        if self.head == "inward":
            return max(0.62, self.style.width / 1.5)
        length = float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())
        room = length / HEAD[0] / (2.4 if self.head in ("double", "both") else 1.4)
        return min(max(0.62, self.style.width / 1.5), room)

    def _direction(self) -> Array:
        # on a curve, the chord under the head
        short = self.points if self.head == "inward" else shortened(self.points, HEAD[0])
        d = self.points[-1] - short[-2 if self.head == "inward" else -1]
        return d / np.linalg.norm(d)


@dataclass(frozen=True, eq=False)
class Label:
    """A line of text with formulas between dollar signs; ``at`` is the lower left corner of its ink."""

    tex: str
    at: Array
    size: float = 11.0
    color: str = INK

    @property
    def box(self) -> Box:
        """(left, bottom, right, top) of the ink [pt]."""
        left, bottom, right, top = outline(self.tex).box
        x, y = self.at
        return (x, y, x + (right - left) * self.size, y + (top - bottom) * self.size)


@dataclass(eq=False)
class Group:
    """Items that belong together, with attributes (``class``, ``data-…``) and a title."""

    items: list[Any] = field(default_factory=list)
    attributes: dict[str, str] = field(default_factory=dict)
    title: str = ""

    def add(self, *items: Any) -> None:
        """Append items."""
        self.items.extend(items)


@dataclass(eq=False)
class Sheet:
    """A drawing: its items, its title and its attributes."""

    root: Group
    title: str
    attributes: dict[str, str] = field(default_factory=dict)
    margin: float = 10.0

    @property
    def box(self) -> Box:
        """(left, bottom, right, top) of all items, with the margin [pt]."""
        x0, y0, x1, y1 = box_of(self.root)
        m = self.margin
        return (x0 - m, y0 - m, x1 + m, y1 + m)


def flat(group: Group) -> Iterator[Any]:
    """Yield all items of a group and of the groups in it, but no group."""
    for item in group.items:
        if isinstance(item, Group):
            yield from flat(item)
        else:
            yield item


def box_of(item: Any) -> Box:
    """(left, bottom, right, top) of an item [pt]."""
    if isinstance(item, Group):
        boxes = [box_of(part) for part in item.items]
        return union(boxes) if boxes else (0.0, 0.0, 0.0, 0.0)
    if isinstance(item, Label):
        return item.box
    if isinstance(item, Circle):
        x, y = item.center
        r = item.radius + item.style.width / 2
        return (x - r, y - r, x + r, y + r)
    points = item.points
    if isinstance(item, Arrow):
        points = np.vstack([points, item.shaft(), *item.heads()])
    half = item.style.width / 2 if item.style.stroke else 0.0
    (x0, y0), (x1, y1) = points.min(axis=0), points.max(axis=0)
    return (float(x0) - half, float(y0) - half, float(x1) + half, float(y1) + half)


def union(boxes: Sequence[Box]) -> Box:
    """Return the smallest box that contains all boxes."""
    return (
        min(b[0] for b in boxes),
        min(b[1] for b in boxes),
        max(b[2] for b in boxes),
        max(b[3] for b in boxes),
    )


def moved(item: Any, by: Array) -> Any:
    """Return a displaced copy of an item."""
    if isinstance(item, Group):
        return Group([moved(part, by) for part in item.items], dict(item.attributes), item.title)
    if isinstance(item, Label):
        return replace(item, at=item.at + by)
    if isinstance(item, Circle):
        return replace(item, center=item.center + by)
    return replace(item, points=item.points + by)


def overlap(a: Box, b: Box) -> float:
    """Area of the overlap of two boxes."""
    w = min(a[2], b[2]) - max(a[0], b[0])
    h = min(a[3], b[3]) - max(a[1], b[1])
    return w * h if w > 0 and h > 0 else 0.0


def arc(center: Array, radius: float, start: float, end: float) -> Array:
    """Points on a circle from the angle ``start`` to the angle ``end`` [rad]."""
    n = max(3, int(abs(end - start) / math.radians(4)) + 1)
    angles = np.linspace(start, end, n)
    return center + radius * np.column_stack([np.cos(angles), np.sin(angles)])


def _head(tip: Array, d: Array, scale: float) -> Array:
    length, half = HEAD[0] * scale, HEAD[1] * scale
    side = np.array([-d[1], d[0]])
    base = tip - length * d
    return np.array([tip, base + half * side, base + 0.22 * length * d, base - half * side])


def shortened(points: Array, by: float) -> Array:
    """Return a polyline without its last stretch, of length ``by``."""
    result = list(points)
    while len(result) > 1:
        d = result[-1] - result[-2]
        length = float(np.linalg.norm(d))
        if length > by or len(result) == 2:
            result[-1] = result[-1] - d * min(0.999, by / length if length > 0 else 0.0)
            break
        by -= length
        result.pop()
    return np.array(result)
