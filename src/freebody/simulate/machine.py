"""What the compiled loop is made with: C functions, a call by address, and a weighted sum of rows.

    @compiled                              the function as numba compiles it, alone and once
    call(address, t, y, i, c, out, j)      f(t, &y[i], &c[0], &out[j])
    linear(row)(work, n, target, base, h)  work[target] = work[base] + h Σ_j row[j] work[j]
    greater(a, b), lesser(a, b)            a if a > b else b, a if a < b else b
    root(a), whole(a)                      sqrt(a), int(a)
    with_bits(i)                           the real number of 64 bits

The scalar ones are instructions; what numba makes of max, min, sqrt and int tests for exceptions or calls a library.

A kernel has the signature ``void f(double t, const double *y, const double *c, double *out)``. It is called through
its address and not through a numba function type, so that one compiled integrator serves every model. ``y``, ``c``,
``out`` and ``work`` are pointers. The rows of ``work`` are padded to a multiple of `WIDTH` numbers: a sum is then
whole vector registers, with nothing left over and no test for overlap.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

from llvmlite import ir
from numba import cfunc, types
from numba.core import cgutils, typed_passes, untyped_passes
from numba.core.compiler import CompilerBase
from numba.core.compiler_machinery import PassManager
from numba.extending import intrinsic, typeof_impl

from .layout import WIDTH
from .rows import all_of, splat

_double = ir.DoubleType()
_integer = ir.IntType(64)


Reals = Any  # the first of real numbers in memory
Integers = Any  # the first of integers in memory

_TYPES = {
    "None": types.void,
    "int": types.int64,
    "float": types.float64,
    "Reals": types.CPointer(types.float64),
    "Integers": types.CPointer(types.int64),
}


class _Passes(CompilerBase):
    """What numba does for functions of numbers and pointers, in which nothing is inlined, lifted or made of arrays."""

    def define_pipelines(self) -> list[PassManager]:
        passes = PassManager("loop")
        for one in (
            untyped_passes.TranslateByteCode,
            untyped_passes.FixupArgs,
            untyped_passes.IRProcessing,
            untyped_passes.RewriteSemanticConstants,
            untyped_passes.DeadBranchPrune,
            untyped_passes.GenericRewrites,
            untyped_passes.ReconstructSSA,
            typed_passes.NopythonTypeInference,
            typed_passes.PreLowerStripPhis,
            typed_passes.IRLegalization,
            typed_passes.AnnotateTypes,
            typed_passes.NativeLowering,
            typed_passes.NoPythonBackend,
        ):
            passes.add_pass(one, one.__name__)
        passes.finalize()
        return [passes]


class Compiled:
    """A function with the types it is annotated with, compiled by numba when it is first asked for.

    It is a C function, and others that are compiled call it by its symbol. numba would put a copy of a function of its
    own kind in each that calls it, compile each copy, and let each look for exceptions.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function
        *self.arguments, self.result = function.__annotations__.values()

    @cached_property
    def code(self) -> Any:
        """numba's C function, with ``.address``, ``.native_name`` and ``.inspect_llvm()``; it owns the code."""
        # no exceptions, and no counting of references
        made = cfunc(self._signature(), error_model="numpy", _nrt=False, pipeline_class=_Passes)
        return made(self.function)

    def compile(self) -> None:
        """Now; what it calls is compiled with it."""
        _ = self.code

    @property
    def is_compiled(self) -> bool:
        """Whether anything has asked for it."""
        return "code" in vars(self)

    def _signature(self) -> Any:
        return _TYPES[self.result](*(_TYPES[argument] for argument in self.arguments))

    def __call__(self, *arguments: Any) -> Any:
        raise TypeError(
            f"Expected compiled code to call '{self.function.__name__}', got a call from Python. "
            "freebody.simulate.loop has the functions for Python."
        )


def compiled(function: Callable[..., Any]) -> Compiled:
    """A function for the compiled loop."""
    return Compiled(function)


@typeof_impl.register(Compiled)
def _type_of_compiled(value: Compiled, context: Any) -> Any:
    del context
    return types.ExternalFunction(value.code.native_name, value._signature())


@intrinsic
def call(typing: Any, address: Any, t: Any, y: Any, i: Any, c: Any, out: Any, j: Any) -> Any:
    """Call the kernel at ``address`` on ``y[i:]``; it writes ``out[j:]``."""
    del typing
    signature = types.void(types.int64, types.float64, y, types.int64, c, out, types.int64)
    del address, t, i, j

    def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del signature
        kernel, time, y_, i_, c_, out_, j_ = arguments
        state, result = builder.gep(y_, [i_]), builder.gep(out_, [j_])
        pointer = _double.as_pointer()
        function = ir.FunctionType(ir.VoidType(), [_double, pointer, pointer, pointer])
        builder.call(builder.inttoptr(kernel, function.as_pointer()), [time, state, c_, result])
        return context.get_dummy_value()

    return signature, write


def _pointer(numbers: str, element: Any) -> Any:
    """The pointer to numbers at an address."""

    def at(typing: Any, address: Any) -> Any:
        del typing, address

        def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            del context, signature
            return builder.inttoptr(arguments[0], element.as_pointer())

        return _TYPES[numbers](types.int64), write

    return intrinsic(at)


reals_at, integers_at = _pointer("Reals", _double), _pointer("Integers", _integer)


@intrinsic
def shifted(typing: Any, p: Any, k: Any) -> Any:
    """The pointer to ``p[k]``."""
    del typing, k

    def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del context, signature
        return builder.gep(arguments[0], [arguments[1]])

    return p(p, types.int64), write


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
    early = terms[:-1] if chained else terms

    def weighted_sum(typing: Any, work: Any, n: Any, target: Any, base: Any, h: Any) -> Any:
        del typing, n, target, base, h
        step_type = types.int64 if lanes else types.float64
        signature = types.void(work, types.int64, types.int64, types.int64, step_type)

        def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            del signature
            work_, n_, target_, base_, h_ = arguments
            vector = ir.VectorType(_double, WIDTH)
            # one rounding where the machine can, two where it can not: never a call of a library
            fma = cgutils.get_or_insert_function(
                builder.module, ir.FunctionType(vector, [vector] * 3), f"llvm.fmuladd.v{WIDTH}f64"
            )

            def at(index: Any) -> Any:
                return builder.bitcast(builder.gep(work_, [index]), vector.as_pointer())

            def place(number: Any, offset: Any) -> Any:
                return at(builder.add(builder.mul(number, n_), offset))

            def load(number: int, offset: Any) -> Any:
                return builder.load(place(_integer(number), offset), align=8)

            step = builder.load(at(h_), align=8) if lanes else splat(builder, h_)
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
            for number, coefficient in early:
                value, weight = load(number, offset), all_of(coefficient)
                total = (
                    builder.fmul(weight, value)
                    if total is None
                    else builder.call(fma, [weight, value, total])
                )
            start = builder.select(based, builder.load(place(safe_base, offset), align=8), all_of(0))
            result = start if total is None else builder.call(fma, [step, total, start])
            if chained and not lanes:
                number, coefficient = terms[-1]
                one = cgutils.get_or_insert_function(
                    builder.module, ir.FunctionType(_double, [_double] * 3), "llvm.fmuladd.f64"
                )
                weight = builder.fmul(h_, _double(coefficient))
                late = builder.gep(work_, [builder.add(builder.mul(_integer(number), n_), offset)])
                new = builder.gep(work_, [builder.add(builder.mul(target_, n_), offset)])
                for k in range(WIDTH):
                    # atomic, or LLVM makes them wide again; the instructions are those of any load and store
                    value = builder.load_atomic(builder.gep(late, [_integer(k)]), "monotonic", 8)
                    known = builder.extract_element(result, ir.IntType(32)(k))
                    value = builder.call(one, [weight, value, known])
                    builder.store_atomic(value, builder.gep(new, [_integer(k)]), "monotonic", 8)
            else:
                if chained:
                    number, coefficient = terms[-1]
                    weight = builder.fmul(step, all_of(coefficient))
                    result = builder.call(fma, [weight, load(number, offset), result])
                builder.store(result, place(target_, offset), align=8)
            following = builder.add(offset, _integer(WIDTH))
            offset.add_incoming(following, builder.block)
            builder.cbranch(builder.icmp_signed("<", following, n_), loop, done)
            builder.position_at_end(done)
            return context.get_dummy_value()

        return signature, write

    return intrinsic(weighted_sum)


def _compared(operator: str) -> Any:
    """The one of two numbers that compares so with the other, else the other."""

    def choice(typing: Any, a: Any, b: Any) -> Any:
        del typing, a, b

        def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            del context, signature
            a, b = arguments
            return builder.select(builder.fcmp_ordered(operator, a, b), a, b)

        return types.float64(types.float64, types.float64), write

    return intrinsic(choice)


greater, lesser = _compared(">"), _compared("<")


@intrinsic
def root(typing: Any, a: Any) -> Any:
    """The square root."""
    del typing, a

    def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del context, signature
        function = ir.FunctionType(_double, [_double])
        return builder.call(
            cgutils.get_or_insert_function(builder.module, function, "llvm.sqrt.f64"), arguments
        )

    return types.float64(types.float64), write


def _converted(into: Callable[[Any, Any], Any]) -> Callable[..., Any]:
    """What writes one instruction on one number."""

    def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del context, signature
        return into(builder, arguments[0])

    return write


@intrinsic
def whole(typing: Any, a: Any) -> Any:
    """A real number without its fraction, as an integer."""
    del typing, a
    return types.int64(types.float64), _converted(lambda builder, x: builder.fptosi(x, _integer))


@intrinsic
def with_bits(typing: Any, a: Any) -> Any:
    """The real number that has the bits of an integer."""
    del typing, a
    return types.float64(types.int64), _converted(lambda builder, x: builder.bitcast(x, _double))
