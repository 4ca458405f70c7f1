"""What the compiled loop is made with: C functions, a call by address, and a weighted sum of rows.

    @compiled                              the function as numba compiles it, alone and once
    call(address, t, y, i, c, out, j)      f(t, &y[i], &c[0], &out[j])
    linear(row)(work, n, target, base, h)  work[target] = work[base] + h Σ_j row[j] work[j]
    rowwise(formula)(work, w, n, ...)      a formula of rows, eight numbers at a time, and the largest of its results
    greater(a, b), lesser(a, b)            a if a > b else b, a if a < b else b
    root(a), whole(a)                      sqrt(a), int(a)
    bits(a), with_bits(i)                  the 64 bits of a real number as an integer, and back

The scalar ones are instructions; what numba makes of max, min, sqrt and int tests for exceptions or calls a library.

A kernel has the signature ``void f(double t, const double *y, const double *c, double *out)``. It is called through
its address and not through a numba function type, so that one compiled integrator serves every model. ``y``, ``c``,
``out`` and ``work`` are pointers. The rows of ``work`` are padded to a multiple of `WIDTH` numbers: a sum is then
whole vector registers, with nothing left over and no test for overlap.
"""

from __future__ import annotations

import inspect
import math
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


class Eight:
    """Eight numbers, of a row or all the same, in a formula."""

    def __init__(self, builder: Any, value: Any) -> None:
        self.builder, self.value = builder, value

    def _of(self, other: Any) -> Any:
        return other.value if isinstance(other, Eight) else _all_of(float(other))

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

    def __rtruediv__(self, other: Any) -> Eight:
        return self._with("fdiv", other, self)

    def __abs__(self) -> Eight:
        return self._bitwise(lambda b, x: b.and_(x, _bits_of((1 << 63) - 1)))

    def _bitwise(self, of: Callable[[Any, Any], Any]) -> Eight:
        """What a function of their bits makes."""
        b = self.builder
        result = of(b, b.bitcast(self.value, ir.VectorType(_integer, WIDTH)))
        return Eight(b, b.bitcast(result, ir.VectorType(_double, WIDTH)))

    def times_plus(self, factor: Eight, more: Eight) -> Eight:
        """The product with more added, with one rounding where the machine can."""
        vector = self.value.type
        fma = cgutils.get_or_insert_function(
            self.builder.module, ir.FunctionType(vector, [vector] * 3), f"llvm.fmuladd.v{WIDTH}f64"
        )
        return Eight(self.builder, self.builder.call(fma, [self.value, factor.value, more.value]))

    def greater(self, other: Eight) -> Eight:
        """Of each pair."""
        b = self.builder
        return Eight(b, b.select(b.fcmp_ordered(">", self.value, other.value), self.value, other.value))

    def logarithm2(self) -> Eight:
        """log₂ of numbers >= 0 within 0.01, -1023 of 0: their exponents, and a parabola of what is left, 1 <= m < 2."""
        one, shifted = 0x3FF << 52, 0x433 << 52  # of the second number the last bits are an integer
        exponent = self._bitwise(lambda b, x: b.or_(b.lshr(x, _bits_of(52)), _bits_of(shifted)))
        m = self._bitwise(lambda b, x: b.or_(b.and_(x, _bits_of((1 << 52) - 1)), _bits_of(one)))
        return exponent - (2.0**52 + 1023.0) + ((2.0 - m * (1.0 / 3.0)) * m - 5.0 / 3.0)

    def total(self, of: Callable[[Eight, Eight], Eight]) -> Any:
        """What ``of`` two at a time leaves of the eight."""
        b, left = self.builder, self
        for k in (4, 2, 1):
            places = ir.Constant(
                ir.VectorType(ir.IntType(32), WIDTH), [(i + k) % WIDTH for i in range(WIDTH)]
            )
            left = of(left, Eight(b, b.shuffle_vector(left.value, left.value, places)))
        return b.extract_element(left.value, ir.IntType(32)(0))


def _all_of(number: float) -> Any:
    return ir.Constant(ir.VectorType(_double, WIDTH), [_double(number)] * WIDTH)


def _bits_of(number: int) -> Any:
    return ir.Constant(ir.VectorType(_integer, WIDTH), [_integer(number)] * WIDTH)


def _splat(builder: Any, scalar: Any) -> Any:
    """A number eight times."""
    nothing = ir.Constant(ir.VectorType(_double, WIDTH), ir.Undefined)
    one = builder.insert_element(nothing, scalar, ir.IntType(32)(0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(one, nothing, zeros)


class _Rows:
    """The rows of ``work``, eight numbers of each, as a formula reads and writes them."""

    def __init__(self, builder: Any, work: Any, w: Any, offset: Any) -> None:
        self.builder, self.work, self.w, self.offset = builder, work, w, offset

    def _place(self, row: Any) -> Any:
        b = self.builder
        index = b.add(b.mul(self.w, _integer(row) if isinstance(row, int) else row), self.offset)
        return b.bitcast(b.gep(self.work, [index]), ir.VectorType(_double, WIDTH).as_pointer())

    def __getitem__(self, row: Any) -> Eight:
        return Eight(self.builder, self.builder.load(self._place(row), align=8))

    def __setitem__(self, row: Any, value: Eight) -> None:
        self.builder.store(value.value, self._place(row), align=8)


def rowwise(formula: Callable[..., Eight | None]) -> Any:
    """Compiled ``(work, w, n, *more)``: a formula of the rows of ``work``, of which it reads and writes eight numbers at
    a time, of numbers, and of arrays of length n, after which stands 1.

    The largest of its results is that of the whole, nan if one of them is.
    """

    def over_rows(typing: Any, work: Any, w: Any, n: Any, *more: Any) -> Any:
        del typing, w, n

        def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            del context, signature
            work_, w_, n_, *more_ = arguments
            vector = ir.VectorType(_double, WIDTH)
            largest = cgutils.alloca_once_value(builder, _all_of(-math.inf))
            doubt = cgutils.alloca_once_value(builder, _all_of(0.0))
            places = ir.Constant(ir.VectorType(_integer, WIDTH), [_integer(k) for k in range(WIDTH)])
            with cgutils.for_range_slice(builder, _integer(0), w_, _integer(WIDTH)) as (offset, _):

                def given(kind: Any, value: Any) -> Eight:
                    if kind is types.float64:
                        return Eight(builder, _splat(builder, value))
                    left = builder.bitcast(builder.sub(n_, offset), _double)  # only its bits
                    left = builder.bitcast(_splat(builder, left), places.type)
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
                        builder, builder.call(load, [pointer, ir.IntType(32)(8), there, _all_of(1.0)])
                    )

                rows = _Rows(builder, work_, w_, offset)
                result = formula(rows, *(given(kind, value) for kind, value in zip(more, more_, strict=True)))
                if result is not None:
                    builder.store(result.greater(Eight(builder, builder.load(largest))).value, largest)
                    builder.store((result * 0.0 + Eight(builder, builder.load(doubt))).value, doubt)
            if result is None:
                return _double(0.0)
            most = Eight(builder, builder.load(largest)).total(Eight.greater)
            return builder.fadd(most, Eight(builder, builder.load(doubt)).total(Eight.__add__))

        return types.float64(work, types.int64, types.int64, *more), write

    names = ("typing", "work", "w", "n", *list(inspect.signature(formula).parameters)[1:])
    kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
    over_rows.__signature__ = inspect.Signature([inspect.Parameter(name, kind) for name in names])  # type: ignore[attr-defined]
    return intrinsic(over_rows)


@intrinsic
def copied(typing: Any, work: Any, w: Any, source: Any, target: Any) -> Any:
    """Row ``target`` of ``work`` becomes row ``source``."""
    del typing, source, target

    def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del signature
        work_, w_, source_, target_ = arguments
        with cgutils.for_range_slice(builder, _integer(0), w_, _integer(WIDTH)) as (offset, _):
            rows = _Rows(builder, work_, w_, offset)
            rows[target_] = rows[source_]
        return context.get_dummy_value()

    return types.void(work, types.int64, types.int64, types.int64), write


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

            def splat(scalar: Any) -> Any:
                one = builder.insert_element(ir.Constant(vector, ir.Undefined), scalar, ir.IntType(32)(0))
                zeros = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
                return builder.shuffle_vector(one, ir.Constant(vector, ir.Undefined), zeros)

            def all_of(number: float) -> Any:
                return ir.Constant(vector, [_double(number)] * WIDTH)

            def at(index: Any) -> Any:
                return builder.bitcast(builder.gep(work_, [index]), vector.as_pointer())

            def place(number: Any, offset: Any) -> Any:
                return at(builder.add(builder.mul(number, n_), offset))

            def load(number: int, offset: Any) -> Any:
                return builder.load(place(_integer(number), offset), align=8)

            step = builder.load(at(h_), align=8) if lanes else splat(h_)
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
def bits(typing: Any, a: Any) -> Any:
    """The bits of a real number as an integer."""
    del typing, a
    return types.int64(types.float64), _converted(lambda builder, x: builder.bitcast(x, _integer))


@intrinsic
def with_bits(typing: Any, a: Any) -> Any:
    """The real number that has the bits of an integer."""
    del typing, a
    return types.float64(types.int64), _converted(lambda builder, x: builder.bitcast(x, _double))
