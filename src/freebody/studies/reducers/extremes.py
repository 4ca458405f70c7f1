"""Greatest and smallest values of a number over all runs, with the lanes that have them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ...errors import SimulationError, arguments_named, shown
from .number import Array
from .reducer import Reducer, Variable, is_skipped, numbers_of


@arguments_named
def largest(what: str, n: int = 10, by: Any = None, *, missing: str = "raise") -> Extremes:
    """Return the reducer for the largest values of a number over all runs, with the lanes that have them.

    Parameters
    ----------
    what : str
        Number of a whole run, as in :func:`freebody.mean`.
    n : int, optional
        How many values, from 1 to 65536. Equal values stand in the order of their lanes.
    by : str or sequence of str, optional
        Numbers whose distinct values are groups.
    missing : {"raise", "skip"}, optional
        Meaning of a run in which the number has no finite value.

    Returns
    -------
    Extremes
        Its result has ``value`` and ``lane`` by ``rank``, the largest first, nan and -1 where there are fewer runs,
        and ``count``, the number of all runs. Extremes of a sample have no standard error.

    Raises
    ------
    SimulationError
        If the text is no number of a whole run, or ``n`` is no number of values.

    Examples
    --------
    >>> import freebody as fb, numpy as np
    >>> worst = fb.largest("max(pin)", 2)
    >>> data = worst.result(worst.of({"max(pin)": np.array([3.0, 9.0, 4.0])}, lanes=np.array([7, 8, 9])))
    >>> data.value.values, data.lane.values
    (array([9., 4.]), array([8, 9]))
    """
    return _extremes("largest", -1, what, n, by, missing)


@arguments_named
def smallest(what: str, n: int = 10, by: Any = None, *, missing: str = "raise") -> Extremes:
    """Return the reducer for the smallest values of a number over all runs, with the lanes that have them.

    Parameters and result are those of :func:`freebody.largest`, with the smallest value first.

    Raises
    ------
    SimulationError
        If the text is no number of a whole run, or ``n`` is no number of values.

    Examples
    --------
    >>> import freebody as fb, numpy as np
    >>> best = fb.smallest("end", 1)
    >>> best.result(best.of({"end": np.array([3.0, 2.0, 2.0])}, lanes=np.arange(3))).lane.values
    array([1])
    """
    return _extremes("smallest", 1, what, n, by, missing)


def _extremes(title: str, sign: int, what: str, n: Any, by: Any, missing: Any) -> Extremes:
    if type(n) is not int or not 1 <= n <= 1 << 16:
        raise SimulationError(f"Expected from 1 to 65536 for n= of {title}, got {shown(n)}.")
    return Extremes(**numbers_of([what], title, by), skipped=is_skipped(missing, title), n=n, sign=sign)


@dataclass(frozen=True, eq=False)
class Outermost:
    """The ``n`` smallest values of some lanes, their lanes, and the number of all lanes."""

    n: int
    values: Array
    lanes: NDArray[np.int64]
    count: int

    def merge(self, other: Outermost) -> Outermost:
        """Return the smallest values of the lanes of both."""
        values, lanes = np.concatenate([self.values, other.values]), np.concatenate([self.lanes, other.lanes])
        return _outermost(self.n, values, lanes, self.count + other.count)


def _outermost(n: int, values: Array, lanes: Any, count: int) -> Outermost:
    """Return the smallest values, equal values in the order of their lanes."""
    if len(values) > 4 * n:  # all values up to the n-th
        near = values <= np.partition(values, n - 1)[n - 1]
        values, lanes = values[near], lanes[near]
    order = np.lexsort([lanes, values])[:n]
    return Outermost(n, values[order], lanes[order], count)


@dataclass(frozen=True, repr=False)
class Extremes(Reducer):
    """Greatest or smallest values of a number. Made by :func:`largest` and :func:`smallest`."""

    has_error: ClassVar[bool] = False
    n: int = field(kw_only=True)
    sign: int = field(kw_only=True)
    """-1 for the greatest values, 1 for the smallest."""

    @property
    def title(self) -> str:  # type: ignore[override]
        """Name of the function that makes it."""
        return "largest" if self.sign < 0 else "smallest"

    def options(self) -> list[str]:
        """Return the other arguments, as in a call."""
        return [str(self.n)]

    @property
    def entries(self) -> int:
        """Greatest number of entries of the state of one group."""
        return self.n

    def part(self, values: list[Array], lanes: Any, weighted: bool) -> Outermost:
        """Return the outermost values of the lanes of one group."""
        return _outermost(self.n, self.sign * values[0] + 0.0, lanes, len(lanes))

    def variables(self, parts: list[Outermost]) -> tuple[dict[str, Variable], dict[str, Any]]:
        """Return values and lanes by rank, and the number of lanes."""
        size = max((len(part.lanes) for part in parts), default=0)
        values, lanes = np.full((len(parts), size), np.nan), np.full((len(parts), size), -1, dtype=np.int64)
        for row, part in enumerate(parts):
            values[row, : len(part.lanes)] = self.sign * part.values + 0.0
            lanes[row, : len(part.lanes)] = part.lanes
        counts = np.array([part.count for part in parts], dtype=np.int64)
        result: dict[str, Variable] = {
            "value": (("rank",), values, {"long_name": f"{self.title} values of {self.numbers[0].text}"}),
            "lane": (("rank",), lanes, {"long_name": "lanes that have them"}),
            "count": ((), counts, {"long_name": "runs"}),
        }
        return result, {"rank": (("rank",), np.arange(1, size + 1), {})}
