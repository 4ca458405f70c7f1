"""Places for arrows and labels, so that they do not overlap: the cheapest of a fixed list of places.

The places are tried in the same order every time, so the same model gives the same drawing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .labels import size_of
from .sheet import Arrow, Box, Label

Array = NDArray[np.float64]

CLEAR = 2.0
"""Gap around a label [pt]."""

_ANGLES = [math.radians(15 * k) for k in range(24)]
_BLOCK = 120
"""Places of a label whose cost is computed at once."""

_DISTANCES = (3.0, 6.0, 10.0, 15.0, 22.0, 30.0, 42.0, 56.0, 74.0, 95.0, 120.0, 150.0)
"""Distances of a label from its anchor [pt]."""

_AROUND = np.array([(math.cos(angle), math.sin(angle)) for angle in _ANGLES])
_SIGNS = np.where(np.abs(_AROUND) < 0.2, 0.0, np.sign(_AROUND))
"""Corner or side of a label's box that is nearest to its anchor, in each direction."""


class Placer:
    """Areas, lines and boxes that are on the sheet so far, which arrows and labels avoid."""

    def __init__(self) -> None:
        self.boxes: list[Box] = []
        self.areas: list[Array] = []
        self._weights: list[float] = []
        self._bounds = np.zeros((0, 2, 2))  # least and greatest coordinates of the areas
        self._ink: list[Array] = []

    def area(self, polygon: Array, weight: float = 1.0) -> None:
        """Add an area that arrows avoid (more, the greater ``weight``) and on whose edge no label lies."""
        self.areas.append(polygon)
        self._weights.append(weight)
        self.line(np.vstack([polygon, polygon[:1]]))

    def about(self, areas: Sequence[Array]) -> Placer:
        """Return a placer for the same sheet that avoids only these areas."""
        other = Placer()
        other.boxes, other._ink = self.boxes, [self.ink]
        other.areas, other._weights = list(areas), [1.0] * len(areas)
        return other

    def line(self, points: Array) -> None:
        """Add a line that labels avoid."""
        self._ink.append(sampled(points, 2.0))

    def box(self, box: Box) -> None:
        """Add a box that everything avoids."""
        self.boxes.append(box)

    @property
    def ink(self) -> Array:
        """Points along all lines of the sheet, shape (n, 2) [pt]."""
        if len(self._ink) > 1:
            self._ink = [np.vstack(self._ink)]
        return self._ink[0] if self._ink else np.zeros((0, 2))

    def crowding(self, points: Array, at: Array | None = None) -> float:
        """Cost of an arrow along these points: its overlap with areas, lines and labels, except close to ``at``."""
        along = sampled(points, 3.0)
        if at is not None:
            along = along[((along - at) ** 2).sum(axis=1) > 8.0**2]
            if not len(along):
                return 0.0
        cost = 0.0
        for k in self._reached(along):
            cost += self._weights[k] * float(inside(self.areas[k], along).mean())
        ink = self.ink
        if at is not None and len(ink):
            # its head on the head of another arrow, on the same line
            close = sampled(points, 1.0)
            close = close[np.abs(np.linalg.norm(close - at, axis=1) - 5.0) < 2.5]
            if len(close):
                cost += 0.8 * float(touched(close, ink, 2.0).mean())
        (x0, y0), (x1, y1) = along.min(axis=0) - 5.0, along.max(axis=0) + 5.0
        near = (ink[:, 0] > x0) & (ink[:, 0] < x1) & (ink[:, 1] > y0) & (ink[:, 1] < y1)
        ink = ink[near]
        if len(ink):
            cost += 1.2 * float(touched(along, ink, 4.5).mean())
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
        """Place a label near the first anchor that has room; an anchor is (point, preferred direction from it)."""
        w, h = size_of(tex, size)
        # each box touches a circle about its anchor, with one of the distances as its radius
        offsets = _AROUND * np.array(_DISTANCES)[:, None, None] + _SIGNS * np.array([w / 2, h / 2])
        distance_cost = np.repeat(0.8 * np.array(_DISTANCES), len(_ANGLES))
        places, costs = [], []
        for rank, (point, toward) in enumerate(anchors):
            places.append(point + offsets.reshape(-1, 2))
            turn_cost = 0.0 if toward is None else np.tile(7.0 * (1 - _AROUND @ toward), len(_DISTANCES))
            costs.append(distance_cost + 4.0 * rank + turn_cost)
        centers, base = np.vstack(places), np.concatenate(costs)
        order = np.argsort(base, kind="stable")
        best, least = centers[order[0]], np.inf
        for k in range(0, len(order), _BLOCK):
            block = order[k : k + _BLOCK]
            if base[block[0]] >= least:  # without any overlap, all further places cost more
                break
            total = base[block] + self._overlap_cost(centers[block], w, h)
            lowest = int(np.argmin(total))
            if total[lowest] < least:
                best, least = centers[block[lowest]], float(total[lowest])
        label = Label(tex, best - np.array([w, h]) / 2, size, color)
        self.box(label.box)
        return label

    def _overlap_cost(self, centers: Array, w: float, h: float) -> Array:
        """Cost of what boxes of width ``w`` and height ``h`` would cover, for each of their centres."""
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
        for k in self._reached(centers):
            cost += 12.0 * self._weights[k] * inside(self.areas[k], centers)
        return cost

    def _reached(self, points: Array) -> list[int]:
        """Return the numbers of the areas whose bounds meet those of points."""
        new = self.areas[len(self._bounds) :]
        if new:
            bounds = np.array([(area.min(axis=0), area.max(axis=0)) for area in new])
            self._bounds = np.concatenate([self._bounds, bounds])
        low, high = points.min(axis=0), points.max(axis=0)
        return np.nonzero(((self._bounds[:, 0] <= high) & (self._bounds[:, 1] >= low)).all(axis=1))[
            0
        ].tolist()

    def arrow(self, arrow: Arrow) -> None:
        """Add an arrow that has its place."""
        self.line(arrow.points)
        for head in arrow.heads():
            self.line(np.vstack([head, head[:1]]))


def sampled(points: Array, step: float) -> Array:
    """Points along a polyline, at most ``step`` apart."""
    lengths = np.concatenate([[0.0], np.cumsum(np.sqrt((np.diff(points, axis=0) ** 2).sum(axis=1)))])
    at = np.linspace(0.0, lengths[-1], max(2, int(np.ceil(lengths[-1] / step)) + 1))
    return np.column_stack([np.interp(at, lengths, points[:, 0]), np.interp(at, lengths, points[:, 1])])


def touched(points: Array, ink: Array, gap: float) -> NDArray[np.bool_]:
    """Truth value for each point: it is nearer than ``gap`` to one of the points of ``ink``."""
    x, y = (points[:, k, None] - ink[:, k] for k in (0, 1))
    x *= x
    y *= y
    x += y
    return x.min(axis=1) < gap * gap


def meets(line: Array, box: Box) -> bool:
    """True if a polyline crosses a box, or passes it within half the gap of a label."""
    along, gap = sampled(line, 0.5), CLEAR / 2
    low, high = np.array(box[:2]) - gap, np.array(box[2:]) + gap
    return bool(((along > low) & (along < high)).all(axis=1).any())


def inside(polygon: Array, points: Array) -> NDArray[np.bool_]:
    """Truth value for each point: it lies inside a polygon (odd number of crossings of a ray)."""
    result = np.zeros(len(points), dtype=bool)
    near = ((points >= polygon.min(axis=0)) & (points <= polygon.max(axis=0))).all(axis=1)
    if not near.any():
        return result
    x, y = points[near].T
    after = np.roll(polygon, -1, axis=0)
    slanted = polygon[:, 1] != after[:, 1]
    ax, ay = polygon[slanted].T[:, :, None]
    bx, by = after[slanted].T[:, :, None]
    crossed = ((ay > y) != (by > y)) & (x < (bx - ax) * (y - ay) / (by - ay) + ax)
    result[near] = crossed.sum(axis=0) % 2 == 1
    return result
