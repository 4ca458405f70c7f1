"""Impacts of machines whose joints have friction under their load, in compiled code.

    |Λ_T| <= μ P,      P = r (|F_a| + |F_b|)

with the impulses F of the reactions of the joint, which this friction changes. Newton's law has one P; Poisson's has
one of compression and one of expansion. Each pass solves for the impulses at P and takes P from their reactions, as
those between impacts do (`phase.bearings`). The reactions of a blow are ``blown``, and the friction acts with it.
"""

from __future__ import annotations

from ....native.instructions import Reals, compiled, greater, run_by
from ...cones.contacts import ACCEPTED, Contacts
from ...phase.bearings import NEARLY, PASSES, SAME, load_of
from ...phase.contact_outputs import row_taken
from ...phase.phase_kernels import response
from ...phase.phase_record import PhaseData
from .. import event_run
from ..event_run import EventRun
from ..moment import append, copy


@compiled
def append_loaded(it: EventRun) -> None:
    """Append the friction of joints under their load to the contacts that collide."""
    for k in range(it.contacts):
        if it.loaded[k] != 0:
            append(it, k)


@compiled
def collided_under_loads(it: EventRun, contacts: Contacts) -> int:
    """Let the chosen contacts collide at once, with loads that agree with their impulses; return why not, or 0."""
    last = 1.0
    for i in range(it.count):
        contacts.least[i] = contacts.back[i] = 0.0
    for _ in range(PASSES):
        run_by(it.colliding, contacts)
        if not contacts.residual <= ACCEPTED:
            return event_run.NO_IMPULSES
        change = bear(it, contacts)
        if change <= SAME or NEARLY >= change >= last:
            return 0
        last = change
    return event_run.JAMMED


@compiled
def bear(it: EventRun, contacts: Contacts) -> float:
    """Set the loads to those of the impulses; return their greatest change, relative to the greatest load."""
    change, most, machine = 0.0, 0.0, PhaseData(it.looking)
    for turn in range(2 if contacts.poisson != 0 else 1):
        react(it, contacts, machine, turn)
        bounds, j = contacts.least if turn == 0 else contacts.back, 0
        for i in range(it.count):
            if it.loaded[it.chosen[i]] != 0:
                load = load_of(machine.bearing, j)
                change, most = greater(change, abs(load - bounds[i])), greater(most, load)
                bounds[i] = load
                j += 1
    return change / most if most > 0.0 else 0.0


@compiled
def react(it: EventRun, contacts: Contacts, machine: PhaseData, turn: int) -> None:
    """Set the outputs of bearings to the impulses of joints in compression, ``turn`` 0, or in expansion, 1.

    The reactions are affine in accelerations, forces and multipliers, whose place jumps and impulses take.
    """
    state, n, size = machine.state, it.n, event_run.LOADED * it.loads
    acting = state[it.n_q + n :]
    copy(it.y, state, it.n_q + n)
    for i in range(n + it.rows + machine.all_own):
        acting[i] = 0.0
    bearings_of(it, machine, it.unstruck)
    pushed, row = machine.free, machine.spare
    for p in range(n):
        pushed[p] = 0.0
    for a in range(contacts.rows):
        impulse = contacts.compressed[a] if turn == 0 else contacts.forces[a] - contacts.compressed[a]
        machine.force[it.list[a]] = impulse
        row_taken(machine, it.list[a], row)
        for p in range(n):
            pushed[p] += impulse * row[p]
    response(machine, pushed, machine.udot)
    for i in range(machine.conditions):  # those of the machine itself
        machine.multiplier[machine.number[i]] = machine.lam[i]
    bearings_of(it, machine, machine.bearing)
    for i in range(size):
        if i % event_run.LOADED != 0:  # the first of each is its lever
            machine.bearing[i] += it.blown[i] - it.unstruck[i]


@compiled
def bearings_of(it: EventRun, machine: PhaseData, out: Reals) -> None:
    """Set the levers and forces of the joints at the state, accelerations and forces of ``machine.state``."""
    machine.bearings(it.t, machine.state, machine.bearings_c, out)
