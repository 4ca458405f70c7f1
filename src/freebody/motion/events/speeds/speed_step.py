"""A short step of the speeds alone, in compiled code: which contacts stick and where the others slip to, at once.

    u⁺ = u + h M⁻¹ f + M⁻¹ Wᵀ Λ,    0 <= Λ_N  ⟂  v_N⁺ >= 0,    -Λ_T in μ Λ_N Sgn(v_T⁺)

M, f and W are those of the position halfway, so that a contact that stays closed as it turns does no work by N.
Where several contacts come to rest and begin to slip within less than a microsecond, the directions of slip follow each
other faster than events tell, and no nudge along directions of the accelerations is possible. This problem decides for
all of them, and always has a solution. It is of first order in h where slips begin and end.

Source: J. J. Moreau, Unilateral contact and dry friction in finite freedom dynamics (1988).
"""

from __future__ import annotations

from ....native.instructions import compiled, greater, run_by
from ...cones.contacts import ACCEPTED, Contacts
from ...phase.contact_outputs import evaluated, extended
from ...phase.phase_record import PhaseData
from .. import limits
from ..event_run import EventRun
from ..impulse_system import add_row, impelled, move_speeds
from ..moment import add_response, approaches, choose_all, copy, largest, look, presses, pull, size_of
from ..problem import gather, split, take_all, take_island
from ..setting import displace, normalise
from ..slips.straight_steps import closes, log_leap, loses_places

NEARLY = 1e-6
"""Residual of a step whose mean speeds are known well enough for the rates of its rows."""


@compiled
def step_of_speeds(it: EventRun, contacts: Contacts, length: float) -> int:
    """Pass a step of this length; return 1 if the state has changed, or 0.

    It is 0 if nothing touches, if an impact comes first, if a drive acts in a closed loop, if there is no solution, or
    if a contact would close, also one at a place of a patch that has no features yet, or a compliant one that presses
    would not any more. Its force is that of the depth halfway; joints bear the load of the last decision.
    """
    n_q, n, begun, machine = it.n_q, it.n, it.t, PhaseData(it.looking)
    if approaches(it) != 0 or (machine.own > 0 and (machine.driven != 0 or it.moving != 0)):
        return 0
    choose_all(it)
    if it.count == 0:
        return 0
    copy(it.y, it.start, it.n_y)
    copy(it.gap, it.apart, it.contacts)
    copy(it.rate, it.speeds, it.rows)
    look_halfway(it, length)
    solve(it, contacts, length)
    if contacts.residual <= NEARLY and (contacts.residual > ACCEPTED or slips_by_error(it, contacts) != 0):
        look_at_trial(it, length)
        solve(it, contacts, length)
    if not contacts.residual <= ACCEPTED:
        look(it)
        return 0
    it.worst = greater(it.worst, contacts.residual)
    it.t = begun + length / 2.0
    evaluated(it.t, it.trial, machine)
    work = length * machine.load[0]
    if machine.driven != 0:
        work += driven_work(it, contacts, length)
    for i in range(n_q):
        it.y[i] += length * machine.q_dot[i]
    for i in range(n):
        it.y[n_q + i] += it.step[i]
    normalise(it)
    it.t = begun + length
    look(it)
    if closes(it, it.near) != 0 or loses_places(it) != 0 or presses_anew(it) != 0:
        it.t = begun
        copy(it.start, it.y, it.n_y)
        look(it)
        return 0
    heat = 0.0
    for i in range(it.count):
        k, at = it.chosen[i], contacts.at[i]
        for j in range(1 + it.tangents[k]):
            r = it.first[k] + j
            done = contacts.forces[at + j] * (it.speeds[r] + it.rate[r]) / 2.0
            if j < it.compliant[k]:
                work += done
            else:
                heat -= done
    it.y[n_q + n] += work - heat
    it.y[n_q + n + 1] += heat
    keep_closed(it, contacts)
    log_leap(it, begun, length)
    return 1


@compiled
def solve(it: EventRun, contacts: Contacts, length: float) -> None:
    """Find the impulses of a step and its changes of speed, ``step``, and let ``trial`` have the mean speeds."""
    find_impulses(it, contacts, length)
    for i in range(it.n):
        it.step[i] = length * it.free[i]
    for a in range(contacts.rows):
        add_response(it, contacts.forces[a], it.list[a], it.step)
    for i in range(it.n):
        it.trial[it.n_q + i] = it.y[it.n_q + i] + it.step[i] / 2.0


@compiled
def find_impulses(it: EventRun, contacts: Contacts, length: float) -> None:
    """Solve the problem of a step, island by island, and put the results together in that of all chosen contacts."""
    first, residual = 0, 0.0
    split(it)
    while first < it.concerned_count and residual <= NEARLY:
        first = take_island(it, first)
        write_step(it, contacts, length)
        run_by(it.finding, contacts)
        residual = greater(residual, contacts.residual) if contacts.residual <= NEARLY else contacts.residual
        for a in range(contacts.rows):
            it.whole[it.list[a]], it.nu[it.list[a]] = contacts.forces[a], contacts.after[a]
    if it.count < it.concerned_count:
        take_all(it)
        write_step(it, contacts, length)
        for a in range(contacts.rows):
            contacts.forces[a], contacts.after[a] = it.whole[it.list[a]], it.nu[it.list[a]]
        contacts.residual = residual


@compiled
def write_step(it: EventRun, contacts: Contacts, length: float) -> None:
    """Write the problem of the chosen contacts: of their speeds after a step, with all other forces in it."""
    gather(it, contacts, 1, length)
    for i in range(it.count):
        k, at = it.chosen[i], contacts.at[i]
        for j in range(it.compliant[k], 1 + it.tangents[k]):  # the normal of a compliant one is no unknown
            contacts.given[at + j] += length * it.c[it.first[k] + j]


@compiled
def slips_by_error(it: EventRun, contacts: Contacts) -> int:
    """Return 1 if a contact that presses slips in a step by no more than its speed at rest may be, else 0.

    Rates of the rows, c, are those of the speeds at the start of the step. They miss what the rows turn by in half of
    it: h² of the product of two accelerations, which no motion of bodies at rest on each other can have, so that each
    would slip by its part, at its limit.
    """
    for i in range(it.count):
        rests = size_of(contacts.after[contacts.at[i] + 1 :], it.tangents[it.chosen[i]]) <= it.still
        if rests and presses_in_step(it, contacts, i) != 0 and rests_in_step(it, contacts, i) == 0:
            return 1
    return 0


@compiled
def keep_closed(it: EventRun, contacts: Contacts) -> None:
    """Close contacts that press in a step, and stop those that rest: its rows are those halfway, at other speeds.

    What they miss is of second order in its length, but where friction wedges bodies, it would open a contact for the
    10 ns that 1 kN needs to close it by another impact.
    """
    for turn in range(2):  # positions, then speeds
        count = 0
        for i in range(it.count):
            k = it.chosen[i]
            if it.held[k] == 0 and it.presser[k] < 0 and presses_in_step(it, contacts, i) != 0:
                goal = it.gap[k] if turn == 0 else it.rate[it.first[k]]
                count = add_row(it, count, it.first[k], -goal)
        impelled(it, contacts, count)
        if turn == 0:
            displace(it, it.x, count)
        else:
            move_speeds(it)
            look(it)


@compiled
def presses_in_step(it: EventRun, contacts: Contacts, i: int) -> int:
    """Return 1 if a contact of the list presses in the step that has been passed, or its normal force is given."""
    if it.held[it.chosen[i]] != 0:
        return 1
    p = contacts.presser[i] if contacts.presser[i] >= 0 else i
    least = limits.SMALL * largest(contacts.forces, contacts.rows)
    return 1 if contacts.forces[contacts.at[p]] > least else 0


@compiled
def rests_in_step(it: EventRun, contacts: Contacts, i: int) -> int:
    """Return 1 if a contact of the list is at rest in the step that has been passed, else 0."""
    n, none = it.tangents[it.chosen[i]], ACCEPTED * largest(contacts.given, contacts.rows)
    stays = size_of(contacts.after[contacts.at[i] + 1 :], n) <= none
    return 1 if n > 0 and contacts.static[i] > 0.0 and stays else 0


@compiled
def presses_anew(it: EventRun) -> int:
    """Return 1 if a compliant contact presses that is not chosen, or does not that is, else 0."""
    for k in range(it.contacts):
        if it.compliant[k] != 0:
            pressed = 0
            for i in range(it.count):
                pressed = 1 if it.chosen[i] == k else pressed
            if presses(it, k) != pressed:
                return 1
    return 0


@compiled
def look_halfway(it: EventRun, length: float) -> None:
    """Look at the contacts in the position after half of a step, ``trial``, with the speeds that they have now."""
    machine, state = PhaseData(it.looking), it.trial
    evaluated(it.t, it.y, machine)
    copy(it.y, state, it.n_y)
    for i in range(it.n_q):
        state[i] += length * machine.q_dot[i] / 2.0
    look_at_trial(it, length)


@compiled
def look_at_trial(it: EventRun, length: float) -> None:
    """Look at the contacts in ``trial``, after half of a step, with the rates in ``speeds``."""
    it.looked(it.t + length / 2.0, it.trial, it.looking, it.seen)
    copy(it.speeds, it.rate, it.rows)
    for k in range(it.contacts):
        if it.loaded[k] != 0:
            it.given[k] = it.load[k]
        if it.adhering[k] != 0:
            it.adhering[k] = 0
            pull(it, k, 1)


@compiled
def driven_work(it: EventRun, contacts: Contacts, length: float) -> float:
    """Return the work of drives in a step, by its mean accelerations and contact forces, in its middle."""
    machine = PhaseData(it.looking)
    extended(it.trial, machine)
    for i in range(it.n):
        machine.udot[i] = it.step[i] / length
    for r in range(it.rows):
        machine.force[r] = 0.0
    for a in range(contacts.rows):
        machine.force[it.list[a]] = contacts.forces[a] / length
    for k in range(it.contacts):
        if it.adhering[k] != 0:
            machine.force[it.first[k]] -= it.adhesion[k]
    machine.power(it.t, machine.state, machine.power_c, it.x)
    return length * it.x[0]
