"""The machine in the middle or at the end of a step: M, f, W and G there, and the contacts that are closed."""

from __future__ import annotations

from ...native.instructions import Reals, compiled, inlined
from ..cones.block_rows import add, dot
from ..cones.cone import set_scales
from ..cones.contact_problem import FIRST, LINE, NORMAL, SECOND, Blocks
from ..families.faces import FAR
from ..families.inertia import mass_blocks
from ..ode.states import to_unit
from .elimination import answer, factor, hold
from .pairs import begin_closed, close_pairs, family_of, lay_pairs
from .stepping_record import (
    BEGINS,
    CLOSED_GAP,
    CONSTRAINTS,
    FULL,
    LANDED,
    MASS,
    NONE,
    OPENS,
    Contacts,
    Gaps,
    Machine,
    Run,
)


@compiled
def evaluate(run: Run, t: float, constraints: int, near: float, friction: int) -> int:
    """Evaluate the machine at z, and factor M and the first ``constraints`` constraints; return a failure or NONE.

    Pairs of families are found up to the gap ``near``; they have tangent rows only if ``friction`` is not 0.
    """
    if run.machine.looped == 0:
        run.machine.system(t, run.z, run.machine.c, run.outputs)
        hide(run.contacts, run.now)
    if lay_pairs(run, t, near, friction) == 0:
        return FULL
    if run.machine.looped == 1:
        loads_at(run.machine, t, run.z, run.f)
    if inertia(run) == 0:
        return MASS
    if hold(run.elimination, run.W, constraints) == 0:
        return CONSTRAINTS
    return NONE


@compiled
def inertia(run: Run) -> int:
    """Factor M; return 0 if it is not positive definite. That of bodies alone is constant."""
    links = run.families.links
    if run.machine.looped == 1:
        if links.varying == 0 and links.known == 1:
            return 1
        mass_blocks(links, run.problem.blocks, run.M)
        links.known = 1
    return factor(run.elimination, run.M)


@compiled
def begin(run: Run, t: float, near: float) -> None:
    """Let the contacts and pairs with gaps up to ``near`` at z, the state before the first step, begin closed."""
    contacts, row = run.contacts, 0
    if run.machine.looped == 0:
        run.machine.system(t, run.z, run.machine.c, run.outputs)
        hide(contacts, run.now)
    for e in range(contacts.count):
        begins = run.now.gap[e] <= near and contacts.held[e] == 0 and contacts.presser[e] < 0
        contacts.kept[e] = contacts.stuck[e] = BEGINS if begins else OPENS
        for k in range(1 + contacts.tangents[e]):
            contacts.last[row + k, 0] = run.rates[row + k]
        row += 1 + contacts.tangents[e]
    begin_closed(run, t, near)


@compiled
def loads_at(machine: Machine, t: float, y: Reals, f: Reals) -> None:
    """Set f at a state."""
    if machine.looped == 0:
        machine.loading(t, y, machine.c, f)
    else:
        machine.loading(t, y, machine.of_loading, machine.bias)
        for i in range(machine.n):
            f[i] = -machine.bias[machine.order[i]]


@compiled
def give(run: Run, N: Reals) -> None:
    """Set the impulses of the normal forces that the state gives to those of N; without them there is no friction."""
    contacts, problem = run.contacts, run.problem
    for a in range(contacts.closed):
        if contacts.held[contacts.owner[a]] != 0 and contacts.presser[contacts.owner[a]] < 0:
            if problem.kinds[a] == NORMAL:
                problem.low[a] = N[contacts.owner[a]] * run.h
                problem.x[a] = problem.low[a]
            elif N[contacts.owner[a]] == 0.0:
                problem.x[a] = 0.0


@compiled
def adhere(run: Run) -> None:
    """Add the pulls -A of the closed contacts and pairs to the loads, and their power; N + A is what the cones have.

    The step after that of a landing takes a besides what turns the motion (`curvature`). That is none of the N that A
    bounds.
    """
    contacts, problem, pairs = run.contacts, run.problem, run.families.pairs
    for a in range(problem.count):
        e, r, A = contacts.owner[a], problem.rows[a], 0.0
        if problem.kinds[a] == NORMAL:
            A = contacts.adhesion[e] if a < contacts.closed else adhesion_of(run, e)
            if A > 0.0 and contacts.stays[a] == LANDED and contacts.turn[a] > 0.0:
                A += contacts.turn[a] / (problem.scale[a] * run.h)
            if a < contacts.closed:
                contacts.pull[e] = A
            else:
                pairs.pull[e] = A
        if A > 0.0:
            add(problem.blocks, r, run.W, -A, run.pressed)
            run.pressing[0] -= A * contacts.before[a]


@inlined
def compliant(run: Run, c: int) -> int:
    """Return 1 if a law of its depth gives the normal force of a pair."""
    return 1 if run.families.laws.normal[family_of(run, run.families.pairs.slots[c])] != 0 else 0


@inlined
def adhesion_of(run: Run, c: int) -> float:
    """Return the pull that a pair bears."""
    return run.families.laws.adhesion[family_of(run, run.families.pairs.slots[c])]


@compiled
def normalize(machine: Machine, y: Reals) -> None:
    """Divide each quaternion of a state by its norm."""
    to_unit(y, machine.quaternions, machine.n_quaternions)


@compiled
def put_speeds(machine: Machine, y: Reals, u: Reals) -> None:
    """Write speeds in block order into a state."""
    for i in range(machine.n):
        y[machine.n_q + machine.order[i]] = u[i]


@compiled
def hide(contacts: Contacts, gaps: Gaps) -> None:
    """Set the gap of a contact to ``FAR`` if its foot lies beyond the end of its side, or behind the side.

    It came behind if, on a straight line from the last place, the gap was negative where the reach passed zero.
    """
    for k in range(contacts.reaches):
        seen, reach, gap = contacts.seen[k], gaps.reach[k], gaps.gap[contacts.reach_of[k]]
        if seen[0] < 0.0 <= reach:
            along = reach - seen[0]
            contacts.behind[k] = 1 if seen[1] * reach - gap * seen[0] < -CLOSED_GAP * along else 0
        elif gap >= -CLOSED_GAP:
            contacts.behind[k] = 0
        seen[0], seen[1] = reach, gap
    for k in range(contacts.reaches):
        if gaps.reach[k] < 0.0 or contacts.behind[k] != 0:
            gaps.gap[contacts.reach_of[k]] = FAR


@compiled
def close(run: Run, friction: int, near: float) -> None:
    """Set the rows of the problem to those of the contacts with gaps up to ``near``.

    Tangent rows only if ``friction`` is not 0.
    """
    contacts, problem = run.contacts, run.problem
    count, row = 0, 0
    for e in range(contacts.count):
        tangents, presser = contacts.tangents[e], contacts.presser[e]
        contacts.normal_row[e] = -1
        if presser >= 0:  # it resists rolling or spinning while its contact is closed
            if friction != 0 and contacts.normal_row[presser] >= 0:
                for k in range(1, 1 + tangents):
                    problem.rows[count], problem.mu[count], problem.low[count] = row + k, contacts.mu[e], 0.0
                    problem.kinds[count] = LINE if tangents == 1 else FIRST + k - 1
                    problem.between[count] = count - 1 - contacts.normal_row[presser]
                    contacts.owner[count], contacts.rebound[count] = e, 0.0
                    count += 1
        elif (run.now.gap[e] <= near or (contacts.kept[e] != OPENS and run.now.gap[e] < FAR)) and (
            friction != 0 or contacts.held[e] == 0
        ):
            contacts.normal_row[e] = count
            for k in range(1 + tangents if friction != 0 else 1):
                problem.rows[count], problem.mu[count], problem.between[count] = row + k, contacts.mu[e], 0
                problem.kinds[count] = NORMAL if k == 0 else (LINE if tangents == 1 else FIRST + k - 1)
                problem.low[count] = run.given[e] * run.h if k == 0 else 0.0
                if friction == 0 and contacts.kept[e] > OPENS:
                    problem.low[count] = -run.h * contacts.guess[row]
                contacts.owner[count] = e
                contacts.rebound[count] = contacts.restitution[e] if k == 0 else 0.0
                count += 1
        row += 1 + tangents
    problem.count = contacts.closed = count
    close_pairs(run, friction)


@compiled
def answers(run: Run, constraints: int) -> None:
    """Compute X and σ of the rows of the problem, and the part of A = W X of each contact."""
    problem, blocks, W, X = run.problem, run.problem.blocks, run.W, run.problem.X
    A, kinds = problem.matrix, problem.kinds
    for a in range(problem.count):
        r = problem.rows[a]
        answer(run.elimination, r, W, X, run.elimination.sigma[a], constraints)
        A[a, 0] = joined(blocks, r, r, W, X)
        if (kinds[a] == LINE and problem.between[a] == 0) or kinds[a] == SECOND:
            A[a - 1, 1] = joined(blocks, r - 1, r, W, X)
        if kinds[a] == SECOND and problem.between[a - 1] == 0:
            A[a - 2, 1] = joined(blocks, r - 2, r - 1, W, X)
            A[a - 2, 2] = joined(blocks, r - 2, r, W, X)
    for a in range(problem.count):
        e = run.contacts.owner[a]
        given = run.contacts.held[e] if a < run.contacts.closed else compliant(run, e)
        if kinds[a] == NORMAL and given != 0:
            # a given force that moves nothing is compared by the rate of its tangent
            A[a, 0] = A[a + 1, 0]
    set_scales(problem)
    run.sweeping.pairs = 0


@compiled
def joined(blocks: Blocks, r: int, k: int, W: Reals, X: Reals) -> float:
    """Return W_r X_k of two rows over the same blocks, as those of a contact."""
    return dot(W[blocks.at[r] :], X[blocks.at[k] :], blocks.at[r + 1] - blocks.at[r])
