"""The solution of the contact problem of contacts that are at rest or slide, in compiled code.

The unknowns x, λ = B x, are the forces of equalities, one for each normal and, for a contact at rest with friction,
one for each tangent; a contact that slides along d has the column e_N - μ d e_T. What `newton.solve` finds from zero is
polished by Newton's method on the laws themselves, e(x) = 0 (`cone.violation`), in unknowns √s x and equations e/√s.
Its steps are least in norm where A is singular: (JᵀJ + δ) dx = -Jᵀ e. Where the solution is proven to be the only one
(`uniqueness`), this method tries it alone.
"""

from __future__ import annotations

import math

from ...native.instructions import Reals, compiled, greater, inlined, root
from .combinations import name_pressers, rated
from .cone import set_scales, violation, violation_slopes
from .contact_problem import DEPENDENT, EQUALITY, FIRST, GOAL, LINE, NORMAL
from .contacts import Contacts
from .elimination import solved
from .newton import factor, press_at_least, solve
from .uniqueness import SMALL, behind, is_held, unique

ROUGH, CLOSE, FINE = 1e-5, 1e-10, 1e-13
"""Relative residual from which the polish begins, also if A is singular, and with which its result is accepted."""
ROUNDS, LOOSE = 20, 1e-13
"""Limit on steps of the polish; δ relative to the scaled slopes, which are about 1."""
STRAIGHT = 10
"""Limit on steps from zero where the solution is the only one."""


@inlined
def ray(it: Contacts, k: int, j: int) -> float:
    """Return the force on tangent ``j`` of a contact that slides, per unit of the normal force that bounds it."""
    return -it.friction[k] * it.way[2 * k + j]


@compiled
def along_ray(it: Contacts, a: int, x: Reals, stride: int) -> float:
    """Return the sum of the forces on tangents per unit of an unknown times x of their rows, ``stride`` apart."""
    total, k = 0.0, it.owner[a]
    for s in range(k, behind(it, k)):
        if it.slides[s] != 0:
            for j in range(it.tangents[s]):
                total += ray(it, s, j) * x[(it.at[s] + 1 + j) * stride]
    return total


@compiled
def slides_in(it: Contacts, k: int) -> int:
    """Return 1 if a contact slides, rolls or spins, else 0."""
    found = 0
    for s in range(k, behind(it, k)):
        if it.slides[s] != 0:
            found = 1
    return found


@compiled
def lay_out(it: Contacts) -> None:
    """Set the rows of the problem, their rates per unit impulse, factors of these, and scales."""
    problem, m = it.problem, it.equalities
    for a in range(m):
        it.place[a], problem.kinds[a], it.owner[a], problem.mu[a] = it.equal[a], EQUALITY, -1, 0.0
        problem.between[a] = 0
    normal = m
    for k in range(it.contacts):
        n = it.tangents[k] if it.slides[k] == 0 and it.static[k] > 0.0 else 0
        if it.presser[k] < 0:
            normal, it.place[m], problem.kinds[m] = m, it.at[k], NORMAL
            it.owner[m] = k if slides_in(it, k) != 0 else -1
            problem.mu[m], problem.between[m] = it.static[k], 0
            m += 1
        before = m - 1 - normal
        for j in range(n):
            it.place[m], it.owner[m], problem.mu[m] = it.at[k] + 1 + j, -1, it.static[k]
            problem.kinds[m], problem.between[m] = LINE if n == 1 else FIRST + j, before
            m += 1
    problem.count = m
    n = factor(it.A, it.rows, it.factors, DEPENDENT, it.left, it.order)
    it.directions, it.sole = n, 1 if is_regular(it, n) != 0 and unique(it, n) != 0 else 0
    lay_out_blocks(it, n)
    for a in range(m):
        row = it.place[a] * it.rows
        for b in range(m):
            it.chosen[a * m + b] = it.A[row + it.place[b]]
            if it.owner[b] >= 0:
                it.chosen[a * m + b] += along_ray(it, b, it.A[row:], 1)
        for k in range(n):
            it.H[a * n + k] = it.factors[row + k]
            it.C[a * n + k] = it.factors[row + k]
            if it.owner[a] >= 0:
                it.C[a * n + k] += along_ray(it, a, it.factors[k:], it.rows)
        for k in range(3):
            problem.matrix[a, k] = 0.0
            if a + k < m:
                problem.matrix[a, k] = it.A[row + it.place[a + k]]
        problem.matrix[a, 0] = abs(problem.matrix[a, 0])
    scale_held(it)
    set_scales(problem)
    for a in range(m):
        it.unit[a] = 1.0


@compiled
def scale_held(it: Contacts) -> None:
    """Compare a given normal force that moves nothing by the rate of its tangent."""
    a, problem = it.equalities, it.problem
    for k in range(it.contacts):
        if it.presser[k] >= 0:
            continue
        if is_held(it, k) != 0:
            problem.matrix[a, 0] = it.A[(it.at[k] + 1) * (it.rows + 1)]
        a += 1
        while a < problem.count and problem.kinds[a] > NORMAL:
            a += 1


@compiled
def equilibrate(it: Contacts) -> None:
    """Give friction that a given force bounds, as of joints that turn, rates like those of the other rows.

    Of rates that are compared, 1 rad/s is not 1 m/s. Its rows have d r and x/d. Powers of two leave all digits.
    """
    a, problem, m, n, unit = it.equalities, it.problem, it.problem.count, it.directions, it.unit
    for k in range(it.contacts):
        if it.presser[k] < 0:
            if is_held(it, k) != 0:
                unit[a] = 0.0
            a += 1
            while a < m and problem.kinds[a] > NORMAL:
                unit[a] = unit[a - 1]
                a += 1
    usual = 0.0
    for i in range(m):
        usual = greater(usual, unit[i] * problem.scale[i])
    for i in range(m):
        if unit[i] == 0.0:
            unit[i] = unit[i - 1] if problem.kinds[i] > NORMAL else unit_of(problem.scale[i], usual)
    for i in range(m):
        for b in range(m):
            it.chosen[i * m + b] *= unit[i] * unit[b]
        for k in range(n):
            it.H[i * n + k] *= unit[i]
            it.C[i * n + k] *= unit[i]
        for k in range(3):
            if i + k < m:
                problem.matrix[i, k] *= unit[i] * unit[i + k]
        problem.scale[i] *= unit[i] * unit[i]


@compiled
def unit_of(scale: float, usual: float) -> float:
    """Return the power of two whose square brings a rate per unit impulse within a factor of two of the usual one."""
    result = 1.0
    if scale > 0.0 and usual > 0.0 and math.isfinite(scale / usual) and math.isfinite(usual / scale):
        while scale * result * result > 2.0 * usual:
            result /= 2.0
        while 2.0 * scale * result * result < usual:
            result *= 2.0
    return result


@compiled
def is_regular(it: Contacts, n: int) -> int:
    """Return 1 if no row of the problem nearly depends on others, else 0; A has rank n.

    The normal row of what resists rolling or spinning moves nothing, and is no row of the problem.
    """
    for a in range(it.problem.count):
        row = it.place[a]
        if n < it.problem.count or not it.left[row] > SMALL * it.A[row * it.rows + row]:
            return 0
    return 1


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
def answer(it: Contacts, enough: float) -> float:
    """Set x to the solution of r = A x + b from zero; return its residual, which is sought down to ``enough``.

    The only solution may be found in any way. If A is regular, the polish finds the solution from a rough one.
    Otherwise it keeps what that has of forces without effect, which are to be those of equal compliance: it begins
    from a close one.
    """
    problem, size = it.problem, 0.0
    for a in range(problem.count):
        size = greater(size, greater(abs(problem.b[a]), problem.scale[a] * abs(problem.low[a])))
    problem.reference = size
    if it.sole != 0:
        least = direct(it)
        if least <= FINE:
            return refined(it)
    least = polished(it, ROUGH if it.directions == it.rows else CLOSE)
    if least <= enough:
        return least
    return polished(it, GOAL)


@compiled
def direct(it: Contacts) -> float:
    """Set x to what Newton's method on the laws finds from zero; return its residual, which may be any."""
    problem = it.problem
    press_at_least(problem, problem.x)
    least, turn = violated(it), 0
    while least > FINE and turn < STRAIGHT and step(it) != 0:
        for a in range(problem.count):
            problem.x[a] += it.left[a]
        least, turn = violated(it), turn + 1
    return least


@compiled
def polished(it: Contacts, goal: float) -> float:
    """Set x to a solution to within ``goal`` from zero, polished; return its residual."""
    solve(it.problem, it.newton, goal)
    return refined(it)


@compiled
def refined(it: Contacts) -> float:
    """Polish x as far as its residual falls; return that."""
    problem = it.problem
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
        it.forces[it.place[a]] += it.unit[a] * x[a]
        k = it.owner[a]
        for s in range(k, behind(it, k) if k >= 0 else k):
            if it.slides[s] != 0:
                for j in range(it.tangents[s]):
                    it.forces[it.at[s] + 1 + j] += ray(it, s, j) * it.unit[a] * x[a]
    name_pressers(it)
    rated(it)


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
        if it.presser[k] >= 0:
            continue
        problem.low[a] = it.least[k]
        a += 1
        while a < problem.count and problem.kinds[a] > NORMAL:
            a += 1
    it.residual = answer(it, FINE)
    take(it)
    return 0
