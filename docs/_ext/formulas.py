"""Mathematics of the guides, set as on freebody's own pages: outlines of letters, no script, no request.

``$…$`` in a line and ``$$…$$`` as a block are LaTeX; each has its glyphs with it.
"""

from __future__ import annotations

from typing import Any

from freebody.typesetting.html import Glyphs


def setup(app: Any) -> dict[str, Any]:
    app.add_html_math_renderer("freebody", (inline, None), (block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def inline(translator: Any, node: Any) -> None:
    """Set a formula in a line of text."""
    glyphs = Glyphs()
    shown = glyphs.line(node.astext())
    translator.body.append(glyphs.svg() + shown)
    _skip()


def block(translator: Any, node: Any) -> None:
    """Set a formula as a block, its equations below one another."""
    glyphs = Glyphs()
    shown = glyphs.block(node.astext())
    translator.body.append(f"<div>{glyphs.svg()}{shown}</div>")
    _skip()


def _skip() -> None:
    from docutils.nodes import SkipNode

    raise SkipNode
