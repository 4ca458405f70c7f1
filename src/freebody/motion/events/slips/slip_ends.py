"""The last moments of slips in space, which end at speed zero, where they have no direction, in compiled code."""

from __future__ import annotations

from ....native.instructions import compiled, greater, root
from ...cones.block_rows import dot
from ...cones.contacts import Contacts
from ...ode.run import Run
from ...phase import laws
from ...phase.phase_record import PhaseData
from .. import limits
from ..event_run import EventRun
from ..impulse_system import add_row, impelled, move_speeds
from ..moment import copy, is_smooth, largest, look, response, slip_speed
from .straight_steps import UPSET, go_straight, log_leap, upset

DEAD = 1e-16
"""Part of the motion by a normal force, as a square, below which that by friction is none: at a dead centre it is zero.

An event is located to about 1e-11 of a turn.
"""
FADES, ALIKE = 100.0, 10.0
"""Multiple of the speed at which slips end up to which others end together; the part by which they must have slowed."""


@compiled
def resolve_slips(it: EventRun, run: Run) -> None:
    """Set the speed at which slips in space end: what the tolerances of the speeds resolve."""
    most = 0.0
    for i in range(it.n_q, it.n_q + it.n):
        most = greater(most, run.absolute[i])
    it.slowest = greater(laws.STOPPED, laws.RESOLVED * most)
    if it.creeping == 0:
        PhaseData(it.phase).stopped = it.slowest


@compiled
def fading(it: EventRun, slows: int) -> int:
    """Return a contact with friction that slips in space so slowly that the slip soon has no direction, or -1.

    With ``slows`` 1 it is one that slows further: its speed does not pass the end of slips, and its direction turns at
    rates of 1/speed.
    """
    known = 0
    for k in range(it.contacts):
        rough = it.mode[k] == laws.SLIDE and it.tangents[k] == 2 and not is_smooth(it, k)
        if not rough or slip_speed(it, k) > PhaseData(it.phase).stopped:
            continue
        if slows == 0:
            return k
        if slip_speed(it, k) > it.still:
            if known == 0:
                it.accelerations(it.t, it.y, it.phase, it.speeds)
                known = 1
            r = it.first[k] + 1
            if dot(it.rate[r:], it.speeds[r:], 2) < 0.0:
                return k
    return -1


@compiled
def stop(it: EventRun, contacts: Contacts, keep: int) -> int:
    """Cancel the slip of the contacts ``stopped``; those that stick, and are closed, stay so. Return 1, or 0 if not all
    of them can.

    With ``keep`` 1 the work is not counted.

    Slips along tangents at a dead centre go on: what stops them there would stop all that moves.
    """
    count = 0
    for k in range(it.contacts):
        if it.mode[k] != laws.OPEN and it.held[k] == 0:
            count = add_row(it, count, it.first[k], -it.rate[it.first[k]])
        if it.stopped[k] != 0 or it.mode[k] == laws.STICK:
            for j in range(1, 1 + it.tangents[k]):
                if is_dead_centre(it, k, it.first[k] + j) == 0:
                    count = add_row(it, count, it.first[k] + j, -it.rate[it.first[k] + j])
    missed, work = impelled(it, contacts, count), it.impulses
    move_speeds(it)
    if keep != 0:
        it.impulses, it.rest_left = work, it.impulses - work
    look(it)
    return 1 if missed <= it.still else 0


@compiled
def is_dead_centre(it: EventRun, k: int, r: int) -> int:
    """Return 1 if force along tangent r of a contact moves the machine by nothing beside its normal force, else 0.

    The slip of a crank's pin in a straight slot is zero there, whatever the speed of the crank.
    """
    p = it.presser[k] if it.presser[k] >= 0 else k
    if it.held[p] != 0:
        return 0
    normal = it.first[p]
    return 1 if response(it, r, r) <= DEAD * response(it, normal, normal) else 0


@compiled
def turn_back(it: EventRun, contacts: Contacts) -> None:
    """Take away slips along a line that are against the sense in which they begin: what an impact has left of them.

    Otherwise the function that ends the slip would begin below zero, and never fall through it.
    """
    found, noise = 0, limits.NOISE * (1.0 + largest(it.y[it.n_q :], it.n))
    for k in range(it.contacts):
        v, it.stopped[k] = 0.0, 0
        if it.mode[k] == laws.SLIDE_ON or it.mode[k] == laws.SLIDE_BACK:
            v = it.rate[it.first[k] + 1]
            v = v if it.mode[k] == laws.SLIDE_ON else -v
        if -it.still <= v < -noise:
            it.stopped[k], found = 1, 1
    if found != 0:
        stop(it, contacts, 0)


@compiled
def find_stopped(it: EventRun, k: int, length: float) -> None:
    """Let the slips of other contacts end with that of contact k, after this time; ``speeds`` are the accelerations.

    A body that turns as it stops comes to rest at all its contacts at once.
    """
    fast = FADES * PhaseData(it.phase).stopped
    for j in range(it.contacts):
        slides = it.mode[j] == laws.SLIDE and it.tangents[j] == 2 and it.rough[j] != 0
        r, speed, left = it.first[j] + 1, slip_speed(it, j), 0.0
        for i in range(it.tangents[j]):
            left += (it.rate[r + i] + length * it.speeds[r + i]) ** 2
        ends = slides and speed <= fast and root(left) <= speed / ALIKE
        it.stopped[j] = 1 if j == k or ends else 0


@compiled
def halt(it: EventRun, contacts: Contacts, k: int, whole: int) -> int:
    """Pass the end of a slip in space whose speed has fallen to that of its end, by a straight step to it.

    A slip along a line is at its end. The step ends before where a contact closes. Return 1 if the state has changed, 0
    if not, and -1 if it hardly slows: it stops if it sticks then. The state is that without slip, and ``kept`` the one
    before. Return `UPSET` if other slow slips would turn within the step, or what sticks cannot stay in place without
    the slip, and ``whole`` is not 0.
    """
    speed, r = slip_speed(it, k), it.first[k] + 1
    if not speed > 0.0:
        return 0
    for j in range(it.contacts):
        it.stopped[j] = 1 if j == k else 0
    if it.tangents[k] == 1:
        stop(it, contacts, 0)
        return 1
    it.accelerations(it.t, it.y, it.phase, it.speeds)
    slowing = -dot(it.rate[r:], it.speeds[r:], 2) / speed
    if not slowing > 0.0:  # it turns as it slows: a new slip begins, or it sticks
        stop(it, contacts, 0)
        return 1
    length = speed / slowing
    find_stopped(it, k, length)
    if length > limits.LONGEST:
        copy(it.y, it.kept, it.n_y)
        if stop(it, contacts, 1) == 0 and whole != 0:
            copy(it.kept, it.y, it.n_y)
            look(it)
            return UPSET
        return -1
    if whole != 0 and upset(it, k, length) != 0:
        return UPSET
    copy(it.y, it.start, it.n_y)
    it.rates(it.t, it.y, it.phase, it.step)
    begun = it.t
    passed = go_straight(it, length)
    for i in range(it.n_q + it.n, it.n_y):
        it.y[i] += passed * it.step[i]
    if passed < length:  # what closes comes first
        for j in range(it.contacts):
            it.stopping[j] = 0
    else:
        stop(it, contacts, 0)  # the slip that remains after a straight step is of second order in its length
    log_leap(it, begun, passed)
    return 1
