"""A lane: one run of a batch, with its outputs, extremes, events and legs.

A lane has its own parameters and initial state. It leaves the requested results only: outputs at given times, extremes,
first and last times of events, and its status. Its steps are not stored.

If signals have break points, the run goes in legs as a single run does (`driven`): constants, the memory of the
step-size control and the length of the first step are new in each leg. Extremes are looked for at the start and the end
of every step, and at the zeros of the rate of the quantity, which are watched as events are.
"""

from __future__ import annotations

import math

from ...native.instructions import EPS, Parts, Reals, greater
from ..ode.layout import FINISHED, RUNNING, TERMINAL
from ..ode.states import normalise
from ..ode.step_control import clear, launch, look
from .batch_memory import Batch, OneLane

part = Parts()


@part.inlined
def direction_of(batch: Batch) -> float:
    """Return 1, or -1 if the runs go backwards in time."""
    return 1.0 if batch.t1 >= batch.t0 else -1.0


# -- results -------------------------------------------------------------------------------------------


@part
def set_constants(batch: Batch, lane: OneLane, leg: int) -> None:
    """Set the constants of a lane in an interval between break points of its signals."""
    parameters, c = batch.lane_parameters, lane.run.c
    for k in range(batch.n_parameters):
        parameters[k] = batch.parameters[lane.number, k]
    for k in range(batch.n_settings):
        parameters[batch.columns[k]] = batch.settings[leg, k]
    batch.prologue(0.0, parameters, c, c)


@part
def write_outputs(batch: Batch, lane: OneLane, k: int, y: Reals) -> None:
    """Compute the outputs at the k-th output time and the state ``y``."""
    place = (lane.number * batch.n_times + k) * batch.n_outputs
    batch.outputs(batch.times[k], y, lane.run.c, batch.values[place:])


@part
def widen(batch: Batch, lane: OneLane, t: float, y: Reals) -> None:
    """Update the greatest, smallest and last value of each quantity with their values at one more state.

    A quantity without a value at a state keeps the value nan.
    """
    number = lane.number
    greatest, smallest, last = batch.greatest[number], batch.smallest[number], batch.last[number]
    batch.reductions(t, y, lane.run.c, batch.spare)
    for k in range(batch.n_reduced):
        x = batch.spare[k]
        if x > greatest[k] or x != x:
            greatest[k] = x
        if x < smallest[k] or x != x:
            smallest[k] = x
        last[k] = x


@part
def begin_extremes(batch: Batch, lane: OneLane) -> None:
    """Set all extremes of a lane to the values at its start."""
    number = lane.number
    batch.reductions(lane.run.t, lane.run.y, lane.run.c, batch.spare)
    for k in range(batch.n_reduced):
        batch.greatest[number, k] = batch.smallest[number, k] = batch.spare[k]
        batch.first[number, k] = batch.last[number, k] = batch.spare[k]


@part
def log_event(batch: Batch, lane: OneLane, e: int, t: float, again_from: float) -> None:
    """Log event ``e`` of a lane, unless the leg before ended with it; this leg began at ``again_from``."""
    row = lane.number * batch.n_events + e
    times = batch.event_times[row]
    again = batch.n_legs > 1 and batch.event_counts[row] > 0 and abs(times[1] - t) <= 1e-12
    if again and t - again_from <= 4.0 * EPS * greater(1.0, abs(again_from)):
        return
    if batch.event_counts[row] == 0:
        times[0] = t
    times[1] = t
    batch.event_counts[row] += 1


@part
def log_step_events(batch: Batch, lane: OneLane) -> None:
    """Log the events in the log of the run, and update the extremes with their states.

    A terminal event at the start of the run does not end a run and is not logged.
    """
    run, search = lane.run, lane.run.search
    for k in range(run.events):
        e, t = search.log_numbers[k], search.log_times[k]
        if e < batch.n_events and not (search.terminal[e] != 0 and t == batch.t0):
            log_event(batch, lane, e, t, run.start)
        if batch.n_reduced > 0:
            widen(batch, lane, t, search.log_states[k])


@part
def contradicted(batch: Batch, lane: OneLane, t: float, y: Reals) -> int:
    """Return 1 if a condition that was redundant at the start does not hold, or if, by the last output, other
    conditions should replace the active ones.
    """
    size, residuals = 0.0, batch.n_dropped
    for i in range(lane.run.n):
        size = greater(size, abs(y[i]))
    batch.dropped(t, y, lane.run.c, batch.spare)
    for j in range(residuals - 1):
        if abs(batch.spare[j]) > 1e-6 * (1.0 + size):
            return 1
    return 1 if batch.spare[residuals - 1] > 0.0 else 0


# -- legs ----------------------------------------------------------------------------------------------


@part
def begun_beyond(batch: Batch, lane: OneLane) -> None:
    """Log an event at the start for each limit that a run begins beyond."""
    for e in range(batch.n_events - batch.n_limits, batch.n_events):
        if lane.run.search.table[0, e] < 0.0:
            log_event(batch, lane, e, lane.run.t, lane.run.t)


@part
def jumped(batch: Batch, lane: OneLane, t: float) -> int:
    """Log an event for each function that jumps across zero at the beginning ``t`` of a leg; set the constants of the
    leg.

    Return 1 if one of these events is terminal.
    """
    run, search, result = lane.run, lane.run.search, 0
    before, after = search.table[0], search.g
    search.functions(t, run.y, run.c, before)
    set_constants(batch, lane, lane.leg)
    search.functions(t, run.y, run.c, after)
    for e in range(batch.n_events):
        if (before[e] < 0.0 < after[e]) or (after[e] < 0.0 < before[e]):
            sign = 1 if after[e] > 0.0 else -1
            if search.directions[e] == 0 or search.directions[e] == sign:
                log_event(batch, lane, e, t, t - 1.0)
                if search.terminal[e] != 0:
                    result = 1
    return result


@part
def begin_leg(batch: Batch, lane: OneLane) -> int:
    """Begin a leg of a lane at y.

    Return RUNNING, FINISHED if it has no length, TERMINAL if an event ends the run between the legs, or the status of a
    run that cannot begin.
    """
    run, leg = lane.run, lane.leg
    run.t = run.start = batch.leg_starts[leg]
    run.until, run.longest = batch.leg_ends[leg], batch.longest
    lane.longest = 0.0
    run.fixed = 1 if batch.leg_steps[leg] != 0.0 else 0
    run.h = batch.leg_steps[leg] if run.fixed != 0 else lane.stride
    run.taken = run.suspect = run.calm = run.stiffness = run.after_rejection = run.blame = 0
    run.evaluated = run.accepted = run.events = 0
    run.stop_if_stiff, run.required = batch.stop_if_stiff, batch.n_events
    if leg > 0 and batch.n_events > 0:
        if jumped(batch, lane, run.t) != 0:
            set_constants(batch, lane, leg - 1)
            k, direction = lane.outputs_done, direction_of(batch)
            while k < batch.n_times and (batch.times[k] - run.t) * direction <= 0.0:
                write_outputs(batch, lane, k, run.y)
                k += 1
            lane.outputs_done = k
            return TERMINAL
    else:
        set_constants(batch, lane, leg)
    clear(run)
    normalise(run, run.y)
    for i in range(run.n):
        run.absolute[i], run.relative[i] = batch.tolerances[i], batch.tolerances[i]
    if batch.works != 0:
        if leg == 0:
            batch.energy(run.t, run.y, run.c, batch.spare)
            lane.energy = greater(abs(batch.spare[0]), abs(batch.spare[1]))
        if 0.0 < lane.energy < math.inf:
            run.absolute[run.n - 1] *= lane.energy
    code = launch(run)
    if run.search.count > 0 and code == RUNNING:
        code = look(run)
        if leg == 0 and code == RUNNING:
            begun_beyond(batch, lane)
    if batch.n_reduced > 0:
        if leg == 0:
            begin_extremes(batch, lane)
        else:
            widen(batch, lane, run.t, run.y)
    if code == FINISHED:
        for k in range(batch.n_times):
            write_outputs(batch, lane, k, run.y)
    return code
