"""The contact problems of the chosen contacts of a run, in compiled code: one for each island.

An island is a set of contacts that share no speeds, and none that masses or conditions of the machine couple with
theirs, with others. What happens in one has no part in another.
"""

from __future__ import annotations

from ...native.instructions import compiled
from ..cones.block_rows import join, root_of
from ..cones.contacts import Contacts
from .event_run import EventRun
from .limits import NOISE
from .moment import copy_wholes, largest, response, row_of, slip_speed


@compiled
def apart(it: EventRun) -> None:
    """Let every block of speeds be an island."""
    for b in range(it.blocks):
        it.parent[b], it.holds[b] = b, 0


@compiled
def couple(it: EventRun, k: int) -> None:
    """Let the blocks of a contact be of one island."""
    join(it.parent, it.beside[2 * k], it.beside[2 * k + 1])


@compiled
def name_island(it: EventRun, k: int) -> None:
    """Set the island of a contact: its first block."""
    it.island[k] = root_of(it.parent, it.beside[2 * k])


@compiled
def split(it: EventRun) -> None:
    """Find the islands of the chosen contacts, which `take_island` chooses in turn."""
    apart(it)
    it.concerned_count = it.count
    copy_wholes(it.chosen, it.concerned, it.count)
    for i in range(it.count):
        couple(it, it.chosen[i])
    for i in range(it.count):
        k, place = it.chosen[i], i
        name_island(it, k)
        while place > 0 and it.island[it.members[place - 1]] > it.island[k]:
            it.members[place] = it.members[place - 1]
            place -= 1
        it.members[place] = k


@compiled
def take_island(it: EventRun, first: int) -> int:
    """Choose the contacts of the island that begins at this place of the members; return the place after them."""
    last, island = first, it.island[it.members[first]]
    while last < it.concerned_count and it.island[it.members[last]] == island:
        it.chosen[last - first] = it.members[last]
        last += 1
    it.count = last - first
    return last


@compiled
def take_all(it: EventRun) -> None:
    """Choose the contacts of all islands again."""
    copy_wholes(it.concerned, it.chosen, it.concerned_count)
    it.count = it.concerned_count


@compiled
def gather(it: EventRun, contacts: Contacts, impact: int, time: float) -> None:
    """Write the problem of the chosen contacts: of their speeds in an ``impact`` (1), else of accelerations.

    Given forces, or bounds of friction, act for a ``time``; 1 for accelerations.
    """
    m = 0
    contacts.contacts, contacts.equalities = it.count, 0
    for i in range(it.count):
        k = it.chosen[i]
        contacts.at[i], contacts.tangents[i] = m, it.tangents[k]
        speed = slip_speed(it, k)
        contacts.friction[i] = it.coefficients[4 * k if speed > it.still else 4 * k + 3]
        contacts.static[i] = it.coefficients[4 * k + 1]
        contacts.least[i], contacts.held[i], contacts.slides[i] = time * it.given[k], it.held[k], 0
        contacts.presser[i], presser = -1, it.presser[k]
        if presser >= 0 and it.held[presser] != 0:
            contacts.least[i] = time * it.given[presser]
        elif presser >= 0:
            contacts.presser[i] = place_of(it, i, presser)
        if impact != 0:
            contacts.static[i] = contacts.friction[i]
        elif speed > it.still:
            contacts.slides[i] = 1
            for j in range(it.tangents[k]):
                contacts.way[2 * i + j] = it.rate[it.first[k] + 1 + j] / speed
        for j in range(1 + it.tangents[k]):
            it.list[m] = it.first[k] + j
            m += 1
    contacts.rows = m
    for a in range(m):
        r = it.list[a]
        contacts.given[a] = it.rate[r] if impact != 0 else it.c[r]
        for b in range(a + 1):
            contacts.A[a * m + b] = contacts.A[b * m + a] = response(it, r, it.list[b])
    for i in range(it.count):
        if it.compliant[it.chosen[i]] != 0:
            press(contacts, contacts.at[i], contacts.least[i])
        elif it.held[it.chosen[i]] != 0 and impact == 0:
            if is_unloaded(it, it.chosen[i]) != 0:
                contacts.least[i] = contacts.given[contacts.at[i] + 1] = 0.0
            contacts.given[contacts.at[i]] = rate_of_bound(contacts, i)


@compiled
def is_unloaded(it: EventRun, k: int) -> int:
    """Return 1 if the bound of a joint's dry friction is round-off, and so is its acceleration without it; else 0.

    So is each joint of what falls freely from rest.
    """
    if it.held[k] == 0 or it.compliant[k] != 0 or it.tangents[k] != 1 or it.presser[k] >= 0:
        return 0
    r, size = it.first[k] + 1, 0.0
    W = row_of(it, it.W, r)
    for i in range(it.n):
        size += abs(W[i])
    noise = NOISE * size * largest(it.free, it.n)
    bound = it.coefficients[4 * k + 1] * it.given[k] * response(it, r, r)
    return 1 if abs(it.c[r]) <= noise and bound <= noise else 0


@compiled
def place_of(it: EventRun, i: int, k: int) -> int:
    """Return the place of a contact in the list, up to the place i."""
    while it.chosen[i] != k:
        i -= 1
    return i


@compiled
def press(contacts: Contacts, r: int, force: float) -> None:
    """Let a given normal force act on all rates, and be no unknown: its row and column of A are zero then.

    Its own rate, which is 0 or more as the law of contact has it, becomes the size of the parts of the acceleration:
    beside it the others are judged.
    """
    m = contacts.rows
    size = abs(contacts.given[r]) + force * contacts.A[r * m + r]
    for a in range(m):
        contacts.given[a] += force * contacts.A[a * m + r]
        contacts.A[a * m + r] = 0.0
    for a in range(m):
        contacts.A[r * m + a] = 0.0
    contacts.given[r] = size


@compiled
def rate_of_bound(contacts: Contacts, i: int) -> float:
    """Return the greatest rate that the bounded friction of a joint gives its tangent.

    It stands in its normal row, which moves nothing: beside it others are judged, where all of them vanish in balance.
    """
    r = contacts.at[i] + contacts.tangents[i]
    return contacts.static[i] * contacts.least[i] * contacts.A[r * contacts.rows + r]
