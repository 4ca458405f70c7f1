"""Glyphs of the STIX letters that matplotlib ships: outlines and measures, in thousandths of an em.

The letters travel with the package, so that a formula looks the same on every computer.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FreebodyError

Array = NDArray[np.float64]

EM = 1000
"""Units in an em."""

CLOSE = 79
"""Code of a matplotlib Path that closes an outline; its vertex says nothing."""

FACES = {
    "r": "STIXGeneral", "i": "STIXGeneralItalic", "b": "STIXGeneralBol", "j": "STIXGeneralBolIta",
    "s": "STIXSizOneSymReg", "t": "STIXSizTwoSymReg", "u": "STIXSizThreeSymReg", "v": "STIXSizFourSymReg",
}  # fmt: skip
"""Upright, italic, bold, bold italic; and four sizes of brackets and roots."""


@dataclass(frozen=True, eq=False)
class Glyph:
    """A letter or sign; the origin is on the baseline, y points up.

    ``box`` is (left, bottom, right, top) of the ink; ``vertices`` and ``codes`` are those of a matplotlib Path.
    """

    key: str
    advance: int
    box: tuple[int, int, int, int]
    vertices: Array
    codes: tuple[int, ...]

    @property
    def italic_correction(self) -> int:
        """How far the ink leans over the advance."""
        return max(0, self.box[2] - self.advance)

    def path(self) -> str:
        """Return the outline as data of an SVG path, y down."""
        return path(self.vertices, self.codes)


@cache
def _face(style: str) -> Any:
    import matplotlib
    from matplotlib.ft2font import FT2Font

    font = FT2Font(str(Path(matplotlib.get_data_path(), "fonts", "ttf", f"{FACES[style]}.ttf")))
    font.set_size(EM, 72)
    return font, font.get_charmap()


def has(style: str, char: str) -> bool:
    """Return whether a face has a character."""
    return ord(char) in _face(style)[1]


@cache
def glyph(style: str, char: str) -> Glyph:
    """Return a character of a face; of the upright one if the face does not have it.

    >>> glyph("i", "θ").key
    'i3b8'
    """
    from matplotlib.ft2font import LoadFlags

    if not has(style, char):
        if style == "r":
            raise FreebodyError(
                f"Expected characters that the STIX fonts have in a formula, got '{char}' (U+{ord(char):04X}). "
                "Rename the symbol."
            )
        return glyph("r", char)
    font, places = _face(style)
    loaded = font.load_glyph(places[ord(char)], LoadFlags.NO_HINTING)
    vertices, codes = font.get_path()
    vertices = np.asarray(vertices, dtype=float).reshape(-1, 2).round()
    ink = vertices[np.asarray(codes) != CLOSE] if len(vertices) else np.zeros((1, 2))
    low, high = ink.min(axis=0), ink.max(axis=0)
    box = (int(low[0]), int(low[1]), int(high[0]), int(high[1]))
    advance = round(loaded.linearHoriAdvance / 2**16)
    return Glyph(f"{style}{ord(char):x}", advance, box, vertices, tuple(map(int, codes)))


def path(vertices: Array, codes: tuple[int, ...]) -> str:
    """Return an outline as data of an SVG path, in relative coordinates, y down."""
    parts: list[str] = []
    here = np.zeros(2)
    k = 0
    while k < len(codes):
        letter, count = {1: ("m", 1), 2: ("l", 1), 3: ("q", 2), 4: ("c", 3)}.get(codes[k], ("z", 1))
        if letter == "z":
            parts.append("z")
        else:
            points = vertices[k : k + count]
            numbers = ((points - here) * (1, -1)).round().astype(int).ravel().tolist()
            parts.append(letter + "".join(f" {n}" if i and n >= 0 else str(n) for i, n in enumerate(numbers)))
            here = points[-1]
            if letter == "m":
                begin = here
        if letter == "z":
            here = begin
        k += count
    return "".join(parts)
