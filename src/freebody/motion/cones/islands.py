"""Newton's method for the islands of a contact problem: the sets of rows that share no speeds with others.

Sweeps are slow where the forces of faces on faces are open. The islands that are not solved by then get Newton's
method (`newton.balance`), with the impulses of the sweeps as multipliers: rounds of proximal points

    y ← λ(v),  F(v) = v - Cᵀ λ(v) = 0,   λ = P(y - r(v)/ε)

each to a small part of the residual left by the one before it. The fixed point is the exact law, whatever ε is. An
island with more rows or speeds than there is room for stays as it is.
"""

from __future__ import annotations

import math
from typing import Annotated

from ...native.instructions import compiled, greater, lesser
from ...native.records import Count, Record, Row, Whole, Wholes, record
from .cone import add_all, residual
from .contact_problem import ContactProblem, Newton
from .newton import DRIFT, balance, reach

SOFT, HARDEST, SOFTEST = 1e-3, 1e-6, 1e-1
"""First compliance and its limits, relative to the mean of the scales."""
FINE = 1e-10
"""Residual below which a greater compliance helps where a round is slow: the round-off of r/ε is what is left."""
SLOW, IDLE = 0.2, 6
"""Ratio of two residuals above which the compliance falls, and rounds without progress that end the search."""
INEXACT, ROUND_OFF = 5e-3, 1e-15
"""|F| relative to |v| that ends Newton's method in a round: a part of the residual before it, and the least one."""


@record
class Islands(Record):
    """Memory of this file.

    ``speeds``, ``rows``  room for one island;  ``steps``: number of all Newton steps
    ``parent``   a block of the same island, itself for the first one;  ``worst``: greatest violation of a law in it
    ``place``    first speed of a block in the island;  ``own``: rows of the problem in the island
    ``part``     the island as a problem of one block, and the arrays of that
    """

    speeds: Count
    rows: Count
    steps: Whole
    parent: Annotated[Wholes, "blocks"]
    worst: Annotated[Row, "blocks"]
    place: Annotated[Wholes, "blocks"]
    own: Annotated[Wholes, "most"]
    part: ContactProblem
    newton: Newton


@compiled
def settle(problem: ContactProblem, islands: Islands, goal: float) -> float:
    """Improve x in every island that violates a law by more than ``goal``; return the residual, of finite x."""
    blocks = problem.blocks
    connect(problem, islands)
    for a in range(problem.count):
        if blocks.first[problem.rows[a] + 1] > blocks.first[problem.rows[a]]:
            b = root_of(islands, blocks.pieces[blocks.first[problem.rows[a]]])
            islands.worst[b] = greater(islands.worst[b], abs(problem.e[a]))
    for b in range(blocks.count):
        unsolved = islands.parent[b] == b and islands.worst[b] > goal * problem.reference
        if unsolved and lay_out(problem, islands, b) == 1:
            improve(problem, islands, b, goal)
    add_all(problem)
    problem.residual = residual(problem)
    return problem.residual


@compiled
def root_of(islands: Islands, b: int) -> int:
    """Return the first block of the island of a block."""
    while islands.parent[b] != b:
        islands.parent[b] = islands.parent[islands.parent[b]]
        b = islands.parent[b]
    return b


@compiled
def connect(problem: ContactProblem, islands: Islands) -> None:
    """Join the blocks that rows share."""
    blocks = problem.blocks
    for b in range(blocks.count):
        islands.parent[b], islands.worst[b] = b, 0.0
    for a in range(problem.count):
        r = problem.rows[a]
        for p in range(blocks.first[r] + 1, blocks.first[r + 1]):
            one, other = root_of(islands, blocks.pieces[p - 1]), root_of(islands, blocks.pieces[p])
            if one < other:
                islands.parent[other] = one
            else:
                islands.parent[one] = other


@compiled
def lay_out(problem: ContactProblem, islands: Islands, island: int) -> int:
    """Write an island as a problem of its own; return 0 if there is no room for it."""
    blocks, part, n, m = problem.blocks, islands.part, 0, 0
    for b in range(blocks.count):
        if root_of(islands, b) == island:
            islands.place[b] = n
            n += blocks.starts[b + 1] - blocks.starts[b]
    for a in range(problem.count):
        r = problem.rows[a]
        if (
            blocks.first[r + 1] > blocks.first[r]
            and root_of(islands, blocks.pieces[blocks.first[r]]) == island
        ):
            if m < islands.rows:
                islands.own[m] = a
            m += 1
    if n > islands.speeds or m > islands.rows:
        return 0
    part.count, part.reference, part.blocks.n = m, problem.reference, n
    part.blocks.starts[0], part.blocks.starts[1] = 0, n
    for i in range(m):
        a = islands.own[i]
        r = problem.rows[a]
        part.rows[i], part.kinds[i], part.mu[i], part.low[i] = (
            i,
            problem.kinds[a],
            problem.mu[a],
            problem.low[a],
        )
        part.scale[i], part.b[i], part.x[i] = problem.scale[a], problem.b[a], problem.x[a]
        part.blocks.pieces[i], part.blocks.first[i], part.blocks.at[i] = 0, i, i * n
        for k in range(i * n, i * n + n):
            part.W[k], part.X[k] = 0.0, 0.0
        k = blocks.at[r]
        for p in range(blocks.first[r], blocks.first[r + 1]):
            b = blocks.pieces[p]
            for j in range(blocks.starts[b + 1] - blocks.starts[b]):
                part.W[i * n + islands.place[b] + j] = problem.W[k]
                part.X[i * n + islands.place[b] + j] = problem.X[k]
                k += 1
    part.blocks.first[m], part.blocks.at[m] = m, m * n
    return 1


@compiled
def improve(problem: ContactProblem, islands: Islands, island: int, goal: float) -> None:
    """Solve the island that is laid out from its impulses; take what violates its laws less."""
    part, newton, unit, x = islands.part, islands.newton, 0.0, islands.part.x
    add_all(part)
    for k in range(part.blocks.n):
        newton.v[k] = part.v[k]
    for i in range(part.count):
        newton.y[i], newton.past[i], newton.moved[i] = x[i], x[i], 0.0
        unit += part.scale[i] / part.count
    soft, last, least, idle = SOFT * unit, residual(part), islands.worst[island] / problem.reference, 0
    while idle < IDLE and least > goal and math.isfinite(last):
        islands.steps += balance(part, newton, soft, greater(ROUND_OFF, INEXACT * last))
        for i in range(part.count):
            x[i] = newton.here.x[i]
        add_all(part)
        left = residual(part)
        follow(part, newton)
        idle += 1
        if left < least:
            idle, least = 0, left
            for i in range(part.count):
                problem.x[islands.own[i]] = x[i]
        if left > SLOW * last:
            soft = (
                greater(soft / 10.0, HARDEST * unit) if left > FINE else lesser(10.0 * soft, SOFTEST * unit)
            )
        last = left


@compiled
def follow(part: ContactProblem, newton: Newton) -> None:
    """Set the multipliers to the impulses; where these drift on a line, to the place where a contact leaves its cone.

    A speed too small to be seen moves them so, and would take ever so many rounds.
    """
    x, past, moved, square, before, along = part.x, newton.past, newton.moved, 0.0, 0.0, 0.0
    for i in range(part.count):
        change = x[i] - past[i]
        square += change * change
        before += moved[i] * moved[i]
        along += change * moved[i]
        moved[i] = change
    straight = along > 0.0 and along * along > (1.0 - DRIFT * DRIFT) * square * before
    far = reach(part, moved) if straight else 0.0
    for i in range(part.count):
        newton.y[i] = x[i] + far * moved[i]
        past[i] = newton.y[i]
