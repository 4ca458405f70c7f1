"""Loads of joints that bound their friction in a step, from the impulses that it has with them.

    P = r (|F_a| + |F_b|),     F the reactions at (q_M, ū) to (u⁺ - u)/h, Λ/h and λ/h

Each pass solves the contacts under the loads of the last one (`phase.bearings` says when that ends).
"""

from __future__ import annotations

from ...native.instructions import compiled, greater
from ..cones.contact_problem import NORMAL
from ..phase.bearings import load_of
from .free_joints import turning
from .stepping_record import Run

PASSES = 2000
"""Passes after which loads are not found."""
AGREE = 1e-13
"""Change of a load, relative to the greatest, at which it is found."""


@compiled
def bear(run: Run, t: float) -> float:
    """Set the impulses of the loads; return their greatest change, relative to the greatest load."""
    bearings, contacts, problem = run.bearings, run.contacts, run.problem
    set_motion(run)
    bearings.forces(t + 0.5 * run.h, bearings.motion, bearings.c, bearings.outputs)
    change, most = 0.0, 0.0
    for j in range(bearings.count):
        load, k = run.h * load_of(bearings.outputs, j), bearings.loaded[j]
        a = contacts.normal_row[k]
        change, most = greater(change, abs(load - problem.low[a])), greater(most, load)
        problem.low[a] = problem.x[a] = load
        run.given[k] = load / run.h
    return change / most if most > 0.0 else 0.0


@compiled
def set_motion(run: Run) -> None:
    """Write the mean state, accelerations, contact forces and multipliers of the step."""
    machine, contacts, problem, motion = run.machine, run.contacts, run.problem, run.bearings.motion
    n_q, n = machine.n_q, machine.n
    for i in range(n_q):
        motion[i] = run.z[i]
    for i in range(n):
        change = run.free[i] + problem.v[i]
        run.u_mean[i] = run.u[i] + 0.5 * change
        motion[n_q + machine.order[i]] = run.u_mean[i]
        motion[n_q + n + machine.order[i]] = change / run.h
    for k in range(machine.flights):
        at = n_q + n + machine.order[machine.spin[k]] + 3
        x, y, z = turning(machine, k, run.u_mean)
        motion[at] -= x
        motion[at + 1] -= y
        motion[at + 2] -= z
    at = n_q + 2 * n
    for r in range(contacts.rows):
        motion[at + r] = 0.0
    for a in range(contacts.closed):
        force = problem.x[a] / run.h
        if problem.kinds[a] == NORMAL:
            force -= contacts.pull[contacts.owner[a]]
        motion[at + problem.rows[a]] = force
    for i in range(run.constraints):
        impulse = run.lam[i]
        for a in range(problem.count):
            impulse -= run.elimination.sigma[a, i] * problem.x[a]
        motion[at + contacts.rows + run.bearings.number[i]] = impulse / run.h
