"""Formulas in HTML: pieces of SVG in a line that wraps, over one table of glyphs, with words for who cannot see it.

``data-tex`` holds the LaTeX of the formula for the reader who copies it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from hashlib import blake2s
from html import escape

from .boxes import Box, Item, Named, Placed, Rule, bounds
from .glyphs import EM
from .latex import Node, parse, rows
from .lines import pieces
from .plain import plain
from .setting import Style, setting

NARROW, WIDE = 16, 40
"""Widths of columns for which formulas are broken [em]: that of a telephone, and of a page."""

STYLE = (
    ".formula{display:inline;font-size:1.08em}.formula svg,.glyphs path{fill:currentColor}"
    ".formula svg{overflow:visible;max-width:100%}.equation .formula svg{margin:.15em 0}"
    ".narrow-only{display:none}@media(max-width:760px){.wide-only{display:none}.narrow-only{display:inline}}"
    ".equation{padding-left:2em;text-indent:-2em;margin:.5em 0;line-height:1.7}"
)
"""Style sheet for formulas outside the pages of freebody, which have their own."""


class Glyphs:
    """Table of the glyphs that formulas of one document use.

    Formulas refer to the table by ids that depend on what a glyph is, and on nothing else.
    """

    def __init__(self) -> None:
        self._entries: dict[str, str] = {}

    def svg(self) -> str:
        """Return the table; it must be in the same document, anywhere."""
        if not self._entries:
            return ""
        inside = "".join(self._entries.values())
        hidden = 'width="0" height="0" style="position:absolute" aria-hidden="true"'
        return f'<svg class="glyphs" {hidden}><defs>{inside}</defs></svg>'

    def line(self, tex: str) -> str:
        r"""Return a formula as HTML inside a line of text.

        >>> Glyphs().line(r"\dot{\theta}").partition("<svg")[0]
        '<span class="formula" role="img" aria-label="θ̇" data-tex="\\dot{\\theta}">'
        """
        node = parse(tex)
        return self._span(tex, node, self._svgs([setting(node, Style(0, False))]))

    def block(self, tex: str, codes: Sequence[str] = ()) -> str:
        """Return the equations of a LaTeX formula or ``aligned`` block as HTML, a paragraph each, which wrap.

        ``codes`` are the first equations in the language of a program, for the reader who copies them.
        """
        parsed = [(row, parse(row)) for row in rows(tex)]
        return "\n".join(
            f'<div class="equation"{_code(code)}>{self._span(row, node, *self._columns(node))}</div>'
            for (row, node), code in zip(parsed, [*codes, *[""] * len(parsed)], strict=False)
        )

    def _columns(self, node: Node) -> tuple[str, ...]:
        """Return a formula for a wide column, and for a narrow one if a fraction or a root is too wide for that."""
        wide, narrow = (self._svgs(pieces(node, NARROW * EM, column * EM)) for column in (WIDE, NARROW))
        return (wide,) if wide == narrow else (wide, narrow)

    def _svgs(self, boxes: Iterable[Box]) -> str:
        return "".join(map(self._svg, boxes))

    def _span(self, tex: str, node: Node, wide: str, narrow: str | None = None) -> str:
        words = escape(plain(node))
        inside = (
            wide
            if narrow is None
            else f'<span class="wide-only">{wide}</span><span class="narrow-only">{narrow}</span>'
        )
        return (
            f'<span class="formula" role="img" aria-label="{words}" data-tex="{escape(tex)}">{inside}</span>'
        )

    def _svg(self, box: Box) -> str:
        _, low, _, high = bounds(box)
        top, height = -round(high), round(high) - round(low)
        items = "".join(map(self._item, box.items))
        return (
            f'<svg width="{_em(box.width)}" height="{_em(height)}" viewBox="0 {top} {round(box.width)} {height}" '
            f'style="vertical-align:{_em(low)}">{items}</svg>'
        )

    def _item(self, item: Item) -> str:
        if isinstance(item, Rule):
            return f'<path d="M{_n(item.x)} {_n(-item.y)}h{_n(item.width)}v{_n(-item.height)}h{_n(-item.width)}z"/>'
        across, up = (item.scale, item.scale) if isinstance(item, Named) else (item.across, item.up)
        key = self._key(item, across, up)
        places = (("x", round(item.x)), ("y", round(-item.y)))
        place = "".join(f' {axis}="{n}"' for axis, n in places if n)
        return f'<use href="#{key}"{place}/>'

    def _key(self, item: Placed | Named, across: float, up: float) -> str:
        """Enter what an item shows, in its size, into the table, and return its id."""
        if isinstance(item, Named):
            inside = "".join(map(self._item, item.inside.items))
            key = self._enter(f"f-{_digest(inside)}", lambda name: f"<g id={name}>{inside}</g>")
        else:
            g = item.glyph
            key = self._enter(f"f-{g.key}", lambda name: f'<path id={name} d="{g.path()}"/>')
        if across == 1 == up:
            return key
        size = f"{across:.3g}" if across == up else f"{across:.3g} {up:.4g}"
        use = f'<use href="#{key}" transform="scale({size})"/>'
        return self._enter(
            f"{key}-{size.replace(' ', '-').replace('0.', '')}", lambda name: f"<g id={name}>{use}</g>"
        )

    def _enter(self, key: str, entry: Callable[[str], str]) -> str:
        if key not in self._entries:
            self._entries[key] = entry(f'"{key}"')
        return key


def _code(code: str) -> str:
    return f' data-sympy="{escape(code)}"' if code else ""


def _digest(text: str) -> str:
    return blake2s(text.encode(), digest_size=4).hexdigest()


def _n(x: float) -> str:
    return str(round(x))


def _em(x: float) -> str:
    return f"{x / EM:.3f}".rstrip("0").rstrip(".") + "em"


def block(tex: str) -> str:
    """Return equations as HTML that stands alone, with its glyphs and style: for notebooks.

    >>> block("a = b").count("<use")
    3
    """
    glyphs = Glyphs()
    inside = glyphs.block(tex)
    return f"<div><style>{STYLE}</style>{glyphs.svg()}{inside}</div>"
