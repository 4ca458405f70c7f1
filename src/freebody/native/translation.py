"""Translation of functions of numbers and of arrays in memory from Python's syntax into LLVM's.

Compiled loops are written in a small part of Python, the compiled language (docs/compiled-language.md). Each of its
statements corresponds to instructions of a processor:

    integers, real numbers and truth values, one or one for each lane, and arrays of numbers, p[i];
    + - * / // % ** << >> & | ^, abs, comparisons, and, or, not, a if c else b, where(c, a, b), any, all,
    several names at once, if, while, for over range or over each lane, break, continue, return, calls

A variable has the type of its first value, and a value on every way to its use. Globals are constants: numbers, tables
(NumPy arrays), other functions of this kind, and instructions. Expressions of globals alone are evaluated during
translation, and a branch that they exclude is not translated. A function may call `Compiled` and `Instruction` objects;
any other call is refused.

One source serves one run and several lanes: the *width* of a translation is the number of lanes of the types `Real`,
`Whole`, `Truth` and `Row` (`TYPES`). A function without such a type in its signature is of one run at every width.

Arithmetic is that of the processor (`arithmetic`). Variables become values of LLVM, which meet in phi nodes: no pass of
LLVM is needed to keep them in registers.

The file is longer than others: it defines one language in one place.
"""

from __future__ import annotations

import ast
import builtins
import inspect
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
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
    constant,
    element_of,
    in_words,
    is_number,
    kind_of,
    lanes_of,
    mathematical,
    negated,
    operated,
    opposite,
    size,
    wide,
)

TYPES = {
    "None": ir.VoidType(),
    "int": WHOLE,
    "float": REAL,
    "Reals": REAL.as_pointer(),
    "Integers": WHOLE.as_pointer(),
}
"""LLVM type of an argument or a result, by its annotation."""
WIDE_TYPES = {"Real": REAL, "Whole": WHOLE, "Truth": TRUTH}
"""Type of the number in each lane, by annotation. A `Row` points to numbers of type `Real`."""
_UNLIKELY = (1, 1 << 20)
"""Weights of the ways of a branch on ``rare(c)``."""


def type_of(annotation: Any, lanes: int) -> Any:
    """LLVM type of an annotation in a translation for so many lanes; None if there is none."""
    name = annotation if isinstance(annotation, str) else getattr(annotation, "__name__", str(annotation))
    if name == "Row":
        return wide(REAL, lanes).as_pointer()
    return wide(WIDE_TYPES[name], lanes) if name in WIDE_TYPES else TYPES.get(name)


def _is_wide(annotation: Any) -> bool:
    return annotation == "Row" or annotation in WIDE_TYPES


class Compiled:
    """A function to be translated, with the types of its annotations."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function
        annotations: list[Any] = [*function.__annotations__.values()] or [""]
        self.arguments, self.result = annotations[:-1], annotations[-1]

    def __call__(self, *arguments: Any) -> Any:
        """Raise an error: only compiled code can call this object."""
        raise TypeError(
            f"Expected compiled code to call '{self.function.__name__}', got a call from Python. "
            "freebody.native.loop has the functions for Python."
        )


class Inlined(Compiled):
    """A function that is translated anew at the place of each call. It returns one value or several, at its end."""


class Instruction:
    """A call that is replaced by instructions: ``write(builder, *values)`` writes them and returns the result.

    The result is an LLVM value or None. ``kinds`` are the types of the arguments (`TYPES`, `WIDE_TYPES`); "" accepts
    any type.
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


def variable(builder: Any, value: Any) -> Any:
    """Pointer to local memory of the function, set to this value."""
    with builder.goto_entry_block():
        place = builder.alloca(value.type)
    builder.store(value, place)
    return place


@contextmanager
def counted(builder: Any, stop: Any, step: int) -> Iterator[Any]:
    """Write a loop around the body of the context, whose value is the counter: 0, step, … below ``stop``."""
    before = builder.block
    head, body, done = (builder.append_basic_block() for _ in range(3))
    builder.branch(head)
    builder.position_at_end(head)
    number = builder.phi(WHOLE)
    number.add_incoming(WHOLE(0), before)
    builder.cbranch(builder.icmp_signed("<", number, stop), body, done)
    builder.position_at_end(body)
    yield number
    number.add_incoming(builder.add(number, WHOLE(step)), builder.block)
    builder.branch(head)
    builder.position_at_end(done)


@instruction("Real")
def _finite(builder: Any, x: Any) -> Any:
    return compared(builder, ast.Lt, mathematical(builder, "fabs", x), math.inf)


@instruction("Real")
def _logarithm2(builder: Any, x: Any) -> Any:
    return mathematical(builder, "log2", x)


@instruction("Real")
def _root(builder: Any, x: Any) -> Any:
    return mathematical(builder, "sqrt", x)


@instruction("Real", "Real")
def _signed(builder: Any, x: Any, sign: Any) -> Any:
    return mathematical(builder, "copysign", x, sign)


def _of_mask(sign: str, number: int) -> Instruction:
    """Instruction that compares the bits of a truth value for each lane with a number."""

    def reduced(builder: Any, c: Any) -> Any:
        if lanes_of(c.type) == 1:
            return c
        bits = ir.IntType(lanes_of(c.type))
        return builder.icmp_unsigned(sign, builder.bitcast(c, bits), bits(number))

    return Instruction(reduced, "Truth")


_abs = Instruction(size, "")
_EQUIVALENTS: dict[Any, Instruction] = {
    abs: _abs, math.fabs: _abs, math.isfinite: _finite, math.log2: _logarithm2, math.sqrt: _root,
    math.copysign: _signed, any: _of_mask("!=", 0), all: _of_mask("==", -1),
}  # fmt: skip
"""Instructions that stand for functions of Python."""


# -- a module ------------------------------------------------------------------------------------------


def translated(functions: Mapping[str, Compiled], lanes: int = 1) -> str:
    """LLVM text of functions under these names, and of all functions that they call, for so many lanes."""
    return str(_unit(functions, lanes).module)


def parts(functions: Mapping[str, Compiled], lanes: int, public: bool = False) -> dict[str, str]:
    """LLVM text of functions, of the functions and the tables that they need, by name, for use in another module.

    Functions that the text calls but does not define are declared. The functions are ``public``, or internal.
    """
    result = {}
    for item in _unit(functions, lanes, internal=not public).module.global_values:
        text = str(item)
        if isinstance(item, ir.Function) and item.is_declaration:
            kinds = ", ".join(map(str, item.function_type.args))
            text = f"declare {item.function_type.return_type} @{item.name}({kinds})"
        result[f"@{item.name}"] = text
    return result


def _unit(functions: Mapping[str, Compiled], lanes: int, internal: bool = False) -> _Unit:
    unit = _Unit()
    for name, function in functions.items():
        unit.declare(function, lanes, name, internal)
    while unit.waiting:
        compiled, llvm_function, width = unit.waiting.pop()
        entry = llvm_function.append_basic_block()
        builder = ir.IRBuilder(entry)
        builder.position_at_end(builder.append_basic_block())
        begin = builder.block
        body = _Body(unit, compiled, builder, width)
        body.result = llvm_function.function_type.return_type
        body.write(llvm_function.args)
        builder.position_at_end(entry)  # the block of variables in memory
        builder.branch(begin)
    return unit


class _Unit:
    """The functions of one module, each translated once for each width that is called."""

    def __init__(self) -> None:
        self.module = ir.Module()
        self.waiting: list[tuple[Compiled, Any, int]] = []
        self._declared: dict[tuple[int, int], Any] = {}
        self._tables: dict[int, Any] = {}
        self._kept: list[Any] = []  # objects whose ids are in use
        self.inlining: list[Inlined] = []

    def _name(self, name: str) -> str:
        """Name that no other function or table has."""
        count, result = 0, name
        while result in self.module.globals:
            count += 1
            result = f"{name}.{count}"
        return result

    def declare(self, compiled: Compiled, lanes: int, name: str = "", internal: bool = False) -> Any:
        """Declare a function, which is translated later. A function without a name stays internal to the module."""
        if not any(map(_is_wide, (*compiled.arguments, compiled.result))):
            lanes = 1
        key = id(compiled), lanes
        if key not in self._declared:
            *arguments, result = signature(compiled, lanes)
            suffix = f".{lanes}" if any(map(_is_wide, (*compiled.arguments, compiled.result))) else ""
            own = self._name(name or f"{compiled.function.__name__}{suffix}")
            function = ir.Function(self.module, ir.FunctionType(result, arguments), own)
            if internal or not name:
                function.linkage = "internal"
            # calls are not inlined: large modules then compile quickly
            function.attributes.add("noinline")
            function.attributes.add("nounwind")
            self._declared[key] = function
            self._kept.append(compiled)
            self.waiting.append((compiled, function, lanes))
        return self._declared[key]

    def table(self, numbers: Any, name: str) -> Any:
        """A constant array of numbers in memory."""
        if id(numbers) not in self._tables:
            kind = {"f": REAL, "i": WHOLE}.get(numbers.dtype.kind)
            if kind is None:
                cure = "np.array(..., dtype=float) or dtype=np.int64 makes one."
                raise Refusal("a table of numbers", cure, f"a table of {numbers.dtype}")
            array = ir.ArrayType(kind, numbers.size)
            table = ir.GlobalVariable(self.module, array, self._name(f"table.{name}"))
            table.linkage, table.global_constant = "internal", True
            table.initializer = array([constant(x.item(), kind) for x in numbers.flat])
            self._tables[id(numbers)] = table
            self._kept.append(numbers)
        return self._tables[id(numbers)]


def signature(compiled: Compiled, lanes: int) -> list[Any]:
    """Types of the arguments and of the result of a function."""
    function = compiled.function
    code = function.__code__
    where = f"({Path(code.co_filename).name}, line {code.co_firstlineno})"
    parameters = inspect.signature(function).parameters.values()
    for p in parameters:
        if p.kind is not p.POSITIONAL_OR_KEYWORD or p.default is not p.empty:
            raise TypeError(
                f"Expected arguments by position without defaults for '{function.__name__}', which is to be machine "
                f"code, got '{p}' {where}. Pass every argument."
            )
    names = [p.name for p in parameters]
    if [*function.__annotations__] != [*names, "return"]:
        missing = [name for name in (*names, "return") if name not in function.__annotations__]
        raise TypeError(
            f"Expected a type for every argument and for the result of '{function.__name__}', which is to be machine "
            f"code, got none for {', '.join(missing)} {where}. Annotate it: {', '.join([*TYPES, *WIDE_TYPES, 'Row'])}."
        )
    kinds = []
    annotations = [*function.__annotations__.items()]
    results = re.fullmatch(r"tuple\[(.+)\]", str(compiled.result))
    if results and isinstance(compiled, Inlined):
        annotations[-1:] = [("return", part.strip()) for part in results[1].split(",")]
    for name, annotation in annotations:
        kind = type_of(annotation, lanes)
        if kind is None or isinstance(kind, ir.VoidType) and name != "return":
            raise TypeError(
                f"Expected a type of the compiled language for '{name}' of '{function.__name__}', got '{annotation}' "
                f"{where}. Types are {', '.join([*TYPES, *WIDE_TYPES, 'Row'])}; None is for results."
            )
        kinds.append(kind)
    return kinds


@cache
def _syntax(file: str) -> dict[int, ast.FunctionDef]:
    """Functions of a file by their first line, decorators included."""
    tree = ast.parse(Path(file).read_bytes())
    return {
        min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)]): node
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef)
    }


class _Join:
    """A block, and the ways that lead to it: the last block of each, and the values of its variables."""

    def __init__(self) -> None:
        self.block: Any = None
        self.ways: list[tuple[Any, dict[str, Any]]] = []


class _Body:
    """One function during its translation."""

    def __init__(self, unit: _Unit, compiled: Compiled, builder: Any, lanes: int) -> None:
        code = compiled.function.__code__
        self.unit, self.file, self.lanes = unit, code.co_filename, lanes
        cells = zip(code.co_freevars, compiled.function.__closure__ or (), strict=True)
        self.space = {**compiled.function.__globals__, **{name: cell.cell_contents for name, cell in cells}}
        try:
            tree = _syntax(code.co_filename).get(code.co_firstlineno)
        except OSError:
            tree = None
        if tree is None or tree.name != code.co_name:
            raise TypeError(
                f"Expected the text of '{code.co_name}' in {Path(self.file).name}, line {code.co_firstlineno}, got "
                "another. Write the function with def in a file; if the file has changed, start Python anew."
            )
        self.tree = tree
        self.locals = {*code.co_varnames, *code.co_cellvars}
        self.kinds: dict[str, Any] = {}
        self.values: dict[str, Any] = {}
        self.loops: list[tuple[_Join, _Join]] = []
        self.builder = builder
        self.result: Any = None  # type of the result; several of a function that is inlined
        self.returned: Any = None  # the result of such a function

    def bind(self, values: Sequence[Any]) -> None:
        """Give the arguments their values."""
        for name, value in zip(self.tree.args.args, values, strict=True):
            self.kinds[name.arg], self.values[name.arg] = value.type, value

    def inline(self, values: Sequence[Any], kinds: list[Any]) -> Any:
        """Translate the function at the place of a call, and return its result."""
        self.bind(values)
        self.result = kinds
        self.block(self.tree.body)
        if len(kinds) == 1:
            return None if isinstance(kinds[0], ir.VoidType) else self.returned[0]
        return self.returned

    def write(self, arguments: Sequence[Any]) -> None:
        """Translate the function."""
        self.bind(arguments)
        self.block(self.tree.body)
        if not self.builder.block.is_terminated:
            if not isinstance(self.result, ir.VoidType):
                cure = "End each way through the function with return and a value."
                raise self.refused(self.tree, "a value on every way", cure, "the end of the function")
            self.builder.ret_void()

    def refused(self, node: Any, expected: str, cure: str, got: str = "") -> TypeError:
        """Error that names the construct that cannot be translated, with its file, its line and the cure."""
        got = got or f"'{ast.unparse(node).splitlines()[0]}'"
        return TypeError(
            f"Expected {expected} in '{self.tree.name}', which is to be machine code, got {got} "
            f"({Path(self.file).name}, line {node.lineno}). {cure}"
        )

    # -- ways --

    def goto(self, join: _Join) -> None:
        """End this block with a branch to another."""
        self._lead(join)
        self.builder.branch(join.block)

    def fork(self, truth: Any, yes: _Join, no: _Join, rare: bool = False) -> None:
        """End this block with a branch to one of two others."""
        for join in (yes, no):
            self._lead(join)
        branch = self.builder.cbranch(truth, yes.block, no.block)
        if rare:
            branch.set_weights(_UNLIKELY)

    def _lead(self, join: _Join) -> None:
        join.block = join.block or self.builder.append_basic_block()
        join.ways.append((self.builder.block, dict(self.values)))

    def enter(self, join: _Join) -> bool:
        """Continue at a block with the variables that have a value on every way to it; False if no way leads there."""
        if not join.ways:
            return False
        self.builder.position_at_end(join.block)
        (_, first), *others = join.ways
        self.values = {}
        for name, value in first.items():
            if isinstance(value, tuple) and any(values.get(name) is not value for _, values in others):
                continue
            if all(name in values for _, values in others):
                self.values[name] = self._met(value, [(block, values[name]) for block, values in join.ways])
        return True

    def _met(self, value: Any, ways: Sequence[tuple[Any, Any]]) -> Any:
        """Return the value of one variable, whichever way leads here."""
        if all(other is value for _, other in ways):
            return value
        result = self.builder.phi(value.type)
        for block, other in ways:
            result.add_incoming(other, block)
        return result

    def head(self, node: ast.stmt) -> tuple[Any, dict[str, Any]]:
        """Begin a loop: its first block, and the meetings there of the variables that it changes."""
        names = {x.id for x in ast.walk(node) if isinstance(x, ast.Name) and isinstance(x.ctx, ast.Store)}
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

    # -- statements --

    def block(self, statements: Sequence[ast.stmt]) -> None:
        """Translate statements, up to the first that leaves the block."""
        for statement in statements:
            if self.builder.block.is_terminated:
                return
            write = getattr(self, f"_{type(statement).__name__}", None)
            if write is None:
                cure = "Statements are assignments, if, while, for, break, continue, pass, return and calls."
                raise self.refused(statement, "a statement of the compiled language", cure)
            try:
                write(statement)
            except Refusal as refusal:
                raise self.refused(statement, refusal.expected, refusal.cure, refusal.got) from None

    def _Expr(self, node: ast.Expr) -> None:
        if not isinstance(node.value, ast.Constant):
            self.value(node.value)

    def _Pass(self, node: ast.Pass) -> None:
        pass

    def _Assign(self, node: ast.Assign) -> None:
        value = self.value(node.value)
        for target in node.targets:
            self.put(target, value)

    def _AugAssign(self, node: ast.AugAssign) -> None:
        if isinstance(node.target, ast.Name):
            old = self._Name(node.target)
            self.put(node.target, operated(self.builder, type(node.op), old, self.value(node.value)))
        else:
            place = self.place(node.target)
            old = self.load(place)
            self.store(operated(self.builder, type(node.op), old, self.value(node.value)), place)

    def put(self, target: ast.expr, value: Any) -> None:
        """Assign a value to a name, a component of an array, or a tuple of these."""
        if isinstance(target, ast.Tuple):
            if not isinstance(value, tuple) or len(value) != len(target.elts):
                cure = "Write a value for each name on the right, separated by commas."
                raise self.refused(target, "as many values as names", cure)
            for element, part in zip(target.elts, value, strict=True):
                self.put(element, part)
        elif isinstance(target, ast.Name):
            if isinstance(value, tuple) and target.id in self.locals and target.id not in self.kinds:
                self.values[target.id] = value  # several values under one name, which no branch changes
                return
            kind = self.kinds.get(target.id, kind_of(value))
            if target.id not in self.locals:
                raise self.refused(target, "a name of the function", "Globals are constants.")
            if kind is None or isinstance(kind, ir.VoidType):
                got = in_words(value) if kind is not None else f"{value!r}"
                raise self.refused(
                    target, f"a number or an array for '{target.id}'", "Assign one of these.", got
                )
            self.values[target.id] = self.cast(target, value, kind)
            self.kinds[target.id] = kind
        else:
            self.store(value, self.place(target))

    def place(self, node: ast.expr) -> Any:
        """Pointer to a component."""
        if isinstance(node, ast.Subscript):
            pointer = self.value(node.value)
            if isinstance(kind_of(pointer), ir.PointerType):
                return self.builder.gep(pointer, [self.index(node)])
        cure = "Assign to a name or to a component p[i] of an argument."
        raise self.refused(node, "a name that has a value, or a component of an array", cure)

    def index(self, node: ast.Subscript) -> Any:
        """Place in an array, whose length is not known here: it counts from the first number."""
        place = self.value(node.slice)
        if is_number(place) and place < 0:
            cure = "An array in memory has no end to count from: write the place from its begin."
            raise self.refused(node, "a place from 0 on", cure)
        return self.cast(node.slice, place, WHOLE)

    def load(self, place: Any) -> Any:
        """Load the number, or the number of each lane, at a place."""
        return self.builder.load(place, align=8) if lanes_of(place.type) > 1 else self.builder.load(place)

    def store(self, value: Any, place: Any) -> None:
        """Store a value, converted to the type of its place."""
        value = cast(self.builder, value, place.type.pointee)
        self.builder.store(value, place, align=8 if lanes_of(place.type) > 1 else None)

    def _If(self, node: ast.If) -> None:
        truth = self.constant_truth(node.test)
        if truth is not None:
            self.block(node.body if truth else node.orelse)
            return
        yes, no, after = _Join(), _Join(), _Join()
        self.branch(node.test, yes, no)
        for join, statements in ((yes, node.body), (no, node.orelse)):
            if self.enter(join):
                self.block(statements)
                self.finish(after)
        self.enter(after)

    def finish(self, after: _Join) -> None:
        """Go to a block unless this one has gone elsewhere."""
        if not self.builder.block.is_terminated:
            self.goto(after)

    def _While(self, node: ast.While) -> None:
        if node.orelse:
            raise self.refused(node, "a loop without else", "Write what else does behind the loop.")
        body, again, done = _Join(), _Join(), _Join()
        loop = self.head(node)
        self.branch(node.test, body, done)
        if self.enter(body):
            self.body(node, again, done)
        if self.enter(again):
            self.back(*loop)
        self.enter(done)

    def body(self, node: ast.While | ast.For, again: _Join, done: _Join) -> None:
        """Translate the body of a loop, which goes on at ``again`` and ends at ``done``."""
        self.loops.append((again, done))
        self.block(node.body)
        self.loops.pop()
        self.finish(again)

    def _For(self, node: ast.For) -> None:
        call = node.iter
        kind = self.value(call.func) if isinstance(call, ast.Call) else None
        if kind not in (range, each) or node.orelse or call.keywords:  # type: ignore[attr-defined]
            raise self.refused(node, "a loop over range", "Write for i in range(n), or for lane in each(c).")
        values = [self.value(argument) for argument in call.args]  # type: ignore[attr-defined]
        if kind is each:
            self.over_lanes(node, values)
            return
        if not 1 <= len(values) <= 3:
            raise self.refused(
                call, "a range of one, two or three integers", "Write range(start, stop, step)."
            )
        start, stop, step = (0, *values, 1) if len(values) == 1 else (*values, 1)[:3]
        if not is_number(step) or not isinstance(step, int) or step == 0:
            cure = "The step decides which way to compare: write a number, or a while loop."
            raise self.refused(node, "a loop with a constant step", cure)
        start, stop = (self.cast(call, bound, WHOLE) for bound in (start, stop))
        with self.counter(node, start, stop, step) as (number, again, done):
            self.put(node.target, number)
            self.body(node, again, done)

    @contextmanager
    def counter(self, node: ast.For, start: Any, stop: Any, step: int) -> Iterator[tuple[Any, _Join, _Join]]:
        """Write a loop around the body of the context: (counter, block that goes on, block after the loop)."""
        builder, begin = self.builder, []
        if (
            abs(step) > 1
        ):  # the counter may pass the largest integer behind the last round: the rounds are counted
            begin = [(self.rounds(start, stop, step), -1)]
        begin.append((start, step))
        before = builder.block
        body, again, done = _Join(), _Join(), _Join()
        loop = self.head(node)
        counters = [builder.phi(WHOLE) for _ in begin]
        for counter, (value, _) in zip(counters, begin, strict=True):
            counter.add_incoming(value, before)
        left, number = counters[0], counters[-1]
        sign = "!=" if abs(step) > 1 else "<" if step > 0 else ">"
        self.fork(builder.icmp_signed(sign, left, WHOLE(0) if abs(step) > 1 else stop), body, done)
        self.enter(body)
        yield number, again, done
        if self.enter(again):
            for counter, (_, change) in zip(counters, begin, strict=True):
                counter.add_incoming(builder.add(counter, constant(change, WHOLE)), builder.block)
            self.back(*loop)
        self.enter(done)

    def rounds(self, start: Any, stop: Any, step: int) -> Any:
        """Number of rounds of a loop over range."""
        builder = self.builder
        low, high = (start, stop) if step > 0 else (stop, start)
        whole = builder.udiv(builder.sub(builder.sub(high, low), WHOLE(1)), constant(abs(step), WHOLE))
        return builder.select(builder.icmp_signed("<", low, high), builder.add(whole, WHOLE(1)), WHOLE(0))

    def over_lanes(self, node: ast.For, values: Sequence[Any]) -> None:
        """Translate a loop over the lanes in which a condition holds."""
        if len(values) != 1 or element_of(kind_of(values[0])) != TRUTH:
            raise self.refused(node, "one truth value for each lane", "Write for lane in each(c).")
        lanes = lanes_of(kind_of(values[0]))
        truth = self.cast(node, values[0], wide(TRUTH, lanes))
        body = _Join()
        if lanes == 1:
            done = _Join()
            self.fork(truth, body, done)
            self.enter(body)
            self.put(node.target, 0)
            self.body(node, done, done)
            self.enter(done)
            return
        with self.counter(node, WHOLE(0), WHOLE(lanes), 1) as (lane, again, done):
            self.fork(self.builder.extract_element(truth, lane), body, again)
            self.enter(body)
            self.put(node.target, lane)
            self.body(node, again, done)

    def _Break(self, node: ast.Break) -> None:
        self.goto(self.loops[-1][1])

    def _Continue(self, node: ast.Continue) -> None:
        self.goto(self.loops[-1][0])

    def inlined_return(self, node: ast.Return) -> None:
        """Keep the values that a function gives to the place of its call."""
        if node is not self.tree.body[-1] or node.value is None:
            cure = "A function that is inlined ends with its only return: choose the value before."
            raise self.refused(node, "one return with a value, at the end", cure)
        value = self.value(node.value)
        values = value if isinstance(value, tuple) else (value,)
        if len(values) != len(self.result):
            raise self.refused(node, f"{len(self.result)} values", "Return what the annotation says.")
        self.returned = tuple(self.cast(node, v, kind) for v, kind in zip(values, self.result, strict=True))

    def _Return(self, node: ast.Return) -> None:
        if isinstance(self.result, list):
            self.inlined_return(node)
            return
        if isinstance(self.result, ir.VoidType):
            if node.value is not None:
                raise self.refused(node, "no value to return", "Annotate the result, or write return alone.")
            self.builder.ret_void()
            return
        if node.value is None:
            raise self.refused(node, "a value to return", "Annotate the result with None, or return a value.")
        self.builder.ret(self.cast(node, self.value(node.value), self.result))

    # -- conditions --

    def constant_truth(self, node: ast.expr) -> bool | None:
        """Truth value of a condition that does not depend on the arguments; None if it does."""
        if isinstance(node, ast.BoolOp):
            decisive, known = isinstance(node.op, ast.Or), True
            for part in node.values:
                truth = self.constant_truth(part)
                if truth is decisive:
                    return decisive
                known = known and truth is not None
                if truth is None and any(isinstance(x, ast.Call) for x in ast.walk(part)):
                    return None  # what it calls may write to memory
            return not decisive if known else None
        return None if self.varies(node) else bool(self.value(node))

    def varies(self, node: ast.expr) -> bool:
        """Return whether an expression is known only in the running code."""
        return any(
            isinstance(part, ast.Call | ast.Subscript)
            or isinstance(part, ast.Name)
            and part.id in self.locals
            for part in ast.walk(node)
        )

    def branch(self, node: ast.expr, yes: _Join, no: _Join, unlikely: bool = False) -> None:
        """Branch to one of two blocks; the parts after a decisive one are not evaluated."""
        truth = self.constant_truth(node)
        if truth is not None:
            self.goto(yes if truth else no)
        elif isinstance(node, ast.BoolOp):
            *rest, last = node.values
            for part in rest:
                further = _Join()
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
        if not isinstance(module, ModuleType) or not hasattr(module, node.attr):
            cure = "Only modules have names here; give the value a name of its own outside the function."
            raise self.refused(node, "a name of a module", cure)
        return getattr(module, node.attr)

    def _Tuple(self, node: ast.Tuple) -> Any:
        return tuple(self.value(element) for element in node.elts)

    def _Subscript(self, node: ast.Subscript) -> Any:
        if isinstance(node.value, ast.Name) and node.value.id not in self.locals:
            return self.of_table(node, node.value.id)
        return self.load(self.place(node))

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
        no, after = _Join(), _Join()
        for operation, operand in zip(map(type, node.ops), node.comparators, strict=True):
            known = result is True
            if not known and lanes_of(kind_of(result)) > 1:
                self.without_calls(operand)
            elif not known and any(isinstance(x, ast.Call | ast.Subscript) for x in ast.walk(operand)):
                further = _Join()
                self.fork(self.truth(node, result), further, no)
                self.enter(further)
                result = True
            b = self.value(operand)
            holds = compared(self.builder, operation, a, b)
            result = holds if result is True else operated(self.builder, ast.BitAnd, result, holds)
            a = b
        if not no.ways:
            return result
        yes = _Join()
        self.goto(yes)
        return self.met([(yes, lambda: result), (no, lambda: False)], after, node)

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
        yes, no, after = _Join(), _Join(), _Join()
        further = _Join()
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
        yes, no, after = _Join(), _Join(), _Join()
        self.branch(node.test, yes, no)
        ways = [(yes, lambda: self.value(node.body)), (no, lambda: self.value(node.orelse))]
        return self.met(ways, after, node)

    def met(self, ways: Sequence[tuple[_Join, Callable[[], Any]]], after: _Join, node: ast.expr) -> Any:
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
        if isinstance(function, Callable) and function in _EQUIVALENTS:  # type: ignore[arg-type]
            function = _EQUIVALENTS[function]
        values = [self.value(argument) for argument in node.args]
        if isinstance(function, Instruction):
            kinds = function.kinds
        elif isinstance(function, Compiled):
            kinds = tuple(function.arguments)
        else:
            cure = "Make it one with @compiled, or use an instruction of freebody.native."
            raise self.refused(node, "a function that is compiled", cure)
        if len(kinds) != len(values) or node.keywords:
            cure = "Pass each by position."
            raise self.refused(node, f"{len(kinds)} argument{'s'[: len(kinds) != 1]}", cure)
        lanes = self.width_of_call(function, values, kinds)
        arguments = [
            value
            if isinstance(value, tuple)
            else self.cast(argument, value, type_of(kind, lanes) or kind_of(value))
            for argument, value, kind in zip(node.args, values, kinds, strict=True)
        ]
        if isinstance(function, Instruction):
            return function.write(self.builder, *arguments)
        if isinstance(function, Inlined):
            return self.inlined(function, arguments, lanes)
        return self.builder.call(self.unit.declare(function, lanes), arguments)

    def inlined(self, function: Inlined, arguments: Sequence[Any], lanes: int) -> Any:
        """Result of a function that is translated here."""
        if function in self.unit.inlining:
            raise Refusal("a function that does not call itself", "Mark it with @compiled, or write a loop.")
        self.unit.inlining.append(function)
        kinds = signature(function, lanes)[len(arguments) :]
        result = _Body(self.unit, function, self.builder, lanes).inline(arguments, kinds)
        self.unit.inlining.pop()
        return result

    def width_of_call(self, function: Any, values: Sequence[Any], kinds: Sequence[str]) -> int:
        """Number of lanes of a call: that of the arguments of wide types; without such arguments, of the caller."""
        of_lanes = [value for value, kind in zip(values, kinds, strict=True) if kind and _is_wide(kind)]
        if not of_lanes:
            return self.lanes
        counts = {lanes_of(kind_of(value)) for value in of_lanes} - {1}
        if len(counts) > 1:
            raise Refusal("arguments of one width", "One number is passed to all lanes.", f"{sorted(counts)}")
        return counts.pop() if counts else 1


def _each(builder: Any, c: Any) -> Any:
    raise Refusal("a loop over each(c)", "Write for lane in each(c).")


def _rare(builder: Any, c: Any) -> Any:
    return c


each = Instruction(_each, "Truth")
"""``for lane in each(c)``: the lanes in which c holds, for what is rare."""
rare = Instruction(_rare, "Truth")
"""``if rare(c)``: c, which seldom holds, so that what follows stands aside from the path of the code."""
