"""The budget of a ring: a computation that needs too much memory or time is refused before it begins.

A product of a and b terms takes a b products of terms. Its result has at most

    min(a b,  Π (d_i + 1),  C(n + d, n))

terms, where d_i is its degree in generator i, d the total degree and n the number of generators. FLINT ends
the process when memory is short, so the estimate comes before the product. Small products cost one comparison.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from math import comb
from typing import Any

from ..errors import TooManyTermsError

FREE = 4096
"""Products of terms that are computed without a check: 0.1 ms of work."""
MEMORY = 2**26
"""Bytes of the largest element. A term takes a byte for the exponent of every generator and 16 for its coefficient, so
an element of a ring of 128 generators has at most 466,000 terms: 20 times as many as the longest answers of the tests.
"""
ELEMENTS = 16
"""Elements of that size that one question may make: 1 GB, if none of them is freed meanwhile."""
LARGE = 16
"""An element counts toward :data:`ELEMENTS` from a 16th of that size on."""
LIFE = 8
"""Number of questions whose budget a ring has in its life outside any named question."""
WORK = 2**29
"""Products of terms in one question, of 15 to 50 ns each: 10 to 30 s."""
SLOW = 1000
"""Products of terms in the time in which Python reads one term, or a factorization handles one: 20 μs."""
CURE = "Ask for less: fewer bodies or coordinates, or numbers in place of parameters."


class Budget:
    """The remaining budget of one question to a ring: products of terms, and terms in memory.

    A caller that can name the result opens a question (:meth:`question`). Questions inside it give a narrower name and
    may lower the budget, never raise it. Outside any question, a ring has the budget of eight questions for its life.
    """

    def __init__(self, ring: Any) -> None:
        self.ring = ring
        self.subject = "an expression"
        self.cure = CURE
        self._open = False
        self._ceiling: int | None = None
        self._renew(LIFE * WORK, LIFE * ELEMENTS)

    def _renew(self, work: float, elements: float) -> None:
        self.work, self.elements = work, elements

    @property
    def most(self) -> int:
        """Greatest number of terms of one element."""
        terms = MEMORY // (self.ring.capacity + 16)
        return terms if self._ceiling is None else min(terms, self._ceiling)

    @contextmanager
    def question(
        self, subject: str, cure: str = "", *, terms: int | None = None, work: int = WORK
    ) -> Iterator[None]:
        """Name the result, and limit the ``terms`` of each element and the ``work`` within this context."""
        before = (self.subject, self.cure, self._open, self._ceiling)
        life = (self.work, self.elements)
        if not self._open:
            self._renew(work, ELEMENTS)
        if cure and not self._open:  # the outermost question knows the cure
            self.cure = cure
        self.subject, self._open = subject, True
        if terms is not None:
            self._ceiling = min(self.most, terms)
        try:
            yield
        finally:
            self.subject, self.cure, self._open, self._ceiling = before
            if not self._open:
                self._renew(*life)

    def refuse(self, terms: int) -> None:
        """Raise TooManyTermsError for the subject of the question."""
        raise TooManyTermsError(
            f"Expected {self.subject} to need no expression of more than {self.most:,} terms, got an estimate of "
            f"{shown(terms)}.",
            self.cure,
        )

    def product(self, a: Any, b: Any) -> None:
        """Charge the product of two fmpz_mpoly."""
        work = len(a) * len(b)
        bits = _bits(a) + _bits(b)
        terms = work
        if self._weight(work, bits) * LARGE > self.most:
            terms = min(work, _monomials(self.ring, a, b))
        self._take(work, terms, bits)

    def power(self, a: Any, exponent: int) -> None:
        """Charge a power: n terms give C(e + n - 1, n - 1) terms, whose coefficients are e times as long."""
        n = len(a)
        terms = comb(exponent + n - 1, n - 1) if n * exponent < 2**16 else _degrees_of_power(a, exponent)
        self._take(0, min(terms, _degrees_of_power(a, exponent)), _bits(a) * exponent)

    def sum(self, terms: int) -> None:
        """Refuse a sum of too many terms."""
        if terms > self.most:
            self.refuse(terms)

    def division(self, p: Any, divisor: Any, times: int = 1) -> None:
        """Charge one pass of a division: every term of p may be replaced by the terms of the divisor."""
        work = len(p) * max(len(divisor) - 1, 1) ** times
        if work > self.most:
            self.refuse(work)
        self._take(work, 0, 0)

    def factors(self, *elements: Any) -> None:
        """Charge a factorization or a common divisor.

        They take 10 to 20 μs a term for products of random sums of up to 10,000 terms, and more for powers of long
        sums.
        """
        terms = sum(map(len, elements))
        self._take(SLOW * terms * (1 + terms // FREE), terms, 0)

    def scan(self, terms: int) -> None:
        """Charge a loop over terms in Python."""
        self._take(SLOW * terms, 0, 0)

    def angle_sum(self, angles: int) -> None:
        """Refuse the sine of a sum of too many angles, which has 2^(n - 1) terms."""
        if angles > FREE.bit_length() and 2 ** (angles - 1) > self.most:
            self.refuse(2 ** (angles - 1))

    def evaluation(self, terms: int, points: int) -> None:
        """Charge the values of terms at points: 1 μs a term and 80 ns a term and point."""
        self._take((50 + 4 * points) * terms, 0, 0)

    def _weight(self, terms: int, bits: int) -> int:
        """Number of terms with coefficients of one word that would take the same memory."""
        return terms if bits <= 64 else terms + terms * bits // (8 * (self.ring.capacity + 16))

    def _take(self, work: int, terms: int, bits: int) -> None:
        most = self.most
        terms = self._weight(terms, bits)
        if terms > most:
            self.refuse(terms)
        self.work -= work
        if terms * LARGE > most:
            self.elements -= terms / most
        if self.work < 0 or self.elements < 0:
            raise TooManyTermsError(
                f"Expected {self.subject} to need at most {WORK:,} products of terms and {ELEMENTS * most:,} terms in "
                f"all, got more.",
                self.cure,
            )


def shown(n: int) -> str:
    """A number of terms as text; from 10^9 on as a power of ten."""
    return f"{n:,}" if n < 10**9 else f"10^{len(str(n)) - 1}"


def _monomials(ring: Any, a: Any, b: Any) -> int:
    """Greatest number of monomials of a product, from its degree in each generator and its total degree."""
    a, b = ring.promoted(a), ring.promoted(b)
    box, used = 1, 0
    for d, e in zip(a.degrees(), b.degrees(), strict=True):
        if d > 0 or e > 0:
            box *= int(d) + int(e) + 1
            used += 1
    degree = int(a.total_degree()) + int(b.total_degree())
    return min(box, comb(used + degree, used) if min(used, degree) < 1000 else box)


def _degrees_of_power(a: Any, exponent: int) -> int:
    """Greatest number of monomials of a power, from its degree in each generator."""
    box = 1
    for d in a.degrees():
        if d > 0:
            box *= int(d) * exponent + 1
    return box


def _bits(a: Any) -> int:
    """Bits of the longest of three coefficients, an estimate for all of them."""
    n = len(a)
    if n == 0:
        return 0
    return max(int(a.coefficient(i)).bit_length() for i in (0, n // 2, n - 1))
