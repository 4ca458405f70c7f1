"""Breaking a formula into pieces between which a line may end: before relations and sums, also in long brackets.

A piece is never wider than the narrowest column, unless nothing in it can be broken.
"""

from __future__ import annotations

from dataclasses import replace

from .boxes import Box, joined
from .latex import (
    BIN,
    CLOSE,
    OPEN,
    ORD,
    PUNCT,
    REL,
    Fenced,
    Fraction,
    Node,
    Root,
    Row,
    Scripts,
    Space,
    Symbol,
)
from .setting import Atom, Style, atoms, classified, fences, kind_of, opened, setting, spaced

ONE, HALF = Symbol("1", "r", ORD), Fraction(Symbol("1", "r", ORD), Symbol("2", "r", ORD))
SLASH = Symbol("/", "r", ORD)
STYLE = Style()
SHORT = 2500
"""Width of a piece that does not stand alone in a line."""


def pieces(node: Node, width: float, column: float | None = None) -> list[Box]:
    r"""Return a formula as boxes that are to be set side by side, and may go to a new line.

    Brackets wider than ``width`` are opened; fractions and roots are written with brackets if they are wider than the
    ``column``.

    >>> from .latex import parse
    >>> [round(box.width) for box in pieces(parse(r"a = b + c"), 18000)]
    [501, 1741, 1573]
    """
    runs = _runs(atoms(node, STYLE))
    result: list[list[Atom]] = []
    while runs:
        run = runs.pop(0)
        wider = _width(run) > width and _opened(run, width if column is None else column)
        if wider:
            runs = _runs(wider) + runs
        else:
            result.append(run)
    if (
        len(result) > 1
        and result[-1][0].kind == REL
        and _width(result[-1]) < SHORT
        and _width(result[-2] + result[-1]) <= width
    ):
        result[-2:] = [result[-2] + result[-1]]  # no line has nothing but "= 0"
    return _boxes(result)


def _width(run: list[Atom]) -> float:
    return sum(box.width for box in spaced(run, STYLE))


def _runs(row: list[Atom]) -> list[list[Atom]]:
    """Cut a row before relations and sums."""
    result: list[list[Atom]] = [[]]
    for atom in row:
        if result[-1] and (atom.kind in (BIN, REL) or _kind(result[-1][-1]) == PUNCT):
            result.append([])
        result[-1].append(atom)
    return result


def _kind(atom: Atom) -> int | None:
    return None if isinstance(atom.node, Space) else atom.kind


def _boxes(runs: list[list[Atom]]) -> list[Box]:
    """Return the box of each run; the space between two runs belongs to the second."""
    result, start = [], 0
    row = [atom for run in runs for atom in run]
    boxes = spaced(row, STYLE)
    for run in runs:
        result.append(joined(boxes[start : start + len(run)]))
        start += len(run)
    return result


def _opened(run: list[Atom], column: float) -> list[Atom]:
    """Return a run whose widest part is opened, or nothing if no part can be."""
    for k in sorted(range(len(run)), key=lambda k: -run[k].box.width):
        inside = _inside(run[k].node, run[k].box.width > column, column)
        if inside is not None:
            return [*run[:k], *inside, *run[k + 1 :]]
    return []


def _inside(node: Node, wide: bool, column: float) -> list[Atom] | None:
    """Return the atoms of a bracket; of a wide fraction or root the form that has brackets. None of anything else."""
    match node:
        case Fenced():
            return _bracketed(node, None, None, column)
        case Scripts(base=Fenced() as base):
            return _bracketed(base, node.sub, node.sup, column)
        case Fraction() if wide:
            return _quotient(node)
        case Root(index=None) if wide:
            return _bracketed(Fenced("(", node.body, ")"), None, HALF, column)
        case Row():
            return atoms(node, STYLE)
        case _:
            return None


def _bracketed(node: Fenced, sub: Node | None, sup: Node | None, column: float) -> list[Atom] | None:
    body = atoms(node.body, STYLE)
    if len(_runs(body)) == 1 and not _opened(body, column):
        return None
    left, right = fences(node, setting(node.body, STYLE))
    end: Node = Symbol(node.right, "r", CLOSE)
    if sub is not None or sup is not None:
        mark = setting(Scripts(Fenced(" ", node.body, node.right), sub, sup), STYLE)
        plain = setting(Fenced(" ", node.body, " "), STYLE)
        right = _without(mark, plain.width)
    return [Atom(left, OPEN, Symbol(node.left, "r", OPEN)), *body, Atom(right, CLOSE, end)]


def _without(box: Box, width: float) -> Box:
    """Return what of a box stands right of a width."""
    items = tuple(replace(item, x=item.x - width) for item in box.items if item.x >= width - 1)
    return replace(box, width=box.width - width, own=items, parts=())


def _quotient(node: Fraction) -> list[Atom] | None:
    """Return a wide fraction as a product with brackets: (1/b) (a), or (a)/(b)."""
    top, below = setting(node.top, STYLE).width, setting(node.below, STYLE).width
    if _is_sum(node.below) and (below > top / 2 or node.top == ONE):
        nodes: list[Node] = [_factor(node.top), SLASH, _factor(node.below)]
    elif node.top != ONE:
        nodes = [Fraction(ONE, node.below), _factor(node.top)]
    else:
        return None
    return classified([Atom(setting(x, STYLE), _class(x), x) for part in nodes for x in opened(part)])


def _is_sum(node: Node) -> bool:
    return len(_runs(atoms(node, STYLE))) > 1


def _factor(node: Node) -> Node:
    return Fenced("(", node, ")") if _is_sum(node) else node


def _class(node: Node) -> int:
    return ORD if node is SLASH else kind_of(node)
