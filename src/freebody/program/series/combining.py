"""Sums of sums in a recurrence, written as sums of their parts.

Additions that wait for each other make an order of a series wait: a (x + y) - a x + b (x + y), for instance, is
b x + (a + b) y. Numbers are combined once, before the first order. For the gyroscope in gimbals this saves 6 % of the
operations and of the time.
"""

from __future__ import annotations

from .recurrence import Node, Number, Recurrence
from .rewriting import arrange

_Weight = dict[tuple[Number, ...], float]
"""Σ value · numbers."""
_Linear = dict[int | None, _Weight]
"""Weight of each series in a sum; None stands for the terms without a series."""


def combined(recurrence: Recurrence) -> None:
    """Expand sums into series that are no sums themselves, where that takes no more terms."""
    nodes, former = recurrence.nodes, list(recurrence.order)
    expansions: dict[int, _Linear] = {}
    for i in former:
        node = nodes[i]
        if node.rule == "scaled":
            expansions[i] = _times(_linear(expansions, node.operand), node.number)
        elif node.rule == "sum":
            total: _Linear = {}
            for sign, x in node.terms:
                part = _linear(expansions, x) if isinstance(x, int) else _times({None: {(): 1.0}}, x)
                _add(total, sign, part)
            if len(total) <= len(node.terms):
                terms = [_term(recurrence, base, weight) for base, weight in total.items()]
                node = nodes[i] = node._replace(terms=tuple(terms))
            if not node.products:
                expansions[i] = total
        if node.rule == "scaled" or (node.rule == "sum" and not node.products):
            ((base, weight), *others) = expansions[i].items() or [(None, {})]
            if not others and base is not None and (number := _number(weight)).value != 1.0:
                nodes[i] = Node("scaled", number=number, operand=base)
    arrange(recurrence, former)
    recurrence.forget()


def _linear(expansions: dict[int, _Linear], x: int) -> _Linear:
    return expansions.get(x, {x: {(): 1.0}})


def _times(linear: _Linear, number: Number) -> _Linear:
    if number.value is not None and not number.function:
        return {x: {n: v * number.value for n, v in weight.items()} for x, weight in linear.items()}
    return {
        x: {tuple(sorted((*n, number), key=repr)): v for n, v in weight.items()}
        for x, weight in linear.items()
    }


def _add(total: _Linear, sign: int, linear: _Linear) -> None:
    for x, weight in linear.items():
        into = total.setdefault(x, {})
        for numbers, value in weight.items():
            into[numbers] = into.get(numbers, 0.0) + sign * value
            if into[numbers] == 0.0:
                del into[numbers]
        if not into:
            del total[x]


def _number(weight: _Weight) -> Number:
    if weight.keys() == {()}:
        return Number(weight[()])
    (numbers, value), *others = weight.items()
    if not others and value == 1.0 and len(numbers) == 1:
        return numbers[0]
    return Number(function="sum", parts=tuple(sorted(((v, n) for n, v in weight.items()), key=repr)))


def _term(recurrence: Recurrence, base: int | None, weight: _Weight) -> tuple[int, int | Number]:
    number = _number(weight)
    if base is None:
        return 1, number
    if number.value is not None and abs(number.value) == 1.0:
        return int(number.value), base
    return 1, recurrence.product(base, number)
