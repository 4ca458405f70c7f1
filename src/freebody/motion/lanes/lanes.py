"""The loop over lanes: many runs of one machine, one after another, without Python between them.

A lane is a run with its own parameters and initial state. It goes through the loop of `step_control` exactly as a
single run does: the same first step, the same control, the same states between steps, to the last bit. A lane leaves
the requested results only: outputs at given times, extremes, first and last times of events, and its status. Its steps
are not stored.

Outputs at given times are ends of shorter steps (`step_control.sample`), computed in separate memory so that they do
not disturb the run. If signals have break points, the run goes in legs as a single run does (`driven`): constants, the
memory of the step-size control and the length of the first step are new in each leg. Extremes are looked for at the
start and the end of every step, and at the zeros of the rate of the quantity, which are watched as events are.
"""

from __future__ import annotations

import math
from typing import Any

from ...native.instructions import EPS, Compiled, Parts, Reals, greater, lesser
from ...native.loop import module_named
from ..ode.layout import FINISHED, RUNNING, TERMINAL
from ..ode.loops import place
from ..ode.run import Run
from .lanes_layout import (
    BLAMED,
    CONTRADICTED,
    GREATEST,
    LAST,
    OUTCOME_SIZE,
    SMALLEST,
    STATUS,
    STEPS_REJECTED,
    STEPS_TAKEN,
    TOO_MANY,
    Batch,
    Lane,
)

__all__ = ["functions"]

part = Parts()

# Bound by `functions` to the compiled loop of a method.
normalise: Any = None
clear: Any = None
launch: Any = None
look: Any = None
advance: Any = None
sample: Any = None


def functions(method: str) -> dict[str, Compiled]:
    """Return the compiled loop over lanes of a method, with the method's own functions."""
    loop = module_named(place(method)).FUNCTIONS
    return {**loop, **part.bound({**globals(), **loop, "method": loop.method})}


# -- results -------------------------------------------------------------------------------------------


@part
def set_constants(batch: Batch, lane: Lane, leg: int) -> None:
    """Set the constants of a lane in an interval between break points of its signals."""
    parameters, c = batch.lane_parameters, lane.run.c
    for k in range(batch.n_parameters):
        parameters[k] = batch.parameters[lane.number, k]
    for k in range(batch.n_settings):
        parameters[batch.columns[k]] = batch.settings[leg, k]
    batch.prologue(0.0, parameters, c, c)


@part
def write_outputs(batch: Batch, lane: Lane, k: int, y: Reals) -> None:
    """Compute the outputs at the k-th output time and the state ``y``."""
    place = (lane.number * batch.n_times + k) * batch.n_outputs
    batch.outputs(batch.times[k], y, lane.run.c, batch.values[place:])


@part
def widen(batch: Batch, lane: Lane, t: float, y: Reals) -> None:
    """Update the greatest, smallest and last value of each quantity with their values at one more state.

    A quantity without a value at a state keeps the value nan.
    """
    batch.reductions(t, y, lane.run.c, batch.spare)
    for k in range(batch.n_reduced):
        x, row = batch.spare[k], batch.reduced[lane.number * batch.n_reduced + k]
        if x > row[GREATEST] or x != x:
            row[GREATEST] = x
        if x < row[SMALLEST] or x != x:
            row[SMALLEST] = x
        row[LAST] = x


@part
def begin_extremes(batch: Batch, lane: Lane) -> None:
    """Set all extremes of a lane to the values at its start."""
    batch.reductions(lane.run.t, lane.run.y, lane.run.c, batch.spare)
    for k in range(batch.n_reduced):
        row = batch.reduced[lane.number * batch.n_reduced + k]
        for i in range(4):
            row[i] = batch.spare[k]


@part
def log_event(batch: Batch, lane: Lane, e: int, t: float, again_from: float) -> None:
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
def log_step_events(batch: Batch, lane: Lane) -> None:
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
def contradicted(batch: Batch, lane: Lane, t: float, y: Reals) -> int:
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


@part
def leave(batch: Batch, number: int, code: int, steps: int, rejected: int, blame: int, t: float) -> None:
    """Store how a run has ended."""
    outcome = batch.outcomes[OUTCOME_SIZE * number :]
    outcome[STATUS], outcome[STEPS_TAKEN], outcome[STEPS_REJECTED], outcome[BLAMED] = (
        code,
        steps,
        rejected,
        blame,
    )
    batch.ends[number] = t


# -- legs ----------------------------------------------------------------------------------------------


@part
def tightening(batch: Batch, run: Run, steps: int, finest: float) -> float:
    """Return the factor on the tolerances of a run that has used its budget of steps (`integrate`).

    ``finest`` is the smallest relative tolerance.
    """
    steps_ahead = steps * (run.until - run.t) / (run.t - run.start)
    factor = 1.0
    if steps_ahead > steps:
        factor = (steps / steps_ahead) ** (batch.order / (batch.order - 1.0))
    return greater(factor, lesser(1.0, batch.finest / finest))


@part
def begun_beyond(batch: Batch, lane: Lane) -> None:
    """Log an event at the start for each limit that a run begins beyond."""
    for e in range(batch.n_events - batch.n_limits, batch.n_events):
        if lane.run.search.table[0, e] < 0.0:
            log_event(batch, lane, e, lane.run.t, lane.run.t)


@part
def jumped(batch: Batch, lane: Lane, t: float) -> int:
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
def enter(batch: Batch, lane: Lane, number: int) -> None:
    """Put a run into a lane."""
    lane.number, lane.leg, lane.outputs_done, lane.steps = number, 0, 0, 0
    lane.energy, lane.stride = 1.0, 0.0
    for i in range(lane.run.n):
        lane.run.y[i] = batch.initial[number, i]


@part
def begin_leg(batch: Batch, lane: Lane) -> int:
    """Begin a leg of a lane at y.

    Return RUNNING, FINISHED if it has no length, TERMINAL if an event ends the run between the legs, or the status of a
    run that cannot begin.
    """
    run, leg = lane.run, lane.leg
    run.t = run.start = batch.leg_starts[leg]
    run.until, run.longest = batch.leg_ends[leg], batch.longest
    run.fixed = 1 if batch.leg_steps[leg] != 0.0 else 0
    run.h = batch.leg_steps[leg] if run.fixed != 0 else lane.stride
    run.taken = run.rejected = run.suspect = run.calm = run.stiffness = run.after_rejection = run.blame = 0
    run.evaluated = run.accepted = run.events = 0
    run.stop_if_stiff, run.required = batch.stop_if_stiff, batch.n_events
    if leg > 0 and batch.n_events > 0:
        if jumped(batch, lane, run.t) != 0:
            set_constants(batch, lane, leg - 1)
            k, direction = lane.outputs_done, 1.0 if batch.t1 >= batch.t0 else -1.0
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


@part
def sample_outputs(batch: Batch, lane: Lane, sampler: Run, code: int) -> None:
    """Compute the outputs at the output times in the steps of the last piece of a run."""
    run, done, n = lane.run, lane.outputs_done, lane.run.n
    direction = 1.0 if batch.t1 >= batch.t0 else -1.0
    reach = done
    while reach < batch.n_times and (batch.times[reach] - run.t) * direction <= 0.0:
        if batch.times[reach] == run.until and code == FINISHED and lane.leg + 1 < batch.n_legs:
            break  # the break point belongs to the next leg
        reach += 1
    if reach > done:
        clear(sampler)
        sampler.sampled = 0
        sample(sampler, run.accepted, 0, reach - done, batch.times[done:], batch.sampled)
        for k in range(done, reach):
            write_outputs(batch, lane, k, batch.sampled[(k - done) * n :])
        lane.outputs_done = reach


@part
def run_leg(batch: Batch, lane: Lane, sampler: Run) -> int:
    """Compute a leg of a lane that has begun, and return its status."""
    run, stride, code = lane.run, 0.0, RUNNING
    remaining_steps, budget = batch.limit - lane.steps, batch.budget
    while code == RUNNING:
        run.room = batch.room if remaining_steps > batch.room else remaining_steps
        if 0 < budget < run.room:
            run.room = budget
        code = advance(run)
        done = run.accepted
        remaining_steps -= done
        for k in range(done):
            stride = greater(stride, abs(run.lengths[k]))
        if budget > 0 and done > 0:
            budget -= done
            if budget == 0:
                finest = run.relative[0]
                for i in range(run.n):
                    finest = lesser(run.relative[i], finest)
                tighter = tightening(batch, run, batch.budget, finest)
                for i in range(run.n):
                    run.relative[i] *= tighter
                    run.absolute[i] *= tighter
                run.h *= tighter ** (1.0 / batch.order)
        log_step_events(batch, lane)
        if batch.n_reduced > 0:
            for k in range(1, done + 1):
                widen(batch, lane, run.times[k], run.states[k])
        sample_outputs(batch, lane, sampler, code)
        if batch.n_dropped > 0:
            for k in range(done + 1):
                if contradicted(batch, lane, run.times[k], run.states[k]) != 0:
                    code = CONTRADICTED
        if code == RUNNING and remaining_steps <= 0:
            code = TOO_MANY
    lane.stride = stride if run.taken > 1 else greater(lane.stride, stride)
    return code


@part
def lanes(begin: int, end: int, batch: Batch, lane: Lane, sampler: Run) -> None:
    """Compute the runs ``begin`` to ``end`` - 1."""
    run = lane.run
    for number in range(begin, end):
        rejected, blame, code = 0, 0, FINISHED
        enter(batch, lane, number)
        run.t = batch.t0
        while code == FINISHED and lane.leg < batch.n_legs:
            code = begin_leg(batch, lane)
            if code == TERMINAL:
                break
            if code == RUNNING:
                code = run_leg(batch, lane, sampler)
            lane.steps += run.taken
            rejected += run.rejected
            blame = run.blame
            lane.leg += 1
        for i in range(run.n):  # Python looks for the cause of a failure at the last state
            batch.initial[number, i] = run.y[i]
        leave(batch, number, code, lane.steps, rejected, blame, run.t)
