"""A short step of the speeds alone, in compiled code: which contacts stick and where the others slip to, at once.

    u⁺ = u + h M⁻¹ f + M⁻¹ Wᵀ Λ,    0 <= Λ_N  ⟂  v_N⁺ >= 0,    -Λ_T in μ Λ_N Sgn(v_T⁺)

Where several contacts come to rest and begin to slip within less than a microsecond, the directions of slip follow each
other faster than events tell, and no nudge along directions of the accelerations is possible. This problem decides for
all of them, and always has a solution. It is of first order in h.

Source: J. J. Moreau, Unilateral contact and dry friction in finite freedom dynamics (1988).
"""

from __future__ import annotations

from ...native.instructions import compiled, lesser, run_by
from ..cones.contacts import ACCEPTED, Contacts
from ..phase.contact_outputs import evaluated
from ..phase.phase_record import PhaseData
from . import event_run
from .event_run import EventRun
from .impulses import gather
from .moment import choose, copy, look, slip_speed
from .setting import normalise
from .slips import log_leap


@compiled
def step_of_speeds(it: EventRun, contacts: Contacts, length: float) -> int:
    """Pass a step of this length; return 1 if the state has changed, or 0.

    It is 0 if a bounded force or a drive acts at a contact, if there is no solution, or if a contact would close.
    """
    n_q, n, begun, machine = it.n_q, it.n, it.t, PhaseData(it.looking)
    if machine.driven != 0 or it.moving != 0:
        return 0
    for k in range(it.contacts):
        if it.held[k] != 0 and it.presser[k] < 0:
            return 0
    choose(it)
    gather(it, contacts, 1)
    for a in range(contacts.rows):
        contacts.given[a] += length * it.c[it.list[a]]
    run_by(it.finding, contacts)
    if not contacts.residual <= ACCEPTED:
        return 0
    copy(it.y, it.start, it.n_y)
    copy(it.gap, it.measure, it.contacts)
    copy(it.rate, it.speeds, it.rows)
    copy(it.y, it.trial, it.n_y)
    for i in range(n):
        change = length * it.free[i]
        for a in range(contacts.rows):
            change += contacts.forces[a] * it.X[it.list[a] * n + i]
        it.step[i] = change
        it.trial[n_q + i] += change / 2.0
    evaluated(it.t, it.trial, machine)
    work = length * machine.load[0]
    for i in range(n_q):
        it.y[i] += length * machine.q_dot[i]
    for i in range(n):
        it.y[n_q + i] += it.step[i]
    normalise(it)
    it.t = begun + length
    look(it)
    for k in range(it.contacts):
        if it.gap[k] < -it.near and it.measure[k] > it.near:
            it.t = begun
            copy(it.start, it.y, it.n_y)
            look(it)
            return 0
    heat = 0.0
    for a in range(contacts.rows):
        r = it.list[a]
        heat -= contacts.forces[a] * (it.speeds[r] + it.rate[r]) / 2.0
    it.y[n_q + n] += work - heat
    it.y[n_q + n + 1] += heat
    log_leap(it, begun, length)
    return 1


@compiled
def decided_by_speeds(it: EventRun, contacts: Contacts, longest: float) -> int:
    """Pass a step of the speeds where slips begin and end faster than events tell; return 1 if it did, else 0.

    Steps that follow each other grow to twice their length, up to `LONGEST`.
    """
    again = it.t - it.leapt <= 2.0 * it.leap
    length = lesser(2.0 * it.leap, event_run.LONGEST) if again else event_run.SHORTEST
    if length > longest or step_of_speeds(it, contacts, length) == 0:
        return 0
    it.leap, it.leapt, it.stage, it.hit = length, it.t, event_run.ARRIVE, 0
    for k in range(it.contacts):
        if it.reason[k] == event_run.CONE_REACHED:
            it.reason[k] = event_run.NO_REASON
    return 1


@compiled
def slow_slips(it: EventRun) -> int:
    """Return the number of slips in space of closed contacts below `SLOW`."""
    found = 0
    for k in range(it.contacts):
        if it.closed[k] != 0 and it.tangents[k] == 2 and it.still < slip_speed(it, k) <= event_run.SLOW:
            found += 1
    return found
