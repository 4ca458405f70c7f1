"""Places of the numbers that only neighbouring links need: sums of the loads that tips pass on, and accelerations.

A place is reused once its number is no longer needed. A chain of any length then needs two places of each sort, which
stay in the fastest cache; a place for every link would not.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import NamedTuple

from ...model.model import GROUND


class Sums(NamedTuple):
    """Places of sums for each link: the sum over its tips, its own contribution, and the sum to which that is added.

    ``added`` is -1 for the first contribution that a parent receives. The places from ``cleared`` up to ``aside`` must
    be zero at first: the sum of links without tips, then the sums that are kept.
    """

    of: list[int]
    passed: list[int]
    added: list[int]
    cleared: int
    aside: int
    end: int


def sums(parents: Sequence[int], kept: Collection[int], start: int, size: int) -> Sums:
    """Places from ``start`` on, of ``size`` numbers each, for a loop from the last link to the first.

    The sums of the links ``kept`` begin with loads and keep their places.
    """
    empty, permanent = start, {i: start + size * (k + 1) for k, i in enumerate(kept)}
    aside = start + size * (1 + len(permanent))
    end = aside + size
    free: list[int] = []
    waiting = dict(permanent)
    of, passed, added = ([-1] * len(parents) for _ in range(3))
    for i in range(len(parents) - 1, -1, -1):
        parent = parents[i]
        passed[i] = aside
        if parent in waiting:
            added[i] = waiting[parent]
        elif parent != GROUND:
            if not free:
                free.append(end)
                end += size
            passed[i] = waiting[parent] = free.pop()
        of[i] = waiting.pop(i, empty)
        if of[i] != empty and i not in permanent:
            free.append(of[i])
    return Sums(of, passed, added, empty, aside, end)


def accelerations(parents: Sequence[int], keep: bool, start: int, size: int = 6) -> tuple[list[int], int]:
    """Return places from ``start`` on for a loop from the first link to the last, the ground's last, and their end.

    Each has ``size`` numbers, of which the first six are the acceleration.

    An acceleration is needed up to the last tip of its link; with ``keep`` it keeps its place.
    """
    last = {parent: i for i, parent in enumerate(parents)}
    places: list[int] = []
    free: list[int] = []
    for i, parent in enumerate(parents):
        if not free:
            free.append(start)
            start += size
        places.append(free.pop())
        if keep:
            continue
        if i not in last:
            free.append(places[i])
        if parent != GROUND and last[parent] == i:
            free.append(places[parent])
    return [*places, start], start + size
