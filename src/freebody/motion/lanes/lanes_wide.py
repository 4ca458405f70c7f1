"""The loop over eight lanes at once, with one run in each of the eight numbers of a vector register.

Each lane has its own time, step, error and control, exactly as in `step_control.advance`. The eight lanes attempt their
steps together. A rejected lane tries again while the others go on. A lane that has ended makes room for the next run. A
method for eight lanes (`dop853_wide`, `taylor_wide`) treats each lane separately, so that a lane does not depend on its
neighbours. `dop853_wide` does the operations of `dop853` in the same order, so that a lane equals a single run to the
last bit.

If a lane has to be examined inside its step, for events, extremes or states at output times, the step is copied from
the rows of eight lanes into a work array of its own, and `step_control` continues there.

Rows of ``wide`` hold component i of lane l at 8 i + l, as do the two rows of ``tolerances``: absolute and relative
tolerances of each lane.

The file is longer than others: it is one loop.
"""

from __future__ import annotations

import math
from typing import Any

from ...native.instructions import Compiled, Integers, Parts, Reals, call, greater, lesser, shifted, whole
from ...native.loop import module_named, sibling
from ..ode.layout import (
    BLAME,
    COLLAPSED,
    CULPRIT,
    DIVERGED,
    END,
    ERROR5,
    FINISHED,
    LOG_SIZE,
    MANY,
    NOT_FINITE,
    PARTS,
    POINT,
    PROJECTED,
    RAW,
    REACH,
    REQUIRED,
    RUNNING,
    STATE,
    STIFF,
    TERMINAL,
    UNDEFINED,
)
from ..ode.loops import place
from ..ode.step_control import _EPS, _TINY, EXPONENT, PREDICTED, SAFETY, SMALLEST
from .instructions_wide import all_finite, blend, call_wide, moved, settled, taken, unit_at
from .lanes import functions as of_one
from .lanes_layout import (
    AFTER_REJECTION,
    AFTERS,
    ALLOWED,
    BUDGET,
    CALM,
    CHANGES,
    CONTRADICTED,
    DROPPED,
    EARLIER_STEPS,
    EASY,
    ENDS,
    ENERGY,
    ENERGY_SCALE,
    ERRORS,
    EXTREMES,
    FINEST,
    LEG,
    LEG_END,
    LEG_INDEX,
    LEG_START,
    LENGTHS,
    LIMIT,
    LIMIT_VALUES,
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
    NEXT_OUTPUT,
    OLD_ERRORS,
    ORDER,
    OUTCOME_SIZE,
    OUTPUTS,
    OUTPUTS_DONE,
    PREVIOUS_STRIDE,
    PROJECTION_WIDE,
    PROLOGUE,
    RATES,
    RATES_WIDE,
    REDUCED,
    REJECTED,
    RUN,
    SELECTED,
    STEPS,
    STOP_STIFF_LANES,
    STRIDE,
    SUSPECT,
    T0,
    T1,
    TAKEN,
    TIMES,
    TOO_MANY,
    WATCHED_WIDE,
    WIDE,
    WIDE_BLAME,
    WIDE_PLACES,
    WIDTH_OF_ROW,
    WORKS,
    N,
)
from .lanes_layout import WATCHED as EVENTS

part = Parts()

# Bound by `functions` to functions of the loop over one lane and of the method for eight lanes.
normalise: Any = None
first_length: Any = None
look: Any = None
densify: Any = None
find_events: Any = None
log_events: Any = None
state_in_step: Any = None
lengthening: Any = None
tightening: Any = None
set_constants: Any = None
jumped: Any = None
contradicted: Any = None
begun_beyond: Any = None
log_event: Any = None
widen: Any = None
HEIGHT = 0
"""Number of rows of a method; the places of the lanes follow them."""
prepare_wide: Any = None
"""(kernel, wide, w, c, tolerances): called before the lengths of the steps are chosen."""
attempt_wide: Any = None
"""(kernel, wide, w, c): steps of all lanes from STATE to RAW."""
judge_wide: Any = None
"""(rates, n, wide, w, c, tolerances): sets ERRORS to the errors of the steps in units of their tolerances, nan if not
finite; ``rates`` is their kernel if a series may continue past a bend, else 0."""
limit_wide: Any = None
"""(wide, w): sets LIMITED to 1 if stability may limit a step, else 0."""
begin_wide: Any = None
"""(lane, n, wide, w): called before the first step of a lane from a new start."""
tune_wide: Any = None
"""(lane, n, wide, w, tolerances): called when the tolerances of a lane have changed."""
accept_wide: Any = None
"""(wide, w, selected): called after the lanes in which the number at ``selected`` is not 0 took their steps."""
blame_wide: Any = None
"""(lane, n, wide, w) -> the component of a lane to blame if there is no length."""
straight_wide: Any = None
"""(lane, n, wide, w, tolerances) -> the length of a straight step before a bend that is closer than the time
resolves."""
lift: Any = None
"""(lane, n, wide, w, work, w1): copies the step of a lane into a work array of its own."""


def functions(method: str) -> dict[str, Compiled]:
    """Return the compiled loop over eight lanes of a method, and the functions it calls."""
    numbers = module_named(place(method)).FUNCTIONS.method
    control = {name: numbers[name] for name in ("PREDICTED", "EXPONENT", "BETA") if name in numbers}
    functions_of_one = of_one(method)
    wide = module_named(sibling(__name__, f"{method}_wide")).FUNCTIONS
    compiled_functions = {name: function for name, function in wide.items() if isinstance(function, Compiled)}
    return {
        **functions_of_one,
        **compiled_functions,
        **part.bound({**globals(), **control, **functions_of_one, **wide}),
    }


@part
def lost(lane: int, n: int, wide: Reals, w: int, row: int, rows: int) -> int:
    """Return the first component of a lane that is not finite in the first of ``rows`` rows that has one, or -1."""
    for k in range(row, row + rows):
        for i in range(n):
            if not math.isfinite(wide[k * w + 8 * i + lane]):
                return i
    return -1


@part
def project_wide(
    kernel: int, n: int, wide: Reals, w: int, c: Reals, quaternions: Integers, nq: int, control: Reals
) -> None:  # fmt: skip
    """Move the ends of the steps onto the constraints in lanes whose error is at most 1 (`step_control.project`).

    A change that is too large is no step error: the error of that lane becomes 1000.
    """
    places = HEIGHT * w
    count = 0
    for lane in range(8):
        wide[places + SELECTED + lane] = 0.0
        if wide[places + ERRORS + lane] <= 1.0:
            wide[places + SELECTED + lane] = 1.0
            count += 1
    k = 0
    while count > 0 and k < 5:
        call_wide(kernel, wide, places + MOMENTS, wide, END * w, c, wide, ERROR5 * w)
        moved(
            wide, 8 * quaternions[nq + PROJECTED], ERROR5 * w, END * w, places + SELECTED, places + CHANGES
        )  # fmt: skip
        unit_wide(wide, w, END, quaternions, nq)
        count = 0
        for lane in range(8):
            change = wide[places + CHANGES + lane]
            if wide[places + SELECTED + lane] != 0.0:
                if k == 0 and not change <= control[ALLOWED + lane]:
                    wide[places + ERRORS + lane] = 1e3
                wide[places + SELECTED + lane] = 0.0
                if change > 1e-8:
                    wide[places + SELECTED + lane] = 1.0
                    count += 1
        k += 1


@part
def unit_wide(wide: Reals, w: int, row: int, quaternions: Integers, nq: int) -> None:
    """Divide the quaternions of a row by their norms (`step_control.normalise`)."""
    for k in range(nq):
        unit_at(wide, row * w + 8 * quaternions[k])


@part
def stiff_wide(lane: int, limited: float, counts: Integers) -> int:
    """Return 1 if a lane is stiff (`step_control.is_stiff`)."""
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
    """Return 1 if a lane may pass a limit in its step.

    It may if a value at one of its ends is at most twice its change in this step or in the one before. Values far from
    zero are copied as the start values of the next step.
    """
    m, values, result = sizes[N_WATCHED], sizes[LIMIT_VALUES], 0
    for e in range(m):
        now, before, changes = wide[values + 8 * e + lane], table[e], values + 8 * (m + e) + lane
        change = abs(now - before)
        if not lesser(now, before) > 2.0 * greater(change, wide[changes]):
            result = 1
        wide[changes] = change
    if result == 0:
        for e in range(m):
            table[e] = wide[values + 8 * e + lane]
            last[e] = 1
    return result


@part
def tune(lane: int, n: int, wide: Reals, w: int, tolerances: Reals, fixed: float, control: Reals) -> None:
    """Update the quantities that depend on the tolerances of a lane."""
    allowed = 0.0
    for i in range(n):
        allowed = greater(allowed, 1e3 * tolerances[w + 8 * i + lane])
    control[ALLOWED + lane] = allowed if fixed == 0.0 else 0.1  # see `step_control.advance`
    tune_wide(lane, n, wide, w, tolerances)


@part
def last_state(lane: int, n: int, wide: Reals, w: int, counts: Integers, initial: Reals) -> None:
    """Store the last good state of a lane in place of its initial state. Python looks there for the cause of a
    failure.
    """
    for i in range(n):
        initial[counts[RUN + lane] * n + i] = wide[STATE * w + 8 * i + lane]


@part
def leave(
    lane: int, code: int, blame: int, t: float, counts: Integers, statuses: Integers, ends: Reals
) -> None:
    """Remove a run from its lane and store its results."""
    run = counts[RUN + lane]
    statuses[OUTCOME_SIZE * run] = code
    statuses[OUTCOME_SIZE * run + 1] = counts[EARLIER_STEPS + lane] + counts[TAKEN + lane]
    statuses[OUTCOME_SIZE * run + 2] = counts[REJECTED + lane]
    statuses[OUTCOME_SIZE * run + 3] = blame
    ends[run] = t
    counts[RUN + lane] = -1


@part
def enter(
    lane: int, run: int, kernels: Integers, sizes: Integers, options: Reals, initial: Reals, parameters: Reals,
    legs: Reals, columns: Integers, output_times: Reals, quaternions: Integers, relative: Reals, absolute_of_run: Reals,
    directions: Integers, terminal: Integers, work: Reals, spare: Reals, lane_parameters: Reals, wide: Reals, w: int,
    c: Reals, c_by_lane: Reals, tolerances: Reals, absolute: Reals, control: Reals, counts: Integers, last: Integers,
    table: Reals, g: Reals, values: Reals, reduced: Reals, event_times: Reals, event_counts: Integers,
    spare_integers: Integers,
) -> int:  # fmt: skip
    """Put a run into a lane.

    Return RUNNING, or the status of a run that cannot begin, with the component to blame in ``counts[WIDE_BLAME]``.
    """
    for i in range(sizes[N]):
        work[STATE * sizes[WIDTH_OF_ROW] + i] = initial[run * sizes[N] + i]
    for k in range(10):
        counts[8 * k + lane] = 0
    counts[RUN + lane] = run
    control[PREVIOUS_STRIDE + lane] = 0.0
    control[ENERGY_SCALE + lane] = 1.0
    return enter_leg(
        lane, kernels, sizes, options, parameters, legs, columns, output_times, quaternions, relative, absolute_of_run,
        directions, terminal, work, spare, lane_parameters, wide, w, c, c_by_lane, tolerances, absolute, control,
        counts, last, table, g, values, reduced, event_times, event_counts, spare_integers,
    )  # fmt: skip


@part
def enter_leg(
    lane: int, kernels: Integers, sizes: Integers, options: Reals, parameters: Reals, legs: Reals, columns: Integers,
    output_times: Reals, quaternions: Integers, relative: Reals, absolute_of_run: Reals, directions: Integers,
    terminal: Integers, work: Reals, spare: Reals, lane_parameters: Reals, wide: Reals, w: int, c: Reals,
    c_by_lane: Reals, tolerances: Reals, absolute: Reals, control: Reals, counts: Integers, last: Integers,
    table: Reals, g: Reals, values: Reals, reduced: Reals, event_times: Reals, event_counts: Integers,
    spare_integers: Integers,
) -> int:  # fmt: skip
    """Begin the next leg of a run with the state in ``work``."""
    n, w1, nq, n_constants = sizes[N], sizes[WIDTH_OF_ROW], sizes[N_QUATERNIONS], sizes[N_CONSTANTS]
    m, n_reduced, count = sizes[N_WATCHED], sizes[N_REDUCED], sizes[N_TIMES]
    leg, run = counts[LEG_INDEX + lane], counts[RUN + lane]
    row = leg * (LEG + sizes[N_SETTINGS])
    start, until, fixed = legs[row], legs[row + 1], legs[row + 2]
    direction = 1.0 if until >= start else -1.0
    longest = lesser(options[LONGEST], abs(until - start))
    c1 = shifted(c_by_lane, lane * n_constants)
    counts[WIDE_BLAME] = 0
    counts[TAKEN + lane] = counts[SUSPECT + lane] = counts[CALM + lane] = counts[AFTER_REJECTION + lane] = 0
    if leg > 0 and sizes[N_EVENTS] > 0:
        if jumped(
            run, leg, kernels, sizes, options[T0], start, work, parameters, legs, columns, directions, terminal,
            lane_parameters, c1, shifted(table, lane * (PARTS + 3) * (m + 1)), g, event_counts, event_times,
        ) != 0:  # fmt: skip
            set_constants(
                kernels[PROLOGUE], run, leg - 1, sizes, parameters, legs, columns, lane_parameters, c1
            )
            k = counts[OUTPUTS_DONE + lane]
            while k < count and (output_times[k] - start) * direction <= 0.0:
                place = (run * count + k) * sizes[N_OUTPUTS]
                call(kernels[OUTPUTS], output_times[k], work, STATE * w1, c1, values, place)
                k += 1
            return TERMINAL
    else:
        set_constants(kernels[PROLOGUE], run, leg, sizes, parameters, legs, columns, lane_parameters, c1)
    for j in range(n_constants):
        c[8 * j + lane] = c1[j]
    for i in range(sizes[N_WORK]):
        if i < STATE * w1 or i >= STATE * w1 + n:
            work[i] = 0.0
    for i in range(n):
        absolute[i] = absolute_of_run[i]
    normalise(work, STATE * w1, quaternions, nq)
    if PREDICTED == 0:
        call(kernels[RATES], start, work, STATE * w1, c1, work, 0)
        for i in range(n):
            if not math.isfinite(work[i]):
                counts[WIDE_BLAME] = i
                return NOT_FINITE
    if sizes[WORKS] != 0:
        if leg == 0:
            call(kernels[ENERGY], start, work, STATE * w1, c1, spare, 0)
            control[ENERGY_SCALE + lane] = greater(abs(spare[0]), abs(spare[1]))
        if 0.0 < control[ENERGY_SCALE + lane] < math.inf:
            absolute[n - 1] *= control[ENERGY_SCALE + lane]
    if m > 0:
        spare_integers[REQUIRED] = sizes[N_EVENTS]
        status = look(
            kernels[EVENTS], start, work, w1, m, c1, shifted(table, lane * (PARTS + 3) * (m + 1)),
            shifted(last, lane * m), spare_integers,
        )  # fmt: skip
        if status != RUNNING:
            counts[WIDE_BLAME] = spare_integers[BLAME]
            return status
        if leg == 0:
            begun_beyond(
                run, sizes, start, shifted(table, lane * (PARTS + 3) * (m + 1)), event_counts, event_times
            )
        if sizes[LIMIT_VALUES] != 0:
            for e in range(m):
                wide[sizes[LIMIT_VALUES] + 8 * (m + e) + lane] = math.inf
    if n_reduced > 0:
        place = run * n_reduced * EXTREMES
        if leg == 0:
            call(kernels[REDUCED], start, work, STATE * w1, c1, spare, 0)
            for k in range(n_reduced):
                for i in range(EXTREMES):
                    reduced[place + EXTREMES * k + i] = spare[k]
        else:
            widen(kernels[REDUCED], start, work, STATE * w1, c1, spare, n_reduced, reduced, place)
    n_dropped = sizes[N_DROPPED]
    if (
        n_dropped > 0
        and contradicted(kernels[DROPPED], n_dropped, start, work, STATE * w1, n, c1, spare) != 0
    ):
        return CONTRADICTED
    step = control[PREVIOUS_STRIDE + lane]
    if fixed != 0.0:
        step = fixed
    elif PREDICTED == 0 and step == 0.0:
        step = first_length(
            kernels[RATES], start, direction, longest, work, w1, n, c1, relative, absolute, options[ORDER]
        )  # fmt: skip
    for i in range(n):
        wide[STATE * w + 8 * i + lane] = work[STATE * w1 + i]
        wide[8 * i + lane] = work[i]
        tolerances[8 * i + lane] = absolute[i]
        tolerances[w + 8 * i + lane] = relative[i]
    begin_wide(lane, n, wide, w)
    tune(lane, n, wide, w, tolerances, fixed, control)
    places = HEIGHT * w
    wide[places + TIMES + lane] = control[LEG_START + lane] = start
    control[LEG_END + lane] = until
    wide[places + STEPS + lane] = direction * lesser(step, longest)
    control[OLD_ERRORS + lane] = 1e-4
    control[STRIDE + lane] = 0.0
    k = counts[OUTPUTS_DONE + lane]
    control[NEXT_OUTPUT + lane] = output_times[k] if k < count else direction * math.inf
    return RUNNING


@part
def seek(
    lane: int, kernels: Integers, sizes: Integers, options: Reals, after: float, quaternions: Integers,
    directions: Integers, terminal: Integers, relative: Reals, work: Reals, spare: Reals, wide: Reals, w: int,
    c1: Reals, absolute: Reals, control: Reals, counts: Integers, last: Integers, table: Reals, g: Reals, zeros: Reals,
    event_log: Reals, event_states: Reals, spare_integers: Integers, reduced: Reals, event_times: Reals,
    event_counts: Integers,
) -> float:  # fmt: skip
    """Find the events and extremes of a lane's step, which has been copied into ``work``.

    Return the fraction of the step at which a terminal event ends it, else -1. If an event function without a value
    ends it, ``counts[WIDE_BLAME]`` is 1 + its number, else 0.
    """
    n, w1, m, n_reduced = sizes[N], sizes[WIDTH_OF_ROW], sizes[N_WATCHED], sizes[N_REDUCED]
    nq, user_events, run = sizes[N_QUATERNIONS], sizes[N_EVENTS], counts[RUN + lane]
    places = HEIGHT * w
    t, h, first = wide[places + TIMES + lane], wide[places + STEPS + lane], control[LEG_START + lane]
    place, stop = run * n_reduced * EXTREMES, -1.0
    counts[WIDE_BLAME] = 0
    if m > 0:
        densify(kernels[RATES], t, h, work, w1, n, c1, quaternions, nq)
        count = find_events(
            kernels[EVENTS], t, h, work, w1, c1, quaternions, nq, m, user_events,
            shifted(table, lane * (PARTS + 3) * (m + 1)), g, shifted(last, lane * m), directions, zeros,
        )  # fmt: skip
        reach = zeros[REACH]
        stop = log_events(
            kernels[RATES], kernels[EVENTS], count, t, h, after, first, n, work, w1, c1, c1, quaternions, nq, g,
            zeros, terminal, event_log, event_states, 0, relative, absolute, spare_integers,
        )  # fmt: skip
        if stop >= 0.0 and stop == reach:
            counts[WIDE_BLAME] = 1 + whole(zeros[CULPRIT])
        for k in range(whole(zeros[3])):
            e = whole(event_log[LOG_SIZE * k + 1])
            if e < user_events:
                log_event(
                    run * user_events + e, event_log[LOG_SIZE * k], options[T0], first, sizes[N_LEGS], terminal[e],
                    event_counts, event_times,
                )  # fmt: skip
            if n_reduced > 0:
                widen(
                    kernels[REDUCED], event_log[LOG_SIZE * k], event_states, k * n, c1, spare, n_reduced, reduced, place
                )  # fmt: skip
    if n_reduced > 0:
        moment = after if stop < 0.0 or stop == 1.0 else t + stop * h
        widen(kernels[REDUCED], moment, work, END * w1, c1, spare, n_reduced, reduced, place)
    return stop


@part
def lanes_wide(
    begin: int, end: int, kernels: Integers, sizes: Integers, options: Reals, initial: Reals, parameters: Reals,
    legs: Reals, columns: Integers, output_times: Reals, quaternions: Integers, relative: Reals, absolute_of_run: Reals,
    directions: Integers, terminal: Integers, work: Reals, spare: Reals, lane_parameters: Reals, wide: Reals,
    c: Reals, c_by_lane: Reals, tolerances: Reals, absolute: Reals, control: Reals, counts: Integers,
    last: Integers, table: Reals, g: Reals, zeros: Reals, event_log: Reals, event_states: Reals,
    spare_integers: Integers, values: Reals, reduced: Reals, event_times: Reals, event_counts: Integers,
    statuses: Integers, ends: Reals,
) -> None:  # fmt: skip
    """Compute the runs ``begin`` to ``end`` - 1. The arguments are those of `lanes.lanes`, and memory of this thread.

    ``last`` and ``table`` have one part per lane. ``c_by_lane`` holds the constants lane by lane.
    """
    n, nq, w1 = sizes[N], sizes[N_QUATERNIONS], sizes[WIDTH_OF_ROW]
    w, m, n_reduced = 8 * n, sizes[N_WATCHED], sizes[N_REDUCED]
    outputs, count, n_constants, n_dropped = (
        sizes[N_OUTPUTS],
        sizes[N_TIMES],
        sizes[N_CONSTANTS],
        sizes[N_DROPPED],
    )
    direction = 1.0 if options[T1] >= options[T0] else -1.0
    places, settings = HEIGHT * w, LEG + sizes[N_SETTINGS]
    following, active = begin, 0
    free, plain = True, m == 0 and n_reduced == 0 and n_dropped == 0
    for leg in range(sizes[N_LEGS]):
        if legs[leg * settings + 2] != 0.0:
            free = plain = False
    for lane in range(8):
        counts[RUN + lane] = -1
    for k in range(WIDE_PLACES):
        wide[places + k] = 0.0
    while active > 0 or following < end:
        for lane in range(8):
            while counts[RUN + lane] < 0 and following < end:
                code = enter(
                    lane, following, kernels, sizes, options, initial, parameters, legs, columns, output_times,
                    quaternions, relative, absolute_of_run, directions, terminal, work, spare, lane_parameters, wide,
                    w, c, c_by_lane, tolerances, absolute, control, counts, last, table, g, values, reduced,
                    event_times, event_counts, spare_integers,
                )  # fmt: skip
                following += 1
                if code == RUNNING:
                    active += 1
                else:
                    leave(lane, code, counts[WIDE_BLAME], options[T0], counts, statuses, ends)
        prepare_wide(kernels[WIDE], wide, w, c, tolerances)
        # choose the steps of most lanes at once; lanes that end, were rejected, ... follow one by one
        one_by_one = 8
        if free and settled(
            wide, places, LENGTHS if PREDICTED != 0 else STEPS, control, counts, direction, options[LONGEST]
        ):
            one_by_one = 0
        for lane in range(one_by_one):
            if wide[places + EASY + lane] != 0.0:
                continue
            if counts[RUN + lane] < 0:
                wide[places + STEPS + lane] = 0.0
                continue
            t, h, until = wide[places + TIMES + lane], wide[places + STEPS + lane], control[LEG_END + lane]
            fixed = legs[counts[LEG_INDEX + lane] * settings + 2]
            if PREDICTED != 0:
                size = wide[places + LENGTHS + lane]
                if kernels[RATES_WIDE] != 0 and not size > 8.0 * _EPS * abs(t):  # a bend is closer than that
                    straight = straight_wide(lane, n, wide, w, tolerances)
                    if straight == straight:
                        size = straight
                if size != size:
                    blame = blame_wide(lane, n, wide, w)
                    last_state(lane, n, wide, w, counts, initial)
                    leave(lane, NOT_FINITE, blame, t, counts, statuses, ends)
                    active -= 1
                    wide[places + STEPS + lane] = 0.0
                    continue
                if fixed == 0.0 and counts[AFTER_REJECTION + lane] == 0:
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
                leave(lane, COLLAPSED, 0, t, counts, statuses, ends)
                active -= 1
                h = 0.0
            elif fixed != 0.0:
                after = control[LEG_START + lane] + (counts[TAKEN + lane] + 1) * h
            wide[places + STEPS + lane], wide[places + AFTERS + lane] = h, after
        if active == 0:
            continue
        attempt_wide(kernels[WIDE], wide, w, c)
        for i in range(w):
            wide[END * w + i] = wide[RAW * w + i]
        unit_wide(wide, w, END, quaternions, nq)
        judge_wide(kernels[RATES_WIDE], n, wide, w, c, tolerances)
        for lane in range(8):
            wide[places + MOMENTS + lane] = wide[places + AFTERS + lane]
        if not free:
            for lane in range(8):
                if counts[RUN + lane] >= 0:
                    fixed = legs[counts[LEG_INDEX + lane] * settings + 2]
                    if fixed != 0.0 and wide[places + ERRORS + lane] > 1.0:
                        wide[places + ERRORS + lane] = 1.0
        if kernels[PROJECTION_WIDE] != 0:
            project_wide(kernels[PROJECTION_WIDE], n, wide, w, c, quaternions, nq, control)
        if PREDICTED == 0:
            call_wide(kernels[WIDE], wide, places + MOMENTS, wide, END * w, c, wide, 12 * w)
            all_finite(wide, w, 12 * w, places + ERRORS)
        if sizes[LIMIT_VALUES] != 0:
            call_wide(
                kernels[WATCHED_WIDE], wide, places + MOMENTS, wide, END * w, c, wide, sizes[LIMIT_VALUES]
            )
        if sizes[STOP_STIFF_LANES] != 0:
            limit_wide(wide, w)
        one_by_one = 8
        if plain:
            if taken(wide, places, control, counts, sizes[BUDGET], sizes[LIMIT]):
                one_by_one = 0
            if PREDICTED == 0:
                for lane in range(8):
                    if wide[places + EASY + lane] != 0.0:
                        error = wide[places + ERRORS + lane]
                        wide[places + STEPS + lane] *= lengthening(error, control[OLD_ERRORS + lane])
                        control[OLD_ERRORS + lane] = greater(error, 1e-4)
        for lane in range(one_by_one):
            if plain and wide[places + EASY + lane] != 0.0:
                continue
            wide[places + SELECTED + lane] = 0.0
            run = counts[RUN + lane]
            if run < 0:
                continue
            t, h, after = (
                wide[places + TIMES + lane],
                wide[places + STEPS + lane],
                wide[places + AFTERS + lane],
            )
            leg = counts[LEG_INDEX + lane]
            reaches, goes_on = counts[ENDS + lane] != 0, leg + 1 < sizes[N_LEGS]
            until, fixed = control[LEG_END + lane], legs[leg * settings + 2]
            error = wide[places + ERRORS + lane]
            code, blame = RUNNING, 0
            if not error <= 1.0:
                counts[REJECTED + lane] += 1
                counts[AFTER_REJECTION + lane] = 1
                if error == error:
                    h *= greater(SMALLEST, SAFETY / error**EXPONENT)
                    if fixed != 0.0:
                        code = DIVERGED
                else:
                    if PREDICTED != 0:
                        blame = blame_wide(lane, n, wide, w)
                    else:
                        blame = lost(lane, n, wide, w, 1, 12)
                        if blame < 0:
                            blame = lost(lane, n, wide, w, RAW, 3)
                    h *= 0.25
                    if fixed != 0.0 or abs(h) <= 16.0 * _EPS * abs(t) or abs(h) < _TINY:
                        code = NOT_FINITE
                wide[places + STEPS + lane] = h
            else:
                counts[TAKEN + lane] += 1
                control[STRIDE + lane] = greater(control[STRIDE + lane], abs(h))
                limited = wide[places + LIMITED + lane]
                if limited != 0.0 or counts[SUSPECT + lane] > 0:
                    stiff = stiff_wide(lane, limited, counts)
                    if stiff * sizes[STOP_STIFF_LANES] != 0 and abs(until - after) > MANY * abs(h):
                        code = STIFF
                done = counts[OUTPUTS_DONE + lane]
                seeking = m > 0 or n_reduced > 0
                if sizes[LIMIT_VALUES] != 0:
                    place = lane * (PARTS + 3) * (m + 1)
                    near = near_limit(lane, sizes, wide, shifted(table, place), shifted(last, lane * m))
                    seeking = near != 0
                lifted = seeking or (done < count and (output_times[done] - after) * direction <= 0.0)
                c1 = shifted(c_by_lane, lane * n_constants)
                if lifted or n_dropped > 0:
                    lift(lane, n, wide, w, work, w1)
                if seeking:
                    stop = seek(
                        lane, kernels, sizes, options, after, quaternions, directions, terminal, relative, work, spare,
                        wide, w, c1, absolute, control, counts, last, table, g, zeros, event_log, event_states,
                        spare_integers, reduced, event_times, event_counts,
                    )  # fmt: skip
                    if stop >= 0.0:
                        code, reaches = TERMINAL, False
                        if counts[WIDE_BLAME] > 0:
                            code, blame = UNDEFINED, counts[WIDE_BLAME] - 1
                        after = after if stop == 1.0 else t + stop * h
                if lifted:
                    while done < count and (output_times[done] - after) * direction <= 0.0:
                        x = output_times[done]
                        if x == until and reaches and goes_on:
                            break  # the break point belongs to the next leg
                        row = STATE if x == t else END
                        if x != t and x != after:
                            state_in_step(
                                kernels[RATES], (x - t) / h, t, h, work, w1, n, c1, quaternions, nq, relative, absolute,
                                spare_integers,
                            )  # fmt: skip
                            row = POINT
                        call(kernels[OUTPUTS], x, work, row * w1, c1, values, (run * count + done) * outputs)
                        done += 1
                    counts[OUTPUTS_DONE + lane] = done
                    control[NEXT_OUTPUT + lane] = output_times[done] if done < count else direction * math.inf
                if (
                    n_dropped > 0
                    and contradicted(kernels[DROPPED], n_dropped, after, work, END * w1, n, c1, spare) != 0
                ):
                    code, reaches = CONTRADICTED, False
                t = after
                wide[places + TIMES + lane] = t
                wide[places + SELECTED + lane] = 1.0
                if reaches and goes_on:
                    if counts[TAKEN + lane] > 1:
                        control[PREVIOUS_STRIDE + lane] = control[STRIDE + lane]
                    else:
                        control[PREVIOUS_STRIDE + lane] = greater(
                            control[PREVIOUS_STRIDE + lane], control[STRIDE + lane]
                        )
                    counts[EARLIER_STEPS + lane] += counts[TAKEN + lane]
                    counts[LEG_INDEX + lane] += 1
                    for i in range(n):
                        work[STATE * w1 + i] = wide[END * w + 8 * i + lane]
                    wide[places + SELECTED + lane] = 0.0  # STATE already holds the start of the leg
                    code = enter_leg(
                        lane, kernels, sizes, options, parameters, legs, columns, output_times, quaternions, relative,
                        absolute_of_run, directions, terminal, work, spare, lane_parameters, wide, w, c, c_by_lane,
                        tolerances, absolute, control, counts, last, table, g, values, reduced, event_times,
                        event_counts, spare_integers,
                    )  # fmt: skip
                    blame = counts[WIDE_BLAME]
                    if code == RUNNING:
                        if counts[EARLIER_STEPS + lane] < sizes[LIMIT]:
                            continue
                        code = TOO_MANY
                elif reaches:
                    code = FINISHED
                elif code == RUNNING and counts[EARLIER_STEPS + lane] + counts[TAKEN + lane] >= sizes[LIMIT]:
                    code = TOO_MANY
                if PREDICTED == 0 and fixed == 0.0:
                    factor = lengthening(error, control[OLD_ERRORS + lane])
                    h *= factor if counts[AFTER_REJECTION + lane] == 0 else lesser(1.0, factor)
                counts[AFTER_REJECTION + lane] = 0
                if counts[TAKEN + lane] == sizes[BUDGET]:
                    finest = tolerances[w + lane]
                    for i in range(n):
                        finest = lesser(tolerances[w + 8 * i + lane], finest)
                    least = options[FINEST] / finest
                    first = control[LEG_START + lane]
                    tighter = tightening(sizes[BUDGET], t - first, until - t, options[ORDER], least)
                    for i in range(n):
                        tolerances[8 * i + lane] *= tighter
                        tolerances[w + 8 * i + lane] *= tighter
                    tune(lane, n, wide, w, tolerances, fixed, control)
                    h *= tighter ** (1.0 / options[ORDER])
                wide[places + STEPS + lane] = h
                control[OLD_ERRORS + lane] = greater(error, 1e-4)
            if code != RUNNING:
                last_state(lane, n, wide, w, counts, initial)
                leave(lane, code, blame, t, counts, statuses, ends)
                active -= 1
        blend(wide, w, END * w, STATE * w, places + SELECTED)
        accept_wide(wide, w, places + SELECTED)
