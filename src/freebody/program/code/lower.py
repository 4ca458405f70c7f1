"""From a tape to a program: the computations worth doing, in their order.

- Dead code is dropped.
- A subexpression of parameters and constants only is computed once, by the prologue: a *hoisted constant*.
- The hoisted factors of a product are multiplied once, so that one of them remains.
- A division by a hoisted expression, or by one that several divisions share, becomes a product with its reciprocal.
- Sine and cosine of an argument are computed together, and arguments that are ready at the same time are computed side
  by side in one vector (:class:`Group`).
- Functions that do the same with other numbers and components of the state share a body (`kinds`).
"""

from __future__ import annotations

from array import array
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from ...errors import ExpressionError
from ...native.records import WIDTH
from ...scalar.algebra import Scalar
from ...scalar.trace import CODES, CONST, DIV, INPUT, MUL, NEG, NONE, Tape, Traced
from .kinds import FIXED, HOISTED, LEAST, TIME, VARYING, Kind, Nodes, kinds_of

SIN, COS = CODES["sin"], CODES["cos"]
RECIPROCAL = len(CODES)
PROLOGUE = ""
"""Name of the body that computes the hoisted constants."""


@dataclass
class Group:
    """Arguments whose sines and cosines are computed in one vector."""

    arguments: list[int]
    place: int = 0  # place of the first sine in the frame; the cosines follow after `lanes`

    @property
    def lanes(self) -> int:
        """Number of lanes: 1, 2, 4 or 8."""
        return 1 << (len(self.arguments) - 1).bit_length()


@dataclass
class Body:
    """One function: its nodes in the order of their computation, and the nodes of its outputs.

    ``order`` holds nodes, and ``-1 - g`` at the point where group ``g`` is computed.
    """

    name: str
    order: list[int]
    outputs: list[int]
    groups: list[Group]


@dataclass
class Program:
    """Nodes as on a tape, each with its ``kind``. Inputs have their place in the vector that they are read from.

    ``constants``  numbers, by the operand of their nodes
    ``hoisted``    node -> its place in c;  ``given``: node at each place of c
    ``kinds``      of functions that share a body, by the name of each
    """

    op: list[int] = field(default_factory=list)
    a: list[int] = field(default_factory=list)
    b: list[int] = field(default_factory=list)
    kind: list[int] = field(default_factory=list)
    constants: list[float] = field(default_factory=list)
    hoisted: dict[int, int] = field(default_factory=dict)
    given: list[int] = field(default_factory=list)
    bodies: dict[str, Body] = field(default_factory=dict)
    kinds: dict[str, Kind] = field(default_factory=dict)


def lower(
    tape: Tape,
    functions: Mapping[str, Sequence[Scalar]],
    time: Traced | None,
    state: Sequence[Traced],
    parameters: Sequence[Traced],
    alone: Collection[str] = (),
) -> Program:
    """Return the functions as a :class:`Program`, with the prologue as the body named :data:`PROLOGUE`.

    Functions ``alone`` share no body with others.
    """
    program = Program()
    add = _Adder(program)
    places: dict[int, tuple[int, int]] = {}
    for k, x in enumerate(parameters):
        places[x.index] = (HOISTED, k)
    for k, x in enumerate(state):
        places[x.index] = (VARYING, k)
    if time is not None:
        places[time.index] = (VARYING, TIME)

    op, a, b = tape.op, tape.a, tape.b
    used = tape.used(x for outputs in functions.values() for x in outputs)
    uses, divisions = _counted(tape, functions, used)
    new: dict[int, int] = {}
    for i in used:
        code = op[i]
        if code == CONST:
            new[i] = add.constant(float(tape.constants[a[i]]))
        elif code == INPUT:
            new[i] = _input(add, tape, i, places)
        elif code == DIV:
            new[i] = _quotient(add, new[a[i]], new[b[i]], uses[a[i]] == 1, divisions[b[i]] > 1)
        elif code == MUL:
            new[i] = _product(add, new[a[i]], new[b[i]], uses[a[i]] == 1, uses[b[i]] == 1)
        elif code == NEG and (
            NONE not in (parts := _parts(program, new[a[i]], uses[a[i]] == 1))
        ):  # -(x c) = x (-c)
            new[i] = add(MUL, parts[0], add(NEG, parts[1], NONE, HOISTED), VARYING)
        else:
            p = new[a[i]]
            q = new[b[i]] if b[i] >= 0 else NONE
            kind = program.kind[p]
            if q >= 0 and program.kind[q] > kind:
                kind = program.kind[q]
            new[i] = add(code, p, q, kind)
    for name, outputs in functions.items():
        nodes = [new[x.index] if type(x) is Traced else add.constant(float(x)) for x in outputs]
        program.bodies[name] = _body(program, name, nodes, VARYING)
    _share(program, alone)
    _give_places(program)
    program.bodies[PROLOGUE] = _body(program, PROLOGUE, program.given, HOISTED)
    return program


def _input(add: _Adder, tape: Tape, i: int, places: Mapping[int, tuple[int, int]]) -> int:
    """Return the node of an input, or of a number that is data."""
    name = tape.inputs[tape.a[i]]
    if name in tape.data:
        return add.datum(float(tape.data[name]))
    if i not in places:
        raise ExpressionError(
            "Expected the inputs of the program among its time, state and parameters, got "
            f"'{name}' in none of them. Add it to one of the three."
        )
    kind, place = places[i]
    return add(INPUT, place, kind, kind)


def _share(program: Program, alone: Collection[str]) -> None:
    """Find the functions that share a body: long ones with as many outputs as another one."""
    bodies = {name: body for name, body in program.bodies.items() if name not in alone}
    long = {name: body for name, body in bodies.items() if len(body.order) >= LEAST}
    counts = Counter(len(body.outputs) for body in long.values())
    functions = {
        name: (len(body.order), body.outputs) for name, body in long.items() if counts[len(body.outputs)] > 1
    }
    if functions:
        nodes = Nodes(program.op, program.a, program.b, program.kind)
        program.kinds = {name: kind for kind in kinds_of(nodes, functions) for name in kind.members}


def _counted(
    tape: Tape, functions: Mapping[str, Sequence[Scalar]], used: Sequence[int]
) -> tuple[array[int], array[int]]:
    """Number of uses of each node of a tape, and number of divisions by it."""
    op, a, b = tape.op, tape.a, tape.b
    uses, divisions = array("i", bytes(4 * len(op))), array("i", bytes(4 * len(op)))
    for i in used:
        if op[i] > INPUT:
            uses[a[i]] += 1
            if b[i] >= 0:
                uses[b[i]] += 1
        if op[i] == DIV:
            divisions[b[i]] += 1
    for outputs in functions.values():
        for x in outputs:
            if type(x) is Traced:
                uses[x.index] += 1
    return uses, divisions


class _Adder:
    """Appends nodes to a program, each once."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.memo: dict[tuple[int, int, int], int] = {}
        self.numbers: dict[str, int] = {}

    def __call__(self, code: int, p: int, q: int, kind: int) -> int:
        """Return the place of a node, appended if it is new."""
        key = (code, p, q)
        place = self.memo.get(key)
        if place is None:
            program = self.program
            place = self.memo[key] = len(program.op)
            program.op.append(code)
            program.a.append(p)
            program.b.append(q)
            program.kind.append(kind)
        return place

    def constant(self, value: float) -> int:
        """Return the node of a constant."""
        key = value.hex()
        if key not in self.numbers:
            self.program.constants.append(value)
            self.numbers[key] = self(CONST, len(self.program.constants) - 1, NONE, FIXED)
        return self.numbers[key]

    def datum(self, value: float) -> int:
        """Return the node of a number that is read like a parameter."""
        key = f"datum {value.hex()}"
        if key not in self.numbers:
            self.program.constants.append(value)
            self.numbers[key] = self(CONST, len(self.program.constants) - 1, NONE, HOISTED)
        return self.numbers[key]


def _quotient(add: _Adder, p: int, q: int, p_once: bool, shared: bool) -> int:
    """p / q, or a product with 1 / q if q is hoisted or several divisions share it."""
    program, kinds = add.program, add.program.kind
    if program.op[p] == CONST and program.constants[program.a[p]] == 1:
        return add(RECIPROCAL, q, NONE, kinds[q])
    if shared if kinds[q] == VARYING else kinds[q] < kinds[p]:
        return _product(add, p, add(RECIPROCAL, q, NONE, kinds[q]), p_once, False)
    return add(DIV, p, q, max(kinds[p], kinds[q]))


def _product(add: _Adder, p: int, q: int, p_once: bool, q_once: bool) -> int:
    """p q. Hoisted factors are joined if one is p or q, or a factor of p or q in a product without another use.

    (c₁ x) c₂ = x (c₁ c₂),    (x c₁) (y c₂) = (x y) (c₁ c₂)
    """
    program, kinds = add.program, add.program.kind
    (x, c), (y, d) = _parts(program, p, p_once), _parts(program, q, q_once)
    if c == NONE or d == NONE or (x == NONE and y == NONE):
        return add(MUL, p, q, max(kinds[p], kinds[q]))
    factor = add(MUL, min(c, d), max(c, d), HOISTED)
    varying = y if x == NONE else x if y == NONE else add(MUL, min(x, y), max(x, y), VARYING)
    return add(MUL, varying, factor, VARYING)


def _parts(program: Program, i: int, once: bool) -> tuple[int, int]:
    """(varying factor, hoisted factor) of a product used once; NONE for a missing factor."""
    kinds, a, b = program.kind, program.a, program.b
    if kinds[i] == HOISTED:
        return NONE, i
    if once and kinds[i] == VARYING and program.op[i] == MUL:
        if kinds[a[i]] == HOISTED:
            return b[i], a[i]
        if kinds[b[i]] == HOISTED:
            return a[i], b[i]
    return i, NONE


def _give_places(program: Program) -> None:
    """Give a place in c to what each body reads, then to each function's own numbers of its kind."""
    for name, body in program.bodies.items():
        kind = program.kinds.get(name)
        if kind is None or kind.name == name:
            _collect_hoisted(program, body, kind.numbers if kind else ())
    for name, kind in program.kinds.items():
        kind.starts[name] = len(program.given)
        program.given += kind.members[name][0]


def _collect_hoisted(program: Program, body: Body, others: Collection[int] = ()) -> None:
    """Give a place in c to every hoisted node that the body reads, except ``others``."""
    kind, hoisted = program.kind, program.hoisted
    read: list[int] = []
    for i in body.order:
        read += (program.a[i], program.b[i]) if i >= 0 else body.groups[-1 - i].arguments
    for p in (*read, *body.outputs):
        if p >= 0 and kind[p] == HOISTED and p not in hoisted and p not in others:
            hoisted[p] = len(program.given)
            program.given.append(p)


def _body(program: Program, name: str, outputs: list[int], kind: int) -> Body:
    """Nodes of this kind that the outputs need, with sines and cosines first and in groups."""
    op, a, b, kinds = program.op, program.a, program.b, program.kind
    needed: set[int] = set()
    waiting = list(outputs)
    while waiting:
        i = waiting.pop()
        if i >= 0 and i not in needed and kinds[i] == kind and op[i] > INPUT:
            needed.add(i)
            waiting += a[i], b[i]
    nodes = sorted(needed)

    # level[i]: number of sines on the longest path to node i
    level: dict[int, int] = {}
    levels: list[dict[int, None]] = []
    for i in nodes:
        deepest = level.get(a[i], 0)
        if b[i] >= 0:
            deepest = max(deepest, level.get(b[i], 0))
        if op[i] == SIN or op[i] == COS:
            while len(levels) <= deepest:
                levels.append({})
            levels[deepest][a[i]] = None
            deepest += 1
        if deepest:
            level[i] = deepest
    groups: list[Group] = []
    order: list[int] = []
    done: set[int] = set()
    place = 0
    for arguments in levels:
        _schedule(program, list(arguments), kind, done, order)
        for chunk in _pack(list(arguments)):
            group = Group(chunk, place)
            place += 2 * group.lanes
            order.append(-1 - len(groups))
            groups.append(group)
    for i in nodes:
        if i not in done and op[i] != SIN and op[i] != COS:
            order.append(i)
    return Body(name, order, outputs, groups)


def _pack(arguments: list[int]) -> list[list[int]]:
    """Split arguments into groups of 8; the last group has 8, 4, 2 or 1 lanes."""
    return [arguments[k : k + WIDTH] for k in range(0, len(arguments), WIDTH)]


def _schedule(program: Program, nodes: list[int], kind: int, done: set[int], order: list[int]) -> None:
    """Append these nodes and the nodes that they need to the order, operands first."""
    op, a, b, kinds = program.op, program.a, program.b, program.kind
    stack = nodes[::-1]
    while stack:
        i = stack[-1]
        if i in done or kinds[i] != kind or op[i] <= INPUT or op[i] == SIN or op[i] == COS:
            stack.pop()
            continue
        waiting = [
            p
            for p in (a[i], b[i])
            if p >= 0
            and p not in done
            and kinds[p] == kind
            and op[p] > INPUT
            and op[p] != SIN
            and op[p] != COS
        ]
        if waiting:
            stack.extend(waiting)
            continue
        done.add(i)
        order.append(i)
        stack.pop()
