"""The work of contacts in a step, by which a rebound is judged."""

from __future__ import annotations

from ...native.instructions import compiled, greater
from ..cones.contact_problem import NORMAL
from ..cones.contacts import EXACT
from ..cones.islands import Islands, connect_without_rebounds, island_of
from .curvature import after
from .stepping_record import Run


@compiled
def gains(run: Run, islands: Islands) -> int:
    """Return the number of islands whose contacts do work, and of which some rebound; leave others no ``rebounds``.

    Λ·(v⁻ + v⁺)/2 is what T + V of a step gains beside its loads. Gravity that turns a speed within the step has a part
    in it, of Λ·g h/2 at most: friction that an impact lets slip back, for instance. Such a step rebounds less, too.
    """
    contacts, problem, energy, found = run.contacts, run.problem, islands.energy, 0
    for a in range(problem.count):
        found += 1 if contacts.rebound[a] > 0.0 and problem.x[a] > 0.0 else 0
    if found == 0:
        return 0
    connect_without_rebounds(problem, islands)
    for b in range(problem.blocks.count):
        for k in range(3):
            energy[b, k] = 0.0
    for a in range(problem.count):
        b, before, speed = island_of(problem, islands, a), contacts.before[a], after(run, a)
        if b >= 0:
            x = 0.5 * problem.x[a]
            if problem.kinds[a] == NORMAL:
                islands.rebounds[b] += 1 if contacts.rebound[a] > 0.0 and x > 0.0 else 0
            energy[b, 0] += x * (before + speed)
            energy[b, 1] += abs(x) * (abs(before) + abs(speed))
    found = 0
    for b in range(problem.blocks.count):
        small = greater(EXACT, problem.residual) * energy[b, 1]
        if not (islands.rebounds[b] > 0 and energy[b, 0] > small):
            islands.rebounds[b] = 0
        found += 1 if islands.rebounds[b] > 0 else 0
    return found
