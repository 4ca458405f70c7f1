"""Formulas on the rows of a work array, eight numbers at a time.

    rowwise(formula)(work, w, n, ...)      evaluate a formula of rows and return the largest of its results
    copied(work, w, source, target)        work[target] = work[source]

A plain loop over the components of a state would compute one after the other; here eight share a vector register.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from typing import Any

from llvmlite import ir

from .arithmetic import REAL, WHOLE, intrinsic, splat
from .functions import Instruction, counted, instruction, variable
from .registers import WIDTH


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


class Rows:
    """The rows of ``work`` as a formula reads and writes them: eight numbers of each, from ``offset`` on."""

    def __init__(self, builder: Any, work: Any, w: Any, offset: Any) -> None:
        self.builder, self.work, self.w, self.offset = builder, work, w, offset

    def index(self, row: Any) -> Any:
        """Place in ``work`` of the eight numbers of a row."""
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
    """Return the instruction ``(work, w, n, *more)`` that evaluates a formula, eight numbers at a time.

    The formula reads and writes rows. Its further arguments are numbers, or arrays of length n that are continued by 1.
    The instruction returns the largest result of the formula, or nan if one of the results is nan.
    """

    def over_rows(builder: Any, work: Any, w: Any, n: Any, *more: Any) -> Any:
        largest = variable(builder, all_of(-math.inf))
        undefined = variable(builder, all_of(0.0))  # becomes nan with the first result that is
        places = ir.Constant(ir.VectorType(WHOLE, WIDTH), [WHOLE(k) for k in range(WIDTH)])
        with counted(builder, w, WIDTH) as offset:

            def eight_of(value: Any) -> Eight:
                if value.type == REAL:
                    return Eight(builder, splat(builder, value, WIDTH))
                remaining = splat(builder, builder.sub(n, offset), WIDTH)
                ones = all_of(1.0)
                pointer = builder.bitcast(builder.gep(value, [offset]), ones.type.as_pointer())
                inside = builder.icmp_signed("<", places, remaining)
                name = f"llvm.masked.load.v{WIDTH}f64.p0"
                return Eight(
                    builder, intrinsic(builder, name, ones.type, pointer, ir.IntType(32)(8), inside, ones)
                )

            rows = Rows(builder, work, w, offset)
            result = formula(rows, *map(eight_of, more))
            if result is not None:
                builder.store(result.greater(Eight(builder, builder.load(largest))).value, largest)
                builder.store((result * 0.0 + Eight(builder, builder.load(undefined))).value, undefined)
        if result is None:
            return None
        maximum = Eight(builder, builder.load(largest)).total(Eight.greater)
        return builder.fadd(maximum, Eight(builder, builder.load(undefined)).total(Eight.__add__))

    return Instruction(over_rows, "Reals", "int", "int", *arguments_of(formula))


def arguments_of(formula: Callable[..., Any]) -> list[str]:
    """Kinds of a formula's arguments after its rows: any kind for each."""
    return [""] * (len(inspect.signature(formula).parameters) - 1)


@instruction("Reals", "int", "int", "int")
def copied(builder: Any, work: Any, w: Any, source: Any, target: Any) -> None:
    """Copy row ``source`` of ``work`` to row ``target``."""
    with counted(builder, w, WIDTH) as offset:
        rows = Rows(builder, work, w, offset)
        rows[target] = rows[source]
