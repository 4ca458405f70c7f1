"""A long solution of linear equations in steps: every unknown by those that stand above it, coefficients by name.

    x_n = b_n / a_n,    x_i = (b_i - Σ_j>i a_ij x_j) / a_ii

Gauss's elimination, repeated with the pivots and the zeros of the exact one and without putting back. A coefficient of
more than SHORT terms gets a name k_1, k_2, …, by which all that follows is written, so that no line is long.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain, count
from typing import Any

import sympy

from ...scalar.element import Polynomial
from ...scalar.ratio import Ratio
from ..printing.systems import Pivot, Terms, replaced, scaled

SHORT = 8
"""Most terms of a coefficient without a name."""
LONG = 200
"""Most terms of an answer that is printed in one line."""


def steps(
    ring: Any, rows: Sequence[Terms], pivots: Sequence[Pivot], places: Mapping[str, Any], asked: Sequence[str],
    taken: Sequence[str],
) -> tuple[list[tuple[str, Ratio]], list[tuple[str, Ratio]]]:  # fmt: skip
    """(unknowns, coefficients): names with their values, each by earlier ones of the list and by coefficients.

    Parameters
    ----------
    ring : Ring
    rows : sequence of Terms
        The equations as they were before elimination.
    pivots : sequence of Pivot
        What the elimination did.
    places : mapping
        Unknown -> element that stands for it.
    asked : sequence of str
        The unknowns that are wanted; others appear where they are needed.
    taken : sequence of str
        Names that coefficients can not have.
    """
    letters = chain("kKz", ("k" * n for n in count(2)))
    names = _Names(ring, next(letter for letter in letters if not _begins(letter, taken)))
    left = [{key: names.short(c) for key, c in terms.items()} for terms in rows]
    values: dict[str, Terms] = {}
    for pivot in pivots:
        own = left[pivot.row]
        inverse = -1 / own[((pivot.unknown, 1),)]
        value = scaled({key: c for key, c in own.items() if key != ((pivot.unknown, 1),)}, inverse)
        values[pivot.unknown] = {key: names.short(c) for key, c in value.items()}
        for i, alive in pivot.changed.items():
            found = replaced(left[i], pivot.unknown, values[pivot.unknown])
            left[i] = {key: names.short(c) for key, c in found.items() if key in alive}
    needed = set(asked)
    for unknown, terms in values.items():  # what stands in a line is solved after it
        if unknown in needed:
            needed |= {v for monomial in terms for v, _ in monomial}
    lines = [(v, _whole(ring, values[v], places)) for v in reversed(values) if v in needed]
    return lines, names.used(lines)


def _begins(letter: str, taken: Sequence[str]) -> bool:
    return any(name.startswith(f"{letter}_") for name in taken)


def _whole(ring: Any, terms: Terms, places: Mapping[str, Any]) -> Ratio:
    total = Ratio(ring, 0)
    for monomial, c in terms.items():
        for v, n in monomial:
            c = c * places[v] ** n
        total = total + c
    return total.tidy()


@dataclass
class _Names:
    """Names of long coefficients, in the order of their making."""

    ring: Any
    letter: str
    table: dict[str, Ratio] = field(default_factory=dict)

    def short(self, c: Ratio) -> Ratio:
        """c, or a name for it, or the negative of one."""
        if len(c) <= SHORT:
            return c
        for name, known in self.table.items():
            if (known.num, known.den) == (c.num, c.den):
                return self._symbol(name)
            if (-known.num, known.den) == (c.num, c.den):
                return -self._symbol(name)
        name = f"{self.letter}_{len(self.table) + 1}"
        self.table[name] = c
        return self._symbol(name)

    def _symbol(self, name: str) -> Ratio:
        return Ratio(self.ring, self.ring.generator(sympy.Symbol(name, real=True), "parameter"))

    def used(self, lines: Sequence[tuple[str, Ratio]]) -> list[tuple[str, Ratio]]:
        """Those that the lines need."""
        kept: set[str] = set().union(*(self._in(value) for _, value in lines))
        for name in reversed(self.table):
            if name in kept:
                kept |= self._in(self.table[name])
        return [(name, value.tidy()) for name, value in self.table.items() if name in kept]

    def _in(self, value: Ratio) -> set[str]:
        parts = [x for x in (value.num, value.den) if type(x) is Polynomial]
        return {str(a) for x in parts for a in x.atoms() if str(a) in self.table}
