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
    copy(it.rate, it.speeds, it.rows)
    look_halfway(it, length)
    same = 1
    for i in range(it.seen_size):
        # gaps and reaches may be infinite
        if it.seen[i] != it.rested[i] and not abs(it.seen[i] - it.rested[i]) <= UNCHANGED * (
            1.0 + abs(it.seen[i])
        ):
            same = 0
    copy(it.seen, it.rested, it.seen_size)
    look(it)
    return same
