"""Formulas on rows, eight numbers at a time: a plain loop over a state would compute one after the other.

An assignment to a whole row, ``run.y_new[:] = run.y + h * combination(B, run.k)``, holds for each component. Rows stand
for their components and numbers for themselves; a product that is added to something is joined to the sum, with one
rounding if the processor has a fused multiply-add.

    combination(weights, k)                Σ_j weights[j] k[j], with constant weights by number of the row
    chain(weights, k)                      the same, in a row that a kernel reads next (`Chain`)
    rowwise(formula)(run, own, ...)        evaluate a formula of rows of two records, and return its largest result
"""

from __future__ import annotations

import ast
import inspect
import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

from llvmlite import ir

from .arithmetic import (
    REAL,
    WHOLE,
    Refusal,
    cast,
    intrinsic,
    kind_of,
    lanes_of,
    mathematical,
    operated,
    selected,
    splat,
    wide,
)
from .functions import Instruction, counted, instruction, variable
from .instructions import where
from .record_access import Table, field_of
from .record_access import value as field_value
from .records import WIDTH


class Eight:
    """Eight numbers in a formula: a part of a row, or one number repeated."""

    def __init__(self, builder: Any, value: Any) -> None:
        self.builder, self.value = builder, value

    def _vector(self, operand: Any) -> Any:
        return operand.value if isinstance(operand, Eight) else all_of(float(operand))

    def _combined(self, operation: str, a: Any, b: Any) -> Eight:
        return Eight(self.builder, getattr(self.builder, operation)(self._vector(a), self._vector(b)))

    def __add__(self, other: Any) -> Eight:
        return self._combined("fadd", self, other)

    def __sub__(self, other: Any) -> Eight:
        return self._combined("fsub", self, other)

    def __mul__(self, other: Any) -> Eight:
        return self._combined("fmul", self, other)

    __radd__, __rmul__ = __add__, __mul__

    def __rsub__(self, other: Any) -> Eight:
        return self._combined("fsub", other, self)

    def __truediv__(self, other: Any) -> Eight:
        return self._combined("fdiv", self, other)

    def __rtruediv__(self, other: Any) -> Eight:
        return self._combined("fdiv", other, self)

    def __abs__(self) -> Eight:
        return self._bitwise(lambda b, x: b.and_(x, bits_of((1 << 63) - 1)))

    def _bitwise(self, function: Callable[[Any, Any], Any]) -> Eight:
        """Numbers whose bits are a function of these bits."""
        b = self.builder
        result = function(b, b.bitcast(self.value, ir.VectorType(WHOLE, WIDTH)))
        return Eight(b, b.bitcast(result, ir.VectorType(REAL, WIDTH)))

    def _called(self, name: str, *operands: Any) -> Eight:
        """Result of an LLVM intrinsic function of these numbers and further operands."""
        values = [self.value, *map(self._vector, operands)]
        return Eight(
            self.builder, intrinsic(self.builder, f"llvm.{name}.v{WIDTH}f64", self.value.type, *values)
        )

    def times_plus(self, factor: Any, more: Any) -> Eight:
        """Return self · factor + more, with one rounding if the processor has a fused multiply-add."""
        return self._called("fmuladd", factor, more)

    def root(self) -> Eight:
        """Square roots."""
        return self._called("sqrt")

    def compared(self, operator: str, other: Any) -> Any:
        """Mask of the places where the comparison holds."""
        return self.builder.fcmp_ordered(operator, self.value, self._vector(other))

    def where(self, mask: Any, other: Any) -> Eight:
        """These numbers where the mask holds, ``other`` elsewhere."""
        return Eight(self.builder, self.builder.select(mask, self.value, self._vector(other)))

    def greater(self, other: Eight) -> Eight:
        """The greater number of each pair."""
        return self.where(self.compared(">", other), other)

    def logarithm2(self) -> Eight:
        """log₂ of numbers >= 0 within 0.01, -1023 for 0: the exponent plus a parabola of the mantissa 1 <= m < 2."""
        one, shifted = 0x3FF << 52, 0x433 << 52  # the low bits of `shifted` hold an integer
        exponent = self._bitwise(lambda b, x: b.or_(b.lshr(x, bits_of(52)), bits_of(shifted)))
        m = self._bitwise(lambda b, x: b.or_(b.and_(x, bits_of((1 << 52) - 1)), bits_of(one)))
        return exponent - (2.0**52 + 1023.0) + ((2.0 - m * (1.0 / 3.0)) * m - 5.0 / 3.0)

    def power2(self) -> Eight:
        """2 to the power of these numbers, as `motion.ode.taylor.power2` computes it."""
        b = self.builder
        exponent = b.fptosi((self + 1023.0).value, ir.VectorType(WHOLE, WIDTH))
        r = self - Eight(b, b.sitofp(b.sub(exponent, bits_of(1023)), self.value.type))
        power = Eight(b, b.bitcast(b.shl(exponent, bits_of(52)), self.value.type))
        return power * r.times_plus(r.times_plus(1.0 / 3.0, 2.0 / 3.0), 1.0)

    def total(self, operation: Callable[[Eight, Eight], Eight]) -> Any:
        """Reduce the eight numbers to one by an operation on pairs."""
        b, result = self.builder, self
        for k in (4, 2, 1):
            places = ir.Constant(
                ir.VectorType(ir.IntType(32), WIDTH), [(i + k) % WIDTH for i in range(WIDTH)]
            )
            result = operation(result, Eight(b, b.shuffle_vector(result.value, result.value, places)))
        return b.extract_element(result.value, ir.IntType(32)(0))


def all_of(number: float) -> Any:
    """Constant vector of one real number."""
    return ir.Constant(ir.VectorType(REAL, WIDTH), [REAL(number)] * WIDTH)


def bits_of(number: int) -> Any:
    """Constant vector of one integer."""
    return ir.Constant(ir.VectorType(WHOLE, WIDTH), [WHOLE(number)] * WIDTH)


class FormulaRows:
    """The rows that a formula reads and writes: eight numbers of each, ``row.y`` or ``row.terms[k]``."""

    def __init__(self, builder: Any, rows: Callable[[str], Any], offset: Any) -> None:
        """``rows`` gives a pointer, or a table of rows, by name."""
        vars(self).update(builder=builder, rows=rows, offset=offset)

    def __getattr__(self, name: str) -> Any:
        row = self.rows(name)
        return _Several(self, row) if isinstance(row, Table) else self.load(row)

    def __setattr__(self, name: str, value: Eight) -> None:
        self.store(value, self.rows(name))

    def load(self, row: Any) -> Eight:
        """Return eight numbers of a row."""
        return Eight(self.builder, self.builder.load(self._place(row), align=8))

    def store(self, value: Eight, row: Any) -> None:
        """Write eight numbers of a row."""
        self.builder.store(value.value, self._place(row), align=8)

    def _place(self, row: Any) -> Any:
        b = self.builder
        return b.bitcast(b.gep(row, [self.offset]), ir.VectorType(REAL, WIDTH).as_pointer())


class _Several:
    """Several rows of a formula."""

    def __init__(self, rows: FormulaRows, table: Table) -> None:
        self.rows, self.table = rows, table

    def __getitem__(self, k: int) -> Eight:
        return self.rows.load(self.table.row(self.rows.builder, WHOLE(k)))

    def __setitem__(self, k: int, value: Eight) -> None:
        self.rows.store(value, self.table.row(self.rows.builder, WHOLE(k)))


def rowwise(formula: Callable[..., Any], last: Callable[..., Eight] | None = None) -> Any:
    """Return the instruction ``(run, own, *more)`` that evaluates a formula, eight numbers at a time.

    The formula reads and writes rows of the two records, as long as the first one says (``width``). Its further
    arguments are numbers, or arrays as long as the state (``n``) that are continued by 1. The instruction returns the
    largest result of the formula, or nan if one of the results is nan; of records of lanes, those of each lane. If the
    formula returns a list, ``last`` computes the result from the largest of each and from the further numbers: the
    largest of increasing functions of each.
    """

    def over_rows(builder: Any, run: Any, own: Any, *more: Any) -> Any:
        n, w = (field_value(builder, run, field_of(run, name)) for name in ("n", "width"))
        largest, lanes = [], run.type.lanes
        undefined = variable(builder, all_of(0.0))  # becomes nan with the first result that is

        @cache  # each row is loaded once
        def rows(name: str) -> Any:
            record = own if name in own.type.record.fields else run
            return field_value(builder, record, field_of(record, name))

        def eight_of(value: Any) -> Eight:
            return Eight(builder, cast(builder, value, undefined.type.pointee))

        start = builder.block
        with counted(builder, w, WIDTH if lanes == 1 else 1) as offset:
            arguments = [
                _part(builder, x, offset, n, lanes) if isinstance(x.type, ir.PointerType) else eight_of(x)
                for x in more
            ]
            results = formula(FormulaRows(builder, rows, offset), *arguments)
            results = [] if results is None else results if isinstance(results, list) else [results]
            total = Eight(builder, builder.load(undefined))
            for result in results:
                with builder.goto_entry_block():
                    largest.append(builder.alloca(undefined.type.pointee))
                with builder.goto_block(start):
                    builder.store(all_of(-math.inf), largest[-1])
                before = Eight(builder, builder.load(largest[-1]))
                builder.store(result.greater(before).value, largest[-1])
                total = result * 0.0 + total
            builder.store(total.value, undefined)
        if not largest:
            return None
        doubt, *maxima = (Eight(builder, builder.load(place)) for place in (undefined, *largest))
        numbers = [eight_of(x) for x in more if not isinstance(x.type, ir.PointerType)]
        maximum = maxima[0] if last is None else last(maxima, *numbers)
        if lanes > 1:
            return (maximum + doubt).value
        return builder.fadd(maximum.total(Eight.greater), doubt.total(Eight.__add__))

    return Instruction(over_rows, "", "", *arguments_of(formula))


def _part(builder: Any, row: Any, offset: Any, n: Any, lanes: int) -> Eight:
    """Eight numbers of an array as long as the state: those of the lanes, or of one run, continued by 1."""
    pointer = builder.gep(row, [offset])
    if lanes > 1:
        return Eight(builder, builder.load(pointer, align=8))
    ones, remaining = all_of(1.0), splat(builder, builder.sub(n, offset), WIDTH)
    places = ir.Constant(ir.VectorType(WHOLE, WIDTH), [WHOLE(k) for k in range(WIDTH)])
    inside, name = builder.icmp_signed("<", places, remaining), f"llvm.masked.load.v{WIDTH}f64.p0"
    pointer = builder.bitcast(pointer, ones.type.as_pointer())
    return Eight(builder, intrinsic(builder, name, ones.type, pointer, ir.IntType(32)(8), inside, ones))


def arguments_of(formula: Callable[..., Any]) -> list[str]:
    """Kinds of a formula's arguments after its rows: any kind for each."""
    return [""] * (len(inspect.signature(formula).parameters) - 1)


# -- assignments to rows -------------------------------------------------------------------------------


class Chain(NamedTuple):
    """A sum of rows for a kernel, y + h Σ_j w_j k_j: what is known early, and its last term h w k.

    A kernel has just written the last row, and the next kernel reads the sum. The numbers of the last row are added one
    by one: a wide sum would wait for the slowest of them, whereas the angles of the next stage follow from speeds, so
    that their sines can be computed before the accelerations are known.
    """

    early: Any
    weight: Any
    late: Any


@instruction("", "")
def combination(builder: Any, weights: Any, rows: Any) -> Any:
    """Refuse the call outside of an assignment to a row."""
    raise Refusal(
        "a combination of rows in an assignment to a row", "Write row[:] = h * combination(weights, rows)."
    )


@instruction("", "")
def chain(builder: Any, weights: Any, rows: Any) -> Any:
    """Refuse the call outside of an assignment to a row."""
    raise Refusal("a chain in an assignment to a row", "Write row[:] = y + h * chain(weights, rows).")


class RowFormula:
    """The right side of an assignment to a row, at the eight components from ``offset`` on."""

    def __init__(self, value: Callable[[ast.expr], Any], builder: Any, offset: Any) -> None:
        self.plain, self.builder, self.offset = value, builder, offset

    def assign(self, row: Any, node: ast.expr) -> None:
        """Write the components of a row."""
        value = self.value(node)
        if (
            isinstance(value, Chain) and lanes_of(row.type) > 1
        ):  # no kernel waits for the slowest of the lanes
            late = self.builder.load(self._place(value.late), align=8)
            value = mathematical(
                self.builder, "fmuladd", *map(self.vector, (value.weight, late, value.early))
            )
        if not isinstance(value, Chain):
            self.builder.store(self.vector(value), self._place(row), align=8)
            return
        b = self.builder
        early = self.vector(value.early)
        for k in range(WIDTH):
            # atomic, so that LLVM does not join them into vectors; the machine code is an ordinary load and store
            old, new = (b.gep(p, [b.add(self.offset, WHOLE(k))]) for p in (value.late, row))
            term = b.load_atomic(old, "monotonic", 8)
            total = b.extract_element(early, ir.IntType(32)(k))
            b.store_atomic(mathematical(b, "fmuladd", value.weight, term, total), new, "monotonic", 8)

    def vector(self, value: Any) -> Any:
        """A value as eight numbers."""
        return cast(self.builder, value, wide(REAL, WIDTH))

    def value(self, node: ast.expr) -> Any:
        """Value of an expression: a number, eight numbers, or a chain."""
        if isinstance(node, ast.BinOp):
            return self._operated(node)
        if isinstance(node, ast.Call):
            function = self.plain(node.func)
            if function is combination or function is chain:
                weights, rows = (self.plain(argument) for argument in node.args)
                terms = sorted((weights if isinstance(weights, dict) else dict(enumerate(weights))).items())
                if function is combination:
                    return self._sum(terms, rows)
                *early, (late, weight) = terms
                return Chain(self._sum(early, rows), weight, rows.row(self.builder, WHOLE(late)))
            if function is where:
                return selected(self.builder, *map(self.value, node.args))
        value = self.plain(node)
        if isinstance(kind_of(value), ir.PointerType):
            return self.builder.load(self._place(value), align=8)
        return value

    def _operated(self, node: ast.BinOp) -> Any:
        b, is_sum = self.builder, isinstance(node.op, ast.Add)
        left, right = (
            (node.right, node.left) if is_sum and _is_product(node.left) else (node.left, node.right)
        )
        if not (is_sum and isinstance(right, ast.BinOp) and _is_product(right)):
            return operated(b, type(node.op), self.value(left), self.value(right))
        a, p, q = self.value(left), self.value(right.left), self.value(right.right)
        if isinstance(q, Chain):  # a + p (early + weight late)
            early = a if q.early is None else self._joined(p, q.early, a)
            return Chain(early, operated(b, ast.Mult, p, q.weight), q.late)
        return self._joined(p, q, a)

    def _joined(self, p: Any, q: Any, a: Any) -> Any:
        """p q + a."""
        return mathematical(self.builder, "fmuladd", *map(self.vector, (q, p, a)))

    def _sum(self, terms: Sequence[tuple[int, float]], rows: Any) -> Any:
        """Σ_j w_j k_j; None without a term."""
        total = None
        for j, weight in terms:
            if weight == 0:
                continue
            row = self.builder.load(self._place(rows.row(self.builder, WHOLE(j))), align=8)
            if total is None:
                total = operated(self.builder, ast.Mult, row, weight)
            else:
                total = mathematical(self.builder, "fmuladd", row, self.vector(weight), total)
        return total

    def _place(self, row: Any) -> Any:
        b = self.builder
        return b.bitcast(b.gep(row, [self.offset]), wide(REAL, WIDTH).as_pointer())  # of lanes: as it is


def _is_product(node: ast.expr) -> bool:
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult)
