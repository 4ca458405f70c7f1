"""The loop over lanes: many runs of one machine, one after another, without Python between them.

A lane is a run with its own parameters and initial state. It goes through the loop of `step_control` exactly as a
single run does: the same first step, the same control, the same states between steps, to the last bit. A lane leaves
the requested results only: outputs at given times, extremes, first and last times of events, and its status. Its steps
are not stored.

Outputs at given times are ends of shorter steps (`step_control.sample`), computed in separate memory so that they do
not disturb the run. If signals have break points, the run goes in legs as a single run does (`driven`): constants, the
memory of the step-size control and the length of the first step are new in each leg. Extremes are looked for at the
start and the end of every step, and at the zeros of the rate of the quantity, which are watched as events are.

The file is longer than others because of its list of indices. The loop is one function, which Python may not interrupt.
"""

from __future__ import annotations

import math
from typing import Any

from ...native.instructions import (
    EPS,
    Compiled,
    Integers,
    Parts,
    Reals,
    call,
    greater,
    lesser,
    shifted,
    whole,
)
from ...native.loop import module_named
from ..ode.layout import (
    ACCEPTED,
    BLAME,
    EVENTS,
    FINISHED,
    FIXED,
    INTEGERS,
    LOG_SIZE,
    MAX_STEP,
    METHOD_ORDER,
    REALS,
    REJECTED,
    REQUIRED,
    RUNNING,
    SAMPLED,
    START,
    STATE,
    STEP,
    STOP_IF_STIFF,
    TAKEN,
    TERMINAL,
    TIME,
    UNTIL,
)
from ..ode.loops import place
from .lanes_layout import (
    BUDGET,
    CONTRADICTED,
    DROPPED,
    ENERGY,
    EXTREMES,
    FINEST,
    LEG,
    LIMIT,
    LONGEST,
    N_DROPPED,
    N_EVENTS,
    N_LEGS,
    N_LIMITS,
    N_OUTPUTS,
    N_PARAMETERS,
    N_QUATERNIONS,
    N_REDUCED,
    N_SETTINGS,
    N_TIMES,
    N_WATCHED,
    N_WORK,
    ORDER,
    OUTCOME_SIZE,
    OUTPUTS,
    PROLOGUE,
    RATES,
    REDUCED,
    ROOM,
    STOP_STIFF_LANES,
    T0,
    T1,
    TOO_MANY,
    WATCHED,
    WIDTH_OF_ROW,
    WORKS,
    N,
)

__all__ = ["functions"]

part = Parts()

# Bound by `functions` to the compiled loop of a method.
normalise: Any = None
launch: Any = None
look: Any = None
advance: Any = None
sample: Any = None


def functions(method: str) -> dict[str, Compiled]:
    """Return the compiled loop over lanes of a method, with the method's own functions."""
    method_functions = module_named(place(method)).FUNCTIONS
    return {**method_functions, **part.bound({**globals(), **method_functions})}


@part
def tightening(steps: int, behind: float, ahead: float, order: float, least: float) -> float:
    """Return the factor on the tolerances of a run that has used its budget of steps (`integrate`).

    ``behind`` and ``ahead`` are times. The factor ``least`` gives the smallest admissible tolerance.
    """
    steps_ahead = steps * ahead / behind
    factor = 1.0
    if steps_ahead > steps:
        factor = (steps / steps_ahead) ** (order / (order - 1.0))
    return greater(factor, lesser(1.0, least))


@part
def widen(
    kernel: int, t: float, states: Reals, place: int, c: Reals, spare: Reals, count: int, reduced: Reals, j: int
) -> None:  # fmt: skip
    """Update the greatest, smallest and last value of each of ``count`` quantities with their values at one more state.

    A quantity without a value at a state keeps the value nan.
    """
    call(kernel, t, states, place, c, spare, 0)
    for k in range(count):
        x = spare[k]
        row = j + EXTREMES * k
        if x > reduced[row] or x != x:
            reduced[row] = x
        if x < reduced[row + 1] or x != x:
            reduced[row + 1] = x
        reduced[row + 3] = x


@part
def set_constants(
    prologue: int, lane: int, leg: int, sizes: Integers, parameters: Reals, legs: Reals, columns: Integers,
    lane_parameters: Reals, c: Reals,
) -> None:  # fmt: skip
    """Set the constants of a lane in an interval between break points of its signals."""
    p, settings = sizes[N_PARAMETERS], sizes[N_SETTINGS]
    for k in range(p):
        lane_parameters[k] = parameters[lane * p + k]
    for k in range(settings):
        lane_parameters[columns[k]] = legs[leg * (LEG + settings) + LEG + k]
    call(prologue, 0.0, lane_parameters, 0, c, c, 0)


@part
def log_event(
    row: int, t: float, start: float, first: float, legs: int, terminal: int, counts: Integers, event_times: Reals
) -> None:  # fmt: skip
    """Log event number ``row`` of all lanes, unless it was logged at the end of the leg before; this leg began at
    ``first``.

    A terminal event at the ``start`` of the run does not end a run and is not logged.
    """
    if terminal != 0 and t == start:
        return
    again = legs > 1 and counts[row] > 0 and abs(event_times[2 * row + 1] - t) <= 1e-12
    if again and t - first <= 4.0 * EPS * greater(1.0, abs(first)):
        return
    if counts[row] == 0:
        event_times[2 * row] = t
    event_times[2 * row + 1] = t
    counts[row] += 1


@part
def begun_beyond(
    lane: int, sizes: Integers, t: float, table: Reals, counts: Integers, event_times: Reals
) -> None:  # fmt: skip
    """Log an event at the start for each limit that a run begins beyond; the first row of ``table`` holds their
    values.
    """
    user_events = sizes[N_EVENTS]
    for e in range(user_events - sizes[N_LIMITS], user_events):
        if table[e] < 0.0:
            log_event(lane * user_events + e, t, t, t, 0, 0, counts, event_times)


@part
def jumped(
    lane: int, leg: int, kernels: Integers, sizes: Integers, start: float, t: float, work: Reals, parameters: Reals,
    legs: Reals, columns: Integers, directions: Integers, terminal: Integers, lane_parameters: Reals, c: Reals,
    before: Reals, after: Reals, counts: Integers, event_times: Reals,
) -> int:  # fmt: skip
    """Log an event for each function that jumps across zero at the beginning ``t`` of a leg; set the constants of the
    leg.

    Return 1 if one of these events is terminal.
    """
    w, user_events, result = sizes[WIDTH_OF_ROW], sizes[N_EVENTS], 0
    call(kernels[WATCHED], t, work, STATE * w, c, before, 0)
    set_constants(kernels[PROLOGUE], lane, leg, sizes, parameters, legs, columns, lane_parameters, c)
    call(kernels[WATCHED], t, work, STATE * w, c, after, 0)
    for e in range(user_events):
        if (before[e] < 0.0 < after[e]) or (after[e] < 0.0 < before[e]):
            sign = 1 if after[e] > 0.0 else -1
            if directions[e] == 0 or directions[e] == sign:
                log_event(lane * user_events + e, t, start, t - 1.0, 0, terminal[e], counts, event_times)
                if terminal[e] != 0:
                    result = 1
    return result


@part
def contradicted(
    kernel: int, residuals: int, t: float, states: Reals, place: int, n: int, c: Reals, spare: Reals
) -> int:  # fmt: skip
    """Return 1 if a condition that was redundant at the start does not hold, or if, by the last output, other
    conditions should replace the active ones.
    """
    size = 0.0
    for i in range(n):
        size = greater(size, abs(states[place + i]))
    call(kernel, t, states, place, c, spare, 0)
    for j in range(residuals - 1):
        if abs(spare[j]) > 1e-6 * (1.0 + size):
            return 1
    return 1 if spare[residuals - 1] > 0.0 else 0


@part
def lanes(
    begin: int, end: int, kernels: Integers, sizes: Integers, options: Reals, initial: Reals, parameters: Reals,
    legs: Reals, columns: Integers, output_times: Reals, quaternions: Integers, relative: Reals, tolerances: Reals,
    directions: Integers, terminal: Integers, work: Reals, sampling_work: Reals, lane_parameters: Reals, c: Reals,
    absolute: Reals, times: Reals, lengths: Reals, states: Reals, last: Integers, table: Reals, g: Reals, zeros: Reals,
    event_log: Reals, event_states: Reals, sampled: Reals, spare: Reals, reals: Reals, integers: Integers,
    spare_integers: Integers, values: Reals, reduced: Reals, event_times: Reals, counts: Integers, statuses: Integers,
    ends: Reals,
) -> None:  # fmt: skip
    """Compute the runs ``begin`` to ``end`` - 1.

    Parameters
    ----------
    kernels, sizes, options      addresses, counts and numbers (`lanes_layout`)
    initial, parameters          rows of each lane: y, and the parameters
    legs                         rows of each interval: start, end, length of all steps or 0, settings of the signals
    columns                      indices of the parameters that these settings are
    output_times                 in the order of the run
    quaternions                  as in `step_control.advance`
    relative, tolerances         of each component; the last of ``tolerances``, of the work, is relative to the energy
    directions, terminal         of the events, and of the rates of extremes after them
    work ... spare_integers      memory of this thread; ``absolute`` holds a lane's relative tolerances, too
    values                       rows of each lane: outputs at each time; nan after the end of the lane
    reduced                      rows of each lane: greatest, smallest, first and last value of each quantity
    event_times                  rows of each lane: first and last time of each event
    counts                       rows of each lane: number of occurrences of each event
    statuses, ends               rows of each lane: status, steps, rejected steps, component to blame; time of the end
    """
    n, w, nq = sizes[N], sizes[WIDTH_OF_ROW], sizes[N_QUATERNIONS]
    m, user_events = sizes[N_WATCHED], sizes[N_EVENTS]
    outputs, count, n_reduced = sizes[N_OUTPUTS], sizes[N_TIMES], sizes[N_REDUCED]
    room, prologue = sizes[ROOM], kernels[PROLOGUE]
    rates, start, finish = kernels[RATES], options[T0], options[T1]
    direction = 1.0 if finish >= start else -1.0
    relative_of_lane = shifted(absolute, n)
    for lane in range(begin, end):
        outputs_done, taken, rejected, blame = 0, 0, 0, 0
        energy, natural = 1.0, 0.0
        place = lane * n_reduced * EXTREMES
        code, now = FINISHED, start
        for i in range(n):
            work[STATE * w + i] = initial[lane * n + i]
        for leg in range(sizes[N_LEGS]):
            if code != FINISHED:
                continue
            row = leg * (LEG + sizes[N_SETTINGS])
            first, until = legs[row], legs[row + 1]
            if leg > 0 and user_events > 0:
                if jumped(
                    lane, leg, kernels, sizes, start, first, work, parameters, legs, columns, directions, terminal,
                    lane_parameters, c, table, g, counts, event_times,
                ) != 0:  # fmt: skip
                    code = TERMINAL
                    set_constants(
                        prologue, lane, leg - 1, sizes, parameters, legs, columns, lane_parameters, c
                    )
                    while outputs_done < count and (output_times[outputs_done] - now) * direction <= 0.0:
                        at_now = (lane * count + outputs_done) * outputs
                        call(kernels[OUTPUTS], output_times[outputs_done], work, STATE * w, c, values, at_now)
                        outputs_done += 1
                    continue
            else:
                set_constants(prologue, lane, leg, sizes, parameters, legs, columns, lane_parameters, c)
            for i in range(sizes[N_WORK]):
                if i < STATE * w or i >= STATE * w + n:
                    work[i] = 0.0
            for i in range(n):
                absolute[i] = tolerances[i]
                relative_of_lane[i] = relative[i]
            normalise(work, STATE * w, quaternions, nq)
            for k in range(INTEGERS):
                integers[k] = 0
            for k in range(REALS):
                reals[k] = 0.0
            if sizes[WORKS] != 0:
                if leg == 0:
                    call(kernels[ENERGY], first, work, STATE * w, c, spare, 0)
                    energy = greater(abs(spare[0]), abs(spare[1]))
                if 0.0 < energy < math.inf:
                    absolute[n - 1] *= energy
            integers[STOP_IF_STIFF], integers[REQUIRED] = sizes[STOP_STIFF_LANES], user_events
            reals[TIME] = reals[START] = first
            reals[UNTIL], reals[MAX_STEP], reals[METHOD_ORDER] = until, options[LONGEST], options[ORDER]
            reals[STEP] = legs[row + 2]
            if reals[STEP] != 0.0:
                integers[FIXED] = 1
            else:
                reals[STEP] = natural
            code = launch(rates, work, w, n, c, relative_of_lane, absolute, reals, integers)
            if m > 0 and code == RUNNING:
                code = look(kernels[WATCHED], first, work, w, m, c, table, last, integers)
                if leg == 0 and code == RUNNING:
                    begun_beyond(lane, sizes, first, table, counts, event_times)
            if n_reduced > 0 and leg == 0:
                call(kernels[REDUCED], first, work, STATE * w, c, spare, 0)
                for k in range(n_reduced):
                    for i in range(EXTREMES):
                        reduced[place + EXTREMES * k + i] = spare[k]
            elif n_reduced > 0:
                widen(kernels[REDUCED], first, work, STATE * w, c, spare, n_reduced, reduced, place)
            done = 0
            now, stride = first, 0.0
            remaining_steps, budget = sizes[LIMIT] - taken, sizes[BUDGET]
            if code == FINISHED:
                for k in range(count):
                    call(kernels[OUTPUTS], start, work, STATE * w, c, values, (lane * count + k) * outputs)
            while code == RUNNING:
                allowed = room if remaining_steps > room else remaining_steps
                if 0 < budget < allowed:
                    allowed = budget
                code = advance(
                    rates, n, c, work, w, quaternions, nq, relative_of_lane, absolute, reals, integers, allowed, times,
                    lengths, states, kernels[WATCHED], m, c, directions, terminal, last, table, g, zeros, event_log,
                    event_states,
                )  # fmt: skip
                done = integers[ACCEPTED]
                remaining_steps -= done
                now = reals[TIME]
                for k in range(done):
                    stride = greater(stride, abs(lengths[k]))
                if budget > 0 and done > 0:
                    budget -= done
                    if budget == 0:
                        finest = relative_of_lane[0]
                        for i in range(n):
                            finest = lesser(relative_of_lane[i], finest)
                        tighter = tightening(
                            sizes[BUDGET], now - first, until - now, options[ORDER], options[FINEST] / finest
                        )
                        for i in range(n):
                            relative_of_lane[i] *= tighter
                            absolute[i] *= tighter
                        reals[STEP] *= tighter ** (1.0 / options[ORDER])
                for k in range(integers[EVENTS]):
                    e = whole(event_log[LOG_SIZE * k + 1])
                    if e < user_events:
                        log_event(
                            lane * user_events + e, event_log[LOG_SIZE * k], start, first, sizes[N_LEGS], terminal[e],
                            counts, event_times,
                        )  # fmt: skip
                    if n_reduced > 0:
                        widen(
                            kernels[REDUCED], event_log[LOG_SIZE * k], event_states, k * n, c, spare, n_reduced,
                            reduced, place,
                        )  # fmt: skip
                if n_reduced > 0:
                    for k in range(1, done + 1):
                        widen(kernels[REDUCED], times[k], states, k * n, c, spare, n_reduced, reduced, place)
                reach = outputs_done
                while reach < count and (output_times[reach] - now) * direction <= 0.0:
                    if output_times[reach] == until and code == FINISHED and leg + 1 < sizes[N_LEGS]:
                        break  # the break point belongs to the next leg
                    reach += 1
                if reach > outputs_done:
                    for i in range(sizes[N_WORK]):
                        sampling_work[i] = 0.0
                    spare_integers[SAMPLED] = 0
                    sample(
                        rates, n, c, sampling_work, w, quaternions, nq, done, times, lengths, states, 0,
                        reach - outputs_done, shifted(output_times, outputs_done), sampled, relative_of_lane, absolute,
                        spare_integers,
                    )  # fmt: skip
                    for k in range(outputs_done, reach):
                        call(
                            kernels[OUTPUTS], output_times[k], sampled, (k - outputs_done) * n, c, values,
                            (lane * count + k) * outputs,
                        )  # fmt: skip
                    outputs_done = reach
                if sizes[N_DROPPED] > 0:
                    for k in range(done + 1):
                        if contradicted(
                            kernels[DROPPED], sizes[N_DROPPED], times[k], states, k * n, n, c, spare
                        ) != 0:  # fmt: skip
                            code = CONTRADICTED
                if code == RUNNING and remaining_steps <= 0:
                    code = TOO_MANY
            natural = stride if integers[TAKEN] > 1 else greater(natural, stride)
            taken += integers[TAKEN]
            rejected += integers[REJECTED]
            blame = integers[BLAME]
        for i in range(n):  # Python looks for the cause of a failure at the last state
            initial[lane * n + i] = work[STATE * w + i]
        statuses[OUTCOME_SIZE * lane] = code
        statuses[OUTCOME_SIZE * lane + 1] = taken
        statuses[OUTCOME_SIZE * lane + 2] = rejected
        statuses[OUTCOME_SIZE * lane + 3] = blame
        ends[lane] = now
