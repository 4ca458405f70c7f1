"""Newton's method on the laws of a contact problem themselves, in the speeds of its blocks.

    e(x) = 0 (`cone.violation`),   e + E_r W dv + (E_x + δ s) dx = 0,   dv = Xᵀ dx

The second equation gives dx = -(g + G dv) contact by contact (`cone.law_slopes`), and so the speeds

    (1 + Xᵀ G) dv = -Xᵀ g

whose matrix has entries for blocks that share a row. δ is a compliance of the step alone, as great as the residual:
forces of faces on faces are open, and change as little as they need. No length of a step is sought, nor is a step
brought back to the cones: e is defined everywhere, and a step that is cut loses what all contacts do together. From the
impulses of a few sweeps this takes a few steps; where it does not end it goes astray, and the best x is kept.

Source: L. Qi, J. Sun, Mathematical Programming 58 (1993) 353-367 (Newton's method on equations with kinks).
"""

from __future__ import annotations

import math

from ...native.instructions import compiled, greater, lesser
from .cone import add_all, along_all, combine, law_slopes, residual
from .contact_problem import ContactProblem, Newton
from .elimination import factored, jacobian, substitute

LOOSE, LOOSEST, STIFF = 1e-8, 0.1, 1e-4
"""Limits of δ, and up to where it grows in steps that gain little: a step leaves about this part of an error."""
LITTLE, MORE, TIMES = 0.3, 10.0, 4
"""Ratio of the residual to the least one above which a step gains little; the factor of δ in the next one, and the
number of such steps after which δ begins anew."""
IDLE = 14
"""Number of such steps in a row that ends the search."""
LOST = 1e6
"""Growth of the residual after which the search goes back to the best x."""


@compiled
def descend(problem: ContactProblem, memory: Newton, goal: float, most: int, part: float) -> float:
    """Improve x by up to ``most`` steps, δ a ``part`` of the residual; return that of the best, which x becomes."""
    m, least, turn, idle, growth = problem.count, math.inf, 0, 0, 1.0
    while True:
        add_all(problem)
        size = residual(problem)
        idle = idle + 1 if size > LITTLE * least else 0
        growth = 1.0 if idle % TIMES == 0 else growth * MORE
        if size < least:
            least = size
            for a in range(m):
                memory.best[a] = problem.x[a]
        elif math.isfinite(least) and not size < LOST * least:
            for a in range(m):
                problem.x[a] = memory.best[a]
            add_all(problem)
            size = residual(problem)
        if least <= goal or turn == most or idle == IDLE or problem.stop != 0 or not math.isfinite(size):
            break
        loose = greater(LOOSE, lesser(LOOSEST, part * size))
        if step(problem, memory, greater(loose, lesser(STIFF, growth * loose))) == 0:
            break
        turn += 1
    for a in range(m):
        problem.x[a] = memory.best[a]
    return least


@compiled
def step(problem: ContactProblem, memory: Newton, loose: float) -> int:
    """Do one step with δ = ``loose``; return 0 if it has no value."""
    blocks, dv, g, G = problem.blocks, memory.step, memory.moved, memory.G[0]
    law_slopes(problem, loose, g, G)
    jacobian(problem, G, memory)
    if factored(memory.J[0], blocks, memory.ends, memory.order) == 0:
        return 0
    memory.factored += 1
    combine(problem, g, dv)
    for k in range(blocks.n):
        dv[k] = -dv[k]
    substitute(memory.J[0], blocks, memory.ends, memory.order, dv)
    along_all(problem, G, dv, problem.r)
    for a in range(problem.count):
        problem.x[a] -= g[a] + problem.r[a]
    return 1
