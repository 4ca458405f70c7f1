"""Translation of functions of numbers and of arrays in memory from Python's syntax into LLVM's.

Compiled loops are written in a small part of Python. Each of its statements corresponds to instructions of a processor:

    integers, real numbers and truth values, and pointers to numbers, p[i] and p[i:];  + - * / // % << **, abs,
    comparisons, and, or, not, a if c else b, several names at once, if, while, for over range, break, continue, return,
    calls; records (`records`): run.t, run.y[i], run.k[j], run.k[j, i], run.rates(t, y, c, out), run.rates is None

A variable has the type of its first value. Integers become real numbers where needed, never the reverse. Globals are
constants: numbers, tables (NumPy arrays), other functions of this kind, and instructions. Expressions of globals alone
are evaluated during translation, and a branch that they exclude is not translated. A function may call `Compiled` and
`Instruction` objects; any other call is refused.

Arithmetic is that of the processor: divisions by zero give infinities or nan, and integers have 64 bits.

The file is longer than others: it defines one language in one place.
"""

from __future__ import annotations

import ast
import builtins
import math
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache, partial
from itertools import pairwise
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from llvmlite import ir

from . import record_access
from .records import Record

REAL, WHOLE, TRUTH = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
TYPES = {
    "None": ir.VoidType(),
    "int": WHOLE,
    "float": REAL,
    "Reals": REAL.as_pointer(),
    "Integers": WHOLE.as_pointer(),
}
"""LLVM type of an argument or a result, by its annotation."""

_OF_REALS = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}
_OF_INTEGERS = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul", ast.LShift: "shl"}
_OF_PYTHON: dict[type, Callable[..., Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.LShift: operator.lshift, ast.Pow: operator.pow,
    ast.Eq: operator.eq, ast.NotEq: operator.ne, ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}  # fmt: skip
_COMPARED = {ast.Eq: "==", ast.NotEq: "!=", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">="}


class Compiled:
    """A function to be translated, with the types of its annotations."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function
        *self.arguments, self.result = function.__annotations__.values()

    def types(self) -> list[Any]:
        """LLVM types of the arguments."""
        return [_typed(argument, self) for argument in self.arguments]

    def __call__(self, *arguments: Any) -> Any:
        """Raise an error: only compiled code can call this object."""
        raise TypeError(
            f"Expected compiled code to call '{self.function.__name__}', got a call from Python. "
            "freebody.native.loop has the functions for Python."
        )


def _typed(annotation: Any, compiled: Compiled) -> Any:
    """LLVM type of an annotation of a function."""
    try:
        return record_access.typed(annotation, TYPES, compiled.function.__globals__)
    except KeyError:
        code = compiled.function.__code__
        raise TypeError(
            f"Expected {', '.join(TYPES)} or a record as the type of an argument or a result of "
            f"'{compiled.function.__name__}', got {annotation!r} ({Path(code.co_filename).name}, line "
            f"{code.co_firstlineno}). Annotate it, and import the record into this file."
        ) from None


class Instruction:
    """A call that is replaced by instructions: ``write(builder, *values)`` writes them and returns the result.

    The result is an LLVM value or None. ``kinds`` are the types of the arguments (`TYPES`); "" accepts any type.
    """

    def __init__(self, write: Callable[..., Any], *kinds: str) -> None:
        self.write, self.kinds = write, kinds

    def __call__(self, *arguments: Any) -> Any:
        """Raise an error: only compiled code can call this object."""
        raise TypeError(f"Expected compiled code to call '{self.write.__name__}', got a call from Python.")


def instruction(*kinds: str) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that makes an `Instruction` with arguments of these kinds."""
    return lambda write: Instruction(write, *kinds)


# -- building blocks of instructions -------------------------------------------------------------------


def called(builder: Any, name: str, result: Any, *values: Any) -> Any:
    """Call an intrinsic function of LLVM and return its result."""
    function = builder.module.globals.get(name)
    if function is None:
        kind = ir.FunctionType(result, [value.type for value in values])
        function = ir.Function(builder.module, kind, name)
    return builder.call(function, values)


def variable(builder: Any, value: Any) -> Any:
    """Pointer to local memory of the function, set to this value."""
    with builder.goto_entry_block():
        place = builder.alloca(value.type)
    builder.store(value, place)
    return place


@contextmanager
def counted(builder: Any, stop: Any, step: int) -> Iterator[Any]:
    """Write a loop around the body of the context, whose value is the counter: 0, step, … below ``stop``."""
    with _loop(builder, WHOLE(0), stop, step) as (number, _, _):
        yield number


@contextmanager
def _loop(builder: Any, start: Any, stop: Any, step: int) -> Iterator[tuple[Any, Any, Any]]:
    """Write a loop around the body of the context: (counter, block that continues the loop, block after it)."""
    place = variable(builder, start)
    head, body, again, done = (builder.append_basic_block() for _ in range(4))
    builder.branch(head)
    builder.position_at_end(head)
    number = builder.load(place)
    builder.cbranch(builder.icmp_signed("<" if step > 0 else ">", number, stop), body, done)
    builder.position_at_end(body)
    yield number, again, done
    if not builder.block.is_terminated:
        builder.branch(again)
    builder.position_at_end(again)
    builder.store(builder.add(number, WHOLE(step)), place)
    builder.branch(head)
    builder.position_at_end(done)


@instruction("float")
def _absolute(builder: Any, x: Any) -> Any:
    return called(builder, "llvm.fabs.f64", REAL, x)


@instruction("float")
def _finite(builder: Any, x: Any) -> Any:
    return builder.fcmp_ordered("<", called(builder, "llvm.fabs.f64", REAL, x), REAL(math.inf))


@instruction("float")
def _logarithm2(builder: Any, x: Any) -> Any:
    return called(builder, "llvm.log2.f64", REAL, x)


_EQUIVALENTS = {abs: _absolute, math.isfinite: _finite, math.log2: _logarithm2}
"""Instructions that stand for functions of Python."""


# -- a module ------------------------------------------------------------------------------------------


def translated(functions: Mapping[str, Compiled]) -> str:
    """LLVM text of functions under these names, and of all functions that they call."""
    unit = _Unit()
    for name, function in functions.items():
        unit.declare(function, name)
    while unit.waiting:
        _Body(unit, *unit.waiting.pop()).write()
    return str(unit.module)


class _Unit:
    """The functions of one module, each translated once."""

    def __init__(self) -> None:
        self.module = ir.Module()
        self.waiting: list[tuple[Compiled, Any]] = []
        self._declared: dict[int, Any] = {}
        self._tables: dict[int, Any] = {}

    def declare(self, compiled: Compiled, name: str = "") -> Any:
        """Declare a function, which is translated later. A function without a name stays internal to the module."""
        if id(compiled) not in self._declared:
            kind = ir.FunctionType(_typed(compiled.result, compiled), compiled.types())
            internal = f"{compiled.function.__name__}.{len(self._declared)}"
            function = ir.Function(self.module, kind, name or internal)
            if not name:
                function.linkage = "internal"
            # calls are not inlined: large modules then compile quickly, and where products and sums are fused does not
            # depend on the caller
            function.attributes.add("noinline")
            function.attributes.add("nounwind")
            self._declared[id(compiled)] = function
            self.waiting.append((compiled, function))
        return self._declared[id(compiled)]

    def table(self, numbers: Any) -> Any:
        """A constant array of real numbers in memory."""
        if id(numbers) not in self._tables:
            kind = ir.ArrayType(REAL, numbers.size)
            table = ir.GlobalVariable(self.module, kind, f"table.{len(self._tables)}")
            table.linkage, table.global_constant = "internal", True
            table.initializer = kind([REAL(float(x)) for x in numbers.flat])
            self._tables[id(numbers)] = table, numbers  # the reference keeps the id valid
        return self._tables[id(numbers)][0]


@cache
def _syntax(file: str) -> dict[int, ast.FunctionDef]:
    """Functions of a file by their first line, decorators included."""
    tree = ast.parse(Path(file).read_bytes())
    return {
        min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)]): node
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef)
    }


def _kind(value: Any) -> Any:
    """LLVM type of an LLVM value or of a Python number."""
    for python, kind in ((bool, TRUTH), (int, WHOLE), (float, REAL)):
        if isinstance(value, python):
            return kind
    return getattr(value, "type", None)


def _is_row(value: Any) -> bool:
    """Whether a value points to numbers."""
    return _kind(value) in (TYPES["Reals"], TYPES["Integers"])


class _Body:
    """One function during its translation."""

    def __init__(self, unit: _Unit, compiled: Compiled, function: Any) -> None:
        code = compiled.function.__code__
        self.unit, self.file, self.space = unit, code.co_filename, compiled.function.__globals__
        self.tree = _syntax(code.co_filename)[code.co_firstlineno]
        self.locals = set(code.co_varnames)
        self.variables: dict[str, Any] = {}
        self.loops: list[tuple[Any, Any]] = []
        self.entry = function.append_basic_block()
        self.builder = ir.IRBuilder(self.entry)
        self.result = function.function_type.return_type
        self.arguments = function.args

    def write(self) -> None:
        """Translate the function."""
        begin = self.builder.append_basic_block()
        self.builder.position_at_end(begin)
        for name, value in zip(self.tree.args.args, self.arguments, strict=True):
            self.variables[name.arg] = variable(self.builder, value)
        self.block(self.tree.body)
        if not self.builder.block.is_terminated:
            if isinstance(self.result, ir.VoidType):
                self.builder.ret_void()
            else:
                self.builder.unreachable()
        self.builder.position_at_end(self.entry)
        self.builder.branch(begin)

    def refused(self, node: Any, expected: str, got: str = "") -> TypeError:
        """Error that names the construct that cannot be translated, with its file and line."""
        got = got or f"'{ast.unparse(node).splitlines()[0]}'"
        return TypeError(
            f"Expected {expected} in '{self.tree.name}', which is to be machine code, got {got} "
            f"({Path(self.file).name}, line {node.lineno})."
        )

    # -- statements --

    def block(self, statements: Sequence[ast.stmt]) -> None:
        """Translate statements, up to the first that leaves the block."""
        for statement in statements:
            if self.builder.block.is_terminated:
                return
            write = getattr(self, f"_{type(statement).__name__}", None)
            if write is None:
                raise self.refused(statement, "a statement of the compiled language")
            write(statement)

    def _Expr(self, node: ast.Expr) -> None:
        if not isinstance(node.value, ast.Constant):
            self.value(node.value)

    def _Assign(self, node: ast.Assign) -> None:
        value = self.value(node.value)
        for target in node.targets:
            self.put(target, value)

    def _AugAssign(self, node: ast.AugAssign) -> None:
        place = self.place(node.target)
        self.store(node, self.operated(node, node.op, self.load(place), self.value(node.value)), place)

    def put(self, target: ast.expr, value: Any) -> None:
        """Assign a value to a name, a component of an array, or a tuple of these."""
        if isinstance(target, ast.Tuple):
            if not isinstance(value, tuple) or len(value) != len(target.elts):
                raise self.refused(target, "as many values as names")
            for element, part in zip(target.elts, value, strict=True):
                self.put(element, part)
        elif isinstance(target, ast.Name) and target.id not in self.variables:
            kind = _kind(value)
            if kind is None or isinstance(kind, ir.VoidType):
                raise self.refused(target, f"a number or a pointer for '{target.id}'", f"{value!r}")
            self.variables[target.id] = variable(self.builder, self.cast(target, value, kind))
        else:
            self.store(target, value, self.place(target))

    def place(self, node: ast.expr) -> Any:
        """Pointer to the value of a name or of a component."""
        if isinstance(node, ast.Name) and node.id in self.variables:
            return self.variables[node.id]
        if isinstance(node, ast.Attribute):
            pointer = self.value(node.value)
            if isinstance(_kind(pointer), record_access.RecordPointer):
                refused = partial(self.refused, node)
                field = record_access.assigned(
                    pointer, record_access.field_of(pointer, node.attr, refused), refused
                )
                return record_access.place(self.builder, pointer, field)
        if isinstance(node, ast.Subscript):
            pointer, index = self.value(node.value), node.slice
            if isinstance(pointer, record_access.Table):
                if not isinstance(index, ast.Tuple) or len(index.elts) != 2:
                    raise self.refused(node, "two indices of a component, [j, i], or one of a row to read")
                row, index = index.elts
                pointer = pointer.row(self.builder, self.cast(node, self.value(row), WHOLE))
            if _is_row(pointer):
                place = self.builder.gep(pointer, [self.cast(node, self.value(index), WHOLE)])
                place.tag = "component"
                return place
        raise self.refused(node, "a name that has a value, a component of an array, or a field of a record")

    def load(self, place: Any) -> Any:
        """Value at a place."""
        return record_access.loaded(self.builder, place)

    def store(self, node: Any, value: Any, place: Any) -> None:
        """Store a value, converted to the type of its place."""
        record_access.stored(self.builder, self.cast(node, value, place.type.pointee), place)

    def _If(self, node: ast.If) -> None:
        truth = self.constant_truth(node.test)
        if truth is not None:
            self.block(node.body if truth else node.orelse)
            return
        yes, no, after = (self.builder.append_basic_block() for _ in range(3))
        self.branch(node.test, yes, no)
        for block, statements in ((yes, node.body), (no, node.orelse)):
            self.builder.position_at_end(block)
            self.block(statements)
            if not self.builder.block.is_terminated:
                self.builder.branch(after)
        self.builder.position_at_end(after)

    def _While(self, node: ast.While) -> None:
        if node.orelse:
            raise self.refused(node, "a loop without else")
        head, body, done = (self.builder.append_basic_block() for _ in range(3))
        self.builder.branch(head)
        self.builder.position_at_end(head)
        self.branch(node.test, body, done)
        self.builder.position_at_end(body)
        self.loops.append((head, done))
        self.block(node.body)
        self.loops.pop()
        if not self.builder.block.is_terminated:
            self.builder.branch(head)
        self.builder.position_at_end(done)

    def _For(self, node: ast.For) -> None:
        call = node.iter
        if not isinstance(call, ast.Call) or self.value(call.func) is not range or node.orelse:
            raise self.refused(node, "a loop over range")
        bounds = [self.value(argument) for argument in call.args]
        start, stop, step = (0, *bounds, 1) if len(bounds) == 1 else (*bounds, 1)[:3]
        if not isinstance(step, int) or step == 0:
            raise self.refused(node, "a loop with a constant step")
        start, stop = (self.cast(node, bound, WHOLE) for bound in (start, stop))
        with _loop(self.builder, start, stop, step) as (counter, again, done):
            self.put(node.target, counter)
            self.loops.append((again, done))
            self.block(node.body)
            self.loops.pop()

    def _Break(self, node: ast.Break) -> None:
        self.builder.branch(self.loops[-1][1])

    def _Continue(self, node: ast.Continue) -> None:
        self.builder.branch(self.loops[-1][0])

    def _Return(self, node: ast.Return) -> None:
        if node.value is None:
            self.builder.ret_void()
        else:
            self.builder.ret(self.cast(node, self.value(node.value), self.result))

    # -- conditions --

    def constant_truth(self, node: ast.expr) -> bool | None:
        """Truth value of a condition that does not depend on the arguments; None if it does."""
        if isinstance(node, ast.BoolOp):
            parts = [self.constant_truth(part) for part in node.values]
            decisive = isinstance(node.op, ast.Or)
            if decisive in parts:
                return decisive
            return None if None in parts else not decisive
        for part in ast.walk(node):
            if (
                isinstance(part, ast.Call | ast.Subscript)
                or isinstance(part, ast.Name)
                and part.id in self.locals
            ):
                return None
        return bool(self.value(node))

    def branch(self, node: ast.expr, yes: Any, no: Any) -> None:
        """Branch to one of two blocks; the parts after a decisive one are not evaluated."""
        truth = self.constant_truth(node)
        if truth is not None:
            self.builder.branch(yes if truth else no)
        elif isinstance(node, ast.BoolOp):
            *rest, last = (part for part in node.values if self.constant_truth(part) is None)
            for part in rest:
                further = self.builder.append_basic_block()
                if isinstance(node.op, ast.And):
                    self.branch(part, further, no)
                else:
                    self.branch(part, yes, further)
                self.builder.position_at_end(further)
            self.branch(last, yes, no)
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            self.branch(node.operand, no, yes)
        else:
            self.builder.cbranch(self.cast(node, self.value(node), TRUTH), yes, no)

    # -- values --

    def value(self, node: ast.expr) -> Any:
        """An LLVM value, or a Python constant if it is known at compile time."""
        write = getattr(self, f"_{type(node).__name__}", None)
        if write is None:
            raise self.refused(node, "an expression of the compiled language")
        return write(node)

    def cast(self, node: Any, value: Any, kind: Any) -> Any:
        """The value as an LLVM value of this type."""
        present = _kind(value)
        if present == WHOLE and kind == REAL:
            return REAL(float(value)) if isinstance(value, int) else self.builder.sitofp(value, REAL)
        if present != kind:
            raise self.refused(node, f"a value of type {kind}", f"{present} of '{ast.unparse(node)}'")
        return kind(value) if isinstance(value, bool | int | float) else value

    def _Constant(self, node: ast.Constant) -> Any:
        return node.value

    def _Name(self, node: ast.Name) -> Any:
        if node.id in self.locals:
            return self.builder.load(self.place(node))
        if node.id not in self.space and not hasattr(builtins, node.id):
            raise self.refused(node, "a name that has a value")
        return self.space.get(node.id, getattr(builtins, node.id, None))

    def _Attribute(self, node: ast.Attribute) -> Any:
        module = self.value(node.value)
        if isinstance(_kind(module), record_access.RecordPointer):
            field = record_access.field_of(module, node.attr, partial(self.refused, node))
            return record_access.value(self.builder, module, field)
        if not isinstance(module, ModuleType):
            raise self.refused(node, "a field of a record, or a name of a module")
        return getattr(module, node.attr)

    def _Tuple(self, node: ast.Tuple) -> Any:
        return tuple(self.value(element) for element in node.elts)

    def _Subscript(self, node: ast.Subscript) -> Any:
        if isinstance(node.value, ast.Name) and node.value.id not in self.locals:
            table = self.value(node.value)
            if not isinstance(table, np.ndarray):
                raise self.refused(node, "a table of numbers")
            places = self.value(node.slice)
            places = places if isinstance(places, tuple) else (places,)
            at: Any = 0
            for place, length in zip(places, table.shape, strict=True):
                at = self.operated(node, ast.Add(), self.operated(node, ast.Mult(), at, length), place)
            at = self.cast(node, at, WHOLE)
            return self.builder.load(self.builder.gep(self.unit.table(table), [WHOLE(0), at]))
        if isinstance(node.slice, ast.Slice):
            return self.later_part(node, node.slice)
        if not isinstance(node.slice, ast.Tuple):
            table = self.value(node.value)
            if isinstance(table, record_access.Table):
                return table.row(self.builder, self.cast(node, self.value(node.slice), WHOLE))
        return self.load(self.place(node))

    def later_part(self, node: ast.Subscript, part: ast.Slice) -> Any:
        """The row that begins inside a row, ``row[k:]``."""
        row = self.value(node.value)
        if part.lower is None or part.upper is not None or part.step is not None or not _is_row(row):
            raise self.refused(node, "the rest of a row, as in row[k:]")
        return self.builder.gep(row, [self.cast(node, self.value(part.lower), WHOLE)])

    def _UnaryOp(self, node: ast.UnaryOp) -> Any:
        value = self.value(node.operand)
        kind, python = _kind(value), isinstance(value, bool | int | float)
        if isinstance(node.op, ast.Not) and kind == TRUTH:
            return not value if python else self.builder.not_(value)
        if isinstance(node.op, ast.USub) and kind in (REAL, WHOLE):
            return -value if python else self.builder.fneg(value) if kind == REAL else self.builder.neg(value)
        raise self.refused(node, "a sign of a number, or 'not' of a truth value")

    def _BinOp(self, node: ast.BinOp) -> Any:
        return self.operated(node, node.op, self.value(node.left), self.value(node.right))

    def operated(self, node: Any, operator: Any, a: Any, b: Any) -> Any:
        """Sum, product, ... of two numbers."""
        operation = type(operator)
        if isinstance(a, int | float) and isinstance(b, int | float):
            return _OF_PYTHON[operation](a, b)
        if operation in (ast.Div, ast.Pow) or REAL in (_kind(a), _kind(b)):
            a, b = self.cast(node, a, REAL), self.cast(node, b, REAL)
            if operation is ast.Pow:
                return called(self.builder, "llvm.pow.f64", REAL, a, b)
            if operation not in _OF_REALS:
                raise self.refused(node, "an operation on real numbers")
            return getattr(self.builder, _OF_REALS[operation])(a, b)
        a, b = self.cast(node, a, WHOLE), self.cast(node, b, WHOLE)
        if operation in _OF_INTEGERS:
            return getattr(self.builder, _OF_INTEGERS[operation])(a, b)
        if operation not in (ast.FloorDiv, ast.Mod):
            raise self.refused(node, "an operation on integers")
        # the processor rounds towards zero, and its remainder has the sign of the dividend
        builder = self.builder
        quotient, remainder = builder.sdiv(a, b), builder.srem(a, b)
        opposite = builder.icmp_signed("<", builder.xor(remainder, b), WHOLE(0))
        corrected = builder.and_(builder.icmp_signed("!=", remainder, WHOLE(0)), opposite)
        if operation is ast.FloorDiv:
            return builder.sub(quotient, builder.zext(corrected, WHOLE))
        return builder.select(corrected, builder.add(remainder, b), remainder)

    def _Compare(self, node: ast.Compare) -> Any:
        values = [self.value(operand) for operand in (node.left, *node.comparators)]
        result: Any = True
        for operator_, (a, b) in zip(node.ops, pairwise(values), strict=True):
            holds = self.compared(node, type(operator_), a, b)
            result = (
                holds
                if result is True
                else self.builder.and_(*(self.cast(node, x, TRUTH) for x in (result, holds)))
            )
        return result

    def compared(self, node: Any, operation: Any, a: Any, b: Any) -> Any:
        """Truth value of a comparison of two numbers."""
        if operation not in _COMPARED:
            if operation in (ast.Is, ast.IsNot) and b is None and isinstance(_kind(a), ir.PointerType):
                sign = "==" if operation is ast.Is else "!="
                return self.builder.icmp_unsigned(sign, a, _kind(a)(None))
            raise self.refused(node, "a comparison of two numbers, or of a kernel with None")
        if isinstance(a, int | float) and isinstance(b, int | float):
            return _OF_PYTHON[operation](a, b)
        kind = REAL if REAL in (_kind(a), _kind(b)) else TRUTH if TRUTH in (_kind(a), _kind(b)) else WHOLE
        a, b = self.cast(node, a, kind), self.cast(node, b, kind)
        if kind != REAL:
            return self.builder.icmp_signed(_COMPARED[operation], a, b)
        # with nan, every comparison but != is false
        ordered = self.builder.fcmp_unordered if operation is ast.NotEq else self.builder.fcmp_ordered
        return ordered(_COMPARED[operation], a, b)

    def _BoolOp(self, node: ast.BoolOp) -> Any:
        truth = self.constant_truth(node)
        return truth if truth is not None else self.chosen(node, node, lambda: True, lambda: False)

    def _IfExp(self, node: ast.IfExp) -> Any:
        truth = self.constant_truth(node.test)
        if truth is not None:
            return self.value(node.body if truth else node.orelse)
        return self.chosen(node, node.test, lambda: self.value(node.body), lambda: self.value(node.orelse))

    def chosen(self, node: Any, test: ast.expr, yes: Callable[[], Any], no: Callable[[], Any]) -> Any:
        """One of two values; only that one is evaluated."""
        builder = self.builder
        blocks = [builder.append_basic_block() for _ in range(2)]
        after = builder.append_basic_block()
        self.branch(test, *blocks)
        values, ends = [], []
        for block, value in zip(blocks, (yes, no), strict=True):
            builder.position_at_end(block)
            values.append(value())
            ends.append(builder.block)
        kind = REAL if REAL in map(_kind, values) else _kind(values[0])
        for k, end in enumerate(ends):
            builder.position_at_end(end)
            values[k] = self.cast(node, values[k], kind)
            builder.branch(after)
        builder.position_at_end(after)
        result = builder.phi(kind)
        for value, end in zip(values, ends, strict=True):
            result.add_incoming(value, end)
        return result

    def _Call(self, node: ast.Call) -> Any:
        function = self.value(node.func)
        if function in _EQUIVALENTS:
            function = _EQUIVALENTS[function]
        values = [self.value(argument) for argument in node.args]
        kinds: Sequence[Any]
        if isinstance(function, Instruction):
            kinds = [TYPES[kind] if kind else None for kind in function.kinds]
        elif isinstance(function, Compiled):
            kinds = function.types()
        elif _kind(function) == record_access.KERNEL:
            kinds = record_access.KERNEL.pointee.args
        elif isinstance(function, type) and issubclass(function, Record):
            kinds = [TYPES["Reals"]]
        else:
            raise self.refused(node, "a function that is compiled")
        if len(kinds) != len(values) or node.keywords:
            raise self.refused(node, f"{len(kinds)} arguments")
        arguments = [
            self.cast(argument, value, kind or _kind(value))
            for argument, value, kind in zip(node.args, values, kinds, strict=True)
        ]
        if isinstance(function, Instruction):
            return function.write(self.builder, *arguments)
        if isinstance(function, type):
            return self.builder.bitcast(arguments[0], record_access.RecordPointer(function))
        if not isinstance(function, Compiled):
            return self.builder.call(function, arguments)
        return self.builder.call(self.unit.declare(function), arguments)
