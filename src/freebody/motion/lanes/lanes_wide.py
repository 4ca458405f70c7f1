"""The loop over eight lanes at once, with one run in each of the eight numbers of a vector register.

Each lane has its own time, step, error and control, exactly as in `step_control.advance`. The eight lanes attempt their
steps together. A rejected lane tries again while the others go on. A lane that has ended makes room for the next run. A
method for eight lanes (`dop853_wide`, `taylor_wide`) treats each lane separately, so that a lane does not depend on its
neighbours. `dop853_wide` does the operations of `dop853` in the same order, so that a lane equals a single run to the
last bit.

If a lane has to be examined inside its step, for events, extremes or states at output times, the step is copied from
the rows of eight lanes into the memory of one run, and `step_control` continues there.
"""

from __future__ import annotations

import math
from typing import Any

from ...native.instructions import EPS, Compiled, Parts, Reals, greater, lesser
from ...native.loop import module_named, sibling
from ..ode.layout import (
    COLLAPSED,
    DIVERGED,
    FINISHED,
    MANY,
    NOT_FINITE,
    RUNNING,
    STIFF,
    TERMINAL,
    UNDEFINED,
)
from ..ode.loops import place
from ..ode.step_control import TINY
from .instructions_wide import all_finite, blend, call_wide, moved, settled, taken, unit_at
from .lanes import functions as of_one
from .lanes_layout import (
    AFTER_REJECTION,
    AFTERS,
    ALLOWED,
    CALM,
    CHANGES,
    CONTRADICTED,
    EARLIER_STEPS,
    EASY,
    END,
    ENDS,
    ERROR5,
    ERRORS,
    LEG_END,
    LENGTHS,
    LIMITED,
    MOMENTS,
    NEXT_OUTPUT,
    OLD_ERRORS,
    RAW,
    REJECTED,
    RUN,
    SELECTED,
    STATE,
    STEPS,
    STRIDE,
    SUSPECT,
    TAKEN,
    TIMES,
    TOO_MANY,
    WIDE_PLACES,
    Batch,
    EightLanes,
    Lane,
)

part = Parts()

# Bound by `functions` to functions of the loop over one lane and of the method for eight lanes.
method: Any = None
enter: Any = None
begin_leg: Any = None
leave: Any = None
find_events: Any = None
log_events: Any = None
log_step_events: Any = None
state_in_step: Any = None
write_outputs: Any = None
lengthening: Any = None
shortening: Any = None
tightening: Any = None
contradicted: Any = None
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
"""(lane, wide, w, run): copies the step of a lane into memory of its own."""


def functions(method: str) -> dict[str, Compiled]:
    """Return the compiled loop over eight lanes of a method, and the functions it calls."""
    functions_of_one = of_one(method)
    wide = module_named(sibling(__name__, f"{method}_wide")).FUNCTIONS
    compiled_functions = {name: function for name, function in wide.items() if isinstance(function, Compiled)}
    space = {**globals(), "method": module_named(place(method)).METHOD, **functions_of_one, **wide}
    return {**functions_of_one, **compiled_functions, **part.bound(space)}


@part
def lost(lane: int, n: int, wide: Reals, w: int, row: int, rows: int) -> int:
    """Return the first component of a lane that is not finite in the first of ``rows`` rows that has one, or -1."""
    for k in range(row, row + rows):
        for i in range(n):
            if not math.isfinite(wide[k * w + 8 * i + lane]):
                return i
    return -1


@part
def project_wide(batch: Batch, eight: EightLanes, lanes: Lane) -> None:
    """Move the ends of the steps onto the constraints in lanes whose error is at most 1 (`step_control.project`).

    A change that is too large is no step error: the error of that lane becomes 1000.
    """
    w, wide, run = eight.w, eight.rows, lanes.run
    places = HEIGHT * w
    count = 0
    for lane in range(8):
        wide[places + SELECTED + lane] = 0.0
        if wide[places + ERRORS + lane] <= 1.0:
            wide[places + SELECTED + lane] = 1.0
            count += 1
    k = 0
    while count > 0 and k < 5:
        call_wide(batch.projection_wide, wide, places + MOMENTS, wide, END * w, eight.c, wide, ERROR5 * w)
        moved(wide, 8 * run.projected, ERROR5 * w, END * w, places + SELECTED, places + CHANGES)
        unit_wide(eight, lanes, END)
        count = 0
        for lane in range(8):
            change = wide[places + CHANGES + lane]
            if wide[places + SELECTED + lane] != 0.0:
                if k == 0 and not change <= eight.control[ALLOWED + lane]:
                    wide[places + ERRORS + lane] = 1e3
                wide[places + SELECTED + lane] = 0.0
                if change > 1e-8:
                    wide[places + SELECTED + lane] = 1.0
                    count += 1
        k += 1


@part
def unit_wide(eight: EightLanes, lanes: Lane, row: int) -> None:
    """Divide the quaternions of a row by their norms (`step_control.normalise`)."""
    run = lanes.run
    for k in range(run.n_quaternions):
        unit_at(eight.rows, row * eight.w + 8 * run.quaternions[k])


@part
def stiff_wide(eight: EightLanes, lane: int, limited: float) -> int:
    """Return 1 if a lane is stiff (`step_control.is_stiff`)."""
    counts = eight.counts
    if limited != 0.0:
        counts[SUSPECT + lane] += 1
        counts[CALM + lane] = 0
    else:
        counts[CALM + lane] += 1
        if counts[CALM + lane] == 6:
            counts[SUSPECT + lane] = 0
    return 1 if counts[SUSPECT + lane] >= 15 else 0


@part
def near_limit(batch: Batch, eight: EightLanes, lanes: Lane, lane: int) -> int:
    """Return 1 if a lane may pass a limit in its step.

    It may if a value at one of its ends is at most twice its change in this step or in the one before. Values far from
    zero are copied as the start values of the next step.
    """
    m, values, wide, result = batch.n_watched, batch.limit_values, eight.rows, 0
    search = lanes[lane].run.search
    for e in range(m):
        now, before, changes = wide[values + 8 * e + lane], search.table[0, e], values + 8 * (m + e) + lane
        change = abs(now - before)
        if not lesser(now, before) > 2.0 * greater(change, wide[changes]):
            result = 1
        wide[changes] = change
    if result == 0:
        for e in range(m):
            search.table[0, e] = wide[values + 8 * e + lane]
            search.signs[e] = 1
    return result


@part
def tune(eight: EightLanes, lanes: Lane, lane: int) -> None:
    """Update the quantities that depend on the tolerances of a lane."""
    allowed, run = 0.0, lanes[lane].run
    for i in range(run.n):
        allowed = greater(allowed, 1e3 * eight.tolerances[eight.w + 8 * i + lane])
    eight.control[ALLOWED + lane] = allowed if run.fixed == 0 else 0.1  # see `step_control.advance`
    tune_wide(lane, run.n, eight.rows, eight.w, eight.tolerances)


@part
def last_state(batch: Batch, eight: EightLanes, lanes: Lane, lane: int) -> None:
    """Store the last good state of a lane in place of its initial state. Python looks there for the cause of a
    failure.
    """
    for i in range(lanes.run.n):
        batch.initial[eight.counts[RUN + lane], i] = eight.rows[STATE * eight.w + 8 * i + lane]


@part
def end_lane(batch: Batch, eight: EightLanes, lane: int, code: int, blame: int, t: float) -> None:
    """Remove a run from its lane and store its results."""
    counts = eight.counts
    steps = counts[EARLIER_STEPS + lane] + counts[TAKEN + lane]
    leave(batch, counts[RUN + lane], code, steps, counts[REJECTED + lane], blame, t)
    counts[RUN + lane] = -1


@part
def enter_leg(batch: Batch, eight: EightLanes, lanes: Lane, lane: int) -> int:
    """Begin the next leg of a run with the state in its own memory."""
    one, run, wide, w = lanes[lane], lanes[lane].run, eight.rows, eight.w
    counts, control, tolerances, places = eight.counts, eight.control, eight.tolerances, HEIGHT * eight.w
    counts[TAKEN + lane] = counts[SUSPECT + lane] = counts[CALM + lane] = counts[AFTER_REJECTION + lane] = 0
    code = begin_leg(batch, one)
    if code != RUNNING:
        return code
    for j in range(batch.n_constants):
        eight.c[8 * j + lane] = run.c[j]
    if batch.limit_values != 0:
        for e in range(batch.n_watched):
            wide[batch.limit_values + 8 * (batch.n_watched + e) + lane] = math.inf
    if batch.n_dropped > 0 and contradicted(batch, one, run.t, run.y) != 0:
        return CONTRADICTED
    for i in range(run.n):
        wide[STATE * w + 8 * i + lane] = run.y[i]
        wide[8 * i + lane] = run.k[0, i]
        tolerances[8 * i + lane] = run.absolute[i]
        tolerances[w + 8 * i + lane] = run.relative[i]
    begin_wide(lane, run.n, wide, w)
    tune(eight, lanes, lane)
    wide[places + TIMES + lane] = run.t
    wide[places + STEPS + lane] = run.h
    control[LEG_END + lane] = run.until
    control[OLD_ERRORS + lane] = 1e-4
    control[STRIDE + lane] = 0.0
    set_next_output(batch, eight, one, lane)
    return RUNNING


@part
def set_next_output(batch: Batch, eight: EightLanes, one: Lane, lane: int) -> None:
    """Set the next output time of a lane."""
    direction = 1.0 if batch.t1 >= batch.t0 else -1.0
    k = one.outputs_done
    eight.control[NEXT_OUTPUT + lane] = batch.times[k] if k < batch.n_times else direction * math.inf


@part
def seek(batch: Batch, one: Lane) -> float:
    """Find the events and extremes of a lane's step, which has been copied into its own memory.

    Return the fraction of the step at which a terminal event ends it, else -1. The component to blame is 1 + the number
    of an event function without a value that ends it, else 0.
    """
    run, stop = one.run, -1.0
    run.blame = 0
    if batch.n_watched > 0:
        if method.densify is not None:
            method.densify(run)
        run.events = 0
        stop = log_events(run, find_events(run))
        if stop >= 0.0 and stop == run.search.reach:
            run.blame = 1 + run.search.culprit
        log_step_events(batch, one)
    if batch.n_reduced > 0:
        moment = run.after if stop < 0.0 or stop == 1.0 else run.t + stop * run.h
        widen(batch, one, moment, run.end)
    return stop


@part
def lift_step(eight: EightLanes, one: Lane, lane: int, after: float) -> None:
    """Copy the step of a lane into its own memory."""
    run, places = one.run, HEIGHT * eight.w
    lift(lane, eight.rows, eight.w, run)
    run.t, run.h, run.after = eight.rows[places + TIMES + lane], eight.rows[places + STEPS + lane], after


@part
def output_in_step(batch: Batch, one: Lane, reaches: int) -> None:
    """Compute the outputs at the output times of a step in a lane's own memory."""
    run, t, after = one.run, one.run.t, one.run.after
    direction, done = 1.0 if batch.t1 >= batch.t0 else -1.0, one.outputs_done
    while done < batch.n_times and (batch.times[done] - after) * direction <= 0.0:
        x = batch.times[done]
        if x == run.until and reaches != 0 and one.leg + 1 < batch.n_legs:
            break  # the break point belongs to the next leg
        y = run.y if x == t else run.end
        if x != t and x != after:
            state_in_step(run, (x - t) / run.h)
            y = run.point
        write_outputs(batch, one, done, y)
        done += 1
    one.outputs_done = done


@part
def choose_wide(batch: Batch, eight: EightLanes, lanes: Lane, lane: int) -> int:
    """Choose the step of a lane (`step_control.choose_length`). Return 1 if the run ends instead."""
    run, wide, w, counts = lanes[lane].run, eight.rows, eight.w, eight.counts
    places = HEIGHT * w
    direction = 1.0 if batch.t1 >= batch.t0 else -1.0
    t, h, until = wide[places + TIMES + lane], wide[places + STEPS + lane], run.until
    wide[places + STEPS + lane] = 0.0
    if method.length is not None:
        size = wide[places + LENGTHS + lane]
        if batch.rates_wide != 0 and not size > 8.0 * EPS * abs(t):  # a bend is closer than that
            straight = straight_wide(lane, run.n, wide, w, eight.tolerances)
            if straight == straight:
                size = straight
        if size != size:
            blame = blame_wide(lane, run.n, wide, w)
            last_state(batch, eight, lanes, lane)
            end_lane(batch, eight, lane, NOT_FINITE, blame, t)
            return 1
        if run.fixed == 0 and counts[AFTER_REJECTION + lane] == 0:
            h = direction * size
    if abs(h) > batch.longest:
        h = direction * batch.longest
    counts[ENDS + lane] = 0
    after = t + h
    if (t + 1.01 * h - until) * direction >= 0.0:
        h = until - t
        counts[ENDS + lane] = 1
        after = until
    elif abs(h) <= 8.0 * EPS * abs(t) or abs(h) < TINY:
        last_state(batch, eight, lanes, lane)
        end_lane(batch, eight, lane, COLLAPSED, 0, t)
        return 1
    elif run.fixed != 0:
        after = run.start + (counts[TAKEN + lane] + 1) * h
    wide[places + STEPS + lane], wide[places + AFTERS + lane] = h, after
    return 0


@part
def attempt_all(batch: Batch, eight: EightLanes, lanes: Lane, free: int) -> None:
    """Attempt the steps of all lanes (`step_control.error_of_step`)."""
    wide, w = eight.rows, eight.w
    places = HEIGHT * w
    attempt_wide(batch.wide, wide, w, eight.c)
    for i in range(w):
        wide[END * w + i] = wide[RAW * w + i]
    unit_wide(eight, lanes, END)
    judge_wide(batch.rates_wide, lanes.run.n, wide, w, eight.c, eight.tolerances)
    for lane in range(8):
        wide[places + MOMENTS + lane] = wide[places + AFTERS + lane]
    if free == 0:
        for lane in range(8):
            fixed = eight.counts[RUN + lane] >= 0 and lanes[lane].run.fixed != 0
            if fixed and wide[places + ERRORS + lane] > 1.0:
                wide[places + ERRORS + lane] = 1.0
    if batch.projection_wide != 0:
        project_wide(batch, eight, lanes)
    if method.length is None:
        call_wide(batch.wide, wide, places + MOMENTS, wide, END * w, eight.c, wide, 12 * w)
        all_finite(wide, w, 12 * w, places + ERRORS)
    if batch.limit_values != 0:
        call_wide(
            batch.watched_wide, wide, places + MOMENTS, wide, END * w, eight.c, wide, batch.limit_values
        )
    if batch.stop_if_stiff != 0:
        limit_wide(wide, w)


@part
def reject_wide(eight: EightLanes, lanes: Lane, lane: int, error: float) -> int:
    """Shorten the step of a lane (`step_control.reject`); return its status, with the component to blame in its run."""
    run, wide, w, counts = lanes[lane].run, eight.rows, eight.w, eight.counts
    places, code = HEIGHT * w, RUNNING
    t, h = wide[places + TIMES + lane], wide[places + STEPS + lane]
    counts[REJECTED + lane] += 1
    counts[AFTER_REJECTION + lane] = 1
    run.blame = 0
    if error == error:
        h *= shortening(error)
        if run.fixed != 0:
            code = DIVERGED
    else:
        if method.length is not None:
            run.blame = blame_wide(lane, run.n, wide, w)
        else:
            run.blame = lost(lane, run.n, wide, w, 1, 12)
            if run.blame < 0:
                run.blame = lost(lane, run.n, wide, w, RAW, 3)
        h *= 0.25
        if run.fixed != 0 or abs(h) <= 16.0 * EPS * abs(t) or abs(h) < TINY:
            code = NOT_FINITE
    wide[places + STEPS + lane] = h
    return code


@part
def tighten_wide(batch: Batch, eight: EightLanes, lanes: Lane, lane: int) -> float:
    """Tighten the tolerances of a lane that has used its budget; return the factor."""
    run, w, tolerances = lanes[lane].run, eight.w, eight.tolerances
    finest = tolerances[w + lane]
    for i in range(run.n):
        finest = lesser(tolerances[w + 8 * i + lane], finest)
    run.t = eight.rows[HEIGHT * w + TIMES + lane]
    tighter = tightening(batch, run, batch.budget, finest)
    for i in range(run.n):
        tolerances[8 * i + lane] *= tighter
        tolerances[w + 8 * i + lane] *= tighter
    tune(eight, lanes, lane)
    return tighter


@part
def accept_lane(batch: Batch, eight: EightLanes, lanes: Lane, lane: int, error: float) -> int:
    """Take the step of a lane; return its status, with the component to blame in its run."""
    one, run, wide, w = lanes[lane], lanes[lane].run, eight.rows, eight.w
    counts, control, places = eight.counts, eight.control, HEIGHT * eight.w
    direction, code = 1.0 if batch.t1 >= batch.t0 else -1.0, RUNNING
    t, h, after = wide[places + TIMES + lane], wide[places + STEPS + lane], wide[places + AFTERS + lane]
    reaches, goes_on = counts[ENDS + lane] != 0, one.leg + 1 < batch.n_legs
    run.blame = 0
    counts[TAKEN + lane] += 1
    control[STRIDE + lane] = greater(control[STRIDE + lane], abs(h))
    limited = wide[places + LIMITED + lane]
    if limited != 0.0 or counts[SUSPECT + lane] > 0:
        stiff = stiff_wide(eight, lane, limited)
        if stiff * batch.stop_if_stiff != 0 and abs(run.until - after) > MANY * abs(h):
            code = STIFF
    done = one.outputs_done
    seeking = batch.n_watched > 0 or batch.n_reduced > 0
    if batch.limit_values != 0:
        seeking = near_limit(batch, eight, lanes, lane) != 0
    lifted = seeking or (done < batch.n_times and (batch.times[done] - after) * direction <= 0.0)
    if lifted or batch.n_dropped > 0:
        lift_step(eight, one, lane, after)
    if seeking:
        stop = seek(batch, one)
        if stop >= 0.0:
            code, reaches = TERMINAL, False
            if run.blame > 0:
                code, run.blame = UNDEFINED, run.blame - 1
            after = after if stop == 1.0 else t + stop * h
    if lifted:
        run.after = after
        output_in_step(batch, one, 1 if reaches else 0)
        set_next_output(batch, eight, one, lane)
    if batch.n_dropped > 0 and contradicted(batch, one, after, run.end) != 0:
        code, reaches = CONTRADICTED, False
    wide[places + TIMES + lane] = after
    wide[places + SELECTED + lane] = 1.0
    if reaches and goes_on:
        stride = control[STRIDE + lane]
        one.stride = stride if counts[TAKEN + lane] > 1 else greater(one.stride, stride)
        counts[EARLIER_STEPS + lane] += counts[TAKEN + lane]
        one.leg += 1
        for i in range(run.n):
            run.y[i] = wide[END * w + 8 * i + lane]
        wide[places + SELECTED + lane] = 0.0  # STATE already holds the start of the leg
        code = enter_leg(batch, eight, lanes, lane)
        if code == RUNNING:
            if counts[EARLIER_STEPS + lane] < batch.limit:
                return RUNNING
            code = TOO_MANY
    elif reaches:
        code = FINISHED
    elif code == RUNNING and counts[EARLIER_STEPS + lane] + counts[TAKEN + lane] >= batch.limit:
        code = TOO_MANY
    if method.length is None and run.fixed == 0:
        factor = lengthening(error, control[OLD_ERRORS + lane])
        h *= factor if counts[AFTER_REJECTION + lane] == 0 else lesser(1.0, factor)
    counts[AFTER_REJECTION + lane] = 0
    if counts[TAKEN + lane] == batch.budget:
        h *= tighten_wide(batch, eight, lanes, lane) ** (1.0 / batch.order)
    wide[places + STEPS + lane] = h
    control[OLD_ERRORS + lane] = greater(error, 1e-4)
    return code


@part
def lanes_wide(begin: int, end: int, batch: Batch, lanes: Lane, eight: EightLanes) -> None:
    """Compute the runs ``begin`` to ``end`` - 1, with the memory of eight lanes, ``lanes[0]`` to ``lanes[7]``."""
    wide, w, counts, control = eight.rows, eight.w, eight.counts, eight.control
    direction = 1.0 if batch.t1 >= batch.t0 else -1.0
    places = HEIGHT * w
    following, active = begin, 0
    free, plain = 1, batch.n_watched == 0 and batch.n_reduced == 0 and batch.n_dropped == 0
    for leg in range(batch.n_legs):
        if batch.leg_steps[leg] != 0.0:
            free, plain = 0, False
    for lane in range(8):
        counts[RUN + lane] = -1
    for k in range(WIDE_PLACES):
        wide[places + k] = 0.0
    while active > 0 or following < end:
        for lane in range(8):
            while counts[RUN + lane] < 0 and following < end:
                enter(batch, lanes[lane], following)
                for k in range(8):
                    counts[8 * k + lane] = 0
                counts[RUN + lane] = following
                code = enter_leg(batch, eight, lanes, lane)
                following += 1
                if code == RUNNING:
                    active += 1
                else:
                    end_lane(batch, eight, lane, code, lanes[lane].run.blame, batch.t0)
        prepare_wide(batch.wide, wide, w, eight.c, eight.tolerances)
        # choose the steps of most lanes at once; lanes that end, were rejected, ... follow one by one
        one_by_one = 8
        if free != 0 and settled(
            wide, places, LENGTHS if method.length is not None else STEPS, control, counts, direction, batch.longest
        ):  # fmt: skip
            one_by_one = 0
        for lane in range(one_by_one):
            if wide[places + EASY + lane] == 0.0:
                if counts[RUN + lane] < 0:
                    wide[places + STEPS + lane] = 0.0
                else:
                    active -= choose_wide(batch, eight, lanes, lane)
        if active == 0:
            continue
        attempt_all(batch, eight, lanes, free)
        one_by_one = 8
        if plain:
            if taken(wide, places, control, counts, batch.budget, batch.limit):
                one_by_one = 0
            if method.length is None:
                for lane in range(8):
                    if wide[places + EASY + lane] != 0.0:
                        error = wide[places + ERRORS + lane]
                        wide[places + STEPS + lane] *= lengthening(error, control[OLD_ERRORS + lane])
                        control[OLD_ERRORS + lane] = greater(error, 1e-4)
        for lane in range(one_by_one):
            if plain and wide[places + EASY + lane] != 0.0:
                continue
            wide[places + SELECTED + lane] = 0.0
            if counts[RUN + lane] < 0:
                continue
            error = wide[places + ERRORS + lane]
            if not error <= 1.0:
                code = reject_wide(eight, lanes, lane, error)
            else:
                code = accept_lane(batch, eight, lanes, lane, error)
            if code != RUNNING:
                last_state(batch, eight, lanes, lane)
                end_lane(batch, eight, lane, code, lanes[lane].run.blame, wide[places + TIMES + lane])
                active -= 1
        blend(wide, w, END * w, STATE * w, places + SELECTED)
        accept_wide(wide, w, places + SELECTED)
