"""Events of a motion in time steps: zero crossings of expressions, linear between the ends of each step, and where they
jump through zero by what signals and controllers set.

Forces of contacts are means over a step, which stand at its end, so that their events have the accuracy of a step.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...errors import SimulationError
from ..kernels.contact_quantities import asked_by, watched_program
from ..kernels.kernels import Kernels
from ..ode.dense_output import Array, Crossing, observe
from ..trajectory.event import EventSpec
from .intervals import Intervals


class Crossings:
    """The zero crossings of functions of the user.

    A function that arrives at zero has its event there, and one that leaves it after more than a moment. So has one
    that starts at zero.

    ``asked``   quantities of contacts that the functions take
    """

    def __init__(self, kernels: Kernels, specs: Sequence[EventSpec], expressions: Sequence[Any]) -> None:
        self.kernels, self.specs, self.expressions = kernels, specs, expressions
        self.asked = asked_by(expressions)
        self.program = watched_program(kernels, expressions, self.asked)

    def found(
        self, intervals: Intervals, times: Array, rows: Array, first: int = 0, since: int = 0
    ) -> tuple[Crossing, ...]:
        """Return the crossings in the steps from ``since`` on, at times that begin with that of the step ``first``.

        ``rows`` are states, each followed by quantities of contacts (`pieces.with_contacts`).

        Raises
        ------
        SimulationError
            An event without a value.
        """
        if not self.specs:
            return ()
        n, result = self.kernels.model.n_q + self.kernels.model.n_u, list[Crossing]()
        before = np.zeros(len(self.specs))
        for i, begin, end in intervals.parts(first, first + len(times) - 1):
            constants = self.program.constants(intervals.parameters[i])
            some, late = slice(begin - first, end - first + 1), max(since - begin, 0)
            if 0 < begin == intervals.first[i] and late == 0:
                others = self.program.constants(intervals.parameters[i - 1])
                result += self._jumps(others, constants, times[some][:1], rows[some][:1])
            g = self._values(times[some], rows[some], constants)
            result += self._within(g, before, constants, times[some], rows[some], late)
            before = g[-2:][0]
        ordered = sorted(result, key=lambda one: one.time)
        return tuple(replace(one, state=one.state[:n]) for one in ordered)

    def _at(self, times: Array, rows: Array, constants: Array) -> Array:
        return observe(self.program.address("values"), len(self.specs), times, rows, constants)

    def _jumps(self, before: Array, after: Array, time: Array, row: Array) -> Iterator[Crossing]:
        """Yield the events whose functions change their sign with the constants."""
        signs = (np.sign(self._at(time, row, c)[0]) for c in (before, after))
        for i, (old, new) in enumerate(zip(*signs, strict=True)):
            if old * new < 0 and self.specs[i].direction in (0, int(new)):
                yield Crossing(float(time[0]), i, int(new), row[0].copy())

    def _values(self, times: Array, rows: Array, constants: Array) -> Array:
        """Return the functions at the ends of steps; refuse those without a value."""
        g = self._at(times, rows, constants)
        lost = np.argwhere(~np.isfinite(g))
        if len(lost):
            k, i = lost[0]
            raise SimulationError(
                f"Expected a number for event '{self.specs[i].name}' at t = {times[k]:.9g} s, got {g[k, i]:g} for "
                f"{self.expressions[i]}. A division by zero, or a root or logarithm of a negative number, does this: "
                "watch what passes through zero itself, or stop before with a terminal event."
            )
        return g

    def _within(
        self, g: Array, before: Array, constants: Array, times: Array, rows: Array, late: int
    ) -> Iterator[Crossing]:
        """Yield the zero crossings in the steps of an interval from ``late`` on, by linear interpolation in each.

        ``before`` are the functions a moment before the interval.
        """
        signs = np.sign(g)
        arrives = (signs[:-1] != 0) & (signs[1:] != signs[:-1])
        leaves = (signs[:-1] == 0) & (signs[1:] != 0) & (np.vstack([before, signs[:-2]]) == 0)
        for k, i in np.argwhere(arrives | leaves):
            sign = int(signs[k + 1, i] - signs[k, i] > 0) * 2 - 1
            if k < late or self.specs[i].direction not in (0, sign):
                continue
            x, moved = g[k, i] / (g[k, i] - g[k + 1, i]), rows[k + 1] - rows[k]

            def value(x: float, k: int = int(k), i: int = int(i), moved: Array = moved) -> float:
                moment = times[k : k + 1] + x * (times[k + 1] - times[k])
                return float(self._at(moment, (rows[k] + x * moved)[None], constants)[0, i])

            if not _through_infinity(value):
                time = min(float(times[k] + x * (times[k + 1] - times[k])), float(times[k + 1]))
                yield Crossing(time, int(i), sign, rows[k] + x * moved)


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
