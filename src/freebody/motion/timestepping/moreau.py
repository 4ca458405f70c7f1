"""The compiled time-stepping loop of Moreau and Jean: contact and friction in velocities and impulses of a step.

    1. midpoint         q_M = q + h/2 q'(q, u),   ū = (u + u⁺)/2;   M, f, W, G at q_M
    2. free velocity    M (u_free - u) = h f(t + h/2, q_M, ū) + J + Gᵀ λ,   G u_free + g = 0      (J: blows in the step)
    3. contact problem  u⁺ = u_free + Σ X Λ,   v⁺ = W u⁺ + w   for contacts closed at q_M:
                        0 <= Λ_N ⟂ v_N⁺ + e v_N⁻ >= 0,   -Λ_T in μ Λ_N Sgn(v_T⁺)
    4. end              R⁺ = R (1 - h/2 ω̄×)⁻¹ (1 + h/2 ω̄×),   other q⁺ = q + h/2 (q'(q, u) + q'(q⁺, u⁺))
    5. correction       along M⁻¹ Wᵀ and M⁻¹ Gᵀ until gaps >= 0, φ = 0

Without contact this is of second order. For a free body with f = -ω̄ × J ω̄ the step conserves energy and angular
momentum: J (ω⁺ - ω) · ω̄ = 0, and R⁺ J ω⁺ = R J ω is (1 + h/2 ω̄×) J ω⁺ = (1 - h/2 ω̄×) J ω. The quaternion of
Cayley's turn is q + h q'(q, ω̄), normalized.

The friction cones are exact: |Λ_T| <= μ Λ_N, in space the disk itself, not a polygon (`cones.sweeps`). Constraints
are eliminated (`elimination`): a step along X keeps G u. Speeds are in block order here: entry i is speed ``order[i]``
of the model.

The impulse p = h f(ū) is the fixed point of p → p + r (h f(ū(p)) - p), where ū(p) solves the contacts. r is 1, and
less where bodies turn far in a step: with the last change Δe of e = h f - p it minimizes |e + r Δe/r_last|.

The memory is a record (`stepping_record.Run`). No step allocates or raises.

Sources: M. Jean, Comput. Methods Appl. Mech. Engrg. 177 (1999); V. Acary, B. Brogliato, Numerical Methods for Nonsmooth
Dynamical Systems (2008), chapters 10 and 13; M. Austin, P. S. Krishnaprasad, L.-S. Wang, J. Comput. Phys. 107 (1993)
105-117 (midpoint rule of a rigid body); J. Barzilai, J. M. Borwein, IMA J. Numer. Anal. 8 (1988) 141-148 (r).
"""

from __future__ import annotations

import math

from ...native.instructions import Reals, compiled, greater, lesser, root
from ..cones.block_rows import along, dot
from ..cones.cone import set_scales
from ..cones.contact_problem import FIRST, LINE, NORMAL, SECOND, Blocks
from ..cones.sweeps import solve
from .elimination import answer, block_back, factor, hold, meet
from .stepping_record import (
    BACKWARDS,
    CONSTRAINTS,
    CONTACTS,
    FORWARDS,
    LOADS,
    MASS,
    NONE,
    NOT_FINITE,
    OPEN,
    OVERLAP,
    SLIP,
    STICK,
    Contacts,
    Gaps,
    Machine,
    Run,
)

CLOSED_GAP = 1e-10
DEEP = 1e-10
FAR = 1e300
CLOSINGS = 200
"""Limit on the Newton steps that remove overlap. An almost flat edge, lifted at its lowest point, dips on the other
side, three fifths as deep, so this case takes many steps."""
BALANCED, ROUNDED = 4e-16, 1e-12
"""Energy norm of h f - p, relative to that of the motion, at which the loads of a step are accepted: at once, and if
it has not halved ``IDLE`` times in a row."""
IDLE = 8
MEANS = 2000
"""Limit on the evaluations of the loads in a step."""
SHORTEST = 1e-4
"""Least r."""
TINY = 1e-300


@compiled
def march(run: Run) -> int:
    """Do ``run.steps`` steps from y; return the number done. If a step fails, ``run.failure`` says why."""
    run.done, run.failure = 0, NONE
    while run.done < run.steps and run.failure == NONE:
        t = run.t + run.done * run.h
        run.failure = midpoint(run, t)
        if run.failure == NONE:
            run.failure = velocities(run, t)  # 2 and 3, until the loads agree with the mean speeds
        if run.failure == NONE:
            account(run)
            advance(run, t)
            run.failure = correct(run, t)
        if run.failure == NONE:
            accept(run)
    return run.done


# -- 1: the middle of the step -------------------------------------------------------------------------


@compiled
def midpoint(run: Run, t: float) -> int:
    """Set M, f, W, G at q_M = q + h/2 q'(q, u), and the contacts that are closed there; return a failure or NONE."""
    machine, y, z = run.machine, run.y, run.z
    machine.moving(t, y, machine.c, run.first_rate)
    for i in range(machine.n_q):
        z[i] = y[i] + 0.5 * run.h * run.first_rate[i]
    for i in range(machine.n):
        z[machine.n_q + i] = y[machine.n_q + i]
        run.u[i] = y[machine.n_q + machine.order[i]]
    normalize(machine, z)
    failure = evaluate(run, t + 0.5 * run.h, run.constraints)
    if failure != NONE:
        return failure
    close(run, 1)
    contacts, problem = run.contacts, run.problem
    for a in range(problem.count):
        r = problem.rows[a]
        contacts.before[a], problem.x[a] = run.rates[r], contacts.guess[r]
    answers(run, run.constraints)
    return NONE


@compiled
def evaluate(run: Run, t: float, constraints: int) -> int:
    """Evaluate the machine at z, and factor M and the first ``constraints`` constraints; return a failure or NONE."""
    run.machine.system(t, run.z, run.machine.c, run.outputs)
    hide(run.contacts, run.now)
    if factor(run.elimination, run.M) == 0:
        return MASS
    if hold(run.elimination, run.W, constraints) == 0:
        return CONSTRAINTS
    return NONE


@compiled
def normalize(machine: Machine, y: Reals) -> None:
    """Divide each quaternion of a state by its norm."""
    for k in range(machine.n_quaternions):
        q = y[machine.quaternions[k] :]
        length = root(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
        for j in range(4):
            q[j] /= length


@compiled
def put_speeds(machine: Machine, y: Reals, u: Reals) -> None:
    """Write speeds in block order into a state."""
    for i in range(machine.n):
        y[machine.n_q + machine.order[i]] = u[i]


@compiled
def hide(contacts: Contacts, gaps: Gaps) -> None:
    """Set the gap of a contact to ``FAR`` if its foot lies beyond the end of its side."""
    for k in range(contacts.reaches):
        if gaps.reach[k] < 0.0:
            gaps.gap[contacts.reach_of[k]] = FAR


@compiled
def close(run: Run, friction: int) -> None:
    """Set the rows of the problem to those of the closed contacts; tangent rows only if ``friction`` is not 0."""
    contacts, problem = run.contacts, run.problem
    count, row = 0, 0
    for e in range(contacts.count):
        tangents = contacts.tangents[e]
        if run.now.gap[e] <= CLOSED_GAP:
            for k in range(1 + tangents if friction != 0 else 1):
                problem.rows[count], problem.mu[count] = row + k, contacts.mu[e]
                problem.kinds[count] = NORMAL if k == 0 else (LINE if tangents == 1 else FIRST + k - 1)
                contacts.owner[count], contacts.rebound[count] = e, contacts.restitution[e]
                count += 1
        row += 1 + tangents
    problem.count = count


@compiled
def answers(run: Run, constraints: int) -> None:
    """Compute X and σ of the rows of the problem, and the part of A = W X of each contact."""
    problem, blocks, W, X = run.problem, run.problem.blocks, run.W, run.problem.X
    A, kinds = problem.matrix, problem.kinds
    for a in range(problem.count):
        r = problem.rows[a]
        answer(run.elimination, r, W, X, run.elimination.sigma[a], constraints)
        A[a, 0] = joined(blocks, r, r, W, X)
        if kinds[a] == LINE or kinds[a] == SECOND:
            A[a - 1, 1] = joined(blocks, r - 1, r, W, X)
        if kinds[a] == SECOND:
            A[a - 2, 1] = joined(blocks, r - 2, r - 1, W, X)
            A[a - 2, 2] = joined(blocks, r - 2, r, W, X)
    set_scales(problem)


@compiled
def joined(blocks: Blocks, r: int, k: int, W: Reals, X: Reals) -> float:
    """Return W_r X_k of two rows over the same blocks, as those of a contact."""
    return dot(W[blocks.at[r] :], X[blocks.at[k] :], blocks.at[r + 1] - blocks.at[r])


# -- 2 and 3: velocities -------------------------------------------------------------------------------


@compiled
def velocities(run: Run, t: float) -> int:
    """Find u⁺ and the impulses in which loads, constraints and contacts agree; return a failure or NONE."""
    machine, loads, problem = run.machine, run.loads, run.problem
    for i in range(machine.n):
        loads.p[i] = run.h * run.f[i] + loads.rest[i]
    size, best, idle, r, trials, changes, goal = 0.0, 0.0, 0, 1.0, 0, 0, run.tolerance
    if machine.turning == 1:
        goal = greater(run.tolerance, 0.1 * loads.first_error)
    while True:
        free_velocity(run)
        contact_rates(run, trials)
        sweeps = solve(problem, run.sweeping, goal, run.most_sweeps)
        if sweeps < 0:
            return CONTACTS
        run.sweeps += sweeps
        if machine.turning == 0:
            break
        for i in range(machine.n):
            run.u_mean[i] = run.u[i] + 0.5 * (run.free[i] + problem.v[i])
        put_speeds(machine, run.z, run.u_mean)
        machine.loading(t + 0.5 * run.h, run.z, machine.c, loads.f)
        size = imbalance(run)
        if not math.isfinite(size):
            return NOT_FINITE
        trials += 1
        idle += 1
        if trials == 1 or size < 0.5 * best:
            best, idle = size, 0
        if trials == 1:
            loads.first_error = lesser(size, 0.01)
        if size <= BALANCED or (size <= ROUNDED and idle >= IDLE):
            if goal <= run.tolerance:
                break
            goal = run.tolerance
            continue
        if trials > MEANS:
            return LOADS
        r = change_loads(run, r, changes)
        changes += 1
        goal = greater(run.tolerance, 0.1 * size)
    run.residual = greater(run.residual, problem.residual)
    for i in range(machine.n):
        run.u_new[i] = run.free[i] + (run.u[i] + problem.v[i])
        if not math.isfinite(run.u_new[i]):
            return NOT_FINITE
    return NONE


@compiled
def free_velocity(run: Run) -> None:
    """Set u_free - u = M⁻¹ (p + J + Gᵀ λ), with λ for which G u_free + g = 0."""
    loads, blocks = run.loads, run.problem.blocks
    for i in range(blocks.n):
        loads.rest[i] = loads.p[i] - run.h * run.f[i]
        run.momentum[i] = loads.p[i] + run.blow[i]
    for b in range(blocks.count):
        first = blocks.starts[b]
        block_back(run.elimination, b, run.momentum[first:], run.free[first:])
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
            if not -contacts.rebound[a] * before > before - problem.b[a]:
                contacts.rebound[a] = 0.0
            problem.reference = greater(problem.reference, magnitude(blocks, r, run.W, run.u, run.free))
        if problem.kinds[a] == NORMAL:
            problem.b[a] += contacts.rebound[a] * before
        if trials == 0:
            problem.reference = greater(problem.reference, abs(problem.b[a]))


@compiled
def magnitude(blocks: Blocks, r: int, W: Reals, u: Reals, v: Reals) -> float:
    """Return Σ |W_ri (u + v)_i|."""
    total, k = 0.0, blocks.at[r]
    for p in range(blocks.first[r], blocks.first[r + 1]):
        b = blocks.pieces[p]
        for i in range(blocks.starts[b], blocks.starts[b + 1]):
            total += abs(W[k] * (u[i] + v[i]))
            k += 1
    return total


@compiled
def imbalance(run: Run) -> float:
    """Set e = h f - p and M⁻¹ e; return |e| relative to the motion, √(e·M⁻¹e / (u·M u + p·M⁻¹p))."""
    loads, blocks, whole = run.loads, run.problem.blocks, TINY
    for i in range(blocks.n):
        loads.e[i] = run.h * loads.f[i] - loads.p[i]
    for b in range(blocks.count):
        first, size = blocks.starts[b], blocks.starts[b + 1] - blocks.starts[b]
        block_back(run.elimination, b, loads.p[first:], loads.Me[first:])
        whole += dot(loads.p[first:], loads.Me[first:], size)
        block_back(run.elimination, b, loads.e[first:], loads.Me[first:])
        L = run.elimination.L[blocks.squares[b] :]
        for j in range(size):  # Lᵀ u
            total = 0.0
            for i in range(j, size):
                total += L[i * size + j] * run.u[first + i]
            whole += total * total
    return root(dot(loads.e, loads.Me, blocks.n) / whole)


@compiled
def change_loads(run: Run, r: float, changes: int) -> float:
    """Add r e to p, with the r that minimizes |e + r Δe/r_last| (1 the first time); return r."""
    loads, n = run.loads, run.machine.n
    if changes > 0:
        along_e, whole = 0.0, 0.0
        for i in range(n):
            change = loads.e_old[i] - loads.e[i]
            along_e += change * loads.Me_old[i]
            whole += change * (loads.Me_old[i] - loads.Me[i])
        r = 1.0 if whole == 0.0 else lesser(1.0, greater(SHORTEST, r * along_e / whole))
    for i in range(n):
        loads.e_old[i], loads.Me_old[i] = loads.e[i], loads.Me[i]
        loads.p[i] += r * loads.e[i]
    return r


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
    for a in range(problem.count):
        contacts.guess[problem.rows[a]] = problem.x[a]
        for i in range(run.constraints):
            run.lam[i] -= elimination.sigma[a, i] * problem.x[a]
        after = problem.r[a]
        if problem.kinds[a] == NORMAL:
            after -= contacts.rebound[a] * contacts.before[a]
            if problem.x[a] > 0.0:
                run.modes[k * contacts.count + contacts.owner[a]] = mode(run, a)
        struck += 0.5 * problem.x[a] * (contacts.before[a] + after)
    for r in range(contacts.rows):
        run.impulses[k, r] = contacts.guess[r]
    for i in range(run.machine.n):
        run.u_mean[i] = 0.5 * (run.u[i] + run.u_new[i])
    for i in range(run.constraints):
        r = contacts.rows + i
        run.impulses[k, r] = run.lam[i]
        held += run.lam[i] * along(problem.blocks, r, run.W, run.u_mean)
    run.works[k, 0] = struck + dot(run.blow, run.u_mean, run.machine.n)
    run.works[k, 1] = held


@compiled
def mode(run: Run, a: int) -> int:
    """Return the mode of the pressed contact whose normal is row ``a``."""
    problem = run.problem
    still, last = 100.0 * run.tolerance * problem.reference, problem.count - 1
    if a < last and problem.kinds[a + 1] == LINE:
        v = problem.r[a + 1]
        return FORWARDS if v > still else (BACKWARDS if v < -still else STICK)
    if a < last and problem.kinds[a + 1] == FIRST:
        v, w = problem.r[a + 1], problem.r[a + 2]
        return SLIP if v * v + w * w > still * still else STICK
    return STICK


@compiled
def advance(run: Run, t: float) -> None:
    """Set z to the end of the step, and add the work of the loads."""
    machine, y, z, h = run.machine, run.y, run.z, run.h
    put_speeds(machine, z, run.u_mean)
    machine.moving(t + 0.5 * h, z, machine.c, run.rate)
    run.works[run.done, 1] += h * run.rate[machine.n_q]
    if machine.n_quaternions > 0:
        for i in range(machine.n_q):
            z[i] = y[i]
        machine.moving(t, z, machine.c, run.rate)
    for i in range(machine.n_q):
        z[i] = y[i] + h * run.rate[i]
    put_speeds(machine, z, run.u_new)
    if machine.n_quaternions > 0:
        normalize(machine, z)
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
    run.done += 1


# -- 5: correction -------------------------------------------------------------------------------------


@compiled
def correct(run: Run, t: float) -> int:
    """Move z to gaps >= 0 and φ = 0, the least way in the norm of the mass matrix; return a failure or NONE."""
    depth, error = 0.0, math.inf
    for _ in range(CLOSINGS):
        depth = overlap(run, t)
        error = depth
        for i in range(run.holonomic):
            error = greater(error, abs(run.end.phi[i]))
        if error <= DEEP or not math.isfinite(error):
            break
        failure = separate(run, t, depth)
        if failure != NONE:
            return failure
    run.overlap = error
    if not error <= DEEP:
        return OVERLAP if math.isfinite(error) else NOT_FINITE
    run.depth = greater(run.depth, depth)
    return NONE


@compiled
def overlap(run: Run, t: float) -> float:
    """Evaluate gaps and φ at z; return the greatest depth."""
    depth = 0.0
    run.machine.closing(t + run.h, run.z, run.machine.c, run.end.outputs)
    hide(run.contacts, run.end)
    for e in range(run.contacts.count):
        depth = greater(depth, -run.end.gap[e])
    return depth


@compiled
def separate(run: Run, t: float, depth: float) -> int:
    """Move z by one step: 0 <= x ⟂ gap + W Δ >= 0, φ + G Δ = 0 with Δ = M⁻¹ (Wᵀ x + Gᵀ λ)."""
    machine, problem, shift, count = run.machine, run.problem, run.free, run.holonomic
    failure = evaluate(run, t + run.h, count)
    if failure != NONE:
        return failure
    for i in range(machine.n):
        shift[i] = 0.0
    meet(run.elimination, run.W, run.now.phi, count, shift, run.lam)
    close(run, 0)
    problem.reference = TINY
    for a in range(problem.count):
        problem.x[a] = 0.0
        gap = run.now.gap[run.contacts.owner[a]]
        problem.b[a] = gap + along(problem.blocks, problem.rows[a], run.W, shift)
        problem.reference = greater(problem.reference, abs(problem.b[a]))
    answers(run, count)
    goal = greater(1e-9, 0.1 * DEEP / problem.reference)
    if solve(problem, run.sweeping, goal, run.most_sweeps) < 0:
        run.overlap = depth
        return OVERLAP
    for i in range(machine.n):
        shift[i] += problem.v[i]
    put_speeds(machine, run.z, shift)
    machine.moving(t + run.h, run.z, machine.c, run.rate)
    for i in range(machine.n_q):
        run.z[i] += run.rate[i]
    put_speeds(machine, run.z, run.u_new)
    normalize(machine, run.z)
    return NONE
