"""Colours that every eye can tell apart, and line styles that differ without colour.

Source of the colours: Okabe & Ito, Color Universal Design (2008).
"""

from __future__ import annotations

INK, GREY, PALE = "#1a1a1a", "#6b6b6b", "#c9c9c9"

BLUE, VERMILLION, GREEN, ORANGE, SKY, PURPLE = (
    "#0072B2",
    "#D55E00",
    "#009E73",
    "#E69F00",
    "#56B4E9",
    "#CC79A7",
)

PAIRS = (BLUE, VERMILLION, PURPLE, GREEN, ORANGE, SKY)
"""Colours of reactions, one per joint. The first three, enough for most machines, also differ in grey."""

CONTRAST = 4.5
"""Least contrast of letters with a white page: criterion 1.4.3 of [WCAG2018]."""

BODY_FILLS = ("#dfe8f0", "#f3e6d8", "#dcefe6", "#f2e3ec", "#f7efd2", "#e2f1fa")
"""Pale fills of bodies, in the order of the bodies."""


def pale(color: str) -> str:
    """Mix a colour with white, so that black lines stand out on it.

    >>> pale("#0072B2")
    '#b8d8e9'
    """
    parts = (int(color[i : i + 2], 16) for i in (1, 3, 5))
    return "#" + "".join(f"{round(255 - 0.28 * (255 - part)):02x}" for part in parts)


def luminance(color: str) -> float:
    """Relative luminance of a colour as [WCAG2018] defines it; white is 1.

    >>> round(luminance("#ffffff"), 3), round(luminance("#0072B2"), 3)
    (1.0, 0.152)
    """
    parts = [int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def legible(color: str) -> str:
    """Darken a colour, without changing its hue, until letters in it can be read on white.

    >>> legible("#0072B2"), legible("#E69F00")
    ('#0072B2', '#996a00')
    """
    parts = [float(int(color[i : i + 2], 16)) for i in (1, 3, 5)]
    while 1.05 / (luminance(color) + 0.05) < CONTRAST:
        parts = [x * 0.96 for x in parts]
        color = "#" + "".join(f"{round(x):02x}" for x in parts)
    return color


KINDS = {
    "weight": (INK, 1.5, ()),
    "load": (VERMILLION, 1.9, ()),
    "motor": (VERMILLION, 1.9, ()),
    "spring": (GREEN, 1.5, (5.0, 2.0)),
    "damper": (GREEN, 1.5, (2.0, 2.0)),
    "reaction": (BLUE, 1.5, ()),
    "contact": (PURPLE, 1.5, ()),
    "friction": (PURPLE, 1.5, (4.0, 1.5)),
    "kinetic": (INK, 1.5, ()),
}
"""Colour, width [pt] and dashes of the arrow of each kind of action."""
