"""The loop around the steps of any method: step-size control, projection, located events, output.

    y' = f(t, y, c)

A method (`dop853`, `dop54`, `radau`, `gauss`, `structure`, `taylor`) defines a step, as a value (`Method`). Everything
else is here, once. A step is attempted, judged, and accepted if its error ε is at most 1. The next step is

    h_new = h · min(G, max(S, safety · ε_old^β / ε^α))

(proportional-integral control), with S = 1/3 and G = 6 unless the method states others. A rejected step is repeated
with h_new, and β = 0. Steps of fixed length are accepted whatever their error.

Unit quaternions are normalised after each accepted step. The correction is of the size of the local error, O(h^(p+1)),
and f is evaluated at the corrected state, so that the order p is kept. The dense output is the polynomial from the
state at the start of the step to its uncorrected end. Each quaternion is divided by its norm where the dense output is
evaluated, so that it meets the corrected state at the end of the step and is continuous.

The dense output serves to find events (`event_search`). It is not stored, and no result depends on it: steps are long,
and its error may exceed the tolerance. A state inside a step, of an event or for output (`sample`), is the end of a
shorter step from the same start. It has the order of the method, and at the end of the step it equals the result of the
run. So a run stores n numbers per step.

The memory of a run is a record (`run.Run`). No step allocates, counts references, tests a bound or raises. `loop`
compiles this module once and keeps the result on the disk; the module is imported only for that.

Source: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I (1993), section II.4; E. Hairer,
G. Wanner, Solving Ordinary Differential Equations II (1996), section IV.2.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ...native.instructions import EPS, Compiled, Parts, Reals, call, compiled, greater, lesser, root
from . import event_search
from .event_search import find_events, log_events
from .layout import (
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
from .run import STAGES, Run

TINY = 1e-300


class Method(NamedTuple):
    """A method as a value. Its functions are compiled; those that are None have nothing to do.

    ``attempt``       (run, h) -> 0, or 1 if the iteration diverges: one step of length h from y, whose rates are k[0],
                      to y_new
    ``judge``         (run, h) -> error ε of the step in units of the tolerance, nan if it is not finite
    ``densify``       (run): prepares `interpolate`; k[12] holds the rates at the end of the step
    ``interpolate``   (run, x): sets the row point at the fraction x of the step
    ``prepare``       (run): called before the first step from a new start
    ``hold``          (run): saves an accepted step, since shorter steps may be tried before `accept`
    ``accept``        (run): the step was taken, and y is its end
    ``length``        (run) -> length of the next step, if lengths follow from the state at their start; nan if there is
                      none. No error has to be judged then, and the rates at the end of a step are not needed
    ``limited``       (run, h) -> 1 if stability limits the step; for a method with ``length``
    ``alpha``, ``beta``, ``safety``, ``smallest``, ``greatest``    constants of the control
    ``cost``, ``cost_dense``    evaluations of f in attempt and in densify; 0 for a method that counts its own
    ``last_stage``, ``stable``  last stage, whose time is that of the end, of an explicit method, and the end of its
                      region of stability on the negative axis; 0 for a method that is not watched for stiffness
    ``single_step``   True if there is only one step. Its error is judged whatever its length, and states inside it come
                      from the dense output, which is as accurate as its end
    """

    name: str
    order: int
    attempt: Compiled
    judge: Compiled
    interpolate: Compiled
    densify: Compiled | None = None
    prepare: Compiled | None = None
    hold: Compiled | None = None
    accept: Compiled | None = None
    length: Compiled | None = None
    limited: Compiled | None = None
    alpha: float = 0.125
    beta: float = 0.0
    safety: float = 0.9
    smallest: float = 1.0 / 3.0
    greatest: float = 6.0
    cost: int = 0
    cost_dense: int = 0
    last_stage: int = 0
    stable: float = 0.0
    single_step: bool = False


method: Any = None
"""The method, in the functions below."""

part = Parts()


class Functions(dict[str, Compiled]):
    """The compiled loop of a method: the functions of this module, with ``method`` as a constant."""

    def __init__(self, method: Method) -> None:
        space = {**vars(event_search), **globals(), "method": method}
        super().__init__({**event_search.part.bound(space), **part.bound(space)})
        self.method = method


@compiled
def cubic(run: Run, last: int) -> None:
    """Set dense[0] to dense[2] of the cubic through the states and rates at both ends; k[last] are those at the end."""
    for i in range(run.width):
        difference = run.y_new[i] - run.y[i]
        run.dense[0, i] = difference
        run.dense[1, i] = run.h * run.k[0, i] - difference
        run.dense[2, i] = 2.0 * difference - run.h * (run.k[last, i] + run.k[0, i])


# -- states --------------------------------------------------------------------------------------------


@part
def normalise(run: Run, row: Reals) -> None:
    """Divide each quaternion of a row by its norm."""
    for k in range(run.n_quaternions):
        i = run.quaternions[k]
        a, b, c, d = row[i], row[i + 1], row[i + 2], row[i + 3]
        s = root(a * a + b * b + c * c + d * d)
        for j in range(4):
            row[i + j] /= s


@part
def project(run: Run, t: float, row: Reals) -> float:
    """Move a row onto the constraints, if there are any.

    The kernel takes one Newton step, whose error is the square of the change: after a change below 1e-8 the result has
    reached round-off. Return the change of the first step, relative to 1 + |value|.
    """
    first = 0.0
    if run.projection is not None:
        change, k = 1.0, 0
        while change > 1e-8 and k < 5:
            run.projection(t, row, run.c, run.error5)
            change = 0.0
            for i in range(run.projected):
                new = run.error5[i]
                change = greater(change, abs(new - row[i]) / (1.0 + abs(new)))
                row[i] = new
            normalise(run, row)
            if k == 0:
                first = change
            k += 1
    return first


@part
def not_finite(row: Reals, n: int) -> int:
    """Return the first of n numbers that is not finite, or -1."""
    for i in range(n):
        if not math.isfinite(row[i]):
            return i
    return -1


@part
def dense_state(run: Run, x: float) -> None:
    """Set the row point: the dense output at the fraction ``x`` (0 to 1) of the step, with unit quaternions."""
    method.interpolate(run, x)
    normalise(run, run.point)


@part
def shorter_step(run: Run, x: float) -> None:
    """Set the row point: the end of a step of the length x h from the same start."""
    if method.attempt(run, x * run.h) != 0:
        for i in range(run.n):
            run.y_new[i] = math.nan
    run.evaluated += method.cost
    run.point[:] = run.y_new
    normalise(run, run.point)
    project(run, run.t + x * run.h, run.point)


@part
def state_in_step(run: Run, x: float) -> None:
    """Set the row point: the state at the fraction ``x`` of the step, by a shorter step from the same start, or, for a
    single step, from the dense output.
    """
    if method.single_step:
        dense_state(run, x)
    else:
        shorter_step(run, x)


# -- the length of steps -------------------------------------------------------------------------------


@part
def first_length(run: Run, direction: float, longest: float) -> float:
    """Return a length for the first step (Hairer, Norsett, Wanner, II.4): d_0 = |y|, d_1 = |f|, d_2 = |Δf| / h_0.

    Row point and k[1] are overwritten.
    """
    if run.n == 0:
        return longest
    d0, d1, d2 = 0.0, 0.0, 0.0
    for i in range(run.n):
        scale = run.absolute[i] + run.relative[i] * abs(run.y[i])
        d0 = greater(d0, abs(run.y[i]) / scale)
        d1 = greater(d1, abs(run.k[0, i]) / scale)
    h0 = 1e-6
    if not (d0 < 1e-5 or d1 < 1e-5):
        h0 = 0.01 * d0 / d1
    h0 = lesser(h0, longest)
    for i in range(run.n):
        run.point[i] = run.y[i] + direction * h0 * run.k[0, i]
    run.rates(run.t + direction * h0, run.point, run.c, run.k[1])
    for i in range(run.n):
        scale = run.absolute[i] + run.relative[i] * abs(run.y[i])
        bend = abs(run.k[1, i] - run.k[0, i]) / scale
        if not math.isfinite(bend):
            return h0
        d2 = greater(d2, bend)
    d2 /= h0
    if not math.isfinite(d2):
        return h0
    h1 = greater(1e-6, h0 * 1e-3)
    steepest = greater(d1, d2)
    if steepest > 1e-15:
        h1 = (0.01 / steepest) ** (1.0 / method.order)
    return lesser(lesser(100.0 * h0, h1), longest)


@part
def lengthening(error: float, old: float) -> float:
    """Return the factor from an accepted step to the next."""
    if error > 0.0:
        factor = method.safety * old**method.beta / error**method.alpha
        return lesser(method.greatest, greater(method.smallest, factor))
    return method.greatest


@part
def shortening(error: float) -> float:
    """Return the factor from a rejected step to the next attempt."""
    return greater(method.smallest, method.safety / error**method.alpha)


@part
def choose_length(run: Run, direction: float) -> int:
    """Set h, the end of the step and whether it ends the run; return RUNNING, NOT_FINITE or COLLAPSED."""
    if method.length is not None:
        size = method.length(run)
        if size != size:
            return NOT_FINITE
        if run.fixed == 0 and run.after_rejection == 0:
            run.h = direction * size
    if abs(run.h) > run.longest:
        run.h = direction * run.longest
    run.last = 1 if (run.t + 1.01 * run.h - run.until) * direction >= 0.0 else 0
    if run.last != 0:
        run.h = run.until - run.t
    elif abs(run.h) <= 8.0 * EPS * abs(run.t) or abs(run.h) < TINY:
        return COLLAPSED
    run.after = run.until if run.last != 0 else run.t + run.h
    if run.fixed != 0 and run.last == 0:
        run.after = run.start + (run.taken + 1) * run.h
    return RUNNING


@part
def is_stiff(run: Run) -> int:
    """Return 1 if steps were as long as the region of stability allows, h |λ| > stable, for 15 steps.

    |λ| is estimated from the last stage and the end of the step, two states at one time. λ must be that of a decay: a
    vibration too fast for an explicit method is too fast for an implicit one, too. Six steps without suspicion reset
    the count (Hairer and Wanner, section IV.2).
    """
    above, below, across, h = 0.0, 0.0, 0.0, run.h
    if method.limited is not None:
        suspect = method.limited(run, h) != 0
    else:
        for i in range(run.n):
            a = run.k[12, i] - run.k[method.last_stage, i]
            b = run.end[i] - run.argument[i]
            above += a * a
            below += b * b
            across += a * b
        decays = h * across < -0.5 * abs(h) * root(above * below)
        suspect = decays and h * h * above > method.stable * method.stable * below and below > 0.0
    if suspect:
        run.suspect += 1
        run.calm = 0
    else:
        run.calm += 1
        if run.calm == 6:
            run.suspect = 0
    return 1 if run.suspect >= 15 else 0


# -- steps ---------------------------------------------------------------------------------------------


@part
def launch(run: Run) -> int:
    """Prepare the first step from y: compute its rates and, if none is prescribed, its length.

    Return NOT_FINITE if there are no rates, FINISHED if the run has length zero, else RUNNING.
    """
    direction = 1.0 if run.until >= run.t else -1.0
    longest = lesser(run.longest, abs(run.until - run.t))
    run.old_error = 1e-4
    if method.length is None:
        run.rates(run.t, run.y, run.c, run.k[0])
        run.evaluated += 1
        run.blame = not_finite(run.k[0], run.n)
        if run.blame >= 0:
            return NOT_FINITE
        run.blame = 0
    if longest == 0.0:
        return FINISHED
    if method.length is None and run.h == 0.0:
        run.h = first_length(run, direction, longest)
        run.evaluated += 1
        run.point[:] = 0.0
        run.k[1][:] = 0.0
    run.h = direction * lesser(run.h, longest)
    return RUNNING


@part
def look(run: Run) -> int:
    """Evaluate the event functions at y, and their signs, for the first `find_events`.

    Return UNDEFINED if a required function has no value, else RUNNING.
    """
    search, values = run.search, run.search.table[0]
    search.functions(run.t, run.y, search.c, values)
    for e in range(search.count):
        search.signs[e] = 1 if values[e] > 0.0 else (-1 if values[e] < 0.0 else 0)
        if e < run.required and not math.isfinite(values[e]):
            run.blame = e
            return UNDEFINED
    return RUNNING


@part
def error_of_step(run: Run) -> float:
    """Attempt a step, and return its error ε; 1000 if another reason shortens it, nan if the state at its end, or its
    rates, are not finite.
    """
    diverges = method.attempt(run, run.h) != 0
    run.evaluated += method.cost
    if diverges:
        return 1e3
    error = method.judge(run, run.h)
    run.end[:] = run.y_new
    normalise(run, run.end)
    if run.fixed != 0 and error > 1.0 and not method.single_step:
        error = 1.0
    if error <= 1.0 and not project(run, run.after, run.end) <= run.allowed:
        return 1e3  # not a step error: another branch, or the constraints end or bend too sharply here
    if method.length is None and error <= 1.0:  # a state without rates is invalid
        run.rates(run.after, run.end, run.c, run.k[12])
        run.evaluated += 1
        if not_finite(run.k[12], run.n) >= 0:
            return math.nan
    return error


@part
def reject(run: Run, error: float) -> int:
    """Shorten the step; return RUNNING, DIVERGED if its length is fixed, or NOT_FINITE."""
    run.rejected += 1
    run.after_rejection = 1
    if error == error:
        if run.fixed != 0:
            return DIVERGED
        run.h *= shortening(error)
        return RUNNING
    if method.length is None:  # the others have told it, since they have other rows
        run.blame = blamed(run)
    run.h *= 0.25
    if run.fixed != 0 or abs(run.h) <= 16.0 * EPS * abs(run.t) or abs(run.h) < TINY:
        return NOT_FINITE
    return RUNNING


@part
def blamed(run: Run) -> int:
    """Return the first component that is not finite, in the first row that has one, or -1."""
    for j in range(1, 13):
        i = not_finite(run.k[j], run.n)
        if i >= 0:
            return i
    i = not_finite(run.y_new, run.n)
    if i < 0:
        i = not_finite(run.error5, run.n)
    if i < 0:
        i = not_finite(run.error3, run.n)
    return i


@part
def store(run: Run) -> None:
    """Write time, length and state at the start of an accepted step into the buffers."""
    k = run.accepted
    run.times[k], run.lengths[k] = run.t, run.h
    for i in range(run.n):
        run.states[k, i] = run.y[i]
    run.accepted = k + 1
    run.taken += 1


@part
def follow_events(run: Run) -> int:
    """Find and log the events of an accepted step; return RUNNING, TERMINAL, or UNDEFINED."""
    if run.search.count == 0:
        return RUNNING
    if method.densify is not None:
        method.densify(run)
    run.evaluated += method.cost_dense
    stop = log_events(run, find_events(run))
    if stop < 0.0:
        return RUNNING
    status = TERMINAL
    if stop == run.search.reach:
        status, run.blame = UNDEFINED, run.search.culprit
    if stop != 1.0:
        run.after = run.t + stop * run.h
    return status


@part
def advance(run: Run) -> int:
    """Step until the end, a terminal event, a failure, or until the buffers are full.

    Return RUNNING, FINISHED, TERMINAL, NOT_FINITE, COLLAPSED, DIVERGED, STIFF or UNDEFINED.
    """
    direction = 1.0 if run.until >= run.t else -1.0
    run.accepted = run.events = 0
    if method.prepare is not None and run.taken == 0:
        method.prepare(run)
    run.allowed = 0.0
    for i in range(run.n):
        run.allowed = greater(run.allowed, 1e3 * run.relative[i])
    if run.fixed != 0:
        run.allowed = 0.1  # steps of fixed length may have any error
    status = RUNNING
    while status == RUNNING and run.accepted < run.room and run.events <= run.room:
        status = choose_length(run, direction)
        if status != RUNNING:
            break
        error = error_of_step(run)
        if not error <= 1.0:
            status = reject(run, error)
            continue
        store(run)
        if method.hold is not None:
            method.hold(run)
        if (
            (method.last_stage != 0 or method.limited is not None)
            and is_stiff(run) != 0
            and abs(run.until - run.after) > MANY * abs(run.h)
        ):
            run.stiffness += 1
            if run.stop_if_stiff != 0:
                status = STIFF
        stop = follow_events(run)
        if stop != RUNNING:
            status = stop
        run.t = run.after
        run.y[:] = run.end
        if method.length is None:
            run.k[0][:] = run.k[12]
        if method.accept is not None:
            method.accept(run)
        if stop != RUNNING:
            break
        if run.last != 0:
            status = FINISHED
        elif status == RUNNING and run.fixed == 0:
            factor = lengthening(error, run.old_error)
            if run.after_rejection != 0:
                factor = lesser(1.0, factor)
                run.after_rejection = 0
            run.h *= factor
            run.old_error = greater(error, 1e-4)
    k = run.accepted
    run.times[k] = run.t
    for i in range(run.n):
        run.states[k, i] = run.y[i]
    return status


@part
def clear(run: Run) -> None:
    """Set the rows of a step to zero, but not its state."""
    for j in range(STAGES):
        run.k[j][:] = 0.0
    run.argument[:] = 0.0
    run.y_new[:] = 0.0
    run.error5[:] = 0.0
    run.error3[:] = 0.0
    run.end[:] = 0.0


@part
def piece(run: Run) -> int:
    """Compute a run, or its next piece.

    If a run cannot begin, the buffers hold its start and no steps. In the buffers the lengths follow the times, and the
    states follow the lengths, without gaps.
    """
    status = RUNNING
    if run.taken == 0:
        clear(run)
        for i in range(run.n):
            run.y[i] = run.initial[i]
        normalise(run, run.y)
        run.times[0] = run.t
        for i in range(run.n):
            run.states[0, i] = run.y[i]
        status = launch(run)
        if run.search.count > 0 and status == RUNNING:
            status = look(run)
    if status == RUNNING:
        status = advance(run)
    done, times, states = run.accepted, run.times, run.states[0]
    for k in range(done):
        times[done + 1 + k] = run.lengths[k]
    for i in range((done + 1) * run.n):
        times[2 * done + 1 + i] = states[i]
    return status


# -- states at given times -----------------------------------------------------------------------------


@part
def sample(run: Run, steps: int, dense: int, count: int, moments: Reals, result: Reals) -> None:
    """Compute the states at the times ``moments``, each within the run in the buffers.

    If ``dense`` is 0, each is the end of a shorter step from the start of the step that contains its time. Otherwise it
    is taken from the dense output, which is faster if many times lie in one step and are in the order of the run. The
    step that the rows hold from the last call is not taken again.
    """
    times, n = run.times, run.n
    direction = 1.0 if times[steps] >= times[0] else -1.0
    current = run.sampled - 1
    for k in range(count):
        t = moments[k]
        low, high = 0, steps  # times[low] <= t < times[high], in the direction of the run
        if current >= 0 and (t - times[current]) * direction >= 0.0 > (t - times[current + 1]) * direction:
            low, high = current, current + 1
        while high - low > 1:
            middle = (low + high) // 2
            if (t - times[middle]) * direction >= 0.0:
                low = middle
            else:
                high = middle
        if t == times[low] or t == times[high]:
            row = low if t == times[low] else high
            for i in range(n):
                result[k * n + i] = run.states[row, i]
            continue
        fresh = low != current
        run.t, run.h = times[low], run.lengths[low]
        if fresh:
            current = low
            run.sampled = low + 1
            for i in range(n):
                run.y[i] = run.states[low, i]
            run.rates(run.t, run.y, run.c, run.k[0])
            if method.prepare is not None:
                method.prepare(run)
        x = (t - run.t) / run.h
        from_dense = dense != 0 or method.single_step
        if fresh or not from_dense:
            shorter_step(run, 1.0 if from_dense else x)
        if from_dense:
            if fresh:
                run.rates(run.t + run.h, run.point, run.c, run.k[12])
                if method.densify is not None:
                    method.densify(run)
                if method.hold is not None:
                    method.hold(run)
            dense_state(run, x)
        for i in range(n):
            result[k * n + i] = run.point[i]


@part
def observe(
    kernel: int, count: int, times: Reals, states: Reals, n: int, c: Reals, result: Reals, outputs: int,
) -> None:  # fmt: skip
    """Set row k of ``result`` (length ``outputs``) to the outputs of ``kernel`` at ``times[k]`` and row k of
    ``states``.
    """
    for k in range(count):
        call(kernel, times[k], states, k * n, c, result, k * outputs)
