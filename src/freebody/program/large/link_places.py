"""Where the loops over links keep what only neighbours need: sums of what tips pass on, and accelerations.

A place is used again once nobody waits for what stands there, so that a chain of any length needs two of each: they
stay in the fastest cache, where a place for every link would not.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import NamedTuple

from ...model.model import GROUND


class Sums(NamedTuple):
    """Of each link, where the sum of what its tips pass on stands, where it leaves its own, and where that is added.

    ``added`` is -1 of the first that a parent gets. From ``cleared`` up to ``aside`` there must be zeros to begin
    with: first those for links without tips, then the sums that are kept.
    """

    of: list[int]
    passed: list[int]
    added: list[int]
    cleared: int
    aside: int
    end: int


def sums(parents: Sequence[int], kept: Collection[int], start: int, size: int) -> Sums:
    """Places from ``start`` on, of ``size`` numbers each, of a loop from the last link to the first.

    The sums of the links ``kept`` begin with loads and stay.
    """
    nothing, own = start, {i: start + size * (k + 1) for k, i in enumerate(kept)}
    aside = start + size * (1 + len(own))
    end = aside + size
    free: list[int] = []
    waiting = dict(own)
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
        of[i] = waiting.pop(i, nothing)
        if of[i] != nothing and i not in own:
            free.append(of[i])
    return Sums(of, passed, added, nothing, aside, end)


def accelerations(parents: Sequence[int], keep: bool, start: int) -> tuple[list[int], int]:
    """Places from ``start`` on of a loop from the first link to the last, the ground's at the end; and their end.

    An acceleration is needed up to the last of the tips; with ``keep`` it stays.
    """
    last = {parent: i for i, parent in enumerate(parents)}
    places: list[int] = []
    free: list[int] = []
    for i, parent in enumerate(parents):
        if not free:
            free.append(start)
            start += 6
        places.append(free.pop())
        if keep:
            continue
        if i not in last:
            free.append(places[i])
        if parent != GROUND and last[parent] == i:
            free.append(places[parent])
    return [*places, start], start + 6
