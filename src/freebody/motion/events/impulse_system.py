"""Systems of impulses on rows of contacts, in compiled code: the least motion that changes speeds by given amounts."""

from __future__ import annotations

from ...native.instructions import compiled, greater
from ..cones.block_rows import dot
from ..cones.contacts import Contacts
from ..cones.elimination import solved
from ..cones.newton import factor
from . import limits
from .event_run import EventRun
from .moment import copy, response, row_of, set_response, slip_speed
from .problem import apart, couple, name_island


@compiled
def add_row(it: EventRun, count: int, r: int, goal: float) -> int:
    """Append a row whose rate is to change by ``goal``; return the number of rows."""
    it.list[count], it.goal[count] = r, goal
    for j in range(limits.RAY):
        it.ray[count, j] = 0.0
    return count + 1


@compiled
def add_ray(it: EventRun, a: int, k: int) -> None:
    """Add the friction of a contact that slips, or the moments of one that rolls or spins, to a normal row's ray."""
    at, speed = it.first[k], slip_speed(it, k)
    behind = at - it.list[a]
    for j in range(it.tangents[k]):
        it.ray[a, behind + j] = -it.coefficients[4 * k] * it.rate[at + 1 + j] / speed


@compiled
def ray_product(it: EventRun, a: int, b: int) -> float:
    """Return the change of the rate of row a of the list per unit of unknown b."""
    r, s = it.list[a], it.list[b]
    total = response(it, r, s)
    for j in range(limits.RAY):
        if it.ray[b, j] != 0.0:
            total += it.ray[b, j] * response(it, r, s + 1 + j)
    return total


@compiled
def impelled(it: EventRun, contacts: Contacts, count: int) -> float:
    """Find impulses on the rows of the list that change their rates by the goals, with the list sorted by islands.

    Set ``whole``; return the greatest difference of a change from its goal.
    """
    apart(it)
    for a in range(count):
        couple(it, it.owner[it.list[a]])
    for a in range(count):
        name_island(it, it.owner[it.list[a]])
        b = a
        while b > 0 and island_of(it, b - 1) > island_of(it, b):
            exchange(it, b)
            b -= 1
    for r in range(it.rows):
        it.whole[r] = 0.0
    first, worst = 0, 0.0
    while first < count:
        size = 1
        while first + size < count and island_of(it, first + size) == island_of(it, first):
            size += 1
        worst = greater(worst, impelled_in(it, contacts, first, size))
        apply(it, first, size)
        first += size
    return worst


@compiled
def island_of(it: EventRun, a: int) -> int:
    """Return the island of a row of the list."""
    return it.island[it.owner[it.list[a]]]


@compiled
def exchange(it: EventRun, a: int) -> None:
    """Exchange a row of the list and the one before it."""
    it.list[a - 1], it.list[a] = it.list[a], it.list[a - 1]
    it.goal[a - 1], it.goal[a] = it.goal[a], it.goal[a - 1]
    for j in range(limits.RAY):
        it.ray[a - 1, j], it.ray[a, j] = it.ray[a, j], it.ray[a - 1, j]


@compiled
def impelled_in(it: EventRun, contacts: Contacts, first: int, count: int) -> float:
    """Find impulses x on rows of one island from a place of the list on: S x = g; return the greatest |S x - g|.

    Dependent ones are those of contacts of equal compliance: x = Q ν with S Q ν = g over independent rows, where Q are
    the columns of A of these.
    """
    return impelled_by(it, contacts, first, count, products(it, contacts, first, count))


@compiled
def products(it: EventRun, contacts: Contacts, first: int, count: int) -> int:
    """Set A and S of rows of the list from a place on, and ``order`` to 1 for independent ones; return their number."""
    A, S = contacts.A, contacts.chosen
    for a in range(count):
        for b in range(count):
            A[a * count + b] = response(it, it.list[first + a], it.list[first + b])
            S[a * count + b] = ray_product(it, first + a, first + b)
    return factor(A, count, contacts.factors, limits.SMALL, contacts.left, contacts.order)


@compiled
def impelled_by(it: EventRun, contacts: Contacts, first: int, count: int, kept: int) -> float:
    """Find impulses as `impelled_in` does, with the `products` of their rows."""
    S = contacts.chosen
    for a in range(count):
        it.x[first + a] = 0.0
    turn, good = 0, 1
    while turn < 2 and good != 0:  # what is left of g is solved for once more
        good = improved(it, contacts, first, count, kept)
        turn += 1
    worst = 0.0
    for a in range(count):
        left = -it.goal[first + a]
        for b in range(count):
            left += S[a * count + b] * it.x[first + b]
        worst = greater(worst, abs(left))
    return worst


@compiled
def improved(it: EventRun, contacts: Contacts, first: int, count: int, kept: int) -> int:
    """Add the solution for what is left of g to x; return 0 if there is none, else 1."""
    A, S, order, square, nu, i = contacts.A, contacts.chosen, contacts.order, contacts.slope, it.nu, 0
    x = it.x[first:]
    for a in range(count):
        if order[a] != 0:
            nu[i], j = it.goal[first + a] - dot(S[a * count :], x, count), 0
            for b in range(count):
                if order[b] != 0:
                    square[i * kept + j] = S[a * count + b]
                    if kept < count:  # A is symmetric
                        square[i * kept + j] = dot(S[a * count :], A[b * count :], count)
                    j += 1
            i += 1
    if solved(square, kept, nu) == 0:
        return 0
    j = 0
    for b in range(count):
        if order[b] != 0:
            if kept == count:
                x[b] += nu[j]
            else:
                for a in range(count):
                    x[a] += A[b * count + a] * nu[j]
            j += 1
    return 1


@compiled
def apply(it: EventRun, first: int, count: int) -> None:
    """Add impulses x along the rays of rows of the list to ``whole``."""
    for a in range(first, first + count):
        it.whole[it.list[a]] += it.x[a]
        for j in range(limits.RAY):
            if it.ray[a, j] != 0.0:
                it.whole[it.list[a] + 1 + j] += it.ray[a, j] * it.x[a]


@compiled
def move_speeds(it: EventRun) -> None:
    """Apply the impulses of all rows to the state, and add their work."""
    n, work = it.n, 0.0
    set_response(it, it.whole)
    for r in range(it.rows):
        if it.whole[r] != 0.0:
            work += it.whole[r] * (it.rate[r] + dot(row_of(it, it.W, r), it.v, n) / 2.0)
    if it.moving != 0:
        work += work_of_drives(it)
    it.impulses += work
    for i in range(n):
        it.y[it.n_q + i] += it.v[i]


@compiled
def work_of_drives(it: EventRun) -> float:
    """Return b·Δu - Λ·w, the work of what imposes its motion, of T = uᵀM u/2 + b·u + T₀ and rates r = W u + w."""
    state, out, result = it.trial, it.step, 0.0
    copy(it.y, state, it.n_y)
    for turn in range(2):
        for i in range(it.n):
            state[it.n_q + i] = it.v[i] if turn == 0 else -it.v[i]
        it.energy(it.t, state, it.energy_c, out)
        result += out[0] / 2.0 if turn == 0 else -out[0] / 2.0
    for i in range(it.n):
        state[it.n_q + i] = 0.0
    it.rates_at(it.t, state, it.looking, it.x)
    return result - dot(it.whole, it.x, it.rows)
