"""The impulses of one impact in compiled code: Newton's and Poisson's laws over the problem of `cone_newton`.

A problem has one unknown for each normal and, with friction, for each tangent: kinds, μ and lower limits as there. What
`cone_newton.solve` finds is polished by Newton's method on the laws themselves, with s of `ConeProblem.scales`:

    e_N = min(r_N, s (x - low)),    e_T = s x - P(s x - r),    P: the nearest point of |T| <= s μ x_N

in unknowns √s x and equations e/√s. Its steps are least in norm where A is singular: (JᵀJ + δ) dx = -Jᵀ e.
"""

from __future__ import annotations

import math
from typing import Annotated

from ...native.instructions import Reals, compiled, greater, lesser, root
from ...native.records import Real, Record, Row, Whole, Wholes, record
from ..phase.elimination import solved
from .cone_newton import FIRST, LINE, NORMAL, SECOND, factor, room, solve

EXACT = 1e-10
"""Relative residual above which a result is not a solution."""
GOAL = 1e-15
"""Relative residual at which the search ends; without progress it also ends at `cone_newton.ENOUGH`."""
DEPENDENT = 1e-13
"""Part of a row's diagonal below which the row depends on the others."""
HALVINGS = 5
"""The restitution is halved up to four times, until the energy does not grow, and is zero at last."""
ROUNDS, LOOSE = 20, 1e-13
"""Limit on steps of the polish; δ relative to the scaled slopes, which are about 1."""


@record
class Collision(Record):
    """An impact of ``contacts`` with ``rows`` rates.

    ``at``, ``tangents``       first row and number of tangents of each contact
    ``friction``, ``restitution``    its kinetic μ and e
    ``poisson``                1 for Poisson's law, 0 for Newton's
    ``still``                  approach speed up to which a contact is at rest
    ``A``, ``before``          speeds per unit impulse, and speeds just before
    ``impulses``, ``after``    what is found, with the change of energy, the part of e that acts, the residual, the
                               number of unknowns and that of their independent directions
    """

    contacts: Whole
    rows: Whole
    poisson: Whole
    still: Real
    energy: Real
    part: Real
    residual: Real
    unknowns: Whole
    directions: Whole
    at: Annotated[Wholes, "k"]
    tangents: Annotated[Wholes, "k"]
    friction: Annotated[Row, "k"]
    restitution: Annotated[Row, "k"]
    A: Annotated[Row, "square"]
    before: Annotated[Row, "m"]
    impulses: Annotated[Row, "m"]
    after: Annotated[Row, "m"]
    kinds: Annotated[Wholes, "m"]
    place: Annotated[Wholes, "m"]
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


def collision(contacts: int, rows: int) -> Collision:
    """Return the memory of an impact."""
    block = 2 * rows * rows + 5 * rows + room(rows, rows)
    return Collision.made(k=contacts, m=rows, square=rows * rows, block=block)


@compiled
def laid_out(it: Collision) -> None:
    """Set kinds, places, coefficients and scales of the unknowns, their part of A, and its factor in the block."""
    m = 0
    for k in range(it.contacts):
        n = it.tangents[k] if it.friction[k] > 0.0 else 0
        for j in range(1 + n):
            it.place[m + j] = it.at[k] + j
            it.mu[m + j] = it.friction[k]
            it.kinds[m + j] = NORMAL if j == 0 else (LINE if n == 1 else FIRST + j - 1)
        m += 1 + n
    it.unknowns = m
    for i in range(m):
        for j in range(m):
            it.chosen[i * m + j] = it.A[it.place[i] * it.rows + it.place[j]]
        it.scale[i] = abs(it.chosen[i * m + i])
        if it.kinds[i] == SECOND:
            it.scale[i] += it.scale[i - 1]
            it.scale[i - 1] = it.scale[i]
    n = factor(it.chosen, m, it.factors, DEPENDENT, it.left, it.order)
    it.directions = n
    for i in range(m):
        for k in range(n):
            it.block[i * n + k] = it.factors[i * m + k]
            it.block[m * n + i * n + k] = it.factors[i * m + k]


@compiled
def missed(it: Collision, x: Reals, size: float) -> float:
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
        worst = greater(worst, abs(it.error[i]))
    return worst / size if size > 0.0 else 0.0


@compiled
def sloped(it: Collision, x: Reals) -> None:
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
def stepped(it: Collision) -> int:
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
def answered(it: Collision) -> float:
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
def taken(it: Collision) -> None:
    """Add x to the impulses; set ``after`` to A Λ + v."""
    for i in range(it.unknowns):
        it.impulses[it.place[i]] += it.x[i]
    for i in range(it.rows):
        v = it.before[i]
        for j in range(it.rows):
            v += it.A[i * it.rows + j] * it.impulses[j]
        it.after[i] = v


@compiled
def rebounded(it: Collision, part: float) -> float:
    """Set impulses and speeds for a part of the restitution; return the residual."""
    for i in range(it.rows):
        it.impulses[i], it.after[i] = 0.0, it.before[i]
    for i in range(it.unknowns):
        it.c[i], it.low[i] = it.before[it.place[i]], 0.0
    if it.poisson == 0:
        at = 0
        for k in range(it.contacts):
            while it.place[at] != it.at[k]:
                at += 1
            if it.before[it.at[k]] < -it.still:
                it.c[at] += part * it.restitution[k] * it.before[it.at[k]]
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
def collided(it: Collision) -> None:
    """Find the impulses, with the greatest of the parts of the restitution for which the energy does not grow."""
    laid_out(it)
    for turn in range(1 + HALVINGS):
        it.part = 0.0 if turn == HALVINGS else 1.0 / (1 << turn)
        it.residual = rebounded(it, it.part)
        it.energy, size = 0.0, 0.0
        for i in range(it.rows):
            it.energy += it.impulses[i] * (it.before[i] + it.after[i]) / 2.0  # ΔT = Λ·(v⁻ + v⁺)/2
            size += abs(it.impulses[i]) * (abs(it.before[i]) + abs(it.after[i]))
        if it.residual <= EXACT and it.energy <= EXACT * size:
            return
