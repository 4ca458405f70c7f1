"""Changes of a print, one at a time, and whether a changed one still states the same."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import sympy

from freebody.chapter.meaning import Meaning
from freebody.chapter.notation import Node, Print, Relation, read
from freebody.chapter.small import components, put
from freebody.chapter.statement import Statement, is_zero, summands, terms
from freebody.chapter.values import evaluate

t = sympy.Symbol("t")
TWO = Node("number", "2")
SWAPPED = {"sin": "cos", "cos": "sin"}
FAMILIES = ("xyz", "ijk", "ABC", "rρ")


def changes(text: str, names: dict[str, Any]) -> Iterator[tuple[str, Print]]:
    """(what is changed, the changed print): a sign, a factor, a number, an index, a function, an order."""
    printed = read(text)
    for k, tree in enumerate(printed.members):
        for path, node in tree.walk():
            above = tree
            for i in path[:-1]:
                above = above.parts[i]
            for what, new in _changed(node, above if path else None, names):
                members = (*printed.members[:k], tree.put(path, new), *printed.members[k + 1 :])
                yield f"member {k + 1}: {what}", replace(printed, members=members)


def names_of(meaning: Meaning) -> dict[str, Any]:
    """All names that a print may use, those of an element of mass or of a load too."""
    elements = [] if callable(meaning.elements) else [e for _, e in meaning.elements[:1]]
    return {k: v for part in (meaning.names, *elements, *meaning.loads[:1]) for k, v in part.items()}


def judged(statement: Statement, place: int, printed: Print) -> set[str]:
    """Verdicts on the relations of a changed print; that which adds a number to a vector is none."""
    try:
        return {statement.judge(place, relation).verdict for relation in printed.relations}
    except (TypeError, AttributeError, KeyError, sympy.ShapeError):
        return {"nonsense"}


def _changed(node: Node, above: Node | None, names: dict[str, Any]) -> Iterator[tuple[str, Node]]:
    if node.kind == "const":
        return
    if node.kind == "sum":
        for i, sign in enumerate(node.value):
            flipped = "+" if sign == "-" else "-"
            yield (
                f"sign of {node.parts[i]}",
                replace(node, value=(*node.value[:i], flipped, *node.value[i + 1 :])),
            )
    term = above is None or above.kind in ("sum", "group", "call", "integral", "rate")
    if term and node.kind not in ("sum", "number"):
        yield f"sign of {node}", Node("group", "(", (Node("sum", ("-",), (node,)),))
        inner = Node("group", "(", (node,)) if node.kind in ("dot", "cross") else node
        yield f"factor 2 of {node}", Node("product", ("*", "*"), (TWO, inner))
    if node.kind == "number" and node.value != "0":
        yield f"number {node}", replace(node, value=str(sympy.Rational(node.value) + 1))
    if node.kind == "name":
        for other in siblings(node.value, names):
            yield f"{node} -> {other}", replace(node, value=other)
    if node.kind == "call" and node.value in SWAPPED:
        yield f"{node.value} -> {SWAPPED[node.value]}", replace(node, value=SWAPPED[node.value])
    if node.kind == "cross":
        yield f"order of {node}", replace(node, parts=node.parts[::-1])


def siblings(name: str, names: dict[str, Any]) -> list[str]:
    """Names that differ in their index only, or one of x, y, z for another; scalars for scalars."""
    kind = _split(name)
    vector = isinstance(names.get(name), sympy.MatrixBase)
    found = [
        other
        for other in names
        if other != name and _split(other) == kind and isinstance(names[other], sympy.MatrixBase) == vector
    ]
    return found


def _split(name: str) -> tuple[str, ...]:
    found = re.fullmatch(r"(d'?)?([A-Za-zα-ωΑ-Ω]+)('*)(?:_(.+?))?('*)(\([0t]\))?(/dt)?", name)
    if found is None:
        return (name,)
    rate, stem, inner, index, outer, at, end = (x or "" for x in found.groups())
    family = next((f for f in FAMILIES if stem in f and not index), stem)
    return family, inner, outer if index else "", at, end


class Named(dict):
    """Free names of the kind that they have in a meaning."""

    def __init__(self, known: dict[str, Any], suffix: str = "") -> None:
        super().__init__()
        self.known, self.suffix = known, suffix

    def __contains__(self, name: object) -> bool:
        return name in self.known

    def __getitem__(self, name: str) -> Any:
        make = lambda c: sympy.Function(f"{name}{self.suffix}{c}")(t)  # noqa: E731
        if isinstance(self.known[name], sympy.MatrixBase):
            return sympy.Matrix([make(c) for c in "XYZ"])
        return make("")


def free(meaning: Meaning) -> Meaning:
    """The same names without a meaning."""
    elements = [] if callable(meaning.elements) else meaning.elements
    return Meaning(
        Named(dict(meaning.names)),
        [(sympy.Function(f"mass{i}")(t), Named(dict(e), f"_{i}")) for i, (_, e) in enumerate(elements)]
        or _whole,
        [Named(dict(e), f"_{i}") for i, e in enumerate(meaning.loads)],
    )


def _whole(inside: Any) -> Any:
    return sympy.Function("whole")(inside({}))


def difference(relation: Relation, meaning: Meaning) -> tuple[Any, ...]:
    left = evaluate(relation.left, meaning)
    if relation.right.kind == "const":
        return tuple(x.diff(t) for x in components(left))
    right = evaluate(relation.right, meaning)
    return components(left if right == 0 else left - right)


def same(statement: Statement, place: int, new: Print) -> bool:
    """Whether a changed print states the same: every relation a multiple by a number in names that mean nothing, or
    every member of the same value by what its names mean, or of the same leading terms where it is an approximation.
    """
    old = read(statement.rows[place])
    pairs = list(zip(old.relations, new.relations, strict=True))
    if all(proportional(a, b, statement.meanings[0]) for a, b in pairs):
        return True
    condition = statement.condition[1]() if statement.condition else ()
    return all(
        _unchanged(meaning, condition, a, b)
        for meaning in statement.meanings
        for a, b in zip(old.members, new.members, strict=True)
        if a != b
    )


def proportional(old: Relation, new: Relation, meaning: Meaning) -> bool:
    """Whether both differences, in names that mean nothing, are multiples of each other by a number."""
    empty = free(meaning)
    a, b = ([_numerator(x) for x in difference(r, empty)] for r in (old, new))
    if len(a) != len(b):
        return False
    first, second = ({(i, k): v for i, x in enumerate(both) for k, v in terms(x).items()} for both in (a, b))
    if set(first) != set(second):
        return False
    ratios = {second[k] / first[k] for k in first}
    return len(ratios) == 1 and (old.sign in "=≅" or all(r > 0 for r in ratios))


def _numerator(x: Any) -> Any:
    return sympy.fraction(sympy.together(x))[0]


def _unchanged(meaning: Meaning, condition: Any, old: Node, new: Node) -> bool:
    a, b = (components(evaluate(x, meaning)) for x in (old, new))
    if len(a) != len(b):
        return False
    pairs = (*meaning.along, *meaning.steady, *condition)
    if all(is_zero(put(x - y, pairs)) for x, y in zip(a, b, strict=True)):
        return True
    return meaning.small is not None and _same_leading(meaning, old, new)


def _same_leading(meaning: Meaning, old: Node, new: Node) -> bool:
    """Whether each term goes over into the other as the small quantity vanishes: by SymPy's limit of their ratio."""
    small = meaning.small
    assert small is not None
    terms_of = [[evaluate(x, meaning) for x in summands(side)] for side in (old, new)]
    for a, b in zip(*terms_of, strict=True):
        if isinstance(a, sympy.MatrixBase) or a == b:
            continue
        ratio = sympy.simplify(put(b / a, small.pairs))
        if sympy.limit(ratio, small.symbol, 0) != 1:
            return False
    return True
