"""Products of series that a recurrence does not need: rotations there and back, reciprocals.

    s (c x + s y) + c (c y - s x) = y,   s = sin φ, c = cos φ        x (1 / d) = x / d

A force is found in the axes of a link and taken back to those of its parent, with what it is there; a quotient takes as
many products as 1 / d does, so that it pays to divide what else would be multiplied by it. Identities that subtract,
as 1 - cos² for sin², are left alone: near the zeros of the sine they lose the digits by which something is divided.
"""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

from .factors import factored, times, unscaled
from .recurrence import Node, Number, Recurrence


class _Part(NamedTuple):
    """value · numbers · base, a term of a linear combination of series."""

    value: float
    numbers: tuple[Number, ...]
    base: int

    def by(self, other: _Part) -> _Part:
        """This times the numbers of another."""
        numbers = tuple(sorted((*self.numbers, *other.numbers), key=repr))
        return _Part(self.value * other.value, numbers, self.base)


def shortened(recurrence: Recurrence) -> Recurrence:
    """Shorten a recurrence in place by all rules of `factors` and of this file, and return it."""
    while factored(recurrence) or turned_back(recurrence):
        recurrence.forget()
    divided(recurrence)
    recurrence.forget()
    return recurrence


def turned_back(recurrence: Recurrence) -> bool:
    """Leave out rotations there and back; whether there were any."""
    nodes, former, changed = recurrence.nodes, list(recurrence.order), False
    for i in former:
        while nodes[i].rule == "sum" and (found := _without(recurrence, nodes[i])) is not None:
            nodes[i], changed = found, True
    arrange(recurrence, former)
    return changed


def divided(recurrence: Recurrence) -> None:
    """Divide by what else would be multiplied by its reciprocal, where nothing needs the reciprocal itself."""
    nodes, former = recurrence.nodes, list(recurrence.order)
    uses = Counter(x for i in former for x in recurrence.used(i))
    uses.update(x for x in recurrence.outputs if isinstance(x, int))
    inverse = {
        i for i in former if nodes[i].rule == "quotient" and not isinstance(nodes[i].arguments[0], int)
    }
    times_used = Counter[int]()
    for i in former:
        for _, a, b in nodes[i].products if nodes[i].rule == "sum" else ():
            times_used.update({a, b} & inverse)
            inverse -= {a} & {b}
    inverse = {i for i in inverse if times_used[i] == uses[i] and _is_one(nodes[i])}
    for i in former:
        if nodes[i].rule != "sum":
            continue
        alone = not nodes[i].terms and len(nodes[i].products) == 1
        terms, products = list(nodes[i].terms), []
        for sign, a, b in nodes[i].products:
            x, r = (b, a) if a in inverse else (a, b)
            if r in inverse and x not in inverse:
                terms.append((sign, recurrence.quotient(x, nodes[r].operand)))
            else:
                products.append((sign, a, b))
        nodes[i] = nodes[i]._replace(terms=tuple(terms), products=tuple(products))
        if alone and terms:
            sign, quotient = terms[0]
            if sign > 0 and isinstance(quotient, int):
                nodes[i] = nodes[quotient]
    arrange(recurrence, former)


def _is_one(node: Node) -> bool:
    above = node.arguments[0]
    return not isinstance(above, int) and above.value == 1.0 and not above.function


def arrange(recurrence: Recurrence, former: list[int]) -> None:
    """New nodes after what they need, before what needs them."""
    old, placed = set(former), dict[int, None]()

    def place(i: int) -> None:
        for x in recurrence.used(i):
            if x not in old and x not in placed:
                place(x)
        placed[i] = None

    for i in former:
        place(i)
    recurrence.order = list(placed)


def _without(recurrence: Recurrence, node: Node) -> Node | None:
    """A sum without a rotation there and back; None if there is none in it."""
    products = [(sign, *ab) for sign, a, b in node.products for ab in {(a, b), (b, a)}]
    sines, cosines = (
        [one for one in products if recurrence.nodes[one[1]].function == name] for name in ("sin", "cos")
    )
    for one, s, first in sines:
        for two, c, second in cosines:
            if recurrence.nodes[s].arguments != recurrence.nodes[c].arguments:
                continue
            for p in _parts(recurrence, one, first):
                for q in _parts(recurrence, two, second):
                    left = _left(recurrence, s, c, p, q)
                    if left is None:
                        continue
                    rest = [
                        (f, [x for x in _parts(recurrence, sign, e) if x != gone])
                        for sign, f, e, gone in ((one, s, first, p), (two, c, second, q))
                    ]
                    kept = list(node.products)
                    for sign, f, e in ((one, s, first), (two, c, second)):
                        kept.remove((sign, f, e) if (sign, f, e) in kept else (sign, e, f))
                    kept += [(1, f, _sum(recurrence, parts)) for f, parts in rest if parts]
                    terms = (*node.terms, times(recurrence, left.base, left.value, left.numbers))
                    return node._replace(terms=terms, products=tuple(kept))
    return None


def _parts(recurrence: Recurrence, sign: int, x: int) -> list[_Part]:
    """sign x as a linear combination; nothing if it holds a number that stands alone."""
    value, numbers, base, _ = unscaled(recurrence, x)
    node, outer = recurrence.nodes[base], _Part(sign * value, numbers, base)
    if node.rule != "sum" or node.products:
        return [outer]
    result = []
    for sign_, y in node.terms:
        if not isinstance(y, int):
            return []
        value, numbers, inner, _ = unscaled(recurrence, y)
        result.append(_Part(sign_ * value, numbers, inner).by(outer))
    return result


def _sum(recurrence: Recurrence, parts: list[_Part]) -> int:
    found = [times(recurrence, part.base, part.value, part.numbers) for part in parts]
    return found[0][1] if len(found) == 1 and found[0][0] > 0 else recurrence.sum(*found)


def _left(recurrence: Recurrence, s: int, c: int, p: _Part, q: _Part) -> _Part | None:
    """What s p + c q is, where p = c x + s y and q = c y - s x; None where they are not."""
    found = []
    for part in (p, q):
        node = recurrence.nodes[part.base]
        if node.rule != "sum" or node.terms or len(node.products) != 2:
            return None
        by: dict[int, _Part] = {}
        for sign, a, b in node.products:
            factor, x = (a, b) if a in (s, c) else (b, a)
            value, numbers, base, _ = unscaled(recurrence, x)
            by[factor] = _Part(sign * value, numbers, base).by(part)
        if by.keys() != {s, c}:
            return None
        found.append(by)
    there, back = found
    if there[s] != back[c] or there[c] != back[s]._replace(value=-back[s].value):
        return None
    return there[s]
