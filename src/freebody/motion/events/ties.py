"""Laws that hold with equality, in compiled code: what the motion does a moment later decides whether they end.

A law such as |T| = μ_s N ends if it is violated a `MOMENT` later, on a straight line with the accelerations of a
decision; else it goes on.
"""

from __future__ import annotations

from ...native.instructions import compiled, lesser
from ..cones.contacts import Contacts
from ..phase import laws
from ..phase.contact_outputs import evaluated
from ..phase.phase_record import PhaseData
from . import event_run, limits
from .event_run import EventRun
from .moment import add_responses, choose, copy, largest, look, slip_speed
from .problem import is_unloaded
from .setting import normalise, set_up
from .slips.slip_starts import slip_acceleration

STEADY = 0.01
"""Part of the time in which a slow slip in space would turn or end, in which its direction stays."""


@compiled
def go_straight(it: EventRun) -> float:
    """Set ``trial`` to the state a moment later, with the accelerations of the decision; return how much later."""
    machine, state = PhaseData(it.looking), it.trial
    length = limits.MOMENT / (1.0 + largest(it.y[it.n_q :], it.n))
    for _ in range(it.crowd):  # where events crowd, modes follow each other within less
        length *= 0.5 if length > limits.BRIEFEST else 1.0
    for k in range(it.contacts):  # a straight line must not lead a slow slip beyond its end
        if it.mode[k] == laws.SLIDE and it.tangents[k] == 2 and slip_speed(it, k) > it.still:
            change = slip_acceleration(it, k)
            if length * change > STEADY * slip_speed(it, k):
                length = STEADY * slip_speed(it, k) / change
    evaluated(it.t, it.y, machine)
    copy(it.y, state, it.n_y)
    for i in range(it.n_q):
        state[i] += length * machine.q_dot[i]
    copy(it.free, it.v, it.n)
    add_responses(it, it.force, it.v)
    for i in range(it.n):
        state[it.n_q + i] += length * it.v[i]
    return length


@compiled
def end_at_once(it: EventRun, contacts: Contacts) -> int:
    """Set which laws that hold with equality end: return their number.

    A moment later such a law is violated, or, if its function fell through zero and so is negative, more than now.
    Where N and the limit of friction fall to zero together, a contact that may slip opens.
    """
    set_up(it, contacts)
    length = go_straight(it)
    phase, found, unloaded = PhaseData(it.phase), 0, 0
    now, later = it.watch, it.watch_later
    it.watched(it.t, it.y, it.phase, now)
    it.watched(it.t + length, it.trial, it.phase, later)
    for i in range(phase.endings):
        k, law, e = it.ending[i], phase.law[i], it.events + i
        if it.tied[k] != 0 and (
            it.ends[k] == event_run.NO_REASON or (law == laws.NORMAL and it.ends[k] == event_run.CONE_REACHED)
        ):
            fell = 0.0
            if it.hit == 0 and it.reason[k] == event_run.CONE_REACHED:
                limit = it.coefficients[4 * k + 1] * it.force[it.first[k]]
                fell = now[e] - laws.ROUNDED * (limit * limit if law == laws.CONE else limit)
            if later[e] < lesser(fell, 0.0):
                if law == laws.NORMAL:
                    it.ends[k], found = event_run.NORMAL_ZERO, found + 1
                elif law == laws.CONE or law == laws.LINE_CONE:
                    it.ends[k], found = event_run.CONE_REACHED, found + 1
                    unloaded += is_unloaded(it, k)
    if unloaded > 0:
        it.forces(it.t + length, it.trial, it.phase, it.speeds)
        for k in range(it.contacts):
            it.later[k] = it.speeds[it.first[k] + 1] if is_unloaded(it, k) != 0 else 0.0
    return found


@compiled
def begin_to_leave(it: EventRun) -> int:
    """Set ``left`` of contacts at rest at the end of their side that they leave; return their number.

    The speed along the side is seen a moment later. What takes over from a side that was left at this moment stays.
    """
    choose(it)
    at_end, found = 0, 0
    for i in range(it.count):
        at_end += 1 if it.reach[it.chosen[i]] <= it.near else 0
    if at_end == 0:
        return 0
    if it.ready == 0:
        return -1
    copy(it.y, it.kept, it.n_y)
    copy(it.reach, it.flight, it.contacts)
    go_straight(it)
    copy(it.trial, it.y, it.n_y)
    normalise(
        it
    )  # its length changes in a straight step by more than shows of a disk that is flat to 1e-11 m
    look(it)
    for i in range(it.count):
        k = it.chosen[i]
        takes_over = it.side[k] >= 0 and it.left[it.side[k]] != 0
        if it.flight[k] <= it.near and it.away[k] < -it.still and not takes_over:
            it.left[k], found = 1, found + 1
    copy(it.kept, it.y, it.n_y)
    look(it)
    return found
