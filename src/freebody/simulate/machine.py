"""Two pieces of machine code that numba does not write as well: a call by address, and a weighted sum of rows.

    call(address, t, y, i, c, out, j)      f(t, &y[i], &c[0], &out[j])
    linear(row)(work, n, target, base, h)  work[target] = work[base] + h Σ_j row[j] work[j]

A kernel has the signature ``void f(double t, const double *y, const double *c, double *out)``. It is called through
its address and not through a numba function type, so that one compiled integrator serves every model and lies in
numba's cache on disk. The rows of ``work`` are padded to a multiple of `WIDTH` numbers: a sum is then whole vector
registers, with nothing left over and no test for overlap.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

WIDTH = 8  # numbers in a register of 512 bits; narrower machines split it

_double = ir.DoubleType()
_integer = ir.IntType(64)


def padded(n: int) -> int:
    """Length of a row that holds ``n`` numbers: the next multiple of `WIDTH`.

    >>> padded(1), padded(8), padded(9)
    (8, 8, 16)
    """
    return -(-max(n, 1) // WIDTH) * WIDTH


def _data(context: Any, builder: Any, array_type: Any, value: Any) -> Any:
    return context.make_array(array_type)(context, builder, value).data


@intrinsic
def call(typing: Any, address: Any, t: Any, y: Any, i: Any, c: Any, out: Any, j: Any) -> Any:
    """Call the kernel at ``address`` on ``y[i:]``; it writes ``out[j:]``."""
    del typing
    signature = types.void(types.int64, types.float64, y, types.int64, c, out, types.int64)
    del address, t, i, j

    def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kernel, time, y_, i_, c_, out_, j_ = arguments
        state = builder.gep(_data(context, builder, signature.args[2], y_), [i_])
        constants = _data(context, builder, signature.args[4], c_)
        result = builder.gep(_data(context, builder, signature.args[5], out_), [j_])
        pointer = _double.as_pointer()
        function = ir.FunctionType(ir.VoidType(), [_double, pointer, pointer, pointer])
        builder.call(builder.inttoptr(kernel, function.as_pointer()), [time, state, constants, result])
        return context.get_dummy_value()

    return signature, write


def linear(row: Mapping[int, float]) -> Any:
    """Compiled ``(work, n, target, base, h)``: row ``target`` of ``work`` becomes base + h Σ_j row[j] work[j].

    ``work`` is one flat array of rows of length ``n``, a multiple of `WIDTH`; ``base`` < 0 stands for a row of zeros.
    """
    terms = sorted(row.items())

    def weighted_sum(typing: Any, work: Any, n: Any, target: Any, base: Any, h: Any) -> Any:
        del typing, n, target, base, h
        signature = types.void(work, types.int64, types.int64, types.int64, types.float64)

        def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            work_, n_, target_, base_, h_ = arguments
            data = _data(context, builder, signature.args[0], work_)
            vector = ir.VectorType(_double, WIDTH)
            # one rounding where the machine can, two where it can not: never a call of a library
            fma = cgutils.get_or_insert_function(
                builder.module, ir.FunctionType(vector, [vector] * 3), f"llvm.fmuladd.v{WIDTH}f64"
            )

            def splat(scalar: Any) -> Any:
                one = builder.insert_element(ir.Constant(vector, ir.Undefined), scalar, ir.IntType(32)(0))
                zeros = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
                return builder.shuffle_vector(one, ir.Constant(vector, ir.Undefined), zeros)

            def place(number: Any, offset: Any) -> Any:
                index = builder.add(builder.mul(number, n_), offset)
                return builder.bitcast(builder.gep(data, [index]), vector.as_pointer())

            def load(number: int, offset: Any) -> Any:
                return builder.load(place(_integer(number), offset), align=8)

            step = splat(h_)
            based = builder.icmp_signed(">=", base_, _integer(0))
            safe_base = builder.select(based, base_, _integer(0))
            entry = builder.block
            loop = builder.append_basic_block("rows")
            done = builder.append_basic_block("rows_done")
            builder.branch(loop)
            builder.position_at_end(loop)
            offset = builder.phi(_integer)
            offset.add_incoming(_integer(0), entry)
            total = None
            for number, coefficient in terms:
                value = load(number, offset)
                weight = ir.Constant(vector, [_double(coefficient)] * WIDTH)
                total = (
                    builder.fmul(weight, value)
                    if total is None
                    else builder.call(fma, [weight, value, total])
                )
            zero = ir.Constant(vector, [_double(0)] * WIDTH)
            start = builder.select(based, builder.load(place(safe_base, offset), align=8), zero)
            builder.store(builder.call(fma, [step, total, start]), place(target_, offset), align=8)
            following = builder.add(offset, _integer(WIDTH))
            offset.add_incoming(following, builder.block)
            builder.cbranch(builder.icmp_signed("<", following, n_), loop, done)
            builder.position_at_end(done)
            return context.get_dummy_value()

        return signature, write

    return intrinsic(weighted_sum)
