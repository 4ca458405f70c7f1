"""Functions of one kind: the same operations on other components of the state and other numbers.

The gaps of all pairs of two shapes, or the rows of all corners of a body, are one computation. Such functions share a
body. It reads each component of the state from the place that a table of the function names, and each number from the
function's own part of the constants, where these differ between the functions; what all of them read alike stays as it
is.

A function is an instance of another one if there is a map of the other's nodes to its own that keeps operations and
outputs: it does the same after some of the other's leaves have been replaced, and some made equal. Factors and summands
may be exchanged. Candidates are found by hashes of the trees of operations, whose leaves have no names.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ...scalar.trace import ADD, CODES, INPUT, MUL

FIXED, HOISTED, VARYING = range(3)
"""Kinds of a node: a number, a function of the parameters, a function of time or state."""
TIME = -1
"""As the place of an input."""
LEAST = 32
"""Number of operations from which functions share a body."""
NUMBER, COMPONENT, CLOCK = -1, -2, -3
"""What leaves are: the same at all states, a component of the state, and time."""
_EITHER_WAY = {ADD, MUL, CODES["min"], CODES["max"]}


@dataclass
class Kind:
    """Functions that share the body of one of them.

    ``name``     name of the function whose body it is
    ``numbers``  leaf of the body that differs among the functions -> its place in each one's own part of the constants
    ``places``   input of the body that differs among the functions -> its place in each one's table
    ``members``  name of each function -> nodes of its own part of the constants, and its table
    ``starts``   name of each function -> first place of its own part of the constants
    """

    name: str
    numbers: dict[int, int] = field(default_factory=dict)
    places: dict[int, int] = field(default_factory=dict)
    members: dict[str, tuple[list[int], list[int]]] = field(default_factory=dict)
    starts: dict[str, int] = field(default_factory=dict)


class Nodes:
    """Nodes of a program as trees of operations on leaves: inputs, and what is the same at all states.

    ``does``      operation of each node; those of leaves are less than 0
    ``operands``  of each node, in the order of their trees if they may be exchanged; none of a leaf
    ``trees``     hash of the tree of each node
    """

    def __init__(self, op: Sequence[int], a: Sequence[int], b: Sequence[int], kind: Sequence[int]) -> None:
        self.place = a
        self.does: list[int] = []
        self.operands: list[tuple[int, ...]] = []
        self.trees: list[int] = []
        trees = self.trees
        for code, i, j, given in zip(op, a, b, kind, strict=True):
            operands: tuple[int, ...] = ()
            if given != VARYING:
                code = NUMBER
            elif code == INPUT:
                code = CLOCK if i == TIME else COMPONENT
            else:
                operands = (i,) if j < 0 else (i, j)
                if code in _EITHER_WAY and trees[i] > trees[j]:
                    operands = (j, i)
            self.does.append(code)
            self.operands.append(operands)
            trees.append(hash((code, *(trees[p] for p in operands))))

    def instance(self, general: Sequence[int], special: Sequence[int]) -> dict[int, int] | None:
        """Return what each node of a function is in another one, or None if there is no such map.

        ``general`` and ``special`` are their outputs.
        """
        does, operands, trees = self.does, self.operands, self.trees
        found: dict[int, int] = {}
        waiting = list(zip(general, special, strict=True))
        open_order: list[tuple[int, int]] = []
        while waiting or open_order:
            if not waiting:
                i, j = open_order.pop()
                (p, q), (x, y) = operands[i], operands[j]
                turned = found.get(p) == y or found.get(q) == x
                waiting += ((p, y), (q, x)) if turned else ((p, x), (q, y))
                continue
            i, j = waiting.pop()
            if i in found:
                if found[i] != j:
                    return None
                continue
            if does[i] != does[j]:
                return None
            found[i] = j
            if does[i] in _EITHER_WAY and trees[operands[i][0]] == trees[operands[i][1]]:
                open_order.append((i, j))
                continue
            waiting += zip(operands[i], operands[j], strict=True)
        return found


def kinds_of(nodes: Nodes, functions: Mapping[str, tuple[int, Sequence[int]]]) -> list[Kind]:
    """Return the kinds of functions that have at least two members.

    ``functions`` gives the number of operations and the outputs by name.
    """
    alike: dict[tuple[int, ...], list[str]] = {}
    for name, (_, outputs) in functions.items():
        alike.setdefault(tuple(nodes.trees[i] for i in outputs), []).append(name)
    result = []
    for waiting in alike.values():
        waiting.sort(key=lambda name: -functions[name][0])  # the general ones first
        while len(waiting) > 1:
            first = functions[waiting[0]][1]
            maps = {name: nodes.instance(first, functions[name][1]) for name in waiting}
            found = {name: one for name, one in maps.items() if one is not None}
            if len(found) > 1:
                result.append(_kind(nodes, waiting[0], found))
            waiting = [name for name in waiting if name not in found]
    return result


def _kind(nodes: Nodes, name: str, maps: Mapping[str, Mapping[int, int]]) -> Kind:
    """Return the kind of functions by what the nodes of its body are in each."""
    kind = Kind(name)
    leaves = [
        i for i in sorted(maps[name]) if nodes.does[i] < 0 and len({one[i] for one in maps.values()}) > 1
    ]
    kind.places = {i: k for k, i in enumerate(i for i in leaves if nodes.does[i] != NUMBER)}
    kind.numbers = {i: k for k, i in enumerate(i for i in leaves if nodes.does[i] == NUMBER)}
    for member, one in maps.items():
        kind.members[member] = [one[i] for i in kind.numbers], [nodes.place[one[i]] for i in kind.places]
    return kind
