"""Number of operations in a printed formula: signs, sums, products, divisions, powers, roots and functions.

2*sqrt(g/(7*R)) has four: a product, a root, a division and a product. Of two formulas of about equal length the one
without brackets in brackets and without fractions in brackets is easier to read: each counts as further operations.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..printer import Printer
from ..terms import Sum

NESTED = 1
"""Operations that a bracket in a bracket is worth."""
COMPOUND = 2
"""Operations that a fraction in a bracket is worth."""


@dataclass(slots=True, frozen=True)
class Length:
    """The length of a part of a formula.

    Attributes
    ----------
    operations : int
    unease : int
        Further operations for brackets in brackets and fractions in brackets.
    divided, bracketed : bool
        True if it has a division, or a bracket, that is not inside a root or a function.
    """

    operations: int = 0
    unease: int = 0
    divided: bool = False
    bracketed: bool = False

    @property
    def total(self) -> int:
        """Operations and unease."""
        return self.operations + self.unease

    def inside(self) -> Length:
        """Return the length as an argument: its bracket and its bar are the function's."""
        return Length(self.operations, self.unease)


def _joined(parts: list[Length], operations: int, divided: bool = False) -> Length:
    return Length(
        sum(p.operations for p in parts) + operations,
        sum(p.unease for p in parts),
        divided or any(p.divided for p in parts),
        any(p.bracketed for p in parts),
    )


class Operations(Printer):
    """Printer that counts: every part of a formula is shown as its length."""

    bars = False

    def number(self, n: int) -> Length:
        """A whole number."""
        return Length()

    def name(self, name: str, dots: int = 0) -> Length:
        """A name."""
        return Length()

    def power(self, base: Length, e: int) -> Length:
        """A factor to a positive whole power."""
        return base if e == 1 else _joined([base], 1)

    def bracketed(self, s: Length) -> Length:
        """A sum as a factor."""
        return Length(s.operations, s.unease + NESTED * s.bracketed + COMPOUND * s.divided, False, True)

    def product(self, p: int, over: list[Length], q: int, under: list[Length]) -> Length:
        """p · over / (q · under)."""
        above, below = self.numbered(p, over), self.numbered(q, under)
        if q == 1 and not under:
            return _joined(above, len(above) - 1)
        return _joined(above + below, len(above) - 1 + len(below), True)

    def added(self, terms: list[tuple[bool, Length]]) -> Length:
        """Terms joined by their signs."""
        return _joined([n for _, n in terms], len(terms) - 1 + terms[0][0])

    def function(self, name: str, arguments: list[Length], e: int) -> Length:
        """A function to a positive whole power."""
        return _joined([a.inside() for a in arguments], 1 + (e != 1))

    def root(self, argument: Length) -> Length:
        """A square root."""
        return _joined([argument.inside()], 1)


def length(formula: Sum, ring: Any) -> Length:
    """Return the length of an arranged formula."""
    result: Length = Operations(ring).sum(formula)
    return result


def operations(formula: Sum, ring: Any) -> int:
    """Return the number of operations in an arranged formula."""
    return length(formula, ring).operations
