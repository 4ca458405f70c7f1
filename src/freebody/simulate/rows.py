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
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from .layout import WIDTH

_double = ir.DoubleType()
_integer = ir.IntType(64)


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
        result = of(b, b.bitcast(self.value, ir.VectorType(_integer, WIDTH)))
        return Eight(b, b.bitcast(result, ir.VectorType(_double, WIDTH)))

    def _called(self, name: str, *others: Any) -> Eight:
        """An intrinsic of LLVM."""
        vector, arguments = self.value.type, [self.value, *map(self._of, others)]
        function = cgutils.get_or_insert_function(
            self.builder.module,
            ir.FunctionType(vector, [vector] * len(arguments)),
            f"llvm.{name}.v{WIDTH}f64",
        )
        return Eight(self.builder, self.builder.call(function, arguments))

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
        exponent = b.fptosi((self + 1023.0).value, ir.VectorType(_integer, WIDTH))
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
    return ir.Constant(ir.VectorType(_double, WIDTH), [_double(number)] * WIDTH)


def bits_of(number: int) -> Any:
    return ir.Constant(ir.VectorType(_integer, WIDTH), [_integer(number)] * WIDTH)


def splat(builder: Any, scalar: Any) -> Any:
    """A number eight times."""
    nothing = ir.Constant(ir.VectorType(_double, WIDTH), ir.Undefined)
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
        return b.add(b.mul(self.w, _integer(row) if isinstance(row, int) else row), self.offset)

    def _place(self, row: Any) -> Any:
        b = self.builder
        return b.bitcast(b.gep(self.work, [self.index(row)]), ir.VectorType(_double, WIDTH).as_pointer())

    def __getitem__(self, row: Any) -> Eight:
        return Eight(self.builder, self.builder.load(self._place(row), align=8))

    def __setitem__(self, row: Any, value: Eight) -> None:
        self.builder.store(value.value, self._place(row), align=8)


def rowwise(formula: Callable[..., Eight | None]) -> Any:
    """Compiled ``(work, w, n, *more)``: a formula of rows, of which it reads and writes eight numbers at a time, of
    numbers, and of arrays of length n, after which stands 1.

    The largest of its results is that of the whole, nan if one of them is.
    """

    def over_rows(typing: Any, work: Any, w: Any, n: Any, *more: Any) -> Any:
        del typing, w, n

        def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            del context, signature
            work_, w_, n_, *more_ = arguments
            vector = ir.VectorType(_double, WIDTH)
            largest = cgutils.alloca_once_value(builder, all_of(-math.inf))
            doubt = cgutils.alloca_once_value(builder, all_of(0.0))
            places = ir.Constant(ir.VectorType(_integer, WIDTH), [_integer(k) for k in range(WIDTH)])
            with cgutils.for_range_slice(builder, _integer(0), w_, _integer(WIDTH)) as (offset, _):

                def given(kind: Any, value: Any) -> Eight:
                    if kind is types.float64:
                        return Eight(builder, splat(builder, value))
                    left = builder.bitcast(builder.sub(n_, offset), _double)  # only its bits
                    left = builder.bitcast(splat(builder, left), places.type)
                    load = cgutils.get_or_insert_function(
                        builder.module,
                        ir.FunctionType(
                            vector,
                            [
                                vector.as_pointer(),
                                ir.IntType(32),
                                ir.VectorType(ir.IntType(1), WIDTH),
                                vector,
                            ],
                        ),
                        f"llvm.masked.load.v{WIDTH}f64.p0",
                    )
                    pointer = builder.bitcast(builder.gep(value, [offset]), vector.as_pointer())
                    there = builder.icmp_signed("<", places, left)
                    return Eight(
                        builder, builder.call(load, [pointer, ir.IntType(32)(8), there, all_of(1.0)])
                    )

                rows = Rows(builder, work_, w_, offset)
                result = formula(rows, *(given(kind, value) for kind, value in zip(more, more_, strict=True)))
                if result is not None:
                    builder.store(result.greater(Eight(builder, builder.load(largest))).value, largest)
                    builder.store((result * 0.0 + Eight(builder, builder.load(doubt))).value, doubt)
            if result is None:
                return _double(0.0)
            most = Eight(builder, builder.load(largest)).total(Eight.greater)
            return builder.fadd(most, Eight(builder, builder.load(doubt)).total(Eight.__add__))

        return types.float64(work, types.int64, types.int64, *more), write

    named(over_rows, ("typing", "work", "w", "n"), formula)
    return intrinsic(over_rows)


def named(writer: Any, first: tuple[str, ...], formula: Callable[..., Any]) -> None:
    """Name the arguments of a writer, which numba asks for: after the first those of the formula but its rows."""
    names = (*first, *list(inspect.signature(formula).parameters)[1:])
    kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
    writer.__signature__ = inspect.Signature([inspect.Parameter(name, kind) for name in names])


@intrinsic
def copied(typing: Any, work: Any, w: Any, source: Any, target: Any) -> Any:
    """Row ``target`` of ``work`` becomes row ``source``."""
    del typing, source, target

    def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del signature
        work_, w_, source_, target_ = arguments
        with cgutils.for_range_slice(builder, _integer(0), w_, _integer(WIDTH)) as (offset, _):
            rows = Rows(builder, work_, w_, offset)
            rows[target_] = rows[source_]
        return context.get_dummy_value()

    return types.void(work, types.int64, types.int64, types.int64), write
