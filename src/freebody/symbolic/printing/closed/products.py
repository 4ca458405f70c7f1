"""A product of letters and brackets as a term: roots joined, absolute values joined, one sign.

    a^(1/2) b^(-1/2) = sqrt(a/b),    |a|·|b| = |a b|,    |a|/a² = 1/|a|,    sin x cos x = sin(2x)/2

Roots join where at most one radicand of each side of the fraction is not known to be positive: sqrt(a) sqrt(b) =
sqrt(a b) holds for real roots.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product
from math import isqrt
from typing import Any

from ..terms import Applied, Sum, Term
from .letters import Letters

ODD = ("asin", "atan", "sinh", "tanh")
"""Functions that change their sign with their argument."""


@dataclass
class Bracket:
    """A sum as a factor.

    Attributes
    ----------
    sum : Sum
    letters : frozenset of int
        The letters in it.
    """

    sum: Sum
    letters: frozenset[int]


@dataclass
class Product:
    """coefficient · Π letter^(e/2) · Π bracketⁿ."""

    coefficient: Fraction
    powers: dict[int, int]
    brackets: list[tuple[Bracket, int]] = field(default_factory=list)

    def times(self, other: Product, twice: int = 2) -> Product:
        """Return self · other^(twice/2); ``twice`` is even if the other has brackets or a coefficient."""
        powers = dict(self.powers)
        for k, e in other.powers.items():
            powers[k] = powers.get(k, 0) + e * twice // 2
        n = twice // 2
        brackets = self.brackets + [(b, e * n) for b, e in other.brackets]
        return Product(
            self.coefficient * other.coefficient**n, {k: e for k, e in powers.items() if e}, brackets
        )


class Products:
    """The rules for terms of closed forms of one ring.

    ``argument`` returns the form of an element that is an argument of a function, ``factors`` its product.
    """

    def __init__(
        self, letters: Letters, argument: Callable[[Any], Sum], factors: Callable[[Any], Product]
    ) -> None:
        self.letters = letters
        self.argument = argument
        self.factors = factors

    def term(self, p: Product, length: Callable[[Term], int]) -> tuple[Term, int]:
        """Return the shorter of the forms of a product as a term, and its length."""
        terms = [self._term(p, joined, doubled) for doubled, joined in self._ways(p)]
        return min(((t, length(t)) for t in terms), key=lambda row: row[1])

    def _ways(self, p: Product) -> list[tuple[bool, bool]]:
        kinds = [(self.letters.kind(k), e) for k, e in p.powers.items()]
        roots = any(e % 2 and kind != "number" for kind, e in kinds)
        doubles = sum(kind in ("sin", "cos") and e > 0 for kind, e in kinds) > 1
        return list(product((False, True) if doubles else (True,), (True, False) if roots else (True,)))

    def _term(self, p: Product, joined: bool = True, doubled: bool = True) -> Term:
        """Return a product as a term.

        ``joined`` brings its number under the root, ``doubled`` writes sin(2x)/2 for sin x cos x.
        """
        letters = self.letters
        powers = dict(p.powers)
        number = 1
        for k in [k for k in powers if letters.kind(k) == "number"]:
            number *= letters.bases[k][1] ** powers.pop(k)  # twice the exponent: the square
        coefficient = p.coefficient
        roots = {k: e for k, e in powers.items() if e % 2}
        factors: list[tuple[Any, int, Any]] = []
        square = coefficient**2 * number  # of the coefficient
        sign = -1 if coefficient < 0 else 1
        if not roots:
            coefficient, whole = rooted(square)
            if whole != 1:
                factors.append((Applied("sqrt", [Sum([Term(whole, [])])]), 1, (0,)))
        else:
            outside, inside = _split_root(square) if joined else (Fraction(1), Fraction(square))
            if not joined:
                plain, whole = rooted(square)
                outside, inside = plain, Fraction(whole)
            coefficient = outside
            for radicand, e in self._roots(roots, inside):
                factors.append((Applied("sqrt", [self._root(radicand)]), e, (2,)))
            for k, e in roots.items():
                powers[k] = (e - (1 if e > 0 else -1)) // 2 * 2
        coefficient *= sign
        self._absolute(powers)
        coefficient *= self._double_angles(powers, factors, doubled)
        coefficient *= self._letters(powers, factors, coefficient)
        brackets = [(b.sum, e, b.letters) for b, e in p.brackets]
        for k, e in powers.items():  # polynomials
            if e and letters.kind(k) == "polynomial":
                inner = self.factors(letters.bases[k])
                nested = self._term(inner)
                coefficient *= Fraction(nested.coefficient) ** (e // 2)
                for node, n in nested.factors:
                    if isinstance(node, Sum):
                        brackets.append((node, n * e // 2, frozenset([k])))
                    else:
                        factors.append((node, n * e // 2, (3, letters.rank(k))))
        return Term(_plain(coefficient), self._ordered(factors, brackets))

    # ---------------------------------------------------------------- roots
    def _roots(self, roots: dict[int, int], inside: Fraction) -> list[tuple[Product, int]]:
        """Return the radicands and exponents of one root, or of roots above and below the bar."""
        unknown = [k for k in roots if not self.letters.positive(k)]
        over = {k: 2 for k, e in roots.items() if e > 0}
        under = {k: 2 for k, e in roots.items() if e < 0}
        p, q = inside.numerator, inside.denominator
        if len(unknown) <= 1 and (over or p != 1):
            return [(Product(inside, over | {k: -2 for k in under}), 1)]
        result = []
        for powers, number, e in ((over, p, 1), (under, q, -1)):
            for k in [k for k in unknown if k in powers][1:]:  # sqrt(a) sqrt(b), where both may be negative
                result.append((Product(Fraction(1), {k: powers.pop(k)}), e))
            if powers or number != 1:
                result.append((Product(Fraction(number), powers), e))
        return result

    def _root(self, p: Product) -> Sum:
        """Return a radicand as a sum, with the factors of its polynomials."""
        total = Product(p.coefficient, {})
        for k, e in p.powers.items():
            base = self.letters.bases[k]
            factor = (
                self.factors(base) if self.letters.kind(k) == "polynomial" else Product(Fraction(1), {k: 2})
            )
            total = total.times(factor, e)
        return positive_first(Sum([self._term(total)]))

    # ---------------------------------------------------------------- functions
    def _absolute(self, powers: dict[int, int]) -> None:
        """Replace |a|/a² by 1/|a|."""
        letters = self.letters
        for k in list(powers):
            base = letters.bases[k]
            if isinstance(base, int) and letters.ring.generators[base].name == "abs":
                inside = letters.terms(letters.ring.generators[base].arguments[0])
                if len(inside) == 1:
                    ((monomial, c),) = inside.items()
                    if c == 1 and len(monomial) == 1 and monomial[0][1] == 2:
                        self._reciprocal(powers, k, monomial[0][0])
                        continue
                self._reciprocal(powers, k, letters.number(letters.ring.generators[base].arguments[0]))

    @staticmethod
    def _reciprocal(powers: dict[int, int], absolute: int, inside: int) -> None:
        while powers.get(inside, 0) <= -4 and powers[absolute] > -2:
            powers[inside] += 4
            powers[absolute] -= 4

    def _double_angles(
        self, powers: dict[int, int], factors: list[tuple[Any, int, Any]], doubled: bool
    ) -> Fraction:
        """Replace sin x/cos x by tan x, and sin x cos x by sin(2x)/2; return the number."""
        letters, result = self.letters, Fraction(1)
        for k, e in list(powers.items()):
            base = letters.bases[k]
            if not e or letters.kind(k) != "sin" or not isinstance(base, int):
                continue
            partner = letters.ring.generators[base].partner
            cosine = letters.number(partner)
            if e and powers.get(cosine) == -e:
                factors.append((("tan", ((partner, 1),)), e // 2, (6, letters.rank(k))))
                powers[k] = powers[cosine] = 0
            elif doubled and e > 0 and powers.get(cosine) == e:
                result /= 2 ** (e // 2)
                factors.append((("sin", ((partner, 2),)), e // 2, (6, letters.rank(k))))
                powers[k] = powers[cosine] = 0
        return result

    def _letters(
        self, powers: dict[int, int], factors: list[tuple[Any, int, Any]], outer: Fraction
    ) -> Fraction:
        """Add the factors that are letters; return the sign of functions with a negative argument."""
        letters, sign = self.letters, Fraction(1)
        inside: dict[int, list[Any]] = {1: [], -1: []}
        for k, e in powers.items():
            kind = letters.kind(k)
            if not e or kind == "polynomial":
                continue
            base = letters.bases[k]
            place: Any = (self._place(k), letters.rank(k))
            if kind == "sqrt" or not isinstance(base, tuple) and not letters.ring.generators[base].depends:
                place = (0,)  # roots of numbers, and pi
            if isinstance(base, tuple):
                factors.append((base, e // 2, place))
                continue
            g = letters.ring.generators[base]
            if g.name == "abs" and e in (2, -2):
                inside[e // 2].append((g, place))
            elif kind == "function" and len(g.arguments) <= 2 and g.name not in ("exp", "pow", "abs"):
                arguments = [self.argument(a) for a in g.arguments]
                if g.name in ODD and (is_negative(arguments[0]) or outer < 0 and _flips(arguments[0])):
                    arguments = [negated(arguments[0])]
                    sign *= (-1) ** (e // 2)
                factors.append((Applied(g.name, arguments), e // 2, place))
            else:
                factors.append((base, e // 2, place))
        sign *= self._absolutes(inside, factors)
        return sign

    def _absolutes(self, inside: dict[int, list[Any]], factors: list[tuple[Any, int, Any]]) -> Fraction:
        """Add |a b| for |a|·|b|, and |a/b| for |a|/|b|; return the number that leaves."""
        entries = [(g, place, e) for e, row in inside.items() for g, place in row]
        if not entries:
            return Fraction(1)
        total = Product(Fraction(1), {})
        for g, _, e in entries:
            total = total.times(self.factors(g.arguments[0]), 2 * e)
        below = not inside[1]
        if below:
            total = Product(Fraction(1), {}).times(total, -2)
        term = self._term(total)
        number = abs(Fraction(term.coefficient))
        term.coefficient = 1
        factors.append((Applied("abs", [Sum([term])]), -1 if below else 1, max(p for _, p, _ in entries)))
        return 1 / number if below else number

    def _place(self, letter: int) -> int:
        kind = self.letters.kind(letter)
        number = self.letters.class_of(letter)
        if number == 1:
            return 1
        return 4 if number == 0 else 3 if kind in ("coordinate", "time", "quaternion") else 6

    # ---------------------------------------------------------------- order
    def _ordered(
        self, factors: list[tuple[Any, int, Any]], brackets: list[tuple[Sum, int, frozenset[int]]]
    ) -> list[tuple[Any, int]]:
        """Return the factors in printing order: roots of numbers, parameters, coordinates, rates, functions."""
        letters = self.letters
        rows = [(*_padded(place), i, node, e) for i, (node, e, place) in enumerate(factors)]
        ranks = [place[1] for _, _, place in factors if place[0] == 1]
        for i, (s, e, inside) in enumerate(brackets):
            if all(letters.class_of(k) == 1 for k in inside):
                first = all(r < min(letters.rank(k) for k in inside) for r in ranks)
                place = (1, (10**9,)) if first else (1, (-2,))
            else:
                place = (7 if any(letters.class_of(k) == 0 for k in inside) else 5, (0,))
            rows.append((*place, len(factors) + i, s, e))
        rows.sort(key=lambda r: r[:3])
        return [(node, e) for *_, node, e in rows]


def _padded(place: Any) -> tuple[int, tuple[int, ...]]:
    return place if len(place) == 2 else (place[0], ())


def _plain(x: Fraction) -> int | Fraction:
    return x.numerator if x.denominator == 1 else x


def _square_part(n: int) -> tuple[int, int]:
    """Return (k, f) with n = k² f and f free of squares."""
    k, f, d = 1, 1, 2
    while d * d <= n:
        e = 0
        while n % d == 0:
            n //= d
            e += 1
        k *= d ** (e // 2)
        f *= d ** (e % 2)
        d += 1
        if d > 1000:  # a large prime factor stays under the root, unless the rest is a square
            r = isqrt(n)
            return (k * r, f) if r * r == n else (k, f * n)
    return k, f * n


def rooted(square: Fraction) -> tuple[Fraction, int]:
    """Return (c, n) with c sqrt(n) the positive root: no root in a denominator.

    >>> rooted(Fraction(9, 8))
    (Fraction(3, 4), 2)
    """
    k, f = _square_part(square.numerator * square.denominator)
    return Fraction(k, square.denominator), f


def _split_root(square: Fraction) -> tuple[Fraction, Fraction]:
    """Return (c, f) with c sqrt(f) the positive root, numerator and denominator of f free of squares."""
    k, f = _square_part(square.numerator)
    n, g = _square_part(square.denominator)
    return Fraction(k, n), Fraction(f, g)


def is_negative(s: Sum) -> bool:
    """Return True if all terms of a sum are negative."""
    return bool(s.terms) and all(t.coefficient < 0 for t in s.terms)


def opposite(t: Term) -> Term:
    """Return -t; a bracket above the bar takes the minus if it has terms of both signs.

    >>> difference = Sum([Term(1, [("a", 1)]), Term(-1, [("b", 1)])])
    >>> changed = opposite(Term(2, [(difference, 1)]))
    >>> changed.coefficient, [(t.coefficient, t.factors) for t in changed.factors[0][0].terms]
    (2, [(1, [('b', 1)]), (-1, [('a', 1)])])
    """
    return t.coefficient > 0 and _turned(t, False) or Term(-t.coefficient, t.factors)


def _turned(t: Term, below: bool) -> Term | None:
    """Return -t with another sign of its simplest bracket that has terms of both signs."""
    candidates = [
        i
        for i, (node, e) in enumerate(t.factors)
        if isinstance(node, Sum)
        and e % 2
        and not node.fixed
        and (_mixed(node) if e > 0 else below and _even(node))
    ]
    if not candidates:
        return None
    i = min(candidates, key=lambda i: (_bracketed(t.factors[i][0]), len(t.factors[i][0].terms), -i))
    node, e = t.factors[i]
    return Term(t.coefficient, [*t.factors[:i], (negated(node), e), *t.factors[i + 1 :]])


def _bracketed(s: Sum) -> bool:
    return any(isinstance(node, Sum) for t in s.terms for node, _ in t.factors)


def _flips(s: Sum) -> bool:
    """Return True if a sum is one term with a bracket that takes a minus."""
    return len(s.terms) == 1 and _turned(s.terms[0], True) is not None


def _mixed(s: Sum) -> bool:
    """Return True if a sum and its negative can both begin with a positive term."""
    return not is_negative(s) and any(opposite(t).coefficient > 0 for t in s.terms)


def _even(s: Sum) -> bool:
    """Return True if a sum has at most as many positive terms as negative ones."""
    return 2 * sum(t.coefficient < 0 for t in s.terms) >= len(s.terms)


def negated(s: Sum) -> Sum:
    """Return -s, positive terms first."""
    return positive_first(Sum([opposite(t) for t in s.terms]))


def positive_first(s: Sum) -> Sum:
    """Return a sum that begins with a positive term, if it can have one: b - a, not -a + b."""
    if is_negative(s):
        for i in reversed(range(len(s.terms))):
            changed = _with_positive_bracket(s.terms[i])
            if changed is not None:
                return Sum([changed, *s.terms[:i], *s.terms[i + 1 :]], s.fixed)
        return s
    if not s.terms or s.terms[0].coefficient > 0:
        return s
    return Sum(sorted(s.terms, key=lambda t: t.coefficient < 0), s.fixed)


def _with_positive_bracket(t: Term) -> Term | None:
    """Return a negative term as a positive one, if a bracket can take the minus."""
    return _turned(Term(-t.coefficient, t.factors), True)


def settled(s: Sum) -> tuple[Sum, int]:
    """Return a bracket with few negative terms, of two forms the one whose first term is positive, and its sign."""
    other = Sum([opposite(t) for t in s.terms], s.fixed)
    ours, theirs = (sum(t.coefficient < 0 for t in x.terms) for x in (s, other))
    if s.fixed or ours < theirs or ours == theirs and s.terms[0].coefficient > 0:
        return positive_first(s), 1
    return positive_first(other), -1
