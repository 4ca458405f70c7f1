"""Number of operations in a printed formula: signs, sums, products, divisions, powers, roots and functions.

2*sqrt(g/(7*R)) has four: a product, a root, a division and a product. Of two formulas of about equal length the one
without brackets in brackets and without fractions in fractions is easier to read: each counts as half an operation.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..printer import Printer
from ..terms import Sum


@dataclass(slots=True, frozen=True)
class Length:
    """The length of a part of a formula.

    Attributes
    ----------
    operations : int
    nesting : int
        Brackets in brackets, fractions in fractions, and long fractions in brackets, in halves of an operation.
    divided : bool
        True if it has a division that is not inside a root or a function.
    depth : int
        Brackets in each other, outside roots and functions.
    fractions : bool
        True for a bracket with a division in it.
    """

    operations: int = 0
    nesting: int = 0
    divided: bool = False
    depth: int = 0
    fractions: bool = False

    @property
    def total(self) -> int:
        """Length in halves of an operation: twice the operations, and the nesting."""
        return 2 * self.operations + self.nesting

    def inside(self) -> Length:
        """Return the length as an argument: its bracket and its bar are the function's."""
        return Length(self.operations, self.nesting)


def _joined(parts: list[Length], operations: int, divided: bool = False) -> Length:
    return Length(
        sum(p.operations for p in parts) + operations,
        sum(p.nesting for p in parts),
        divided or any(p.divided for p in parts),
        max(p.depth for p in parts),
    )


class Operations(Printer):
    """Printer that counts: every part of a formula is shown as its length."""

    bars = False

    def __init__(self, ring: Any) -> None:
        super().__init__(ring)
        self._sums: dict[int, tuple[Sum, Length]] = {}

    def factor(self, node: Any, e: int) -> Length:
        """A node to a positive power; a bracket is counted once."""
        if not isinstance(node, Sum):
            length: Length = super().factor(node, e)
            return length
        if id(node) not in self._sums:
            self._sums[id(node)] = (node, self.bracketed(self.sum(node)))
        return self.power(self._sums[id(node)][1], e)

    def number(self, n: int) -> Length:
        """A whole number."""
        return Length()

    def name(self, name: str, dots: int = 0) -> Length:
        """A name."""
        return Length()

    def power(self, base: Length, e: int) -> Length:
        """A factor to a positive whole power."""
        result = _joined([base], 1)
        return (
            base if e == 1 else Length(result.operations, result.nesting, False, base.depth, base.fractions)
        )

    def bracketed(self, s: Length) -> Length:
        """A sum as a factor."""
        nesting = s.nesting + s.depth + 2 * (s.divided and s.depth > 0)
        return Length(s.operations, nesting, False, s.depth + 1, s.divided)

    def product(self, p: int, over: list[Length], q: int, under: list[Length]) -> Length:
        """p · over / (q · under)."""
        above, below = self.numbered(p, over), self.numbered(q, under)
        if q == 1 and not under:
            result = _joined(above, len(above) - 1)
            fractions = any(part.fractions for part in above)
            return Length(result.operations, result.nesting, fractions, result.depth)
        compound = sum(part.fractions for part in above + below)
        result = _joined(above + below, len(above) - 1 + len(below), True)
        return Length(result.operations, result.nesting + compound, True, result.depth)

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
