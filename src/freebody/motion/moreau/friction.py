"""Coefficients of friction that are greater at rest, or vary with the slip speed, found with the impulses of a step.

    stick   v_T⁺ = 0,   |Λ_T| <= μ_s Λ_N;        slip   Λ_T = -μ(|v_T⁺|) Λ_N v_T⁺/|v_T⁺|

Each pass solves the cones with one coefficient for every contact, first with μ_s. One that slips then gets μ of its
slip, and one that sticks keeps what it has, up to μ_s. So a contact sticks if it can with the others: with constant
μ < μ_s coefficients only fall, which ends. For other laws the passes take the secant of each contact. They end where

    |μ - μ(v_T⁺)| Λ_N A

is no more than the residual of the other laws, as the rate that it is (A: rate per unit impulse). That is the law at
the end of the step, to the residual that the motion states; of several solutions, it is the one next to stick.

In an impact the coefficient is that of slip just before it, as by events. An island of contacts has an impact in a
step if it is struck by a blow, or if a contact lands faster than the forces of the step can change its speed.
"""

from __future__ import annotations

from ...native.instructions import call, compiled, greater, lesser, root
from ..cones.block_rows import along, root_of
from ..cones.contact_problem import FIRST, NORMAL
from ..cones.islands import Islands, connect_without_rebounds, island_of
from .pairs import family_of, slip
from .stepping_record import NO_FRICTION, NONE, OPENS, SLIPS, STICK, Run

PASSES, PATIENT = 400, 40
"""Passes after which coefficients are not found, and after which their residual may be that of a long search."""
AGAIN = -1
LEAST, MOST = 1e-2, 10.0
"""Limits of the change of a coefficient, in parts of what it misses."""


@compiled
def law_of(run: Run, a: int) -> int:
    """Return the kernel of the coefficients of the contact whose normal is row ``a``.

    Return 0 if the row is no normal, and if friction has one number or does not act.
    """
    if run.problem.kinds[a] != NORMAL or has_tangent(run, a) == 0:
        return 0
    e = run.contacts.owner[a]
    if a < run.contacts.closed:
        return run.friction.of_contacts[e]
    return run.friction.of_families[family_of(run, run.families.pairs.slots[e])]


@compiled
def has_tangent(run: Run, a: int) -> int:
    """Return 1 if friction acts at the contact whose normal is row ``a``."""
    problem = run.problem
    return 1 if a + 1 < problem.count and problem.kinds[a + 1] > NORMAL and problem.between[a + 1] == 0 else 0


@compiled
def size_of(run: Run, a: int, x: float, y: float) -> float:
    """Return the length of a vector along the tangents behind the normal row ``a``; y counts if there are two."""
    return root(x * x + y * y) if run.problem.kinds[a + 1] == FIRST else abs(x)


@compiled
def look_up(run: Run, t: float, law: int, speed: float) -> None:
    """Set ``found`` to the coefficients of a law: of slip with a speed, and at rest, at (q_M, ū)."""
    friction, n_q = run.friction, run.machine.n_q
    friction.given[n_q + run.machine.n] = speed
    call(law, t + 0.5 * run.h, friction.given, 0, friction.c, friction.found, 0)


@compiled
def set_given(run: Run) -> None:
    """Write the coordinates in the middle of the step and the mean speeds."""
    friction, n_q = run.friction, run.machine.n_q
    for i in range(n_q):
        friction.given[i] = run.z[i]
    for i in range(run.machine.n):
        friction.given[n_q + run.machine.order[i]] = run.u[i] + 0.5 * (run.free[i] + run.problem.v[i])


@compiled
def set_coefficient(run: Run, a: int, mu: float) -> None:
    """Give a coefficient to the contact whose normal is row ``a``."""
    last = a + 2 if run.problem.kinds[a + 1] == FIRST else a + 1
    for k in range(a, last + 1):
        run.problem.mu[k] = mu


@compiled
def begin_friction(run: Run, islands: Islands, t: float) -> None:
    """Set the first coefficients of a step, whose free speeds are known."""
    friction, problem, contacts = run.friction, run.problem, run.contacts
    friction.turns, friction.residual, friction.failure = 0, 0.0, NONE
    find_impacts(run, islands)
    set_given(run)
    for a in range(problem.count):
        law = law_of(run, a)
        if law == 0:
            continue
        b = island_of(problem, islands, a + 1)
        in_impact, speed = b >= 0 and islands.rebounds[b] > 0, 0.0
        friction.passes[a] = -1 if in_impact else 0
        if in_impact:
            across = contacts.before[a + 2] if problem.kinds[a + 1] == FIRST else 0.0
            speed = size_of(run, a, contacts.before[a + 1], across)
        look_up(run, t, law, speed)
        mu = friction.found[0 if in_impact else 1]
        if not mu >= 0.0:
            friction.failure, friction.blame, mu = NO_FRICTION, a, 0.0
        set_coefficient(run, a, mu)


@compiled
def find_impacts(run: Run, islands: Islands) -> None:
    """Set ``rebounds`` of each island to 1 if it has an impact in this step, else to 0."""
    problem, contacts, blocks = run.problem, run.contacts, run.problem.blocks
    connect_without_rebounds(problem, islands)
    for b in range(blocks.count):
        for i in range(blocks.starts[b], blocks.starts[b + 1]):
            if run.blow[i] != 0.0:
                islands.rebounds[root_of(islands.parent, b)] = 1
    for a in range(problem.count):
        b = island_of(problem, islands, a)
        if problem.kinds[a] == NORMAL and contacts.stays[a] == OPENS and b >= 0:
            change = abs(along(blocks, problem.rows[a], run.W, run.free))
            if -contacts.before[a] > change:
                islands.rebounds[b] = 1


@compiled
def rub(run: Run, t: float, goal: float) -> int:
    """Compare the coefficients with those of the slips, and change them; return NONE if they agree within ``goal``,
    `AGAIN` if the contacts are to be solved once more, or a failure.
    """
    friction = run.friction
    failure = friction.failure if friction.failure != NONE else change_coefficients(run, t)
    if failure != NONE or friction.residual <= goal:
        return failure
    friction.turns += 1
    if friction.turns >= PATIENT and friction.residual <= run.enough:
        return NONE
    return AGAIN if friction.turns <= PASSES else SLIPS


@compiled
def change_coefficients(run: Run, t: float) -> int:
    """Change the coefficients to those of the slips; set the residual of the last ones, return a failure or NONE."""
    friction, problem, worst = run.friction, run.problem, 0.0
    set_given(run)
    for a in range(problem.count):
        law = law_of(run, a)
        if law == 0 or friction.passes[a] < 0 or not problem.x[a] > 0.0:
            continue
        mu, two = problem.mu[a], a + 2 if problem.kinds[a + 1] == FIRST else a + 1
        look_up(run, t, law, size_of(run, a, problem.r[a + 1], problem.r[two]))
        if not (friction.found[0] >= 0.0 and friction.found[1] >= 0.0):
            friction.blame = a
            return NO_FRICTION
        aim = friction.found[0]
        if slip(run, a + 1) == STICK:
            T = size_of(run, a, problem.x[a + 1], problem.x[two])
            aim = mu if friction.found[1] * problem.x[a] >= T else lesser(mu, friction.found[1])
        miss = aim - mu
        left = abs(miss) * problem.x[a] * problem.scale[a + 1]
        if left > worst:
            worst, friction.blame = left, a
        set_coefficient(run, a, greater(mu + secant(run, a, mu, miss), 0.0))
    friction.residual = worst / problem.reference
    return NONE


@compiled
def secant(run: Run, a: int, mu: float, miss: float) -> float:
    """Return the change of a coefficient by its secant, between parts of what it misses; remember this pass."""
    friction, part = run.friction, 1.0
    if friction.passes[a] > 0:
        fall = (friction.miss[a] - miss) / (mu - friction.mu[a]) if mu != friction.mu[a] else 1.0
        part = lesser(greater(1.0 / fall, LEAST), MOST) if fall > 0.0 else 1.0
    friction.mu[a], friction.miss[a] = mu, miss
    friction.passes[a] += 1
    return part * miss
