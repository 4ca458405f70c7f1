"""What is wrong with the layout of a drawing: labels on lines or on each other, arrows beside their points."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from freebody.picture.paper.sheet import Arrow, Circle, Group, Label, Line, box_of, flat, overlap

ROUNDED = 1e-3
"""Of lengths on paper [pt], twelve digits of metres apart."""


def faults(drawing: Any) -> list[str]:
    """A line for each label that lies on a line, an arrow or another label, or is cut at the edge of the sheet."""
    items = list(flat(drawing.sheet.root))
    labels = [item for item in items if isinstance(item, Label)]
    x0, y0, x1, y1 = drawing.sheet.box
    found = []
    for i, one in enumerate(labels):
        a = one.box
        if not (x0 <= a[0] and y0 <= a[1] and a[2] <= x1 and a[3] <= y1):
            found.append(f"{one.tex} is cut")
        found += [f"{one.tex} on {other.tex}" for other in labels[i + 1 :] if overlap(a, other.box)]
        for item in items:
            if not isinstance(item, Label) and any(_meets(line, a) for line in _lines(item)):
                found.append(f"{one.tex} on {type(item).__name__.lower()} {_where(drawing.sheet.root, item)}")
    return found


def _lines(item: Any) -> Iterator[Any]:
    """The polylines that are inked."""
    if isinstance(item, Circle):
        t = np.linspace(0, 2 * np.pi, 49)
        yield item.center + item.radius * np.column_stack([np.cos(t), np.sin(t)])
    elif isinstance(item, Arrow):
        yield item.points
        yield from (np.vstack([head, head[:1]]) for head in item.heads())
    elif isinstance(item, Line) and item.style.stroke is not None:
        yield np.vstack([item.points, item.points[:1]]) if item.closed else item.points


def _meets(line: Any, box: Any) -> bool:
    """Whether a polyline goes through a box: some segment is not on one side of it."""
    p, d = line[:-1], np.diff(line, axis=0)
    low, high = np.array(box[:2]), np.array(box[2:])
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (low - p) / d, (high - p) / d
    flat_out = (d == 0) & ((p < low) | (p > high))
    enter = np.where(d == 0, -np.inf, np.minimum(a, b)).max(axis=1)
    leave = np.where(d == 0, np.inf, np.maximum(a, b)).min(axis=1)
    return bool(((enter < leave) & (enter < 1) & (leave > 0) & ~flat_out.any(axis=1)).any())


def _where(group: Group, item: Any) -> str:
    """The group that an item is in."""
    for one in group.items:
        if one is item:
            return group.title or group.attributes.get("class", "")
        if isinstance(one, Group) and (found := _where(one, item)):
            return found
    return ""


def astray(drawing: Any) -> list[str]:
    """Arrows of a free-body diagram that neither begin nor end where they act.

    A particle has no size: at one, arrows begin at the edge of its sign.
    """
    view = np.array(drawing.sheet.attributes["data-view"].split(), dtype=float).reshape(2, 3)
    scale = float(drawing.sheet.attributes["data-scale"])
    found = []
    for panel in drawing.sheet.root.items:
        if not isinstance(panel, Group) or "data-shift" not in panel.attributes:
            continue
        shift = np.array(panel.attributes["data-shift"].split(), dtype=float)
        outline = next(one for one in panel.items if one.attributes.get("class") == "outline")
        signs = [box_of(one) for one in outline.items if outline.attributes["data-solids"] == "particle"]
        for group in panel.items:
            if not isinstance(group, Group) or "data-point" not in group.attributes:
                continue
            if "data-turn" in group.attributes:
                continue
            at = scale * view @ np.array(group.attributes["data-point"].split(), dtype=float) + shift
            for arrow in (one for one in group.items if isinstance(one, Arrow)):
                ends = arrow.points[[0, -1]]
                gap = float(np.linalg.norm(ends - at, axis=1).min())
                if gap > ROUNDED and not any(_within(at, box) and _within(ends, box) for box in signs):
                    found.append(f"{group.title} is {gap:.1f} pt away from where it acts")
    return found


def _within(points: Any, box: Any) -> bool:
    """Whether a point (one of some points) lies in a box, or on its edge."""
    low, high = np.array(box[:2]) - 0.5, np.array(box[2:]) + 0.5
    return bool(((low <= points) & (points <= high)).all(axis=-1).any())
