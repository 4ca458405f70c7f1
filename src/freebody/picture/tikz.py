r"""A sheet as TikZ source that compiles by itself, with lines, arrows and formulas to edit."""

from __future__ import annotations

from typing import Any

from .sheet import Arrow, Circle, Group, Label, Line, Sheet, Style, flat

_HEADS = {
    "full": "-{Latex[length=7pt,width=5pt]}",
    "open": "-{Latex[length=7pt,width=5pt,open]}",
    "double": "-{Latex[length=7pt,width=5pt] Latex[length=7pt,width=5pt]}",
    "both": "{Latex[length=5pt,width=4pt]}-{Latex[length=5pt,width=4pt]}",
}


def tikz(sheet: Sheet) -> str:
    """The sheet as a LaTeX document of the class ``standalone``; one unit is a point."""
    colors: dict[str, str] = {}
    for item in flat(sheet.root):
        for color in (item.color,) if isinstance(item, Label) else (item.style.stroke, item.style.fill):
            if color is not None:
                colors.setdefault(color, f"fb{chr(97 + len(colors) // 26)}{chr(97 + len(colors) % 26)}")
    lines = [
        f"% {_comment(sheet.title)}",
        r"\documentclass[tikz,border=6pt]{standalone}",
        r"\usepackage{amsmath}",
        r"\usetikzlibrary{arrows.meta}",
        *(rf"\definecolor{{{name}}}{{HTML}}{{{_html(color)}}}" for color, name in colors.items()),
        r"\begin{document}",
        r"\begin{tikzpicture}[x=1pt,y=1pt,line cap=round,line join=round]",
        *_items(sheet.root, colors, "  "),
        r"\end{tikzpicture}",
        r"\end{document}",
    ]
    return "\n".join(lines) + "\n"


def _items(group: Group, colors: dict[str, str], indent: str) -> list[str]:
    lines = []
    for item in group.items:
        if isinstance(item, Group):
            if item.title:
                lines.append(f"{indent}% {_comment(item.title)}")
            lines += [rf"{indent}\begin{{scope}}", *_items(item, colors, indent + "  ")]
            lines.append(rf"{indent}\end{{scope}}")
        elif isinstance(item, Label):
            lines.append(
                rf"{indent}\node[anchor=south west,inner sep=0pt,text={colors[item.color]},"
                rf"font=\fontsize{{{item.size:g}}}{{{1.2 * item.size:g}}}\selectfont] at {_at(item.at)} {{{item.tex}}};"
            )
        elif isinstance(item, Circle):
            lines.append(
                rf"{indent}\path[{_style(item.style, colors)}] {_at(item.center)} circle[radius={item.radius:.3f}];"
            )
        else:
            assert isinstance(item, Line | Arrow)
            head = f"{_HEADS[item.head]}," if isinstance(item, Arrow) else ""
            path = " -- ".join(map(_at, item.points))
            closed = " -- cycle" if isinstance(item, Line) and item.closed else ""
            lines.append(rf"{indent}\path[{head}{_style(item.style, colors)}] {path}{closed};")
    return lines


def _style(style: Style, colors: dict[str, str]) -> str:
    parts = []
    if style.stroke is not None:
        parts += [f"draw={colors[style.stroke]}", f"line width={style.width:g}pt"]
        if style.dash:
            pairs = zip(style.dash[::2], style.dash[1::2], strict=False)
            parts.append("dash pattern=" + " ".join(f"on {on:g}pt off {off:g}pt" for on, off in pairs))
    if style.fill is not None:
        parts.append(f"fill={colors[style.fill]}")
    return ",".join(parts)


def _at(point: Any) -> str:
    return f"({point[0]:.3f},{point[1]:.3f})"


def _html(color: str) -> str:
    return color.removeprefix("#").upper()


def _comment(text: str) -> str:
    return " ".join(text.split())
