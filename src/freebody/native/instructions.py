"""What the compiled loop is made with: C functions, a call by address, and a weighted sum of rows.

    @compiled                              a function to be translated (`translation`)
    call(address, t, y, i, c, out, j)      f(t, &y[i], &c[0], &out[j])
    linear(row)(work, n, target, base, h)  work[target] = work[base] + h Σ_j row[j] work[j]
    greater(a, b), lesser(a, b)            a if a > b else b, a if a < b else b
    root(a), whole(a)                      sqrt(a), int(a)
    with_bits(i)                           the real number of 64 bits

A kernel has the signature ``void f(double t, const double *y, const double *c, double *out)``. It is called through
its address, so that one compiled integrator serves every model. The rows of ``work`` are padded to a multiple of
`WIDTH` numbers: a sum is then whole vector registers, with nothing left over and no test for overlap.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import FunctionType
from typing import Any

import numpy as np
from llvmlite import ir

from .registers import WIDTH
from .row_arithmetic import Eight, Rows, splat
from .translation import REAL, WHOLE, Compiled, Instruction, called, counted, instruction

Reals = Any  # the first of real numbers in memory
Integers = Any  # the first of integers in memory
EPS = float(np.finfo(float).eps)


def compiled(function: Callable[..., Any]) -> Compiled:
    """A function for the compiled loop."""
    return Compiled(function)


class Parts(list[Callable[..., Any]]):
    """A decorator that collects functions, which are compiled when they are bound to a method."""

    def __call__(self, function: Callable[..., Any]) -> Callable[..., Any]:
        self.append(function)
        return function

    def bound(self, space: dict[str, Any]) -> dict[str, Compiled]:
        """The functions, with the names in ``space`` in place of the globals of their module; it gets them, too."""
        result = {}
        for given in self:
            function = FunctionType(given.__code__, space, given.__name__)
            function.__annotations__ = given.__annotations__
            space[given.__name__] = result[given.__name__] = Compiled(function)
        return result


@instruction("int", "float", "Reals", "int", "Reals", "Reals", "int")
def call(builder: Any, address: Any, t: Any, y: Any, i: Any, c: Any, out: Any, j: Any) -> None:
    """Call the kernel at ``address`` on ``y[i:]``; it writes ``out[j:]``."""
    pointer = REAL.as_pointer()
    kernel = ir.FunctionType(ir.VoidType(), [REAL, pointer, pointer, pointer])
    builder.call(
        builder.inttoptr(address, kernel.as_pointer()), [t, builder.gep(y, [i]), c, builder.gep(out, [j])]
    )


@instruction("int")
def reals_at(builder: Any, address: Any) -> Any:
    """The pointer to real numbers at an address."""
    return builder.inttoptr(address, REAL.as_pointer())


@instruction("int")
def integers_at(builder: Any, address: Any) -> Any:
    """The pointer to integers at an address."""
    return builder.inttoptr(address, WHOLE.as_pointer())


@instruction("", "int")
def shifted(builder: Any, p: Any, k: Any) -> Any:
    """The pointer to ``p[k]``."""
    return builder.gep(p, [k])


def linear(row: Mapping[int, float], chained: bool = False, lanes: bool = False) -> Any:
    """Compiled ``(work, n, target, base, h)``: row ``target`` of ``work`` becomes base + h Σ_j row[j] work[j].

    ``chained``: the last row has just been written by a kernel, and the target is read by one next. Its numbers are
    then added one by one: a wide sum would wait for the slowest of them, while the angles of the next stage follow
    from speeds, and their sines can be on the way before the accelerations are known.

    ``lanes``: rows hold eight runs side by side, and ``h`` is the place in ``work`` of their eight steps. With
    ``chained`` the roundings are then those of one run.

    ``work`` is one flat array of rows of length ``n``, a multiple of `WIDTH`; ``base`` < 0 stands for a row of zeros.
    """
    terms = sorted(row.items())
    early, (late, weight) = terms[:-1] if chained else terms, terms[-1]

    def weighted_sum(builder: Any, work: Any, n: Any, target: Any, base: Any, h: Any) -> None:
        step = Rows(builder, work, n, h)[0] if lanes else Eight(builder, splat(builder, h))
        based = builder.icmp_signed(">=", base, WHOLE(0))
        safe_base = builder.select(based, base, WHOLE(0))
        with counted(builder, n, WIDTH) as offset:
            rows, total = Rows(builder, work, n, offset), None
            for number, coefficient in early:
                row = rows[number]
                total = row * coefficient if total is None else row.times_plus(coefficient, total)
            result = rows[safe_base].where(based, 0.0)
            if total is not None:
                result = step.times_plus(total, result)
            if not chained:
                rows[target] = result
            elif lanes:
                rows[target] = (step * weight).times_plus(rows[late], result)
            else:
                factor = builder.fmul(h, REAL(weight))
                old, new = (builder.gep(work, [rows.index(row)]) for row in (late, target))
                for k in range(WIDTH):
                    # atomic, or LLVM makes them wide again; the instructions are those of any load and store
                    value = builder.load_atomic(builder.gep(old, [WHOLE(k)]), "monotonic", 8)
                    known = builder.extract_element(result.value, ir.IntType(32)(k))
                    value = called(builder, "llvm.fmuladd.f64", REAL, factor, value, known)
                    builder.store_atomic(value, builder.gep(new, [WHOLE(k)]), "monotonic", 8)

    return Instruction(weighted_sum, "Reals", "int", "int", "int", "int" if lanes else "float")


@instruction("float", "float")
def greater(builder: Any, a: Any, b: Any) -> Any:
    """The one of two numbers that is greater, else the second."""
    return builder.select(builder.fcmp_ordered(">", a, b), a, b)


@instruction("float", "float")
def lesser(builder: Any, a: Any, b: Any) -> Any:
    """The one of two numbers that is less, else the second."""
    return builder.select(builder.fcmp_ordered("<", a, b), a, b)


@instruction("float")
def root(builder: Any, a: Any) -> Any:
    """The square root."""
    return called(builder, "llvm.sqrt.f64", REAL, a)


@instruction("float")
def whole(builder: Any, a: Any) -> Any:
    """A real number without its fraction, as an integer."""
    return builder.fptosi(a, WHOLE)


@instruction("int")
def with_bits(builder: Any, a: Any) -> Any:
    """The real number that has the bits of an integer."""
    return builder.bitcast(a, REAL)
