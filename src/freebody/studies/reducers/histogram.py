"""Histogram of a number over all runs.

Bins of equal width between two bounds, or, without bounds, bins of width 2^k between multiples of 2^k:

    bin j = [j 2^k, (j + 1) 2^k),   k the least for which ``bins`` bins reach from the least to the greatest value

and for which the bounds of bins are floats. More lanes never have a smaller k, and bins of 2^k are unions of smaller
ones: histograms merge exactly, in any order.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ...errors import SimulationError, arguments_named, shown
from .number import Array
from .reducer import Reducer, Variable, is_skipped, numbers_of

_SMALLEST = -1074
"""Exponent of the smallest float."""


@arguments_named
def histogram(
    what: str, bins: int = 200, range: Any = None, by: Any = None, *, missing: str = "raise"
) -> Histogram:
    """Return the reducer for the histogram of a number over all runs.

    Parameters
    ----------
    what : str
        Number of a whole run, as in :func:`freebody.mean`.
    bins : int, optional
        Number of bins, from 1 to 65536; without ``range`` the greatest number.
    range : (number, number), optional
        Bounds of the bins; the last bin includes its upper end. Without it the bins have the width 2^k and begin at
        multiples of it, with the least k for which they reach from the least to the greatest value.
    by : str or sequence of str, optional
        Numbers whose distinct values are groups.
    missing : {"raise", "skip"}, optional
        Meaning of a run in which the number has no finite value.

    Returns
    -------
    Histogram
        Its result has ``value``, the fraction of runs in each bin, its standard ``error``, the number of ``lanes`` in
        each bin, their ``count`` in all, and with ``range`` the numbers of lanes ``below`` and ``above`` it. The
        dimension is ``bin``, with its ends ``left`` and ``right``.

    Raises
    ------
    SimulationError
        If the text is no number of a whole run, or bins or bounds make no histogram.

    Examples
    --------
    >>> import freebody as fb, numpy as np
    >>> h = fb.histogram("final(energy)", bins=4)
    >>> data = h.result(h.of({"final(energy)": np.array([0.1, 0.2, 0.9, 1.6])}, lanes=np.arange(4)))
    >>> data.left.values, data.lanes.values
    (array([0. , 0.5, 1. , 1.5]), array([2, 1, 0, 1]))
    """
    if type(bins) is not int or not 1 <= bins <= 1 << 16:
        raise SimulationError(f"Expected from 1 to 65536 for bins= of histogram, got {shown(bins)}.")
    bounds = None
    if range is None and bins == 1:  # 0 is between two bins of any width
        raise SimulationError("Expected at least 2 bins for a histogram without range=, got bins=1.")
    if range is not None:
        try:
            low, high = map(float, range)
        except (TypeError, ValueError):
            low = high = math.nan
        if not (low < high and math.isfinite(high - low)):
            raise SimulationError(
                f"Expected two rising numbers for range= of histogram, such as (0, 1), got {shown(range)}."
            )
        if (np.diff(np.linspace(low, high, bins + 1)) <= 0).any():
            raise SimulationError(
                f"Expected a range= of histogram that is wide enough for {bins} bins of floats, got {shown(range)}. "
                "Take fewer bins, or leave out range=."
            )
        bounds = low, high
    return Histogram(
        **numbers_of([what], "histogram", by),
        skipped=is_skipped(missing, "histogram"),
        bins=bins,
        range=bounds,
    )


@dataclass(frozen=True, eq=False)
class Bins:
    """Numbers of lanes in bins between fixed bounds; first those below, last those above."""

    lanes: NDArray[np.int64]

    @property
    def count(self) -> int:
        """Number of lanes."""
        return int(self.lanes.sum())

    def merge(self, other: Bins) -> Bins:
        """Return the numbers of the lanes of both."""
        return Bins(self.lanes + other.lanes)


@dataclass(frozen=True, eq=False)
class BinaryBins:
    """Numbers of lanes in bins of width 2^k.

    ``bins``            greatest number of bins
    ``least, greatest`` of the values
    ``first``           number j of the first bin
    ``lanes``           number of lanes in each
    """

    bins: int
    least: float
    greatest: float
    k: int
    first: int
    lanes: NDArray[np.int64]

    @property
    def count(self) -> int:
        """Number of lanes."""
        return int(self.lanes.sum())

    def merge(self, other: BinaryBins) -> BinaryBins:
        """Return the numbers of the lanes of both."""
        least, greatest = min(self.least, other.least), max(self.greatest, other.greatest)
        k = _width(least, greatest, self.bins)
        first = int(_bin(least, k))
        lanes = np.zeros(int(_bin(greatest, k)) - first + 1, dtype=np.int64)
        for x in (self, other):
            lanes += x.wider(k, first, len(lanes))
        return BinaryBins(self.bins, least, greatest, k, first, lanes)

    def wider(self, k: int, first: int, count: int) -> NDArray[np.int64]:
        """Return the lanes in ``count`` bins of width 2^k from number ``first`` on."""
        # 2^53 is the greatest number of a bin
        places = (self.first + np.arange(len(self.lanes))) >> min(k - self.k, 63)
        result = np.zeros(count, dtype=np.int64)
        np.add.at(result, places - first, self.lanes)
        return result


@dataclass(frozen=True)
class NoBins:
    """State without lanes."""

    count: int = 0

    def merge(self, other: Any) -> Any:
        """Return the other state."""
        return other


def _bin(x: Any, k: int) -> Any:
    """Return the number of the bin of width 2^k, as a float."""
    scaled = np.ldexp(x, -k)  # exact but for underflow, which changes the bin of negative numbers only
    return np.where((scaled == 0) & (np.asarray(x) < 0), -1.0, np.floor(scaled))


def _width(least: float, greatest: float, bins: int) -> int:
    """Return the least k for bins of width 2^k, at least the distance of floats at the greatest magnitude."""
    magnitude = max(abs(least), abs(greatest))
    k = max(_SMALLEST, math.frexp(magnitude)[1] - 53) if magnitude else _SMALLEST
    half = greatest / 2 - least / 2
    if half > 0:  # at this k there are more than 2 ``bins`` bins
        k = max(k, math.frexp(half)[1] - bins.bit_length() - 2)
    while int(_bin(greatest, k)) - int(_bin(least, k)) >= bins:
        k += 1
    return k


@dataclass(frozen=True, repr=False)
class Histogram(Reducer):
    """Histogram of a number. Made by :func:`histogram`."""

    title: ClassVar[str] = "histogram"
    bins: int = field(kw_only=True)
    range: tuple[float, float] | None = field(kw_only=True)

    def options(self) -> list[str]:
        """Return the other arguments, as in a call."""
        return [str(self.bins), *([f"range={self.range}"] if self.range else [])]

    @property
    def entries(self) -> int:
        """Greatest number of entries of the state of one group."""
        return self.bins

    def part(self, values: list[Array], lanes: Any, weighted: bool) -> Bins | BinaryBins | NoBins:
        """Return the numbers of the lanes of one group."""
        x = values[0]
        if self.range:
            edges = np.linspace(*self.range, self.bins + 1)
            places = np.searchsorted(edges, x, side="right")
            places[x == edges[-1]] = self.bins
            return Bins(np.bincount(places, minlength=self.bins + 2).astype(np.int64))
        if not len(x):
            return NoBins()
        least, greatest = float(x.min()) + 0.0, float(x.max()) + 0.0
        k = _width(least, greatest, self.bins)
        first = int(_bin(least, k))
        places = (_bin(x, k) - first).astype(np.int64)
        counts = np.bincount(places, minlength=int(_bin(greatest, k)) - first + 1).astype(np.int64)
        return BinaryBins(self.bins, least, greatest, k, first, counts)

    def variables(self, parts: list[Any]) -> tuple[dict[str, Variable], dict[str, Any]]:
        """Return fractions, errors and numbers of lanes, and the bounds of the bins."""
        n = np.array([part.count for part in parts], dtype=np.int64)
        outside: dict[str, Variable] = {}
        if self.range:
            edges = np.linspace(*self.range, self.bins + 1)
            table = np.array([part.lanes for part in parts], dtype=np.int64).reshape(-1, self.bins + 2)
            outside = {
                "below": ((), table[:, 0], {"long_name": "runs below the bins"}),
                "above": ((), table[:, -1], {"long_name": "runs above the bins"}),
            }
            table = table[:, 1:-1]
        else:
            edges, table = _common(parts, self.bins)
        size = np.maximum(n, 1)[:, None]
        p = np.where(n[:, None] > 0, table / size, np.nan)
        error = np.where(n[:, None] > 1, np.sqrt(p * (1 - p) / np.maximum(size - 1, 1)), np.nan)
        result: dict[str, Variable] = {
            "value": (("bin",), p, {"long_name": f"fraction of runs by {self.numbers[0].text}"}),
            "error": (("bin",), error, {"long_name": "standard error"}),
            "lanes": (("bin",), table, {"long_name": "runs in each bin"}),
            "count": ((), n, {"long_name": "runs"}),
            **outside,
        }
        ends: dict[str, Any] = {"left": (("bin",), edges[:-1], {}), "right": (("bin",), edges[1:], {})}
        return result, ends


def _common(parts: Sequence[BinaryBins | NoBins], bins: int) -> tuple[Any, Any]:
    """Return the bounds of bins that all groups share, and the lanes of each group."""
    full = [part for part in parts if isinstance(part, BinaryBins)]
    if not full:
        return np.zeros(1), np.zeros((len(parts), 0), dtype=np.int64)
    least, greatest = min(part.least for part in full), max(part.greatest for part in full)
    k = _width(least, greatest, bins)
    first = int(_bin(least, k))
    count = int(_bin(greatest, k)) - first + 1
    with np.errstate(over="ignore"):  # the upper end of the last bin may lie beyond the greatest float
        edges = np.ldexp(np.arange(first, first + count + 1, dtype=float), k)
    return edges, np.array([part.wider(k, first, count) for part in full])
