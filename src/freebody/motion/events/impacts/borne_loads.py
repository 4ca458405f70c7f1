"""Loads of joints that bound their friction, from the contact forces of a decision or an impact, in compiled code."""

from __future__ import annotations

import math

from ....native.instructions import Reals, compiled, greater
from ...cones.broyden import missed
from ...phase.bearings import load_of, solve
from ...phase.contact_outputs import row_taken
from ...phase.phase_kernels import response
from ...phase.phase_record import PhaseData
from .. import event_run
from ..event_run import EventRun
from ..moment import copy, largest


@compiled
def at_rest(it: EventRun, machine: PhaseData) -> None:
    """Write the present state, with accelerations, contact forces and multipliers that are zero."""
    copy(it.y, machine.state, it.n_q + it.n)
    acting = machine.state[it.n_q + it.n :]
    for i in range(it.n + it.rows + machine.all_own):
        acting[i] = 0.0


@compiled
def respond(it: EventRun, machine: PhaseData) -> None:
    """Add to accelerations and multipliers what the contact forces change."""
    pushed, row = machine.free, machine.spare
    for p in range(it.n):
        pushed[p] = 0.0
    for r in range(it.rows):
        if machine.force[r] != 0.0:
            row_taken(machine, r, row)
            for p in range(it.n):
                pushed[p] += machine.force[r] * row[p]
    response(machine, pushed, it.v, 0, machine.n)
    for i in range(it.n):
        machine.udot[i] += it.v[i]
    for i in range(machine.conditions):  # those of the machine itself
        machine.multiplier[machine.number[i]] += machine.lam[i]


@compiled
def bearings_of(it: EventRun, machine: PhaseData, out: Reals) -> None:
    """Set the levers and forces of the joints at the state, accelerations and forces of ``machine.state``."""
    machine.bearings(it.t, machine.state, machine.bearings_c, out)


@compiled
def borne(it: EventRun) -> float:
    """Note the loads of joints under the forces of a decision; return by how much they differ from those it took.

    It is relative to the greatest load, or to what its parts have on the lever: those of bodies that fall cancel.
    """
    machine, change, most = PhaseData(it.looking), 0.0, 0.0
    at_rest(it, machine)
    bearings_of(it, machine, machine.bearing)
    size = largest(machine.bearing, event_run.LOADED * it.loads)
    solve(it.t, it.y, machine)
    copy(it.y, machine.state, it.n_q + it.n)
    for k in range(it.contacts):
        for j in range(1 + it.tangents[k]):
            machine.force[it.first[k] + j] = it.force[it.first[k] + j]
        if it.adhering[k] != 0:
            machine.force[it.first[k]] -= it.adhesion[k]
    respond(it, machine)
    bearings_of(it, machine, machine.bearing)
    for j in range(it.loads):
        load, part = load_of(machine.bearing, j), size * machine.bearing[event_run.LOADED * j]
        most = greater(most, greater(load, part))
        change = greater(change, missed(it.bounds, it.loads, j, load))
    return change / most if most > 0.0 else 0.0


@compiled
def set_loads(it: EventRun) -> None:
    """Take the loads of the search."""
    j = 0
    for k in range(it.contacts):
        if it.loaded[k] != 0:
            it.given[k] = it.load[k] = it.bounds[j]
            j += 1


@compiled
def keep_loads(it: EventRun) -> None:
    """Take the loads at the end of a phase: steps of the speeds follow it with these."""
    if it.loads == 0:
        return
    it.forces(it.t, it.y, it.phase, it.speeds)
    for k in range(it.contacts):
        if it.loaded[k] != 0 and math.isfinite(it.speeds[it.first[k]]):
            it.given[k] = it.load[k] = it.speeds[it.first[k]]
