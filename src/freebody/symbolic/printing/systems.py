"""Systems of equations in chosen unknowns, whose coefficients are ratios of canonical polynomials.

A row is a polynomial in the unknowns,  Σ c_k Π v_i^n_ik = 0,  with the c_k exact. Rows are used one after another:
an unknown that stands in a row only to the first power, and in no product, is taken from it and put into all others
(Gauss and Jordan, where everything is linear). A pivot is never zero, since zero is recognised; among the possible
ones the shortest is taken, so that 1 comes before m and m before m + M.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ...scalar.element import Polynomial
from ...scalar.ratio import Ratio

Monomial = tuple[tuple[Any, int], ...]
Terms = dict[Monomial, Ratio]
"""Monomials in unknowns (any sortable keys) with their coefficients."""


@dataclass
class Row:
    """One equation ``terms = 0``: its name, and the combination of the rows given that it is."""

    name: str
    terms: Terms
    combination: dict[Any, Ratio] = field(default_factory=dict)

    @property
    def unknowns(self) -> set[Any]:
        """The unknowns that occur."""
        return {v for monomial in self.terms for v, _ in monomial}

    def pivot(self, v: Any) -> Ratio | None:
        """Coefficient of an unknown that the row is linear in, with nothing unknown in front of it."""
        found = None
        for monomial, c in self.terms.items():
            for w, n in monomial:
                if w == v:
                    if n != 1 or len(monomial) != 1:
                        return None
                    found = c
        return found


def collect(x: Any, places: Mapping[int, tuple[Any, int]], ring: Any) -> Terms:
    """An element as a polynomial in the unknowns.

    Parameters
    ----------
    x : Polynomial, int or Fraction
    places : mapping
        Index of a generator of the ring -> (unknown, power of the generator that the unknown stands for).
    ring : Ring

    Raises
    ------
    ValueError
        With the generator that occurs in another power than the unknown.
    """
    if type(x) is not Polynomial:
        return {} if x == 0 else {(): Ratio(ring, x)}
    mask = 0
    for index in places:
        mask |= 1 << index
    for _ in range(10 * len(ring.generators)):
        # unknowns in a denominator: the equation is multiplied by it
        held = [g for g in ring.used(x) if g.kind == "inverse" and g.depends & _atoms(ring, mask)]
        if not held:
            break
        x = x * held[-1].arguments[0]
        if type(x) is not Polynomial:
            return {} if x == 0 else {(): Ratio(ring, x)}
    groups: dict[Monomial, list[tuple[Any, int]]] = {}
    for monomial, c in ring.terms(ring.promoted(x.num)):
        key = []
        for index, n in monomial:
            if index in places:
                v, power = places[index]
                if n % power:
                    raise ValueError(index)
                key.append((v, n // power))
        rest = tuple(f for f in monomial if f[0] not in places)
        groups.setdefault(tuple(sorted(key)), []).append((rest, c))
    result = {}
    for monomial, terms in groups.items():
        num: Any = 0
        for rest, c in terms:
            term: Any = c
            for index, n in rest:
                term = term * ring.variable(index) ** n
            num = num + term
        result[monomial] = Ratio(ring, num, x.den)
    return result


def _atoms(ring: Any, mask: int) -> int:
    total = 0
    for g in ring.of_mask(mask):
        total |= g.depends
    return total


def added(a: Terms, b: Terms) -> Terms:
    """a + b."""
    result = dict(a)
    for monomial, c in b.items():
        total = result[monomial] + c if monomial in result else c
        if total:
            result[monomial] = total
        else:
            result.pop(monomial, None)
    return result


def scaled(a: Terms, factor: Any) -> Terms:
    """a times a ratio."""
    return {monomial: c * factor for monomial, c in a.items()} if factor else {}


def product(a: Terms, b: Terms) -> Terms:
    """a b."""
    result: Terms = {}
    for p, c in a.items():
        for q, d in b.items():
            powers = dict(p)
            for v, n in q:
                powers[v] = powers.get(v, 0) + n
            result = added(result, {tuple(sorted(powers.items())): c * d})
    return result


def replaced(a: Terms, v: Any, value: Terms) -> Terms:
    """a with a polynomial of the other unknowns in place of one."""
    result: Terms = {}
    for monomial, c in a.items():
        n = dict(monomial).get(v, 0)
        rest = {tuple(f for f in monomial if f[0] != v): c}
        for _ in range(n):
            rest = product(rest, value)
        result = added(result, rest)
    return result


def best_pivot(rows: Iterable[Row], unknowns: Iterable[Any]) -> tuple[Row, Any] | None:
    """The row and unknown that cost least: a short coefficient, then little to put into other rows."""
    rows = list(rows)
    wanted = list(unknowns)
    standing: dict[Any, int] = {}
    for row in rows:
        for v in row.unknowns:
            standing[v] = standing.get(v, 0) + 1
    best, least = None, None
    for i, row in enumerate(rows):
        here = row.unknowns
        for j, v in enumerate(wanted):
            if v not in here:
                continue
            c = row.pivot(v)
            if c is None:
                continue
            fill = (len(row.terms) - 1) * (standing[v] - 1)
            cost = (0 if c.is_number else len(c), fill, sum(map(len, row.terms.values())), j, i)
            if least is None or cost < least:
                best, least = (row, v), cost
    return best


@dataclass(frozen=True)
class Pivot:
    """One step of an elimination: the row used, its unknown, and the monomials left in each row that it changed."""

    row: int
    unknown: Any
    changed: Mapping[int, frozenset[Monomial]]


def eliminate(
    rows: list[Row], groups: Iterable[Iterable[Any]], pivots: list[Pivot] | None = None
) -> tuple[dict[Any, Terms], list[Row]]:
    """Unknowns in terms of those that no row is left for, and the rows left over.

    Parameters
    ----------
    rows : list of Row
    groups : iterable of iterables
        Unknowns; those of an earlier group are taken first.
    pivots : list of Pivot, optional
        Filled with what is done.

    Returns
    -------
    (solved, left)
        ``solved[v]`` is free of all solved unknowns; rows left are not zero.
    """
    place = {id(row): i for i, row in enumerate(rows)}
    pivots = [] if pivots is None else pivots
    solved: dict[Any, Terms] = {}
    left = [row for row in rows if row.terms]
    groups = [list(group) for group in groups]
    found = True
    while found:
        found = False
        for group in groups:
            while (pivot := best_pivot(left, [v for v in group if v not in solved])) is not None:
                row, v = pivot
                found = True
                left.remove(row)
                inverse = -1 / row.terms[((v, 1),)]
                value = scaled({k: c for k, c in row.terms.items() if k != ((v, 1),)}, inverse)
                changed = {}
                for other in left:
                    if v in other.unknowns:
                        other.terms = replaced(other.terms, v, value)
                        changed[place[id(other)]] = frozenset(other.terms)
                pivots.append(Pivot(place[id(row)], v, changed))
                left = [other for other in left if other.terms]
                solved = {w: replaced(terms, v, value) for w, terms in solved.items()}
                solved[v] = value
            if found:
                break
    return solved, left
