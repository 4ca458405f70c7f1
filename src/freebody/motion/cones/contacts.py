"""Contacts that are at rest or slide: their contact problem, and its solution, in compiled code.

The unknowns x, λ = B x, are the forces of equalities, one for each normal and, for a contact at rest with friction,
one for each tangent; a contact that slides along d has the column e_N - μ d e_T. What `newton.solve` finds from zero is
polished by Newton's method on the laws themselves, e(x) = 0 (`cone.violation`), in unknowns √s x and equations e/√s.
Its steps are least in norm where A is singular: (JᵀJ + δ) dx = -Jᵀ e.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from ...native.instructions import compiled, greater, inlined, root
from ...native.records import Count, Real, Record, Row, Whole, Wholes, record
from .cone import set_scales, violation, violation_slopes
from .contact_problem import DEPENDENT, EQUALITY, FIRST, GOAL, LINE, NORMAL, ContactProblem, Newton
from .elimination import solved
from .newton import factor, solve

EXACT = 1e-10
"""Relative residual above which a result is not a solution."""
ROUGH, FINE = 1e-5, 1e-13
"""Relative residual from which the polish begins, and with which its result is accepted."""
ROUNDS, LOOSE = 20, 1e-13
"""Limit on steps of the polish; δ relative to the scaled slopes, which are about 1."""


@dataclass(frozen=True)
class Touching:
    """One closed contact of the problem.

    ``held``       True if its normal force is 1 and its normal row is zero
    ``row``        its first row (normal), followed by its ``tangents`` rows (1 planar, 2 spatial, 0 frictionless)
    ``friction``   kinetic coefficient; ``static`` is the static coefficient
    ``sliding``    unit direction of slip, shape (tangents,), if it already slips; None at rest
    """

    name: str
    row: int
    tangents: int
    friction: float
    static: float
    sliding: NDArray[np.float64] | None = None
    held: bool = False


@record
class Contacts(Record):
    """``contacts`` with ``rows`` rates r = A λ + c, after ``equalities`` rows ``equal`` with r = 0.

    ``at``, ``tangents``       first row and number of tangents of each contact
    ``friction``, ``static``   its kinetic and static coefficients
    ``slides``, ``way``        1 if it slides, and along which direction (two numbers)
    ``least``                  its normal force that acts in any case
    ``given``                  c; speeds just before an impact
    ``forces``, ``after``      λ and r
    ``problem``                the problem of the unknowns; ``place`` is the row of each in A, ``owner`` its contact
    ``directions``             number of independent directions of A;  ``most``: limit of the rows
    ``restitution``, ``poisson``, ``still``, ``energy``, ``part``    of an impact (`contact.collision`)
    """

    contacts: Whole
    rows: Whole
    equalities: Whole
    poisson: Whole
    still: Real
    energy: Real
    part: Real
    residual: Real
    directions: Whole
    most: Count
    at: Annotated[Wholes, "k"]
    tangents: Annotated[Wholes, "k"]
    slides: Annotated[Wholes, "k"]
    friction: Annotated[Row, "k"]
    static: Annotated[Row, "k"]
    least: Annotated[Row, "k"]
    restitution: Annotated[Row, "k"]
    way: Annotated[Row, "k2"]
    equal: Annotated[Wholes, "most"]
    A: Annotated[Row, "square"]
    given: Annotated[Row, "most"]
    forces: Annotated[Row, "most"]
    after: Annotated[Row, "most"]
    problem: ContactProblem
    newton: Newton
    place: Annotated[Wholes, "most"]
    owner: Annotated[Wholes, "most"]
    starts: Annotated[Wholes, 2]
    pieces: Annotated[Wholes, "ends"]
    first: Annotated[Wholes, "ends"]
    ends: Annotated[Wholes, "ends"]
    H: Annotated[Row, "square"]
    C: Annotated[Row, "square"]
    chosen: Annotated[Row, "square"]
    factors: Annotated[Row, "square"]
    slope: Annotated[Row, "square"]
    normal: Annotated[Row, "square"]
    best: Annotated[Row, "most"]
    left: Annotated[Row, "most"]
    order: Annotated[Wholes, "most"]


def contacts_of(
    A: Any, c: Any, contacts: Sequence[Touching], low: Any = 0.0, equalities: Sequence[int] = (), impact: bool = False
) -> Contacts:  # fmt: skip
    """Return contacts in memory of their own.

    In an ``impact``, which does not depend on earlier sticking or sliding, every contact has the cone of its kinetic
    friction.
    """
    k, m = len(contacts), len(c)
    it = contacts_room(k, m)
    it.contacts, it.rows, it.equalities = k, m, len(equalities)
    if m:
        it.A[: m * m], it.given[:m], it.equal[: len(equalities)] = np.ravel(A), c, equalities
    if k:
        it.at[:], it.tangents[:] = [one.row for one in contacts], [one.tangents for one in contacts]
        it.friction[:] = [one.friction for one in contacts]
        it.static[:] = it.friction if impact else [one.static for one in contacts]
        it.least[:] = low
        if not impact:
            it.least[[one.held for one in contacts]] = 1.0
    for i, one in enumerate(contacts):
        if one.sliding is not None and not impact:
            it.slides[i] = 1
            it.way[2 * i : 2 * i + one.tangents] = one.sliding
    return it


def contacts_room(k: int, rows: int) -> Contacts:
    """Return memory for up to ``k`` contacts with up to so many rows."""
    most = max(rows, 1)
    it = Contacts.made(k=k, k2=2 * k, most=most, n=most, square=most * most, ends=most + 1)
    it.problem.W, it.problem.X = it.H, it.C
    blocks = it.problem.blocks
    blocks.count, blocks.starts, blocks.pieces = 1, it.starts, it.pieces
    blocks.first, blocks.at = it.first, it.ends
    return it


@inlined
def ray(it: Contacts, a: int, j: int) -> float:
    """Return the force on tangent ``j`` per unit of an unknown that belongs to a contact that slides."""
    return -it.friction[it.owner[a]] * it.way[2 * it.owner[a] + j]


@compiled
def lay_out(it: Contacts) -> None:
    """Set the rows of the problem, their rates per unit impulse, factors of these, and scales."""
    problem, m = it.problem, it.equalities
    for a in range(m):
        it.place[a], problem.kinds[a], it.owner[a], problem.mu[a] = it.equal[a], EQUALITY, -1, 0.0
    for k in range(it.contacts):
        n = it.tangents[k] if it.slides[k] == 0 and it.static[k] > 0.0 else 0
        for j in range(1 + n):
            it.place[m + j] = it.at[k] + j
            it.owner[m + j] = k if it.slides[k] != 0 else -1
            problem.mu[m + j] = it.static[k]
            problem.kinds[m + j] = NORMAL if j == 0 else (LINE if n == 1 else FIRST + j - 1)
        m += 1 + n
    problem.count = m
    n = factor(it.A, it.rows, it.factors, DEPENDENT, it.left, it.order)
    it.directions = n
    lay_out_blocks(it, n)
    for a in range(m):
        row = it.place[a] * it.rows
        for b in range(m):
            it.chosen[a * m + b] = it.A[row + it.place[b]]
            if it.owner[b] >= 0:
                for j in range(it.tangents[it.owner[b]]):
                    it.chosen[a * m + b] += ray(it, b, j) * it.A[row + it.place[b] + 1 + j]
        for k in range(n):
            it.H[a * n + k] = it.factors[row + k]
            it.C[a * n + k] = it.factors[row + k]
            if it.owner[a] >= 0:
                for j in range(it.tangents[it.owner[a]]):
                    it.C[a * n + k] += ray(it, a, j) * it.factors[row + (1 + j) * it.rows + k]
        for k in range(3):
            problem.matrix[a, k] = 0.0
            if a + k < m:
                problem.matrix[a, k] = it.A[row + it.place[a + k]]
        problem.matrix[a, 0] = abs(problem.matrix[a, 0])
    scale_held(it)
    set_scales(problem)


@compiled
def scale_held(it: Contacts) -> None:
    """Compare a normal force that moves nothing, such as that of a joint's friction, by the rate of its tangent."""
    a, problem = it.equalities, it.problem
    for k in range(it.contacts):
        if it.least[k] > 0.0 and it.A[it.at[k] * (it.rows + 1)] == 0.0:
            tangent = (it.at[k] + 1) * (it.rows + 1)
            problem.matrix[a, 0] = it.A[tangent]
        a += 1
        while a < problem.count and problem.kinds[a] != NORMAL:
            a += 1


@compiled
def lay_out_blocks(it: Contacts, n: int) -> None:
    """Let every row have one block of n speeds."""
    blocks = it.problem.blocks
    blocks.n = n
    it.starts[0], it.starts[1] = 0, n
    for a in range(it.problem.count + 1):
        it.pieces[a], it.first[a], it.ends[a] = 0, a, a * n
    for a in range(it.problem.count):
        it.problem.rows[a] = a


@compiled
def violated(it: Contacts) -> float:
    """Set the rates and violations of x; return the greatest violation relative to the reference."""
    problem, m = it.problem, it.problem.count
    for a in range(m):
        r = problem.b[a]
        for b in range(m):
            r += it.chosen[a * m + b] * problem.x[b]
        problem.r[a] = r
        if not math.isfinite(r):
            return math.inf
    return violation(problem)


@compiled
def step(it: Contacts) -> int:
    """Set ``left`` to the step of least norm that cancels the violations; return 0 if there is none, else 1."""
    problem, m, J, N = it.problem, it.problem.count, it.slope, it.normal
    scale = problem.scale
    violation_slopes(problem, it.chosen, J)
    for i in range(m):
        it.left[i] = 0.0
        for j in range(m):
            N[i * m + j] = LOOSE if i == j else 0.0
    for a in range(m):
        for i in range(m):
            p = J[a * m + i] / root(scale[a] * scale[i])
            if p != 0.0:
                it.left[i] -= p * problem.e[a] / root(scale[a])
                for j in range(m):
                    N[i * m + j] += p * J[a * m + j] / root(scale[a] * scale[j])
    if solved(N, m, it.left) == 0:
        return 0
    for i in range(m):
        it.left[i] /= root(scale[i])
    return 1


@compiled
def answer(it: Contacts) -> float:
    """Set x to the solution of r = A x + b from zero; return its residual.

    If A is regular, the polish finds the solution from a rough one. Otherwise it would keep what that has of forces
    without effect, and these are to be those of equal compliance.
    """
    problem, size = it.problem, 0.0
    for a in range(problem.count):
        size = greater(size, greater(abs(problem.b[a]), problem.scale[a] * abs(problem.low[a])))
    problem.reference = size
    if it.directions == it.rows:
        least = polished(it, ROUGH)
        if least <= FINE:
            return least
    return polished(it, GOAL)


@compiled
def polished(it: Contacts, goal: float) -> float:
    """Set x to a solution to within ``goal`` from zero, polished; return its residual."""
    problem = it.problem
    solve(problem, it.newton, goal)
    for a in range(problem.count):
        it.best[a] = problem.x[a]
    least = violated(it)
    for _ in range(ROUNDS):
        if least <= GOAL or not math.isfinite(least):
            break
        if step(it) == 0:
            break
        for a in range(problem.count):
            problem.x[a] += it.left[a]
        new = violated(it)
        if not new < least:
            break
        least = new
        for a in range(problem.count):
            it.best[a] = problem.x[a]
    for a in range(problem.count):
        problem.x[a] = it.best[a]
    return least


@compiled
def take(it: Contacts) -> None:
    """Add B x to the forces; set ``after`` to A λ + c."""
    x = it.problem.x
    for a in range(it.problem.count):
        it.forces[it.place[a]] += x[a]
        if it.owner[a] >= 0:
            for j in range(it.tangents[it.owner[a]]):
                it.forces[it.place[a] + 1 + j] += ray(it, a, j) * x[a]
    for i in range(it.rows):
        r = it.given[i]
        for j in range(it.rows):
            r += it.A[i * it.rows + j] * it.forces[j]
        it.after[i] = r


@compiled
def find(it: Contacts) -> int:
    """Set forces, rates and residual of the problem; return 0."""
    lay_out(it)
    problem, a = it.problem, it.equalities
    for i in range(it.rows):
        it.forces[i] = 0.0
    for i in range(problem.count):
        problem.b[i], problem.low[i] = it.given[it.place[i]], 0.0
    for k in range(it.contacts):
        problem.low[a] = it.least[k]
        a += 1
        while a < problem.count and problem.kinds[a] > NORMAL:
            a += 1
    it.residual = answer(it)
    take(it)
    return 0
