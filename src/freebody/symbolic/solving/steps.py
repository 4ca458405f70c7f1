"""A long solution of linear equations in steps: every unknown by unknowns above it, with named coefficients.

    x_n = b_n / a_n,    x_i = (b_i - Σ_j>i a_ij x_j) / a_ii

Gauss's elimination is repeated with the pivots and the zeros of the exact elimination, but without back substitution. A
coefficient of more than SHORT terms gets a name k_1, k_2, …, which replaces it in all later lines, so no line is long.
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
    ring: Any, rows: Sequence[Terms], pivots: Sequence[Pivot], places: Mapping[str, Any], unknowns: Sequence[str],
    reserved: Sequence[str],
) -> tuple[list[tuple[str, Ratio]], list[tuple[str, Ratio]]]:  # fmt: skip
    """Return (unknowns, coefficients): pairs of a name and its value, by earlier names of the list and coefficients.

    Parameters
    ----------
    ring : Ring
    rows : sequence of Terms
        The equations before elimination.
    pivots : sequence of Pivot
        Steps of the elimination.
    places : mapping
        Unknown -> its element of the ring.
    unknowns : sequence of str
        Unknowns of the request; others are listed if these depend on them.
    reserved : sequence of str
        Names that coefficients cannot have.
    """
    letters = chain("kKz", ("k" * n for n in count(2)))
    names = _Names(ring, next(letter for letter in letters if not _begins(letter, reserved)))
    reduced = [{key: names.short(c) for key, c in terms.items()} for terms in rows]
    values: dict[str, Terms] = {}
    for pivot in pivots:
        row = reduced[pivot.row]
        inverse = -1 / row[((pivot.unknown, 1),)]
        value = scaled({key: c for key, c in row.items() if key != ((pivot.unknown, 1),)}, inverse)
        values[pivot.unknown] = {key: names.short(c) for key, c in value.items()}
        for i, nonzero in pivot.changed.items():
            terms = replaced(reduced[i], pivot.unknown, values[pivot.unknown])
            reduced[i] = {key: names.short(c) for key, c in terms.items() if key in nonzero}
    needed = set(unknowns)
    for unknown, terms in values.items():  # the unknowns in a line are solved after it
        if unknown in needed:
            needed |= {v for monomial in terms for v, _ in monomial}
    lines = [(v, _whole(ring, values[v], places)) for v in reversed(values) if v in needed]
    return lines, names.used(lines)


def _begins(letter: str, names: Sequence[str]) -> bool:
    return any(name.startswith(f"{letter}_") for name in names)


def _whole(ring: Any, terms: Terms, places: Mapping[str, Any]) -> Ratio:
    """Return terms as one ratio, with the unknowns as elements of the ring."""
    total = Ratio(ring, 0)
    for monomial, c in terms.items():
        for v, n in monomial:
            c = c * places[v] ** n
        total = total + c
    return total.tidy()


@dataclass
class _Names:
    """Names of long coefficients, in the order of their definition."""

    ring: Any
    letter: str
    table: dict[str, Ratio] = field(default_factory=dict)

    def short(self, c: Ratio) -> Ratio:
        """Return c, or its name if it is long, or minus the name of -c."""
        if len(c) <= SHORT:
            return c
        for name, value in self.table.items():
            if (value.num, value.den) == (c.num, c.den):
                return self._symbol(name)
            if (-value.num, value.den) == (c.num, c.den):
                return -self._symbol(name)
        name = f"{self.letter}_{len(self.table) + 1}"
        self.table[name] = c
        return self._symbol(name)

    def _symbol(self, name: str) -> Ratio:
        return Ratio(self.ring, self.ring.generator(sympy.Symbol(name, real=True), "parameter"))

    def used(self, lines: Sequence[tuple[str, Ratio]]) -> list[tuple[str, Ratio]]:
        """Return the named coefficients that the lines need, with their values."""
        needed: set[str] = set().union(*(self._names_in(value) for _, value in lines))
        for name in reversed(self.table):
            if name in needed:
                needed |= self._names_in(self.table[name])
        return [(name, value.tidy()) for name, value in self.table.items() if name in needed]

    def _names_in(self, value: Ratio) -> set[str]:
        parts = [x for x in (value.num, value.den) if type(x) is Polynomial]
        return {str(a) for x in parts for a in x.atoms() if str(a) in self.table}
