"""The closed form of an element: the shortest of its fractions, factors and groups of terms.

The canonical form of an element decides what it is; this form only prints it. It is searched for by rules:

- letters with half exponents, so that roots join (`letters`, `products`);
- common factors in front, and the irreducible factors of the rest (FLINT);
- what is irreducible is divided into terms with a common factor and others, in the way with the fewest operations;
- one fraction, or several;
- sin² = 1 - cos², cos² = 1 - sin², or sines and cosines of sums of angles.

Of equal length, the earlier form is printed. The file is longer than others: sums and products call each other.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from itertools import combinations
from math import gcd, isqrt, lcm
from typing import Any

from flint import Ordering, fmpz_mpoly_ctx

from ....scalar.algebra import Scalar
from ....scalar.element import Polynomial
from ....scalar.half_angles import half_angles
from ....scalar.polynomial import Ring
from ....scalar.roots import is_positive
from ..angle_sums import shortest
from ..arrange import arrange, over_sums
from ..terms import Sum, Term
from .letters import Letters, Monomial, Terms
from .operations import Operations
from .products import Bracket, Product, Products, is_negative, positive_first, settled

LONGEST = 40
"""Number of terms beyond which a formula is arranged as an equation is."""
WIDE = 10
"""Number of terms up to which all divisions of a sum are compared; longer sums are divided at the commonest letters."""
SUMS = 100
"""Number of sums in one formula whose divisions are compared; further sums are divided at the commonest letter."""


def closed_form(x: Scalar, ring: Ring, below: Scalar = 1) -> tuple[Sum, Ring] | None:
    """Return the closed form of ``x / below`` and the ring that it is in; None if it is a number or too long."""
    if type(x) is not Polynomial and type(below) is not Polynomial:
        return None
    key = ("closed form", x, below, len(ring.positive))
    if key not in ring.cache:
        ring.cache[key] = _closed_form(x, below, ring)
    result: tuple[Sum, Ring] | None = ring.cache[key]
    return result


def _closed_form(x: Scalar, below: Scalar, ring: Ring) -> tuple[Sum, Ring] | None:
    if not _is_short(x, below):
        return None
    half = half_angles(x, below)
    if half is None:
        return ClosedForms.of(ring).form(x, below), ring
    if not _is_short(half.top, half.below):
        return None
    return ClosedForms.of(half.ring).form(half.whole), half.ring


def _is_short(*elements: Scalar) -> bool:
    return all(type(x) is not Polynomial or len(x) <= LONGEST for x in elements)


@cache
def _context(n: int) -> Any:
    return fmpz_mpoly_ctx.get(tuple(f"x{i}" for i in range(n)), Ordering.lex)


class ClosedForms:
    """The search for closed forms of elements of one ring."""

    def __init__(self, ring: Ring) -> None:
        self.ring = ring
        self.letters = Letters(ring)
        self.products = Products(self.letters, self._shortest, self.factors_of)
        self.operations = Operations(ring)
        self.budget = SUMS
        self._forms: dict[tuple[Scalar, Scalar], Sum] = {}
        self._factors: dict[Scalar, Product] = {}
        self._parts: dict[Any, list[Product]] = {}
        self._costs: dict[int, tuple[Product, Term, int]] = {}

    @staticmethod
    def of(ring: Ring) -> ClosedForms:
        """Return the forms of a ring, which remember what they have formed."""
        forms: ClosedForms = ring.cache.setdefault("closed forms", ClosedForms(ring))
        return forms

    def form(self, x: Scalar, below: Scalar = 1) -> Sum:
        """Return the form of ``x / below`` with the fewest operations that a bounded search finds."""
        self.budget = SUMS
        return self._shortest(x, below)

    def _shortest(self, x: Scalar, below: Scalar = 1) -> Sum:
        """Return the form with the fewest operations, within what is left of the budget: arguments share it.

        An argument that occurs in many divisions of a sum is formed once.
        """
        if (x, below) not in self._forms:
            self._forms[x, below] = self._formed(x, below)
        return self._forms[x, below]

    def _formed(self, x: Scalar, below: Scalar) -> Sum:
        if type(below) is Polynomial:
            return min(
                map(self.sum_of, self._fractions(x, below)), key=lambda form: self.operations.sum(form).total
            )
        if type(x) is not Polynomial or below != 1:
            return arrange(x / Fraction(below), self.ring)
        forms = [self.sum_of(self.parts(terms)) for terms in self._variants(x)]
        if not any(g.kind == "sqrt" or self._turns(g) for g in self.ring.used(x)):
            forms.append(arrange(x, self.ring))
        return min(forms, key=lambda form: self.operations.sum(form).total)

    def _turns(self, g: Any) -> bool:
        """Return True for 1/x where -x is known to be positive: an arrangement would print x."""
        return g.kind == "inverse" and is_positive(self.ring, -self.ring.promoted(g.arguments[0].num))

    def _fractions(self, x: Scalar, below: Polynomial) -> Iterator[list[Product]]:
        """Return ``x / below`` as a fraction, and over a single term also as a sum of fractions."""
        p, q = self.factors_of(x), self.factors_of(below)
        whole = Product(p.coefficient / q.coefficient, p.powers, p.brackets)
        yield [whole.times(Product(Fraction(1), q.powers, q.brackets), -2)]
        single = self.letters.terms(below)
        if len(single) == 1 and type(x) is Polynomial:
            ((m, c),) = single.items()
            inverse = tuple((k, -e) for k, e in m)
            yield self.parts({_product(n, inverse): d / c for n, d in self.letters.terms(x).items()})

    # ---------------------------------------------------------------- variants
    def _variants(self, x: Polynomial) -> Iterator[Terms]:
        """Return the ways to write an element in letters."""
        raw = self.letters.terms(x)
        single = self._cleared(x)
        if single is not None:
            yield single
        yield raw
        yield from self._with_denominators(raw)
        yield from self._angles(x)

    def _with_denominators(self, terms: Terms) -> Iterator[Terms]:
        """Return the terms with the sum D of a denominator in place of one of its squares: R² = D - 4 L²."""
        below = {k for m in terms for k, e in m if e < 0 and self.letters.kind(k) == "polynomial"}
        for letter in sorted(below):
            sum_ = self.letters.terms(self.letters.bases[letter])
            for m, c in sum_.items():
                if len(m) == 1 and m[0][1] >= 2:
                    rest = {n: -d / c for n, d in sum_.items() if n != m} | {((letter, 2),): 1 / c}
                    changed = _replaced(terms, m[0], rest)
                    if changed is not None:
                        yield changed

    def _cleared(self, x: Polynomial) -> Terms | None:
        """Return the element over its common denominator."""
        cleared = over_sums(x, self.ring, 10 * LONGEST)
        if cleared is None or not cleared[1]:
            return None
        y, below = cleared
        over = [(g.index, n) for g, n in below]
        if type(y) is not Polynomial:
            return self.letters.collected([(Fraction(y), over)])
        return self.letters.collected((Fraction(c, y.den), (*m, *over)) for m, c in y.terms())

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
            (Fraction(c, den), (*rest, *other))
            for other, row in coefficient.items()
            for rest, c in row.items()
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
            self._costs[id(p)] = (p, *self.products.term(p, lambda t: self.operations.sum(Sum([t])).total))
        return self._costs[id(p)]

    def cost(self, parts: list[Product]) -> int:
        """Return the number of operations of a sum of products."""
        rows = [self._cost(p) for p in parts]
        signs = [t.coefficient < 0 for _, t, _ in rows]
        length = sum(n for _, _, n in rows) + 2 * (len(rows) - 1 - sum(signs))
        return length + 2 * (all(signs) and is_negative(positive_first(Sum([t for _, t, _ in rows]))))

    def parts(self, terms: Terms) -> list[Product]:
        """Return the products, in printing order, whose sum has the fewest operations."""
        key = frozenset(terms.items())
        if key not in self._parts:
            self.budget -= len(terms) > 2
            divisions = list(self._divisions(terms))
            self._parts[key] = divisions[0] if len(divisions) == 1 else min(divisions, key=self.cost)
        return self._parts[key]

    def _divisions(self, terms: Terms) -> Iterator[list[Product]]:
        """Return ways to write a sum as products."""
        entries = sorted(terms.items(), key=lambda t: self.letters.order(t[0]))
        if len(entries) <= 1:
            yield [Product(c, dict(m)) for m, c in entries]
            return
        for whole in self.factored(terms):
            yield [whole]
            if self.budget < 0:
                return
        yield [Product(c, dict(m)) for m, c in entries]
        if len(entries) < 3:
            return
        yield from self._squares(terms)
        for n, group in enumerate(self._groups(entries)):
            if n and self.budget < 0:
                break
            inside = {m: c for m, c in entries if m in group}
            outside = {m: c for m, c in entries if m not in group}
            for whole in self.factored(inside):
                rest = self.parts(outside)
                first = self.letters.order(entries[0][0]) if entries[0][0] in group else None
                yield [whole, *rest] if first is not None else [*rest, whole]
                if self.budget < 0:
                    break

    def _squares(self, terms: Terms) -> Iterator[list[Product]]:
        """Return forms with a square completed: a² - 2ab + b² + c = (a - b)² + c."""
        roots = {m: r for m, c in terms.items() if c > 0 and (r := _root(m, c)) is not None}
        for (m, (a, p)), (n, (b, q)) in combinations(roots.items(), 2):
            if self.budget < 0:
                return
            cross = _product(p, q)
            if cross not in terms or abs(terms[cross]) != 2 * a * b:
                continue
            rest = {k: c for k, c in terms.items() if k not in (m, n, cross)}
            inner = {p: a, q: b if terms[cross] > 0 else -b}
            yield [
                Product(Fraction(1), {}).times(self._as_factor(inner), 4),
                *(self.parts(rest) if rest else []),
            ]

    def _groups(self, entries: list[tuple[Monomial, Fraction]]) -> list[frozenset[Monomial]]:
        """Return the groups of terms with a common letter, largest first."""
        table: dict[tuple[int, bool], set[Monomial]] = {}
        for m, _ in entries:
            for letter, e in m:
                table.setdefault((letter, e > 0), set()).add(m)
        groups = {frozenset(g) for g in table.values() if 2 <= len(g) < len(entries)}
        place = {m: i for i, (m, _) in enumerate(entries)}
        ordered = sorted(groups, key=lambda g: (-len(g), sorted(place[m] for m in g)))
        return ordered if len(entries) <= WIDE else ordered[:3]

    # ---------------------------------------------------------------- products
    def factors_of(self, x: Scalar) -> Product:
        """Return an element as a product: the shortest of its forms with one term, or a bracket."""
        if x not in self._factors:
            self._factors[x] = self._factored(x)
        return self._factors[x]

    def _factored(self, x: Scalar) -> Product:
        if type(x) is not Polynomial:
            return Product(Fraction(x), {})
        positive = is_positive(self.ring, self.ring.promoted(x.num))
        if not positive and is_positive(self.ring, -self.ring.promoted(x.num)):
            return Product(Fraction(-1), {}).times(self.factors_of(-x))
        best = min((self.parts(terms) for terms in self._variants(x)), key=self.cost)
        if positive and len(best) > 1:
            total = positive_first(Sum([self.term(p) for p in best], fixed=True))
            return Product(Fraction(1), {}, [(Bracket(total, self._used(self.letters.terms(x))), 1)])
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
        total, sign = settled(Sum([self.term(p) for p in parts]))
        return Product(Fraction(sign), {}, [(Bracket(total, self._used(terms)), 1)])

    def _multiplied(
        self,
        inner: Terms,
        common: dict[int, int],
        shift: dict[int, int],
        factors: list[tuple[Terms, Fraction, int]],
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


def _root(monomial: Monomial, c: Fraction) -> tuple[Fraction, Monomial] | None:
    """Return the root of a term that is a square."""
    p, q = isqrt(c.numerator), isqrt(c.denominator)
    if not monomial or p * p != c.numerator or q * q != c.denominator or any(e % 4 for _, e in monomial):
        return None
    return Fraction(p, q), tuple((k, e // 2) for k, e in monomial)


def _product(a: Monomial, b: Monomial) -> Monomial:
    powers = dict(a)
    for k, e in b:
        powers[k] = powers.get(k, 0) + e
    return tuple(sorted((k, e) for k, e in powers.items() if e))


def _replaced(terms: Terms, power: tuple[int, int], by: Terms) -> Terms | None:
    """Return terms with a sum in place of a power of a letter; None if it does not occur, or if there are too many."""
    letter, e = power
    changed = False
    for _ in range(2 * LONGEST):
        row = next((m for m in terms if dict(m).get(letter, 0) >= e), None)
        if row is None:
            return terms if changed else None
        changed = True
        terms = dict(terms)
        c = terms.pop(row)
        cofactor = _over(row, {letter: e})
        for m, d in by.items():
            key = _product(cofactor, m)
            total = terms.get(key, Fraction(0)) + c * d
            if total:
                terms[key] = total
            else:
                del terms[key]
        if len(terms) > LONGEST:
            return None
    return None


def _common(monomials: list[Monomial]) -> dict[int, int]:
    """Return the common powers of monomials; negative powers have negative common powers."""
    rows = [dict(m) for m in monomials]
    result = {}
    for k in rows[0]:
        others = [row.get(k, 0) for row in rows]
        if all(n > 0 for n in others):
            result[k] = min(others)
        elif all(n < 0 for n in others):
            result[k] = max(others)
    return result


def _over(monomial: Monomial, common: dict[int, int]) -> Monomial:
    return tuple((k, n) for k, e in monomial if (n := e - common.get(k, 0)))


def _contents(values: list[Fraction]) -> list[Fraction]:
    """Return numbers to take out of a bracket: the common divisor of the numerators, and that of the numbers."""
    numerator = gcd(*(v.numerator for v in values)) or 1
    denominator = lcm(*(v.denominator for v in values))
    result = list(dict.fromkeys([Fraction(numerator), Fraction(numerator, denominator)]))
    if all(v < 0 for v in values):
        result = [-c for c in result]
    return result
