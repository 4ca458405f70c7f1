"""Systems of equations in chosen unknowns, whose coefficients are ratios of canonical polynomials.

A row is a polynomial in the unknowns,  Σ c_k Π v_i^n_ik = 0,  with exact c_k. Rows are used one after another: an
unknown that occurs in a row only to the first power and in no product is solved for, and substituted in all other rows
(Gauss-Jordan elimination, if everything is linear). Canonical coefficients make a zero pivot recognisable. The shortest
pivot is taken: 1 before m, and m before m + M.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ...scalar.algebra import Scalar
from ...scalar.element import Polynomial
from ...scalar.ratio import Ratio

Monomial = tuple[tuple[Any, int], ...]
Terms = dict[Monomial, Ratio]
"""Monomials in unknowns (any sortable keys) with their coefficients."""


@dataclass
class Row:
    """One equation ``terms = 0``, with its name and the combination of original rows that it is."""

    name: str
    terms: Terms
    combination: dict[Any, Ratio] = field(default_factory=dict)

    @property
    def unknowns(self) -> set[Any]:
        """Unknowns that occur in the row."""
        return {v for monomial in self.terms for v, _ in monomial}

    def pivot(self, v: Any) -> Ratio | None:
        """Return the coefficient of an unknown in which the row is linear; None if it is not linear."""
        coefficient = None
        for monomial, c in self.terms.items():
            for w, n in monomial:
                if w == v:
                    if n != 1 or len(monomial) != 1:
                        return None
                    coefficient = c
        return coefficient


def collect(x: Scalar, places: Mapping[int, tuple[Any, int]], ring: Any) -> Terms:
    """Return an element as a polynomial in the unknowns.

    Parameters
    ----------
    x : Polynomial, int or Fraction
    places : mapping
        Index of a generator of the ring -> (unknown, power of the generator that equals the unknown).
    ring : Ring

    Raises
    ------
    ValueError
        A generator occurs to a power that is no power of the unknown; the argument is its index.
    """
    if type(x) is not Polynomial:
        return {} if x == 0 else {(): Ratio(ring, x)}
    mask = 0
    for index in places:
        mask |= 1 << index
    for _ in range(10 * len(ring.generators)):
        # multiply the equation by a denominator that contains unknowns
        denominators = [g for g in ring.used(x) if g.kind == "inverse" and g.depends & _atoms(ring, mask)]
        if not denominators:
            break
        x = x * denominators[-1].arguments[0]
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
        cofactor = tuple(f for f in monomial if f[0] not in places)
        groups.setdefault(tuple(sorted(key)), []).append((cofactor, c))
    result = {}
    for monomial, terms in groups.items():
        num: Scalar = 0
        for cofactor, c in terms:
            term: Scalar = c
            for index, n in cofactor:
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
    """Return a + b."""
    result = dict(a)
    for monomial, c in b.items():
        total = result[monomial] + c if monomial in result else c
        if total:
            result[monomial] = total
        else:
            result.pop(monomial, None)
    return result


def scaled(a: Terms, factor: Any) -> Terms:
    """Return a times a ratio."""
    return {monomial: c * factor for monomial, c in a.items()} if factor else {}


def product(a: Terms, b: Terms) -> Terms:
    """Return a b."""
    result: Terms = {}
    for p, c in a.items():
        for q, d in b.items():
            powers = dict(p)
            for v, n in q:
                powers[v] = powers.get(v, 0) + n
            result = added(result, {tuple(sorted(powers.items())): c * d})
    return result


def replaced(a: Terms, v: Any, value: Terms) -> Terms:
    """Return a with the unknown ``v`` replaced by a polynomial in the others."""
    result: Terms = {}
    for monomial, c in a.items():
        n = dict(monomial).get(v, 0)
        term = {tuple(f for f in monomial if f[0] != v): c}
        for _ in range(n):
            term = product(term, value)
        result = added(result, term)
    return result


def best_pivot(rows: Iterable[Row], unknowns: Iterable[Any]) -> tuple[Row, Any] | None:
    """Return the row and unknown of least cost (a short coefficient, then little fill-in), or None."""
    rows = list(rows)
    candidates = list(unknowns)
    occurrences: dict[Any, int] = {}
    for row in rows:
        for v in row.unknowns:
            occurrences[v] = occurrences.get(v, 0) + 1
    best, least = None, None
    for i, row in enumerate(rows):
        row_unknowns = row.unknowns
        for j, v in enumerate(candidates):
            if v not in row_unknowns:
                continue
            c = row.pivot(v)
            if c is None:
                continue
            fill = (len(row.terms) - 1) * (occurrences[v] - 1)
            cost = (0 if c.is_number else len(c), fill, sum(map(len, row.terms.values())), j, i)
            if least is None or cost < least:
                best, least = (row, v), cost
    return best


@dataclass(frozen=True)
class Pivot:
    """One step of an elimination: the row used, its unknown, and the remaining monomials of each changed row."""

    row: int
    unknown: Any
    changed: Mapping[int, frozenset[Monomial]]


def eliminate(
    rows: list[Row], groups: Iterable[Iterable[Any]], pivots: list[Pivot] | None = None
) -> tuple[dict[Any, Terms], list[Row]]:
    """Solve for unknowns in terms of the unknowns for which no row remains.

    Parameters
    ----------
    rows : list of Row
    groups : iterable of iterables
        Unknowns; those of an earlier group are solved for first.
    pivots : list of Pivot, optional
        Filled with the steps.

    Returns
    -------
    (solved, remaining)
        ``solved[v]`` is free of all solved unknowns; the remaining rows are not zero.
    """
    index_of = {id(row): i for i, row in enumerate(rows)}
    pivots = [] if pivots is None else pivots
    solved: dict[Any, Terms] = {}
    remaining = [row for row in rows if row.terms]
    groups = [list(group) for group in groups]
    progress = True
    while progress:
        progress = False
        for group in groups:
            while (pivot := best_pivot(remaining, [v for v in group if v not in solved])) is not None:
                row, v = pivot
                progress = True
                remaining.remove(row)
                inverse = -1 / row.terms[((v, 1),)]
                value = scaled({k: c for k, c in row.terms.items() if k != ((v, 1),)}, inverse)
                changed = {}
                for other in remaining:
                    if v in other.unknowns:
                        other.terms = replaced(other.terms, v, value)
                        changed[index_of[id(other)]] = frozenset(other.terms)
                pivots.append(Pivot(index_of[id(row)], v, changed))
                remaining = [other for other in remaining if other.terms]
                solved = {w: replaced(terms, v, value) for w, terms in solved.items()}
                solved[v] = value
            if progress:
                break
    return solved, remaining
