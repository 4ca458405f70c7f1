"""Formulas as outlines of their letters: they look the same in every browser and on paper, and can be measured.

matplotlib's mathtext sets them in the STIX letters that it ships. The unit of length is one em.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import FreebodyError

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
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    # TeX sets a space before a function, mathtext does not
    tex = re.sub(r"(?<![-+=(]) (\\(?:sin|cos|tan|operatorname))", r" \, \1", tex)
    font = FontProperties(family=["STIXGeneral"], math_fontfamily="stix")
    math = "$" in tex
    try:
        vertices, codes = text_to_path.get_text_path(font, tex, ismath=math)
    except ValueError as error:
        raise FreebodyError(f"Expected a formula that can be set, got '{tex}': {error}") from None
    vertices = np.asarray(vertices, dtype=float).reshape(-1, 2) / text_to_path.FONT_SCALE
    if not len(vertices):
        return Outline(vertices, [], (0.0, 0.0, 0.0, 0.0))
    left, bottom = vertices.min(axis=0)
    right, top = vertices.max(axis=0)
    return Outline(vertices, list(codes), (float(left), float(bottom), float(right), float(top)))


def size_of(tex: str, size: float) -> tuple[float, float]:
    """Width and height of the ink of a line of text [pt]."""
    left, bottom, right, top = outline(tex).box
    return ((right - left) * size, (top - bottom) * size)
