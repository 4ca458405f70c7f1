"""Instructions of the compiled language: calls by address, pointers and mathematical functions.

    @compiled                              a function to be translated (`translation`)
    call(address, t, y, i, c, out, j)      f(t, &y[i], &c[0], &out[j])
    run_by(address, record)                f(&record)
    address_of(p)                          the address of numbers, as an integer
    greater(a, b), lesser(a, b)            a if a > b else b, a if a < b else b
    maximum(a, b)                          the greater one, nan if one is nan
    larger(a, b)                           the same of sizes, numbers without a sign
    root(a), whole(a)                      sqrt(a), int(a)
    with_bits(i), bits(a)                  the real number of 64 bits, and the bits of a number
    fma(a, b, c)                           a b + c with one rounding
    muladd(a, b, c)                        a b + c with one rounding if the processor has such an instruction
    where(c, a, b)                         a where c holds, b elsewhere

A kernel has the signature ``void f(double t, const double *y, const double *c, double *out)``. It is called through
its address, so that one compiled integrator serves every model.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import FunctionType
from typing import Any

import numpy as np
from llvmlite import ir

from .arithmetic import (
    REAL,
    TRUTH,
    WHOLE,
    cast,
    intrinsic,
    lanes_of,
    mathematical,
    selected,
    wide,
)
from .functions import Compiled, Inlined, Instruction, instruction

Reals = Any  # pointer to the first of real numbers in memory
Integers = Any  # pointer to the first of integers in memory
Real = Any  # a real number, or one for each lane
Whole = Any  # an integer, or one for each lane
Truth = Any  # a truth value, or one for each lane
Row = Any  # pointer to the first of such real numbers in memory
EPS = float(np.finfo(float).eps)


def compiled(function: Callable[..., Any]) -> Compiled:
    """Mark a function as one of the compiled language."""
    return Compiled(function)


def hot(function: Compiled) -> Compiled:
    """Mark a compiled function in which a loop spends much of its time: it gets all of LLVM's passes where the others
    get a few (`codegen.optimised_code`).
    """
    function.hot = True
    return function


def inlined(function: Callable[..., Any]) -> Inlined:
    """Mark a function as one that is translated at the place of each call; it may return several values."""
    return Inlined(function)


class Parts(list[Callable[..., Any]]):
    """A decorator that collects functions. They become compiled functions when they are bound to a method.

    Those of ``inlined`` are translated at the place of each call.
    """

    def __init__(self) -> None:
        super().__init__()
        self._inlined: list[Callable[..., Any]] = []

    def inlined(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Collect a function that is to be inlined."""
        self._inlined.append(function)
        return self(function)

    def __call__(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Collect a function."""
        self.append(function)
        return function

    def bound(self, space: dict[str, Any]) -> dict[str, Compiled]:
        """Return the functions with ``space`` in place of their modules' globals, and add them to ``space``."""
        result = {}
        for part in self:
            function = FunctionType(part.__code__, space, part.__name__)
            function.__annotations__ = part.__annotations__
            kind = Inlined if part in self._inlined else Compiled
            space[part.__name__] = result[part.__name__] = kind(function)
        return result


@instruction("int", "float", "Reals", "int", "Reals", "Reals", "int")
def call(builder: Any, address: Any, t: Any, y: Any, i: Any, c: Any, out: Any, j: Any) -> None:
    """Call the kernel at ``address`` with ``y[i:]``; it writes ``out[j:]``."""
    pointer = REAL.as_pointer()
    kernel = ir.FunctionType(ir.VoidType(), [REAL, pointer, pointer, pointer])
    builder.call(
        builder.inttoptr(address, kernel.as_pointer()), [t, builder.gep(y, [i]), c, builder.gep(out, [j])]
    )


@instruction("Reals")
def address_of(builder: Any, p: Any) -> Any:
    """Address of numbers in memory."""
    return builder.ptrtoint(p, WHOLE)


@instruction("int", "")
def run_by(builder: Any, address: Any, record: Any) -> Any:
    """Return what the function of a record at ``address`` returns, an integer."""
    byte = ir.IntType(8).as_pointer()
    function = ir.FunctionType(WHOLE, [byte]).as_pointer()
    return builder.call(builder.inttoptr(address, function), [builder.bitcast(record, byte)])


@instruction("int")
def reals_at(builder: Any, address: Any) -> Any:
    """Pointer to the real numbers at an address."""
    return builder.inttoptr(address, REAL.as_pointer())


@instruction("int")
def integers_at(builder: Any, address: Any) -> Any:
    """Pointer to the integers at an address."""
    return builder.inttoptr(address, WHOLE.as_pointer())


@instruction("", "int")
def shifted(builder: Any, p: Any, k: Any) -> Any:
    """Pointer to ``p[k]``."""
    return builder.gep(p, [k])


@instruction("Real", "Real")
def greater(builder: Any, a: Any, b: Any) -> Any:
    """Return a if a > b, else b."""
    return builder.select(builder.fcmp_ordered(">", a, b), a, b)


@instruction("Real", "Real")
def lesser(builder: Any, a: Any, b: Any) -> Any:
    """Return a if a < b, else b."""
    return builder.select(builder.fcmp_ordered("<", a, b), a, b)


@instruction("Real", "Real")
def maximum(builder: Any, a: Any, b: Any) -> Any:
    """Return the greater number; nan if one is nan."""
    first = builder.or_(builder.fcmp_ordered(">", a, b), builder.fcmp_unordered("uno", a, a))
    return builder.select(first, a, b)


@instruction("Real", "Real")
def larger(builder: Any, a: Any, b: Any) -> Any:
    """Return the greater of two sizes, numbers without a sign such as |x|; nan if one is nan.

    Their bits compare as integers do, those of nan being the greatest, so that one instruction does what `maximum` does
    in four.
    """
    p, q = (builder.bitcast(x, wide(WHOLE, lanes_of(a.type))) for x in (a, b))
    return builder.select(builder.icmp_unsigned(">", p, q), a, b)


@instruction("Real")
def root(builder: Any, a: Any) -> Any:
    """Square root; nan of a negative number."""
    return mathematical(builder, "sqrt", a)


@instruction("Real", "Real", "Real")
def fma(builder: Any, a: Any, b: Any, c: Any) -> Any:
    """Return a b + c with one rounding."""
    return mathematical(builder, "fma", a, b, c)


@instruction("Real", "Real", "Real")
def muladd(builder: Any, a: Any, b: Any, c: Any) -> Any:
    """Return a b + c, with one rounding if the processor has a fused multiply-add."""
    return mathematical(builder, "fmuladd", a, b, c)


@instruction("Real")
def whole(builder: Any, a: Any) -> Any:
    """Integer part, rounded towards zero; the nearest integer to a number beyond 64 bits; 0 of nan."""
    kind = wide(WHOLE, lanes_of(a.type))
    suffix = f"v{lanes_of(a.type)}" if lanes_of(a.type) > 1 else ""
    return intrinsic(builder, f"llvm.fptosi.sat.{suffix}i64.{suffix}f64", kind, a)


@instruction("Whole")
def with_bits(builder: Any, a: Any) -> Any:
    """Real number with the bits of an integer."""
    return builder.bitcast(a, wide(REAL, lanes_of(a.type)))


@instruction("Real")
def bits(builder: Any, a: Any) -> Any:
    """Integer with the bits of a real number."""
    return builder.bitcast(a, wide(WHOLE, lanes_of(a.type)))


@instruction("Whole", "Whole")
def high(builder: Any, a: Any, b: Any) -> Any:
    """Upper 64 bits of the product of two patterns of 64 bits."""
    double = ir.IntType(128)
    product = builder.mul(builder.zext(a, double), builder.zext(b, double))
    return builder.trunc(builder.lshr(product, double(64)), WHOLE)


@instruction("Whole", "Whole", "Whole")
def joined(builder: Any, a: Any, b: Any, k: Any) -> Any:
    """64 bits of the 128 bits of a and b, from place k on, 0 <= k < 64."""
    return intrinsic(builder, "llvm.fshl.i64", WHOLE, a, b, k)


@instruction("Whole")
def leading_zeros(builder: Any, a: Any) -> Any:
    """Number of zeros before the first one of 64 bits."""
    return intrinsic(builder, "llvm.ctlz.i64", WHOLE, a, TRUTH(0))


@instruction("Whole")
def unsigned(builder: Any, a: Any) -> Any:
    """Real number nearest to the natural number with these 64 bits."""
    return builder.uitofp(a, wide(REAL, lanes_of(a.type)))


def library(name: str, arguments: int = 1) -> Instruction:
    """Return the function of this name in the C library, of so many real numbers."""

    def call_library(builder: Any, *values: Any) -> Any:
        return intrinsic(builder, name, REAL, *values)

    return Instruction(call_library, *["float"] * arguments)


@instruction("")
def room(builder: Any, count: Any) -> Any:
    """Pointer to memory of the function for so many real numbers; the count is a constant."""
    with builder.goto_entry_block():
        return builder.alloca(REAL, count.constant)


def polynomial(coefficients: Sequence[float]) -> Instruction:
    """Return the instruction (z, z²) -> Σ coefficients[i] z^i.

    It has two chains, of even and of odd powers (Estrin's first step), which is shorter to wait for.
    """

    def in_two_chains(builder: Any, z: Any, zz: Any) -> Any:
        sums = []
        for chain in (coefficients[0::2], coefficients[1::2]):
            value = cast(builder, chain[-1], z.type)
            for c in reversed(chain[:-1]):
                value = mathematical(builder, "fma", value, zz, cast(builder, c, z.type))
            sums.append(value)
        return mathematical(builder, "fma", sums[1], z, sums[0])

    return Instruction(in_two_chains, "Real", "Real")


# -- what a run of one lane does as well, and what is rare -------------------------------------------------


where = Instruction(selected, "", "", "")
"""``where(c, a, b)``: a where c holds, b elsewhere; both are evaluated."""


@instruction("")
def lanes(builder: Any, x: Any) -> int:
    """Return the number of lanes."""
    return lanes_of(x.type)


@instruction("Row")
def numbers(builder: Any, row: Any) -> Any:
    """Pointer to the numbers of a row: that of component i in lane l stands at (number of lanes) i + l."""
    return builder.bitcast(row, REAL.as_pointer())
