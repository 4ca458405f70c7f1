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
from ...native.instructions import Compiled, Parts, Truth, Whole, greater, lesser, where
from ...native.instructions import lanes as width
from ..ode.layout import FINISHED, RUNNING, STIFF
from ..ode.loops import compiled_functions
from ..ode.run import OneRun, Run
from ..ode.states import are_finite, begin_again, expect_end, in_parts, state_in_step
from ..ode.step_control import (
    change_length,
    choose_length,
    clear,
    error_of_step,
    follow_events,
    is_stiff,
    pass_step,
)
from . import lane as one_lane
from .batch_memory import CONTRADICTED, TOO_MANY, Batch, Lane, OneLane
from .lane import begin_leg, contradicted, direction_of, log_step_events, widen, write_outputs

__all__ = ["functions"]

part = Parts()

method: Any = None
"""The method, in the functions below."""


def functions(method: str) -> dict[str, Compiled]:
    """Return the compiled loop over lanes of a method, with the method's own functions."""
    loop = compiled_functions(method)
    space = {**vars(one_lane), **globals(), **loop, "method": loop.method}
    return {**loop, **one_lane.part.bound(space), **part.bound(space)}


# -- a lane beside the others, and lifted out ----------------------------------------------------------


@part.inlined
def alone(wide: Lane, own: OneLane, lane: int) -> OneLane:
    """Return a lane in the memory of one run."""
    return wide if width(wide.energy) == 1 else own[lane]


@part
def settle(batch: Batch, wide: Lane, lane: int, one: OneLane) -> None:
    """Copy a leg that begins, from the memory of one run to its place beside the others."""
    run, begun = wide.run, one.run
    run.t[lane], run.h[lane], run.start[lane], run.until[lane] = begun.t, begun.h, begun.start, begun.until
    run.longest[lane], run.old_error[lane], run.fixed[lane] = begun.longest, begun.old_error, begun.fixed
    run.allowed[lane], run.trend[lane] = begun.allowed, begun.trend
    run.after_rejection[lane] = run.suspect[lane] = run.calm[lane] = run.blame[lane] = 0
    wide.longest[lane] = 0.0
    for j in range(batch.n_constants):
        run.c[j][lane] = begun.c[j]
    for i in range(run.n):
        run.y[i][lane], run.k[0, i][lane] = begun.y[i], begun.k[0, i]
        run.absolute[i][lane], run.relative[i][lane] = begun.absolute[i], begun.relative[i]
    if batch.near_limits != 0:
        for e in range(batch.n_watched):
            run.search.table[0, e][lane], run.search.table[1, e][lane] = begun.search.table[0, e], math.inf


@part
def lift(batch: Batch, wide: Lane, lane: int, one: OneLane) -> None:
    """Copy the step of a lane into the memory of one run."""
    run, step = wide.run, one.run
    step.t, step.h, step.after = run.t[lane], run.h[lane], run.after[lane]
    step.reached = step.base = -1.0
    for i in range(run.n):
        step.y[i], step.y_new[i], step.end[i] = run.y[i][lane], run.y_new[i][lane], run.end[i][lane]
    method.lift(run, lane, step)
    step.search.has_slopes = 0
    if batch.near_limits != 0:
        for e in range(batch.n_watched):
            step.search.table[0, e] = run.search.table[0, e][lane]
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
    """Copy a step into the separate memory in which states inside it are computed."""
    clear(sampler)
    sampler.h = run.h
    begin_again(sampler, run.t, run.y)
    if method.expect is not None:
        expect_end(sampler, run.after, run.end)


@part
def output_in_step(batch: Batch, one: OneLane, sampler: OneRun, after: float, reaches: int) -> None:
    """Compute the outputs at the output times of a step, which ends at ``after``."""
    run, done, direction = one.run, one.outputs_done, direction_of(batch)
    while done < batch.n_times and (batch.times[done] - after) * direction <= 0.0:
        x = batch.times[done]
        if x == run.until and reaches != 0 and one.leg + 1 < batch.n_legs:
            break  # the break point belongs to the next leg
        y = run.y if x == run.t else run.end
        if x != run.t and x != after:
            state_in_step(sampler, (x - run.t) / run.h)
            if method.expect is not None and not are_finite(sampler.point, run.n):
                in_parts(sampler, run.t, run.y, x - run.t)
                begin_sampling(sampler, run)
            y = sampler.point
        write_outputs(batch, one, done, y)
        done += 1
    one.outputs_done = done


@part
def next_output(batch: Batch, one: OneLane) -> float:
    """Return the next output time of a lane."""
    return (
        batch.times[one.outputs_done] if one.outputs_done < batch.n_times else direction_of(batch) * math.inf
    )


@part
def look_into(batch: Batch, wide: Lane, own: OneLane, lane: int, seeks: int) -> int:
    """Find events, extremes and outputs in the good step of a lane. Return RUNNING, TERMINAL, UNDEFINED,
    UNRESOLVED or CONTRADICTED.
    """
    run, one, code = wide.run, alone(wide, own, lane), RUNNING
    if width(run.t) > 1:
        lift(batch, wide, lane, one)
    step = one.run
    if seeks != 0:
        if batch.n_watched > 0:
            step.search.seen = 1.0
            begins = True
            while begins or step.search.seen < 1.0:
                begins, step.events = False, 0
                code = follow_events(step)
                log_step_events(batch, one)
        if batch.n_reduced > 0:
            widen(batch, one, step.after, step.end)
    if code != RUNNING:
        run.last[lane], run.after[lane], run.blame[lane] = 0, step.after, step.blame
    if (wide.next_output[lane] - step.after) * direction_of(batch) <= 0.0:
        if width(run.t) == 1:
            begin_sampling(own.run, step)
        output_in_step(batch, one, own[lane].run, step.after, run.last[lane])
        wide.next_output[lane] = next_output(batch, one)
    if batch.n_dropped > 0 and contradicted(batch, one, step.after, step.end) != 0:
        code, run.last[lane] = CONTRADICTED, 0
    return code


# -- runs, one after the other -------------------------------------------------------------------------


@part
def enter_leg(batch: Batch, wide: Lane, own: OneLane, lane: int) -> int:
    """Begin the next leg of a run, with the state in the memory of one run; return its status."""
    one = alone(wide, own, lane)
    code = begin_leg(batch, one)
    wide.run.taken[lane], wide.run.blame[lane] = 0, one.run.blame
    if code == RUNNING and batch.n_dropped > 0 and contradicted(batch, one, one.run.t, one.run.y) != 0:
        code = CONTRADICTED
    if code == RUNNING and width(wide.energy) > 1:
        settle(batch, wide, lane, one)
    wide.next_output[lane] = next_output(batch, one)
    return code


@part
def enter_lane(batch: Batch, wide: Lane, own: OneLane, lane: int, number: int) -> int:
    """Put a run into a lane; return its status."""
    one, run = alone(wide, own, lane), wide.run
    one.number, one.leg, one.outputs_done, one.steps, one.run.rejected = number, 0, 0, 0, 0
    one.energy, one.stride = 1.0, 0.0
    for i in range(run.n):
        one.run.y[i] = batch.initial[number, i]
    wide.number[lane], wide.steps[lane], run.rejected[lane] = number, 0, 0
    code = enter_leg(batch, wide, own, lane)
    if code != RUNNING:
        run.t[lane] = one.run.t
        for i in range(run.n):
            run.y[i][lane] = one.run.y[i]
        end_lane(batch, wide, lane, code)
    return code


@part
def follow_leg(batch: Batch, wide: Lane, own: OneLane, lane: int) -> int:
    """Return FINISHED at the end of the last leg, else begin the next leg."""
    run, one, longest = wide.run, alone(wide, own, lane), wide.longest[lane]
    if one.leg + 1 == batch.n_legs:
        return FINISHED
    one.stride = longest if run.taken[lane] > 1 else greater(one.stride, longest)
    wide.steps[lane] += run.taken[lane]
    one.leg += 1
    for i in range(run.n):
        one.run.y[i] = run.y[i][lane]
    return enter_leg(batch, wide, own, lane)


@part
def end_lane(batch: Batch, wide: Lane, lane: int, code: int) -> None:
    """Take a run out of its lane and store how it ended. Python looks for the cause of a failure at the last state."""
    run, number = wide.run, wide.number[lane]
    for i in range(run.n):
        batch.initial[number, i] = run.y[i][lane]
    batch.status[number], batch.blame[number], batch.ends[number] = code, run.blame[lane], run.t[lane]
    batch.steps[number], batch.rejected[number] = wide.steps[lane] + run.taken[lane], run.rejected[lane]
    wide.number[lane] = -1
    run.h[lane], run.until[lane] = 0.0, run.t[lane]


@part
def tighten(batch: Batch, run: Run, lane: int) -> None:
    """Tighten the tolerances of a run that has used its budget of steps (`Integration`)."""
    finest, factor = run.relative[0][lane], 1.0
    for i in range(run.n):
        finest = lesser(run.relative[i][lane], finest)
    ahead = batch.budget * (run.until[lane] - run.t[lane]) / (run.t[lane] - run.start[lane])
    if ahead > batch.budget:
        factor = (batch.budget / ahead) ** (batch.order / (batch.order - 1.0))
    factor = greater(factor, lesser(1.0, batch.finest / finest))
    for i in range(run.n):
        run.relative[i][lane] *= factor
        run.absolute[i][lane] *= factor
    run.h[lane] *= factor ** (1.0 / batch.order)


@part
def take(batch: Batch, wide: Lane, own: OneLane, good: Truth) -> Whole:
    """Take the good steps; return for each lane RUNNING, STIFF, TERMINAL, UNDEFINED, UNRESOLVED or
    CONTRADICTED.
    """
    run, direction = wide.run, direction_of(batch)
    status: Whole = RUNNING
    run.taken = where(good, run.taken + 1, run.taken)
    wide.longest = where(good, greater(wide.longest, abs(run.h)), wide.longest)
    if method.hold is not None:
        method.hold(run)
    if (method.last_stage != 0 or method.limited is not None) and batch.stop_if_stiff != 0:
        status = where(is_stiff(run, good), STIFF, RUNNING)
    seeks: Truth = good and batch.n_watched + batch.n_reduced > 0
    if batch.near_limits != 0:
        seeks = near_limit(run, good)
    looks = good and ((wide.next_output - run.after) * direction <= 0.0 or batch.n_dropped > 0)
    for lane in each(seeks or looks):
        found = look_into(batch, wide, own, lane, 1 if seeks[lane] else 0)
        if found != RUNNING:
            status[lane] = found
    if batch.near_limits != 0:
        pass_limits(run, good)
    pass_step(run, good)
    return status


@part
def lanes(begin: int, end: int, batch: Batch, wide: Lane, own: OneLane) -> None:
    """Compute the runs ``begin`` to ``end`` - 1."""
    run, following = wide.run, begin
    fresh: Truth = False
    wide.number = -1
    run.t = run.until = run.h = 0.0
    while following < end or any(wide.number >= 0):
        for lane in each(wide.number < 0):
            while following < end and wide.number[lane] < 0:
                enter_lane(batch, wide, own, lane, following)
                fresh[lane] = True
                following += 1
        if any(fresh) and method.prepare is not None:
            method.prepare(run, fresh)
        fresh = False
        code = choose_length(run)
        for lane in each(wide.number >= 0 and code != RUNNING):
            end_lane(batch, wide, lane, code[lane])
        if any(wide.number >= 0):
            error = error_of_step(run)
            good: Truth = wide.number >= 0 and error <= 1.0
            bad: Truth = wide.number >= 0 and not error <= 1.0
            status: Whole = RUNNING
            if any(good):
                status = take(batch, wide, own, good)
            if method.length is None or any(bad):
                status = where(bad, change_length(run, error, good), status)
            for lane in each(good and run.last != 0):
                status[lane] = follow_leg(batch, wide, own, lane)
                fresh[lane] = True
            full = wide.steps + run.taken >= batch.limit
            status = where(good and status == RUNNING and full, TOO_MANY, status)
            if batch.budget > 0:
                for lane in each(good and status == RUNNING and run.taken == batch.budget):
                    tighten(batch, run, lane)
            for lane in each(wide.number >= 0 and status != RUNNING):
                end_lane(batch, wide, lane, status[lane])
