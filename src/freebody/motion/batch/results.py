"""Results of the lanes of a batch, as arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..ending import End
from ..ode.dense_output import Array

LANE_BY_LANE = ("event_times", "counts", "status", "steps", "rejected", "blame", "end_times")
"""Arrays in which the compiled loop writes a row for each lane."""
_ARRAYS = ("values", "reduced", *LANE_BY_LANE, "texts")
REASON = "reason"
"""Variable that tells why a lane failed."""


@dataclass(frozen=True, eq=False)
class Results:
    """Results of the lanes ``low`` to ``high`` - 1, one row per lane.

    ``values``        outputs, (lanes, times, outputs)
    ``reduced``       greatest, smallest, first and last value of each quantity of the whole run
    ``event_times``   first and last time of each event
    ``counts``        how often each event happened
    ``status``        code of the end; ``steps``, ``rejected``: numbers of steps; ``blame``: component or event
    ``end_times``     time at which the run ended
    ``slopes``        derivatives by the unknowns, by the name of their variable; the unknowns are the last axis
    ``texts``         results that are texts: the timeline of modes, the reason of a failure
    ``begin``         time at which runs begin
    """

    low: int
    high: int
    values: Array
    reduced: Array
    event_times: Array
    counts: NDArray[np.int64]
    status: NDArray[np.int64]
    steps: NDArray[np.int64]
    rejected: NDArray[np.int64]
    blame: NDArray[np.int64]
    end_times: Array
    texts: NDArray[Any]
    slopes: Mapping[str, Array] = field(default_factory=dict)
    begin: float = 0.0

    def take(self, part: Results) -> None:
        """Copy the results of some of the lanes into their rows."""
        rows = slice(part.low - self.low, part.high - self.low)
        for name in _ARRAYS:
            getattr(self, name)[rows] = getattr(part, name)
        for name, array in self.slopes.items():
            array[rows] = part.slopes[name]

    def rows(self, low: int, high: int) -> Results:
        """Return the results of the lanes ``low`` to ``high`` - 1; they share their memory with these."""
        rows = slice(low - self.low, high - self.low)
        slopes = {name: array[rows] for name, array in self.slopes.items()}
        return Results(
            low,
            high,
            **{name: getattr(self, name)[rows] for name in _ARRAYS},
            slopes=slopes,
            begin=self.begin,
        )

    def clear(self, rows: Any) -> None:
        """Make lanes waiting again."""
        for array in (self.values, self.reduced, self.event_times, *self.slopes.values()):
            array[rows] = np.nan
        self.end_times[rows] = self.begin
        self.texts[rows] = ""
        self.status[rows] = End.WAITING
        for whole in (self.counts, self.steps, self.rejected, self.blame):
            whole[rows] = 0

    @property
    def waiting(self) -> NDArray[np.bool_]:
        """True for each lane that was not run."""
        return self.status == End.WAITING
