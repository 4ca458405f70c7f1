"""Blocks of lanes: as many as it takes, each of about two seconds of work."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from ...native.records import WIDTH
from .block import Report, Whole
from .schedule import Range, Workers
from .tally import Tally

SECONDS = 2.0
"""Time that a block is to take."""
LARGEST = 1 << 26
"""Most bytes of the results of a block."""
FEW = 64
"""Number of lanes that are cut without a trial."""
SHARES = 4
"""Blocks that each worker gets at least, so that all end at about the same time."""
_SHORTEST = 0.05  # seconds of a block, where few lanes are shared by many workers
_ENOUGH = 0.02  # seconds of a trial that can be measured
_TRIALS = (1, 16, 256, 4096)  # lanes


def seconds_per_lane(crew: Workers, count: int, check: Callable[[], None] = lambda: None) -> float | None:
    """Return the time that a lane takes one worker, from a trial of some lanes; None if the trial fails.

    Of each number of lanes there are two trials. The first prepares the worker and is not counted: eight lanes at once
    have code of their own.
    """
    crew.delivery = Whole()
    measured = None
    for k in range(2 * len(_TRIALS)):
        lanes = min(_TRIALS[k // 2], count)
        low = (count - lanes) * k // (2 * len(_TRIALS))
        crew.start(low, low + lanes)
        while (ended := crew.wait(1.0)) is None:
            check()
        check()
        report = ended[1]
        if not isinstance(report, Report):
            crew.renew()
            return measured
        if k % 2:
            measured = report.seconds / lanes
            if report.seconds > _ENOUGH or lanes == count:
                break
    return measured


def size_of_block(count: int, seconds: float | None, workers: int, bytes_per_lane: int) -> int:
    """Return the number of lanes of a block.

    Parameters
    ----------
    count : int
        Number of lanes of the study.
    seconds : float or None
        Time that a lane takes one worker.
    workers : int
        Number of workers.
    bytes_per_lane : int
        Size of the results of a lane.
    """
    largest = max(1, min(LARGEST // bytes_per_lane, count))
    share = -(-count // (SHARES * workers))
    if not seconds:
        return max(1, min(share, largest))
    size = min(SECONDS / seconds, max(share, _SHORTEST / seconds))
    size = int(max(1, min(size, largest)))
    return size - size % WIDTH if size > WIDTH else size


def cut(count: int, size: int) -> list[Range]:
    """Return the blocks of a study."""
    return [(low, min(low + size, count)) for low in range(0, count, size)]


def growing(
    ranges: Iterable[Range], first: int, count: int, bytes_per_lane: int, crew: Workers, tally: Tally
) -> Iterator[Range]:
    """Yield blocks of ranges of lanes: the first ones small, later ones as long as lanes before them took.

    Parameters
    ----------
    ranges : iterable of (int, int)
    first : int
        Number of lanes of the first blocks.
    count, bytes_per_lane : int
        Number of lanes of the study, and size of the results of a lane.
    crew : Workers
    tally : Tally
        Knows how long lanes took.
    """
    size = first
    for low, high in ranges:
        while low < high:
            if tally.seconds_per_lane:
                size = min(
                    4 * size, size_of_block(count, tally.seconds_per_lane, crew.workers, bytes_per_lane)
                )
            yield low, min(low + size, high)
            low += size


def ranges_within(chosen: NDArray[np.bool_], blocks: Iterable[Range]) -> Iterator[Range]:
    """Yield the ranges of lanes that are chosen, each within a block."""
    for low, high in blocks:
        edges = np.flatnonzero(np.diff(chosen[low:high], prepend=False, append=False)).tolist()
        for first, last in zip(edges[::2], edges[1::2], strict=True):
            yield low + first, low + last
