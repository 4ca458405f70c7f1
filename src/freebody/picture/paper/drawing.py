"""A finished drawing: notebooks show it, and it is saved as SVG, PDF, PNG or TikZ."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import FormatError
from ...formats.files import replacing
from .labels import outline
from .sheet import Arrow, Circle, Label, Sheet, Style, flat
from .svg import svg
from .tikz import tikz

FORMATS = (".svg", ".pdf", ".png", ".tex")


class Drawing:
    """A drawing of a model, made by :func:`freebody.draw` and :func:`freebody.free_body_diagram`.

    Attributes
    ----------
    sheet : Sheet
        Lines, arrows and labels, in points.
    """

    def __init__(self, sheet: Sheet) -> None:
        self.sheet = sheet

    @cached_property
    def svg(self) -> str:
        """SVG text of the drawing, without scripts and fonts, so that any page can hold it."""
        return svg(self.sheet)

    @cached_property
    def tikz(self) -> str:
        """LaTeX document of the drawing, in TikZ, ready to edit."""
        return tikz(self.sheet)

    @property
    def size(self) -> tuple[float, float]:
        """Width and height [pt]."""
        x0, y0, x1, y1 = self.sheet.box
        return (x1 - x0, y1 - y0)

    def save(self, path: str | Path, dpi: float = 200) -> None:
        """Write the drawing to a file in the format of its ending: ``.svg``, ``.pdf``, ``.png`` or ``.tex`` (TikZ).

        Raises
        ------
        FormatError
            If the file name has another ending, or the file cannot be written.
        """
        path = Path(path)
        ending = path.suffix.lower()
        if ending not in FORMATS:
            raise FormatError(
                f"Expected a file name that ends in {', '.join(FORMATS)} for a drawing, got '{path.name}'."
            )
        with replacing(path) as new:
            if ending == ".svg":
                new.write_text(self.svg, encoding="utf-8")
            elif ending == ".tex":
                new.write_text(self.tikz, encoding="utf-8")
            else:
                self.figure().savefig(new, dpi=dpi, format=ending[1:])

    def figure(self) -> Any:
        """Matplotlib Figure of the drawing in its true size, with the same outlines as the SVG."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
        from matplotlib.patches import Circle as Round
        from matplotlib.patches import PathPatch
        from matplotlib.path import Path as Curve

        x0, y0, x1, y1 = self.sheet.box
        figure = Figure(figsize=((x1 - x0) / 72, (y1 - y0) / 72), facecolor="white")
        FigureCanvasAgg(figure)
        ax = figure.add_axes((0, 0, 1, 1))
        ax.set_xlim(x0, x1)
        ax.set_ylim(y0, y1)
        ax.axis("off")

        def patch(curve: Any, style: Style, order: int) -> None:
            ax.add_patch(PathPatch(curve, zorder=order, **_patch(style)))

        for order, item in enumerate(flat(self.sheet.root)):
            if isinstance(item, Label):
                shape = outline(item.tex)
                if len(shape.codes):
                    vertices = item.at + (shape.vertices - np.array(shape.box[:2])) * item.size
                    patch(Curve(vertices, shape.codes), Style(None, fill=item.color), order)
            elif isinstance(item, Circle):
                ax.add_patch(Round(tuple(item.center), item.radius, zorder=order, **_patch(item.style)))
            elif isinstance(item, Arrow):
                patch(Curve(item.shaft()), item.style, order)
                filled = "#ffffff" if item.head == "open" else item.style.stroke
                for head in item.heads():
                    closed = Curve(np.vstack([head, head[:1]]), closed=True)
                    patch(closed, Style(item.style.stroke, 1.0, (), filled), order)
            else:
                points = np.vstack([item.points, item.points[:1]]) if item.closed else item.points
                patch(Curve(points, closed=item.closed), item.style, order)
        return figure

    def _repr_svg_(self) -> str:
        return self.svg

    def _repr_html_(self) -> str:
        return f'<div style="overflow-x:auto">{self.svg}</div>'

    def __repr__(self) -> str:
        w, h = self.size
        return f"{self.sheet.title} ({w:.0f} x {h:.0f} pt; .svg, .save('x.pdf'))"


def _patch(style: Style) -> dict[str, Any]:
    stroke = style.stroke
    return {
        "facecolor": style.fill or "none",
        "edgecolor": stroke or "none",
        "linewidth": style.width if stroke else 0.0,
        "linestyle": (0, tuple(x / style.width for x in style.dash)) if style.dash and stroke else "solid",
        "joinstyle": "round",
        "capstyle": "butt" if style.dash else "round",
    }
