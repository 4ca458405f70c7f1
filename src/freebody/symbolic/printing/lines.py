"""Results shown as lines of words, names and formulas: one description gives text, LaTeX and MathML."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import sympy

from .latex import latex_name
from .show import (
    aligned,
    column_latex,
    column_mathml,
    column_text,
    elements,
    latex_of,
    latex_words,
    mathml_of,
    shown_name,
    split,
    text_of,
    words,
)

SIGNS = {"=": "=", "->": r"\to", ",": ","}
MATHML_SIGNS = {"=": "=", "->": "→", ",": ","}


@dataclass(frozen=True)
class Name:
    """A name with its primes, such as ``psi'``."""

    text: str


@dataclass(frozen=True)
class Sign:
    """A sign between formulas: ``=``, ``->`` or a comma."""

    text: str


EQUALS = Sign("=")
COMMA = Sign(",")
Piece = Any
"""Words (str), a Name, a Sign, a number, a SymPy expression or column."""


class Lines:
    """A result that is described by ``_lines``, each a sequence of pieces."""

    def _lines(self) -> Sequence[Sequence[Piece]]:
        raise NotImplementedError

    def text(self) -> str:
        """The result as plain text."""
        return "\n".join("".join(map(_text, line)) for line in self._lines())

    def latex(self) -> str:
        """The same as a LaTeX ``aligned`` block."""
        return aligned("&" + " ".join(map(_latex, line)) for line in self._lines())

    def mathml(self) -> str:
        """The same as presentation MathML, an element for each line."""
        return elements("".join(map(_mathml, line)) for line in self._lines())

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"


class Shown:
    """A collection of results that each show themselves: one after another."""

    def _parts(self) -> Sequence[Any]:
        raise NotImplementedError

    def text(self) -> str:
        """All parts as plain text."""
        return "\n".join(one.text() for one in self._parts())

    def latex(self) -> str:
        """All parts as a LaTeX ``aligned`` block."""
        return aligned("&" + one.latex() for one in self._parts())

    def mathml(self) -> str:
        """All parts as presentation MathML."""
        return "\n".join(one.mathml() for one in self._parts())

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"


def assignments(values: Iterable[tuple[str, Any]]) -> list[Piece]:
    """``a = 1, b = 2``."""
    result: list[Piece] = []
    for name, value in values:
        result += [*([COMMA] if result else []), Name(name), EQUALS, value]
    return result


def rounded(x: Any) -> Any:
    """A number to the digits that are shown, as a SymPy expression."""
    if isinstance(x, complex):
        return rounded(x.real) + sympy.I * rounded(x.imag)
    short = float(f"{float(x):.6g}")
    return sympy.Integer(int(short)) if short == int(short) else sympy.Float(str(short))


def _formula(x: Any) -> Any:
    return x if isinstance(x, sympy.Basic | sympy.MatrixBase) else rounded(complex(x) if _complex(x) else x)


def _complex(x: Any) -> bool:
    return bool(isinstance(x, complex) and x.imag)


def _text(x: Piece) -> str:
    if isinstance(x, str):
        return x
    if isinstance(x, Name):
        return x.text
    if isinstance(x, Sign):
        return ", " if x is COMMA else f" {x.text} "
    if isinstance(x, sympy.MatrixBase):
        return column_text(x)
    return text_of(_formula(x))


def _latex(x: Piece) -> str:
    if isinstance(x, str):
        return latex_words(x)
    if isinstance(x, Name):
        return latex_name(*split(x.text))
    if isinstance(x, Sign):
        return SIGNS[x.text]
    if isinstance(x, sympy.MatrixBase):
        return column_latex(x)
    return latex_of(_formula(x))


def _mathml(x: Piece) -> str:
    if isinstance(x, str):
        return words(x)
    if isinstance(x, Name):
        return shown_name(x.text)
    if isinstance(x, Sign):
        return f"<mo>{MATHML_SIGNS[x.text]}</mo>"
    if isinstance(x, sympy.MatrixBase):
        return column_mathml(x)
    return mathml_of(_formula(x))
