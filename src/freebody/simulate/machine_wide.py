"""What the compiled loops over eight runs need besides `machine`: instructions on the eight numbers of a register.

Memory holds component i of lane l at 8 i + l of a row; what there is one of per lane, at l of a place. Each function
does to every lane what its neighbour in `machine`, `stepping` or `taylor` does to one, with the same roundings.
"""

from __future__ import annotations

import math
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from .layout import WIDTH
from .rows import Eight, all_of, bits_of

_double, _integer = ir.DoubleType(), ir.IntType(64)
_eight = ir.VectorType(_double, WIDTH)
_wholes = ir.VectorType(_integer, WIDTH)
_index = types.int64


class _Eight:
    """Writes instructions on registers of eight numbers."""

    def __init__(self, builder: Any, memory: Any) -> None:
        self.builder, self.memory = builder, memory

    def at(self, place: Any, memory: Any = None) -> Any:
        pointer = self.builder.gep(self.memory if memory is None else memory, [place])
        return self.builder.bitcast(pointer, _eight.as_pointer())

    def load(self, place: Any, memory: Any = None) -> Any:
        return self.builder.load(self.at(place, memory), align=8)

    def store(self, value: Any, place: Any) -> None:
        self.builder.store(value, self.at(place), align=8)

    def called(self, name: str, *arguments: Any) -> Any:
        """An intrinsic of LLVM."""
        function = ir.FunctionType(_eight, [_eight] * len(arguments))
        name = f"llvm.{name}.v{WIDTH}f64"
        return self.builder.call(
            cgutils.get_or_insert_function(self.builder.module, function, name), arguments
        )

    def fused(self, a: Any, b: Any, c: Any) -> Any:
        return self.called("fmuladd", a, b, c)

    def greater(self, a: Any, b: Any) -> Any:
        return Eight(self.builder, a).greater(Eight(self.builder, b)).value

    def variable(self, value: Any) -> Any:
        return cgutils.alloca_once_value(self.builder, value)

    def rows(self, w: Any) -> Any:
        """Goes through the components of a row: `with` gives their places."""
        return cgutils.for_range_slice(self.builder, _integer(0), w, _integer(WIDTH))

    def plus(self, place: Any, offset: Any, rows: int = 0, w: Any = None) -> Any:
        """``place`` + ``offset`` + ``rows`` w."""
        place = self.builder.add(place, offset)
        return place if rows == 0 else self.builder.add(place, self.builder.mul(_integer(rows), w))

    def logarithm2(self, x: Any) -> Any:
        return Eight(self.builder, x).logarithm2().value

    def power2(self, x: Any) -> Any:
        """`taylor.power2`."""
        builder = self.builder
        exponent = builder.fptosi(builder.fadd(x, all_of(1023.0)), _wholes)
        r = builder.fsub(x, builder.sitofp(builder.sub(exponent, bits_of(1023)), _eight))
        power = builder.bitcast(builder.shl(exponent, bits_of(52)), _eight)
        bend = self.fused(r, all_of(1.0 / 3.0), all_of(2.0 / 3.0))
        return builder.fmul(power, self.fused(r, bend, all_of(1.0)))


@intrinsic
def call_wide(typing: Any, address: Any, t: Any, i: Any, y: Any, j: Any, c: Any, out: Any, k: Any) -> Any:
    """Call the kernel for eight lanes on times ``t[i:]`` and states ``y[j:]``; it writes ``out[k:]``."""
    del typing
    signature = types.void(types.int64, t, types.int64, y, types.int64, c, out, types.int64)
    del address, i, j, k

    def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del signature
        kernel, t_, i_, y_, j_, c_, out_, k_ = arguments
        pointer = _double.as_pointer()
        function = ir.FunctionType(ir.VoidType(), [pointer] * 4)
        builder.call(
            builder.inttoptr(kernel, function.as_pointer()),
            [builder.gep(t_, [i_]), builder.gep(y_, [j_]), c_, builder.gep(out_, [k_])],
        )
        return context.get_dummy_value()

    return signature, write


def lengths(order: int, terms: int, tiny: float) -> Any:
    """Compiled ``(wide, w, series, state, tolerances, rates, result)``: see `taylor.given`.

    At ``result`` stand the lengths of the steps, infinite for a polynomial, nan where a coefficient is not finite. The
    coefficients y_0 begin at ``series``; ``tolerances`` are rows of the absolute and the relative ones; at ``rates``
    stands log₂ r / p.
    """

    @intrinsic
    def lengths(
        typing: Any, wide: Any, w: Any, series: Any, state: Any, tolerances: Any, rates: Any, result: Any
    ) -> Any:
        del typing, w, series, state, rates, result

        def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            del signature
            wide_, w_, series_, state_, tolerances_, rates_, result_ = arguments
            v = _Eight(builder, wide_)
            maxima = [v.variable(all_of(tiny)) for _ in range(terms)]
            total = v.variable(all_of(0.0))
            with v.rows(w_) as (offset, _):
                size = v.called("fabs", v.load(v.plus(state_, offset)))
                relative = v.load(builder.add(w_, offset), tolerances_)
                allowed = builder.fadd(v.load(offset, tolerances_), builder.fmul(relative, size))
                scale = builder.fdiv(all_of(1.0), allowed)
                for j, most in enumerate(maxima):
                    part = v.called("fabs", v.load(v.plus(series_, offset, order - j, w_)))
                    part = builder.fmul(part, scale)
                    builder.store(v.greater(builder.load(most), part), most)
                    builder.store(builder.fadd(builder.load(total), part), total)
            none = all_of(-1e300)
            slowest, rate = none, v.load(rates_)
            for j, most in enumerate(maxima):
                size = builder.load(most)
                log = v.logarithm2(size)
                if j > 1:
                    log = builder.fadd(log, builder.fmul(all_of(j - 1.0), rate))
                log = builder.fmul(log, all_of(1.0 / (order - j)))
                some = builder.fcmp_ordered(">", size, all_of(tiny))
                slowest = builder.select(some, v.greater(slowest, log), slowest)
            found = v.power2(builder.fneg(slowest))
            infinite = all_of(math.inf)
            found = builder.select(builder.fcmp_ordered("==", slowest, none), infinite, found)
            finite = builder.fcmp_ordered("<", builder.load(total), infinite)
            v.store(builder.select(finite, found, all_of(math.nan)), result_)
            return context.get_dummy_value()

        places = [_index] * 3
        return types.void(wide, *places, tolerances, _index, _index), write

    return lengths


def series_end(order: int) -> Any:
    """Compiled ``(wide, w, series, state, lost, loses, raw, steps, errors)``: see `taylor.attempt`.

    Row ``raw`` is the polynomial at the end of the ``steps``, row ``loses`` what its last sum loses to rounding; at
    ``errors`` stands 0, or nan where it is not finite.
    """

    @intrinsic
    def series_end(
        typing: Any, wide: Any, w: Any, series: Any, state: Any, lost: Any, loses: Any, raw: Any, steps: Any,
        errors: Any,
    ) -> Any:  # fmt: skip
        del typing, w, series, state, lost, loses, raw, steps, errors

        def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            del signature
            wide_, w_, series_, state_, lost_, loses_, raw_, steps_, errors_ = arguments
            v = _Eight(builder, wide_)
            h = v.load(steps_)
            twice = builder.fmul(h, h)
            sizes = v.variable(all_of(0.0))
            with v.rows(w_) as (offset, _):
                # Σ y_(k+1) h^k: the odd and the even powers side by side, since one addition waits for the other
                sides: dict[int, Any] = {}
                for k in range(order, 0, -1):
                    term, side = v.load(v.plus(series_, offset, k, w_)), k % 2
                    sides[side] = v.fused(sides[side], twice, term) if side in sides else term
                change = builder.fmul(h, v.fused(sides[0], h, sides[1]))
                change = builder.fadd(change, v.load(v.plus(lost_, offset)))
                start = v.load(v.plus(state_, offset))
                end = builder.fadd(start, change)
                part = builder.fsub(end, start)
                error = builder.fsub(start, builder.fsub(end, part))
                v.store(builder.fadd(error, builder.fsub(change, part)), v.plus(loses_, offset))
                v.store(end, v.plus(raw_, offset))
                builder.store(builder.fadd(builder.load(sizes), v.called("fabs", end)), sizes)
            finite = builder.fcmp_ordered("<", builder.load(sizes), all_of(math.inf))
            v.store(builder.select(finite, all_of(0.0), all_of(math.nan)), errors_)
            return context.get_dummy_value()

        return types.void(wide, *[_index] * 8), write

    return series_end


def decaying(order: int, bound: float) -> Any:
    """Compiled ``(wide, w, last, steps, result)``: see `taylor.limited`.

    At ``result`` stands 1 or 0; row ``last`` is y_p."""

    @intrinsic
    def decaying(typing: Any, wide: Any, w: Any, last: Any, steps: Any, result: Any) -> Any:
        del typing, w, last, steps, result

        def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            del signature
            wide_, w_, last_, steps_, result_ = arguments
            v = _Eight(builder, wide_)
            sums = [v.variable(all_of(0.0)) for _ in range(3)]
            with v.rows(w_) as (offset, _):
                place = v.plus(last_, offset)
                a = builder.fmul(all_of(float(order)), v.load(place))
                b = v.load(builder.sub(place, w_))
                for total, (x, y) in zip(sums, ((a, a), (b, b), (a, b)), strict=True):
                    builder.store(v.fused(x, y, builder.load(total)), total)
            above, below, across = (builder.load(total) for total in sums)
            h, zero = v.load(steps_), all_of(0.0)
            fast = builder.fmul(builder.fmul(h, h), above)
            square = builder.fmul(all_of(4.0), builder.fmul(across, across))
            some = builder.fcmp_ordered(">", below, zero)
            for less, more in (
                (builder.fmul(h, across), zero),
                (builder.fmul(above, below), square),
                (builder.fmul(all_of(bound * bound), below), fast),
            ):
                some = builder.and_(some, builder.fcmp_ordered("<", less, more))
            v.store(builder.select(some, all_of(1.0), zero), result_)
            return context.get_dummy_value()

        return types.void(wide, *[_index] * 4), write

    return decaying


@intrinsic
def unit_at(typing: Any, wide: Any, place: Any) -> Any:
    """The quaternions at ``place`` divided by their norms: see `stepping.normalise`."""
    del typing, place

    def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del signature
        v = _Eight(builder, arguments[0])
        places = [v.plus(arguments[1], _integer(WIDTH * j)) for j in range(4)]
        parts = [v.load(place) for place in places]
        total = builder.fmul(parts[0], parts[0])
        for x in parts[1:]:
            total = builder.fadd(total, builder.fmul(x, x))
        norm = v.called("sqrt", total)
        for x, place in zip(parts, places, strict=True):
            v.store(builder.fdiv(x, norm), place)
        return context.get_dummy_value()

    return types.void(wide, _index), write


@intrinsic
def blend(typing: Any, wide: Any, w: Any, source: Any, target: Any, wanted: Any) -> Any:
    """Row ``target`` becomes row ``source`` in the lanes in which the number at ``wanted`` is not 0."""
    del typing, w, source, target, wanted

    def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del signature
        wide_, w_, source_, target_, wanted_ = arguments
        v = _Eight(builder, wide_)
        some = builder.fcmp_unordered("!=", v.load(wanted_), all_of(0.0))
        with v.rows(w_) as (offset, _):
            place = v.plus(target_, offset)
            v.store(builder.select(some, v.load(v.plus(source_, offset)), v.load(place)), place)
        return context.get_dummy_value()

    return types.void(wide, *[_index] * 4), write


@intrinsic
def moved(typing: Any, wide: Any, w: Any, source: Any, target: Any, wanted: Any, result: Any) -> Any:
    """`blend`; at ``result`` stands the greatest change, relative to 1 + |value|: see `stepping.project`."""
    del typing, w, source, target, wanted, result

    def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del signature
        wide_, w_, source_, target_, wanted_, result_ = arguments
        v = _Eight(builder, wide_)
        some = builder.fcmp_unordered("!=", v.load(wanted_), all_of(0.0))
        most = v.variable(all_of(0.0))
        with v.rows(w_) as (offset, _):
            place = v.plus(target_, offset)
            old, new = v.load(place), v.load(v.plus(source_, offset))
            size = builder.fadd(all_of(1.0), v.called("fabs", new))
            change = builder.fdiv(v.called("fabs", builder.fsub(new, old)), size)
            builder.store(v.greater(builder.load(most), change), most)
            v.store(builder.select(some, new, old), place)
        v.store(builder.load(most), result_)
        return context.get_dummy_value()

    return types.void(wide, *[_index] * 5), write
