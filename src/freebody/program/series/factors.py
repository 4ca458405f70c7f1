"""Common factors in the sums of a recurrence: f x + f y becomes f (x + y), one product of series in place of two.

A product of two series takes as many multiplications per order as they have coefficients; a product with a number takes
one. So numbers are moved out of products, to places where no series is multiplied by another. Equal products of
opposite sign, which a rotation there and back leaves, cancel.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any, NamedTuple

from .recurrence import Number, Recurrence


class _Product(NamedTuple):
    """value · numbers · a · b, with the pair of nodes in order; ``original`` is the term or product of the sum."""

    value: float
    numbers: tuple[Number, ...]
    pair: tuple[int, int]
    original: tuple[Any, ...]


def factored(recurrence: Recurrence) -> bool:
    """Draw common factors out of the sums of products, and return whether there were any."""
    return _Factoring(recurrence).factored()


def unscaled(
    recurrence: Recurrence, x: int, uses: Mapping[int, int] | None = None
) -> tuple[float, tuple[Number, ...], int, bool]:
    """Value, numbers and series whose product node ``x`` is, and whether the nodes between have no other use."""
    value, alone = 1.0, True
    numbers: tuple[Number, ...] = ()
    while True:
        node = recurrence.nodes[x]
        if node.rule == "scaled":
            if node.number.value is None or node.number.function:
                numbers = (*numbers, node.number)
            else:
                value *= node.number.value
            below = node.operand
        elif (
            node.rule == "sum"
            and len(node.terms) == 1
            and not node.products
            and isinstance(node.terms[0][1], int)
        ):
            value *= node.terms[0][0]
            below = node.terms[0][1]
        else:
            return value, numbers, x, alone
        alone = alone and uses is not None and uses[x] == 1
        x = below


def times(recurrence: Recurrence, x: int, value: float, numbers: tuple[Number, ...]) -> tuple[int, int]:
    """Multiply a series by numbers; return a sign and a series."""
    for number in numbers:
        x = recurrence.product(x, number)
    if abs(value) != 1:
        x = recurrence.product(x, Number(abs(value)))
    return (1 if value > 0 else -1), x


class _Factoring:
    """One pass of factoring over a recurrence."""

    def __init__(self, recurrence: Recurrence) -> None:
        self.recurrence, self.nodes = recurrence, recurrence.nodes
        self.former = recurrence.order
        self.placed: dict[int, None] = {}
        self.uses = Counter(x for i in self.former for x in recurrence.used(i))
        self.uses.update(x for x in recurrence.outputs if isinstance(x, int))

    def factored(self) -> bool:
        """Factor all sums, and return whether one has changed."""
        changed = False
        for i in self.former:
            before = self.recurrence.used(i)
            if self.nodes[i].rule == "sum" and i not in self.placed and self._draw(i):
                changed = True
                for x in self.recurrence.used(i):
                    if x not in before:
                        self._place(x)
            self.placed[i] = None
        self.recurrence.order = list(self.placed)
        return changed

    def _place(self, i: int) -> None:
        """Place a new sum after its parts."""
        if i not in self.placed:
            for x in self.recurrence.used(i):
                self._place(x)
            self.placed[i] = None

    def _multiplied(
        self, sign: float, numbers: tuple[Number, ...], a: int, b: int, original: tuple[Any, ...]
    ) -> _Product:
        value_a, numbers_a, x, _ = unscaled(self.recurrence, a)
        value_b, numbers_b, y, _ = unscaled(self.recurrence, b)
        sorted_numbers = tuple(sorted((*numbers, *numbers_a, *numbers_b), key=repr))
        return _Product(sign * value_a * value_b, sorted_numbers, (min(x, y), max(x, y)), original)

    def _draw(self, i: int) -> bool:
        """Draw common factors out of node ``i``, and return whether there were any."""
        terms, expanded = [], []
        for term in self.nodes[i].terms:
            sign, x = term
            if isinstance(x, int):
                value, numbers, base, alone = unscaled(self.recurrence, x, self.uses)
                below = self.nodes[base]
                if (
                    alone
                    and self.uses[base] == 1
                    and below.rule == "sum"
                    and not below.terms
                    and len(below.products) == 1
                ):
                    product_sign, a, b = below.products[0]
                    expanded.append(self._multiplied(sign * value * product_sign, numbers, a, b, term))
                    continue
            terms.append(term)
        expanded += [self._multiplied(sign, (), a, b, (sign, a, b)) for sign, a, b in self.nodes[i].products]
        remaining = self._collected(expanded)
        products: list[tuple[int, int, int]] = []
        while remaining:
            uses = Counter(x for p in remaining for x in set(p.pair))
            f, count = min(uses.items(), key=lambda item: (-item[1], item[0]))  # the most common factor
            group = [p for p in remaining if f in p.pair] if count > 1 else remaining
            remaining = [p for p in remaining if p not in group]
            if count > 1:
                parts = [times(self.recurrence, p.pair[p.pair[0] == f], p.value, p.numbers) for p in group]
                products.append((1, f, self.recurrence.sum(*parts)))
                continue
            for p in group:
                if len(p.original) == 2:
                    terms.append(p.original)
                elif p.original:
                    products.append(p.original)
                else:
                    sign, x = times(self.recurrence, p.pair[1], p.value, p.numbers)
                    products.append((sign, p.pair[0], x))
        if len(products) == len(self.nodes[i].products) and len(terms) == len(self.nodes[i].terms):
            return False
        self.nodes[i] = self.nodes[i]._replace(terms=tuple(terms), products=tuple(products))
        return True

    def _collected(self, products: list[_Product]) -> list[_Product]:
        """Add up equal products and drop those that cancel."""
        result: dict[object, _Product] = {}
        for p in products:
            key = p.numbers, p.pair
            if key in result:
                p = _Product(result[key].value + p.value, p.numbers, p.pair, ())
            result[key] = p
        return [p for p in result.values() if p.value != 0]
