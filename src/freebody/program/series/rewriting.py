"""Removal of products that a recurrence does not need: rotations there and back, reciprocals.

    s (c x + s y) + c (c y - s x) = y,   s = sin φ, c = cos φ        x (1 / d) = x / d

A force is computed in the axes of a link and turned back to those of its parent, where it may cancel a rotation. A
quotient x / d takes as many products as 1 / d does, so dividing by d saves the product with its reciprocal. Identities
that subtract, such as 1 - cos² = sin², are not used: near the zeros of the sine they lose the digits of a divisor.
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
        """Product of this part and the value and numbers of another."""
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
    """Remove rotations there and back, and return whether there were any."""
    nodes, former, changed = recurrence.nodes, list(recurrence.order), False
    for i in former:
        while nodes[i].rule == "sum" and (shorter := _without(recurrence, nodes[i])) is not None:
            nodes[i], changed = shorter, True
    arrange(recurrence, former)
    return changed


def divided(recurrence: Recurrence) -> None:
    """Replace products with a reciprocal by quotients, where nothing needs the reciprocal itself."""
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
    """Order the nodes anew: each new node after its operands and before its uses."""
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
    """Return a sum without a rotation there and back; None if it contains none."""
    products = [(sign, *ab) for sign, a, b in node.products for ab in {(a, b), (b, a)}]
    sines, cosines = (
        [product for product in products if recurrence.nodes[product[1]].function == name]
        for name in ("sin", "cos")
    )
    for sign_s, s, factor_s in sines:
        for sign_c, c, factor_c in cosines:
            if recurrence.nodes[s].arguments != recurrence.nodes[c].arguments:
                continue
            for p in _parts(recurrence, sign_s, factor_s):
                for q in _parts(recurrence, sign_c, factor_c):
                    result = _unturned(recurrence, s, c, p, q)
                    if result is None:
                        continue
                    rest = [
                        (f, [x for x in _parts(recurrence, sign, e) if x != removed])
                        for sign, f, e, removed in ((sign_s, s, factor_s, p), (sign_c, c, factor_c, q))
                    ]
                    remaining = list(node.products)
                    for sign, f, e in ((sign_s, s, factor_s), (sign_c, c, factor_c)):
                        remaining.remove((sign, f, e) if (sign, f, e) in remaining else (sign, e, f))
                    remaining += [(1, f, _sum(recurrence, parts)) for f, parts in rest if parts]
                    terms = (*node.terms, times(recurrence, result.base, result.value, result.numbers))
                    return node._replace(terms=terms, products=tuple(remaining))
    return None


def _parts(recurrence: Recurrence, sign: int, x: int) -> list[_Part]:
    """Parts of the linear combination sign · x; none if it has a term without a series."""
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
    terms = [times(recurrence, part.base, part.value, part.numbers) for part in parts]
    return terms[0][1] if len(terms) == 1 and terms[0][0] > 0 else recurrence.sum(*terms)


def _unturned(recurrence: Recurrence, s: int, c: int, p: _Part, q: _Part) -> _Part | None:
    """Return y = s p + c q if p = c x + s y and q = c y - s x, else None."""
    rotated = []
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
        rotated.append(by)
    along, across = rotated
    if along[s] != across[c] or along[c] != across[s]._replace(value=-across[s].value):
        return None
    return along[s]
