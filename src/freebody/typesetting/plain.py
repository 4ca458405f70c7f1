"""Formulas in one line of Unicode: what a screen reader says, and what a search finds."""

from __future__ import annotations

import re
import unicodedata

from .latex import (
    BIN,
    CLOSE,
    INNER,
    OPEN,
    PUNCT,
    REL,
    Accent,
    Fenced,
    Fraction,
    Grid,
    Node,
    Root,
    Row,
    Scripts,
    Space,
    Symbol,
    Words,
    parse,
)

MARKS = {
    "˙": "\u0307",
    "¨": "\u0308",
    "⃛": "\u20db",
    "ˆ": "\u0302",
    "˜": "\u0303",
    "line": "\u0304",
    "¯": "\u0304",
    "→": "\u20d7",
}
"""Combining marks of accents."""


def plain(node: Node) -> str:
    r"""Return a formula in words and signs.

    >>> from .latex import parse
    >>> print(plain(parse(r"\frac{1}{2} m \left(\dot{x}_{1}^{2} - g\right) \sin\theta")))
    1/2 m (ẋ_1^2 − g) sin θ
    """
    return unicodedata.normalize("NFC", " ".join(_plain(node).split()))


def plain_line(text: str) -> str:
    r"""Return a line of text with formulas between dollar signs in words and signs.

    >>> print(plain_line(r"mass $m_{1}$"))
    mass m_1
    """
    parts = re.split(r"(?<!\\)\$", text)
    return "".join(plain(parse(x)) if k % 2 else x.replace("\\$", "$") for k, x in enumerate(parts))


def _plain(node: Node) -> str:
    match node:
        case Row():
            return "".join(_in_row(node))
        case Symbol():
            return node.text
        case Space():
            return " " if node.width > 0 else ""
        case Words():
            return node.text
        case Scripts():
            parts = [_plain(node.base)]
            parts += [f"_{_grouped(node.sub)}"] if node.sub is not None else []
            parts += [f"^{_grouped(node.sup)}"] if node.sup is not None else []
            return "".join(parts)
        case Fraction():
            return f"{_grouped(node.top)}/{_grouped(node.below)}"
        case Root():
            sign = {"3": "∛", "4": "∜"}.get(_plain(node.index), "√") if node.index is not None else "√"
            return f"{sign}{_grouped(node.body)}"
        case Fenced():
            return f"{node.left}{_plain(node.body)}{node.right}".strip()
        case Accent():
            return _plain(node.body) + MARKS[node.mark]
        case Grid():
            return "[" + "; ".join(", ".join(map(_plain, row)) for row in node.rows) + "]"


def _in_row(node: Row) -> list[str]:
    result: list[str] = []
    for k, x in enumerate(node.nodes):
        text = _plain(x)
        kind = (
            x.kind
            if isinstance(x, Symbol)
            else x.base.kind
            if isinstance(x, Scripts) and isinstance(x.base, Symbol)
            else INNER
        )
        if kind in (BIN, REL):
            text = f" {text} " if k else text
        elif kind == PUNCT:
            text += " "
        elif not isinstance(x, Space) and result:
            last = node.nodes[k - 1]
            digits = (
                isinstance(last, Symbol)
                and isinstance(x, Symbol)
                and (last.text + x.text).replace(".", "0").isdigit()
            )
            first = k == 1 and isinstance(last, Symbol) and last.kind == BIN
            tight = isinstance(last, Symbol) and last.kind == OPEN or kind == CLOSE
            text = text if digits or first or tight else f" {text}"
        result.append(text)
    return result


def _grouped(node: Node) -> str:
    text = _plain(node)
    return text if text.replace(".", "0").isalnum() or isinstance(node, Symbol | Accent) else f"({text})"
