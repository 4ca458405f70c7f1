"""States of a run: on the constraints, inside a step, and at given times.

A state inside a step, of an event or for output, is the end of a shorter step from the same start. It has the order of
the method, and at the end of the step it equals the result of the run. The dense output only serves to find events, and
is faster where many states lie in one step. `step_control` binds these functions to a method.
"""

from __future__ import annotations

import math
from typing import Any

from ...native.instructions import (
    EPS,
    Integers,
    Parts,
    Real,
    Reals,
    Row,
    Truth,
    call,
    compiled,
    greater,
    lesser,
    root,
    where,
)
from .run import Run

MOST_PARTS = 1024
"""Number of parts into which a step is divided at most."""

BESIDE = EPS ** (1 / 3)
"""Part of a step in which the error of a polynomial of second order is round-off of the change in the step."""

part = Parts()

method: Any = None
"""The method (`method.Method`), in the functions below."""


@compiled
def to_unit(row: Row, quaternions: Integers, count: int) -> None:
    """Divide the quaternions that begin at these places of a row by their norms."""
    for k in range(count):
        i = quaternions[k]
        a, b, c, d = row[i], row[i + 1], row[i + 2], row[i + 3]
        s = root(a * a + b * b + c * c + d * d)
        for j in range(4):
            row[i + j] /= s


@compiled
def close_gaps(run: Run) -> None:
    """Let the lengths of the steps follow the times, and the states follow the lengths."""
    done, times, states = run.accepted, run.times, run.states[0]
    for k in range(done):
        times[done + 1 + k] = run.lengths[k]
    for i in range((done + 1) * run.n):
        times[2 * done + 1 + i] = states[i]


@compiled
def normalise(run: Run, row: Row) -> None:
    """Divide each quaternion of a row by its norm."""
    to_unit(row, run.quaternions, run.n_quaternions)


@compiled
def project(run: Run, t: Real, row: Row, moving: Truth) -> Real:
    """Move a row onto the constraints where ``moving`` holds. There are some.

    The kernel takes one Newton step, whose error is the square of the change: after a change below 1e-8 the result has
    reached round-off. Return the change of the first step, relative to 1 + |value|.
    """
    first: Real = 0.0
    k = 0
    while any(moving) and k < 5:
        change: Real = 0.0
        run.projection(t, row, run.c, run.error5)
        for i in range(run.projected):
            new = run.error5[i]
            change = greater(change, abs(new - row[i]) / (1.0 + abs(new)))
        normalise(run, run.error5)
        for i in range(run.projected):
            row[i] = where(moving, run.error5[i], row[i])
        first = change if k == 0 else first
        moving = moving and change > 1e-8
        k += 1
    return first


@compiled
def are_finite(row: Row, n: int) -> Truth:
    """Return whether n numbers are finite."""
    doubt: Real = 0.0
    for i in range(n):
        doubt += 0.0 * row[i]
    return doubt == 0.0


@compiled
def not_finite(row: Row, n: int, lane: int) -> int:
    """Return the first of n numbers of a lane that is not finite, or -1."""
    for i in range(n):
        if not math.isfinite(row[i][lane]):
            return i
    return -1


@part
def dense_state(run: Run, x: float) -> None:
    """Set the row point: the dense output at the fraction ``x`` (0 to 1) of the step, with unit quaternions."""
    method.interpolate(run, x)
    normalise(run, run.point)
    run.reached = -1.0


@part
def shorter_step(run: Run, x: float) -> None:
    """Set the row point: the end of a step of the length x h from the same start; of a series, its value there."""
    if method.length is not None:
        method.interpolate(run, x)
    else:
        if method.attempt(run, x * run.h) != 0:
            for i in range(run.n):
                run.y_new[i] = math.nan
        run.point[:] = run.y_new
    run.evaluated += method.cost
    normalise(run, run.point)
    if run.projection is not None:
        project(run, run.t + x * run.h, run.point, True)


@part
def state_in_step(run: Run, x: float) -> None:
    """Set the row point: the state at the fraction ``x`` of the step, by a shorter step from the same start, or, for a
    single step, from the dense output. A state that the row still holds is not computed again.

    States beside that of the first shorter step follow from it. It stays the same for the step, so that equal fractions
    have equal states, by whose signs events are told to have passed.
    """
    if method.single_step:
        dense_state(run, x)
    elif run.reached != x:
        reach = reach_of(run) if method.cost > 0 else 0.0
        if run.base >= 0.0 and abs(x - run.base) <= reach:
            state_beside(run, x)
        else:
            shorter_step(run, x)
            if run.base < 0.0 < reach:
                keep_base(run, x)
        run.reached = x


@compiled
def reach_of(run: Run) -> float:
    """Return the part of the step in which states follow from one, but for round-off; 0 if searches move farther.

    The ends of shorter steps have errors, of the tolerance r, and run with the length at slopes that are off by those:
    over a part p of the step by r p. A search moves by r.
    """
    tolerance = 0.0
    for i in range(run.n):
        tolerance = greater(tolerance, greater(run.relative[i], run.absolute[i]))
    return lesser(BESIDE, EPS / tolerance) if tolerance * tolerance <= EPS else 0.0


@part
def keep_base(run: Run, x: float) -> None:
    """Keep the row point, the state at ``x``, with its rates and the rates of these, if they are finite."""
    y, f, slope = run.beside[0], run.beside[1], run.beside[2]
    t, aside = run.t + x * run.h, (BESIDE if x < 0.5 else -BESIDE) * run.h
    y[:] = run.point
    run.rates(t, y, run.c, f)
    run.argument[:] = y + aside * f
    run.rates(t + aside, run.argument, run.c, slope)
    run.evaluated += 2
    slope[:] = (slope - f) / aside
    run.base = x if are_finite(slope, run.n) else -1.0


@part
def state_beside(run: Run, x: float) -> None:
    """Set the row point: the state at ``x``, by the Taylor polynomial of second order at ``base``."""
    length = (x - run.base) * run.h
    run.point[:] = run.beside[0] + length * (run.beside[1] + length / 2.0 * run.beside[2])
    normalise(run, run.point)
    if run.projection is not None:
        project(run, run.t + x * run.h, run.point, True)


# -- states at given times -----------------------------------------------------------------------------


@part
def step_at(run: Run, steps: int, t: float) -> int:
    """Return the step of the run that contains a time: times[k] <= t < times[k + 1], in the direction of the run."""
    times, low, high = run.times, 0, steps
    direction = 1.0 if times[steps] >= times[0] else -1.0
    current = run.sampled - 1
    if current >= 0 and (t - times[current]) * direction >= 0.0 > (t - times[current + 1]) * direction:
        return current
    while high - low > 1:
        middle = (low + high) // 2
        if (t - times[middle]) * direction >= 0.0:
            low = middle
        else:
            high = middle
    return low


@part
def begin_again(run: Run, t: float, y: Reals) -> None:
    """Go to the start of a step, the state y at t."""
    run.t, run.reached, run.base = t, -1.0, -1.0
    for i in range(run.n):
        run.y[i] = y[i]
    run.rates(run.t, run.y, run.c, run.k[0])
    if method.prepare is not None:
        method.prepare(run, True)


@part
def expect_end(run: Run, t: float, y: Reals) -> None:
    """Let iterations begin from the known end of the step, the state y at t."""
    for i in range(run.n):
        run.end[i] = y[i]
    run.rates(t, run.end, run.c, run.k[12])
    method.expect(run, t - run.t)


@part
def strays(run: Run, x: float) -> Truth:
    """Return whether the shorter step to ``x`` has come to another solution for its stages than the known step.

    Its error is greater than that of the known step, and than the tolerance. Where the force of a contact passes
    through infinity at a direction of its slip near that of the motion, there is a solution on each side.
    """
    error = method.judge(run, x * run.h)
    return error > 1.0 and (method.attempt(run, run.h) != 0 or not error <= method.judge(run, run.h))


@part
def in_parts(run: Run, t: float, y: Reals, length: float) -> None:
    """Set the row point: the state at this distance from the start of a step, the state y at t, by several steps.

    The iteration of one may not converge where that of the run did, from the polynomial of the step before.
    """
    parts, done = 1, 0
    while done < parts and parts < MOST_PARTS:
        parts, done = 2 * parts, 0
        begin_again(run, t, y)
        while done < parts and method.attempt(run, length / parts) == 0 and are_finite(run.y_new, run.n):
            normalise(run, run.y_new)
            if run.projection is not None:
                project(run, run.t + length / parts, run.y_new, True)
            if method.hold is not None:
                method.hold(run)
            if method.accept is not None:
                method.accept(run, True)
            done += 1
            run.t = t + done * length / parts
            run.y[:] = run.y_new
            run.rates(run.t, run.y, run.c, run.k[0])
        run.point[:] = run.y
    if done < parts:
        for i in range(run.n):
            run.point[i] = math.nan


@part
def sample(run: Run, steps: int, dense: int, count: int, moments: Reals, result: Reals) -> None:
    """Compute the states at the times ``moments``, each within the run in the buffers.

    If ``dense`` is 0, each is the end of a shorter step from the start of the step that contains its time. Otherwise it
    is taken from the dense output, which is faster if many times lie in one step and are in the order of the run. The
    step that the rows hold from the last call is not taken again.
    """
    times, n = run.times, run.n
    for k in range(count):
        t = moments[k]
        low = step_at(run, steps, t)
        high = low + 1 if low < steps else low
        if t == times[low] or t == times[high]:
            row = low if t == times[low] else high
            for i in range(n):
                result[k * n + i] = run.states[row, i]
            continue
        fresh = low != run.sampled - 1
        run.t, run.h = times[low], run.lengths[low]
        if fresh:
            run.sampled = low + 1
            begin_again(run, times[low], run.states[low])
            if method.expect is not None and high > low:
                expect_end(run, times[high], run.states[high])
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
        if method.expect is not None and (
            not are_finite(run.point, n) or (not from_dense and strays(run, x))
        ):
            in_parts(run, times[low], run.states[low], t - times[low])
            run.sampled = 0
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
