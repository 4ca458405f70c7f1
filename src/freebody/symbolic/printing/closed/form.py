"""The closed form of an element: the shortest of its fractions, factors and groups of terms.

The canonical form of an element decides what it is; this form only prints it. It is searched for by rules:

- letters with half exponents, so that roots join (`letters`, `products`);
- common factors in front, and the irreducible factors of the rest (FLINT);
- what is irreducible is divided into terms with a common factor and others, in the way with the fewest operations;
- one fraction, or several;
- sin² = 1 - cos², cos² = 1 - sin², or sines and cosines of sums of angles.

Of equal length, the earlier form is printed.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from math import gcd, lcm
from typing import Any

from flint import Ordering, fmpz_mpoly_ctx

from ....scalar.algebra import Scalar
from ....scalar.element import Polynomial
from ....scalar.half_angles import half_angles
from ....scalar.polynomial import Ring
from ..angle_sums import shortest
from ..arrange import arrange
from ..terms import Sum, Term, content_of
from .letters import Letters, Monomial, Terms
from .operations import Operations
from .products import Bracket, Product, Products, negated, positive_first

LONGEST = 40
"""Number of terms beyond which a formula is arranged as an equation is."""
WIDE = 10
"""Number of terms up to which all divisions of a sum are compared; longer sums are divided at the commonest letter."""


def closed_form(x: Scalar, ring: Ring) -> tuple[Sum, Ring] | None:
    """Return the closed form of an element and the ring that it is in; None if it is too long."""
    if type(x) is not Polynomial:
        return None
    key = ("closed form", x, len(ring.positive))
    if key not in ring.cache:
        ring.cache[key] = _closed_form(x, ring)
    result: tuple[Sum, Ring] | None = ring.cache[key]
    return result


def _closed_form(x: Polynomial, ring: Ring) -> tuple[Sum, Ring] | None:
    if len(x) > LONGEST:
        return None
    half = half_angles(x)
    if half is not None:
        if type(half.whole) is not Polynomial or len(half.whole) > LONGEST:
            return None
        return ClosedForms.of(half.ring)(half.whole), half.ring
    return ClosedForms.of(ring)(x), ring


@cache
def _context(n: int) -> Any:
    return fmpz_mpoly_ctx.get(tuple(f"x{i}" for i in range(n)), Ordering.lex)


class ClosedForms:
    """The search for closed forms of elements of one ring."""

    def __init__(self, ring: Ring) -> None:
        self.ring = ring
        self.letters = Letters(ring)
        self.products = Products(self.letters, self, self.factors_of)
        self.operations = Operations(ring)
        self._parts: dict[Any, list[Product]] = {}
        self._costs: dict[int, tuple[Product, Term, int]] = {}

    @staticmethod
    def of(ring: Ring) -> ClosedForms:
        """Return the forms of a ring, which remember what they have formed."""
        forms: ClosedForms = ring.cache.setdefault("closed forms", ClosedForms(ring))
        return forms

    def __call__(self, x: Scalar) -> Sum:
        """Return the form with the fewest operations."""
        if type(x) is not Polynomial:
            return arrange(x, self.ring)
        forms = [self.sum_of(self.parts(terms)) for terms in self._variants(x)]
        plain = arrange(x, self.ring)
        if not any(g.kind == "sqrt" for g in self.ring.used(x)):
            forms.append(plain)
        return min(forms, key=lambda form: self.operations.sum(form).total)

    # ---------------------------------------------------------------- variants
    def _variants(self, x: Polynomial) -> Iterator[Terms]:
        """Return the ways to write an element in letters."""
        raw = self.letters.terms(x)
        yield raw
        single = self._cleared(x)
        if single is not None:
            yield single
        for variant in self._angles(x):
            yield variant

    def _cleared(self, x: Polynomial) -> Terms | None:
        """Return the element over its common denominator."""
        y: Scalar = x
        below: list[tuple[Polynomial, int]] = []
        while type(y) is Polynomial:
            inverses = [
                g for g in self.ring.used(y) if g.kind == "inverse" and len(g.arguments[0]) > 1
            ]
            if not inverses:
                break
            g = inverses[-1]
            n = max(e for m, _ in y.terms() for i, e in m if i == g.index)
            if len(y) * len(g.arguments[0]) ** n > 10 * LONGEST:
                return None
            y = y * g.arguments[0] ** n
            below.append((g, n))
        if not below:
            return None
        entries = self.letters.collected(
            (Fraction(c, y.den), (*m, *((g.index, n) for g, n in below)))
            for m, c in self.ring.coerce(y).terms()
        ) if type(y) is Polynomial else self.letters.collected(
            [(Fraction(y), [(g.index, n) for g, n in below])]
        )
        return entries

    def _angles(self, x: Polynomial) -> Iterator[Terms]:
        """Return the element with sines instead of cosines squared, and with sums of angles."""
        rows: dict[Any, dict[Any, int]] = {}
        arrangement = self.letters.arrangement
        used = self.ring.used(x)
        if not any(g.kind in ("sin", "cos") for g in used):
            return
        for monomial, c in x.terms():
            other = tuple(f for f in monomial if arrangement.class_of(f[0]) == 2)
            rest = tuple(f for f in monomial if arrangement.class_of(f[0]) != 2)
            rows.setdefault(other, {})[rest] = c
        coefficient, power = shortest(self.ring, rows, arrangement.rank)
        if coefficient is not rows:
            yield self._joined(coefficient, x.den * power)
        for g in used:
            if g.kind == "sin" or g.kind == "cos" and self.ring.generators[g.partner] not in used:
                cosine = g.index if g.kind == "cos" else g.partner
                sine = self.ring.generators[cosine].partner
                for replaced, by in ((sine, cosine), (cosine, sine)):
                    variant = self._without_squares(rows, replaced, by)
                    if variant is not None:
                        yield self._joined(variant, x.den)

    def _joined(self, coefficient: dict[Any, dict[Any, int]], den: int) -> Terms:
        return self.letters.collected(
            (Fraction(c, den), (*rest, *other)) for other, row in coefficient.items() for rest, c in row.items()
        )

    @staticmethod
    def _without_squares(
        rows: dict[Any, dict[Any, int]], replaced: int, by: int
    ) -> dict[Any, dict[Any, int]] | None:
        """Return the rows with 1 - by² for replaced²; None if no square occurs."""
        result: dict[Any, dict[Any, int]] = {}
        changed = False
        for other, row in rows.items():
            powers = dict(other)
            n = powers.get(replaced, 0) // 2 if powers.get(replaced, 0) > 0 else 0
            changed = changed or n > 0
            choose = 1
            for k in range(n + 1):
                new = dict(powers)
                new[replaced] = powers.get(replaced, 0) - 2 * n
                new[by] = powers.get(by, 0) + 2 * k
                key = tuple(sorted(((i, e) for i, e in new.items() if e), reverse=True))
                for rest, c in row.items():
                    table = result.setdefault(key, {})
                    table[rest] = table.get(rest, 0) + c * choose * (-1) ** k
                choose = choose * (n - k) // (k + 1)
        if not changed:
            return None
        return {k: kept for k, row in result.items() if (kept := {r: c for r, c in row.items() if c})}

    # ---------------------------------------------------------------- sums
    def sum_of(self, parts: list[Product]) -> Sum:
        """Return products as a sum in printing order."""
        return positive_first(Sum([self.term(p) for p in parts]))

    def term(self, p: Product) -> Term:
        """Return a product as a term."""
        return self._cost(p)[1]

    def _cost(self, p: Product) -> tuple[Product, Term, int]:
        if id(p) not in self._costs:
            term = self.products.term(p, lambda t: self.operations.sum(Sum([t])).total)
            self._costs[id(p)] = (p, term, self.operations.sum(Sum([term])).total)
        return self._costs[id(p)]

    def cost(self, parts: list[Product]) -> int:
        """Return the number of operations of a sum of products."""
        rows = [self._cost(p) for p in parts]
        signs = [t.coefficient < 0 for _, t, _ in rows]
        return sum(n for _, _, n in rows) - sum(signs) + len(rows) - 1 + all(signs)

    def parts(self, terms: Terms) -> list[Product]:
        """Return the products, in printing order, whose sum has the fewest operations."""
        key = frozenset(terms.items())
        if key not in self._parts:
            self._parts[key] = min(self._divisions(terms), key=self.cost)
        return self._parts[key]

    def _divisions(self, terms: Terms) -> Iterator[list[Product]]:
        """Return ways to write a sum as products."""
        entries = sorted(terms.items(), key=lambda t: self.letters.order(t[0]))
        if len(entries) <= 1:
            yield [Product(c, dict(m)) for m, c in entries]
            return
        for whole in self.factored(terms):
            yield [whole]
        yield [Product(c, dict(m)) for m, c in entries]
        if len(entries) < 3:
            return
        for group in self._groups(entries):
            inside = {m: c for m, c in entries if m in group}
            outside = {m: c for m, c in entries if m not in group}
            for whole in self.factored(inside):
                rest = self.parts(outside)
                first = self.letters.order(entries[0][0]) if entries[0][0] in group else None
                yield [whole, *rest] if first is not None else [*rest, whole]

    def _groups(self, entries: list[tuple[Monomial, Fraction]]) -> list[frozenset[Monomial]]:
        """Return the groups of terms with a common letter, largest first."""
        table: dict[tuple[int, bool], set[Monomial]] = {}
        for m, _ in entries:
            for letter, e in m:
                table.setdefault((letter, e > 0), set()).add(m)
        groups = {frozenset(g) for g in table.values() if 2 <= len(g) < len(entries)}
        place = {m: i for i, (m, _) in enumerate(entries)}
        ordered = sorted(groups, key=lambda g: (-len(g), sorted(place[m] for m in g)))
        return ordered if len(entries) <= WIDE else ordered[: 3 if len(entries) <= 2 * WIDE else 1]

    # ---------------------------------------------------------------- products
    def factors_of(self, x: Scalar) -> Product:
        """Return an element as a product: the shortest of its forms with one term, or a bracket."""
        if type(x) is not Polynomial:
            return Product(Fraction(x), {})
        best = min((self.parts(terms) for terms in self._variants(x)), key=self.cost)
        return self._bracket(best, self.letters.terms(x))

    @staticmethod
    def _used(terms: Terms) -> frozenset[int]:
        return frozenset(k for m in terms for k, _ in m)

    def factored(self, terms: Terms) -> Iterator[Product]:
        """Return forms of a sum as one product: content and common letters in front of brackets."""
        if len(terms) == 1:
            ((m, c),) = terms.items()
            yield Product(c, dict(m))
            return
        common = _common(list(terms))
        inner = {_over(m, common): c for m, c in terms.items()}
        seen = []
        for content in _contents(list(inner.values())):
            scaled = {m: c / content for m, c in inner.items()}
            if common or content != 1:
                yield self._bracketed(content, common, scaled)
            seen.append(content)
        shift, factors = self._irreducible(inner)
        if sum(e for _, _, e in factors) > 1 or shift:
            yield self._multiplied(inner, common, shift, factors)

    def _bracketed(self, content: Fraction, common: dict[int, int], inner: Terms) -> Product:
        return Product(content, dict(common)).times(self._as_factor(inner))

    def _as_factor(self, terms: Terms) -> Product:
        """Return a sum as a product or a bracket, whose first term is positive."""
        return self._bracket(self.parts(terms), terms)

    def _bracket(self, parts: list[Product], terms: Terms) -> Product:
        if len(parts) == 1:
            return parts[0]
        total = Sum([self.term(p) for p in parts])
        sign = 1
        if total.terms[0].coefficient < 0:
            total, sign = negated(total), -1
        return Product(Fraction(sign), {}, [(Bracket(total, self._used(terms)), 1)])

    def _multiplied(
        self, inner: Terms, common: dict[int, int], shift: dict[int, int], factors: list[tuple[Terms, Fraction, int]]
    ) -> Product:
        powers = dict(common)
        for k, e in shift.items():
            powers[k] = powers.get(k, 0) + e
        total = Product(Fraction(1), {k: e for k, e in powers.items() if e})
        for factor, content, e in factors:
            total = total.times(self._as_factor(factor), 2 * e)
            total.coefficient *= content
        return total

    def _irreducible(self, inner: Terms) -> tuple[dict[int, int], list[tuple[Terms, Fraction, int]]]:
        """Return (powers in front, [(factor, content, exponent)]): the factors of a sum over its common denominator."""
        letters = sorted({k for m in inner for k, _ in m})
        place = {k: i for i, k in enumerate(letters)}
        unit = {k: 1 if any(e % 2 for m in inner for j, e in m if j == k) else 2 for k in letters}
        low = {k: min(dict(m).get(k, 0) for m in inner) for k in letters}
        den = lcm(*(c.denominator for c in inner.values()))
        table = {}
        for m, c in inner.items():
            exponents = [-low[k] // unit[k] for k in letters]
            for k, e in m:
                exponents[place[k]] = (e - low[k]) // unit[k]
            table[tuple(exponents)] = int(c * den)
        content, factors = _context(len(letters)).from_dict(table).factor()
        result = []
        number = Fraction(int(content), den)
        for p, e in factors:
            terms = {
                tuple((k, int(n) * unit[k]) for k, n in zip(letters, m, strict=True) if n): Fraction(int(c))
                for m, c in p.to_dict().items()
            }
            result.append((terms, number, int(e)))
            number = Fraction(1)
        return {k: e for k, e in low.items() if e}, result


def _common(monomials: list[Monomial]) -> dict[int, int]:
    """Return the common powers of monomials; negative powers have negative common powers."""
    rows = [dict(m) for m in monomials]
    result = {}
    for k, e in rows[0].items():
        others = [row.get(k, 0) for row in rows]
        if all(n > 0 for n in others):
            result[k] = min(others)
        elif all(n < 0 for n in others):
            result[k] = max(others)
    return result


def _over(monomial: Monomial, common: dict[int, int]) -> Monomial:
    return tuple((k, n) for k, e in monomial if (n := e - common.get(k, 0)))


def _contents(values: list[Fraction]) -> list[Fraction]:
    """Return numbers to take out of a bracket: the greatest common divisor, that of the numerators, and 1."""
    numerator = gcd(*(v.numerator for v in values)) or 1
    denominator = lcm(*(v.denominator for v in values))
    numbers = [content_of(values), Fraction(numerator, denominator), Fraction(numerator), Fraction(1, denominator)]
    result = list(dict.fromkeys([*numbers, Fraction(1)]))
    if all(v < 0 for v in values):
        result = [-c for c in result]
    return result
