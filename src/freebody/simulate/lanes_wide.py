"""Eight lanes at once: the loop over lanes with one run in each of the eight numbers of a vector register.

Each lane keeps its own time, step, error and control, exactly as `stepping.advance` has them; what eight lanes share is
one attempt after another. A lane that is rejected tries again while the others go on; one that has ended makes room for
the next. The kernels for eight lanes and the sums of the stages do the operations of those for one in the same order,
so that a lane is the run that it would be alone, to the last bit.

For the explicit method of order 8 on machines without constraints, and for runs in which no events and no extremes are
looked for (`lanes` serves the others). States at output times are made as for one lane (`stepping.sample`).

Rows of ``wide`` hold component i of lane l at 8 i + l, as do the two rows of ``absolute``: absolute and relative
tolerances of each lane.

The file is longer than others: it is the one loop, with the steps of `dop853` for eight lanes.
"""

from __future__ import annotations

import math
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from . import dop853, stepping, tableau
from .lanes import functions as of_one
from .lanes_layout import (
    BUDGET,
    ENERGY,
    FINEST,
    KEPT,
    LEG,
    LIMIT,
    LONGEST,
    N_CONSTANTS,
    N_LEGS,
    N_OUTPUTS,
    N_QUATERNIONS,
    N_SETTINGS,
    N_TIMES,
    N_WORK,
    ORDER,
    OUTPUTS,
    PROLOGUE,
    RATES,
    STIFF_ASKED,
    T0,
    T1,
    TOO_MANY,
    WIDE,
    WIDTH_OF_ROW,
    WORKS,
    N,
)
from .layout import (
    ARGUMENT,
    COLLAPSED,
    END,
    ERROR3,
    ERROR5,
    FINISHED,
    MANY,
    NOT_FINITE,
    RAW,
    ROWS,
    RUNNING,
    STATE,
    STIFF,
)
from .machine import Compiled, Integers, Reals, call, greater, lesser, linear, root, shifted
from .stepping import _EPS, _TINY, GREATEST, SAFETY, SMALLEST

_double, _integer = ir.DoubleType(), ir.IntType(64)
_PARTS: list[Any] = []
EXPONENT, BETA = dop853.CONTROL["EXPONENT"], dop853.CONTROL["BETA"]
LAST, STABLE = dop853.CONTROL["LAST"], dop853.CONTROL["LIMIT"]
STEPS, TIMES, MOMENTS = 0, 8, 16  # places after the rows: steps, times and moments of the lanes

# what `functions` puts in place
normalise: Any = None
sample: Any = None
first_length: Any = None
tightening: Any = None
set_constants: Any = None


def part(function: Any) -> Any:
    """A function of the loop over lanes."""
    _PARTS.append(function)
    return function


def functions() -> dict[str, Compiled]:
    """The compiled loop over lanes, of one and of eight."""
    given = of_one("dop853")
    return {**given, **stepping.bound(_PARTS, {**globals(), **given})}


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


_C1, _C2, _C3, _C4, _C5, _C6, _C7, _C8, _C9, _C10, _C11 = tableau.C[1:12]
_a1, _a2, _a3, _a4, _a5, _a6, _a7, _a8, _a9, _a10, _a11 = (
    linear(row, chained=True, lanes=True) for row in tableau.A[1:12]
)
_b, _e5, _e3 = (linear(row, lanes=True) for row in (tableau.B, tableau.E5, tableau.E3))


@part
def stage(kernel: int, fraction: float, k: int, wide: Reals, w: int, c: Reals) -> None:
    """Row k: the rates at row ARGUMENT, at the part ``fraction`` of every lane's step."""
    more = ROWS * w
    for lane in range(8):
        wide[more + MOMENTS + lane] = wide[more + TIMES + lane] + fraction * wide[more + STEPS + lane]
    call_wide(kernel, wide, more + MOMENTS, wide, ARGUMENT * w, c, wide, k * w)


@part
def attempt_wide(kernel: int, wide: Reals, w: int, c: Reals) -> None:
    """One step of each lane from STATE, whose rates are row 0: see `dop853.attempt`."""
    h = ROWS * w + STEPS
    _a1(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C1, 1, wide, w, c)
    _a2(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C2, 2, wide, w, c)
    _a3(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C3, 3, wide, w, c)
    _a4(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C4, 4, wide, w, c)
    _a5(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C5, 5, wide, w, c)
    _a6(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C6, 6, wide, w, c)
    _a7(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C7, 7, wide, w, c)
    _a8(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C8, 8, wide, w, c)
    _a9(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C9, 9, wide, w, c)
    _a10(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C10, 10, wide, w, c)
    _a11(wide, w, ARGUMENT, STATE, h)
    stage(kernel, _C11, 11, wide, w, c)
    _b(wide, w, RAW, STATE, h)
    _e5(wide, w, ERROR5, -1, h)
    _e3(wide, w, ERROR3, -1, h)


@part
def judge_wide(lane: int, n: int, wide: Reals, w: int, absolute: Reals) -> float:
    """Error of a lane's step in units of its tolerance, nan if it is not finite: see `dop853.judge`."""
    error5, error3 = 0.0, 0.0
    for i in range(n):
        k = 8 * i + lane
        new = wide[RAW * w + k]
        scale = absolute[k] + absolute[w + k] * greater(abs(wide[STATE * w + k]), abs(new))
        one, two = abs(wide[ERROR5 * w + k]) / scale, abs(wide[ERROR3 * w + k]) / scale
        if not (math.isfinite(new) and math.isfinite(one) and math.isfinite(two)):
            return math.nan
        error5 = greater(one, error5)
        error3 = greater(error3, two)
    if error5 == 0.0:
        return 0.0
    return error5 * error5 / root(error5 * error5 + 0.01 * error3 * error3)


@part
def lost(lane: int, n: int, wide: Reals, w: int, row: int, rows: int) -> int:
    """The first component of a lane that is not finite in the first of ``rows`` rows that has one, or -1."""
    for k in range(row, row + rows):
        for i in range(n):
            if not math.isfinite(wide[k * w + 8 * i + lane]):
                return i
    return -1


@part
def unit_wide(lane: int, wide: Reals, w: int, row: int, quaternions: Integers, nq: int) -> None:
    for k in range(nq):
        i = row * w + 8 * quaternions[k] + lane
        a, b, c, d = wide[i], wide[i + 8], wide[i + 16], wide[i + 24]
        s = root(a * a + b * b + c * c + d * d)
        for j in range(4):
            wide[i + 8 * j] /= s


@part
def stiff_wide(lane: int, n: int, wide: Reals, w: int, h: float, counts: Integers) -> int:
    """See `stepping._stiff`."""
    above, below, across = 0.0, 0.0, 0.0
    for i in range(n):
        k = 8 * i + lane
        a = wide[12 * w + k] - wide[LAST * w + k]
        b = wide[END * w + k] - wide[ARGUMENT * w + k]
        above += a * a
        below += b * b
        across += a * b
    decays = h * across < -0.5 * abs(h) * root(above * below)
    if decays and h * h * above > STABLE * STABLE * below and below > 0.0:
        counts[SUSPECT + lane] += 1
        counts[CALM + lane] = 0
    else:
        counts[CALM + lane] += 1
        if counts[CALM + lane] == 6:
            counts[SUSPECT + lane] = 0
    return 1 if counts[SUSPECT + lane] >= 15 else 0


# places of eight integers each: number of the run (-1: none), steps of this leg, rejected steps, suspicions, calm
# steps, whether the step before was rejected, outputs given, whether the step reaches the end, leg, steps of the legs
# before; and the component to blame
RUN, TAKEN, REJECTED, SUSPECT, CALM, AFTER, GIVEN, ENDS, AT, BEFORE = 0, 8, 16, 24, 32, 40, 48, 56, 64, 72
COUNTS = 80
# places of eight numbers each: error of the step before, longest step of this leg and of those before, start and end of
# the leg, energy at the start of the run
OLDS, STRIDE, NATURAL, FIRST, LAST_TIME, SIZE = 0, 8, 16, 24, 32, 40


@part
def enter(
    lane: int, run: int, kernels: Integers, sizes: Integers, options: Reals, initial: Reals, parameters: Reals,
    legs: Reals, columns: Integers, quaternions: Integers, relative: Reals, tolerances: Reals, work: Reals,
    spare: Reals, mine: Reals, wide: Reals, w: int, c: Reals, alone: Reals, absolute: Reals, single: Reals,
    control: Reals, counts: Integers,
) -> int:  # fmt: skip
    """A run enters a lane; RUNNING, or NOT_FINITE with the component in ``counts[COUNTS]``. See `lanes.lanes`."""
    for i in range(sizes[N]):
        work[STATE * sizes[WIDTH_OF_ROW] + i] = initial[run * sizes[N] + i]
    for k in range(10):
        counts[8 * k + lane] = 0
    counts[RUN + lane] = run
    control[NATURAL + lane] = 0.0
    control[SIZE + lane] = 1.0
    return enter_leg(
        lane, kernels, sizes, options, parameters, legs, columns, quaternions, relative, tolerances, work, spare, mine,
        wide, w, c, alone, absolute, single, control, counts,
    )  # fmt: skip


@part
def enter_leg(
    lane: int, kernels: Integers, sizes: Integers, options: Reals, parameters: Reals, legs: Reals, columns: Integers,
    quaternions: Integers, relative: Reals, tolerances: Reals, work: Reals, spare: Reals, mine: Reals, wide: Reals,
    w: int, c: Reals, alone: Reals, absolute: Reals, single: Reals, control: Reals, counts: Integers,
) -> int:  # fmt: skip
    """A run enters its next leg, with the state in ``work``."""
    n, w1, nq, hoisted = sizes[N], sizes[WIDTH_OF_ROW], sizes[N_QUATERNIONS], sizes[N_CONSTANTS]
    leg = counts[AT + lane]
    row = leg * (LEG + sizes[N_SETTINGS])
    start, until = legs[row], legs[row + 1]
    direction = 1.0 if until >= start else -1.0
    longest = lesser(options[LONGEST], abs(until - start))
    own = shifted(alone, lane * hoisted)
    set_constants(kernels[PROLOGUE], counts[RUN + lane], leg, sizes, parameters, legs, columns, mine, own)
    for j in range(hoisted):
        c[8 * j + lane] = own[j]
    for i in range(sizes[N_WORK]):
        if i < STATE * w1 or i >= STATE * w1 + n:
            work[i] = 0.0
    for i in range(n):
        single[i] = tolerances[i]
    normalise(work, STATE * w1, quaternions, nq)
    call(kernels[RATES], start, work, STATE * w1, own, work, 0)
    for i in range(n):
        if not math.isfinite(work[i]):
            counts[COUNTS] = i
            return NOT_FINITE
    if sizes[WORKS] != 0:
        if leg == 0:
            call(kernels[ENERGY], start, work, STATE * w1, own, spare, 0)
            control[SIZE + lane] = greater(abs(spare[0]), abs(spare[1]))
        if 0.0 < control[SIZE + lane] < math.inf:
            single[n - 1] *= control[SIZE + lane]
    step = control[NATURAL + lane]
    if step == 0.0:
        step = first_length(
            kernels[RATES], start, direction, longest, work, w1, n, own, relative, single, options[ORDER]
        )  # fmt: skip
    for i in range(n):
        wide[STATE * w + 8 * i + lane] = work[STATE * w1 + i]
        wide[8 * i + lane] = work[i]
        absolute[8 * i + lane] = single[i]
        absolute[w + 8 * i + lane] = relative[i]
    more = ROWS * w
    wide[more + TIMES + lane] = control[FIRST + lane] = start
    control[LAST_TIME + lane] = until
    wide[more + STEPS + lane] = direction * lesser(step, longest)
    control[OLDS + lane] = 1e-4
    control[STRIDE + lane] = 0.0
    counts[TAKEN + lane] = counts[SUSPECT + lane] = counts[CALM + lane] = counts[AFTER + lane] = 0
    return RUNNING


@part
def lanes_wide(
    begin: int, end: int, kernels: Integers, sizes: Integers, options: Reals, initial: Reals, parameters: Reals,
    legs: Reals, columns: Integers, wanted: Reals, quaternions: Integers, relative: Reals, tolerances: Reals,
    work: Reals, other: Reals, spare: Reals, mine: Reals, wide: Reals, c: Reals, alone: Reals, absolute: Reals,
    single: Reals, control: Reals, afters: Reals, counts: Integers,
    times: Reals, lengths: Reals, states: Reals, sampled: Reals, spare_integers: Integers, values: Reals,
    kept: Integers, ends: Reals,
) -> None:  # fmt: skip
    """Runs ``begin`` to ``end`` - 1; arguments as those of `lanes.lanes`, and memory of this thread."""
    n, nq = sizes[N], sizes[N_QUATERNIONS]
    w = 8 * n
    outputs, count, hoisted = sizes[N_OUTPUTS], sizes[N_TIMES], sizes[N_CONSTANTS]
    direction = 1.0 if options[T1] >= options[T0] else -1.0
    more = ROWS * w
    following, active = begin, 0
    for lane in range(8):
        counts[RUN + lane] = -1
        wide[more + STEPS + lane] = wide[more + TIMES + lane] = 0.0
    while active > 0 or following < end:
        for lane in range(8):
            while counts[RUN + lane] < 0 and following < end:
                code = enter(
                    lane, following, kernels, sizes, options, initial, parameters, legs, columns, quaternions,
                    relative, tolerances, work, spare, mine, wide, w, c, alone, absolute, single, control, counts,
                )  # fmt: skip
                if code == RUNNING:
                    active += 1
                else:
                    counts[RUN + lane] = -1
                    kept[KEPT * following] = code
                    kept[KEPT * following + 3] = counts[COUNTS]
                    ends[following] = options[T0]
                following += 1
            run = counts[RUN + lane]
            if run < 0:
                wide[more + STEPS + lane] = 0.0
                continue
            t, h, until = wide[more + TIMES + lane], wide[more + STEPS + lane], control[LAST_TIME + lane]
            if abs(h) > options[LONGEST]:
                h = direction * options[LONGEST]
            counts[ENDS + lane] = 0
            if (t + 1.01 * h - until) * direction >= 0.0:
                h = until - t
                counts[ENDS + lane] = 1
            elif abs(h) <= 8.0 * _EPS * abs(t) or abs(h) < _TINY:
                kept[KEPT * run] = COLLAPSED
                kept[KEPT * run + 1] = counts[BEFORE + lane] + counts[TAKEN + lane]
                kept[KEPT * run + 2] = counts[REJECTED + lane]
                ends[run] = t
                counts[RUN + lane] = -1
                active -= 1
                h = 0.0
            wide[more + STEPS + lane] = h
            afters[lane] = until if counts[ENDS + lane] != 0 else t + h
        if active == 0:
            continue
        attempt_wide(kernels[WIDE], wide, w, c)
        for i in range(w):
            wide[END * w + i] = wide[RAW * w + i]
        for lane in range(8):
            unit_wide(lane, wide, w, END, quaternions, nq)
            wide[more + MOMENTS + lane] = afters[lane]
        call_wide(kernels[WIDE], wide, more + MOMENTS, wide, END * w, c, wide, 12 * w)
        for lane in range(8):
            run = counts[RUN + lane]
            if run < 0:
                continue
            t, h, after = wide[more + TIMES + lane], wide[more + STEPS + lane], afters[lane]
            reaches, goes_on = counts[ENDS + lane] != 0, counts[AT + lane] + 1 < sizes[N_LEGS]
            start, until = control[FIRST + lane], control[LAST_TIME + lane]
            error = judge_wide(lane, n, wide, w, absolute)
            if error <= 1.0 and lost(lane, n, wide, w, 12, 1) >= 0:
                error = math.nan
            code = RUNNING
            blame = 0
            if not error <= 1.0:
                counts[REJECTED + lane] += 1
                counts[AFTER + lane] = 1
                if error == error:
                    h *= greater(SMALLEST, SAFETY / error**EXPONENT)
                else:
                    blame = lost(lane, n, wide, w, 1, 12)
                    if blame < 0:
                        blame = lost(lane, n, wide, w, RAW, 3)
                    h *= 0.25
                    if abs(h) <= 16.0 * _EPS * abs(t) or abs(h) < _TINY:
                        code = NOT_FINITE
                wide[more + STEPS + lane] = h
            else:
                counts[TAKEN + lane] += 1
                control[STRIDE + lane] = greater(control[STRIDE + lane], abs(h))
                stiff = stiff_wide(lane, n, wide, w, h, counts)
                if stiff * sizes[STIFF_ASKED] != 0 and abs(until - after) > MANY * abs(h):
                    code = STIFF
                given = counts[GIVEN + lane]
                reach = given
                while reach < count and (wanted[reach] - after) * direction <= 0.0:
                    if wanted[reach] == until and reaches and goes_on:
                        break  # the break point belongs to the next leg
                    reach += 1
                if reach > given:
                    times[0], times[1], lengths[0] = t, after, h
                    for i in range(n):
                        states[i] = wide[STATE * w + 8 * i + lane]
                        states[n + i] = wide[END * w + 8 * i + lane]
                    for i in range(sizes[N_WORK]):
                        other[i] = 0.0
                    own = shifted(alone, lane * hoisted)
                    sample(
                        kernels[RATES], n, own, other, sizes[WIDTH_OF_ROW], quaternions, nq, 1, times, lengths, states,
                        0, reach - given, shifted(wanted, given), sampled, relative, single, spare_integers,
                    )  # fmt: skip
                    for k in range(given, reach):
                        call(
                            kernels[OUTPUTS], wanted[k], sampled, (k - given) * n, own, values,
                            (run * count + k) * outputs,
                        )  # fmt: skip
                    counts[GIVEN + lane] = reach
                t = after
                wide[more + TIMES + lane] = t
                for i in range(n):
                    k = 8 * i + lane
                    wide[STATE * w + k] = wide[END * w + k]
                    wide[k] = wide[12 * w + k]
                if reaches and goes_on:
                    if counts[TAKEN + lane] > 1:
                        control[NATURAL + lane] = control[STRIDE + lane]
                    else:
                        control[NATURAL + lane] = greater(control[NATURAL + lane], control[STRIDE + lane])
                    counts[BEFORE + lane] += counts[TAKEN + lane]
                    counts[AT + lane] += 1
                    for i in range(n):
                        work[STATE * sizes[WIDTH_OF_ROW] + i] = wide[STATE * w + 8 * i + lane]
                    code = enter_leg(
                        lane, kernels, sizes, options, parameters, legs, columns, quaternions, relative, tolerances,
                        work, spare, mine, wide, w, c, alone, absolute, single, control, counts,
                    )  # fmt: skip
                    if code != RUNNING:
                        blame = counts[COUNTS]
                        counts[TAKEN + lane] = 0
                    elif counts[BEFORE + lane] < sizes[LIMIT]:
                        continue
                    else:
                        code = TOO_MANY
                elif reaches:
                    code = FINISHED
                elif code == RUNNING and counts[BEFORE + lane] + counts[TAKEN + lane] >= sizes[LIMIT]:
                    code = TOO_MANY
                factor = GREATEST
                if error > 0.0:
                    factor = SAFETY * control[OLDS + lane] ** BETA / error**EXPONENT
                    factor = lesser(GREATEST, greater(SMALLEST, factor))
                if counts[AFTER + lane] != 0:
                    factor = lesser(1.0, factor)
                    counts[AFTER + lane] = 0
                h *= factor
                if counts[TAKEN + lane] == sizes[BUDGET]:
                    finest = absolute[w + lane]
                    for i in range(n):
                        finest = lesser(absolute[w + 8 * i + lane], finest)
                    least = options[FINEST] / finest
                    tighter = tightening(sizes[BUDGET], t - start, until - t, options[ORDER], least)
                    for i in range(n):
                        absolute[8 * i + lane] *= tighter
                        absolute[w + 8 * i + lane] *= tighter
                    h *= tighter ** (1.0 / options[ORDER])
                wide[more + STEPS + lane] = h
                control[OLDS + lane] = greater(error, 1e-4)
            if code != RUNNING:
                kept[KEPT * run] = code
                kept[KEPT * run + 1] = counts[BEFORE + lane] + counts[TAKEN + lane]
                kept[KEPT * run + 2] = counts[REJECTED + lane]
                kept[KEPT * run + 3] = blame
                ends[run] = t
                counts[RUN + lane] = -1
                active -= 1
