"""Newton's method for the islands of a contact problem: the sets of rows that share no speeds with others.

Sweeps are slow where the forces of faces on faces are open. The islands that a few of them do not solve get Newton's
method on the laws (`descent`), also from what an interior point method finds from zero (`interior`), or without
friction the dual method (`dual`). What more sweeps and that leave gets
Newton's method at a compliance (`newton.balance`), with the impulses of the sweeps as multipliers: rounds of proximal
points

    y ← λ(v),  F(v) = v - Cᵀ λ(v) = 0,   λ = P(y - r(v)/ε)

each to a small part of the residual left by the one before it. The fixed point is the exact law, whatever ε is. An
island with more rows or speeds than there is room for stays as it is.
"""

from __future__ import annotations

import math
from typing import Annotated

from ...native.instructions import compiled, greater, hot, lesser
from ...native.records import Count, Record, Row, Rows, Whole, Wholes, record
from .block_rows import join, root_of
from .cone import add_all, project_all, residual
from .contact_problem import ContactProblem, Dense, Newton
from .descent import descend
from .dual import is_bare, take_in
from .elimination import least_linked
from .interior import begin, go_on, is_served
from .newton import DRIFT, balance, reach, solve

SOFT, HARDEST, SOFTEST = 1e-2, 1e-6, 1e-1
"""First compliance and its limits, relative to the mean of the scales."""
FINE = 1e-10
"""Residual below which a greater compliance helps where a round is slow: the round-off of r/ε is what is left."""
SLOW, IDLE = 0.2, 6
"""Ratio of two residuals above which the compliance falls, and rounds without progress that end the search."""
FEW = 12
"""Newton steps of a round; a greater compliance takes fewer."""
WARM, COLD = 20, 100
"""Limits on Newton's steps on the laws, from the impulses of the sweeps and from zero: most of those that end need
fewer."""
APPROACHES, PATH, LATE = 3, 20, 4
"""Number of approaches of the interior point method, limit on its steps in each of them, and the turn from which it
begins without the slope of |z_T|."""
ROUGH, FINER, FINEST = 1e-3, 1e-5, 1e-7
"""Residuals to which these go, each followed by Newton's method on the laws."""
INSIDE = 0.1
"""Part of the goal to which Newton's method on the laws goes: what brings its result into the cones changes rates."""
SMALL_FIRST, FEW_ROWS, FEW_SPEEDS = -1, 130, 150
"""Turn before the sweeps, and the rows (without friction) and speeds up to which an island has it."""
ANEW = 24
"""Speeds of an island up to which it is solved from zero where all else has not reached the goal."""
INEXACT, ROUND_OFF = 5e-3, 1e-15
"""|F| relative to |v| that ends Newton's method in a round: a part of the residual before it, and the least one."""


@record
class Islands(Record):
    """Memory of this file.

    ``speeds``, ``rows``  room for one island;  ``steps``: number of all Newton steps
    ``touching`` rows of each block, from ``at`` on
    ``parent``   a block of the same island, itself for the first one;  ``worst``: greatest violation of a law in it
    ``place``    number of a block in the island;  ``order``: its blocks;  ``own``: rows of the problem in the island
    ``degree``   links of each block, -1 where it is eliminated;  ``sequence``: in which they are
    ``part``     the island as a problem of its own
    ``energy``   sums over an island that judge its rebounds;  ``rebounds``: number of these
    """

    speeds: Count
    rows: Count
    steps: Whole
    touching: Wholes
    at: Wholes
    parent: Annotated[Wholes, "blocks"]
    worst: Annotated[Row, "blocks"]
    place: Annotated[Wholes, "blocks"]
    order: Annotated[Wholes, "blocks"]
    degree: Annotated[Wholes, "blocks"]
    sequence: Annotated[Wholes, "blocks"]
    own: Annotated[Wholes, "most"]
    energy: Annotated[Rows, "blocks", 3]
    rebounds: Annotated[Wholes, "blocks"]
    part: ContactProblem
    dense: Dense
    newton: Newton


@compiled
def settle(
    problem: ContactProblem, islands: Islands, goal: float, close: float, enough: float, turn: int
) -> float:
    """Improve x in every island that violates a law by more than ``goal``, within the cones; return the residual.

    ``turn`` counts the calls for one problem. `SMALL_FIRST` is one before the sweeps, for islands in which they take
    longer. A search that is slow ends at a residual of ``close``. Islands that are within ``enough`` get no rounds of
    proximal points. x that is not finite has no residual.
    """
    blocks, rows, speeds = problem.blocks, islands.rows, islands.speeds
    if turn == SMALL_FIRST:
        speeds = FEW_SPEEDS if speeds > FEW_SPEEDS else speeds
        rows = FEW_ROWS if is_bare(problem) == 1 and rows > FEW_ROWS else rows
    add_all(problem)
    problem.residual = residual(problem)
    connect(problem, islands)
    for a in range(problem.count):
        b = island_of(problem, islands, a)
        if b >= 0:
            islands.worst[b] = greater(islands.worst[b], abs(problem.e[a]))
    for b in range(blocks.count):
        unsolved = islands.parent[b] == b and islands.worst[b] > goal * problem.reference
        if unsolved and lay_out(problem, islands, b, rows, speeds) == 1:
            solved = at_once(problem, islands, b, goal, close, turn)
            if solved == 0 and turn > 0 and islands.worst[b] > enough * problem.reference:
                improve(problem, islands, b, goal)
    project_all(problem, problem.x, problem.x)
    add_all(problem)
    problem.residual = residual(problem)
    return problem.residual


@compiled
def connect(problem: ContactProblem, islands: Islands) -> None:
    """Join the blocks that rows share, and list the rows of each block."""
    blocks, at = problem.blocks, islands.at
    for b in range(blocks.count):
        islands.parent[b], islands.worst[b], at[b] = b, 0.0, 0
    at[blocks.count] = 0
    for a in range(problem.count):
        r = problem.rows[a]
        for p in range(blocks.first[r], blocks.first[r + 1]):
            at[blocks.pieces[p]] += 1
    for b in range(1, blocks.count + 1):
        at[b] += at[b - 1]
    for a in range(problem.count - 1, -1, -1):
        r = problem.rows[a]
        for p in range(blocks.first[r], blocks.first[r + 1]):
            at[blocks.pieces[p]] -= 1
            islands.touching[at[blocks.pieces[p]]] = a
    for a in range(problem.count):
        r = problem.rows[a]
        for p in range(blocks.first[r] + 1, blocks.first[r + 1]):
            join(islands.parent, blocks.pieces[p - 1], blocks.pieces[p])


@compiled
def connect_without_rebounds(problem: ContactProblem, islands: Islands) -> None:
    """Do what :func:`connect` does; no island rebounds yet."""
    connect(problem, islands)
    for b in range(problem.blocks.count):
        islands.rebounds[b] = 0


@compiled
def island_of(problem: ContactProblem, islands: Islands, a: int) -> int:
    """Return the first block of the island of a row; -1 if the row moves nothing."""
    blocks, r = problem.blocks, problem.rows[a]
    return (
        -1
        if blocks.first[r + 1] == blocks.first[r]
        else root_of(islands.parent, blocks.pieces[blocks.first[r]])
    )


@compiled
def lay_out(problem: ContactProblem, islands: Islands, island: int, rows: int, speeds: int) -> int:
    """Write an island as a problem of its own; return 0 if it has more rows or speeds."""
    blocks, part, n, m = problem.blocks, islands.part, 0, 0
    for a in range(problem.count):
        if island_of(problem, islands, a) == island:
            if m < rows:
                islands.own[m] = a
            m += 1
    for b in range(blocks.count):
        if root_of(islands.parent, b) == island:
            n += blocks.starts[b + 1] - blocks.starts[b]
    if n > speeds or m > rows:
        return 0
    part.count, part.reference, part.blocks.n = m, problem.reference, n
    for i in range(m):
        a = islands.own[i]
        part.rows[i], part.kinds[i], part.between[i] = i, problem.kinds[a], problem.between[a]
        part.mu[i], part.low[i], part.scale[i] = problem.mu[a], problem.low[a], problem.scale[a]
        part.b[i], part.x[i] = problem.b[a], problem.x[a]
    arrange(problem, islands, island, m)
    p, k = 0, 0
    for i in range(m):
        r = problem.rows[islands.own[i]]
        part.blocks.first[i], part.blocks.at[i] = p, k
        for j in range(blocks.first[r], blocks.first[r + 1]):
            part.blocks.pieces[p] = islands.place[blocks.pieces[j]]
            p += 1
        for j in range(blocks.at[r], blocks.at[r + 1]):
            part.W[k], part.X[k] = problem.W[j], problem.X[j]
            k += 1
    part.blocks.first[m], part.blocks.at[m] = p, k
    return 1


@compiled
def arrange(problem: ContactProblem, islands: Islands, island: int, rows: int) -> None:
    """Number the blocks of an island, which has some rows, in the order in which they are eliminated.

    The dual method needs none.
    """
    blocks, part, place, order, sequence = (
        problem.blocks,
        islands.part,
        islands.place,
        islands.order,
        islands.sequence,
    )
    count = walk(problem, islands, island)
    if is_bare(part) == 0:
        mark(problem, islands, rows, count)
        least_linked(islands.newton.links, islands.degree, sequence, count)
        for k in range(count):
            sequence[k] = order[sequence[k]]
        for k in range(count):
            order[k], place[sequence[k]] = sequence[k], k
    part.blocks.count, part.blocks.starts[0] = count, 0
    for k in range(count):
        b = order[k]
        part.blocks.starts[k + 1] = part.blocks.starts[k] + blocks.starts[b + 1] - blocks.starts[b]


@compiled
def mark(problem: ContactProblem, islands: Islands, rows: int, count: int) -> None:
    """Mark the pairs of blocks of an island, by their places, that share a row."""
    blocks, linked = problem.blocks, islands.newton.links.blocks
    for k in range(count * count):
        linked[k] = 0
    for i in range(rows):
        r = problem.rows[islands.own[i]]
        for p in range(blocks.first[r], blocks.first[r + 1]):
            for q in range(blocks.first[r], p):
                b, c = islands.place[blocks.pieces[p]], islands.place[blocks.pieces[q]]
                linked[b * count + c] = linked[c * count + b] = 1


@hot
@compiled
def walk(problem: ContactProblem, islands: Islands, start: int) -> int:
    """List the blocks of an island in breadth, from ``start`` on; return their number."""
    blocks, place, order = problem.blocks, islands.place, islands.order
    count, seen = 1, 0
    for b in range(blocks.count):
        place[b] = -1
    order[0], place[start] = start, 0
    while seen < count:
        b = order[seen]
        for k in range(islands.at[b], islands.at[b + 1]):
            r = problem.rows[islands.touching[k]]
            for p in range(blocks.first[r], blocks.first[r + 1]):
                other = blocks.pieces[p]
                if place[other] < 0:
                    order[count], place[other] = other, count
                    count += 1
        seen += 1
    return count


@compiled
def at_once(
    problem: ContactProblem, islands: Islands, island: int, goal: float, close: float, turn: int
) -> int:
    """Solve the island that is laid out by the dual method or by Newton's method on the laws; return 1 on success,
    also where it ends ``close`` to the goal.

    Newton's method begins with the impulses of the sweeps, then with those of the interior point method, which begins
    at other rates in each turn. What that does not serve begins with none from the second turn on, with other damping
    in each. Every second turn has the other limit of friction (`cone.law_slopes`). The best impulses are kept.
    """
    part, dense, newton = islands.part, islands.dense, islands.newton
    odd = turn % 2
    least = islands.worst[island] / problem.reference
    for i in range(part.count):
        newton.y[i] = part.x[i]
    left, ways, inside = math.inf, 2 if turn > 0 else 1, 1 if turn >= 0 and is_served(part) == 1 else 0
    if inside == 1:
        ways = 1 + APPROACHES
    for way in range(ways):
        if is_bare(part) == 1 and part.count <= dense.most:
            left, ways = take_in(part, dense, goal, 0), 1
        elif way == 0:
            left = descend(part, newton, INSIDE * goal, INSIDE * close, WARM, 1.0, odd)
        elif inside == 1 and least > close:
            if way == 1:
                begin(part, newton.path, start_of(turn), 1.0 if turn < LATE else 0.0)
            go_on(part, newton, ROUGH if way == 1 else (FINER if way == 2 else FINEST), PATH)
            left = descend(part, newton, INSIDE * goal, INSIDE * close, WARM if turn == 0 else COLD, 1.0, odd)
        elif least > close:
            for i in range(part.count):
                part.x[i] = greater(part.low[i], 0.0)
            left = descend(part, newton, INSIDE * goal, INSIDE * close, COLD, looseness(turn), odd)
        if left < least:
            least = left
            for i in range(part.count):
                newton.y[i] = part.x[i]
    for i in range(part.count):
        part.x[i] = newton.y[i]
    if turn != SMALL_FIRST or least <= close:
        islands.worst[island] = least * problem.reference
        for i in range(part.count):
            problem.x[islands.own[i]] = part.x[i]
    return 1 if least <= close else 0


@compiled
def start_of(turn: int) -> float:
    """Return the rates, relative to the reference, at which the interior point method begins in a turn."""
    if turn % 2 == 0:
        return 0.1 if turn % LATE == 0 else 0.01
    return 1.0 if turn % LATE == 1 else 10.0


@compiled
def looseness(turn: int) -> float:
    """Return the part of the residual that a step is damped by in a turn: what one leads astray, another solves."""
    if turn % 3 == 1:
        return 1.0
    return 10.0 if turn % 3 == 2 else 0.1


@compiled
def improve(problem: ContactProblem, islands: Islands, island: int, goal: float) -> None:
    """Solve the island that is laid out from its impulses; take what violates its laws less."""
    part, newton, unit, x = islands.part, islands.newton, 0.0, islands.part.x
    add_all(part)
    newton.kept = 0.0
    for k in range(part.blocks.n):
        newton.v[k] = part.v[k]
    for i in range(part.count):
        newton.y[i], newton.past[i], newton.moved[i] = x[i], x[i], 0.0
        unit += part.scale[i] / part.count
    soft, last, least, idle = SOFT * unit, residual(part), islands.worst[island] / problem.reference, 0
    while idle < IDLE and least > goal and math.isfinite(last) and problem.stop == 0:
        idle += 1
        steps = balance(part, newton, soft, greater(ROUND_OFF, INEXACT * last), FEW)
        islands.steps += steps
        if steps == FEW and soft < SOFTEST * unit:
            soft = lesser(10.0 * soft, SOFTEST * unit)
            for k in range(part.blocks.n):
                newton.v[k] = part.v[k]
            continue
        for i in range(part.count):
            x[i] = newton.here.x[i]
        add_all(part)
        left = residual(part)
        follow(part, newton)
        if left < least:
            if left < 0.5 * least:
                idle = 0
            least = left
            for i in range(part.count):
                problem.x[islands.own[i]] = x[i]
        if left > SLOW * last:
            soft = (
                greater(soft / 10.0, HARDEST * unit) if left > FINE else lesser(10.0 * soft, SOFTEST * unit)
            )
        last = left
    if least > goal and part.blocks.n <= ANEW and problem.stop == 0:
        begin_anew(problem, islands, least, goal)


@compiled
def begin_anew(problem: ContactProblem, islands: Islands, least: float, goal: float) -> None:
    """Solve the small island that is laid out from zero; take what violates its laws less.

    The compliances from great ones on find what rounds from the impulses of sweeps do not: slips that differ by
    millionths between contacts whose rows nearly depend on each other, as the corners of a box on a soft floor.
    """
    part = islands.part
    islands.steps += solve(part, islands.newton, goal)
    add_all(part)
    if residual(part) < least:
        for i in range(part.count):
            problem.x[islands.own[i]] = part.x[i]


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
