"""Motion by steps of the speeds alone, where slips begin and end faster than events tell, in compiled code."""

from __future__ import annotations

import math

from ....native.instructions import compiled, lesser
from ...cones.contacts import Contacts
from .. import event_run, limits
from ..event_run import EventRun
from ..moment import copy, look
from .held_phases import hold_longer, hold_shorter
from .speed_step import look_halfway, step_of_speeds
from .step_modes import creep, hold_at_rest

UNCHANGED = 1e-12
"""Relative difference of all that a step of the speeds is computed from, below which its result is the same."""


@compiled
def decided_by_speeds(it: EventRun, contacts: Contacts, longest: float) -> int:
    """Pass a step of the speeds where slips begin and end faster than events tell; return 1 if it did, else 0.

    Steps that follow each other grow to twice their length, up to `LONGEST`. If contacts are at rest after it by forces
    that are open, a phase with their modes follows, to its end at the next such step.
    """
    checked = it.checking
    it.checking = 0
    again = it.leap > 0.0 and it.t - it.leapt <= 2.0 * it.leap
    length = lesser(2.0 * it.leap, limits.LONGEST) if again else limits.SHORTEST
    if checked != 0 and is_unchanged(it, length) != 0:
        hold_longer(it)
        return 1
    if length > longest or step_of_speeds(it, contacts, length) == 0:
        it.rested[0] = math.nan
        return 0
    it.leap, it.leapt, it.stage, it.hit = length, it.t, event_run.ARRIVE, 0
    if hold_at_rest(it, contacts) != 0:
        it.hold = it.hold if checked != 0 else limits.LONGEST / 4.0
        hold_longer(it)
    elif checked != 0 and it.hold > limits.LONGEST:
        hold_shorter(it, 8.0)  # contacts had begun to slip before its end
        return 1
    elif length == limits.LONGEST and creep(it, contacts) != 0:
        it.stage = event_run.SET_UP
    for k in range(it.contacts):
        if it.reason[k] == event_run.CONE_REACHED:
            it.reason[k] = event_run.NO_REASON
    return 1


@compiled
def is_unchanged(it: EventRun, length: float) -> int:
    """Return 1 if a step of the speeds is that of the last check, which found a rest, else 0."""
    rows = 2 * (it.contacts + it.rows) + it.n
    after = rows + 2 * it.rows * it.n
    copy(it.rate, it.speeds, it.rows)
    look_halfway(it, length)
    same = alike(it, 0, rows) * alike(it, after, it.seen_size - after)
    for k in range(it.contacts):
        p = it.presser[k] if it.presser[k] >= 0 else k
        if it.closed[p] != 0 or it.held[p] != 0:  # others have no part in a step
            first, size = rows + it.first[k] * it.n, (1 + it.tangents[k]) * it.n
            same *= alike(it, first, size) * alike(it, first + it.rows * it.n, size)
    copy(it.seen, it.rested, it.seen_size)
    look(it)
    return same


@compiled
def alike(it: EventRun, first: int, count: int) -> int:
    """Return 1 if so many numbers that have been seen, from this one on, are those of the last check, else 0."""
    for i in range(first, first + count):
        x, before = it.seen[i], it.rested[i]
        near = abs(x - before) <= UNCHANGED * (1.0 + abs(x))
        if x != before and not near:  # gaps and reaches may be infinite
            return 0
    return 1
