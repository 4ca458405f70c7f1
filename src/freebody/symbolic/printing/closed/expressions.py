"""SymPy expressions in print: roots joined, fractions combined, frequencies in closed form.

SymPy itself keeps √(3 g/(2 L)) as √6 √(g/L)/2, and that in every cosine of a response.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import sympy

from ....errors import FreebodyError
from ....scalar.polynomial import Ring
from ..latex import Latex
from ..lines import Result
from ..printer import Printer
from ..show import latex_of, text_of
from ..text import Text
from .answers import closed

WAVES = (sympy.cos, sympy.sin, sympy.exp)


@dataclass(frozen=True)
class Closed(Result):
    """A SymPy expression, or a number, that prints in closed form."""

    expression: Any
    ring: Ring | None

    def text(self) -> str:
        """The expression as plain text."""
        return _written(Text, self.expression, self.ring)

    def latex(self) -> str:
        """The expression as LaTeX."""
        return _written(Latex, self.expression, self.ring)


class Expressions(list[Any], Result):
    """A list of SymPy expressions that prints them as a book does.

    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> L, g = s.parameters(L=2, g=9.81)
    >>> s.gravity = (0, -g, 0)
    >>> bar = s.body("bar", fb.slender_bar(1, L, axis="y"))
    >>> pin = s.hinge("pin", s.ground, bar, to=(0, L/2, 0), axis="z", coordinate="theta")
    >>> fb.linearize(s).natural_frequencies()
    [sqrt(3*g/(2*L))]
    """

    def __init__(self, expressions: Iterable[Any] = (), ring: Ring | None = None) -> None:
        super().__init__(expressions)
        self.ring = ring

    def text(self) -> str:
        """The expressions as plain text."""
        return "[" + ", ".join(Closed(x, self.ring).text() for x in self) + "]"

    def latex(self) -> str:
        """The expressions as LaTeX."""
        return r",\quad ".join(Closed(x, self.ring).latex() for x in self)

    __str__ = __repr__ = Result.__repr__

    def __reduce__(self) -> tuple[Any, ...]:
        return Expressions, (list(self),)  # a copy in another process prints as SymPy does


def _written(kind: type[Printer], x: Any, ring: Ring | None) -> str:
    x, write = sympy.sympify(x), text_of if kind is Text else latex_of
    waves = sorted(x.atoms(*WAVES), key=str)
    if not waves:
        return _shortest(kind, x, ring)
    # letters in place of the waves e^(a t), cos(w t), sin(w t), which are written last
    letters = [sympy.Symbol(f"wave_{k + 100}") for k in range(len(waves))]
    inner = x.xreplace(dict(zip(waves, letters, strict=True)))
    result = _shortest(kind, inner, ring)
    for wave, letter in zip(waves, letters, strict=True):
        result = result.replace(write(letter), _wave(kind, wave, _shortest(kind, wave.args[0], ring)))
    return result


def _wave(kind: type[Printer], wave: Any, inside: str) -> str:
    """A wave with its argument as printed."""
    name = type(wave).__name__
    if kind is Text:
        return f"{name}({inside})"
    return f"e^{{{inside}}}" if name == "exp" else rf"\{name}\left({inside}\right)"


def _shortest(kind: type[Printer], x: Any, ring: Ring | None) -> str:
    """An expression in closed form, or as it is if that is shorter: roots of what may be negative are not joined."""
    found, plain = _closed(Text, x, ring), text_of(x)
    if found is None or len(plain) < len(found):
        return plain if kind is Text else latex_of(x)
    return found if kind is Text else str(_closed(kind, x, ring))


def _closed(kind: type[Printer], x: Any, ring: Ring | None) -> str | None:
    """An expression in closed form; None if it is complex or has none."""
    if ring is None or x.has(sympy.I):
        return None
    try:
        return str(closed(kind, ring.from_sympy(x), ring))
    except FreebodyError:
        return None
