"""Rows of the compiled loop in formulas, eight numbers at a time.

    rowwise(formula)(work, w, n, ...)      a formula of rows, and the largest of its results
    copied(work, w, source, target)        work[target] = work[source]

A loop over the components of a state would add one after the other; here eight stand side by side in a register.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from typing import Any

from llvmlite import ir

from .registers import WIDTH
from .translation import REAL, WHOLE, Instruction, called, counted, instruction, variable


class Eight:
    """Eight numbers, of a row or all the same, in a formula."""

    def __init__(self, builder: Any, value: Any) -> None:
        self.builder, self.value = builder, value

    def _of(self, other: Any) -> Any:
        return other.value if isinstance(other, Eight) else all_of(float(other))

    def _with(self, operation: str, a: Any, b: Any) -> Eight:
        return Eight(self.builder, getattr(self.builder, operation)(self._of(a), self._of(b)))

    def __add__(self, other: Any) -> Eight:
        return self._with("fadd", self, other)

    def __sub__(self, other: Any) -> Eight:
        return self._with("fsub", self, other)

    def __mul__(self, other: Any) -> Eight:
        return self._with("fmul", self, other)

    __radd__, __rmul__ = __add__, __mul__

    def __rsub__(self, other: Any) -> Eight:
        return self._with("fsub", other, self)

    def __truediv__(self, other: Any) -> Eight:
        return self._with("fdiv", self, other)

    def __rtruediv__(self, other: Any) -> Eight:
        return self._with("fdiv", other, self)

    def __abs__(self) -> Eight:
        return self._bitwise(lambda b, x: b.and_(x, bits_of((1 << 63) - 1)))

    def _bitwise(self, of: Callable[[Any, Any], Any]) -> Eight:
        """What a function of their bits makes."""
        b = self.builder
        result = of(b, b.bitcast(self.value, ir.VectorType(WHOLE, WIDTH)))
        return Eight(b, b.bitcast(result, ir.VectorType(REAL, WIDTH)))

    def _called(self, name: str, *others: Any) -> Eight:
        """An intrinsic of LLVM."""
        values = [self.value, *map(self._of, others)]
        return Eight(self.builder, called(self.builder, f"llvm.{name}.v{WIDTH}f64", self.value.type, *values))

    def times_plus(self, factor: Any, more: Any) -> Eight:
        """The product with more added, with one rounding where the machine can."""
        return self._called("fmuladd", factor, more)

    def root(self) -> Eight:
        """The square roots."""
        return self._called("sqrt")

    def compared(self, operator: str, other: Any) -> Any:
        """Where they compare so: a mask."""
        return self.builder.fcmp_ordered(operator, self.value, self._of(other))

    def where(self, mask: Any, other: Any) -> Eight:
        """Those in the mask, of another number the others."""
        return Eight(self.builder, self.builder.select(mask, self.value, self._of(other)))

    def greater(self, other: Eight) -> Eight:
        """Of each pair."""
        return self.where(self.compared(">", other), other)

    def logarithm2(self) -> Eight:
        """log₂ of numbers >= 0 within 0.01, -1023 of 0: their exponents, and a parabola of what is left, 1 <= m < 2."""
        one, shifted = 0x3FF << 52, 0x433 << 52  # of the second number the last bits are an integer
        exponent = self._bitwise(lambda b, x: b.or_(b.lshr(x, bits_of(52)), bits_of(shifted)))
        m = self._bitwise(lambda b, x: b.or_(b.and_(x, bits_of((1 << 52) - 1)), bits_of(one)))
        return exponent - (2.0**52 + 1023.0) + ((2.0 - m * (1.0 / 3.0)) * m - 5.0 / 3.0)

    def power2(self) -> Eight:
        """`taylor.power2`."""
        b = self.builder
        exponent = b.fptosi((self + 1023.0).value, ir.VectorType(WHOLE, WIDTH))
        r = self - Eight(b, b.sitofp(b.sub(exponent, bits_of(1023)), self.value.type))
        power = Eight(b, b.bitcast(b.shl(exponent, bits_of(52)), self.value.type))
        return power * r.times_plus(r.times_plus(1.0 / 3.0, 2.0 / 3.0), 1.0)

    def total(self, of: Callable[[Eight, Eight], Eight]) -> Any:
        """What ``of`` two at a time leaves of the eight."""
        b, left = self.builder, self
        for k in (4, 2, 1):
            places = ir.Constant(
                ir.VectorType(ir.IntType(32), WIDTH), [(i + k) % WIDTH for i in range(WIDTH)]
            )
            left = of(left, Eight(b, b.shuffle_vector(left.value, left.value, places)))
        return b.extract_element(left.value, ir.IntType(32)(0))


def all_of(number: float) -> Any:
    return ir.Constant(ir.VectorType(REAL, WIDTH), [REAL(number)] * WIDTH)


def bits_of(number: int) -> Any:
    return ir.Constant(ir.VectorType(WHOLE, WIDTH), [WHOLE(number)] * WIDTH)


def splat(builder: Any, scalar: Any) -> Any:
    """A number eight times."""
    nothing = ir.Constant(ir.VectorType(REAL, WIDTH), ir.Undefined)
    one = builder.insert_element(nothing, scalar, ir.IntType(32)(0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(one, nothing, zeros)


class Rows:
    """The rows of ``work``, eight numbers of each, as a formula reads and writes them."""

    def __init__(self, builder: Any, work: Any, w: Any, offset: Any) -> None:
        self.builder, self.work, self.w, self.offset = builder, work, w, offset

    def index(self, row: Any) -> Any:
        """Where they stand."""
        b = self.builder
        return b.add(b.mul(self.w, WHOLE(row) if isinstance(row, int) else row), self.offset)

    def _place(self, row: Any) -> Any:
        b = self.builder
        return b.bitcast(b.gep(self.work, [self.index(row)]), ir.VectorType(REAL, WIDTH).as_pointer())

    def __getitem__(self, row: Any) -> Eight:
        return Eight(self.builder, self.builder.load(self._place(row), align=8))

    def __setitem__(self, row: Any, value: Eight) -> None:
        self.builder.store(value.value, self._place(row), align=8)


def rowwise(formula: Callable[..., Eight | None]) -> Any:
    """Compiled ``(work, w, n, *more)``: a formula of rows, of which it reads and writes eight numbers at a time, of
    numbers, and of arrays of length n, after which stands 1.

    The largest of its results is that of the whole, nan if one of them is.
    """

    def over_rows(builder: Any, work: Any, w: Any, n: Any, *more: Any) -> Any:
        largest = variable(builder, all_of(-math.inf))
        doubt = variable(builder, all_of(0.0))
        places = ir.Constant(ir.VectorType(WHOLE, WIDTH), [WHOLE(k) for k in range(WIDTH)])
        with counted(builder, w, WIDTH) as offset:

            def given(value: Any) -> Eight:
                if value.type == REAL:
                    return Eight(builder, splat(builder, value))
                left = builder.bitcast(builder.sub(n, offset), REAL)  # only its bits
                left = builder.bitcast(splat(builder, left), places.type)
                nothing = all_of(1.0)
                pointer = builder.bitcast(builder.gep(value, [offset]), nothing.type.as_pointer())
                there = builder.icmp_signed("<", places, left)
                name = f"llvm.masked.load.v{WIDTH}f64.p0"
                return Eight(
                    builder, called(builder, name, nothing.type, pointer, ir.IntType(32)(8), there, nothing)
                )

            rows = Rows(builder, work, w, offset)
            result = formula(rows, *map(given, more))
            if result is not None:
                builder.store(result.greater(Eight(builder, builder.load(largest))).value, largest)
                builder.store((result * 0.0 + Eight(builder, builder.load(doubt))).value, doubt)
        if result is None:
            return None
        most = Eight(builder, builder.load(largest)).total(Eight.greater)
        return builder.fadd(most, Eight(builder, builder.load(doubt)).total(Eight.__add__))

    return Instruction(over_rows, "Reals", "int", "int", *arguments_of(formula))


def arguments_of(formula: Callable[..., Any]) -> list[str]:
    """Of any kind each, but for its rows."""
    return [""] * (len(inspect.signature(formula).parameters) - 1)


@instruction("Reals", "int", "int", "int")
def copied(builder: Any, work: Any, w: Any, source: Any, target: Any) -> None:
    """Row ``target`` of ``work`` becomes row ``source``."""
    with counted(builder, w, WIDTH) as offset:
        rows = Rows(builder, work, w, offset)
        rows[target] = rows[source]
