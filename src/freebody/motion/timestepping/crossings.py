"""Events of a motion in time steps: zero crossings of expressions, linear between the ends of each step, and where they
jump through zero by what signals and controllers set.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from ...errors import SimulationError
from ..kernels.kernels import Kernels
from ..kernels.program import Program
from ..ode.dense_output import Array, Crossing, observe
from .intervals import Intervals


def crossings(
    kernels: Kernels,
    intervals: Intervals,
    specs: Any,
    expressions: Any,
    times: Array,
    states: Array,
    first: int = 0,
) -> tuple[Crossing, ...]:
    """Return the zero crossings of the user's events; times and states begin with those of the step ``first``.

    Raises
    ------
    SimulationError          if an event has no value
    """
    if not specs:
        return ()
    program = kernels.expressions(expressions)
    result: list[Crossing] = []
    for i, begin, end in intervals.parts(first, first + len(times) - 1):
        constants = program.constants(intervals.parameters[i])
        some = slice(begin - first, end - first + 1)
        if 0 < begin == intervals.first[i]:
            before = program.constants(intervals.parameters[i - 1])
            result += _jumps(program, specs, before, constants, times[some][:1], states[some][:1])
        result += _within(program, specs, expressions, constants, times[some], states[some])
    return tuple(sorted(result, key=lambda one: one.time))


def _jumps(
    program: Program, specs: Any, before: Array, after: Array, time: Array, state: Array
) -> Iterator[Crossing]:
    """Yield the events whose functions change their sign with the constants."""
    signs = (
        np.sign(observe(program.address("values"), len(specs), time, state, c)[0]) for c in (before, after)
    )
    for i, (old, new) in enumerate(zip(*signs, strict=True)):
        if old * new < 0 and specs[i].direction in (0, int(new)):
            yield Crossing(float(time[0]), i, int(new), state[0].copy())


def _within(
    program: Program, specs: Any, expressions: Any, constants: Array, times: Array, states: Array
) -> Iterator[Crossing]:
    """Yield the zero crossings in the steps of an interval, located by linear interpolation within each step."""

    def at(moments: Array, there: Array) -> Array:
        return observe(program.address("values"), len(specs), moments, there, constants)

    g = at(times, states)
    lost = np.argwhere(~np.isfinite(g))
    if len(lost):
        k, i = lost[0]
        raise SimulationError(
            f"Expected a number for event '{specs[i].name}' at t = {times[k]:.9g} s, got {g[k, i]:g} for "
            f"{expressions[i]}. A division by zero, or a root or logarithm of a negative number, does this: watch what "
            "passes through zero itself, or stop before with a terminal event."
        )
    for i, spec in enumerate(specs):
        for k in np.flatnonzero((g[:-1, i] * g[1:, i] < 0) | ((g[1:, i] == 0) & (g[:-1, i] != 0))):
            sign = 1 if g[k, i] < 0 else -1
            if spec.direction in (0, sign):
                x = g[k, i] / (g[k, i] - g[k + 1, i])

                def value(x: float, k: int = int(k), i: int = i) -> float:
                    between = states[k : k + 1] + x * (states[k + 1] - states[k])
                    return float(at(times[k : k + 1] + x * (times[k + 1] - times[k]), between)[0, i])

                if _through_infinity(value):
                    continue
                time = float(times[k] + x * (times[k + 1] - times[k]))
                yield Crossing(time, i, sign, states[k] + x * (states[k + 1] - states[k]))


def _through_infinity(value: Callable[[float], float]) -> bool:
    """Return True if a sign change between 0 and 1 is at a pole: near it, |value| far exceeds both end values."""
    low, high = 0.0, 1.0
    before, after = value(low), value(high)
    largest = max(abs(before), abs(after))
    for _ in range(40):
        x = (low + high) / 2
        found = value(x)
        if found == 0:
            return False
        low, high = (x, high) if (found > 0) == (before > 0) else (low, x)
    return not min(abs(value(low)), abs(value(high))) <= 1e3 * largest
