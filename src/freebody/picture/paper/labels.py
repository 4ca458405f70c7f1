"""Formulas as outlines of their letters: they look the same in every browser and on paper, and can be measured.

The unit of length is one em.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...typesetting.boxes import Placed, Rule, bounds, flat
from ...typesetting.glyphs import EM
from ...typesetting.setting import line

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Outline:
    """Outline of a line of text [em]; the origin is the left end of the baseline, y points up.

    ``vertices`` and ``codes`` are those of a matplotlib Path; ``box`` is (left, bottom, right, top) of the ink.
    """

    vertices: Array
    codes: Any
    box: tuple[float, float, float, float]


@cache
def outline(tex: str) -> Outline:
    r"""Return the outline of a line of text with formulas between dollar signs.

    >>> left, bottom, right, top = outline("$m g$").box
    >>> right - left > 1 and bottom < 0
    True
    """
    box = line(tex)
    vertices: list[Array] = []
    codes: list[int] = []
    for item in flat(box).items:
        if isinstance(item, Rule):
            corners = np.array([[0, 0], [0, 1], [1, 1], [1, 0], [0, 0]]) * (item.width, item.height)
            vertices.append(corners + (item.x, item.y))
            codes += (1, 2, 2, 2, 79)
        elif isinstance(item, Placed):
            vertices.append(item.glyph.vertices * (item.across, item.up) + (item.x, item.y))
            codes += item.glyph.codes
    if not codes:
        return Outline(np.zeros((0, 2)), [], (0.0, 0.0, 0.0, 0.0))
    left, bottom, right, top = (x / EM for x in bounds(box))
    return Outline(np.vstack(vertices) / EM, codes, (left, bottom, right, top))


def size_of(tex: str, size: float) -> tuple[float, float]:
    """Width and height of the ink of a line of text [pt]."""
    left, bottom, right, top = outline(tex).box
    return ((right - left) * size, (top - bottom) * size)
