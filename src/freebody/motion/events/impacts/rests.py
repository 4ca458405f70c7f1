"""The ends of bounces and of slow slips: the least motion that takes speeds away, in compiled code."""

from __future__ import annotations

from ....native.instructions import compiled
from ...cones.contacts import Contacts
from .. import event_run, limits
from ..event_run import EventRun
from ..impulse_system import add_ray, add_row, impelled, move_speeds
from ..log import begin, end, mark, note, note_all
from ..moment import copy, is_smooth, look, normal_speed, presses, slip_speed


@compiled
def take_away(it: EventRun, contacts: Contacts) -> None:
    """Take the normal speeds of the contacts ``taking`` away, and the slip where they stick (`sticks`).

    The remaining bounces press with the sum of the weights less the normal momentum removed here. On a slipping contact
    the friction is smaller accordingly, by -μ d per unit of normal impulse. Other contacts at rest stay closed, under
    the same friction.
    """
    count = 0
    for k in range(it.contacts):
        at = it.first[k]
        rests = it.closed[k] != 0 and it.presser[k] < 0 and abs(it.rate[at]) <= it.still
        if it.taking[k] != 0 or rests:
            count = add_row(it, count, at, -it.rate[at])
            if it.tangents[k] > 0 and not is_smooth(it, k):
                if sticks(it, k) != 0:
                    for j in range(1, 1 + it.tangents[k]):
                        count = add_row(it, count, at + j, -it.rate[at + j])
                else:
                    add_ray(it, count - 1, k)
            count = add_resistances(it, count, k)
    impelled(it, contacts, count)
    move_speeds(it)
    look(it)


@compiled
def add_resistances(it: EventRun, count: int, k: int) -> int:
    """Add what resists the rolling and spinning of a contact in the list: rows at rest, else parts of its ray."""
    normal, r = count - 1, k + 1
    while it.list[normal] != it.first[k]:
        normal -= 1
    while r < it.contacts and it.presser[r] == k:
        if slip_speed(it, r) > it.still:
            add_ray(it, normal, r)
        elif not is_smooth(it, r):
            for j in range(1, 1 + it.tangents[r]):
                count = add_row(it, count, it.first[r] + j, -it.rate[it.first[r] + j])
        r += 1
    return count


@compiled
def sticks(it: EventRun, k: int) -> int:
    """Return 1 if a contact has no slip, or one so slow that it ends within its bounces, or its last impact left none.

    Else 0.
    """
    if slip_speed(it, k) <= limits.SLOW:
        return 1
    for b in range(it.bounces - 1, it.bounces - 1 - limits.PERIOD, -1):
        if it.taking[k] != 0 and b >= 0 and it.bounced[b * it.contacts + k] != 0:
            return it.bounce_stuck[b]
    return 0


@compiled
def take_approach(it: EventRun, contacts: Contacts) -> None:
    """Take away the approach of contacts that have collided at this moment: what corrections left, or the rest of a
    series of impacts that goes on between several of them closer than times differ.

    That may press others that have just left; each pass brings one more to rest, or ends this: rows that depend on each
    other may contradict each other by their round-off.
    """
    goes_on, turn = 1, 0
    while goes_on != 0 and turn < it.contacts:
        goes_on, turn, found = 0, turn + 1, 0
        for k in range(it.contacts):
            it.taking[k] = 1 if it.closed[k] != 0 and normal_speed(it, k) < -it.still else 0
            found += it.taking[k]
        if found > 0:
            take_away(it, contacts)
        for k in range(it.contacts):
            if it.taking[k] != 0 and normal_speed(it, k) >= -it.still:
                goes_on = 1


@compiled
def log_rest(it: EventRun, kind: int) -> None:
    """Log that the contacts ``taking`` come to rest, from the state ``start``."""
    at = begin(it, event_run.RESTING)
    mark(it, kind)
    note(it, it.t)
    note_all(it, it.start, it.n_y)
    note_all(it, it.y, it.n_y)
    for k in range(it.contacts):
        if it.taking[k] != 0:
            mark(it, k)
    end(it, at)


@compiled
def end_slow_slips(it: EventRun, contacts: Contacts) -> None:
    """End slips in space slower than `SLOW`, where events crowd at one moment.

    A body that turns about one of its contacts as it stops has no direction of slip there, and a straight step that
    begins one outlasts the slip at the others. The impulses move the masses least: the energy falls.
    """
    count, slow = 0, 0
    for k in range(it.contacts):
        it.taking[k], rests = 0, it.closed[k] != 0 and abs(normal_speed(it, k)) <= it.still
        if rests:
            count = add_row(it, count, it.first[k], -normal_speed(it, k))
        slow_enough = it.tangents[k] == 2 and not is_smooth(it, k) and slip_speed(it, k) <= limits.SLOW
        if slow_enough and (rests or (it.compliant[k] != 0 and presses(it, k) != 0)):
            it.taking[k] = 1
            for j in range(1, 3):
                count = add_row(it, count, it.first[k] + j, -it.rate[it.first[k] + j])
            if slip_speed(it, k) > it.still:
                slow = 1
    if slow != 0:
        copy(it.y, it.start, it.n_y)
        impelled(it, contacts, count)
        move_speeds(it)
        log_rest(it, event_run.SLOWED)
        look(it)
