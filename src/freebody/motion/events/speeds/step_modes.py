"""The modes that a step of the speeds leaves: of rests by open forces, and of slips that creep, in compiled code."""

from __future__ import annotations

import math

from ....native.instructions import compiled, lesser
from ...cones.contacts import ACCEPTED, Contacts
from ...phase import laws
from ...phase.phase_record import PhaseData
from .. import limits
from ..event_run import EventRun
from ..moment import approaches, copy_wholes, is_smooth, presses, size_of, slip_speed
from ..setting import depends, listed, set_up
from ..shares import find_shared, forces_decide, has_forces, leave_pulling, opened
from .open_cones import are_near_cones, beyond_cones
from .speed_step import presses_in_step, rests_in_step, step_of_speeds

CREPT = 10.0
"""Part of the speed of a slip that creeps at which it ends."""


@compiled
def hold_at_rest(it: EventRun, contacts: Contacts) -> int:
    """Set the modes of the step that has been passed if no contact slips slowly after it; return 1, or 0."""
    copy_wholes(it.mode, it.before, it.contacts)
    if are_at_rest(it, contacts) != 0:
        copy_wholes(it.mode, it.decided, it.contacts)
        leave_pulling(it, contacts)
        if beyond_cones(it, -limits.SMALL, 0) != 0:
            stay_at_limits(it, contacts)
        elif are_near_cones(it, -limits.SMALL, 0) != 0:
            stay_closed(it, contacts)
        return 1
    copy_wholes(it.before, it.mode, it.contacts)  # a phase that was held too long is passed again with them
    it.rested[0] = math.nan
    return 0


@compiled
def creep(it: EventRun, contacts: Contacts) -> int:
    """Set the modes of steps that have gone on with slips in space slower than `slowest`; return 1 if there are any.

    A slip that stops takes a part of such a step. What is left moves with the machine, as feet do that cannot all stay
    in place while their legs turn: friction has the direction of a speed of 1e-9 m/s, and follows the load. The last
    step is a short one, since its mean rows leave its length times such changes in the speeds.
    """
    least = it.slowest
    for k in range(it.contacts):
        if it.closed[k] != 0 and it.tangents[k] == 2 and not is_smooth(it, k):
            v = slip_speed(it, k)
            least = lesser(least, v) if v > it.still else least
    if least == it.slowest or it.refuse != 0:
        return 0
    copy_wholes(it.mode, it.before, it.contacts)
    if step_of_speeds(it, contacts, limits.BRIEF) == 0 or modes_of_step(it, contacts) < 0:
        copy_wholes(it.before, it.mode, it.contacts)
        return 0
    open_pulling(it, contacts)
    PhaseData(it.phase).stopped, it.creeping = least / CREPT, 1
    return 1


@compiled
def open_pulling(it: EventRun, contacts: Contacts) -> None:
    """Open the contacts that have pressed in a step, since they approached, and pull after it."""
    set_up(it, contacts)
    while has_forces(it) != 0 and opened(it) >= 0:
        set_up(it, contacts)


@compiled
def are_at_rest(it: EventRun, contacts: Contacts) -> int:
    """Set the modes of the step that has been passed; return 1 if contacts are at rest, and none slips slowly, else 0.

    Forces beyond their cone by F give a body of mass m the speed F h/m, far below a slip, so contacts are at rest whose
    speeds in the problem are its round-off.
    """
    if it.refuse != 0 or slow_slips(it) > 0 or approaches(it) != 0:
        return 0
    return 1 if modes_of_step(it, contacts) > 0 and begin_at_limits(it, contacts) != 0 else 0


@compiled
def modes_of_step(it: EventRun, contacts: Contacts) -> int:
    """Set the modes of the step that has been passed; return 1 if contacts are at rest by forces that may be open, 0 if
    none is, and -1 if a slip begins in it.

    A slip that begins has no direction yet. A contact that rests alone in a plane has a force that events follow.
    """
    found = 0
    for k in range(it.contacts):
        it.mode[k], it.way[k, 0], it.way[k, 1] = laws.OPEN, 0.0, 0.0
    for i in range(it.count):
        k = it.chosen[i]
        p = contacts.presser[i] if contacts.presser[i] >= 0 else i
        closed = it.held[k] != 0 or it.closed[it.chosen[p]] != 0
        if closed and presses_in_step(it, contacts, i) != 0:
            n = it.tangents[k]
            rests = slip_speed(it, k) <= it.still and rests_in_step(it, contacts, i) != 0
            it.mode[k] = laws.STICK if rests else laws.SLIDE
            if it.mode[k] == laws.SLIDE and it.rough[k] != 0:
                if is_smooth(it, k):
                    it.mode[k] = laws.SMOOTH
                elif slip_speed(it, k) <= it.still:
                    return -1
                elif n == 1:
                    it.mode[k] = laws.SLIDE_BACK if it.rate[it.first[k] + 1] < 0.0 else laws.SLIDE_ON
            if rests:
                found += 1 if n == 1 and it.held[k] == 0 else 2
    return 1 if found > 1 else 0


@compiled
def begin_at_limits(it: EventRun, contacts: Contacts) -> int:
    """Let contacts at rest slip that are at their limits by forces that are not open; return 0 if one has no direction.

    A slip that begins is too slow for a step of 0.1 µs to tell it from rest.
    """
    find_shared(it, contacts)
    for i in range(it.count):
        k, at, n = it.chosen[i], contacts.at[i], contacts.tangents[i]
        if it.mode[k] == laws.STICK and it.shared[k] == 0:
            limit = contacts.static[i] * contacts.forces[at]
            if limit > 0.0 and limit - size_of(contacts.forces[at + 1 :], n) <= ACCEPTED * limit:
                if n > 1:
                    return 0
                it.mode[k] = laws.SLIDE_BACK if contacts.forces[at + 1] > 0.0 else laws.SLIDE_ON
    return 1


@compiled
def stay_at_limits(it: EventRun, contacts: Contacts) -> None:
    """Let what is at rest at its limit in the step stay there, of contacts in space and of joints, where equal shares
    would be beyond cones.

    The others hold them; their forces decide the motion, as where a ball that is clamped spins at a third contact.
    """
    copy_wholes(it.mode, it.before, it.contacts)
    for i in range(it.count):
        k, at, n = it.chosen[i], contacts.at[i], contacts.tangents[i]
        limit = contacts.static[i] * contacts.forces[at]
        friction = size_of(contacts.forces[at + 1 :], n)
        stays = it.mode[k] == laws.STICK and (n > 1 or it.held[k] != 0)
        if stays and limit > 0.0 and limit - friction <= ACCEPTED * limit:
            for j in range(n):
                it.way[k, j] = -contacts.forces[at + 1 + j] / friction
            it.mode[k] = laws.LIMIT
            if n == 1:
                it.mode[k] = laws.SLIDE_BACK if it.way[k, 0] < 0.0 else laws.SLIDE_ON
    set_up(it, contacts)
    if beyond_cones(it, -limits.SMALL, 0) != 0 or are_held(it, contacts) == 0:
        copy_wholes(it.before, it.mode, it.contacts)
        set_up(it, contacts)


@compiled
def stay_closed(it: EventRun, contacts: Contacts) -> None:
    """Keep the modes of the step where forces that are not open any more, as what pulled has opened, are beyond cones.

    Open forces that do not decide the motion are within the laws at other shares: those of the step.
    """
    copy_wholes(it.mode, it.before, it.contacts)
    copy_wholes(it.decided, it.mode, it.contacts)
    set_up(it, contacts)
    if it.spare_count == 0 or forces_decide(it, contacts) != 0:
        copy_wholes(it.before, it.mode, it.contacts)
        set_up(it, contacts)


@compiled
def are_held(it: EventRun, contacts: Contacts) -> int:
    """Return 1 if the others hold the contacts that have been put to their limits, else 0."""
    count = listed(it)
    for k in range(it.contacts):
        if it.mode[k] != it.before[k]:
            for j in range(it.tangents[k]):
                if depends(it, contacts, it.first[k] + 1 + j, count) == 0:
                    return 0
    return 1


@compiled
def slow_slips(it: EventRun) -> int:
    """Return the number of slips in space of closed contacts below `SLOW`."""
    found = 0
    for k in range(it.contacts):
        touches = it.closed[k] != 0 or (it.compliant[k] != 0 and presses(it, k) != 0)
        if touches and it.tangents[k] == 2 and it.still < slip_speed(it, k) <= limits.SLOW:
            found += 1
    return found
