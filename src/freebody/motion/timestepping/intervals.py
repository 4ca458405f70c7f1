"""Intervals of a motion in time steps in which all constants of the machine keep their values.

Signals and controllers give other values at the start of each (`legs.driven`); without them there is one interval.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..kernels.kernels import Kernels
from ..kernels.program import Program
from ..legs.driven import Drives
from ..ode.dense_output import Array, observe


@dataclass(frozen=True, eq=False)
class Intervals:
    """Values of the parameters in each interval.

    ``first``        number of the step with which each begins
    ``parameters``   values of the parameters in each
    ``jumps``        work at the start of each, by which the change of a potential raises the energy [J]
    """

    first: Any
    parameters: Array
    jumps: Array

    def between(self, first: int, last: int) -> Intervals:
        """Return the intervals of the steps from ``first`` to before ``last``, which are numbered from 0."""
        begin = int(self.of_steps(first))
        some = slice(begin, max(int(self.of_steps(last - 1)), begin) + 1)
        jumps = self.jumps[some].copy()
        jumps[0] = 0.0 if first > 0 else jumps[0]
        return Intervals(np.maximum(self.first[some] - first, 0), self.parameters[some], jumps)

    def of_steps(self, steps: Any) -> Any:
        """Return the number of the interval of each step."""
        return np.searchsorted(self.first, steps, side="right") - 1

    def work_until(self, steps: Any) -> Array:
        """Return the work of the changes up to the start of each step [J]."""
        return np.asarray(np.cumsum(self.jumps)[self.of_steps(steps)])

    def numbers(self, kernels: Kernels, step: int) -> Mapping[str, float]:
        """Return the values of the parameters in a step by name."""
        row = self.parameters[self.of_steps(step)]
        return dict(zip((x.name for x in kernels.model.parameters), row.tolist(), strict=True))

    def parts(self, begin: int, end: int) -> Iterator[tuple[int, int, int]]:
        """Yield the intervals of the steps from ``begin`` to ``end``: number, first of these steps, end."""
        ends = [*self.first[1:].tolist(), end]
        for i in range(int(self.of_steps(begin)), len(self.first)):
            if self.first[i] >= end > begin:
                return
            yield i, max(int(self.first[i]), begin), min(ends[i], end)

    def observed(self, program: Program, function: str, times: Array, states: Array, steps: Any) -> Array:
        """Return the outputs of a function at states, with the values of the parameters in these steps."""
        address, count = program.address(function), program.outputs(function)
        places = self.of_steps(steps)
        result = np.empty((len(times), count))
        for k in np.unique(places):
            some = places == k
            constants = program.constants(self.parameters[k])
            result[some] = observe(address, count, times[some], states[some], constants)
        return result


class Values:
    """Values of the parameters in a run of steps, which ``drives`` change at the steps ``first``.

    ``numbers``, ``parameters``   those of the present step, by name and in order
    """

    def __init__(
        self, kernels: Kernels, numbers: Mapping[str, float], drives: Drives | None, first: Any
    ) -> None:
        self.kernels, self.drives, self.numbers = kernels, drives, numbers
        self.parameters = kernels.parameters(numbers)
        self._changes = first[::-1].tolist() if drives else []
        count = len(first)
        self._all = Intervals(first, np.empty((count, len(self.parameters))), np.zeros(count))
        self._all.parameters[0], self._count = self.parameters, 1

    def change(self, step: int, t: float, y: Array) -> bool:
        """Take the values that signals and controllers give at the start of a step; return True if there are any."""
        drives = self.drives
        if drives is None or step != self.next_change():
            return False
        before = self._energy(t, y) if drives.potential else 0.0
        drives.change(t, y)
        self._changes.pop()
        self.numbers = dict(drives.numbers)
        self.parameters = self.kernels.parameters(self.numbers)
        if step > 0:
            self._all.jumps[self._count] = self._energy(t, y) - before if drives.potential else 0.0
            self._count += 1
        self._all.parameters[self._count - 1] = self.parameters
        return True

    def next_change(self) -> float:
        """Return the next step at which values change, infinity if there is none."""
        return self._changes[-1] if self._changes else np.inf

    def intervals(self) -> Intervals:
        """Return the intervals up to the present step."""
        whole, some = self._all, slice(self._count)
        return Intervals(whole.first[some], whole.parameters[some], whole.jumps[some])

    def _energy(self, t: float, y: Array) -> float:
        program = self.kernels.motion()
        constants = program.constants(self.parameters)
        return float(observe(program.address("energy"), 2, np.array([t]), y[None], constants).sum())
