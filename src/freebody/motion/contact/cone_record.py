"""A contact problem as a record, its solution and that of an impact in compiled code.

The unknowns x, λ = B x, are the forces of equalities, one for each normal and, for a contact at rest with friction,
one for each tangent; a contact that slides along d has the column e_N - μ d e_T. What `cone_newton.solve` finds from
zero is polished by Newton's method on the laws themselves, with s of `ConeProblem.scales`:

    e_N = min(r_N, s (x - low)),    e_T = s x - P(s x - r),    P: the nearest point of |T| <= s μ x_N

in unknowns √s x and equations e/√s. Its steps are least in norm where A is singular: (JᵀJ + δ) dx = -Jᵀ e.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from ...native.instructions import Reals, compiled, greater, inlined, lesser, root
from ...native.loop import made
from ...native.records import Real, Record, Row, Whole, Wholes, record
from ..phase.elimination import solved
from .cone_newton import EQUALITY, FIRST, LINE, NORMAL, SECOND, factor, room, solve

EXACT = 1e-10
"""Relative residual above which a result is not a solution."""
GOAL = 1e-15
"""Relative residual at which the search ends; without progress it also ends at `cone_newton.ENOUGH`."""
DEPENDENT = 1e-13
"""Part of a row's diagonal below which the row depends on the others."""
HALVINGS = 5
"""The restitution of an impact is halved up to four times, until the energy does not grow, and is zero at last."""
ROUNDS, LOOSE = 20, 1e-13
"""Limit on steps of the polish; δ relative to the scaled slopes, which are about 1."""


@dataclass(frozen=True)
class Touching:
    """One closed contact of the problem.

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


@record
class Cone(Record):
    """A problem r = A λ + c of ``contacts`` with ``rows`` rates, after ``equalities`` rows ``equal`` with r = 0.

    ``at``, ``tangents``       first row and number of tangents of each contact
    ``friction``, ``static``   its kinetic and static coefficients
    ``slides``, ``way``        1 if it slides, and along which direction (two numbers)
    ``least``                  its normal force that acts in any case
    ``given``                  c; speeds just before an impact
    ``forces``, ``after``      λ and r
    ``unknowns``, ``directions``    number of unknowns, and of their independent directions
    ``restitution``, ``poisson``, ``still``, ``energy``, ``part``    of an impact
    """

    contacts: Whole
    rows: Whole
    equalities: Whole
    poisson: Whole
    still: Real
    energy: Real
    part: Real
    residual: Real
    unknowns: Whole
    directions: Whole
    at: Annotated[Wholes, "k"]
    tangents: Annotated[Wholes, "k"]
    slides: Annotated[Wholes, "k"]
    friction: Annotated[Row, "k"]
    static: Annotated[Row, "k"]
    least: Annotated[Row, "k"]
    restitution: Annotated[Row, "k"]
    way: Annotated[Row, "k2"]
    equal: Annotated[Wholes, "m"]
    A: Annotated[Row, "square"]
    given: Annotated[Row, "m"]
    forces: Annotated[Row, "m"]
    after: Annotated[Row, "m"]
    kinds: Annotated[Wholes, "m"]
    place: Annotated[Wholes, "m"]
    owner: Annotated[Wholes, "m"]
    mu: Annotated[Row, "m"]
    low: Annotated[Row, "m"]
    scale: Annotated[Row, "m"]
    c: Annotated[Row, "m"]
    x: Annotated[Row, "m"]
    best: Annotated[Row, "m"]
    rates: Annotated[Row, "m"]
    error: Annotated[Row, "m"]
    chosen: Annotated[Row, "square"]
    factors: Annotated[Row, "square"]
    slope: Annotated[Row, "square"]
    normal: Annotated[Row, "square"]
    left: Annotated[Row, "m"]
    order: Annotated[Wholes, "m"]
    two: Annotated[Row, 2]
    block: Annotated[Row, "block"]


def cone(
    A: Any, c: Any, contacts: Sequence[Touching], low: Any = 0.0, equalities: Sequence[int] = (), impact: bool = False
) -> Cone:  # fmt: skip
    """Return a contact problem in memory of its own.

    In an ``impact``, which does not depend on earlier sticking or sliding, every contact has the cone of its kinetic
    friction.
    """
    k, m = len(contacts), len(c)
    it = Cone.made(k=k, k2=2 * k, m=m, square=m * m, block=2 * m * m + 5 * m + room(m, m))
    it.contacts, it.rows, it.equalities = k, m, len(equalities)
    if m:
        it.A[:], it.given[:], it.equal[: len(equalities)] = np.ravel(A), c, equalities
    if k:
        it.at[:], it.tangents[:] = [one.row for one in contacts], [one.tangents for one in contacts]
        it.friction[:] = [one.friction for one in contacts]
        it.static[:] = it.friction if impact else [one.static for one in contacts]
        it.least[:] = low
    for i, one in enumerate(contacts):
        if one.sliding is not None and not impact:
            it.slides[i] = 1
            it.way[2 * i : 2 * i + one.tangents] = one.sliding
    return it


@inlined
def ray(it: Cone, i: int, j: int) -> float:
    """Return the force on tangent ``j`` per unit of an unknown that belongs to a contact that slides."""
    return -it.friction[it.owner[i]] * it.way[2 * it.owner[i] + j]


@compiled
def laid_out(it: Cone) -> None:
    """Set kinds, places, coefficients, scales of the unknowns, their rates per unit, and the factors in the block."""
    m = it.equalities
    for i in range(m):
        it.place[i], it.kinds[i], it.owner[i], it.mu[i] = it.equal[i], EQUALITY, -1, 0.0
    for k in range(it.contacts):
        n = it.tangents[k] if it.slides[k] == 0 and it.static[k] > 0.0 else 0
        for j in range(1 + n):
            it.place[m + j] = it.at[k] + j
            it.owner[m + j] = k if it.slides[k] != 0 else -1
            it.mu[m + j] = it.static[k]
            it.kinds[m + j] = NORMAL if j == 0 else (LINE if n == 1 else FIRST + j - 1)
        m += 1 + n
    it.unknowns = m
    n = factor(it.A, it.rows, it.factors, DEPENDENT, it.left, it.order)
    it.directions = n
    for i in range(m):
        row = it.place[i] * it.rows
        for j in range(m):
            it.chosen[i * m + j] = it.A[row + it.place[j]]
            if it.owner[j] >= 0:
                for b in range(it.tangents[it.owner[j]]):
                    it.chosen[i * m + j] += ray(it, j, b) * it.A[row + it.place[j] + 1 + b]
        for k in range(n):
            it.block[i * n + k] = it.factors[row + k]
            it.block[m * n + i * n + k] = it.factors[row + k]
            if it.owner[i] >= 0:
                for b in range(it.tangents[it.owner[i]]):
                    it.block[m * n + i * n + k] += ray(it, i, b) * it.factors[row + (1 + b) * it.rows + k]
        it.scale[i] = abs(it.A[row + it.place[i]])
        if it.kinds[i] == SECOND:
            it.scale[i] += it.scale[i - 1]
            it.scale[i - 1] = it.scale[i]


@compiled
def missed(it: Cone, x: Reals, size: float) -> float:
    """Set ``rates`` and ``error`` at x; return the greatest violation relative to ``size``."""
    m, worst = it.unknowns, 0.0
    for i in range(m):
        r = it.c[i]
        for j in range(m):
            r += it.chosen[i * m + j] * x[j]
        it.rates[i] = r
    for i in range(m):
        r, s = it.rates[i], it.scale[i]
        it.error[i] = r
        if it.kinds[i] == NORMAL:
            it.error[i] = lesser(s * (x[i] - it.low[i]), r)
        elif it.kinds[i] == LINE:
            free, limit = s * x[i] - r, s * it.mu[i] * greater(x[i - 1], 0.0)
            if abs(free) > limit:
                it.error[i] = s * x[i] - (limit if free > 0.0 else -limit)
        elif it.kinds[i] == FIRST or it.kinds[i] == SECOND:
            a = i if it.kinds[i] == FIRST else i - 1
            p, q, limit = (
                s * x[a] - it.rates[a], s * x[a + 1] - it.rates[a + 1], s * it.mu[i] * greater(x[a - 1], 0.0)
            )  # fmt: skip
            length = root(p * p + q * q)
            if length > limit:
                it.error[i] = s * x[i] - limit / length * (p if i == a else q)
        if not math.isfinite(it.error[i]):
            return math.inf
        size_here = abs(it.error[i])
        if it.kinds[i] == SECOND:
            size_here = root(it.error[i - 1] * it.error[i - 1] + it.error[i] * it.error[i])
        worst = greater(worst, size_here)
    return worst / size if size > 0.0 else 0.0


@compiled
def sloped(it: Cone, x: Reals) -> None:
    """Set ``slope`` to the derivatives of ``error``, at x with its rates."""
    m, J = it.unknowns, it.slope
    for i in range(m):
        s, kind = it.scale[i], it.kinds[i]
        if kind != SECOND:  # set with the first tangent
            for j in range(m):
                J[i * m + j] = it.chosen[i * m + j]
        pressed, outside = 1.0, False
        if LINE <= kind <= FIRST:
            pressed = 1.0 if x[i - 1] > 0.0 else 0.0
        if kind == NORMAL:
            outside = s * (x[i] - it.low[i]) <= it.rates[i]
        elif kind == LINE:
            free = s * x[i] - it.rates[i]
            outside = abs(free) > s * it.mu[i] * greater(x[i - 1], 0.0)
        if NORMAL <= kind <= LINE:
            if outside:
                for j in range(m):
                    J[i * m + j] = 0.0
                J[i * m + i] = s
                if kind == LINE:
                    J[i * m + i - 1] = -s * it.mu[i] * pressed * (1.0 if s * x[i] > it.rates[i] else -1.0)
        elif kind == FIRST:
            p, q, limit = (
                s * x[i] - it.rates[i], s * x[i + 1] - it.rates[i + 1], s * it.mu[i] * greater(x[i - 1], 0.0)
            )  # fmt: skip
            length = root(p * p + q * q)
            for j in range(m):
                J[(i + 1) * m + j] = it.chosen[(i + 1) * m + j]
            if length > limit:
                e, f, part = p / length, q / length, limit / length
                for j in range(m):
                    a = (s if j == i else 0.0) - it.chosen[i * m + j]
                    b = (s if j == i + 1 else 0.0) - it.chosen[(i + 1) * m + j]
                    along = e * a + f * b
                    J[i * m + j] = (s if j == i else 0.0) - part * (a - e * along)
                    J[(i + 1) * m + j] = (s if j == i + 1 else 0.0) - part * (b - f * along)
                J[i * m + i - 1] -= s * it.mu[i] * pressed * e
                J[(i + 1) * m + i - 1] -= s * it.mu[i] * pressed * f


@compiled
def stepped(it: Cone) -> int:
    """Set ``left`` to the step of least norm that cancels ``error``; return 0 if there is none, else 1."""
    m, J, N = it.unknowns, it.slope, it.normal
    for i in range(m):
        it.left[i] = 0.0
        for j in range(m):
            N[i * m + j] = LOOSE if i == j else 0.0
    for a in range(m):
        for i in range(m):
            p = J[a * m + i] / root(it.scale[a] * it.scale[i])
            if p != 0.0:
                it.left[i] -= p * it.error[a] / root(it.scale[a])
                for j in range(m):
                    N[i * m + j] += p * J[a * m + j] / root(it.scale[a] * it.scale[j])
    if solved(N, m, it.left) == 0:
        return 0
    for i in range(m):
        it.left[i] /= root(it.scale[i])
    return 1


@compiled
def answered(it: Cone) -> float:
    """Set x to the solution of r = A x + c from zero; return its residual."""
    m, n = it.unknowns, it.directions
    at, size = 2 * m * n, 0.0
    for i in range(m):
        it.block[at + i] = it.c[i]
        it.block[at + m + i] = it.mu[i]
        it.block[at + 2 * m + i] = it.low[i]
        it.block[at + 3 * m + i] = it.scale[i]
        size = greater(size, greater(abs(it.c[i]), it.scale[i] * abs(it.low[i])))
    solve(it.block, it.kinds, m, n, GOAL, it.two)
    for i in range(m):
        it.x[i] = it.block[at + 4 * m + i]
        it.best[i] = it.x[i]
    least = missed(it, it.x, size)
    for _ in range(ROUNDS):
        if least <= GOAL or not math.isfinite(least):
            break
        sloped(it, it.x)
        if stepped(it) == 0:
            break
        for i in range(m):
            it.x[i] += it.left[i]
        new = missed(it, it.x, size)
        if not new < least:
            break
        least = new
        for i in range(m):
            it.best[i] = it.x[i]
    for i in range(m):
        it.x[i] = it.best[i]
    return least


@compiled
def taken(it: Cone) -> None:
    """Add B x to the forces; set ``after`` to A λ + c."""
    for i in range(it.unknowns):
        it.forces[it.place[i]] += it.x[i]
        if it.owner[i] >= 0:
            for b in range(it.tangents[it.owner[i]]):
                it.forces[it.place[i] + 1 + b] += ray(it, i, b) * it.x[i]
    for i in range(it.rows):
        r = it.given[i]
        for j in range(it.rows):
            r += it.A[i * it.rows + j] * it.forces[j]
        it.after[i] = r


@compiled
def found(it: Cone) -> None:
    """Set forces, rates and residual of the problem."""
    laid_out(it)
    for i in range(it.rows):
        it.forces[i] = 0.0
    for i in range(it.unknowns):
        it.c[i], it.low[i] = it.given[it.place[i]], 0.0
    first = it.equalities
    for k in range(it.contacts):
        it.low[first] = it.least[k]
        first += 1
        while first < it.unknowns and it.kinds[first] > NORMAL:
            first += 1
    it.residual = answered(it)
    taken(it)


@compiled
def rebounded(it: Cone, part: float) -> float:
    """Set impulses and speeds for a part of the restitution; return the residual."""
    for i in range(it.rows):
        it.forces[i], it.after[i] = 0.0, it.given[i]
    for i in range(it.unknowns):
        it.c[i], it.low[i] = it.given[it.place[i]], 0.0
    if it.poisson == 0:
        at = 0
        for k in range(it.contacts):
            while it.place[at] != it.at[k]:
                at += 1
            if it.given[it.at[k]] < -it.still:
                it.c[at] += part * it.restitution[k] * it.given[it.at[k]]
    residual = answered(it)
    taken(it)
    if it.poisson != 0:
        at = 0
        for k in range(it.contacts):
            while it.place[at] != it.at[k]:
                at += 1
            it.low[at] = greater(part * it.restitution[k] * it.x[at], 0.0)
        for i in range(it.unknowns):
            it.c[i] = it.after[it.place[i]]
        residual = greater(residual, answered(it))
        taken(it)
    return residual


@compiled
def collided(it: Cone) -> None:
    """Find the impulses, with the greatest of the parts of the restitution for which the energy does not grow."""
    laid_out(it)
    for turn in range(1 + HALVINGS):
        it.part = 0.0 if turn == HALVINGS else 1.0 / (1 << turn)
        it.residual = rebounded(it, it.part)
        it.energy, size = 0.0, 0.0
        for i in range(it.rows):
            it.energy += it.forces[i] * (it.given[i] + it.after[i]) / 2.0  # ΔT = Λ·(v⁻ + v⁺)/2
            size += abs(it.forces[i]) * (abs(it.given[i]) + abs(it.after[i]))
        if it.residual <= EXACT and it.energy <= EXACT * size:
            return


def compiled_code() -> Any:
    """Return the functions `found` and `collided` as machine code."""
    label = __name__.partition(".")[2]
    return made(label, (label,), ("found", "collided"), lambda: globals()).functions
