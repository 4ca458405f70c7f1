"""The correction at the end of a step: bodies out of each other, and conditions on coordinates met.

    0 <= x ⟂ gap + W Δ >= 0,   φ + G Δ = 0,   Δ = M⁻¹ (Wᵀ x + Gᵀ λ)          again and again, until gap >= 0 and φ = 0

Δ is the least displacement in the norm of the mass matrix. Speeds stay as they are, those of free joints in axes that
do not turn (`free_joints`), so the energy of the machine changes by the work of this displacement against its loads:
V(q + Δ) - V(q) lifts bodies that have sunk into each other in the step. The displacement of each step is kept, and its
work stands in the ledger (`Energy.correction`).
"""

from __future__ import annotations

import math

from ...native.instructions import compiled, greater
from ..cones.block_rows import along
from ..cones.islands import Islands
from .configuration import CLOSED_GAP, answers, close, evaluate, hide, normalize, put_speeds
from .elimination import meet
from .free_joints import fix, release
from .impulses import impulses
from .pairs import deepest, pair_gap
from .stepping_record import NONE, NOT_FINITE, OVERLAP, Run

DEEP = 1e-10
CLOSINGS = 200
"""Limit on the Newton steps that remove overlap. An almost flat edge, lifted at its lowest point, dips on the other
side, three fifths as deep, so this case takes many steps."""
TOLERANCE = 1e-5
"""Residual of the problem of the displacements, relative to the greatest gap: their error is of second order. A rough
one leaves contacts a little open, and the next step does not see them."""
INEXACT = 0.1
"""Residual, relative to the greatest gap, with which a displacement is taken where the solvers end before."""
TINY = 1e-300


@compiled
def correct(run: Run, islands: Islands, t: float) -> int:
    """Move z to gaps >= 0 and φ = 0, the least way in the norm of the mass matrix; return a failure or NONE."""
    depth, error, moved, n_q = 0.0, math.inf, run.moved[run.done], run.machine.n_q
    for i in range(n_q):
        moved[i] = run.z[i]
    for _ in range(CLOSINGS):
        depth = overlap(run, t)
        error = depth
        for i in range(run.holonomic):
            error = greater(error, abs(run.end.phi[i]))
        if error <= DEEP or not math.isfinite(error):
            break
        failure = separate(run, islands, t, depth)
        if failure != NONE:
            return failure
    run.overlap = error
    if not error <= DEEP:
        return OVERLAP if math.isfinite(error) else NOT_FINITE
    run.depth = greater(run.depth, depth)
    for i in range(n_q):
        moved[i] = run.z[i] - moved[i]
    return NONE


@compiled
def overlap(run: Run, t: float) -> float:
    """Evaluate gaps and φ at z; return the greatest depth."""
    depth = 0.0
    if run.machine.looped == 0:
        run.machine.closing(t + run.h, run.z, run.machine.c, run.end.outputs)
        hide(run.contacts, run.end)
    for e in range(run.contacts.count):
        depth = greater(depth, -run.end.gap[e])
        if run.contacts.kept[e] != 0:
            depth = greater(depth, run.end.gap[e])
    return deepest(run, t, depth)


@compiled
def separate(run: Run, islands: Islands, t: float, depth: float) -> int:
    """Move z by one step: 0 <= x ⟂ gap + W Δ >= 0, φ + G Δ = 0 with Δ = M⁻¹ (Wᵀ x + Gᵀ λ)."""
    machine, problem, shift, count = run.machine, run.problem, run.free, run.holonomic
    near = greater(CLOSED_GAP, depth)  # those as near as the deepest one is deep may be met on the way
    run.families.patch.even = near
    failure = evaluate(run, t + run.h, count, near)
    run.families.patch.even = 0.0
    if failure != NONE:
        return failure
    for i in range(machine.n):
        shift[i] = 0.0
    meet(run.elimination, run.W, run.now.phi, count, shift, run.lam)
    close(run, 0, near)
    problem.reference = TINY
    for a in range(problem.count):
        problem.x[a] = 0.0
        gap = run.now.gap[run.contacts.owner[a]] if a < run.contacts.closed else pair_gap(run, a)
        problem.b[a] = gap + along(problem.blocks, problem.rows[a], run.W, shift)
        problem.reference = greater(problem.reference, abs(problem.b[a]))
    answers(run, count)
    goal = greater(TOLERANCE, 0.1 * DEEP / problem.reference)
    if impulses(run, islands, goal) == 0 and not problem.residual <= INEXACT:
        run.overlap = depth
        return OVERLAP
    for i in range(machine.n):
        shift[i] += problem.v[i]
    put_speeds(machine, run.z, shift)
    shifted(run, t)
    return NONE


@compiled
def shifted(run: Run, t: float) -> None:
    """Move the coordinates of z by its speeds, and give it those of the step."""
    machine = run.machine
    machine.moving(t + run.h, run.z, machine.c, run.rate)
    fix(machine, run.z, run.u_new)
    for i in range(machine.n_q):
        run.z[i] += run.rate[i]
    normalize(machine, run.z)
    release(machine, run.z, run.u_new)
    put_speeds(machine, run.z, run.u_new)
