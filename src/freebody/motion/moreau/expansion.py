"""Poisson's law in a step: the contacts of an impact are compressed, and give e times that impulse back.

    compression   0 <= Λ_C ⟂ v_C + a >= 0,                  v_C = u_free + Σ X Λ_C,  with friction in its cone
    expansion     0 <= Λ_E - e Λ_C ⟂ v⁺ + a >= 0,           -Λ_TE in μ Λ_NE Sgn(v_T⁺ + a_T)

The compression is the problem of a step without restitution, and holds its forces as well. Contacts expand if one of
their island lands faster than these forces can change its speed; others have Λ_E = 0. The forces of the step expand,
too, an error of first order, as all of an impact in a step.

Source: M. Anitescu, F. A. Potra, Nonlinear Dynamics 14 (1997) 231-247.
"""

from __future__ import annotations

from ...native.instructions import compiled, greater
from ..cones.cone import add_all, rate
from ..cones.contact_problem import NORMAL
from ..cones.islands import Islands, connect_without_rebounds, island_of
from .configuration import compliant
from .impulses import impulses
from .pairs import family_of
from .stepping_record import Run


@compiled
def join_expansions(run: Run, islands: Islands) -> None:
    """Give their restitution to all contacts of the islands in which one rebounds."""
    contacts, problem, pairs = run.contacts, run.problem, run.families.pairs
    run.expansion.chosen = 1
    connect_without_rebounds(problem, islands)
    for a in range(problem.count):
        b = island_of(problem, islands, a)
        if b >= 0 and contacts.rebound[a] > 0.0:
            islands.rebounds[b] = 1
    for a in range(problem.count):
        b, e = island_of(problem, islands, a), contacts.owner[a]
        if problem.kinds[a] != NORMAL or b < 0 or islands.rebounds[b] == 0:
            continue
        if a < contacts.closed and contacts.held[e] == 0:
            contacts.rebound[a] = contacts.restitution[e]
        elif a >= contacts.closed and compliant(run, e) == 0:
            contacts.rebound[a] = run.families.laws.restitution[family_of(run, pairs.slots[e])]


@compiled
def expand(run: Run, islands: Islands, goal: float) -> int:
    """Add the impulses of the expansion to those of the compression; return 0 if none are found, else 1."""
    problem, expansion, found = run.problem, run.expansion, 0
    for a in range(problem.count):
        back = run.contacts.rebound[a] * problem.x[a] if problem.kinds[a] == NORMAL else 0.0
        expansion.x[a], expansion.b[a], expansion.low[a] = problem.x[a], problem.b[a], problem.low[a]
        expansion.back[a] = back
        found += 1 if back > 0.0 else 0
    if found == 0:
        return 1
    left = problem.residual
    for a in range(problem.count):
        problem.b[a], problem.low[a], problem.x[a] = problem.r[a], expansion.back[a], expansion.back[a]
    solved = impulses(run, islands, goal, run.enough, 0)
    problem.residual = greater(problem.residual, left)
    for a in range(problem.count):
        problem.x[a] += expansion.x[a]
        problem.b[a], problem.low[a] = expansion.b[a], expansion.low[a]
    add_all(problem)
    for a in range(problem.count):
        problem.r[a] = rate(problem, a)
    run.sweeping.ended = 0
    return solved
