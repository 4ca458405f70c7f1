"""Statements of the compiled language: one function during its translation (`Body`)."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from llvmlite import ir

from .arithmetic import (
    REAL,
    TRUTH,
    WHOLE,
    Refusal,
    cast,
    constant,
    element_of,
    in_words,
    intrinsic,
    is_number,
    kind_of,
    lanes_of,
    operated,
    wide,
)
from .expressions import Expressions, Join, statements
from .functions import Compiled, components, counted, each, type_of, unrolled
from .record_access import length_of
from .records import WIDTH
from .rows import Components, LoopOverComponents, RowFormula, begun, reduced


@cache
def _syntax(file: str) -> dict[int, ast.FunctionDef]:
    """Functions of a file by their first line, decorators included. They stand in statements, not in expressions."""
    return {
        min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)]): node
        for node in statements(ast.parse(Path(file).read_bytes()))
        if isinstance(node, ast.FunctionDef)
    }


class Body(Expressions):
    """One function during its translation."""

    def __init__(self, unit: Any, compiled: Compiled, builder: Any, lanes: int) -> None:
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
        self.has_width = compiled.has_width
        self.locals = {*code.co_varnames, *code.co_cellvars}
        self.kinds: dict[str, Any] = {}
        self.values: dict[str, Any] = {}
        self.loops: list[tuple[Join, Join]] = []
        self.in_components = False
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
        target = node.targets[0]
        if isinstance(target, ast.Subscript) and isinstance(target.slice, ast.Slice):
            self.assign_row(node, target)
            return
        value = self.value(node.value)
        for target in node.targets:
            self.put(target, value)

    def _AnnAssign(self, node: ast.AnnAssign) -> None:
        kind = type_of(ast.unparse(node.annotation), self.lanes)
        if (
            not isinstance(node.target, ast.Name)
            or node.value is None
            or element_of(kind) not in (REAL, WHOLE, TRUTH)
        ):
            cure = "Real, Whole and Truth have a number in each lane: x: Real = 0.0."
            raise self.refused(node, "a type and a first value for a name", cure)
        self.put(node.target, self.cast(node.value, self.value(node.value), kind))

    def assign_row(self, node: ast.Assign, target: ast.Subscript) -> None:
        """Translate an assignment to all components of a row, ``row[:] = formula``."""
        part, row = target.slice, self.value(target.value)
        if len(node.targets) > 1 or part.lower or part.upper or part.step:  # type: ignore[attr-defined]
            raise self.refused(node, "an assignment to all components of one row", "Write row[:] = formula.")
        step = WIDTH if lanes_of(row.type) == 1 else 1
        with counted(self.builder, length_of(self.builder, row), step) as offset:
            RowFormula(self.value, self.builder, offset).assign(row, node.value)

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
        elif isinstance(target, ast.Subscript) and self.is_name_of_lanes(target.value):
            lanes = self.value(target.value)
            value = self.cast(target, value, element_of(lanes.type))
            if lanes_of(lanes.type) > 1:
                value = self.builder.insert_element(lanes, value, self.index(target.slice))
            self.put(target.value, value)
        else:
            self.store(value, self.place(target))

    def store(self, value: Any, place: Any) -> None:
        """Store a value, converted to the type of its place."""
        value = cast(self.builder, value, place.type.pointee)
        self.builder.store(value, place, align=8 if lanes_of(place.type) > 1 else None)

    def _If(self, node: ast.If) -> None:
        truth = self.constant_truth(node.test)
        if truth is not None:
            self.block(node.body if truth else node.orelse)
            return
        yes, after = Join(), Join()
        no = Join() if node.orelse else after
        self.branch(node.test, yes, no)
        for join, part in ((yes, node.body), (no, node.orelse)):
            if join is not after and self.enter(join):
                self.block(part)
                self.finish(after)
        self.enter(after)

    def _While(self, node: ast.While) -> None:
        if node.orelse:
            raise self.refused(node, "a loop without else", "Write what else does behind the loop.")
        body, again, done = Join(), Join(), Join()
        loop = self.head(node)
        self.branch(node.test, body, done)
        if self.enter(body):
            self.body(node, again, done)
        if self.enter(again):
            self.back(*loop)
        self.enter(done)

    def body(self, node: ast.While | ast.For, again: Join, done: Join) -> None:
        """Translate the body of a loop, which goes on at ``again`` and ends at ``done``."""
        self.loops.append((again, done))
        self.block(node.body)
        self.loops.pop()
        self.finish(again)

    def _For(self, node: ast.For) -> None:
        call = node.iter
        kind = self.value(call.func) if isinstance(call, ast.Call) else None
        if kind not in (range, each, unrolled, components) or node.orelse or call.keywords:  # type: ignore[attr-defined]
            raise self.refused(node, "a loop over range", "Write for i in range(n), or for lane in each(c).")
        values = [self.value(argument) for argument in call.args]  # type: ignore[attr-defined]
        if kind is unrolled:
            self.over_constants(node, values)
            return
        if kind is each:
            self.over_lanes(node, values)
            return
        if kind is components:
            self.over_components(node, values)
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
    def counter(self, node: ast.For, start: Any, stop: Any, step: int) -> Iterator[tuple[Any, Join, Join]]:
        """Write a loop around the body of the context: (counter, block that goes on, block after the loop)."""
        builder, begin = self.builder, []
        if (
            abs(step) > 1
        ):  # the counter may pass the largest integer behind the last round: the rounds are counted
            begin = [(self.rounds(start, stop, step), -1)]
        begin.append((start, step))
        before = builder.block
        body, again, done = Join(), Join(), Join()
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

    def over_constants(self, node: ast.For, values: Sequence[Any]) -> None:
        """Translate the body of a loop once for each of its numbers."""
        name = node.target.id if isinstance(node.target, ast.Name) else ""
        constant = all(isinstance(value, int) for value in values)
        if not constant or not 1 <= len(values) <= 3 or not name or name in self.kinds:
            cure = "Write for i in unrolled(start, stop), with numbers and a name of its own."
            raise self.refused(node, "one, two or three constant integers", cure)
        done = Join()
        for number in range(*values):
            again = Join()
            self.values[name] = number
            self.body(node, again, done)
            if not self.enter(again):
                break
        else:
            self.goto(done)
        self.enter(done)
        self.values.pop(name, None)

    def over_components(self, node: ast.For, values: Sequence[Any]) -> None:
        """Translate a loop over the components of rows: eight at a time, and of lanes one after the other."""
        if len(values) != 1 or self.in_components:
            raise self.refused(node, "one number of components", "Write for i in components(n), in no other.")
        count = self.cast(node, values[0], WHOLE)
        loop = LoopOverComponents(node, {name: self.kinds.get(name) for name in self.values}, self.value)
        for part, expected, cure in loop.refusals():
            raise self.refused(part, expected, cure)
        builder, self.in_components = self.builder, True
        if self.lanes > 1:
            with self.counter(node, WHOLE(0), count, 1) as (number, again, done):
                self.put(node.target, number)
                self.body(node, again, done)
        else:
            for name, operation in loop.reductions.items():
                first = begun(builder, operation, self.cast(node, self.values[name], REAL))
                self.values[name], self.kinds[name] = first, first.type
            rounds = builder.ashr(builder.add(count, WHOLE(WIDTH - 1)), WHOLE(3))
            with self.counter(node, WHOLE(0), rounds, 1) as (number, again, _):
                before = {name: self.values[name] for name in loop.reductions}
                eight = Components(builder, builder.mul(number, WHOLE(WIDTH)), count)
                self.values[loop.name] = eight
                self.block(node.body)
                for name, value in before.items():
                    self.values[name] = eight.without_padding(self.values[name], value)
                self.finish(again)
            for name, operation in loop.reductions.items():
                self.values[name], self.kinds[name] = reduced(builder, operation, self.values[name]), REAL
        self.in_components = False
        for name in (loop.name, *loop.new):
            self.values.pop(name, None)
            self.kinds.pop(name, None)

    def over_lanes(self, node: ast.For, values: Sequence[Any]) -> None:
        """Translate a loop over the lanes in which a condition holds."""
        if len(values) != 1 or element_of(kind_of(values[0])) != TRUTH:
            raise self.refused(node, "one truth value for each lane", "Write for lane in each(c).")
        lanes = lanes_of(kind_of(values[0]))
        truth = self.cast(node, values[0], wide(TRUTH, lanes))
        body = Join()
        if lanes == 1:
            done = Join()
            self.fork(truth, body, done)
            self.enter(body)
            self.put(node.target, 0)
            self.body(node, done, done)
            self.enter(done)
            return
        builder, mask = self.builder, ir.IntType(lanes)
        bits = builder.zext(builder.bitcast(truth, mask), WHOLE)  # the lanes that are still to come
        before, again, done = builder.block, Join(), Join()
        loop = self.head(node)
        left = builder.phi(WHOLE)
        left.add_incoming(bits, before)
        self.fork(builder.icmp_unsigned("!=", left, WHOLE(0)), body, done, rare=True)
        self.enter(body)
        self.put(node.target, intrinsic(builder, "llvm.cttz.i64", WHOLE, left, TRUTH(1)))
        self.body(node, again, done)
        if self.enter(again):
            left.add_incoming(builder.and_(left, builder.sub(left, WHOLE(1))), builder.block)
            self.back(*loop)
        self.enter(done)

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
