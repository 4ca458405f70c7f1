"""Monomials of a closed form: its letters with integer and half exponents.

A letter is a generator of the ring, a polynomial that stands in a denominator or under a root, a sine or cosine of a
sum of angles, or a whole number under a root. With half exponents sqrt(L)/L is L^(-1/2), so that roots join:

    sqrt(3)*sqrt(g)*sqrt(L)/L = 3^(1/2) g^(1/2) L^(-1/2) = sqrt(3*g/L)
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from ....scalar.element import Polynomial
from ....scalar.roots import is_positive
from ..arrange import FIXED, MOVING, Arrangement

Monomial = tuple[tuple[int, int], ...]
"""((letter, twice the exponent), ...) by rising letters."""
Terms = dict[Monomial, Fraction]


class Letters:
    """The letters of closed forms of one ring, by number."""

    def __init__(self, ring: Any) -> None:
        self.ring = ring
        self.arrangement = Arrangement(ring, None)
        self.bases: list[Any] = []
        self._numbers: dict[Any, int] = {}
        self._classes: dict[int, int] = {}
        self._ranks: dict[int, Any] = {}
        self._orders: dict[Monomial, Any] = {}

    def number(self, base: Any) -> int:
        """Return the number of a letter."""
        if base not in self._numbers:
            self._numbers[base] = len(self.bases)
            self.bases.append(base)
        return self._numbers[base]

    # ---------------------------------------------------------------- from elements
    def terms(self, x: Any) -> Terms:
        """Return an element or a number in letters."""
        if type(x) is not Polynomial:
            return {(): Fraction(x)} if x else {}
        return self.collected((Fraction(c, x.den), m) for m, c in x.terms())

    def collected(self, entries: Any) -> Terms:
        """Return the sum of (coefficient, factors) in letters."""
        result: Terms = {}
        for c, factors in entries:
            powers: dict[int, int] = {}
            for i, e in factors:
                base, twice, sign = self._letter(i, e)
                c *= sign
                letter = self.number(base)
                powers[letter] = powers.get(letter, 0) + twice
            key = tuple(sorted((k, e) for k, e in powers.items() if e))
            result[key] = result.get(key, 0) + c
        return {m: c for m, c in result.items() if c}

    def _letter(self, i: Any, e: Any) -> tuple[Any, int, int]:
        """Return (base, twice the exponent, sign) of a factor."""
        if isinstance(i, str):  # a sine or cosine of a sum of angles: the exponent holds the angles
            return (i, e), 2, 1
        g = self.ring.generators[i]
        if g.kind not in ("inverse", "sqrt"):
            return i, 2 * e, 1
        (x,) = g.arguments
        twice = e if g.kind == "sqrt" else -2 * e
        if x.is_number:
            return ("number", int(x.number())), twice, 1
        if len(x) == 1 and x.den == 1 and x.num.leading_coefficient() == 1:
            (factors, _), *_ = x.terms()
            if len(factors) == 1 and factors[0][1] == 1:
                base, inner, sign = self._letter(factors[0][0], 1)
                if inner == 2:
                    return base, twice, sign
                return factors[0][0], twice, 1
        # of x and -x, the one under a root or known to be positive: one letter for both
        if g.kind == "inverse" and (("sqrt", -x) in self.ring._index or self._positive(-x)):
            return -x, twice, (-1) ** e
        return x, twice, 1

    # ---------------------------------------------------------------- questions
    def positive(self, letter: int) -> bool:
        """Return True if a letter is known to be positive."""
        base = self.bases[letter]
        if isinstance(base, tuple):
            return base[0] == "number"
        if isinstance(base, int):
            return self._positive(self.ring.variable(base))
        return self._positive(base)

    def _positive(self, x: Polynomial) -> bool:
        return is_positive(self.ring, self.ring.promoted(x.num))

    def kind(self, letter: int) -> str:
        """Return the kind of generator that a letter is, or a word for other letters."""
        base = self.bases[letter]
        if isinstance(base, int):
            return str(self.ring.generators[base].kind)
        return "polynomial" if isinstance(base, Polynomial) else str(base[0])

    def class_of(self, letter: int) -> int:
        """Return 0 for moving letters, 1 for parameters, 2 for all others; see `Arrangement.class_of`."""
        if letter not in self._classes:
            base = self.bases[letter]
            if isinstance(base, int):
                number = self.arrangement.class_of(base)
            elif isinstance(base, tuple):
                number = 1 if base[0] == "number" else 2
            else:
                used = self.ring.used(base)
                atoms = self.ring.of_mask(self.ring.depends(base))
                fixed = all(a.kind in FIXED for a in atoms) and not any(
                    g.kind in ("sin", "cos", "function") for g in used
                )
                number = 1 if fixed else 2
            self._classes[letter] = number
        return self._classes[letter]

    def rank(self, letter: int) -> tuple[int, ...]:
        """Return the sorting key of a letter: the ranks of the atoms that it depends on."""
        if letter not in self._ranks:
            base = self.bases[letter]
            if isinstance(base, int):
                g = self.ring.generators[base]
                trigonometric = g.kind in ("sin", "cos")
                key = self.arrangement.rank(min(base, g.partner) if trigonometric else base)
                key = (*key, g.kind == "cos") if trigonometric else key
            elif isinstance(base, Polynomial):
                mask = self.ring.depends(base)
                key = (*sorted(a.rank for a in self.ring.of_mask(mask)), len(self.ring.generators))
            elif base[0] == "number":
                key = (-1,)
            else:
                key = (*(x for i, n in base[1] for x in (*self.arrangement.rank(i), n)), base[0] == "cos")
            self._ranks[letter] = key
        return self._ranks[letter]

    def order(self, monomial: Monomial) -> Any:
        """Return the sorting key of a term: accelerations and speeds first, then by functions, then by parameters."""
        if monomial not in self._orders:
            by_class: list[list[tuple[int, int]]] = [[], [], []]
            for letter, e in monomial:
                by_class[self.class_of(letter)].append((letter, e))
            moving, parameters, others = by_class
            first: Any = (9,)
            if moving:
                kinds = [MOVING.get(self.kind(k), 2) for k, _ in moving]
                first = (min(kinds), -sum(e for _, e in moving), sorted(self.rank(k) for k, _ in moving))
            second = (sum(abs(e) for _, e in others), sorted(self._place(k, e) for k, e in others))
            ranks = sorted(self.rank(k) for k, e in parameters for _ in range(abs(e)))
            third = (not parameters, ranks, [-e for _, e in parameters])
            self._orders[monomial] = (first, second, third)
        return self._orders[monomial]

    def _place(self, letter: int, e: int) -> Any:
        """Return the sorting key of a coordinate or function: coordinates, then angles, sines first."""
        angle = self.kind(letter) in ("sin", "cos")
        rank = self.rank(letter)
        return (1, rank[:-1], e, rank[-1]) if angle else (0, rank, e, False)
