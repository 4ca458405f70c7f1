"""The times of the steps. None is longer than ``step=``, and each stop ends one: a break point of a signal, a sample of
a controller.

Between two stops all steps have one length, so that no step crosses a jump or a bend of the loads.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..ode.dense_output import Array
from ..start.arguments import check_count

_WHOLE = 1e-9
"""Part of a step by which a whole number of them may miss the length of an interval."""


@dataclass(frozen=True, eq=False)
class Grid:
    """Steps of a run.

    ``times``     start of each step, and the end of the last [s];  ``lengths``: of each step [s]
    ``longest``   greatest length of a step, or the one that was asked for if there is no step [s]
    ``first``     number of the step that begins at the start and at each stop
    """

    times: Array
    lengths: Array
    longest: float
    first: Any

    @property
    def count(self) -> int:
        """Number of steps."""
        return len(self.lengths)

    def step_at(self, time: float) -> int:
        """Return the number of the step that holds a time; of two, the later one."""
        soon = time + 1e-12 * (time - self.times[0])
        k = int(np.searchsorted(self.times, soon, side="right")) - 1
        return min(k, max(self.count - 1, 0))


def grid_of(begin: float, end: float, step: float, stops: Sequence[float], most: int) -> Grid:
    """Return the steps from ``begin`` to ``end``, with ``stops`` between them in order.

    Raises
    ------
    SimulationError
        More than ``most`` steps.
    """
    ends = np.array([begin, *stops, end])
    spans = np.diff(ends)
    check_count(float(np.sum(spans)) / step, most, f"step = {step:g} s", "Take a longer step=")
    counts = np.maximum(np.round(spans / step), 1)
    short = np.abs(counts * step - spans) > _WHOLE * np.maximum(step, np.abs(end))
    counts = np.where(short, np.ceil(spans / step), counts).astype(np.int64)
    if end == begin:
        counts[:] = 0
    many = f"step = {step:g} s and {len(stops)} break points and samples, each of which ends a step"
    check_count(float(counts.sum()), most, many, "Take a longer step=, or sample less often")
    lengths = spans / np.maximum(counts, 1)
    first = np.concatenate([[0], np.cumsum(counts)])
    times = [
        t + h * np.arange(n)
        for t, h, n in zip(ends.tolist(), lengths.tolist(), counts.tolist(), strict=False)
    ]
    longest = float(lengths.max()) if counts.any() else step
    return Grid(np.concatenate([*times, [end]]), np.repeat(lengths, counts), longest, first[:-1])
