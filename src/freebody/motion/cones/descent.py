"""Newton's method on the laws of a contact problem themselves, in the speeds of its blocks.

    e(x) = 0 (`cone.violation`),   e + E_r W dv + (E_x + δ s) dx = 0,   dv = Xᵀ dx

The second equation gives dx = -(g + G dv) contact by contact (`cone.law_slopes`), and so the speeds

    (1 + Xᵀ G) dv = -Xᵀ g

whose matrix has entries for blocks that share a row. δ is a compliance of the step alone, as great as the residual:
forces of faces on faces are open, and change as little as they need. No length of a step is sought, nor is a step
brought back to the cones: e is defined everywhere, and a step that is cut loses what all contacts do together. From the
impulses of a few sweeps this takes a few steps; where it does not end it goes astray, and the best x is kept.

Sources: L. Qi, J. Sun, Mathematical Programming 58 (1993) 353-367 (Newton's method on equations with kinks); P. Alart,
A. Curnier, Comput. Methods Appl. Mech. Engrg. 92 (1991) 353-375 (the other limit of friction).
"""

from __future__ import annotations

import math

from ...native.instructions import compiled, greater, lesser
from .cone import add_all, along_all, combine, law_slopes, residual
from .contact_problem import ContactProblem, Newton
from .elimination import factored, jacobian, link, substitute

LOOSE, LOOSEST = 1e-8, 0.1
"""Limits of δ, which is the residual: a step leaves about this part of an error."""
LOST = 1e6
"""Growth of the residual that ends the search."""
SLOW = 0.1
"""Part of a residual that is close to the goal above which a step leaves it at that: near the solution of a regular
problem a step takes far more, and one whose forces are open may go to and fro between modes."""


@compiled
def descend(
    problem: ContactProblem,
    memory: Newton,
    goal: float,
    close: float,
    most: int,
    part: float,
    augmented: int,
) -> float:
    """Improve x by up to ``most`` steps, δ a ``part`` of the residual; return that of the best, which x becomes.

    It ends at the goal, and where steps are slow at a residual up to ``close``. Where steps by one of the two limits of
    friction, ``augmented`` or not (`law_slopes`), go to and fro between modes, those by the other one often end.
    """
    m, least, last, turn = problem.count, math.inf, math.inf, 0
    link(problem, memory.links)
    while True:
        add_all(problem)
        size = residual(problem)
        if size < least:
            least = size
            for a in range(m):
                memory.best[a] = problem.x[a]
        if least <= goal or turn == most or not size < LOST * least or problem.stop != 0:
            break
        if least <= close and size > SLOW * last:
            break
        last = size
        if step(problem, memory, greater(LOOSE, lesser(LOOSEST, part * size)), augmented) == 0:
            break
        turn += 1
    for a in range(m):
        problem.x[a] = memory.best[a]
    return least


@compiled
def step(problem: ContactProblem, memory: Newton, loose: float, augmented: int) -> int:
    """Do one step with δ = ``loose``; return 0 if it has no value."""
    blocks, dv, g, G = problem.blocks, memory.step, memory.moved, memory.G[0]
    law_slopes(problem, loose, augmented, g, G)
    jacobian(problem, G, memory)
    if factored(memory.J[0], blocks, memory.links, memory.order) == 0:
        return 0
    memory.factored += 1
    combine(problem, g, dv)
    for k in range(blocks.n):
        dv[k] = -dv[k]
    substitute(memory.J[0], blocks, memory.links, memory.order, dv)
    along_all(problem, G, dv, problem.r)
    for a in range(problem.count):
        problem.x[a] -= g[a] + problem.r[a]
    return 1
