"""The compiled time-stepping loop of Moreau and Jean: contact and friction in velocities and impulses of a step.

    1. midpoint         q_M = q + h/2 q'(q, u),   ū = (u + u⁺)/2;   M, f, W, G at q_M
    2. free velocity    M (u_free - u) = h f(t + h/2, q_M, ū) + J + Gᵀ λ,   G u_free + g = 0      (J: blows in the step)
                        with the normal forces of compliant contacts N(q_M, u) in f
    3. contact problem  u⁺ = u_free + Σ X Λ,   v⁺ = W u⁺ + w   for contacts closed at q_M, or that pressed before:
                        0 <= Λ_N ⟂ v_N⁺ + a_N + e (v_N⁻ - a_N) >= 0,   -Λ_T in μ Λ_N Sgn(v_T⁺ + a_T)
                        with μ of the slip v_T⁺ + a_T, up to μ_s without one (`friction`)
                        with the greatest part of e for which the contacts do no work (`gains`), by Poisson's law as
                        an impulse e Λ (`expansion`), and a of those that
                        stay closed: by what their surfaces turn in half a step (`curvature`)
    4. end              R⁺ = R (1 - h/2 ω̄×)⁻¹ (1 + h/2 ω̄×),   other q⁺ = q + h/2 (q'(q, u) + q'(q⁺, u⁺))
    5. correction       along M⁻¹ Wᵀ and M⁻¹ Gᵀ until gaps >= 0, those of contacts that press 0, and φ = 0

Without impacts and changes of mode this is of second order, in contact, too. For a free body with f = -ω̄ × J ω̄ the
step conserves energy and angular momentum: J (ω⁺ - ω) · ω̄ = 0, and R⁺ J ω⁺ = R J ω is
(1 + h/2 ω̄×) J ω⁺ = (1 - h/2 ω̄×) J ω. The quaternion of Cayley's turn is q + h q'(q, ω̄), normalized.

On a surface of curvature κ that curves away, a contact is open at q_M by κ v² h²/8, and v_N⁻ is a_N = κ v² h/2 there,
which v_N⁺ = -a_N takes back. So contacts that press, and do not rebound, stay closed until their force vanishes
(`Contacts.kept`): if they fell and landed again, their forces would be 0 and 2 N in turn, and each fall a loss.

The friction cones are exact: |Λ_T| <= μ Λ_N, in space the disk itself, not a polygon (`cones.sweeps`,
`cones.islands`). Constraints are eliminated (`elimination`): a step along X keeps G u. Speeds are in block order here:
entry i is speed ``order[i]`` of the model.

Loads that depend on ū are found by iteration (`loads`). The speeds v of free joints are within a step those of their
mass centre in the axes of q_M, and f holds what these do not turn (`free_joints`): spheres need no iteration.

The memory is a record (`stepping_record.Run`). No step allocates or raises.

Sources: M. Jean, Comput. Methods Appl. Mech. Engrg. 177 (1999); V. Acary, B. Brogliato, Numerical Methods for Nonsmooth
Dynamical Systems (2008), chapters 10 and 13; M. Austin, P. S. Krishnaprasad, L.-S. Wang, J. Comput. Phys. 107 (1993)
105-117 (midpoint rule of a rigid body).
"""

from __future__ import annotations

import math

from ...native.instructions import compiled, greater, lesser
from ..cones.block_rows import along, dot, magnitude
from ..cones.collision import HALVINGS
from ..cones.cone import bound
from ..cones.contact_problem import FIRST, LINE, NORMAL
from ..cones.islands import Islands, island_of
from .bearings import AGREE, PASSES, bear
from .configuration import adhere, answers, close, evaluate, give, loads_at, normalize, put_speeds
from .correction import DEEP, correct
from .curvature import after, lasting, returned, set_turns, turned
from .elimination import answer_block, meet
from .expansion import expand, join_expansions
from .free_joints import add_turning, fix, release
from .friction import AGAIN, begin_friction, rub
from .gains import gains
from .impulses import impulses, reached
from .loads import change_loads, imbalance
from .pairs import begin_pairs, log_pairs, mode, press_pairs, room_left, slip, sticking
from .spin import set_spins
from .stepping_record import (
    CLOSED_GAP,
    CONTACTS,
    JAMMED,
    LOADS,
    NONE,
    NOT_FINITE,
    OPEN,
    OPENS,
    Run,
)

BALANCED, ROUNDED = 4e-16, 1e-12
"""Energy norm of h f - p, relative to that of the motion, at which the loads of a step are accepted: at once, and if
it has not halved ``IDLE`` times in a row."""
IDLE = 8
MEANS = 2000
"""Limit on the evaluations of the loads in a step."""
TINY = 1e-300


@compiled
def march(run: Run, islands: Islands) -> int:
    """Do ``run.steps`` steps from y; return the number done. If a step fails, ``run.failure`` says why."""
    run.done, run.failure, run.logged = 0, NONE, 0
    while run.done < run.steps and run.failure == NONE and room_left(run) == 1 and run.problem.stop == 0:
        t = run.times[run.done]
        run.families.sharp = 0
        run.failure = speeds(run, islands, t)
        if run.failure == CONTACTS and run.families.patch.extent > 0.0:  # fewer points press at edges
            run.families.sharp = 1
            run.failure = speeds(run, islands, t)
        if run.failure == NONE:
            run.failure = end_speeds(run)
        if run.failure == NONE:
            account(run)
            advance(run, t)  # 4: q⁺ = q + h/2 (q'(q, u) + q'(q⁺, u⁺)), quaternions by Cayley's rotation
            run.failure = correct(run, islands, t)  # 5: gaps >= 0, φ = 0
        if run.failure == NONE and run.problem.stop == 0:  # a step whose solvers were stopped is no step
            accept(run)
    return run.done


@compiled
def speeds(run: Run, islands: Islands, t: float) -> int:
    """Find the impulses of a step and the speeds after it; return a failure or NONE."""
    failure = midpoint(run, islands, t)  # 1: q_M = q + h/2 q'(q, u)
    if failure != NONE:
        return failure
    return velocities(run, islands, t)  # 2 and 3: M (u⁺ - u) = h f(ū) + J + Gᵀ λ + Wᵀ Λ


# -- 1: the middle of the step -------------------------------------------------------------------------


@compiled
def midpoint(run: Run, islands: Islands, t: float) -> int:
    """Set M, f, W, G at q_M = q + h/2 q'(q, u), and the contacts that are closed there; return a failure or NONE."""
    machine, y, z = run.machine, run.y, run.z
    machine.moving(t, y, machine.c, run.first_rate)
    for i in range(machine.n_q):
        z[i] = y[i] + 0.5 * run.h * run.first_rate[i]
    for i in range(machine.n):
        run.u[i] = y[machine.n_q + machine.order[i]]
    normalize(machine, z)
    fix(machine, y, run.u)
    release(machine, z, run.u)
    put_speeds(machine, z, run.u)
    run.families.pairs.within = -1.0  # those of another state
    failure = evaluate(run, t + 0.5 * run.h, run.constraints, CLOSED_GAP, 1)
    if failure != NONE:
        return failure
    add_turning(run, run.u, run.f)
    close(run, 1, CLOSED_GAP)
    contacts, problem = run.contacts, run.problem
    for a in range(contacts.closed):
        r, e = problem.rows[a], contacts.owner[a]
        contacts.before[a], problem.x[a] = run.rates[r], contacts.guess[r] * (run.h / run.past[0])
        contacts.stays[a] = abs(contacts.kept[e]) if problem.kinds[a] == NORMAL else contacts.stuck[e]
        contacts.half[a], contacts.turn[a] = turned(run, contacts.stays[a], contacts.last[r], run.rates[r])
    give(run, run.given)
    press_pairs(run, t + 0.5 * run.h)
    begin_pairs(run)
    set_spins(run, run.u)
    answers(run, run.constraints)
    set_turns(run, islands)
    adhere(run)
    return NONE


# -- 2 and 3: velocities -------------------------------------------------------------------------------


@compiled
def velocities(run: Run, islands: Islands, t: float) -> int:
    """Find free speeds and impulses with the greatest part of the restitution that makes no energy; return a failure
    or NONE.

    It is halved, in the islands that gain, as that of an impact between events is (`cones.collision`). Where no
    impulses obey the law, there is none either.
    """
    run.expansion.chosen = 0
    failure, turn = balanced(run, islands, t), 0
    while turn <= HALVINGS and failure == NONE and gains(run, islands) != 0:
        turn += 1
        for a in range(run.problem.count):
            b = island_of(run.problem, islands, a)
            if b >= 0 and islands.rebounds[b] > 0:
                run.contacts.rebound[a] = 0.5 * run.contacts.rebound[a] if turn < HALVINGS else 0.0
        failure = balanced(run, islands, t)
    if failure == NONE:
        run.reduced += 1 if turn > 0 else 0
        run.residual = greater(run.residual, greater(run.problem.residual, run.friction.residual))
    return failure


@compiled
def balanced(run: Run, islands: Islands, t: float) -> int:
    """Find free speeds and impulses in which loads, constraints and contacts agree; return a failure or NONE."""
    machine, loads, problem = run.machine, run.loads, run.problem
    for i in range(machine.n):
        loads.p[i] = run.h * (run.f[i] + run.pressed[i]) + loads.rest[i]
    size, best, idle, r, trials, least = 0.0, 0.0, 0, 1.0, 0, run.tolerance
    goal = least
    loads.changes, run.friction.turns = 0, -1 if run.friction.varies > 0 else 0
    if machine.turning == 1:
        goal = greater(run.tolerance, 0.1 * loads.first_error)
    while True:
        failure = solved(run, islands, t, goal, trials)
        if failure != NONE:
            return failure
        if problem.residual > goal:  # so it is for the other problems of the step
            least = reached(run, goal)
        goal = greater(goal, least)
        if machine.turning == 0:
            break
        for i in range(machine.n):
            run.u_mean[i] = run.u[i] + 0.5 * (run.free[i] + problem.v[i])
        put_speeds(machine, run.z, run.u_mean)
        loads_at(machine, t + 0.5 * run.h, run.z, loads.f)
        add_turning(run, run.u_mean, loads.f)
        size = imbalance(run, trials)
        if not math.isfinite(size):
            return NOT_FINITE
        trials += 1
        idle += 1
        if trials == 1 or size < 0.5 * best:
            best, idle = size, 0
        if trials == 1:
            loads.first_error = lesser(size, 0.01)
        if size <= BALANCED or (size <= ROUNDED and idle >= IDLE):
            if goal <= least:
                break
            goal = least
            continue
        if trials > MEANS:
            return LOADS
        r = change_loads(run, r, trials)
        # what the turning of bodies in the equations leaves (`spin`) is of second order
        # once found to a goal, it is not sought to a greater one: where slopes are singular, the two would alternate
        goal = lesser(goal, greater(least, (size if loads.changes == 0 else 0.1) * size))
    return NONE


@compiled
def solved(run: Run, islands: Islands, t: float, goal: float, trials: int) -> int:
    """Find free speeds and impulses with the impulse of the loads, and the limits of friction by loads of joints and by
    slips; return a failure or NONE.
    """
    problem, passes = run.problem, 0
    while True:
        free_velocity(run)  # 2
        contact_rates(run, trials)  # 3
        if run.expansion.poisson == 1 and run.expansion.chosen == 0:
            join_expansions(run, islands)
        if run.friction.turns < 0:
            begin_friction(run, islands, t)
        run.enough = greater(run.accepted, lesser(DEEP / (problem.reference * run.h), run.most_accepted))
        if impulses(run, islands, goal, run.enough, 1 if trials > 0 and run.sweeping.ended == 0 else 0) == 0:
            return CONTACTS
        goal = greater(goal, reached(run, goal))
        if run.bearings.count > 0 and bear(run, t) > AGREE:
            passes += 1
            if passes > PASSES:
                return JAMMED
            continue
        found = rub(run, t, goal) if run.friction.varies > 0 else NONE
        if found == NONE and run.expansion.poisson == 1 and expand(run, islands, goal) == 0:
            found = CONTACTS
        if found != AGAIN:
            return found


@compiled
def end_speeds(run: Run) -> int:
    """Set u⁺; return a failure or NONE."""
    for i in range(run.machine.n):
        run.u_new[i] = run.free[i] + (run.u[i] + run.problem.v[i])
        if not math.isfinite(run.u_new[i]):
            return NOT_FINITE
    return NONE


@compiled
def free_velocity(run: Run) -> None:
    """Set u_free - u = M⁻¹ (p + J + Gᵀ λ), with λ for which G u_free + g = 0."""
    loads, blocks = run.loads, run.problem.blocks
    for i in range(blocks.n):
        loads.rest[i] = loads.p[i] - run.h * (run.f[i] + run.pressed[i])
        run.momentum[i] = loads.p[i] + run.blow[i]
    for b in range(blocks.count):
        first = blocks.starts[b]
        answer_block(run.elimination, b, run.momentum[first:], run.free[first:])
    meet(run.elimination, run.W, run.constraint_rates, run.constraints, run.free, run.lam)


@compiled
def contact_rates(run: Run, trials: int) -> None:
    """Set the rates b = W u_free + w, those of normals plus e v_N⁻; at the first trial choose e and the reference.

    There is no rebound where the forces of a single step reverse it: it ends within the step.
    """
    contacts, problem, blocks = run.contacts, run.problem, run.problem.blocks
    if trials == 0:
        problem.reference = TINY
    for a in range(problem.count):
        r, before = problem.rows[a], contacts.before[a]
        problem.b[a] = before + along(blocks, r, run.W, run.free)
        if trials == 0:
            change, turn = problem.b[a] - before, contacts.turn[a]
            if not contacts.rebound[a] * (turn - before) > -change - 2.0 * turn:
                contacts.rebound[a] = 0.0
            problem.reference = greater(problem.reference, magnitude(blocks, r, run.W, run.u, run.free))
            # what the friction of a given normal force can change, since its own row is zero
            problem.reference = greater(problem.reference, problem.scale[a] * problem.low[a])
        problem.b[a] += returned(run, a)
        if trials == 0:
            problem.reference = greater(problem.reference, abs(problem.b[a]))


# -- 4: the end of the step ----------------------------------------------------------------------------


@compiled
def account(run: Run) -> None:
    """Write the impulses and modes of the step, and its work: of contacts and blows, Λ·(v⁻ + v⁺)/2 + J·ū; λ·G ū."""
    contacts, problem, elimination = run.contacts, run.problem, run.elimination
    k, struck, held = run.done, 0.0, 0.0
    for r in range(contacts.rows):
        contacts.guess[r] = 0.0
    for e in range(contacts.count):
        run.modes[k * contacts.count + e] = OPEN
        contacts.kept[e] = OPENS
        contacts.stuck[e] = OPENS
    for a in range(problem.count):
        if a < contacts.closed:
            contacts.guess[problem.rows[a]] = problem.x[a]
        for i in range(run.constraints):
            run.lam[i] -= elimination.sigma[a, i] * problem.x[a]
        speed = after(run, a)
        if a < contacts.closed:
            contacts.last[problem.rows[a], 0], contacts.last[problem.rows[a], 1] = speed, contacts.half[a]
        if problem.kinds[a] == NORMAL:
            if problem.x[a] > 0.0 and a < contacts.closed:
                e = contacts.owner[a]
                run.modes[k * contacts.count + e] = mode(run, a)
                stay(run, a)
        elif contacts_resist(run, a) == 1 and problem.x[bound(problem, a)] > 0.0:
            run.modes[k * contacts.count + contacts.owner[a]] = slip(run, a)
        struck += 0.5 * problem.x[a] * (contacts.before[a] + speed)
    log_pairs(run)
    for r in range(contacts.rows):
        run.impulses[k, r] = contacts.guess[r]
    for a in range(contacts.closed):
        if problem.kinds[a] == NORMAL:
            run.impulses[k, problem.rows[a]] -= run.h * contacts.pull[contacts.owner[a]]
    for i in range(run.machine.n):
        run.u_mean[i] = 0.5 * (run.u[i] + run.u_new[i])
    for i in range(run.constraints):
        r = contacts.rows + i
        run.impulses[k, r] = run.lam[i]
        held += run.lam[i] * along(problem.blocks, r, run.W, run.u_mean)
    struck += run.h * (run.pressing[0] + dot(run.pressed, run.u_mean, run.machine.n))
    struck -= run.h * dot(run.pressed, run.u, run.machine.n)
    run.works[k, 0] = struck + dot(run.blow, run.u_mean, run.machine.n)
    run.works[k, 1] = held


@compiled
def stay(run: Run, a: int) -> None:
    """Keep how long the contact whose normal is row ``a``, which presses, has stayed closed and stuck."""
    contacts, e = run.contacts, run.contacts.owner[a]
    contacts.kept[e] = OPENS if contacts.held[e] != 0 else lasting(run, a)
    contacts.stuck[e] = sticking(run, a) if contacts.kept[e] != OPENS else OPENS


@compiled
def contacts_resist(run: Run, a: int) -> int:
    """Return 1 if what resists rolling or spinning begins at row ``a``."""
    problem = run.problem
    begins = problem.kinds[a] == LINE or problem.kinds[a] == FIRST
    return 1 if a < run.contacts.closed and begins and problem.between[a] > 0 else 0


@compiled
def advance(run: Run, t: float) -> None:
    """Set z to the end of the step, and add the work of the loads."""
    machine, y, z, h = run.machine, run.y, run.z, run.h
    put_speeds(machine, z, run.u_mean)
    machine.moving(t + 0.5 * h, z, machine.c, run.rate)
    run.works[run.done, 1] += h * run.rate[machine.n_q]
    fix(machine, z, run.u_new)
    if machine.n_quaternions > 0:
        for i in range(machine.n_q):
            z[i] = y[i]
        machine.moving(t, z, machine.c, run.rate)
    for i in range(machine.n_q):
        z[i] = y[i] + h * run.rate[i]
    normalize(machine, z)
    release(machine, z, run.u_new)
    put_speeds(machine, z, run.u_new)
    if machine.n_quaternions > 0:
        machine.moving(t + h, z, machine.c, run.rate)
        for i in range(machine.n_q):
            if machine.turned[i] == 0:
                z[i] = y[i] + 0.5 * h * (run.first_rate[i] + run.rate[i])


@compiled
def accept(run: Run) -> None:
    """Take the step to z."""
    n = run.machine.n_q + run.machine.n
    for i in range(n):
        run.y[i] = run.z[i]
        run.states[run.done, i] = run.z[i]
    for i in range(run.machine.n):
        run.blow[i] = 0.0
    run.past[0], run.past[1] = run.h, run.past[0]
    run.done += 1
