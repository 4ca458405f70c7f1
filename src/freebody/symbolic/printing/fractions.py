"""Ratios of canonical polynomials in print: text, LaTeX, MathML, SymPy."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from ...scalar.element import Polynomial
from ...scalar.half_angles import half_angles
from ...scalar.polynomial import Ring
from ...scalar.ratio import Ratio
from .closed.answers import answer, is_answer
from .display import displayed, latex, text
from .latex import Latex
from .printer import Printer
from .text import Text


def parts(r: Any, ring: Ring) -> tuple[Any, Any, Ring]:
    """Return numerator and denominator as they are printed, with integers under the bar, and their ring.

    With sines or cosines in the denominator, the form is the one common to all equal fractions (`half_angles`).
    """
    if type(r) is not Ratio:
        return r, 1, ring
    form = half_angles(r.num, r.den)
    if form is not None:
        ring, r = form.ring, Ratio(form.ring, form.top, form.below)
    num, den = r.num, r.den
    if den == 1:
        return num, 1, ring
    integer = num.den if type(num) is Polynomial else Fraction(num).denominator
    if text(den, ring).startswith("-"):
        integer = -integer
    return num * integer, den * integer, ring


def ratio_text(r: Any, ring: Ring) -> str:
    """Return a ratio, an element or a number as plain text."""
    form = _closed(Text, r, ring)
    if form is not None:
        return str(form)
    num, den, ring = parts(r, ring)
    top = text(num, ring, closed=False)
    if den == 1:
        return top
    below = text(den, ring, closed=False)
    return f"{_bracketed(top)}/{below if _simple(below) else f'({below})'}"


def _closed(kind: type[Printer], r: Any, ring: Ring) -> Any:
    """Return the closed form of a ratio; None for a long one, and for an element with speeds."""
    num, den = (r.num, r.den) if type(r) is Ratio else (r, 1)
    return answer(kind, num, ring, den) if type(den) is Polynomial or is_answer(num) else None


def _simple(written: str) -> bool:
    return not any(c in written for c in " */")


def _bracketed(written: str) -> str:
    depth = 0
    for i, c in enumerate(written):
        depth += (c == "(") - (c == ")")
        if depth == 0 and c == " " and i:
            return f"({written})"
    return written


def ratio_latex(r: Any, ring: Ring) -> str:
    """Return a ratio as LaTeX."""
    form = _closed(Latex, r, ring)
    if form is not None:
        return str(form)
    num, den, ring = parts(r, ring)
    if den == 1:
        return latex(num, ring)
    over = latex(num, ring, closed=False)
    if over.startswith("-") and _bracketed(over) == over:
        return f"-\\frac{{{over[1:].strip()}}}{{{latex(den, ring, closed=False)}}}"
    return f"\\frac{{{over}}}{{{latex(den, ring, closed=False)}}}"


def ratio_displayed(r: Any, ring: Ring) -> Any:
    """Return a ratio as a SymPy expression, numerator and denominator grouped as they are printed."""
    num, den, ring = parts(r, ring)
    top = displayed(num, ring)
    return top if den == 1 else top / displayed(den, ring)
