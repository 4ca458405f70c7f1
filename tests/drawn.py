"""Parts of a finished drawing, read back: groups, scale, projection, labels."""

from __future__ import annotations

from typing import Any

import numpy as np

import freebody as fb
from freebody.gallery import entries
from freebody.picture.machine.configuration import configuration
from freebody.picture.machine.draw import draw
from freebody.picture.paper.sheet import Group, Label, flat

PLACED = 1e-8
"""Of lengths on paper [pt]: attributes of drawings have twelve digits."""


def groups(drawing: Any, class_: str) -> list[Group]:
    """All groups of a class, or of two classes of which it is the first."""

    def within(group: Group) -> Any:
        for item in group.items:
            if isinstance(item, Group):
                if item.attributes.get("class", "").split()[:1] == [class_]:
                    yield item
                yield from within(item)

    return list(within(drawing.sheet.root))


def scale_of(drawing: Any) -> float:
    return float(drawing.sheet.attributes["data-scale"])


def view_of(drawing: Any) -> Any:
    return np.array(drawing.sheet.attributes["data-view"].split(), dtype=float).reshape(2, 3)


def texts(drawing: Any) -> list[str]:
    return [item.tex for item in flat(drawing.sheet.root) if isinstance(item, Label)]


def as_drawn(name: str) -> tuple[Any, Any, Any]:
    """A system of the gallery, its drawing as the gallery shows it, and its configuration."""
    entry = entries()[name]
    s = entry.build()
    e = fb.equations(s)
    near = {key: x for key, x in entry.near.items() if key in e.model.coordinate_names}
    at = dict(entry.drawn) or None
    values = dict(entry.enlarged) or None
    return s, draw(e, near=near, at=at, values=values), configuration(e.model, at, near=near, values=values)
