"""What the compiled loops over eight runs need besides `machine`: instructions on the eight numbers of a register.

Memory holds component i of lane l at 8 i + l of a row; what there is one of per lane, at l of a place. Each function
does to every lane what its neighbour in `machine`, `stepping` or `taylor` does to one, with the same roundings.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from llvmlite import ir

from .lanes_layout import WIDE_PLACES
from .layout import WIDTH
from .rows import Eight, Rows, all_of, arguments_of
from .translation import REAL, WHOLE, Instruction, counted, instruction, variable


class _Memory:
    """Eight numbers at places of memory, from which formulas are made."""

    def __init__(self, builder: Any, memory: Any) -> None:
        self.builder, self.memory = builder, memory

    def _at(self, place: Any, memory: Any) -> Any:
        pointer = self.builder.gep(self.memory if memory is None else memory, [place])
        return self.builder.bitcast(pointer, ir.VectorType(REAL, WIDTH).as_pointer())

    def load(self, place: Any, memory: Any = None) -> Eight:
        return Eight(self.builder, self.builder.load(self._at(place, memory), align=8))

    def store(self, eight: Eight, place: Any) -> None:
        self.builder.store(eight.value, self._at(place, None), align=8)

    def variable(self, number: float) -> _Variable:
        return _Variable(self.builder, number)

    def rows(self, w: Any) -> Any:
        """Goes through the components of a row: `with` gives their places."""
        return counted(self.builder, w, WIDTH)

    def plus(self, place: Any, offset: Any, rows: int = 0, w: Any = None) -> Any:
        """``place`` + ``offset`` + ``rows`` w."""
        place = self.builder.add(place, offset)
        return place if rows == 0 else self.builder.add(place, self.builder.mul(WHOLE(rows), w))


class _Variable:
    """Eight numbers that change."""

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


class _Lanes(Rows):
    """Rows of eight runs side by side; those from ``height`` on stand behind the places of the lanes."""

    def __init__(self, height: int, *memory: Any) -> None:
        super().__init__(*memory)
        self.height = height

    def index(self, row: Any) -> Any:
        found = super().index(row)
        return self.builder.add(found, WHOLE(WIDE_PLACES)) if row >= self.height else found


def lanewise(formula: Callable[..., Eight], height: int) -> Any:
    """Compiled ``(wide, w, result, *more)``: a formula as for `rows.rowwise`, of eight runs side by side.

    ``more`` are places of eight numbers, one for each run, and arrays with one for each component of each run. At
    ``result`` stands the largest of the results of each run, nan if one of them is.
    """

    def over_lanes(builder: Any, wide: Any, w: Any, result: Any, *more: Any) -> None:
        v = _Memory(builder, wide)
        largest, doubt = v.variable(-math.inf), v.variable(0.0)
        of_runs = {k: v.load(x) for k, x in enumerate(more) if x.type == WHOLE}
        with v.rows(w) as offset:
            given = [of_runs.get(k) or v.load(offset, x) for k, x in enumerate(more)]
            found = formula(_Lanes(height, builder, wide, w, offset), *given)
            largest.become(found.greater(largest.now))
            doubt.become(found * 0.0 + doubt.now)
        v.store(largest.now + doubt.now, result)

    return Instruction(over_lanes, "Reals", "int", "int", *arguments_of(formula))


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
        v = _Memory(builder, wide)
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
        found = (slowest * -1.0).power2()
        found = Eight(builder, all_of(math.inf)).where(slowest.compared("==", none), found)
        v.store(found.where(total.now.compared("<", math.inf), math.nan), result)

    return lengths


def decaying(order: int, bound: float, early: int, grown: float) -> Any:
    """Compiled ``(wide, w, last, steps, result)``: see `taylor.limited`.

    At ``result`` stands 1 or 0; row ``last`` is y_p."""

    @instruction("Reals", "int", "int", "int", "int")
    def decaying(builder: Any, wide: Any, w: Any, last: Any, steps: Any, result: Any) -> None:
        v = _Memory(builder, wide)
        sums = [v.variable(0.0) for _ in range(4)]
        with v.rows(w) as offset:
            place = v.plus(last, offset)
            a, b = v.load(place) * float(order), v.load(builder.sub(place, w))
            c = v.load(v.plus(place, WHOLE(0), early - order, w))
            for total, (x, y) in zip(sums, ((a, a), (b, b), (a, b), (c, c)), strict=True):
                total.become(x.times_plus(y, total.now))
        above, below, across, first = (total.now for total in sums)
        h = v.load(steps)
        growth = above.root() * grown
        for _ in range(order - early):
            growth = growth * abs(h)
        some = below.compared(">", 0.0)
        for less, more in (
            (h * across, 0.0),
            (above * below, across * across * 4.0),
            (below * (bound * bound), h * h * above),
        ):
            some = builder.and_(some, less.compared("<", more))
        some = builder.and_(some, first.root().compared("<=", growth))
        v.store(Eight(builder, all_of(1.0)).where(some, 0.0), result)

    return decaying


@instruction("Reals", "int")
def unit_at(builder: Any, wide: Any, place: Any) -> None:
    """The quaternions at ``place`` divided by their norms: see `stepping.normalise`."""
    v = _Memory(builder, wide)
    places = [v.plus(place, WHOLE(WIDTH * j)) for j in range(4)]
    a, b, c, d = parts = [v.load(place) for place in places]
    norm = (a * a + b * b + c * c + d * d).root()
    for x, place in zip(parts, places, strict=True):
        v.store(x / norm, place)


@instruction("Reals", "int", "int", "int", "int")
def blend(builder: Any, wide: Any, w: Any, source: Any, target: Any, wanted: Any) -> None:
    """Row ``target`` becomes row ``source`` in the lanes in which the number at ``wanted`` is 1, not 0."""
    v = _Memory(builder, wide)
    some = v.load(wanted).compared("!=", 0.0)
    with v.rows(w) as offset:
        place = v.plus(target, offset)
        v.store(v.load(v.plus(source, offset)).where(some, v.load(place)), place)


@instruction("Reals", "int", "int", "int", "int", "int")
def moved(builder: Any, wide: Any, w: Any, source: Any, target: Any, wanted: Any, result: Any) -> None:
    """`blend`; at ``result`` stands the greatest change, relative to 1 + |value|: see `stepping.project`."""
    v = _Memory(builder, wide)
    some = v.load(wanted).compared("!=", 0.0)
    most = v.variable(0.0)
    with v.rows(w) as offset:
        place = v.plus(target, offset)
        old, new = v.load(place), v.load(v.plus(source, offset))
        change = abs(new - old) / (abs(new) + 1.0)
        most.become(most.now.greater(change))
        v.store(new.where(some, old), place)
    v.store(most.now, result)
