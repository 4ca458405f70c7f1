"""Canonical polynomials in print: text, LaTeX, MathML and grouped SymPy.

They are printed directly from the polynomial; only `displayed` builds a SymPy expression.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...scalar.algebra import Scalar
from ...scalar.polynomial import Ring
from .arrange import Lumps as Lumps
from .closed.answers import shown
from .grouped import Grouped
from .latex import Latex
from .lines import Result
from .printer import Printer
from .show import aligned
from .text import Text


def text(x: Scalar, ring: Ring, lump: bool | Lumps = False, closed: bool | None = None) -> Any:
    """Return an element or a number as plain text.

    An element without speeds, accelerations and reactions is an answer: it is printed in its closed form, with the
    fewest operations. All others are grouped by accelerations and speeds, as the sides of an equation are.

    Parameters
    ----------
    x : Polynomial, int or Fraction
    ring : Ring
    lump : bool or Lumps, optional
        Name the distinct polynomials of parameters. With True the result is ``(text, table)``, the table of names
        as text. A `Lumps` is filled with the names, which several equations can share.
    closed : bool, optional
        Print the closed form in any case, or in none.

    Examples
    --------
    >>> import sympy
    >>> m, M, a = sympy.symbols("m M a")
    >>> q = sympy.Function("theta")(sympy.Symbol("t"))
    >>> ring = Ring()
    >>> x = ring.from_sympy(m * a * q.diff() ** 2 * sympy.sin(q) + (M + m) * q.diff())
    >>> print(text(x, ring))
    m*a*theta'^2*sin(theta) + (M + m)*theta'
    >>> g, L = sympy.symbols("g L", positive=True)
    >>> print(text(ring.from_sympy(sympy.sqrt(3) * sympy.sqrt(g) * sympy.sqrt(L) / L), ring))
    sqrt(3*g/L)
    """
    return _lumped(Text, x, ring, lump, closed)


def latex(x: Scalar, ring: Ring, lump: bool | Lumps = False, closed: bool | None = None) -> Any:
    """Return an element as LaTeX; see `text`."""
    return _lumped(Latex, x, ring, lump, closed)


def displayed(x: Scalar, ring: Ring) -> Any:
    """Return an element as a SymPy expression, grouped as its text is."""
    return Grouped(ring).show(x)


def equation_text(left: Scalar, right: Scalar, ring: Ring, lump: bool | Lumps = False) -> Any:
    """Return ``left = right`` as plain text; see `text`."""
    return _equation(Text, left, right, ring, lump, " = ")


def equation_latex(left: Scalar, right: Scalar, ring: Ring, lump: bool | Lumps = False) -> Any:
    """Return ``left = right`` as LaTeX."""
    return _equation(Latex, left, right, ring, lump, " = ")


def lines_of(
    kind: type[Printer], sides: Sequence[tuple[Scalar, Scalar]], ring: Ring, sign: str
) -> tuple[list[str], list[str]]:
    """Return equations as lines, and as further lines the names of their long roots and denominators."""
    long = Lumps("P")
    lines = []
    for left, right in sides:
        printer = kind(ring, None, long)
        lines.append(f"{printer.show(left)}{sign}{printer.show(right)}")
    printer = kind(ring)
    return lines, [f"{printer.name(name)}{sign}{printer.show(x)}" for name, x in long.table.items()]


class Formulas(Result):
    """A result that is a list of equations; ``_lines(write)`` prints them with one of the functions above."""

    def _lines(self, write: Any) -> list[str]:
        raise NotImplementedError

    def text(self) -> str:
        """The equations as plain text, a line each."""
        return "\n".join(self._lines(equation_text))

    def latex(self) -> str:
        """The equations as a LaTeX ``aligned`` block."""
        rows = [line.replace(" = ", " &= ", 1) for line in self._lines(equation_latex)]
        return aligned(rows)


def _lumped(kind: type[Printer], x: Scalar, ring: Ring, lump: bool | Lumps, closed: bool | None) -> Any:
    lumps = Lumps() if lump is True else lump or None
    if lumps is None:
        return shown(kind, x, ring, closed)
    result = kind(ring, lumps).show(x)
    return (result, _table(kind, ring, lumps)) if lump is True else result


def _equation(
    kind: type[Printer], left: Scalar, right: Scalar, ring: Ring, lump: bool | Lumps, sign: str
) -> Any:
    lumps = Lumps() if lump is True else lump or None
    printer = kind(ring, lumps)
    shown = f"{printer.show(left)}{sign}{printer.show(right)}"
    return (shown, _table(kind, ring, lumps)) if lump is True and lumps else shown


def _table(kind: type[Printer], ring: Ring, lumps: Lumps) -> dict[str, str]:
    printer = kind(ring)
    return {name: printer.show(value) for name, value in lumps.table.items()}
