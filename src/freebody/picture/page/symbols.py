"""Formulas and names of a page, set in outlines over one table of glyphs."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from html import escape
from typing import Any

from ...model.closure import Closure
from ...model.model import Model
from ...symbolic.printing.latex import label_latex
from ...symbolic.printing.names import GREEK, SPELLED
from ...typesetting.html import Glyphs
from ...typesetting.latex import parse
from ...typesetting.plain import plain

LONGEST = 30_000
"""Most characters of a formula in LaTeX; a longer one is not shown."""

COMPONENTS = ("x", "y", "z", "Mx", "My", "Mz")
"""Components of the reaction of a joint, after its name."""

_PUNCTUATED = re.compile(r'(<span class="formula"(?:(?!</span>).)*</span>[.,;:?!)]+)')
_POWER = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)e([+-]?\d+)(?!\w)")
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_TOKEN = re.compile(r"[A-Za-z]\w*'*(?:_\w+)?'*")


class Symbols:
    """Formulas and names of one page; ``names`` are those that are set wherever they stand between words.

    >>> page = Symbols(["theta_1", "h"])
    >>> page.words("largest theta_1").startswith('largest <span class="formula"')
    True
    """

    def __init__(self, names: Iterable[str] = ()) -> None:
        self.glyphs = Glyphs()
        self.names = {name for name in names if name not in ("a", "A", "I")}

    @classmethod
    def of(cls, model: Model, *more: str) -> Symbols:
        """Return the symbols of a machine's page."""
        states = model.state_names
        parameters = (parameter.name for parameter in model.parameters)
        joints = (*model.joints, *(name for name, x in model.constraints.items() if isinstance(x, Closure)))
        contacts = (name for x in model.contacts for name in (x.name, x.owner))
        reactions = (f"{name}_{component}" for name in joints for component in COMPONENTS)
        return cls(
            (
                *states,
                *parameters,
                *reactions,
                *contacts,
                *(f"{name}{dots}" for name in states for dots in ("'", "''")),
                *more,
            )
        )

    def name(self, name: str) -> str:
        """Return a name as HTML: a symbol, or words."""
        tex = None if _is_word(name) else label_latex(name)
        return escape(name) if tex is None else self.glyphs.line(tex)

    def words(self, text: str) -> str:
        """Return words as HTML, with the names between them set."""
        parts, end, text = [], 0, in_powers(text)
        for match in _TOKEN.finditer(text):
            if match[0] in self.names:
                parts += [escape(text[end : match.start()]), self.name(match[0])]
                end = match.end()
        return unbroken("".join(parts) + escape(text[end:]))

    def formula(self, tex: str, codes: Sequence[str] = ()) -> str:
        """Return a formula as HTML that wraps, or the reason why it is not shown; ``codes``: see `Glyphs.block`."""
        if len(tex) > LONGEST:
            return f"<p>Too long to show ({len(tex):,} characters of LaTeX).</p>"
        return self.glyphs.block(tex, codes)

    def scene(self, scene: Mapping[str, Any]) -> dict[str, Any]:
        """Return the data of a page with the labels of its charts and sliders as HTML."""
        labels = {label for chart in scene.get("charts", ()) for _, _, label in chart["curves"]}
        labels |= {slider["name"] for slider in scene.get("live", {}).get("sliders", ())}
        return {**scene, "symbols": self.labels(labels)}

    def labels(self, names: Iterable[str]) -> dict[str, str]:
        """Return the names that are symbols as HTML."""
        shown = {name: self.name(name) for name in sorted(names)}
        return {name: html for name, html in shown.items() if html != escape(name)}

    def table(self) -> str:
        """Return the glyphs of all that was set so far."""
        return self.glyphs.svg()


def unbroken(html: str) -> str:
    """Return words with formulas so that punctuation stays on the line of the formula before it.

    >>> unbroken('of <span class="formula">x</span>, too')
    'of <span class="unbroken"><span class="formula">x</span>,</span> too'
    """
    return _PUNCTUATED.sub(r'<span class="unbroken">\1</span>', html)


def in_powers(text: str) -> str:
    """Return a text with its numbers as a book prints them.

    >>> in_powers("balanced to 4.3e-14, of 1e+10 J")
    'balanced to 4.3 × 10⁻¹⁴, of 10¹⁰ J'
    """
    return _POWER.sub(
        lambda found: f"{found[1]} × 10{str(int(found[2])).translate(_RAISED)}".removeprefix("1 × "),
        text,
    )


@cache
def in_letters(name: str) -> str:
    """Return a name in letters, Greek ones too, with "_" before its subscript: for pictures that have no formulas.

    >>> in_letters("psi'_fast"), in_letters("Omega_zeta"), in_letters("weight")
    ('ψ̇_fast', 'Ω_ζ', 'weight')
    """
    tex = None if _is_word(name) else label_latex(name)
    return name if tex is None else plain(parse(tex))


def _is_word(name: str) -> bool:
    return name.isalpha() and len(name) > 1 and name not in GREEK and name not in SPELLED
