"""Eight lanes at once: the loop over lanes with one run in each of the eight numbers of a vector register.

Each lane keeps its own time, step, error and control, exactly as `stepping.advance` has them; what eight lanes share is
one attempt after another. A lane that is rejected tries again while the others go on; one that has ended makes room for
the next. What a method does for eight lanes (`dop853_wide`, `taylor_wide`) it does to each of them alone, so that a
lane does not depend on its neighbours; those of `dop853` do the operations of those for one in the same order, so that
there a lane is the run that it would be alone, to the last bit.

Where there is something to look for inside a step of a lane, events, extremes or states at output times, the step is
lifted out of the register into a work array of its own, and `stepping` goes on with it.

Rows of ``wide`` hold component i of lane l at 8 i + l, as do the two rows of ``tolerances``: absolute and relative
tolerances of each lane.

The file is longer than others: it is the one loop.
"""

from __future__ import annotations

import math
from typing import Any

from ...native.instructions import Compiled, Integers, Parts, Reals, call, greater, lesser, shifted, whole
from ...native.loop import module_named
from ..ode.layout import (
    BLAME,
    COLLAPSED,
    CULPRIT,
    DIVERGED,
    END,
    ERROR5,
    FINISHED,
    LOGGED,
    MANY,
    NAMED,
    NOT_FINITE,
    PARTS,
    POINT,
    PROJECTED,
    RAW,
    REACH,
    RUNNING,
    STATE,
    STIFF,
    TERMINAL,
    UNDEFINED,
)
from ..ode.loops import place
from ..ode.step_control import _EPS, _TINY, EXPONENT, GIVEN, SAFETY, SMALLEST
from .instructions_wide import all_finite, blend, call_wide, moved, settled, taken, unit_at
from .lanes import functions as of_one
from .lanes_layout import (
    AFTER,
    AFTERS,
    ALLOWED,
    AT,
    BEFORE,
    BLAMED,
    BUDGET,
    CALM,
    CHANGES,
    DONE,
    DROPPED,
    EASY,
    ENDS,
    ENERGY,
    ERRORS,
    EXTREMES,
    FINEST,
    FIRST,
    KEPT,
    LAST_TIME,
    LEFT,
    LEG,
    LENGTHS,
    LIMIT,
    LIMITED,
    LONGEST,
    MOMENTS,
    N_CONSTANTS,
    N_DROPPED,
    N_EVENTS,
    N_LEGS,
    N_OUTPUTS,
    N_QUATERNIONS,
    N_REDUCED,
    N_SETTINGS,
    N_TIMES,
    N_WATCHED,
    N_WORK,
    NATURAL,
    NEXT,
    OLDS,
    ORDER,
    OUTPUTS,
    PROJECTION_WIDE,
    PROLOGUE,
    RATES,
    RATES_WIDE,
    REDUCED,
    REJECTED,
    RUN,
    SEEN,
    SIZE,
    STEPS,
    STIFF_ASKED,
    STRIDE,
    SUSPECT,
    T0,
    T1,
    TAKEN,
    TIMES,
    TOO_MANY,
    WANTED,
    WATCHED_WIDE,
    WIDE,
    WIDE_PLACES,
    WIDTH_OF_ROW,
    WORKS,
    N,
)
from .lanes_layout import WATCHED as EVENTS

part = Parts()

# what `functions` puts in place: of the loop over one lane, and of the method for eight
normalise: Any = None
first_length: Any = None
look: Any = None
densify: Any = None
find_events: Any = None
_log_events: Any = None
_part: Any = None
lengthening: Any = None
tightening: Any = None
set_constants: Any = None
jumped: Any = None
contradicted: Any = None
begun_beyond: Any = None
log_event: Any = None
widen: Any = None
HEIGHT = 0
"""Rows of a method; places of the lanes follow them."""
prepare_wide: Any = None
"""(kernel, wide, w, c, tolerances): before the lengths of the steps are settled."""
attempt_wide: Any = None
"""(kernel, wide, w, c): steps of all lanes from STATE to RAW."""
judge_wide: Any = None
"""(rates, n, wide, w, c, tolerances): at ERRORS those of the steps in units of their tolerances, nan if they are not
finite; ``rates`` is their kernel, where a series may go on behind a bend, else 0."""
limit_wide: Any = None
"""(wide, w): at LIMITED 1 where stability may limit a step, else 0."""
begin_wide: Any = None
"""(lane, n, wide, w): before the first step of a lane from a new start."""
tune_wide: Any = None
"""(lane, n, wide, w, tolerances): the tolerances of a lane are new."""
accept_wide: Any = None
"""(wide, w, wanted): the lanes in which the number at ``wanted`` is not 0 took their steps."""
blame_wide: Any = None
"""(lane, n, wide, w) -> the component of a lane to blame where there is no length."""
straight_wide: Any = None
"""(lane, n, wide, w, tolerances) -> the length of a straight step where a bend is closer than the time resolves."""
lift: Any = None
"""(lane, n, wide, w, work, w1): the step of a lane in a work array of its own."""


def functions(method: str) -> dict[str, Compiled]:
    """The compiled loop over eight lanes of a method, and what it calls."""
    numbers = module_named(place(method)).FUNCTIONS.method
    control = {name: numbers[name] for name in ("GIVEN", "EXPONENT", "BETA") if name in numbers}
    given = of_one(method)
    wide = module_named(f"{__name__.partition('.')[2].rpartition('.')[0]}.{method}_wide").FUNCTIONS
    made = {name: function for name, function in wide.items() if isinstance(function, Compiled)}
    return {**given, **made, **part.bound({**globals(), **control, **given, **wide})}


@part
def lost(lane: int, n: int, wide: Reals, w: int, row: int, rows: int) -> int:
    """The first component of a lane that is not finite in the first of ``rows`` rows that has one, or -1."""
    for k in range(row, row + rows):
        for i in range(n):
            if not math.isfinite(wide[k * w + 8 * i + lane]):
                return i
    return -1


@part
def project_wide(
    kernel: int, n: int, wide: Reals, w: int, c: Reals, quaternions: Integers, nq: int, control: Reals
) -> None:  # fmt: skip
    """The ends of the steps onto the constraints, in lanes whose error is at most 1: see `stepping.project`.

    What moves too far there is not the error of a step: the error of that lane becomes 1000."""
    more = HEIGHT * w
    some = 0
    for lane in range(8):
        wide[more + WANTED + lane] = 0.0
        if wide[more + ERRORS + lane] <= 1.0:
            wide[more + WANTED + lane] = 1.0
            some += 1
    k = 0
    while some > 0 and k < 5:
        call_wide(kernel, wide, more + MOMENTS, wide, END * w, c, wide, ERROR5 * w)
        moved(
            wide, 8 * quaternions[nq + PROJECTED], ERROR5 * w, END * w, more + WANTED, more + CHANGES
        )  # fmt: skip
        unit_wide(wide, w, END, quaternions, nq)
        some = 0
        for lane in range(8):
            change = wide[more + CHANGES + lane]
            if wide[more + WANTED + lane] != 0.0:
                if k == 0 and not change <= control[ALLOWED + lane]:
                    wide[more + ERRORS + lane] = 1e3
                wide[more + WANTED + lane] = 0.0
                if change > 1e-8:
                    wide[more + WANTED + lane] = 1.0
                    some += 1
        k += 1


@part
def unit_wide(wide: Reals, w: int, row: int, quaternions: Integers, nq: int) -> None:
    """See `stepping.normalise`."""
    for k in range(nq):
        unit_at(wide, row * w + 8 * quaternions[k])


@part
def stiff_wide(lane: int, limited: float, counts: Integers) -> int:
    """See `stepping._stiff`."""
    if limited != 0.0:
        counts[SUSPECT + lane] += 1
        counts[CALM + lane] = 0
    else:
        counts[CALM + lane] += 1
        if counts[CALM + lane] == 6:
            counts[SUSPECT + lane] = 0
    return 1 if counts[SUSPECT + lane] >= 15 else 0


@part
def near_limit(lane: int, sizes: Integers, wide: Reals, table: Reals, last: Integers) -> int:
    """Whether a lane may pass a limit in its step: where a value at one of its ends is not twice what it changed by in
    this step or the one before. Values that are far from zero are taken over for the next step."""
    m, seen, result = sizes[N_WATCHED], sizes[SEEN], 0
    for e in range(m):
        now, before, changes = wide[seen + 8 * e + lane], table[e], seen + 8 * (m + e) + lane
        change = abs(now - before)
        if not lesser(now, before) > 2.0 * greater(change, wide[changes]):
            result = 1
        wide[changes] = change
    if result == 0:
        for e in range(m):
            table[e] = wide[seen + 8 * e + lane]
            last[e] = 1
    return result


@part
def tune(lane: int, n: int, wide: Reals, w: int, tolerances: Reals, fixed: float, control: Reals) -> None:
    """What follows from the tolerances of a lane."""
    allowed = 0.0
    for i in range(n):
        allowed = greater(allowed, 1e3 * tolerances[w + 8 * i + lane])
    control[ALLOWED + lane] = allowed if fixed == 0.0 else 0.1  # see `stepping.advance`
    tune_wide(lane, n, wide, w, tolerances)


@part
def last_state(lane: int, n: int, wide: Reals, w: int, counts: Integers, initial: Reals) -> None:
    """The last good state of a lane takes the place of its start: what is to blame is looked for there."""
    for i in range(n):
        initial[counts[RUN + lane] * n + i] = wide[STATE * w + 8 * i + lane]


@part
def leave(lane: int, code: int, blame: int, t: float, counts: Integers, kept: Integers, ends: Reals) -> None:
    """A run leaves its lane."""
    run = counts[RUN + lane]
    kept[KEPT * run] = code
    kept[KEPT * run + 1] = counts[BEFORE + lane] + counts[TAKEN + lane]
    kept[KEPT * run + 2] = counts[REJECTED + lane]
    kept[KEPT * run + 3] = blame
    ends[run] = t
    counts[RUN + lane] = -1


@part
def enter(
    lane: int, run: int, kernels: Integers, sizes: Integers, options: Reals, initial: Reals, parameters: Reals,
    legs: Reals, columns: Integers, wanted: Reals, quaternions: Integers, relative: Reals, given: Reals,
    directions: Integers, terminal: Integers, work: Reals, spare: Reals, mine: Reals, wide: Reals, w: int, c: Reals,
    alone: Reals, tolerances: Reals, single: Reals, control: Reals, counts: Integers, last: Integers, table: Reals,
    g: Reals, values: Reals, reduced: Reals, event_times: Reals, happened: Integers, spare_integers: Integers,
) -> int:  # fmt: skip
    """A run enters a lane; RUNNING, or why it does not begin, with the component in ``counts[BLAMED]``."""
    for i in range(sizes[N]):
        work[STATE * sizes[WIDTH_OF_ROW] + i] = initial[run * sizes[N] + i]
    for k in range(10):
        counts[8 * k + lane] = 0
    counts[RUN + lane] = run
    control[NATURAL + lane] = 0.0
    control[SIZE + lane] = 1.0
    return enter_leg(
        lane, kernels, sizes, options, parameters, legs, columns, wanted, quaternions, relative, given, directions,
        terminal, work, spare, mine, wide, w, c, alone, tolerances, single, control, counts, last, table, g, values,
        reduced, event_times, happened, spare_integers,
    )  # fmt: skip


@part
def enter_leg(
    lane: int, kernels: Integers, sizes: Integers, options: Reals, parameters: Reals, legs: Reals, columns: Integers,
    wanted: Reals, quaternions: Integers, relative: Reals, given: Reals, directions: Integers, terminal: Integers,
    work: Reals, spare: Reals, mine: Reals, wide: Reals, w: int, c: Reals, alone: Reals, tolerances: Reals,
    single: Reals, control: Reals, counts: Integers, last: Integers, table: Reals, g: Reals, values: Reals,
    reduced: Reals, event_times: Reals, happened: Integers, spare_integers: Integers,
) -> int:  # fmt: skip
    """A run enters its next leg, with the state in ``work``."""
    n, w1, nq, hoisted = sizes[N], sizes[WIDTH_OF_ROW], sizes[N_QUATERNIONS], sizes[N_CONSTANTS]
    m, many, count = sizes[N_WATCHED], sizes[N_REDUCED], sizes[N_TIMES]
    leg, run = counts[AT + lane], counts[RUN + lane]
    row = leg * (LEG + sizes[N_SETTINGS])
    start, until, fixed = legs[row], legs[row + 1], legs[row + 2]
    direction = 1.0 if until >= start else -1.0
    longest = lesser(options[LONGEST], abs(until - start))
    own = shifted(alone, lane * hoisted)
    counts[BLAMED] = 0
    counts[TAKEN + lane] = counts[SUSPECT + lane] = counts[CALM + lane] = counts[AFTER + lane] = 0
    if leg > 0 and sizes[N_EVENTS] > 0:
        if jumped(
            run, leg, kernels, sizes, options[T0], start, work, parameters, legs, columns, directions, terminal, mine,
            own, shifted(table, lane * (PARTS + 3) * (m + 1)), g, happened, event_times,
        ) != 0:  # fmt: skip
            set_constants(kernels[PROLOGUE], run, leg - 1, sizes, parameters, legs, columns, mine, own)
            k = counts[DONE + lane]
            while k < count and (wanted[k] - start) * direction <= 0.0:
                place = (run * count + k) * sizes[N_OUTPUTS]
                call(kernels[OUTPUTS], wanted[k], work, STATE * w1, own, values, place)
                k += 1
            return TERMINAL
    else:
        set_constants(kernels[PROLOGUE], run, leg, sizes, parameters, legs, columns, mine, own)
    for j in range(hoisted):
        c[8 * j + lane] = own[j]
    for i in range(sizes[N_WORK]):
        if i < STATE * w1 or i >= STATE * w1 + n:
            work[i] = 0.0
    for i in range(n):
        single[i] = given[i]
    normalise(work, STATE * w1, quaternions, nq)
    if GIVEN == 0:
        call(kernels[RATES], start, work, STATE * w1, own, work, 0)
        for i in range(n):
            if not math.isfinite(work[i]):
                counts[BLAMED] = i
                return NOT_FINITE
    if sizes[WORKS] != 0:
        if leg == 0:
            call(kernels[ENERGY], start, work, STATE * w1, own, spare, 0)
            control[SIZE + lane] = greater(abs(spare[0]), abs(spare[1]))
        if 0.0 < control[SIZE + lane] < math.inf:
            single[n - 1] *= control[SIZE + lane]
    if m > 0:
        spare_integers[NAMED] = sizes[N_EVENTS]
        seen = look(
            kernels[EVENTS], start, work, w1, m, own, shifted(table, lane * (PARTS + 3) * (m + 1)),
            shifted(last, lane * m), spare_integers,
        )  # fmt: skip
        if seen != RUNNING:
            counts[BLAMED] = spare_integers[BLAME]
            return seen
        if leg == 0:
            begun_beyond(
                run, sizes, start, shifted(table, lane * (PARTS + 3) * (m + 1)), happened, event_times
            )
        if sizes[SEEN] != 0:
            for e in range(m):
                wide[sizes[SEEN] + 8 * (m + e) + lane] = math.inf
    if many > 0:
        place = run * many * EXTREMES
        if leg == 0:
            call(kernels[REDUCED], start, work, STATE * w1, own, spare, 0)
            for k in range(many):
                for i in range(EXTREMES):
                    reduced[place + EXTREMES * k + i] = spare[k]
        else:
            widen(kernels[REDUCED], start, work, STATE * w1, own, spare, many, reduced, place)
    left = sizes[N_DROPPED]
    if left > 0 and contradicted(kernels[DROPPED], left, start, work, STATE * w1, n, own, spare) != 0:
        return LEFT
    step = control[NATURAL + lane]
    if fixed != 0.0:
        step = fixed
    elif GIVEN == 0 and step == 0.0:
        step = first_length(
            kernels[RATES], start, direction, longest, work, w1, n, own, relative, single, options[ORDER]
        )  # fmt: skip
    for i in range(n):
        wide[STATE * w + 8 * i + lane] = work[STATE * w1 + i]
        wide[8 * i + lane] = work[i]
        tolerances[8 * i + lane] = single[i]
        tolerances[w + 8 * i + lane] = relative[i]
    begin_wide(lane, n, wide, w)
    tune(lane, n, wide, w, tolerances, fixed, control)
    more = HEIGHT * w
    wide[more + TIMES + lane] = control[FIRST + lane] = start
    control[LAST_TIME + lane] = until
    wide[more + STEPS + lane] = direction * lesser(step, longest)
    control[OLDS + lane] = 1e-4
    control[STRIDE + lane] = 0.0
    k = counts[DONE + lane]
    control[NEXT + lane] = wanted[k] if k < count else direction * math.inf
    return RUNNING


@part
def seek(
    lane: int, kernels: Integers, sizes: Integers, options: Reals, after: float, quaternions: Integers,
    directions: Integers, terminal: Integers, relative: Reals, work: Reals, spare: Reals, wide: Reals, w: int,
    own: Reals, single: Reals, control: Reals, counts: Integers, last: Integers, table: Reals, g: Reals, found: Reals,
    event_log: Reals, event_states: Reals, spare_integers: Integers, reduced: Reals, event_times: Reals,
    happened: Integers,
) -> float:  # fmt: skip
    """Events and extremes of a lane's step, which has been lifted into ``work``; its part at which a terminal event
    ends it, else -1. Where an event without a value does, ``counts[BLAMED]`` is 1 + its number, else 0."""
    n, w1, m, many = sizes[N], sizes[WIDTH_OF_ROW], sizes[N_WATCHED], sizes[N_REDUCED]
    nq, asked, run = sizes[N_QUATERNIONS], sizes[N_EVENTS], counts[RUN + lane]
    more = HEIGHT * w
    t, h, first = wide[more + TIMES + lane], wide[more + STEPS + lane], control[FIRST + lane]
    place, stop = run * many * EXTREMES, -1.0
    counts[BLAMED] = 0
    if m > 0:
        densify(kernels[RATES], t, h, work, w1, n, own, quaternions, nq)
        count = find_events(
            kernels[EVENTS], t, h, work, w1, own, quaternions, nq, m, asked,
            shifted(table, lane * (PARTS + 3) * (m + 1)), g, shifted(last, lane * m), directions, found,
        )  # fmt: skip
        reach = found[REACH]
        stop = _log_events(
            kernels[RATES], kernels[EVENTS], count, t, h, after, first, n, work, w1, own, own, quaternions, nq, g,
            found, terminal, event_log, event_states, 0, relative, single, spare_integers,
        )  # fmt: skip
        if stop >= 0.0 and stop == reach:
            counts[BLAMED] = 1 + whole(found[CULPRIT])
        for k in range(whole(found[3])):
            e = whole(event_log[LOGGED * k + 1])
            if e < asked:
                log_event(
                    run * asked + e, event_log[LOGGED * k], options[T0], first, sizes[N_LEGS], terminal[e], happened,
                    event_times,
                )  # fmt: skip
            if many > 0:
                widen(
                    kernels[REDUCED], event_log[LOGGED * k], event_states, k * n, own, spare, many, reduced, place
                )  # fmt: skip
    if many > 0:
        moment = after if stop < 0.0 or stop == 1.0 else t + stop * h
        widen(kernels[REDUCED], moment, work, END * w1, own, spare, many, reduced, place)
    return stop


@part
def lanes_wide(
    begin: int, end: int, kernels: Integers, sizes: Integers, options: Reals, initial: Reals, parameters: Reals,
    legs: Reals, columns: Integers, wanted: Reals, quaternions: Integers, relative: Reals, given: Reals,
    directions: Integers, terminal: Integers, work: Reals, spare: Reals, mine: Reals, wide: Reals,
    c: Reals, alone: Reals, tolerances: Reals, single: Reals, control: Reals, counts: Integers,
    last: Integers, table: Reals, g: Reals, found: Reals, event_log: Reals, event_states: Reals,
    spare_integers: Integers, values: Reals, reduced: Reals, event_times: Reals, happened: Integers, kept: Integers,
    ends: Reals,
) -> None:  # fmt: skip
    """Runs ``begin`` to ``end`` - 1; arguments as those of `lanes.lanes`, and memory of this thread.

    Of ``last`` and ``table`` there is a part for each lane; ``alone`` holds the constants lane by lane.
    """
    n, nq, w1 = sizes[N], sizes[N_QUATERNIONS], sizes[WIDTH_OF_ROW]
    w, m, many = 8 * n, sizes[N_WATCHED], sizes[N_REDUCED]
    outputs, count, hoisted, left = sizes[N_OUTPUTS], sizes[N_TIMES], sizes[N_CONSTANTS], sizes[N_DROPPED]
    direction = 1.0 if options[T1] >= options[T0] else -1.0
    more, settings = HEIGHT * w, LEG + sizes[N_SETTINGS]
    following, active = begin, 0
    free, plain = True, m == 0 and many == 0 and left == 0
    for leg in range(sizes[N_LEGS]):
        if legs[leg * settings + 2] != 0.0:
            free = plain = False
    for lane in range(8):
        counts[RUN + lane] = -1
    for k in range(WIDE_PLACES):
        wide[more + k] = 0.0
    while active > 0 or following < end:
        for lane in range(8):
            while counts[RUN + lane] < 0 and following < end:
                code = enter(
                    lane, following, kernels, sizes, options, initial, parameters, legs, columns, wanted, quaternions,
                    relative, given, directions, terminal, work, spare, mine, wide, w, c, alone, tolerances, single,
                    control, counts, last, table, g, values, reduced, event_times, happened, spare_integers,
                )  # fmt: skip
                following += 1
                if code == RUNNING:
                    active += 1
                else:
                    leave(lane, code, counts[BLAMED], options[T0], counts, kept, ends)
        prepare_wide(kernels[WIDE], wide, w, c, tolerances)
        # the steps of most lanes follow all at once; what has an end, a rejected step, ... goes one by one
        others = 8
        if free and settled(
            wide, more, LENGTHS if GIVEN != 0 else STEPS, control, counts, direction, options[LONGEST]
        ):
            others = 0
        for lane in range(others):
            if wide[more + EASY + lane] != 0.0:
                continue
            if counts[RUN + lane] < 0:
                wide[more + STEPS + lane] = 0.0
                continue
            t, h, until = wide[more + TIMES + lane], wide[more + STEPS + lane], control[LAST_TIME + lane]
            fixed = legs[counts[AT + lane] * settings + 2]
            if GIVEN != 0:
                size = wide[more + LENGTHS + lane]
                if kernels[RATES_WIDE] != 0 and not size > 8.0 * _EPS * abs(t):  # a bend is closer
                    straight = straight_wide(lane, n, wide, w, tolerances)
                    if straight == straight:
                        size = straight
                if size != size:
                    blame = blame_wide(lane, n, wide, w)
                    last_state(lane, n, wide, w, counts, initial)
                    leave(lane, NOT_FINITE, blame, t, counts, kept, ends)
                    active -= 1
                    wide[more + STEPS + lane] = 0.0
                    continue
                if fixed == 0.0 and counts[AFTER + lane] == 0:
                    h = direction * size
            if abs(h) > options[LONGEST]:
                h = direction * options[LONGEST]
            counts[ENDS + lane] = 0
            after = t + h
            if (t + 1.01 * h - until) * direction >= 0.0:
                h = until - t
                counts[ENDS + lane] = 1
                after = until
            elif abs(h) <= 8.0 * _EPS * abs(t) or abs(h) < _TINY:
                last_state(lane, n, wide, w, counts, initial)
                leave(lane, COLLAPSED, 0, t, counts, kept, ends)
                active -= 1
                h = 0.0
            elif fixed != 0.0:
                after = control[FIRST + lane] + (counts[TAKEN + lane] + 1) * h
            wide[more + STEPS + lane], wide[more + AFTERS + lane] = h, after
        if active == 0:
            continue
        attempt_wide(kernels[WIDE], wide, w, c)
        for i in range(w):
            wide[END * w + i] = wide[RAW * w + i]
        unit_wide(wide, w, END, quaternions, nq)
        judge_wide(kernels[RATES_WIDE], n, wide, w, c, tolerances)
        for lane in range(8):
            wide[more + MOMENTS + lane] = wide[more + AFTERS + lane]
        if not free:
            for lane in range(8):
                if counts[RUN + lane] >= 0:
                    fixed = legs[counts[AT + lane] * settings + 2]
                    if fixed != 0.0 and wide[more + ERRORS + lane] > 1.0:
                        wide[more + ERRORS + lane] = 1.0
        if kernels[PROJECTION_WIDE] != 0:
            project_wide(kernels[PROJECTION_WIDE], n, wide, w, c, quaternions, nq, control)
        if GIVEN == 0:
            call_wide(kernels[WIDE], wide, more + MOMENTS, wide, END * w, c, wide, 12 * w)
            all_finite(wide, w, 12 * w, more + ERRORS)
        if sizes[SEEN] != 0:
            call_wide(kernels[WATCHED_WIDE], wide, more + MOMENTS, wide, END * w, c, wide, sizes[SEEN])
        if sizes[STIFF_ASKED] != 0:
            limit_wide(wide, w)
        others = 8
        if plain:
            if taken(wide, more, control, counts, sizes[BUDGET], sizes[LIMIT]):
                others = 0
            if GIVEN == 0:
                for lane in range(8):
                    if wide[more + EASY + lane] != 0.0:
                        error = wide[more + ERRORS + lane]
                        wide[more + STEPS + lane] *= lengthening(error, control[OLDS + lane])
                        control[OLDS + lane] = greater(error, 1e-4)
        for lane in range(others):
            if plain and wide[more + EASY + lane] != 0.0:
                continue
            wide[more + WANTED + lane] = 0.0
            run = counts[RUN + lane]
            if run < 0:
                continue
            t, h, after = wide[more + TIMES + lane], wide[more + STEPS + lane], wide[more + AFTERS + lane]
            leg = counts[AT + lane]
            reaches, goes_on = counts[ENDS + lane] != 0, leg + 1 < sizes[N_LEGS]
            until, fixed = control[LAST_TIME + lane], legs[leg * settings + 2]
            error = wide[more + ERRORS + lane]
            code, blame = RUNNING, 0
            if not error <= 1.0:
                counts[REJECTED + lane] += 1
                counts[AFTER + lane] = 1
                if error == error:
                    h *= greater(SMALLEST, SAFETY / error**EXPONENT)
                    if fixed != 0.0:
                        code = DIVERGED
                else:
                    blame = lost(lane, n, wide, w, 1, 12)
                    if blame < 0:
                        blame = lost(lane, n, wide, w, RAW, 3)
                    h *= 0.25
                    if fixed != 0.0 or abs(h) <= 16.0 * _EPS * abs(t) or abs(h) < _TINY:
                        code = NOT_FINITE
                wide[more + STEPS + lane] = h
            else:
                counts[TAKEN + lane] += 1
                control[STRIDE + lane] = greater(control[STRIDE + lane], abs(h))
                limited = wide[more + LIMITED + lane]
                if limited != 0.0 or counts[SUSPECT + lane] > 0:
                    stiff = stiff_wide(lane, limited, counts)
                    if stiff * sizes[STIFF_ASKED] != 0 and abs(until - after) > MANY * abs(h):
                        code = STIFF
                done = counts[DONE + lane]
                seeking = m > 0 or many > 0
                if sizes[SEEN] != 0:
                    place = lane * (PARTS + 3) * (m + 1)
                    near = near_limit(lane, sizes, wide, shifted(table, place), shifted(last, lane * m))
                    seeking = near != 0
                lifted = seeking or (done < count and (wanted[done] - after) * direction <= 0.0)
                own = shifted(alone, lane * hoisted)
                if lifted or left > 0:
                    lift(lane, n, wide, w, work, w1)
                if seeking:
                    stop = seek(
                        lane, kernels, sizes, options, after, quaternions, directions, terminal, relative, work, spare,
                        wide, w, own, single, control, counts, last, table, g, found, event_log, event_states,
                        spare_integers, reduced, event_times, happened,
                    )  # fmt: skip
                    if stop >= 0.0:
                        code, reaches = TERMINAL, False
                        if counts[BLAMED] > 0:
                            code, blame = UNDEFINED, counts[BLAMED] - 1
                        after = after if stop == 1.0 else t + stop * h
                if lifted:
                    while done < count and (wanted[done] - after) * direction <= 0.0:
                        x = wanted[done]
                        if x == until and reaches and goes_on:
                            break  # the break point belongs to the next leg
                        row = STATE if x == t else END
                        if x != t and x != after:
                            _part(
                                kernels[RATES], (x - t) / h, t, h, work, w1, n, own, quaternions, nq, relative, single,
                                spare_integers,
                            )  # fmt: skip
                            row = POINT
                        call(kernels[OUTPUTS], x, work, row * w1, own, values, (run * count + done) * outputs)
                        done += 1
                    counts[DONE + lane] = done
                    control[NEXT + lane] = wanted[done] if done < count else direction * math.inf
                if (
                    left > 0
                    and contradicted(kernels[DROPPED], left, after, work, END * w1, n, own, spare) != 0
                ):
                    code, reaches = LEFT, False
                t = after
                wide[more + TIMES + lane] = t
                wide[more + WANTED + lane] = 1.0
                if reaches and goes_on:
                    if counts[TAKEN + lane] > 1:
                        control[NATURAL + lane] = control[STRIDE + lane]
                    else:
                        control[NATURAL + lane] = greater(control[NATURAL + lane], control[STRIDE + lane])
                    counts[BEFORE + lane] += counts[TAKEN + lane]
                    counts[AT + lane] += 1
                    for i in range(n):
                        work[STATE * w1 + i] = wide[END * w + 8 * i + lane]
                    wide[more + WANTED + lane] = 0.0  # the start of the leg stands already
                    code = enter_leg(
                        lane, kernels, sizes, options, parameters, legs, columns, wanted, quaternions, relative, given,
                        directions, terminal, work, spare, mine, wide, w, c, alone, tolerances, single, control,
                        counts, last, table, g, values, reduced, event_times, happened, spare_integers,
                    )  # fmt: skip
                    blame = counts[BLAMED]
                    if code == RUNNING:
                        if counts[BEFORE + lane] < sizes[LIMIT]:
                            continue
                        code = TOO_MANY
                elif reaches:
                    code = FINISHED
                elif code == RUNNING and counts[BEFORE + lane] + counts[TAKEN + lane] >= sizes[LIMIT]:
                    code = TOO_MANY
                if GIVEN == 0 and fixed == 0.0:
                    factor = lengthening(error, control[OLDS + lane])
                    h *= factor if counts[AFTER + lane] == 0 else lesser(1.0, factor)
                counts[AFTER + lane] = 0
                if counts[TAKEN + lane] == sizes[BUDGET]:
                    finest = tolerances[w + lane]
                    for i in range(n):
                        finest = lesser(tolerances[w + 8 * i + lane], finest)
                    least = options[FINEST] / finest
                    first = control[FIRST + lane]
                    tighter = tightening(sizes[BUDGET], t - first, until - t, options[ORDER], least)
                    for i in range(n):
                        tolerances[8 * i + lane] *= tighter
                        tolerances[w + 8 * i + lane] *= tighter
                    tune(lane, n, wide, w, tolerances, fixed, control)
                    h *= tighter ** (1.0 / options[ORDER])
                wide[more + STEPS + lane] = h
                control[OLDS + lane] = greater(error, 1e-4)
            if code != RUNNING:
                last_state(lane, n, wide, w, counts, initial)
                leave(lane, code, blame, t, counts, kept, ends)
                active -= 1
        blend(wide, w, END * w, STATE * w, more + WANTED)
        accept_wide(wide, w, more + WANTED)
