"""Blocks of speeds that masses, and conditions of the machine, couple."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from ....model import Model


class SpeedBlocks(NamedTuple):
    """Blocks of speeds that follow each other, each coupled in itself by masses and conditions of the machine.

    ``starts``     first speed of each block, and their number
    ``contacts``   the two blocks that a contact has speeds of, twice the same if there is one
    ``own``        block of each active condition of the machine
    """

    starts: tuple[int, ...]
    contacts: tuple[tuple[int, int], ...]
    own: tuple[int, ...]


def coupled_speeds(n: int, coupled: Sequence[Sequence[int]]) -> list[list[int]]:
    """Return the speeds of each set that these couple, in their order."""
    root = list(range(n))

    def find(i: int) -> int:
        while root[i] != i:
            i = root[i]
        return i

    for group in coupled:
        for a, b in pairwise(group):
            i, j = sorted((find(a), find(b)))
            root[j] = i
    members: dict[int, list[int]] = {}
    for i in range(n):
        members.setdefault(find(i), []).append(i)
    return list(members.values())


def speeds_inward(model: Model) -> list[list[int]]:
    """Return the speeds that move each link: a body of a family has its row over the whole of their blocks."""
    result: list[list[int]] = []
    for link in model.links:
        own = [j for j, _ in link.partials]
        if link.u >= 0:
            own = list(range(link.u, link.u + (link.n_speeds)))
        result.append(own + (result[link.parent] if link.parent >= 0 else []))
    return result


def speed_blocks(
    n: int, coupled: Sequence[Sequence[int]], contacts: Sequence[Sequence[int]], own: Sequence[Sequence[int]]
) -> SpeedBlocks:
    """Return the blocks of speeds of which M couples some, for those of all rows of each contact and own condition.

    Speeds between those of a block are of it, and so are those of a contact with speeds of more than two.
    """
    coupled = [*coupled, *own]
    for _ in range(2):
        for group in coupled_speeds(n, coupled):
            coupled.append(range(group[0], group[-1] + 1))
        block = {j: k for k, group in enumerate(coupled_speeds(n, coupled)) for j in group}
        over = [sorted({block[j] for j in speeds}) or [0] for speeds in contacts]
        coupled += [speeds for speeds, found in zip(contacts, over, strict=True) if len(found) > 2]
    starts = [group[0] for group in coupled_speeds(n, coupled)]
    return SpeedBlocks(
        (*starts, n),
        tuple((found[0], found[-1]) for found in over),
        tuple(block[speeds[0]] if speeds else 0 for speeds in own),
    )
