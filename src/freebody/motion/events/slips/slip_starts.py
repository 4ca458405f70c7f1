"""The first moments of slips in space, which begin at speed zero, where they have no direction, in compiled code."""

from __future__ import annotations

from ....native.instructions import compiled, greater, lesser, root
from ...cones.block_rows import dot
from ...cones.contacts import Contacts
from ...phase import laws
from .. import limits
from ..event_run import EventRun
from ..impulse_system import add_row, impelled, move_speeds
from ..moment import (
    acceleration_of,
    add_responses,
    approaches,
    copy,
    is_smooth,
    largest,
    look,
    response,
    row_of,
    set_response,
    slip_speed,
)
from ..setting import begins_slip, leaves_rest, project, set_up
from .straight_steps import UPSET, go_straight, log_leap, upset

FIRM = 100.0
"""Multiple of the speed of a slip that begins at which the rest of the machine may move by that."""


@compiled
def pull(it: EventRun) -> float:
    """Return the least tangential acceleration of slips that begin at rest; -1 if none begins."""
    result = -1.0
    for k in range(it.contacts):
        if begins_slip(it, k) != 0:
            size = slip_acceleration(it, k)
            result = size if result < 0.0 else lesser(result, size)
    return result


@compiled
def slip_acceleration(it: EventRun, k: int) -> float:
    """Return the tangential acceleration of a contact under the forces of the decision."""
    square = 0.0
    set_response(it, it.force)
    for j in range(it.tangents[k]):
        a = acceleration_of(it, it.first[k] + 1 + j)
        square += a * a
    return root(square)


@compiled
def scale_of(it: EventRun) -> float:
    """Return the greatest acceleration of a contact without contact forces.

    That of the lowest point of a disk that lies flat, which is no contact, has no limit.
    """
    result = 0.0
    for k in range(it.contacts):
        if it.mode[k] != laws.OPEN or is_rim(it, k) == 0:
            result = greater(result, largest(it.c[it.first[k] :], 1 + it.tangents[k]))
    return result


@compiled
def is_rim(it: EventRun, k: int) -> int:
    """Return 1 if a contact is that of the lowest point of a disk, whose points are contacts where it lies flat."""
    for i in range(it.rings):
        if it.ring_edge[i] == k:
            return 1
    return 0


@compiled
def nudged(it: EventRun, contacts: Contacts, alone: int) -> int:
    """Find impulses that give slips which begin the speed `NUDGE`; return 0 if other contacts prevent it, else 1.

    ``alone`` is the contact to which they give it while other slips that begin are free, or -1 for all.
    """
    count = 0
    for k in range(it.contacts):
        if it.mode[k] != laws.OPEN:
            begins = leaves_rest(it, k)
            goes = begins != 0 and (alone < 0 or alone == k)
            if it.held[k] == 0:
                count = add_row(it, count, it.first[k], 0.0)
            if it.mode[k] == laws.STICK or it.mode[k] == laws.LIMIT or goes:
                for j in range(it.tangents[k]):
                    goal = limits.NUDGE * it.way[k, j] if goes else 0.0
                    count = add_row(it, count, it.first[k] + 1 + j, goal)
    return 1 if impelled(it, contacts, count) <= 1e-3 * limits.NUDGE else 0


@compiled
def is_gentle(it: EventRun) -> int:
    """Return 1 if the impulses that nudge slips change little else, 0 if the machine would be hit by them.

    Where other contacts nearly hold the one that slips, it slips at a part of the speed of the machine, and by a nudge
    that would have to be a multiple of it. Other slow slips must keep their directions.
    """
    work, alone = 0.0, 0.0
    for k in range(it.contacts):
        if leaves_rest(it, k) != 0:
            for j in range(it.tangents[k]):
                r, goal = it.first[k] + 1 + j, limits.NUDGE * it.way[k, j]
                work += it.whole[r] * goal
                alone += goal * goal / response(it, r, r) if goal != 0.0 else 0.0
    if work > FIRM * FIRM * alone:
        return 0
    set_response(it, it.whole)
    for k in range(it.contacts):
        for j in range(1 + it.tangents[k] if it.mode[k] != laws.OPEN else 0):
            r = it.first[k] + j
            it.speeds[r] = dot(row_of(it, it.W, r), it.v, it.n)
    return 1 - upset(it, -1, 1.0)


@compiled
def begin_slip(it: EventRun, contacts: Contacts, end: float, longest: float, whole: int) -> int:
    """Pass the first moment of a slip in space that begins at rest; return 1 if the state has changed, else 0.

    This moment is a straight step of at most ``longest`` that gives the slip a direction. It ends before where a
    contact closes. Return -1 if the others prevent the slip in the direction of its acceleration, or would move by it,
    and `UPSET` if other slow slips would turn within the step, and ``whole`` is not 0.
    """
    least = pull(it)
    if least < 0.0:
        return 0
    n_q, n = it.n_q, it.n
    if least <= limits.SMALL * scale_of(it) or least * longest < 4.0 * laws.STOPPED:
        if nudged(it, contacts, -1) == 0 or is_gentle(it) == 0:
            return -1
        work = it.impulses
        move_speeds(it)
        it.impulses = work
        look(it)
        return 1
    length = lesser(greater(4.0 * laws.STOPPED / least, 1e-9), end - it.t)
    if whole != 0:
        set_response(it, it.force)
        for k in range(it.contacts):
            for j in range(1 + it.tangents[k] if it.mode[k] != laws.OPEN else 0):
                it.speeds[it.first[k] + j] = acceleration_of(it, it.first[k] + j)
        if upset(it, -1, length) != 0:
            return UPSET
    copy(it.y, it.start, it.n_y)
    copy(it.free, it.step[n_q:], n)
    add_responses(it, it.force, it.step[n_q:])
    begun = it.t
    length = go_straight(it, length)
    if approaches(it) == 0:  # else the impact comes first
        set_up(it, contacts)
        project(it)
    it.rates(it.t, it.y, it.phase, it.step)
    for i in range(it.n_q + it.n, it.n_y):  # work and heat, of loads and of contacts that slip already
        it.y[i] += length * it.step[i]
    look(it)
    log_leap(it, begun, length)
    return 1


@compiled
def shortest_turn(it: EventRun) -> float:
    """Return the shortest time in which friction turns a slip in space that has just begun, v/a, or 0 without one."""
    result, a = 0.0, scale_of(it)
    for k in range(it.contacts):
        v, slides = slip_speed(it, k), it.mode[k] == laws.SLIDE and it.tangents[k] == 2
        if slides and it.still < v <= limits.SLOW and a > 0.0 and not is_smooth(it, k):
            result = lesser(result, v / a) if result > 0.0 else v / a
    return result


@compiled
def turned_over(it: EventRun) -> int:
    """Return 1 if the first moment of a slip has given one along a line the other sense than its mode, else 0.

    The impulses that nudge a slip spin the body, too: a spin that was about to begin has a speed then. If a contact
    closes at its end, the impact comes first.
    """
    if approaches(it) != 0:
        return 0
    for k in range(it.contacts):
        v = it.rate[it.first[k] + 1] if it.tangents[k] == 1 else 0.0
        if (it.mode[k] == laws.SLIDE_ON and v < -it.still) or (
            it.mode[k] == laws.SLIDE_BACK and v > it.still
        ):
            return 1
    return 0
