"""The correction at the end of a step: bodies out of each other, and conditions on coordinates met.

    0 <= x ⟂ gap + W Δ >= 0,   φ + G Δ = 0,   Δ = M⁻¹ (Wᵀ x + Gᵀ λ)          again and again, until gap >= 0 and φ = 0

Δ is the least displacement in the norm of the mass matrix. A contact that pressed in the step, and stays closed, is
pulled shut, too: x >= -h Λ, by no more than what presses it can move in a step. Where that does not suffice, as where
a table has more feet than can touch a dome at once, it hangs: it stays open until the next step (`hang`).

The displacement lifts what has sunk into each other in the step, by V(q + Δ) - V(q). A contact that pressed in the
step keeps its speed, in axes that do not turn (`free_joints`). One that flies, and has closed since the middle of the
step, met its surface with less speed, so that a bounce gains no height:

    u⁺ = u + s Δ,    s u·M Δ + s²/2 Δ·M Δ = f·Δ        Δ of the contacts that fly alone, for each island of contacts

The change of q and u of each step is kept, and its energy stands in the ledger (`Energy.correction`).
"""

from __future__ import annotations

import math

from ...native.instructions import compiled, greater, root
from ..cones.block_rows import add, along
from ..cones.dual import is_bare, take_in
from ..cones.islands import Islands, connect, island_of
from .configuration import FAR, answers, close, evaluate, hide, normalize, put_speeds
from .elimination import meet
from .free_joints import fix, release
from .impulses import impulses
from .pairs import deepest, faced, hang, pair_gap, pair_rate, pressed
from .spin import leave_spins
from .stepping_record import CLOSED_GAP, NONE, NOT_FINITE, OPEN, OPENS, OVERLAP, Displaced, Run

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
    depth, error, moved, n = 0.0, math.inf, run.moved[run.done], run.machine.n_q + run.machine.n
    for i in range(n):
        moved[i] = run.z[i]
    for k in range(CLOSINGS):
        turn = k if k < 2 else 2
        depth = overlap(run, t, run.expected[turn])
        error, run.expected[turn] = depth, 2.0 * greater(CLOSED_GAP, depth)
        for i in range(run.holonomic):
            error = greater(error, abs(run.end.phi[i]))
        if error <= DEEP or not math.isfinite(error):
            break
        failure, laid = NONE, 0
        if k == 0:
            remember(run.first, run.displaced)
        if k == 0 and lands(run) == 1:
            failure, laid = slow(run, islands, t, depth), 1 if run.constraints == run.holonomic else 0
        if failure == NONE and laid == 0:
            failure = lay(run, t, depth, run.holonomic)
        if failure == NONE:
            failure = separate(run, islands, t, depth)
        if failure != NONE:
            return failure
        if k == 0:
            remember(run.displaced, run.first)
    run.overlap = error
    if not error <= DEEP:
        return OVERLAP if math.isfinite(error) else NOT_FINITE
    run.depth = greater(run.depth, depth)
    for i in range(n):
        moved[i] = run.z[i] - moved[i]
    return NONE


@compiled
def overlap(run: Run, t: float, near: float) -> float:
    """Evaluate gaps and φ at z; return the greatest depth. Pairs are found up to ``near``."""
    depth = 0.0
    if run.machine.looped == 0:
        run.machine.closing(t + run.h, run.z, run.machine.c, run.end.outputs)
        hide(run.contacts, run.end)
    for e in range(run.contacts.count):
        depth = greater(depth, -run.end.gap[e])
        if run.end.gap[e] >= FAR:  # beyond the end of its side
            run.contacts.kept[e] = OPENS
        if run.contacts.kept[e] > OPENS:
            depth = greater(depth, run.end.gap[e])
    return deepest(run, t, depth, near)


@compiled
def lands(run: Run) -> int:
    """Return 1 if a contact without impulses in the step is closed at its end (`overlap`)."""
    contacts, pairs = run.contacts, run.families.pairs
    for e in range(contacts.count):
        if run.end.gap[e] < -DEEP and contacts.held[e] == 0 and opened(run, e) == 1:
            return 1
    for c in range(pairs.count):
        if pairs.touch[pairs.slots[c], 0] < -DEEP and pressed(pairs, c) == 0:
            return 1
    return 0


@compiled
def opened(run: Run, e: int) -> int:
    """Return 1 if a contact had no impulses in the step."""
    return 1 if run.modes[run.done * run.contacts.count + e] == OPEN and run.contacts.kept[e] == OPENS else 0


@compiled
def flies(run: Run, a: int) -> int:
    """Return 1 if the contact of row ``a`` of the problem had no impulses in the step."""
    e = run.contacts.owner[a]
    return opened(run, e) if a < run.contacts.closed else 1 - pressed(run.families.pairs, e)


@compiled
def slow(run: Run, islands: Islands, t: float, depth: float) -> int:
    """Take what the displacement of contacts that fly adds to the potential from their approach; return a failure or
    NONE.

    An approach that the loads of a single step give is left: it has no rebound, and the next step stops it, with
    friction. This is how contacts go on on surfaces that curve away.
    """
    machine, problem, energy = run.machine, run.problem, islands.energy
    for i in range(machine.n):
        run.u_mean[i] = 0.0
    put_speeds(machine, run.z, run.u_mean)  # f without terms of the speeds, which do no work
    failure = lay(run, t, depth, run.constraints)
    put_speeds(machine, run.z, run.u_new)
    if failure != NONE or approach(run) == 0:
        return failure
    if solved(run, islands, depth, 0) == 0:
        return OVERLAP
    connect(problem, islands)
    for b in range(problem.blocks.count):
        for k in range(3):
            energy[b, k] = 0.0
    for a in range(problem.count):
        b, r, x = island_of(problem, islands, a), problem.rows[a], problem.x[a]
        if b >= 0:
            energy[b, 0] += x * closing_rate(run, a)
            energy[b, 1] += x * along(problem.blocks, r, run.W, problem.v)
            energy[b, 2] += along(problem.blocks, r, problem.X, run.momentum) * x
    for b in range(problem.blocks.count):
        p, q, work = energy[b, 0], energy[b, 1], energy[b, 2]
        energy[b, 0] = 0.0
        if work < 0.0 and -p > -work * run.h:
            energy[b, 0] = -2.0 * work / (root(greater(p * p + 2.0 * q * work, 0.0)) - p)
    for a in range(problem.count):
        b = island_of(problem, islands, a)
        if b >= 0:
            add(problem.blocks, problem.rows[a], problem.X, energy[b, 0] * problem.x[a], run.u_new)
    put_speeds(machine, run.z, run.u_new)
    return NONE


@compiled
def approach(run: Run) -> int:
    """Set the gaps of the problem of contacts that fly; return 1 if one approaches faster than the loads of a step
    make it.

    Without one, ``-p > -work h`` holds in no island.
    """
    problem, fast = run.problem, 0
    for i in range(run.machine.n):
        run.momentum[i] = run.f[i] + run.pressed[i]
    for a in range(problem.count):
        gap = gap_of(run, a)
        problem.b[a] = 0.0 if gap < 0.0 and flies(run, a) == 0 else gap
        change = run.h * along(problem.blocks, problem.rows[a], problem.X, run.momentum)
        if closing_rate(run, a) < change:
            fast = 1
    return fast


@compiled
def closing_rate(run: Run, a: int) -> float:
    """Return the rate of the gap of row ``a`` of the problem with the new speeds, where z has none."""
    r = run.problem.rows[a]
    own = run.rates[r] if a < run.contacts.closed else pair_rate(run, a)
    return own + along(run.problem.blocks, r, run.W, run.u_new)


@compiled
def gap_of(run: Run, a: int) -> float:
    """Return the gap of row ``a`` of the problem."""
    return run.now.gap[run.contacts.owner[a]] if a < run.contacts.closed else pair_gap(run, a)


@compiled
def lay(run: Run, t: float, depth: float, constraints: int) -> int:
    """Set the rows of the problem of a displacement at z, and their answers; return a failure or NONE."""
    near = greater(CLOSED_GAP, depth)  # those as near as the deepest one is deep may be met on the way
    run.families.patch.even = near
    failure = evaluate(run, t + run.h, constraints, near, 0)
    run.families.patch.even = 0.0
    if failure == NONE:
        close(run, 0, near)
        leave_spins(run)
        answers(run, constraints)
        run.factored = 0
    return failure


@compiled
def solved(run: Run, islands: Islands, depth: float, moves: int) -> int:
    """Solve 0 <= x ⟂ b + W Δ >= 0 from the contacts that press in `Run.displaced`; return 1 on success, else 0.

    The impulses of all displacements that move z, ``moves`` 1, are those of one: a later one may take some back.
    """
    problem, borne, displaced, k = run.problem, run.borne, run.displaced, 0
    problem.reference = TINY
    crowded = 1 if 2 * problem.count > problem.blocks.n or faced(run) == 1 else 0  # sweeps would not end soon
    for a in range(problem.count):
        while k < displaced.count and displaced.numbers[k] < number(run, a):
            k += 1
        known = k < displaced.count and displaced.numbers[k] == number(run, a)
        borne[a] = displaced.impulses[k] if known else 0.0
        problem.x[a] = TINY if known and (crowded == 1 or borne[a] > 0.0) else 0.0
        if problem.b[a] < 0.0 or problem.low[a] < 0.0:  # one that hangs is wider open than this step moves it
            problem.reference = greater(problem.reference, abs(problem.b[a]))
        problem.low[a] -= borne[a]
    goal = greater(TOLERANCE, 0.1 * DEEP / problem.reference)
    if crowded == 0 or solved_at_once(run, islands, goal) == 0:
        run.factored = 0
        if impulses(run, islands, goal, 0.0, crowded) == 0 and not problem.residual <= INEXACT:
            run.overlap = depth
            return 0
    displaced.count = 0
    for a in range(problem.count):
        problem.x[a] = 0.0 if problem.x[a] == TINY else problem.x[a]
        if problem.x[a] > problem.low[a]:
            k = displaced.count
            displaced.numbers[k] = number(run, a)
            displaced.impulses[k] = borne[a] + problem.x[a] if moves == 1 else 0.0
            displaced.count += 1
    return 1


@compiled
def solved_at_once(run: Run, islands: Islands, goal: float) -> int:
    """Solve the problem of a displacement by the dual method, all islands together; return 1 on success, else 0."""
    problem, dense = run.problem, islands.dense
    if problem.count > dense.most or problem.blocks.n > islands.speeds or is_bare(problem) == 0:
        return 0
    problem.residual = take_in(problem, dense, goal, run.factored)
    run.factored = 1
    return 1 if problem.residual <= goal else 0


@compiled
def remember(found: Displaced, displaced: Displaced) -> None:
    """Keep the contacts that press in a displacement for another one, without impulses."""
    displaced.count = found.count
    for k in range(found.count):
        displaced.numbers[k], displaced.impulses[k] = found.numbers[k], 0.0


@compiled
def number(run: Run, a: int) -> int:
    """Return a number of the contact of row ``a`` of the problem, by which it is known in other problems."""
    e = run.contacts.owner[a]
    return e if a < run.contacts.closed else run.contacts.count + run.families.pairs.ids[e]


@compiled
def separate(run: Run, islands: Islands, t: float, depth: float) -> int:
    """Move z by one step, 0 <= x ⟂ gap + W Δ >= 0, φ + G Δ = 0 with Δ = M⁻¹ (Wᵀ x + Gᵀ λ), whose rows are laid."""
    machine, problem, shift, count = run.machine, run.problem, run.free, run.holonomic
    for i in range(machine.n):
        shift[i] = 0.0
    meet(run.elimination, run.W, run.now.phi, count, shift, run.lam)
    for a in range(problem.count):
        problem.b[a] = gap_of(run, a) + along(problem.blocks, problem.rows[a], run.W, shift)
    if solved(run, islands, depth, 1) == 0:
        return OVERLAP
    for a in range(problem.count):
        pulls = problem.low[a] + run.borne[a] < 0.0
        if pulls and problem.r[a] > problem.scale[a] * (problem.x[a] - problem.low[a]):
            hang(run, a)
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
