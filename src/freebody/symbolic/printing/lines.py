"""Results that print themselves: base classes, and lines of words, names and formulas.

One description of lines gives text and LaTeX.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import sympy

from .latex import latex_name, latex_number
from .show import (
    aligned,
    column_latex,
    column_text,
    latex_of,
    latex_words,
    split,
    text_of,
)
from .typeset import Typeset

SIGNS = {"=": "=", "->": r"\to", ",": ","}


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
"""Words (str), a Name, a Sign, a number, a SymPy expression or column, a Result."""


class Result(Typeset):
    """A result with ``text``, ``latex`` and ``html``; notebooks show it set, a console its text."""

    def text(self) -> str:
        """Return the result as plain text."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return self.text()


class Lines(Result):
    """A result that ``_lines`` describes; each line is a sequence of pieces."""

    def _lines(self) -> Sequence[Sequence[Piece]]:
        raise NotImplementedError

    def text(self) -> str:
        """The result as plain text."""
        return "\n".join("".join(map(_text, line)) for line in self._lines())

    def latex(self) -> str:
        """The result as a LaTeX ``aligned`` block."""
        return aligned("&" + " ".join(map(_latex, line)) for line in self._lines())


class Shown(Result):
    """A result that consists of other results, shown one after another."""

    def _parts(self) -> Sequence[Any]:
        raise NotImplementedError

    def text(self) -> str:
        """All parts as plain text."""
        return "\n".join(part.text() for part in self._parts())

    def latex(self) -> str:
        """All parts as a LaTeX ``aligned`` block."""
        return aligned("&" + part.latex() for part in self._parts())


def assignments(values: Iterable[tuple[str, Any]]) -> list[Piece]:
    """Return the pieces of ``a = 1, b = 2``."""
    result: list[Piece] = []
    for name, value in values:
        result += [*([COMMA] if result else []), Name(name), EQUALS, value]
    return result


def rounded(x: Any) -> Any:
    """Return a number, rounded as it is shown, as a SymPy expression."""
    if isinstance(x, complex):
        return rounded(x.real) + sympy.I * rounded(x.imag)
    short = float(f"{float(x):.6g}")
    return sympy.Integer(int(short)) if short == int(short) else sympy.Float(str(short))


def _formula(x: Any) -> Any:
    return (
        x if isinstance(x, sympy.Basic | sympy.MatrixBase) else rounded(complex(x) if _is_complex(x) else x)
    )


def _is_complex(x: Any) -> bool:
    return bool(isinstance(x, complex) and x.imag)


def _text(x: Piece) -> str:
    if isinstance(x, str):
        return x
    if isinstance(x, Result):
        return x.text()
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
    if isinstance(x, Result):
        return x.latex()
    if isinstance(x, Name):
        return latex_name(*split(x.text))
    if isinstance(x, Sign):
        return SIGNS[x.text]
    if isinstance(x, sympy.MatrixBase):
        return column_latex(x)
    return latex_of(x) if isinstance(x, sympy.Basic) else latex_number(x)
