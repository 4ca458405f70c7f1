"""Where arrows and labels go, so that they do not lie on one another: the cheapest of a fixed list of places.

Everything is tried in the same order every time: the same model gives the same drawing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .labels import size_of
from .sheet import Arrow, Box, Label

Array = NDArray[np.float64]

CLEAR = 2.0
"""Gap around a label [pt]."""

_ANGLES = [math.radians(15 * k) for k in range(24)]
_AT_ONCE = 120
_AWAY = (3.0, 6.0, 10.0, 15.0, 22.0, 30.0, 42.0, 56.0, 74.0, 95.0, 120.0, 150.0)

_AROUND = np.array([(math.cos(angle), math.sin(angle)) for angle in _ANGLES])
_SIGNS = np.where(np.abs(_AROUND) < 0.2, 0.0, np.sign(_AROUND))
"""Which corner or side of a box is nearest to its anchor, in each direction."""


class Placer:
    """The sheet as it fills up."""

    def __init__(self) -> None:
        self.boxes: list[Box] = []
        self.areas: list[Array] = []
        self._weights: list[float] = []
        self._ink: list[Array] = []

    def area(self, polygon: Array, weight: float = 1.0) -> None:
        """An area that arrows should leave (the more, the greater ``weight``), and on whose edge no label lies."""
        self.areas.append(polygon)
        self._weights.append(weight)
        self.line(np.vstack([polygon, polygon[:1]]))

    def about(self, areas: Sequence[Array]) -> Placer:
        """The same sheet, of which only some areas are to be avoided."""
        other = Placer()
        other.boxes, other._ink = self.boxes, [self.ink]
        other.areas, other._weights = list(areas), [1.0] * len(areas)
        return other

    def line(self, points: Array) -> None:
        """A line that labels should not lie on."""
        self._ink.append(sampled(points, 2.0))

    def box(self, box: Box) -> None:
        """A box that nothing should lie on."""
        self.boxes.append(box)

    @property
    def ink(self) -> Array:
        if len(self._ink) > 1:
            self._ink = [np.vstack(self._ink)]
        return self._ink[0] if self._ink else np.zeros((0, 2))

    def crowding(self, points: Array, at: Array | None = None) -> float:
        """How much an arrow along these points would lie on areas, other lines and labels, except close to ``at``."""
        along = sampled(points, 3.0)
        if at is not None:
            along = along[((along - at) ** 2).sum(axis=1) > 8.0**2]
            if not len(along):
                return 0.0
        cost = 0.0
        for area, weight in zip(self.areas, self._weights, strict=True):
            cost += weight * float(inside(area, along).mean())
        ink = self.ink
        if at is not None and len(ink):
            # a head upon another one, on the same line
            close = sampled(points, 1.0)
            close = close[np.abs(np.linalg.norm(close - at, axis=1) - 5.0) < 2.5]
            if len(close):
                gaps = np.sqrt(((close[:, None, :] - ink[None, :, :]) ** 2).sum(axis=2)).min(axis=1)
                cost += 0.8 * float((gaps < 2.0).mean())
        (x0, y0), (x1, y1) = along.min(axis=0) - 5.0, along.max(axis=0) + 5.0
        near = (ink[:, 0] > x0) & (ink[:, 0] < x1) & (ink[:, 1] > y0) & (ink[:, 1] < y1)
        ink = ink[near]
        if len(ink):
            gaps = np.sqrt(((along[:, None, :] - ink[None, :, :]) ** 2).sum(axis=2)).min(axis=1)
            cost += 1.2 * float((gaps < 4.5).mean())
        for x0, y0, x1, y1 in self.boxes:
            hit = (
                (along[:, 0] > x0 - 2)
                & (along[:, 0] < x1 + 2)
                & (along[:, 1] > y0 - 2)
                & (along[:, 1] < y1 + 2)
            )
            cost += 6.0 * float(hit.mean())
        return cost

    def label(
        self,
        tex: str,
        anchors: Sequence[tuple[Array, Array | None]],
        size: float = 11.0,
        color: str = "#1a1a1a",
    ) -> Label:
        """A label near the first of the anchors that has room: (point, preferred direction from it)."""
        w, h = size_of(tex, size)
        # each box touches a circle of radius `away` about its anchor
        shape = _AROUND * np.array(_AWAY)[:, None, None] + _SIGNS * np.array([w / 2, h / 2])
        near = np.repeat(0.8 * np.array(_AWAY), len(_ANGLES))
        places, costs = [], []
        for rank, (point, toward) in enumerate(anchors):
            places.append(point + shape.reshape(-1, 2))
            turned = 0.0 if toward is None else np.tile(7.0 * (1 - _AROUND @ toward), len(_AWAY))
            costs.append(near + 4.0 * rank + turned)
        centers, base = np.vstack(places), np.concatenate(costs)
        order = np.argsort(base, kind="stable")
        best, least = centers[order[0]], np.inf
        for k in range(0, len(order), _AT_ONCE):
            part = order[k : k + _AT_ONCE]
            if base[part[0]] >= least:  # the rest costs more by itself
                break
            total = base[part] + self._lying(centers[part], w, h)
            lowest = int(np.argmin(total))
            if total[lowest] < least:
                best, least = centers[part[lowest]], float(total[lowest])
        label = Label(tex, best - np.array([w, h]) / 2, size, color)
        self.box(label.box)
        return label

    def _lying(self, centers: Array, w: float, h: float) -> Array:
        """Cost of what boxes of one size about the centres lie on."""
        x0, x1 = centers[:, 0] - w / 2 - CLEAR, centers[:, 0] + w / 2 + CLEAR
        y0, y1 = centers[:, 1] - h / 2 - CLEAR, centers[:, 1] + h / 2 + CLEAR
        cost = np.zeros(len(centers))
        for a0, b0, a1, b1 in self.boxes:
            width = np.minimum(x1, a1) - np.maximum(x0, a0)
            height = np.minimum(y1, b1) - np.maximum(y0, b0)
            cost += np.where((width > 0) & (height > 0), 1000.0 + width * height, 0.0)
        ink = self.ink
        near = (
            (ink[:, 0] > x0.min()) & (ink[:, 0] < x1.max()) & (ink[:, 1] > y0.min()) & (ink[:, 1] < y1.max())
        )
        ink = ink[near]
        if len(ink):
            hit = (
                (ink[None, :, 0] > x0[:, None])
                & (ink[None, :, 0] < x1[:, None])
                & (ink[None, :, 1] > y0[:, None])
                & (ink[None, :, 1] < y1[:, None])
            )
            cost += 45.0 * np.minimum(hit.sum(axis=1), 12) + np.where(hit.any(axis=1), 150.0, 0.0)
        for area, weight in zip(self.areas, self._weights, strict=True):
            cost += 12.0 * weight * inside(area, centers)
        return cost

    def arrow(self, arrow: Arrow) -> None:
        """An arrow that has its place."""
        self.line(arrow.points)
        for head in arrow.heads():
            self.line(np.vstack([head, head[:1]]))


def sampled(points: Array, step: float) -> Array:
    """Points along a polyline, at most ``step`` apart."""
    way = np.concatenate([[0.0], np.cumsum(np.sqrt((np.diff(points, axis=0) ** 2).sum(axis=1)))])
    at = np.linspace(0.0, way[-1], max(2, int(np.ceil(way[-1] / step)) + 1))
    return np.column_stack([np.interp(at, way, points[:, 0]), np.interp(at, way, points[:, 1])])


def meets(line: Array, box: Box) -> bool:
    """Whether a polyline goes through a box, or past it within half the gap of a label."""
    along, gap = sampled(line, 0.5), CLEAR / 2
    low, high = np.array(box[:2]) - gap, np.array(box[2:]) + gap
    return bool(((along > low) & (along < high)).all(axis=1).any())


def inside(polygon: Array, points: Array) -> Any:
    """Which points lie inside a polygon, by crossings of a ray."""
    x, y = points[:, 0], points[:, 1]
    result = np.zeros(len(points), dtype=bool)
    for (ax, ay), (bx, by) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if ay == by:
            continue
        between = (ay > y) != (by > y)
        result ^= between & (x < (bx - ax) * (y - ay) / (by - ay) + ax)
    return result
