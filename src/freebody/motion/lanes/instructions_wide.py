"""Instructions on the eight numbers of a register, which the compiled loops over eight runs need besides
`instructions`.

Memory holds component i of lane l at 8 i + l of a row, and a number that exists once per lane at l of a place. Each
function does to every lane what its counterpart in `instructions`, `step_control` or `taylor` does to one lane, with
the same rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from llvmlite import ir

from ...native.arithmetic import REAL, WHOLE, splat
from ...native.functions import Instruction, counted, instruction, variable
from ...native.instructions import EPS
from ...native.record_access import Table
from ...native.records import WIDTH
from ...native.row_arithmetic import Eight, FormulaRows, all_of, arguments_of, bits_of
from ..ode.step_control import TINY
from .lanes_layout import (
    AFTER_REJECTION,
    AFTERS,
    EARLIER_STEPS,
    EASY,
    ENDS,
    ERRORS,
    LEG_END,
    LIMITED,
    NEXT_OUTPUT,
    RUN,
    SELECTED,
    STEPS,
    STRIDE,
    SUSPECT,
    TAKEN,
    TIMES,
    WIDE_PLACES,
)


class Memory:
    """Eight numbers at places of memory, for use in formulas."""

    def __init__(self, builder: Any, memory: Any) -> None:
        self.builder, self.memory = builder, memory

    def _pointer(self, place: Any, memory: Any) -> Any:
        pointer = self.builder.gep(self.memory if memory is None else memory, [place])
        return self.builder.bitcast(pointer, ir.VectorType(REAL, WIDTH).as_pointer())

    def load(self, place: Any, memory: Any = None) -> Eight:
        """Return the eight numbers at a place."""
        return Eight(self.builder, self.builder.load(self._pointer(place, memory), align=8))

    def store(self, eight: Eight, place: Any) -> None:
        """Store eight numbers at a place."""
        self.builder.store(eight.value, self._pointer(place, None), align=8)

    def variable(self, number: float) -> _Variable:
        """Return eight variables with the same initial value."""
        return _Variable(self.builder, number)

    def rows(self, w: Any) -> Any:
        """Loop over the components of a row: `with` gives their offsets."""
        return counted(self.builder, w, WIDTH)

    def plus(self, place: Any, offset: Any, rows: int = 0, w: Any = None) -> Any:
        """Return ``place`` + ``offset`` + ``rows`` w."""
        place = self.builder.add(place, offset)
        return place if rows == 0 else self.builder.add(place, self.builder.mul(WHOLE(rows), w))


class _Variable:
    """Eight variables."""

    def __init__(self, builder: Any, number: float) -> None:
        self.builder, self.place = builder, variable(builder, all_of(number))

    @property
    def now(self) -> Eight:
        return Eight(self.builder, self.builder.load(self.place))

    def become(self, eight: Eight) -> None:
        self.builder.store(eight.value, self.place)


@instruction("int", "Reals", "int", "Reals", "int", "Reals", "Reals", "int")
def call_wide(builder: Any, address: Any, t: Any, i: Any, y: Any, j: Any, c: Any, out: Any, k: Any) -> None:
    """Call the kernel for eight lanes on times ``t[i:]`` and states ``y[j:]``; it writes ``out[k:]``."""
    kernel = ir.FunctionType(ir.VoidType(), [REAL.as_pointer()] * 4)
    builder.call(
        builder.inttoptr(address, kernel.as_pointer()),
        [builder.gep(t, [i]), builder.gep(y, [j]), c, builder.gep(out, [k])],
    )


def linear(row: Mapping[int, float], chained: bool = False) -> Any:
    """Return the instruction ``(wide, w, target, base, h)``: row ``target`` becomes base + h Σ_j row[j] wide[j].

    ``base`` < 0 stands for a row of zeros, and ``h`` is the place in ``wide`` of the steps. With ``chained``, the
    roundings are those of `row_arithmetic.chain`.
    """
    terms = sorted(row.items())
    early, (late, weight) = terms[:-1] if chained else terms, terms[-1]

    def weighted_sum(builder: Any, wide: Any, w: Any, target: Any, base: Any, h: Any) -> None:
        v = Memory(builder, wide)
        step, based = v.load(h), builder.icmp_signed(">=", base, WHOLE(0))
        safe_base = builder.select(based, base, WHOLE(0))
        with v.rows(w) as offset:
            total = None
            for k, coefficient in early:
                number = v.load(v.plus(WHOLE(0), offset, k, w))
                total = number * coefficient if total is None else number.times_plus(coefficient, total)
            result = v.load(builder.add(builder.mul(safe_base, w), offset)).where(based, 0.0)
            if total is not None:
                result = step.times_plus(total, result)
            if chained:
                result = (step * weight).times_plus(v.load(v.plus(WHOLE(0), offset, late, w)), result)
            v.store(result, builder.add(builder.mul(target, w), offset))

    return Instruction(weighted_sum, "Reals", "int", "int", "int", "int")


def lanewise(formula: Callable[..., Eight], places: Mapping[str, int], height: int) -> Any:
    """Return the compiled ``(wide, w, result, *more)``: a formula as for `row_arithmetic.rowwise`, of eight runs side
    by side.

    ``places`` are the numbers of the rows by name; those from ``height`` on follow the places of the lanes, and k and
    terms are several rows.

    ``more`` are places of eight numbers, one for each run, and arrays with one number for each component of each run.
    At ``result`` it stores the largest result of each run, nan if one of its results is nan.
    """

    def over_lanes(builder: Any, wide: Any, w: Any, result: Any, *more: Any) -> None:
        v = Memory(builder, wide)
        largest, doubt = v.variable(-math.inf), v.variable(0.0)
        of_runs = {k: v.load(x) for k, x in enumerate(more) if x.type == WHOLE}

        def rows(name: str) -> Any:
            place = builder.mul(w, WHOLE(places[name]))
            place = builder.add(place, WHOLE(WIDE_PLACES)) if places[name] >= height else place
            first = builder.gep(wide, [place])
            return Table(first, w) if name in ("k", "terms") else first

        with v.rows(w) as offset:
            arguments = [of_runs.get(k) or v.load(offset, x) for k, x in enumerate(more)]
            results = formula(FormulaRows(builder, rows, offset), *arguments)
            largest.become(results.greater(largest.now))
            doubt.become(results * 0.0 + doubt.now)
        v.store(largest.now + doubt.now, result)

    return Instruction(over_lanes, "Reals", "int", "int", *arguments_of(formula))


def lengths(order: int, terms: int, tiny: float) -> Any:
    """Return the compiled ``(wide, w, series, state, tolerances, rates, result)`` (`taylor.predicted_length`).

    It stores the lengths of the steps at ``result``: infinite for a polynomial, nan if a coefficient is not finite. The
    coefficients y_0 begin at ``series``. ``tolerances`` are rows of absolute and relative tolerances. ``rates`` is the
    place of log₂ r / p.
    """

    @instruction("Reals", "int", "int", "int", "Reals", "int", "int")
    def lengths(
        builder: Any, wide: Any, w: Any, series: Any, state: Any, tolerances: Any, rates: Any, result: Any
    ) -> None:
        v = Memory(builder, wide)
        maxima = [v.variable(tiny) for _ in range(terms)]
        total = v.variable(0.0)
        with v.rows(w) as offset:
            relative = v.load(builder.add(w, offset), tolerances)
            size = abs(v.load(v.plus(state, offset)))
            scale = 1.0 / (v.load(offset, tolerances) + relative * size)
            for j, most in enumerate(maxima):
                part = abs(v.load(v.plus(series, offset, order - j, w))) * scale
                most.become(most.now.greater(part))
                total.become(total.now + part)
        rate, none = v.load(rates), Eight(builder, all_of(-1e300))
        slowest = none
        for j, most in enumerate(maxima):
            log = most.now.logarithm2()
            if j > 1:
                log = log + rate * (j - 1.0)
            log = log * (1.0 / (order - j))
            slowest = slowest.greater(log).where(most.now.compared(">", tiny), slowest)
        steps = (slowest * -1.0).power2()
        steps = Eight(builder, all_of(math.inf)).where(slowest.compared("==", none), steps)
        v.store(steps.where(total.now.compared("<", math.inf), math.nan), result)

    return lengths


def decaying(order: int, bound: float, early: int, grown: float) -> Any:
    """Return the compiled ``(wide, w, last, steps, result)`` (`taylor.limited_by_stability`).

    It stores 1 or 0 at ``result``. Row ``last`` is y_p.
    """

    @instruction("Reals", "int", "int", "int", "int")
    def decaying(builder: Any, wide: Any, w: Any, last: Any, steps: Any, result: Any) -> None:
        v = Memory(builder, wide)
        h = v.load(steps)

        def terms(offset: Any) -> tuple[Any, Eight, Eight]:
            place = v.plus(last, offset)
            return place, v.load(place) * float(order), v.load(builder.sub(place, w))

        above, below, across, first = (v.variable(0.0) for _ in range(4))
        with v.rows(w) as offset:
            _, a, b = terms(offset)
            above.become(a.times_plus(a, above.now))
            below.become(b.times_plus(b, below.now))
        mask = (below.now * (bound * bound)).compared("<", h * h * above.now)
        mask = builder.and_(mask, below.now.compared(">", 0.0))
        v.store(Eight(builder, all_of(0.0)), result)
        with builder.if_then(any_of(builder, mask)):
            with v.rows(w) as offset:
                place, a, b = terms(offset)
                c = v.load(v.plus(place, WHOLE(0), early - order, w))
                across.become(a.times_plus(b, across.now))
                first.become(c.times_plus(c, first.now))
            growth = above.now.root() * grown
            for _ in range(order - early):
                growth = growth * abs(h)
            for less, more in (
                (h * across.now, 0.0),
                (above.now * below.now, across.now * across.now * 4.0),
            ):
                mask = builder.and_(mask, less.compared("<", more))
            mask = builder.and_(mask, first.now.root().compared("<=", growth))
            v.store(Eight(builder, all_of(1.0)).where(mask, 0.0), result)

    return decaying


def any_of(builder: Any, mask: Any) -> Any:
    """Return true if one of eight is in a mask."""
    return builder.icmp_unsigned("!=", builder.bitcast(mask, ir.IntType(WIDTH)), ir.IntType(WIDTH)(0))


def _are_all(builder: Any, mask: Any) -> Any:
    """Return true if all of eight are in a mask."""
    return builder.icmp_unsigned("==", builder.bitcast(mask, ir.IntType(WIDTH)), ir.IntType(WIDTH)(255))


class _Lane:
    """The numbers that the loop over eight lanes keeps for them: eight at each place, real or integer."""

    def __init__(self, builder: Any, wide: Any, more: Any, control: Any, counts: Any) -> None:
        self.builder, self.more = builder, more
        self.wide, self.control, self.counts = Memory(builder, wide), Memory(builder, control), counts

    def now(self, place: int) -> Eight:
        return self.wide.load(self.builder.add(self.more, WHOLE(place)))

    def become(self, place: int, eight: Eight) -> None:
        self.wide.store(eight, self.builder.add(self.more, WHOLE(place)))

    def _of_counts(self, place: int) -> Any:
        pointer = self.builder.gep(self.counts, [WHOLE(place)])
        return self.builder.bitcast(pointer, ir.VectorType(WHOLE, WIDTH).as_pointer())

    def count(self, place: int) -> Any:
        return self.builder.load(self._of_counts(place), align=8)

    def become_count(self, place: int, value: Any) -> None:
        self.builder.store(value, self._of_counts(place), align=8)

    def all(self, *masks: Any) -> Any:
        """Return the lanes that are in every mask."""
        result = masks[0]
        for mask in masks[1:]:
            result = self.builder.and_(result, mask)
        return result


@instruction("Reals", "int", "int", "Reals", "Integers", "float", "float")
def settled(
    builder: Any, wide: Any, more: Any, length: Any, control: Any, counts: Any, direction: Any, longest: Any
) -> Any:  # fmt: skip
    """Set steps and their ends in the lanes in which the length at ``length`` can be taken without further checks.

    These are lanes without a rejected step before, an end of the leg or an output time in the step, and with a length
    that is neither too long nor too short. EASY becomes 1 there, else 0. Return true if these are all lanes.
    """
    v = _Lane(builder, wide, more, control, counts)
    sign, most = (Eight(builder, splat(builder, x, WIDTH)) for x in (direction, longest))
    t, old = v.now(TIMES), v.now(STEPS)
    size = abs(v.wide.load(builder.add(more, length)))
    h = sign * size
    after = t + h
    easy = v.all(
        builder.icmp_signed(">=", v.count(RUN), bits_of(0)),
        builder.icmp_signed("==", v.count(AFTER_REJECTION), bits_of(0)),
        size.compared("<=", most),
        size.compared(">", abs(t) * (8.0 * EPS)),
        size.compared(">=", TINY),
        ((t + h * 1.01 - v.control.load(WHOLE(LEG_END))) * sign).compared("<", 0.0),
        ((v.control.load(WHOLE(NEXT_OUTPUT)) - after) * sign).compared(">", 0.0),
    )
    v.become(STEPS, h.where(easy, old))
    v.become(AFTERS, after.where(easy, v.now(AFTERS)))
    v.become(EASY, Eight(builder, all_of(1.0)).where(easy, 0.0))
    v.become_count(ENDS, builder.select(easy, bits_of(0), v.count(ENDS)))
    return _are_all(builder, easy)


@instruction("Reals", "int", "Reals", "Integers", "int", "int")
def taken(builder: Any, wide: Any, more: Any, control: Any, counts: Any, budget: Any, limit: Any) -> Any:
    """Take the steps of `settled` that are good and after which nothing else has to be done.

    EASY becomes 1 there, else 0. Return true if these are all lanes.
    """
    v = _Lane(builder, wide, more, control, counts)
    number = builder.add(v.count(TAKEN), bits_of(1))

    def all_of_them(whole: Any) -> Any:
        return splat(builder, whole, WIDTH)

    easy = v.all(
        v.now(EASY).compared("==", 1.0),
        v.now(ERRORS).compared("<=", 1.0),
        v.now(LIMITED).compared("==", 0.0),
        builder.icmp_signed("==", v.count(SUSPECT), bits_of(0)),
        builder.icmp_signed("!=", number, all_of_them(budget)),
        builder.icmp_signed("<", builder.add(number, v.count(EARLIER_STEPS)), all_of_them(limit)),
    )
    one, stride = Eight(builder, all_of(1.0)), v.control.load(WHOLE(STRIDE))
    v.become_count(TAKEN, builder.select(easy, number, v.count(TAKEN)))
    v.control.store(stride.greater(abs(v.now(STEPS))).where(easy, stride), WHOLE(STRIDE))
    v.become(TIMES, v.now(AFTERS).where(easy, v.now(TIMES)))
    v.become(SELECTED, one.where(easy, 0.0))
    v.become(EASY, one.where(easy, 0.0))
    return _are_all(builder, easy)


@instruction("Reals", "int", "int", "int")
def all_finite(builder: Any, wide: Any, w: Any, row: Any, errors: Any) -> None:
    """Set errors of good steps, <= 1, to nan if one of the numbers of ``row`` is not finite."""
    v = Memory(builder, wide)
    doubt = v.variable(0.0)
    with v.rows(w) as offset:
        doubt.become(v.load(v.plus(row, offset)) * 0.0 + doubt.now)
    error = v.load(errors)
    v.store((error + doubt.now).where(error.compared("<=", 1.0), error), errors)


def lifted(rows: Mapping[int, tuple[bool, int]], height: int) -> Any:
    """Return the compiled ``(lane, n, wide, w, rows, own, w1)``: it copies rows of one lane into the memory of a run.

    ``rows`` maps the number of a row of eight lanes to a number of a row of the run, or of its method (True). Rows from
    ``height`` on follow the places of the lanes. It goes component by component, with one number of each row: one row
    is shorter than a register, and the numbers of a lane are far apart.
    """

    @instruction("int", "int", "Reals", "int", "Reals", "Reals", "int")
    def lifted(builder: Any, lane: Any, n: Any, wide: Any, w: Any, run: Any, own: Any, w1: Any) -> None:
        starts = []
        for k, (of_method, j) in sorted(rows.items()):
            start = builder.add(builder.mul(w, WHOLE(k)), lane)
            start = builder.add(start, WHOLE(WIDE_PLACES)) if k >= height else start
            target = own if of_method else run
            starts.append((builder.gep(wide, [start]), builder.gep(target, [builder.mul(w1, WHOLE(j))])))
        with counted(builder, n, 1) as i:
            eighth = builder.mul(i, WHOLE(WIDTH))
            for source, target in starts:
                builder.store(builder.load(builder.gep(source, [eighth])), builder.gep(target, [i]))

    return lifted


@instruction("Reals", "int")
def unit_at(builder: Any, wide: Any, place: Any) -> None:
    """Divide the quaternions at ``place`` by their norms (`step_control.normalise`)."""
    v = Memory(builder, wide)
    places = [v.plus(place, WHOLE(WIDTH * j)) for j in range(4)]
    a, b, c, d = parts = [v.load(place) for place in places]
    norm = (a * a + b * b + c * c + d * d).root()
    for x, place in zip(parts, places, strict=True):
        v.store(x / norm, place)


@instruction("Reals", "int", "int", "int", "int")
def blend(builder: Any, wide: Any, w: Any, source: Any, target: Any, selected: Any) -> None:
    """Copy row ``source`` to row ``target`` in the lanes in which the number at ``selected`` is not 0."""
    v = Memory(builder, wide)
    mask = v.load(selected).compared("!=", 0.0)
    with v.rows(w) as offset:
        place = v.plus(target, offset)
        v.store(v.load(v.plus(source, offset)).where(mask, v.load(place)), place)


@instruction("Reals", "int", "int", "int", "int", "int")
def moved(builder: Any, wide: Any, w: Any, source: Any, target: Any, selected: Any, result: Any) -> None:
    """Do as `blend`, and store the greatest change, relative to 1 + |value|, at ``result`` (`step_control.project`)."""
    v = Memory(builder, wide)
    mask = v.load(selected).compared("!=", 0.0)
    greatest = v.variable(0.0)
    with v.rows(w) as offset:
        place = v.plus(target, offset)
        old, new = v.load(place), v.load(v.plus(source, offset))
        change = abs(new - old) / (abs(new) + 1.0)
        greatest.become(greatest.now.greater(change))
        v.store(new.where(mask, old), place)
    v.store(greatest.now, result)
