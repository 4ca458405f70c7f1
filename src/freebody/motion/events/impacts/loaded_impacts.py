"""Impacts of machines whose joints have friction under their load, in compiled code.

    |Λ_T| <= μ P,      P = r (|F_a| + |F_b|)

with the impulses F of the reactions of the joint, which this friction changes. Newton's law has one P; Poisson's has
one of compression and one of expansion. Each pass solves for the impulses at P and takes the right side from their
reactions (`cones.broyden`). The reactions of a blow are ``blown``, and the friction acts with it.
"""

from __future__ import annotations

from ....native.instructions import compiled, greater, run_by
from ...cones.broyden import TURNS, begin, missed, take
from ...cones.collision import HALVINGS
from ...cones.contacts import ACCEPTED, Contacts
from ...phase.bearings import SAME, load_of
from ...phase.phase_record import PhaseData
from .. import event_run
from ..event_run import EventRun
from ..moment import append, largest
from .borne_loads import at_rest, bearings_of, respond

NEAR = 1e-6
"""Relative difference at which loads may stay: open shares of impulses have the accuracy of the limit that they are."""


@compiled
def append_loaded(it: EventRun) -> None:
    """Append the friction of joints under their load to the contacts that collide."""
    for k in range(it.contacts):
        if it.loaded[k] != 0:
            append(it, k)


@compiled
def collided_under_loads(it: EventRun, contacts: Contacts) -> int:
    """Let the chosen contacts collide at once, with loads that agree with their impulses; return why not, or 0.

    Where none agree the restitution is halved, at last to zero, as where there are no impulses: a rebound that friction
    of a joint would have to be forced through has loads that grow with it.
    """
    why, part = agreed_impulses(it, contacts), 1.0
    for turn in range(HALVINGS):
        if why == 0:
            return 0
        half = 0.0 if turn == HALVINGS - 1 else 0.5
        for i in range(it.count):
            contacts.restitution[i] *= half
        part *= half
        why = agreed_impulses(it, contacts)
        contacts.part *= part
    return why


@compiled
def agreed_impulses(it: EventRun, contacts: Contacts) -> int:
    """Set impulses with loads that agree with them; return why there are none, or 0."""
    last, turns, count = 1.0, 2 if contacts.poisson != 0 else 1, it.loads
    for i in range(it.count):
        contacts.least[i] = contacts.back[i] = 0.0
    begin(it.bounds, turns * count)
    for _ in range(TURNS):
        run_by(it.colliding, contacts)
        if not contacts.residual <= ACCEPTED:
            return event_run.NO_IMPULSES
        change = bear(it, contacts, turns)
        near = change <= NEAR or felt(it, contacts, turns) <= ACCEPTED
        if change <= SAME or (near and change >= last):
            return 0
        last = change
        take(it.bounds, turns * count)
        j = 0
        for i in range(it.count):
            if it.loaded[it.chosen[i]] != 0:
                contacts.least[i] = it.bounds[j]
                contacts.back[i] = it.bounds[count + j] if turns > 1 else 0.0
                j += 1
    return event_run.JAMMED


@compiled
def bear(it: EventRun, contacts: Contacts, turns: int) -> float:
    """Note the loads of the impulses; return by how much they differ, relative to the greatest load.

    What the greatest impulse has on their levers is the size of their parts.
    """
    change, most, machine = 0.0, 0.0, PhaseData(it.looking)
    for turn in range(turns):
        react(it, contacts, machine, turn)
        for j in range(it.loads):
            load, part = load_of(machine.bearing, j), machine.bearing[event_run.LOADED * j]
            most = greater(most, greater(load, part * largest(contacts.forces, contacts.rows)))
            change = greater(change, missed(it.bounds, turns * it.loads, turn * it.loads + j, load))
    return change / most if most > 0.0 else 0.0


@compiled
def felt(it: EventRun, contacts: Contacts, turns: int) -> float:
    """Return the greatest speed that friction gives a joint by what its load misses, relative to the greatest speed.

    Impulses of slow approaches beside fast slips have the round-off of these, and their loads with them.
    """
    n, j, result = turns * it.loads, 0, 0.0
    fastest = greater(largest(contacts.given, contacts.rows), largest(contacts.after, contacts.rows))
    for i in range(it.count):
        if it.loaded[it.chosen[i]] != 0:
            missing, r = 0.0, contacts.at[i] + contacts.tangents[i]
            for turn in range(turns):
                missing = greater(missing, abs(it.bounds[n + turn * it.loads + j]))
            result = greater(result, contacts.friction[i] * missing * contacts.A[r * contacts.rows + r])
            j += 1
    return result / fastest if fastest > 0.0 else 0.0


@compiled
def react(it: EventRun, contacts: Contacts, machine: PhaseData, turn: int) -> None:
    """Set the outputs of bearings to the impulses of joints in compression, ``turn`` 0, or in expansion, 1.

    The reactions are affine in accelerations, forces and multipliers, whose place jumps and impulses take: as great as
    the reactions without them, of which a small impulse would be the round-off.
    """
    size, greatest = event_run.LOADED * it.loads, largest(contacts.forces, contacts.rows)
    at_rest(it, machine)
    bearings_of(it, machine, it.unstruck)
    scale = (1.0 + largest(it.unstruck, size)) / greatest if greatest > 0.0 else 1.0
    for a in range(contacts.rows):
        impulse = contacts.compressed[a] if turn == 0 else contacts.forces[a] - contacts.compressed[a]
        machine.force[it.list[a]] = scale * impulse
    respond(it, machine)
    bearings_of(it, machine, machine.bearing)
    for i in range(size):
        if i % event_run.LOADED != 0:  # the first of each is its lever
            machine.bearing[i] = (machine.bearing[i] - it.unstruck[i]) / scale + it.blown[i]
