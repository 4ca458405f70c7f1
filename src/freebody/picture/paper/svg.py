"""A sheet as SVG text: no scripts, no fonts, no requests."""

from __future__ import annotations

from functools import cache
from html import escape
from typing import Any

import numpy as np

from ...typesetting.glyphs import EM, path
from ...typesetting.plain import plain_line
from .labels import outline
from .sheet import Arrow, Circle, Group, Label, Line, Sheet, Style


def svg(sheet: Sheet) -> str:
    """Return the sheet as one ``svg`` element; lengths in points, y points down as always in SVG."""
    x0, y0, x1, y1 = sheet.box
    width, height = x1 - x0, y1 - y0
    data = "".join(f' {key}="{escape(value)}"' for key, value in sheet.attributes.items())
    writer = _Writer(x0, y1)
    body = "\n".join(writer.item(item) for item in sheet.root.items)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.2f}pt" height="{height:.2f}pt" '
        f'viewBox="0 0 {width:.2f} {height:.2f}" role="img" data-origin="{-x0:.4f} {y1:.4f}"{data}>\n'
        f"<title>{escape(sheet.title)}</title>\n"
        f'<rect width="{width:.2f}" height="{height:.2f}" fill="#ffffff"/>\n'
        f"{body}\n</svg>\n"
    )


class _Writer:
    def __init__(self, left: float, top: float) -> None:
        self.left, self.top = left, top

    def _at(self, point: Any) -> str:
        return f"{point[0] - self.left:.3f} {self.top - point[1]:.3f}"

    def item(self, item: Any) -> str:
        if isinstance(item, Group):
            attributes = "".join(f' {key}="{escape(value)}"' for key, value in item.attributes.items())
            title = f"<title>{escape(item.title)}</title>" if item.title else ""
            return f"<g{attributes}>{title}\n" + "\n".join(map(self.item, item.items)) + "\n</g>"
        if isinstance(item, Label):
            return self._label(item)
        if isinstance(item, Circle):
            x, y = item.center
            return (
                f'<circle cx="{x - self.left:.3f}" cy="{self.top - y:.3f}" r="{item.radius:.3f}"'
                f"{_style(item.style)}/>"
            )
        if isinstance(item, Arrow):
            return self._arrow(item)
        assert isinstance(item, Line)
        return f'<path d="{self._path(item.points)}{" Z" if item.closed else ""}"{_style(item.style)}/>'

    def _path(self, points: Any) -> str:
        return "M" + " L".join(self._at(p) for p in points)

    def _arrow(self, arrow: Arrow) -> str:
        style = arrow.style
        ends = f'data-start="{self._at(arrow.points[0])}" data-end="{self._at(arrow.points[-1])}"'
        parts = [f'<path class="shaft" {ends} d="{self._path(arrow.shaft())}"{_style(style)}/>']
        filled = Style(style.stroke, 1.0, (), "#ffffff" if arrow.head == "open" else style.stroke)
        for head in arrow.heads():
            parts.append(f'<path class="head" d="{self._path(head)} Z"{_style(filled)}/>')
        return "\n".join(parts)

    def _label(self, label: Label) -> str:
        left, bottom, *_ = outline(label.tex).box
        x, y = label.at - label.size * np.array([left, bottom])
        em = label.size / EM
        words = escape(plain_line(label.tex))
        return (
            f'<path class="label" data-tex="{escape(label.tex)}" role="img" aria-label="{words}" '
            f'transform="matrix({em:.6g} 0 0 {em:.6g} {x - self.left:.2f} {self.top - y:.2f})" '
            f'd="{_letters(label.tex)}" fill="{label.color}"/>'
        )


@cache
def _letters(tex: str) -> str:
    """Outline of a line of text as data of an SVG path, in thousandths of an em."""
    shape = outline(tex)
    return path((EM * shape.vertices).round(), tuple(shape.codes))


def _style(style: Style) -> str:
    fill = style.fill or "none"
    if style.stroke is None:
        return f' fill="{fill}"'
    dash = f' stroke-dasharray="{" ".join(f"{x:g}" for x in style.dash)}"' if style.dash else ""
    return (
        f' fill="{fill}" stroke="{style.stroke}" stroke-width="{style.width:g}" stroke-linejoin="round"'
        f' stroke-linecap="{"butt" if style.dash else "round"}"{dash}'
    )
