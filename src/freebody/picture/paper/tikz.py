r"""A sheet as TikZ source that compiles by itself; its lines, arrows and formulas can be edited."""

from __future__ import annotations

from typing import Any

from .sheet import HEAD, Arrow, Circle, Group, Label, Line, Sheet, Style, flat, shortened

NARROW = 0.92
"""Size of Computer Modern relative to STIX at which both are about equally wide: labels are placed for STIX."""

WIDE = 60.0
"""Width above which a label counts as a line of text [pt]."""


def tikz(sheet: Sheet) -> str:
    """Return the sheet as a LaTeX document of the class ``standalone``; the unit is a point."""
    colors: dict[str, str] = {}
    for item in flat(sheet.root):
        for color in (item.color,) if isinstance(item, Label) else (item.style.stroke, item.style.fill):
            if color is not None:
                colors.setdefault(color, f"fb{chr(97 + len(colors) // 26)}{chr(97 + len(colors) % 26)}")
    lines = [
        f"% {_comment(sheet.title)}",
        r"\RequirePackage{fix-cm}",
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
            x0, y0, x1, y1 = item.box
            size = NARROW * item.size
            # a line of text is anchored at its beginning, a symbol at its middle
            anchor, x = ("west", x0) if x1 - x0 > WIDE else ("center", (x0 + x1) / 2)
            lines.append(
                rf"{indent}\node[anchor={anchor},inner sep=0pt,text={colors[item.color]},"
                rf"font=\fontsize{{{size:.4g}}}{{{1.2 * size:.4g}}}\selectfont] "
                rf"at {_at((x, (y0 + y1) / 2))} {{{item.tex}}};"
            )
        elif isinstance(item, Circle):
            lines.append(
                rf"{indent}\path[{_style(item.style, colors)}] {_at(item.center)} circle[radius={item.radius:.3f}];"
            )
        elif isinstance(item, Arrow):
            lines += [rf"{indent}\path[{options}] {path};" for options, path in _arrow(item, colors)]
        else:
            assert isinstance(item, Line)
            closed = " -- cycle" if item.closed else ""
            lines.append(rf"{indent}\path[{_style(item.style, colors)}] {_path(item.points)}{closed};")
    return lines


def _arrow(arrow: Arrow, colors: dict[str, str]) -> list[tuple[str, str]]:
    """Options and points of the paths of an arrow: one path with heads; for a curve its shaft and a straight end."""
    length, half = HEAD[0] * arrow.size, HEAD[1] * arrow.size
    fill = ",line width=0.8pt,fill=white" if arrow.head == "open" else ""
    tip = f"Stealth[length={length:.3g}pt,width={2 * half:.3g}pt,inset={0.22 * length:.3g}pt{fill}]"
    heads = {"double": f"-{{{tip} {tip}}}", "both": f"{{{tip}}}-{{{tip}}}"}.get(arrow.head, f"-{{{tip}}}")
    style = _style(arrow.style, colors)
    if arrow.head == "inward":
        shaft = arrow.shaft()
        return [(f"{heads},{style}", _path(side)) for side in (shaft[:2], shaft[:-3:-1])]
    if len(arrow.points) == 2:
        return [(f"{heads},{style}", _path(arrow.points))]
    end = shortened(arrow.points, 1.2 * length)
    return [(style, _path(end)), (f"{heads},{style}", _path([end[-1], arrow.tip]))]


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


def _path(points: Any) -> str:
    return " -- ".join(map(_at, points))


def _at(point: Any) -> str:
    return f"({point[0]:.3f},{point[1]:.3f})"


def _html(color: str) -> str:
    return color.removeprefix("#").upper()


def _comment(text: str) -> str:
    return " ".join(text.split())
