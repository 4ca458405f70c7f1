"""Expressions of the compiled language: values of LLVM, and the ways on which they are evaluated.

Variables become values of LLVM, which meet in phi nodes where several ways lead to one block (`Ways`).
"""

from __future__ import annotations

import ast
import builtins
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from llvmlite import ir

from .arithmetic import (
    REAL,
    TRUTH,
    WHOLE,
    Refusal,
    cast,
    common_lanes,
    compared,
    element_of,
    is_number,
    kind_of,
    lanes_of,
    negated,
    operated,
    opposite,
    wide,
)
from .functions import (
    EQUIVALENTS,
    Compiled,
    Inlined,
    Instruction,
    components,
    is_wide,
    rare,
    type_of,
    unrolled,
    variable,
)
from .record_access import RecordPointer, Table, assigned_place, field_of, is_record
from .record_access import value as field_value
from .records import Record
from .rows import Components

_UNLIKELY = (1, 1 << 20)
"""Weights of the ways of a branch on ``rare(c)``."""


def is_kernel(value: Any) -> bool:
    """Return whether a value is the address of a kernel."""
    kind = kind_of(value)
    return isinstance(kind, ir.PointerType) and isinstance(kind.pointee, ir.FunctionType)


def in_memory(builder: Any, t: Any) -> Any:
    """The first argument of a kernel: the time of one run, or a pointer to those of several."""
    return t if lanes_of(t.type) == 1 else variable(builder, t)


def statements(node: ast.AST) -> Iterator[ast.AST]:
    """A statement or a module, and all statements in it: their expressions are twenty times as many."""
    waiting = [node]
    while waiting:
        node = waiting.pop()
        yield node
        for name in ("body", "orelse", "finalbody", "handlers", "cases"):
            waiting += getattr(node, name, ())


@cache
def assigned(node: ast.stmt) -> tuple[ast.expr, ...]:
    """What a statement assigns to: names, components, fields."""
    targets: list[Any] = []
    for x in statements(node):
        targets += getattr(x, "targets", None) or [
            target for target in [getattr(x, "target", None)] if target
        ]
    for target in targets:
        if isinstance(target, ast.Tuple):
            targets += target.elts
    return tuple(targets)


class Join:
    """A block, and the ways that lead to it: the last block of each, and the values of its variables."""

    def __init__(self) -> None:
        self.block: Any = None
        self.ways: list[tuple[Any, dict[str, Any]]] = []


class Ways:
    """The blocks of one function during its translation, and the variables on each way."""

    builder: Any
    tree: ast.FunctionDef
    file: str
    has_width: bool
    values: dict[str, Any]
    kinds: dict[str, Any]

    def refused(self, node: Any, expected: str, cure: str, got: str = "") -> TypeError:
        """Error that names the construct that cannot be translated, with its file, its line and the cure."""
        got = got or f"'{ast.unparse(node).splitlines()[0]}'"
        return TypeError(
            f"Expected {expected} in '{self.tree.name}', which is to be machine code, got {got} "
            f"({Path(self.file).name}, line {node.lineno}). {cure}"
        )

    def goto(self, join: Join) -> None:
        """End this block with a branch to another."""
        self._lead(join)
        self.builder.branch(join.block)

    def fork(self, truth: Any, yes: Join, no: Join, rare: bool = False) -> None:
        """End this block with a branch to one of two others."""
        for join in (yes, no):
            self._lead(join)
        self.builder.cbranch(truth, yes.block, no.block, _UNLIKELY if rare else ())

    def _lead(self, join: Join) -> None:
        join.block = join.block or self.builder.append_basic_block()
        join.ways.append((self.builder.block, dict(self.values)))

    def enter(self, join: Join) -> bool:
        """Continue at a block with the variables that have a value on every way to it; False if no way leads there."""
        if not join.ways:
            return False
        self.builder.position_at_end(join.block)
        (_, first), *others = join.ways
        if not others:
            self.values = first
            return True
        self.values = {}
        for name, value in first.items():
            if all([values.get(name) is value for _, values in others]):
                self.values[name] = value
            elif not is_number(value) and not isinstance(value, tuple) and all(name in x for _, x in others):
                self.values[name] = result = self.builder.phi(value.type)
                for block, values in join.ways:
                    result.add_incoming(values[name], block)
        return True

    def head(self, node: ast.stmt) -> tuple[Any, dict[str, Any]]:
        """Begin a loop: its first block, and the meetings there of the variables that it changes."""
        names = set()
        for x in assigned(node):
            target = x.value if isinstance(x, ast.Subscript) and self.is_name_of_lanes(x.value) else x
            if isinstance(target, ast.Name):
                names.add(target.id)
        before, head = self.builder.block, self.builder.append_basic_block()
        self.builder.branch(head)
        self.builder.position_at_end(head)
        meetings = {}
        for name in [name for name in self.values if name in names]:
            if isinstance(self.values[name], tuple):
                del self.values[name]
                continue
            meetings[name] = self.builder.phi(self.kinds[name])
            meetings[name].add_incoming(self.values[name], before)
            self.values[name] = meetings[name]
        return head, meetings

    def back(self, head: Any, meetings: dict[str, Any]) -> None:
        """Repeat a loop from its first block."""
        for name, meeting in meetings.items():
            meeting.add_incoming(self.values[name], self.builder.block)
        self.builder.branch(head)

    def is_of_lanes(self, value: Any) -> bool:
        """Return whether a value is a number in each lane, or the only one in a function that may have lanes."""
        kind = getattr(value, "type", None)
        return lanes_of(kind) > 1 if not self.has_width else element_of(kind) in (REAL, WHOLE, TRUTH)

    def is_name_of_lanes(self, node: ast.expr) -> bool:
        """Return whether an expression is the name of a number in each lane."""
        return isinstance(node, ast.Name) and self.is_of_lanes(self.values.get(node.id))

    def finish(self, after: Join) -> None:
        """Go to a block unless this one has gone elsewhere."""
        if not self.builder.block.is_terminated:
            self.goto(after)


class Expressions(Ways):
    """The expressions of one function."""

    unit: Any
    lanes: int
    locals: set[str]
    space: dict[str, Any]
    in_components: bool

    def place(self, node: ast.expr) -> Any:
        """Pointer to a component, to a field, or to the number of one of these in a lane."""
        if isinstance(node, ast.Attribute):
            pointer = self.value(node.value)
            if is_record(pointer):
                return assigned_place(self.builder, pointer, node.attr)
        if isinstance(node, ast.Subscript):
            array = self.value(node.value)
            return self.of_lane(node) if self.is_of_lanes(array) else self.component(node, array)
        cure = "Assign to a name, to a component p[i] of an argument, or to a field of a record."
        raise self.refused(node, "a name that has a value, or a component of an array", cure)

    def component(self, node: ast.Subscript, pointer: Any) -> Any:
        """Pointer to a component of an array or of several rows."""
        index = node.slice
        if isinstance(pointer, Table):
            if not isinstance(index, ast.Tuple) or len(index.elts) != 2:
                raise self.refused(node, "two indices of a component", "Write [j, i].")
            row, index = index.elts
            pointer = pointer.row(self.builder, self.index(row))
        if not isinstance(kind_of(pointer), ir.PointerType) or is_record(pointer):
            raise self.refused(node, "an array that has components", "Arrays and rows of records have them.")
        if isinstance(index, ast.Name) and isinstance(self.values.get(index.id), Components):
            return self.values[index.id].of(pointer)
        return self.builder.gep(pointer, [self.index(index)])

    def of_lane(self, node: ast.Subscript) -> Any:
        """Pointer to the number of a component or a field in a lane."""
        place = self.place(node.value)
        lane = self.index(node.slice)
        return self.builder.gep(
            self.builder.bitcast(place, element_of(place.type.pointee).as_pointer()), [lane]
        )

    def index(self, node: ast.expr) -> Any:
        """Place in an array, whose length is not known here: it counts from the first number."""
        place = self.value(node)
        if is_number(place) and place < 0:
            cure = "An array in memory has no end to count from: write the place from its begin."
            raise self.refused(node, "a place from 0 on", cure)
        return self.cast(node, place, WHOLE)

    def load(self, place: Any) -> Any:
        """Load the number, or the number of each lane, at a place."""
        return self.builder.load(place, align=8) if lanes_of(place.type) > 1 else self.builder.load(place)

    # -- conditions --

    def constant_truth(self, node: ast.expr) -> bool | None:
        """Truth value of a condition that does not depend on the arguments; None if it does."""
        if isinstance(node, ast.BoolOp):
            decisive, open_parts = isinstance(node.op, ast.Or), []
            for part in node.values:
                truth = self.constant_truth(part)
                if truth is None:
                    open_parts.append(part)
                elif truth is decisive:  # what is called before it may write to memory
                    calls = any(isinstance(x, ast.Call) for part in open_parts for x in ast.walk(part))
                    return None if calls else decisive
            return None if open_parts else not decisive
        return None if self.varies(node) else bool(self.value(node))

    def varies(self, node: ast.AST) -> bool:
        """Return whether an expression is known only in the running code."""
        if isinstance(node, ast.Name):
            return node.id in self.locals
        if isinstance(node, (ast.Call, ast.Subscript)):
            return True
        if isinstance(node, ast.Attribute):
            return self.varies(node.value)
        if isinstance(node, ast.Compare):
            return self.varies(node.left) or any(map(self.varies, node.comparators))
        if isinstance(node, ast.Constant):
            return False
        return any(isinstance(part, ast.expr) and self.varies(part) for part in ast.iter_child_nodes(node))

    def branch(self, node: ast.expr, yes: Join, no: Join, unlikely: bool = False) -> None:
        """Branch to one of two blocks; the parts after a decisive one are not evaluated."""
        truth = self.constant_truth(node)
        if truth is not None:
            self.goto(yes if truth else no)
        elif isinstance(node, ast.BoolOp):
            *rest, last = node.values
            for part in rest:
                further = Join()
                if isinstance(node.op, ast.And):
                    self.branch(part, further, no)
                else:
                    self.branch(part, yes, further)
                if not self.enter(further):
                    return
            self.branch(last, yes, no)
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            self.branch(node.operand, no, yes)
        elif isinstance(node, ast.Call) and self.value(node.func) is rare and len(node.args) == 1:
            self.branch(node.args[0], yes, no, unlikely=True)
        else:
            value = self.value(node)
            if isinstance(value, bool):
                self.goto(yes if value else no)
            else:
                self.fork(self.truth(node, value), yes, no, unlikely)

    def truth(self, node: ast.expr, value: Any) -> Any:
        """One truth value as an LLVM value."""
        return self.cast(node, value, TRUTH)

    # -- values --

    def value(self, node: ast.expr) -> Any:
        """An LLVM value, or a Python constant if it is known at compile time."""
        write = getattr(self, f"_{type(node).__name__}", None)
        if write is None:
            cure = "Expressions are numbers, names, p[i], operations, comparisons, a if c else b and calls."
            raise self.refused(node, "an expression of the compiled language", cure)
        try:
            return write(node)
        except Refusal as refusal:
            raise self.refused(node, refusal.expected, refusal.cure, refusal.got) from None

    def cast(self, node: Any, value: Any, kind: Any) -> Any:
        """The value of a node as an LLVM value of this type."""
        try:
            return cast(self.builder, value, kind)
        except Refusal as refusal:
            got = f"{refusal.got}, '{ast.unparse(node).splitlines()[0]}'"
            raise self.refused(node, refusal.expected, refusal.cure, got) from None

    def _Constant(self, node: ast.Constant) -> Any:
        return node.value

    def _Name(self, node: ast.Name) -> Any:
        if node.id in self.values:
            return self.values[node.id]
        if node.id in self.kinds:
            cure = f"Give '{node.id}' a value before the branch or the loop."
            raise self.refused(node, "a name that has a value on every way to here", cure)
        if node.id in self.locals or node.id not in self.space and not hasattr(builtins, node.id):
            raise self.refused(node, "a name that has a value", f"Assign '{node.id}' before, or import it.")
        return self.space.get(node.id, getattr(builtins, node.id, None))

    def _Attribute(self, node: ast.Attribute) -> Any:
        module = self.value(node.value)
        if is_record(module):
            return field_value(self.builder, module, field_of(module, node.attr))
        is_value = isinstance(module, tuple) and node.attr in getattr(module, "_fields", ())
        if not is_value and (not isinstance(module, ModuleType) or not hasattr(module, node.attr)):
            cure = "Modules, records and named tuples have names; give the value a name outside the function."
            raise self.refused(node, "a name of a module, or a field of a record", cure)
        return getattr(module, node.attr)

    def _Tuple(self, node: ast.Tuple) -> Any:
        return tuple(self.value(element) for element in node.elts)

    def _Subscript(self, node: ast.Subscript) -> Any:
        if isinstance(node.slice, ast.Slice):
            return self.later_part(node, node.slice)
        array = self.value(node.value)
        if isinstance(array, Table) and not isinstance(node.slice, ast.Tuple):
            return array.row(self.builder, self.index(node.slice))
        if is_record(array):
            size = array.type.record.size
            distance = operated(self.builder, ast.Mult, self.index(node.slice), size)
            first = self.builder.bitcast(array, ir.IntType(8).as_pointer())
            return self.builder.bitcast(self.builder.gep(first, [distance]), array.type)
        if isinstance(array, tuple | dict) and not isinstance(array, Table):
            return self.of_constants(node, array)
        if self.is_of_lanes(array):
            if isinstance(node.value, ast.Subscript | ast.Attribute):  # in memory: only this number is loaded
                return self.load(self.of_lane(node))
            lane = self.index(node.slice)
            return array if lanes_of(array.type) == 1 else self.builder.extract_element(array, lane)
        if isinstance(node.value, ast.Name) and node.value.id not in self.locals:
            return self.of_table(node, node.value.id)
        return self.load(self.component(node, array))

    def later_part(self, node: ast.Subscript, part: ast.Slice) -> Any:
        """The row that begins inside a row, ``row[k:]``."""
        row = self.value(node.value)
        pointer = isinstance(kind_of(row), ir.PointerType) and not is_record(row)
        if not pointer or part.lower is None or part.upper is not None or part.step is not None:
            raise self.refused(node, "the rest of an array", "Write row[k:].")
        return self.builder.gep(row, [self.index(part.lower)])

    def of_constants(self, node: ast.Subscript, constants: Any) -> Any:
        """Element of a tuple or a dictionary of the module."""
        place = self.value(node.slice)
        try:
            if is_number(place):
                return constants[place]
        except LookupError:
            cure = f"There are {len(constants)} elements."
            raise self.refused(node, "a place in these constants", cure, f"{place}") from None
        cure = "unrolled(...) gives constants; a table of NumPy has places that vary."
        raise self.refused(node, "a constant place", cure)

    def of_table(self, node: ast.Subscript, name: str) -> Any:
        """Number of a table."""
        table = self.value(node.value)
        if not isinstance(table, np.ndarray):
            raise self.refused(node, "a table of numbers", "np.array(...) outside the function makes one.")
        places = self.value(node.slice)
        places = places if isinstance(places, tuple) else (places,)
        if len(places) != table.ndim:
            cure = f"The table has shape {table.shape}."
            raise self.refused(node, f"{table.ndim} places in the table '{name}'", cure)
        at: Any = 0
        for place, length in zip(places, table.shape, strict=True):
            if is_number(place) and not 0 <= place < length:
                cure = "Write the place from the begin; runs of the code do not check it."
                raise self.refused(node, f"a place from 0 to {length - 1}", cure)
            at = operated(self.builder, ast.Add, operated(self.builder, ast.Mult, at, length), place)
        at = self.cast(node.slice, at, WHOLE)
        return self.builder.load(self.builder.gep(self.unit.table(table, name), [WHOLE(0), at]))

    def _UnaryOp(self, node: ast.UnaryOp) -> Any:
        value = self.value(node.operand)
        if isinstance(node.op, ast.Not):
            return negated(self.builder, value)
        if isinstance(node.op, ast.USub):
            return opposite(self.builder, value)
        raise self.refused(node, "a sign of a number, or 'not' of a truth value", "-1 - k is ~k.")

    def _BinOp(self, node: ast.BinOp) -> Any:
        left = self.value(node.left)
        return operated(self.builder, type(node.op), left, self.value(node.right))

    def _Compare(self, node: ast.Compare) -> Any:
        """Truth value of a chain of comparisons; what stands after one that does not hold is not evaluated."""
        a, result = self.value(node.left), True
        no, after = Join(), Join()
        for operation, operand in zip(map(type, node.ops), node.comparators, strict=True):
            known = result is True
            if not known and lanes_of(kind_of(result)) > 1:
                self.without_calls(operand)
            elif not known and any(isinstance(x, ast.Call | ast.Subscript) for x in ast.walk(operand)):
                further = Join()
                self.fork(self.truth(node, result), further, no)
                self.enter(further)
                result = True
            b = self.value(operand)
            holds = self.compared(operation, a, b)
            result = holds if result is True else operated(self.builder, ast.BitAnd, result, holds)
            a = b
        if not no.ways:
            return result
        yes = Join()
        self.goto(yes)
        return self.met([(yes, lambda: result), (no, lambda: False)], after, node)

    def compared(self, operation: type, a: Any, b: Any) -> Any:
        """Truth value of a comparison of two numbers, or of a kernel with None."""
        if operation in (ast.Is, ast.IsNot) and b is None:
            if isinstance(kind_of(a), ir.PointerType):
                sign = "==" if operation is ast.Is else "!="
                return self.builder.icmp_unsigned(sign, a, kind_of(a)(None))
            if kind_of(a) is None:  # a constant of the module
                return (a is None) is (operation is ast.Is)
        return compared(self.builder, operation, a, b)

    def _BoolOp(self, node: ast.BoolOp) -> Any:
        """The operand that decides, as in Python: a truth value unless the other operands are constants."""
        decisive, operands = isinstance(node.op, ast.Or), list(node.values)
        while len(operands) > 1 and (truth := self.constant_truth(operands[0])) is not None:
            if truth is decisive:
                break
            operands.pop(0)
        first, *rest = operands
        if not rest or self.constant_truth(first) is decisive:
            return self.value(first)
        for operand in rest:
            if self.constant_truth(operand) is not None and not isinstance(self.value(operand), bool):
                raise self.refused(operand, "a truth value", "Write a if c else b.")
        a = self.value(first)
        if lanes_of(kind_of(a)) > 1:
            return self.lane_by_lane(node, a, rest)
        yes, no, after = Join(), Join(), Join()
        further = Join()
        self.fork(self.truth(first, a), *((yes, further) if decisive else (further, no)))
        self.enter(further)
        remaining = rest[0] if len(rest) == 1 else ast.copy_location(ast.BoolOp(node.op, rest), node)
        self.branch(remaining, yes, no)
        return self.met([(yes, lambda: True), (no, lambda: False)], after, node)

    def lane_by_lane(self, node: ast.BoolOp, a: Any, rest: Sequence[ast.expr]) -> Any:
        """And, or in each lane: all operands are evaluated."""
        operation = ast.BitOr if isinstance(node.op, ast.Or) else ast.BitAnd
        for operand in rest:
            self.without_calls(operand)
            a = operated(self.builder, operation, a, self.value(operand))
        return a

    def without_calls(self, operand: ast.expr) -> None:
        """Refuse an operand that calls a function, which may write to memory, if some lanes do not need it."""
        calls = (x for x in ast.walk(operand) if isinstance(x, ast.Call))
        if any(isinstance(self.value(call.func), Compiled) for call in calls):
            cure = "It would be called for the lanes that are decided, too: give its result a name first."
            raise self.refused(operand, "operands without calls of functions", cure)

    def _IfExp(self, node: ast.IfExp) -> Any:
        truth = self.constant_truth(node.test)
        if truth is not None:
            return self.value(node.body if truth else node.orelse)
        yes, no, after = Join(), Join(), Join()
        self.branch(node.test, yes, no)
        ways = [(yes, lambda: self.value(node.body)), (no, lambda: self.value(node.orelse))]
        return self.met(ways, after, node)

    def met(self, ways: Sequence[tuple[Join, Callable[[], Any]]], after: Join, node: ast.expr) -> Any:
        """One of several values; only that one is evaluated."""
        builder, ends = self.builder, []
        for join, value in ways:
            if self.enter(join):
                ends.append((value(), builder.block))
        values = [value for value, _ in ends]
        kinds = [*map(kind_of, values)]
        if None in kinds or any(isinstance(kind, ir.VoidType) for kind in kinds):
            raise self.refused(node, "two numbers or two arrays", "Use an if statement.")
        kind = kinds[0]
        if not isinstance(kind, ir.PointerType):
            elements = [*map(element_of, kinds)]
            kind = wide(REAL if REAL in elements else elements[0], common_lanes(*values))
        arrivals = []
        for value, end in ends:
            builder.position_at_end(end)
            arrivals.append((self.cast(node, value, kind), end))
            self.goto(after)
        self.enter(after)
        if len(arrivals) == 1:
            return arrivals[0][0]
        result = builder.phi(kind)
        for value, end in arrivals:
            result.add_incoming(value, end)
        return result

    def _Call(self, node: ast.Call) -> Any:
        function = self.value(node.func)
        if isinstance(function, Callable) and function in EQUIVALENTS:  # type: ignore[arg-type]
            function = EQUIVALENTS[function]
        values = [self.value(argument) for argument in node.args]
        kinds: tuple[Any, ...]
        if function is unrolled or function is components:
            cure = "Write for i in unrolled(1, 12), or for i in components(n)."
            raise self.refused(node, "a loop over unrolled(...) or components(n)", cure)
        if isinstance(function, Instruction):
            kinds = function.kinds
        elif isinstance(function, Compiled):
            kinds = tuple(function.arguments)
        elif is_kernel(function):
            kinds = ("Real", "Row", "Row", "Row")
        elif isinstance(function, type) and issubclass(function, Record):
            kinds = ("Row",) if function.widths else ("Reals",)
        else:
            cure = "Make it one with @compiled, or use an instruction of freebody.native."
            raise self.refused(node, "a function that is compiled", cure)
        if len(kinds) != len(values) or node.keywords:
            cure = "Pass each by position."
            raise self.refused(node, f"{len(kinds)} argument{'s'[: len(kinds) != 1]}", cure)
        if self.in_components and any(isinstance(kind_of(value), ir.PointerType) for value in values):
            cure = "What it reads or writes may be of another component."
            raise self.refused(node, "arguments that are numbers, in a loop over components", cure)
        lanes = self.width_of_call(function, values, kinds)
        arguments = [
            value
            if isinstance(value, tuple | dict)
            else self.cast(argument, value, type_of(kind, lanes) or kind_of(value))
            for argument, value, kind in zip(node.args, values, kinds, strict=True)
        ]
        if isinstance(function, Instruction):
            return function.write(self.builder, *arguments)
        if isinstance(function, Inlined):
            return self.unit.inlined(function, arguments, self.builder, lanes)
        if isinstance(function, type):
            record = function.of(lanes)  # type: ignore[attr-defined]
            return self.builder.bitcast(arguments[0], RecordPointer(record))
        if not isinstance(function, Compiled):
            return self.builder.call(function, [in_memory(self.builder, arguments[0]), *arguments[1:]])
        return self.builder.call(self.unit.declare(function, lanes), arguments)

    def width_of_call(self, function: Any, values: Sequence[Any], kinds: Sequence[Any]) -> int:
        """Number of lanes of a call: that of the arguments of wide types; without such arguments, of the caller."""
        if is_kernel(function):
            return lanes_of(function.type.pointee.args[1])
        of_lanes = [value for value, kind in zip(values, kinds, strict=True) if kind and is_wide(kind)]
        if not of_lanes:
            return self.lanes
        counts = {lanes_of(kind_of(value)) for value in of_lanes} - {1}
        if len(counts) > 1:
            raise Refusal("arguments of one width", "One number is passed to all lanes.", f"{sorted(counts)}")
        return counts.pop() if counts else 1
