"""Relations among generators, and the normal form of a polynomial modulo them.

A relation is a polynomial that is zero, such as sin² + cos² - 1 or p·p⁻¹ - 1. Modulo a set of
relations that is a Gröbner basis, every polynomial has one normal form [Buchberger 1965], so
equal elements are identical and zero is recognised.

Two kinds of relations are stored separately, for speed:

- squares, ``g² - P`` with P older than g (sines, square roots, the unit norm): most relations of
  mechanics; they apply only if both factors of a product contain g;
- general relations (inverses, half angles): completed with Buchberger's algorithm whenever a new
  relation shares a leading generator with an old one.

Newer generators are larger in the lexicographic order, so that a relation that defines a new
generator leads with it, and elements in normal form remain in normal form.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from flint import fmpz_mpoly_vec

from .budget import FREE

# Buchberger's completion stops beyond this: (relations, terms of one, bits of a coefficient).
# Elements stay correct then, but may have several forms in these generators (`element.is_zero` still decides exactly).
LIMITS = (60, 400, 512)
STEP = 2**22
"""Terms that a division may make without checks on the way: 0.3 GB in a ring of 64 generators."""
SHORT = 8
"""Terms of a square that may replace powers of a generator without a check of the budget."""


@dataclass(slots=True)
class Relation:
    """``polynomial = 0``, with the bit masks of its generators and of the generators of its leading monomial."""

    polynomial: Any
    leading: int
    support: int
    coefficient: int
    degree: int
    tail: int  # terms beside the leading one


class Relations:
    """All relations of one ring; every polynomial of them is in the ring's current context."""

    def __init__(self, ring: Any):
        self.ring = ring
        self.squares = 0  # generators g that lead a relation g² - P
        self.triggers = 0  # every leading monomial of `general` contains one of these generators
        self.square: dict[int, Any] = {}  # bit of g -> g² - P
        self.introduces: dict[int, int] = {}  # bit of g -> generators of P
        self.general: list[Relation] = []
        self.unfinished = False  # whether a completion was stopped: see `element.is_zero`

    def promote(self) -> None:
        """Convert all relations to the ring's new context."""
        promoted = self.ring.promoted
        self.square = {bit: promoted(p) for bit, p in self.square.items()}
        for relation in self.general:
            relation.polynomial = promoted(relation.polynomial)

    def add_square(self, bit: int, polynomial: Any) -> None:
        """Declare ``polynomial = g² - P = 0``, where ``bit`` is the mask of g."""
        self.squares |= bit
        self.square[bit] = polynomial
        self.introduces[bit] = self.ring.support(polynomial) & ~bit

    def add_general(self, polynomials: list[Any], triggers: int) -> None:
        """Declare that each of ``polynomials`` is zero and complete the set where they overlap."""
        self.triggers |= triggers
        new = [self._relation(p) for p in polynomials]
        squares = [self._relation(p) for p in self.square.values()]
        related: list[Relation] = []
        reach = 0
        for relation in new:
            reach |= relation.support
        pending = squares + self.general
        while near := [r for r in pending if r.leading & reach]:
            pending = [r for r in pending if not r.leading & reach]
            for relation in near:
                reach |= relation.support
            related += near
        overlap = any(a.leading & b.leading for a in new for b in related) or len(new) > 1
        if not overlap:  # coprime leading monomials: already a Gröbner basis (Buchberger's first criterion)
            self.general += new
            return
        vector = fmpz_mpoly_vec([r.polynomial for r in new + related], self.ring.context)
        basis, complete = vector.buchberger_naive(limits=LIMITS)
        if not complete:
            self.unfinished = True
            self.general += new
            return
        squares_as_text = {str(p) for p in self.square.values()}
        replaced = {id(r) for r in related}
        self.general = [r for r in self.general if id(r) not in replaced]
        for p in basis.autoreduction():
            if p.is_constant():
                raise ZeroDivisionError
            if p.leading_coefficient() < 0:
                p = -p
            if str(p) not in squares_as_text:
                self.general.append(self._relation(p))

    def _relation(self, p: Any) -> Relation:
        lead = self.ring.exponents(p.monomial(0))
        leading = degree = 0
        for index, e in lead:
            leading |= 1 << index
            degree += e
        return Relation(p, leading, self.ring.support(p), int(p.leading_coefficient()), degree, len(p) - 1)

    def _in_steps(self, p: Any, relation: Relation) -> Any:
        """Remainder of a division that may be long, because replacing the leading monomial can bring it back.

        The terms are divided in groups that are small enough to stay within the budget. If a single term might exceed
        it, the leading monomial is replaced in single steps.
        """
        degrees = p.degrees()
        last = len(degrees) - 1
        lead = relation.polynomial.monomial(0)
        times = min(max(int(degrees[last - i]), 0) // e for i, e in self.ring.exponents(lead))
        longest = relation.tail**times
        if len(p) * longest <= STEP:
            return divmod(p, relation.polynomial)[1]
        budget = self.ring.budget
        budget.scan(len(p))
        terms = list(p.to_dict().items())
        if longest <= STEP:
            n = STEP // longest
            total = self.ring.context.constant(0)
            for i in range(0, len(terms), n):
                part = self.ring.context.from_dict(dict(terms[i : i + n]))
                total = total + divmod(part, relation.polynomial)[1]
                budget.sum(len(total))
            return total
        while True:
            quotients = {}
            for monomial, c in terms:
                rest = tuple(int(a) - int(b) for a, b in zip(monomial, lead, strict=True))
                if min(rest) >= 0 and int(c) % relation.coefficient == 0:
                    quotients[rest] = int(c) // relation.coefficient
            if not quotients:
                return p
            quotient = self.ring.context.from_dict(quotients)
            budget.product(quotient, relation.polynomial)
            p = p - quotient * relation.polynomial
            budget.scan(len(p))
            terms = list(p.to_dict().items())

    def normal_form(self, p: Any, both: int, either: int) -> tuple[Any, int, int]:
        """Remainder of a product modulo the relations.

        Parameters
        ----------
        p : fmpz_mpoly
            A product of two normal forms.
        both, either : int
            Masks of the generators in both factors, and in at least one.

        Returns
        -------
        (remainder, scale, mask)
            ``p = remainder / scale``; the mask of the generators that may occur in the remainder.
        """
        scale = 1
        fire = both & self.squares
        while True:
            while fire:
                bit = 1 << (fire.bit_length() - 1)  # newest first: P contains only older generators
                square = self.square[bit]
                if len(p) * len(square) > FREE or len(square) > SHORT:
                    degree = int(p.degrees()[self.ring.capacity - bit.bit_length()])
                    self.ring.budget.division(p, square, degree // 2)
                p = p % square
                fire ^= bit
                new = self.introduces[bit]
                fire |= new & self.squares
                either |= new
            if not either & self.triggers:
                return p, scale, either
            changed = False
            for relation in self.general:
                if relation.leading & ~either:
                    continue
                while True:
                    lc = relation.coefficient
                    scaled = p if lc == 1 else p * lc
                    times = int(p.total_degree()) // relation.degree
                    if len(p) * relation.tail**times > STEP:
                        remainder = self._in_steps(scaled, relation)
                        if remainder == scaled:
                            break
                    else:
                        quotient, remainder = divmod(scaled, relation.polynomial)
                        if not quotient:
                            break
                    p = remainder
                    scale *= lc
                    changed = True
                    either |= relation.support
                    if lc == 1:
                        break
            if not changed or not p:
                return p, scale, either
            fire = either & self.squares
