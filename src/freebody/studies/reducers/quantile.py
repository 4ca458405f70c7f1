"""Quantiles of a number over all runs, from a sketch that merges exactly.

The bits of a float, read as an integer, have the order of the float. A sketch counts the lanes by the first B of the
64 bits, where B is the greatest number for which at most ``buckets`` different beginnings occur. More lanes never have
fewer beginnings, so that B of all lanes does not depend on the order in which sketches merge. Few lanes keep all bits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ...errors import SimulationError, arguments_named, shown
from .intervals import CONFIDENCE, DEVIATIONS, rank_of, ranks_around
from .number import Array
from .reducer import ENTRIES, Reducer, Variable, is_skipped, numbers_of

BUCKETS = 4096
_CHUNK = 1 << 16
_SIGN = np.uint64(1 << 63)
_LARGEST = float(np.finfo(float).max)


@arguments_named
def quantile(
    what: str, q: Any, by: Any = None, *, buckets: int = BUCKETS, missing: str = "raise"
) -> Quantile:
    """Return the reducer for quantiles of a number over all runs.

        x_q = the least value x of a run for which at least q n runs have a value <= x

    Up to ``buckets`` different values are kept as they are: the quantiles are then those of ``numpy.quantile(...,
    method="inverted_cdf")``. Beyond, values are counted in buckets, whose width relative to the value is at most about
    2 k / ``buckets`` where the values lie within a factor 2^k. The result states the bucket.

    Parameters
    ----------
    what : str
        Number of a whole run, as in :func:`freebody.mean`.
    q : number or sequence of numbers
        Probabilities from 0 to 1.
    by : str or sequence of str, optional
        Numbers whose distinct values are groups.
    buckets : int, optional
        Greatest number of buckets, from 16 to 65536.
    missing : {"raise", "skip"}, optional
        Meaning of a run in which the number has no finite value.

    Returns
    -------
    Quantile
        Its result has ``value``, within the bucket from ``lower`` to ``upper`` by linear interpolation; ``low`` and
        ``high``, the ends of an interval of 95 % by order statistics, widened to whole buckets, infinite where there
        are too few runs; ``error``, their distance over 2·1.96; and ``count``. The dimension is ``quantile``.

    Raises
    ------
    SimulationError
        If the text is no number of a whole run, or a probability is not between 0 and 1.

    Examples
    --------
    >>> import freebody as fb, numpy as np
    >>> q = fb.quantile("max(theta)", [0.5, 0.9])
    >>> data = q.result(q.of({"max(theta)": np.arange(1000.0)}, lanes=np.arange(1000)))
    >>> data.value.values, data.low.values
    (array([499., 899.]), array([468., 880.]))
    """
    try:
        probabilities = np.array(q, dtype=float)
    except (TypeError, ValueError):
        probabilities = np.array([np.nan])
    within = (probabilities >= 0) & (probabilities <= 1)
    if probabilities.ndim > 1 or not probabilities.size or not within.all():
        raise SimulationError(f"Expected probabilities from 0 to 1 for q= of quantile, got {shown(q)}.")
    if type(buckets) is not int or not 16 <= buckets <= 1 << 16:
        raise SimulationError(f"Expected from 16 to 65536 for buckets= of quantile, got {shown(buckets)}.")
    values = probabilities.tolist()
    return Quantile(
        **numbers_of([what], "quantile", by), skipped=is_skipped(missing, "quantile"),
        probabilities=tuple(values) if isinstance(values, list) else values, buckets=buckets,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Sketch:
    """Numbers of lanes by the first ``bits`` bits of a float.

    ``beginnings``  the bits that occur, rising
    ``lanes``       number of lanes of each
    """

    buckets: int
    bits: int
    beginnings: NDArray[np.uint64]
    lanes: NDArray[np.int64]

    @property
    def count(self) -> int:
        """Number of lanes."""
        return int(self.lanes.sum())

    def merge(self, other: Sketch) -> Sketch:
        """Return the sketch of the lanes of both."""
        bits = min(self.bits, other.bits)
        beginnings = np.concatenate([_cut(x.beginnings, x.bits - bits) for x in (self, other)])
        return _sketch(self.buckets, bits, beginnings, np.concatenate([self.lanes, other.lanes]))

    def place(self, rank: int) -> int:
        """Return the place of the bucket that holds the value of a rank, from 1 to n."""
        return int(np.searchsorted(np.cumsum(self.lanes), rank))

    def value(self, rank: int) -> float:
        """Return the value of a rank, as if the lanes of its bucket were evenly distributed over it."""
        place = self.place(rank)
        lower, upper = self.bounds(rank)
        before = int(self.lanes[:place].sum())
        return lower + (rank - before - 0.5) / int(self.lanes[place]) * (upper - lower)

    def bounds(self, rank: int) -> tuple[float, float]:
        """Return the bounds of the bucket that holds the value of a rank, from 1 to n."""
        first = int(self.beginnings[self.place(rank)])
        rest = 64 - self.bits
        keys = np.array([first << rest, ((first + 1) << rest) - 1], dtype=np.uint64)
        low, high = np.where(keys & _SIGN, keys ^ _SIGN, ~keys).view(np.float64).tolist()
        # the outermost buckets hold bits of no number
        return (low if low > -_LARGEST else -_LARGEST), (high if high < _LARGEST else _LARGEST)


def _cut(beginnings: NDArray[np.uint64], bits: int) -> NDArray[np.uint64]:
    """Return beginnings shorter by some bits; 4 are always left, since there are at least 16 buckets."""
    return beginnings >> np.uint64(bits)


def _sketch(
    buckets: int, bits: int, beginnings: NDArray[np.uint64], lanes: NDArray[np.int64] | None
) -> Sketch:
    """Return the sketch of beginnings, in any order, with the number of lanes of each or one."""
    if lanes is None:
        beginnings = np.sort(beginnings)
    else:
        order = np.argsort(beginnings)
        beginnings, lanes = beginnings[order], lanes[order]
    differences = beginnings[1:] ^ beginnings[:-1]
    places = np.flatnonzero(differences)
    if len(places) >= buckets:
        # distance of the first different bit from the last bit; cutting c bits keeps differences of length > c
        lengths = _length(differences[places])
        longer = len(places) - np.cumsum(np.bincount(lengths, minlength=65))
        cut = int(np.argmax(longer < buckets))
        beginnings, bits = _cut(beginnings, cut), bits - cut
        places = places[lengths > cut]
    starts = np.concatenate([[0], places + 1]) if len(beginnings) else np.zeros(0, dtype=np.int64)
    if lanes is None:
        counts = np.diff(starts, append=len(beginnings))
    else:
        counts = np.add.reduceat(lanes, starts) if len(starts) else lanes
    return Sketch(buckets, bits, beginnings[starts], counts.astype(np.int64))


def _length(x: NDArray[np.uint64]) -> NDArray[np.int64]:
    """Return the number of bits of each integer, without leading zeros."""
    high = (x >> np.uint64(32)).astype(np.float64)  # floats hold 32 bits exactly
    low = (x & np.uint64(0xFFFFFFFF)).astype(np.float64)
    return np.where(high > 0, np.frexp(high)[1] + 32, np.frexp(low)[1]).astype(np.int64)


@dataclass(frozen=True, repr=False)
class Quantile(Reducer):
    """Quantiles of a number. Made by :func:`quantile`."""

    title: ClassVar[str] = "quantile"
    probabilities: float | tuple[float, ...] = field(kw_only=True)
    buckets: int = field(kw_only=True)

    def options(self) -> list[str]:
        """Return the other arguments, as in a call."""
        q = self.probabilities
        more = [] if self.buckets == BUCKETS else [f"buckets={self.buckets}"]
        return [str(list(q) if isinstance(q, tuple) else q), *more]

    @property
    def entries(self) -> int:
        """Greatest number of entries of the state of one group."""
        return min(self.buckets, ENTRIES)

    def part(self, values: list[Array], lanes: Any, weighted: bool) -> Sketch:
        """Return the sketch of the lanes of one group."""
        keys = (values[0] + 0.0).view(np.uint64)  # -0.0 + 0.0 = 0.0
        keys = np.where(keys & _SIGN, ~keys, keys | _SIGN)
        result = _sketch(self.buckets, 64, keys[:_CHUNK], None)
        for low in range(_CHUNK, len(keys), _CHUNK):
            chunk = _cut(keys[low : low + _CHUNK], 64 - result.bits)
            result = result.merge(_sketch(self.buckets, result.bits, chunk, None))
        return result

    def variables(self, parts: list[Sketch]) -> tuple[dict[str, Variable], dict[str, Any]]:
        """Return value, error, count, the bucket, and the interval by order statistics."""
        q = self.probabilities
        several = isinstance(q, tuple)
        qs: Sequence[float] = q if isinstance(q, tuple) else (q,)
        table = np.array([[_statistics(part, x) for x in qs] for part in parts]).reshape(
            len(parts), len(qs), 6
        )
        if not several:
            table = table[:, 0]
        dims = ("quantile",) if several else ()
        interval = {
            "long_name": f"interval of {CONFIDENCE:.0%} by order statistics",
            "confidence": CONFIDENCE,
        }
        about: dict[str, dict[str, Any]] = {
            "value": {"long_name": f"quantile of {self.numbers[0].text}"},
            "error": {"long_name": "width of the interval, in the unit of a standard error"},
            "lower": {"long_name": "lower end of the bucket that holds the quantile of the runs"},
            "upper": {"long_name": "upper end of the bucket that holds the quantile of the runs"},
            "low": interval,
            "high": interval,
        }
        result: dict[str, Variable] = {
            name: (dims, table[..., i], text) for i, (name, text) in enumerate(about.items())
        }
        counts = np.array([part.count for part in parts], dtype=np.int64)
        result["count"] = ((), counts, {"long_name": "runs"})
        return result, {"quantile": (("quantile",), np.array(qs), {})} if several else {
            "quantile": ((), qs[0], {})
        }


def _statistics(part: Sketch, q: float) -> tuple[float, ...]:
    """Return value, error, bounds of the bucket, bounds of the interval."""
    n = part.count
    if not n:
        return (np.nan,) * 6
    lower, upper = part.bounds(rank_of(q, n))
    first, last = ranks_around(q, n)
    low = part.bounds(first)[0] if first > 0 else -np.inf
    high = part.bounds(last)[1] if last <= n else np.inf
    return part.value(rank_of(q, n)), (high / 2 - low / 2) / DEVIATIONS, lower, upper, low, high
