"""Runs that fail in a study that is reduced, and what they mean for its results.

``failed="raise"``   a failed run is an error, with the numbers of failed runs by status and the first lane
``failed="skip"``    failed runs are left out; the result tells how many
``failed="count"``   a failed run counts as one in which the condition holds: an upper bound of a fraction
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SimulationError, shown
from ...motion.ending import GOOD, STATUS
from .reducer import Reducer, State

FAILED = ("raise", "skip", "count")


@dataclass(frozen=True)
class Failures:
    """Failed lanes of a study: status -> number of lanes, least lane, in the order of the statuses."""

    lanes: tuple[tuple[int, int, int], ...] = ()

    @classmethod
    def of(cls, status: Any, lanes: Any) -> Failures:
        """Return the failures among some lanes with these codes of status."""
        status, lanes = np.asarray(status), np.asarray(lanes)
        bad = ~good_lanes(status)
        codes = np.unique(status[bad]).tolist()
        return cls(tuple((int(c), int((status == c).sum()), int(lanes[status == c].min())) for c in codes))

    def merge(self, other: Failures) -> Failures:
        """Return the failures of the lanes of both."""
        table = {code: (count, first) for code, count, first in self.lanes}
        for code, count, first in other.lanes:
            before = table.get(code, (0, first))
            table[code] = before[0] + count, min(before[1], first)
        return Failures(tuple((code, *table[code]) for code in sorted(table)))

    @property
    def count(self) -> int:
        """Number of failed lanes."""
        return sum(count for _, count, _ in self.lanes)

    def check(self, failed: str, meanings: Mapping[int, str] = STATUS) -> None:
        """Refuse failures where they are errors.

        Raises
        ------
        SimulationError
            Numbers of failed runs by status, and the first lane of each.
        """
        if failed != "raise" or not self.lanes:
            return
        words = "; ".join(
            f"{count:,} '{meanings.get(code, code)}' (first in lane {first})"
            for code, count, first in self.lanes
        )
        raise SimulationError(
            f"Expected all runs to end well, but {self.count:,} failed, the first in lane "
            f'{min(first for *_, first in self.lanes)}: {words}. Leave them out by failed="skip", or count them as '
            'runs in which the conditions hold by failed="count".'
        )


def good_lanes(status: Any) -> NDArray[np.bool_]:
    """Return True for each lane whose run ended well.

    >>> from freebody.motion.ending import End
    >>> good_lanes([End.FINISHED, End.TERMINAL, End.COLLAPSED]).tolist()
    [True, True, False]
    """
    return np.isin(status, GOOD)


def check_failed(failed: Any, reducers: Iterable[Reducer]) -> None:
    """Refuse a meaning of failed runs that a reducer cannot have.

    Raises
    ------
    SimulationError
        An unknown meaning, or ``failed="count"`` for a number.
    """
    if not isinstance(failed, str) or failed not in FAILED:
        raise SimulationError(f'Expected failed="raise", "skip" or "count", got {shown(failed)}.')
    if failed == "count":
        for reducer in reducers:
            if reducer.title != "mean" or not reducer.of_condition:
                raise SimulationError(
                    f'Expected means of conditions for failed="count", got {reducer!r}: a failed run has no number. '
                    'Leave such runs out by failed="skip", or reduce conditions alone.'
                )


def state_of_block(
    reducer: Reducer,
    columns: Mapping[str, Any],
    lanes: Any,
    status: Any,
    *,
    weights: Any = None,
    failed: str = "raise",
) -> State:
    """Return the state of a block of lanes that ended with these codes of status; of all lanes for ``"count"``.

    Failures that are errors are those of the study (`Failures.check`); here they are left out.
    """
    good, lanes = good_lanes(status), np.asarray(lanes)
    names = (*reducer.wanted, *reducer.names)

    def part(rows: Any) -> tuple[Any, ...]:
        return (
            {name: np.asarray(columns[name])[rows] for name in names}, lanes[rows],
            None if weights is None else np.asarray(weights)[rows],
        )  # fmt: skip

    state = reducer.of(*part(good))
    return state.merge(reducer.of_failed(*part(~good))) if failed == "count" else state
