"""What the compiled loops over eight runs need besides `machine`: instructions on the eight numbers of a register.

Memory holds component i of lane l at 8 i + l of a row; what there is one of per lane, at l of a place. Each function
does to every lane what its neighbour in `machine`, `stepping` or `taylor` does to one, with the same roundings.
"""

from __future__ import annotations

import math
from typing import Any

from llvmlite import ir

from .layout import WIDTH
from .rows import Eight, all_of, bits_of
from .translation import REAL, WHOLE, called, counted, instruction, variable

_eight = ir.VectorType(REAL, WIDTH)
_wholes = ir.VectorType(WHOLE, WIDTH)


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
        return called(self.builder, f"llvm.{name}.v{WIDTH}f64", _eight, *arguments)

    def fused(self, a: Any, b: Any, c: Any) -> Any:
        return self.called("fmuladd", a, b, c)

    def greater(self, a: Any, b: Any) -> Any:
        return Eight(self.builder, a).greater(Eight(self.builder, b)).value

    def variable(self, value: Any) -> Any:
        return variable(self.builder, value)

    def rows(self, w: Any) -> Any:
        """Goes through the components of a row: `with` gives their places."""
        return counted(self.builder, w, WIDTH)

    def plus(self, place: Any, offset: Any, rows: int = 0, w: Any = None) -> Any:
        """``place`` + ``offset`` + ``rows`` w."""
        place = self.builder.add(place, offset)
        return place if rows == 0 else self.builder.add(place, self.builder.mul(WHOLE(rows), w))

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


@instruction("int", "Reals", "int", "Reals", "int", "Reals", "Reals", "int")
def call_wide(builder: Any, address: Any, t: Any, i: Any, y: Any, j: Any, c: Any, out: Any, k: Any) -> None:
    """Call the kernel for eight lanes on times ``t[i:]`` and states ``y[j:]``; it writes ``out[k:]``."""
    kernel = ir.FunctionType(ir.VoidType(), [REAL.as_pointer()] * 4)
    builder.call(
        builder.inttoptr(address, kernel.as_pointer()),
        [builder.gep(t, [i]), builder.gep(y, [j]), c, builder.gep(out, [k])],
    )


def lengths(order: int, terms: int, tiny: float) -> Any:
    """Compiled ``(wide, w, series, state, tolerances, rates, result)``: see `taylor.given`.

    At ``result`` stand the lengths of the steps, infinite for a polynomial, nan where a coefficient is not finite. The
    coefficients y_0 begin at ``series``; ``tolerances`` are rows of the absolute and the relative ones; at ``rates``
    stands log₂ r / p.
    """

    @instruction("Reals", "int", "int", "int", "Reals", "int", "int")
    def lengths(
        builder: Any, wide: Any, w: Any, series: Any, state: Any, tolerances: Any, rates: Any, result: Any
    ) -> None:
        v = _Eight(builder, wide)
        maxima = [v.variable(all_of(tiny)) for _ in range(terms)]
        total = v.variable(all_of(0.0))
        with v.rows(w) as offset:
            size = v.called("fabs", v.load(v.plus(state, offset)))
            relative = v.load(builder.add(w, offset), tolerances)
            allowed = builder.fadd(v.load(offset, tolerances), builder.fmul(relative, size))
            scale = builder.fdiv(all_of(1.0), allowed)
            for j, most in enumerate(maxima):
                part = v.called("fabs", v.load(v.plus(series, offset, order - j, w)))
                part = builder.fmul(part, scale)
                builder.store(v.greater(builder.load(most), part), most)
                builder.store(builder.fadd(builder.load(total), part), total)
        none = all_of(-1e300)
        slowest, rate = none, v.load(rates)
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
        v.store(builder.select(finite, found, all_of(math.nan)), result)

    return lengths


def series_end(order: int) -> Any:
    """Compiled ``(wide, w, series, state, lost, loses, raw, steps, errors)``: see `taylor.attempt`.

    Row ``raw`` is the polynomial at the end of the ``steps``, row ``loses`` what its last sum loses to rounding; at
    ``errors`` stands 0, or nan where it is not finite.
    """

    @instruction("Reals", "int", "int", "int", "int", "int", "int", "int", "int")
    def series_end(
        builder: Any,
        wide: Any,
        w: Any,
        series: Any,
        state: Any,
        lost: Any,
        loses: Any,
        raw: Any,
        steps: Any,
        errors: Any,
    ) -> None:
        v = _Eight(builder, wide)
        h = v.load(steps)
        twice = builder.fmul(h, h)
        sizes = v.variable(all_of(0.0))
        with v.rows(w) as offset:
            # Σ y_(k+1) h^k: the odd and the even powers side by side, since one addition waits for the other
            sides: dict[int, Any] = {}
            for k in range(order, 0, -1):
                term, side = v.load(v.plus(series, offset, k, w)), k % 2
                sides[side] = v.fused(sides[side], twice, term) if side in sides else term
            change = builder.fmul(h, v.fused(sides[0], h, sides[1]))
            change = builder.fadd(change, v.load(v.plus(lost, offset)))
            start = v.load(v.plus(state, offset))
            end = builder.fadd(start, change)
            part = builder.fsub(end, start)
            error = builder.fsub(start, builder.fsub(end, part))
            v.store(builder.fadd(error, builder.fsub(change, part)), v.plus(loses, offset))
            v.store(end, v.plus(raw, offset))
            builder.store(builder.fadd(builder.load(sizes), v.called("fabs", end)), sizes)
        finite = builder.fcmp_ordered("<", builder.load(sizes), all_of(math.inf))
        v.store(builder.select(finite, all_of(0.0), all_of(math.nan)), errors)

    return series_end


def decaying(order: int, bound: float) -> Any:
    """Compiled ``(wide, w, last, steps, result)``: see `taylor.limited`.

    At ``result`` stands 1 or 0; row ``last`` is y_p."""

    @instruction("Reals", "int", "int", "int", "int")
    def decaying(builder: Any, wide: Any, w: Any, last: Any, steps: Any, result: Any) -> None:
        v = _Eight(builder, wide)
        sums = [v.variable(all_of(0.0)) for _ in range(3)]
        with v.rows(w) as offset:
            place = v.plus(last, offset)
            a = builder.fmul(all_of(float(order)), v.load(place))
            b = v.load(builder.sub(place, w))
            for total, (x, y) in zip(sums, ((a, a), (b, b), (a, b)), strict=True):
                builder.store(v.fused(x, y, builder.load(total)), total)
        above, below, across = (builder.load(total) for total in sums)
        h, zero = v.load(steps), all_of(0.0)
        fast = builder.fmul(builder.fmul(h, h), above)
        square = builder.fmul(all_of(4.0), builder.fmul(across, across))
        some = builder.fcmp_ordered(">", below, zero)
        for less, more in (
            (builder.fmul(h, across), zero),
            (builder.fmul(above, below), square),
            (builder.fmul(all_of(bound * bound), below), fast),
        ):
            some = builder.and_(some, builder.fcmp_ordered("<", less, more))
        v.store(builder.select(some, all_of(1.0), zero), result)

    return decaying


@instruction("Reals", "int")
def unit_at(builder: Any, wide: Any, place: Any) -> None:
    """The quaternions at ``place`` divided by their norms: see `stepping.normalise`."""
    v = _Eight(builder, wide)
    places = [v.plus(place, WHOLE(WIDTH * j)) for j in range(4)]
    parts = [v.load(place) for place in places]
    total = builder.fmul(parts[0], parts[0])
    for x in parts[1:]:
        total = builder.fadd(total, builder.fmul(x, x))
    norm = v.called("sqrt", total)
    for x, place in zip(parts, places, strict=True):
        v.store(builder.fdiv(x, norm), place)


@instruction("Reals", "int", "int", "int", "int")
def blend(builder: Any, wide: Any, w: Any, source: Any, target: Any, wanted: Any) -> None:
    """Row ``target`` becomes row ``source`` in the lanes in which the number at ``wanted`` is not 0."""
    v = _Eight(builder, wide)
    some = builder.fcmp_unordered("!=", v.load(wanted), all_of(0.0))
    with v.rows(w) as offset:
        place = v.plus(target, offset)
        v.store(builder.select(some, v.load(v.plus(source, offset)), v.load(place)), place)


@instruction("Reals", "int", "int", "int", "int", "int")
def moved(builder: Any, wide: Any, w: Any, source: Any, target: Any, wanted: Any, result: Any) -> None:
    """`blend`; at ``result`` stands the greatest change, relative to 1 + |value|: see `stepping.project`."""
    v = _Eight(builder, wide)
    some = builder.fcmp_unordered("!=", v.load(wanted), all_of(0.0))
    most = v.variable(all_of(0.0))
    with v.rows(w) as offset:
        place = v.plus(target, offset)
        old, new = v.load(place), v.load(v.plus(source, offset))
        size = builder.fadd(all_of(1.0), v.called("fabs", new))
        change = builder.fdiv(v.called("fabs", builder.fsub(new, old)), size)
        builder.store(v.greater(builder.load(most), change), most)
        v.store(builder.select(some, new, old), place)
    v.store(builder.load(most), result)
