"""The loop over lanes: many runs of one machine, one after another or eight side by side, without Python between them.

Each lane has its own time, step, error and control, which are those of a single run (`step_control`): the same first
step, the same control, the same states between steps, to the last bit. Eight lanes attempt their steps together. A lane
whose step is rejected tries again while the others go on. A lane that has ended makes room for the next run.

What is special is a step that is looked into, for events, extremes or outputs at given times: searches go their own
ways. It is lifted out of the lanes, into the memory of one run. There the functions of a single run look into it. One
lane alone is in the memory of one run already. There, outputs are computed in separate memory, since a method may
remember its last attempts (`states.sample`).
"""

from __future__ import annotations

import math
from typing import Any

from ...native.functions import each
from ...native.instructions import Compiled, Parts, Real, Truth, Whole, greater, lesser, where
from ...native.instructions import lanes as width
from ...native.loop import module_named
from ..ode.layout import FINISHED, RUNNING, STIFF
from ..ode.loops import place
from ..ode.run import OneRun, Run
from . import lane as one_lane
from .batch_memory import CONTRADICTED, TOO_MANY, Batch, Lane, OneLane

__all__ = ["functions"]

part = Parts()

method: Any = None
"""The method, in the functions below. The others are those of its compiled loop, and of one lane."""
clear: Any = None
set_allowed: Any = None
choose_length: Any = None
error_of_step: Any = None
is_stiff: Any = None
follow_events: Any = None
pass_step: Any = None
change_length: Any = None
blamed: Any = None
state_in_step: Any = None
enter: Any = None
begin_leg: Any = None
contradicted: Any = None
log_step_events: Any = None
widen: Any = None
write_outputs: Any = None
leave: Any = None


def functions(method: str) -> dict[str, Compiled]:
    """Return the compiled loop over lanes of a method, with the method's own functions."""
    loop = module_named(place(method)).FUNCTIONS
    space = {**vars(one_lane), **globals(), **loop, "method": loop.method}
    return {**loop, **one_lane.part.bound(space), **part.bound(space)}


# -- a lane beside the others, and lifted out ----------------------------------------------------------


@part.inlined
def alone(lane: Lane, own: OneLane, l: int) -> OneLane:
    """Return a lane in the memory of one run."""
    return lane if width(lane.energy) == 1 else own[l]


@part
def settle(batch: Batch, lane: Lane, l: int, one: OneLane) -> None:
    """Copy a leg that begins, from the memory of one run to its place beside the others."""
    run, begun = lane.run, one.run
    run.t[l], run.h[l], run.start[l], run.until[l] = begun.t, begun.h, begun.start, begun.until
    run.longest[l], run.old_error[l], run.fixed[l] = begun.longest, begun.old_error, begun.fixed
    run.after_rejection[l] = run.suspect[l] = run.calm[l] = run.blame[l] = 0
    lane.longest[l] = 0.0
    for j in range(batch.n_constants):
        run.c[j][l] = begun.c[j]
    for i in range(run.n):
        run.y[i][l], run.k[0, i][l] = begun.y[i], begun.k[0, i]
        run.absolute[i][l], run.relative[i][l] = begun.absolute[i], begun.relative[i]
    if batch.near_limits != 0:
        for e in range(batch.n_watched):
            run.search.table[0, e][l], run.search.table[1, e][l] = begun.search.table[0, e], math.inf


@part
def lift(batch: Batch, lane: Lane, l: int, one: OneLane) -> None:
    """Copy the step of a lane into the memory of one run."""
    run, step = lane.run, one.run
    step.t, step.h, step.after = run.t[l], run.h[l], run.after[l]
    for i in range(run.n):
        step.y[i], step.y_new[i], step.end[i] = run.y[i][l], run.y_new[i][l], run.end[i][l]
    method.lift(run, l, step)
    if batch.near_limits != 0:
        for e in range(batch.n_watched):
            step.search.table[0, e] = run.search.table[0, e][l]
            if step.search.table[0, e] > 0.0:
                step.search.signs[e] = 1


@part
def near_limit(run: Run, good: Truth) -> Truth:
    """Return whether a lane may pass a limit in its good step.

    It may if a value at one of its ends is at most twice its change in this step or in the one before.
    """
    search = run.search
    search.functions(run.after, run.end, run.c, search.g)
    far: Truth = True
    for e in range(search.count):
        now, before, last = search.g[e], search.table[0, e], search.table[1, e]
        change = abs(now - before)
        far = far and lesser(now, before) > 2.0 * greater(change, last)
        search.table[1, e] = where(good, change, last)
    return good and not far


@part
def pass_limits(run: Run, good: Truth) -> None:
    """Make the values of limits at the end of a good step those at the start of the next."""
    search = run.search
    for e in range(search.count):
        search.table[0, e] = where(good, search.g[e], search.table[0, e])


# -- a step that is looked into ------------------------------------------------------------------------


@part
def begin_sampling(sampler: OneRun, run: OneRun) -> None:
    """Copy the start of a step into the separate memory in which states inside it are computed."""
    clear(sampler)
    sampler.t, sampler.h = run.t, run.h
    sampler.y[:] = run.y
    sampler.rates(sampler.t, sampler.y, sampler.c, sampler.k[0])
    if method.prepare is not None:
        method.prepare(sampler, True)


@part
def output_in_step(batch: Batch, one: OneLane, sampler: OneRun, after: float, reaches: int) -> None:
    """Compute the outputs at the output times of a step, which ends at ``after``."""
    run, done = one.run, one.outputs_done
    direction = 1.0 if batch.t1 >= batch.t0 else -1.0
    while done < batch.n_times and (batch.times[done] - after) * direction <= 0.0:
        x = batch.times[done]
        if x == run.until and reaches != 0 and one.leg + 1 < batch.n_legs:
            break  # the break point belongs to the next leg
        y = run.y if x == run.t else run.end
        if x != run.t and x != after:
            state_in_step(sampler, (x - run.t) / run.h)
            y = sampler.point
        write_outputs(batch, one, done, y)
        done += 1
    one.outputs_done = done


@part
def next_output(batch: Batch, one: OneLane) -> float:
    """Return the next output time of a lane."""
    direction = 1.0 if batch.t1 >= batch.t0 else -1.0
    return batch.times[one.outputs_done] if one.outputs_done < batch.n_times else direction * math.inf


@part
def look_into(batch: Batch, lane: Lane, own: OneLane, l: int, seeks: int) -> int:
    """Find events, extremes and outputs in the good step of a lane. Return RUNNING, TERMINAL, UNDEFINED or
    CONTRADICTED.
    """
    run, one, code = lane.run, alone(lane, own, l), RUNNING
    if width(run.t) > 1:
        lift(batch, lane, l, one)
    step = one.run
    if seeks != 0:
        if batch.n_watched > 0:
            step.events = 0
            code = follow_events(step)
            log_step_events(batch, one)
        if batch.n_reduced > 0:
            widen(batch, one, step.after, step.end)
    if code != RUNNING:
        run.last[l], run.after[l], run.blame[l] = 0, step.after, step.blame
    if (lane.next_output[l] - step.after) * (1.0 if batch.t1 >= batch.t0 else -1.0) <= 0.0:
        if width(run.t) == 1:
            begin_sampling(own.run, step)
        output_in_step(batch, one, own[l].run, step.after, run.last[l])
        lane.next_output[l] = next_output(batch, one)
    if batch.n_dropped > 0 and contradicted(batch, one, step.after, step.end) != 0:
        code, run.last[l] = CONTRADICTED, 0
    return code


# -- runs, one after the other -------------------------------------------------------------------------


@part
def enter_leg(batch: Batch, lane: Lane, own: OneLane, l: int) -> int:
    """Begin the next leg of a run, with the state in the memory of one run; return its status."""
    one = alone(lane, own, l)
    code = begin_leg(batch, one)
    lane.run.taken[l], lane.run.blame[l] = 0, one.run.blame
    if code == RUNNING and batch.n_dropped > 0 and contradicted(batch, one, one.run.t, one.run.y) != 0:
        code = CONTRADICTED
    if code == RUNNING and width(lane.energy) > 1:
        settle(batch, lane, l, one)
    lane.next_output[l] = next_output(batch, one)
    return code


@part
def enter_lane(batch: Batch, lane: Lane, own: OneLane, l: int, number: int) -> int:
    """Put a run into a lane; return its status."""
    one, run = alone(lane, own, l), lane.run
    enter(batch, one, number)
    lane.number[l], lane.steps[l], run.rejected[l] = number, 0, 0
    code = enter_leg(batch, lane, own, l)
    if code != RUNNING:
        run.t[l] = one.run.t
        for i in range(run.n):
            run.y[i][l] = one.run.y[i]
        end_lane(batch, lane, l, code)
    return code


@part
def follow_leg(batch: Batch, lane: Lane, own: OneLane, l: int) -> int:
    """Return FINISHED at the end of the last leg, else begin the next leg."""
    run, one, longest = lane.run, alone(lane, own, l), lane.longest[l]
    if one.leg + 1 == batch.n_legs:
        return FINISHED
    one.stride = longest if run.taken[l] > 1 else greater(one.stride, longest)
    lane.steps[l] += run.taken[l]
    one.leg += 1
    for i in range(run.n):
        one.run.y[i] = run.y[i][l]
    return enter_leg(batch, lane, own, l)


@part
def end_lane(batch: Batch, lane: Lane, l: int, code: int) -> None:
    """Take a run out of its lane and store how it ended. Python looks for the cause of a failure at the last state."""
    run, number = lane.run, lane.number[l]
    for i in range(run.n):
        batch.initial[number, i] = run.y[i][l]
    leave(batch, number, code, lane.steps[l] + run.taken[l], run.rejected[l], run.blame[l], run.t[l])
    lane.number[l] = -1
    run.h[l], run.until[l] = 0.0, run.t[l]


@part
def tighten(batch: Batch, run: Run, l: int) -> None:
    """Tighten the tolerances of a run that has used its budget of steps (`integrate`)."""
    finest, factor = run.relative[0][l], 1.0
    for i in range(run.n):
        finest = lesser(run.relative[i][l], finest)
    ahead = batch.budget * (run.until[l] - run.t[l]) / (run.t[l] - run.start[l])
    if ahead > batch.budget:
        factor = (batch.budget / ahead) ** (batch.order / (batch.order - 1.0))
    factor = greater(factor, lesser(1.0, batch.finest / finest))
    for i in range(run.n):
        run.relative[i][l] *= factor
        run.absolute[i][l] *= factor
    run.h[l] *= factor ** (1.0 / batch.order)
    set_allowed(run)


@part
def lanes(begin: int, end: int, batch: Batch, lane: Lane, own: OneLane) -> None:
    """Compute the runs ``begin`` to ``end`` - 1."""
    run, following = lane.run, begin
    direction = 1.0 if batch.t1 >= batch.t0 else -1.0
    fresh: Truth = False
    lane.number = -1
    run.t = run.until = run.h = 0.0
    while following < end or any(lane.number >= 0):
        for l in each(lane.number < 0):
            while following < end and lane.number[l] < 0:
                enter_lane(batch, lane, own, l, following)
                fresh[l] = True
                following += 1
        if any(fresh):
            set_allowed(run)
            if method.prepare is not None:
                method.prepare(run, fresh)
            fresh = False
        code = choose_length(run, direction)
        for l in each(lane.number >= 0 and code != RUNNING):
            end_lane(batch, lane, l, code[l])
        if any(lane.number >= 0):
            error = error_of_step(run)
            good, bad = lane.number >= 0 and error <= 1.0, lane.number >= 0 and not error <= 1.0
            status: Whole = RUNNING
            run.taken = where(good, run.taken + 1, run.taken)
            lane.longest = where(good, greater(lane.longest, abs(run.h)), lane.longest)
            if any(good):
                if method.hold is not None:
                    method.hold(run)
                if (method.last_stage != 0 or method.limited is not None) and batch.stop_if_stiff != 0:
                    status = where(is_stiff(run, good), STIFF, RUNNING)
                seeks = good and batch.n_watched + batch.n_reduced > 0
                if batch.near_limits != 0:
                    seeks = near_limit(run, good)
                looks = good and ((lane.next_output - run.after) * direction <= 0.0 or batch.n_dropped > 0)
                for l in each(seeks or looks):
                    found = look_into(batch, lane, own, l, 1 if seeks[l] else 0)
                    if found != RUNNING:
                        status[l] = found
                if batch.near_limits != 0:
                    pass_limits(run, good)
                pass_step(run, good)
            if method.length is None or any(bad):
                if method.length is None:
                    for l in each(bad and error != error):
                        run.blame[l] = blamed(run, l)
                status = where(bad, change_length(run, error, good), status)
            for l in each(good and run.last != 0):
                status[l] = follow_leg(batch, lane, own, l)
                fresh[l] = True
            status = where(good and status == RUNNING and lane.steps + run.taken >= batch.limit, TOO_MANY, status)
            if batch.budget > 0:
                for l in each(good and status == RUNNING and run.taken == batch.budget):
                    tighten(batch, run, l)
            for l in each(lane.number >= 0 and status != RUNNING):
                end_lane(batch, lane, l, status[l])
