"""The contacts of a run at one moment, in compiled code: which are closed, approach, or take part in a problem."""

from __future__ import annotations

from ...native.instructions import Integers, Reals, Truth, compiled, greater, inlined, root
from ..cones.block_rows import dot
from ..phase.laws import CLOSED
from .event_run import GAP_CLOSED, NORMAL_ZERO, EventRun
from .limits import STILL


@compiled
def largest(x: Reals, n: int) -> float:
    """Return the greatest of n numbers in magnitude; 0 if there are none."""
    result = 0.0
    for i in range(n):
        result = greater(result, abs(x[i]))
    return result


@compiled
def look(it: EventRun) -> None:
    """Evaluate the contacts at the present state, and find the closed ones."""
    it.looked(it.t, it.y, it.looking, it.seen)
    for k in range(it.contacts if it.loads > 0 else 0):
        if it.loaded[k] != 0:
            it.given[k] = it.load[k]
    for k in range(it.contacts):
        it.adhering[k] = 0
    find_closed(it)


@compiled
def find_closed(it: EventRun) -> None:
    """Find the contacts with zero gap and the foot on their side, or at its end and not leaving it.

    At the end of a side, a round feature touches the side or the corner, never both. A feature that came around that
    end is behind the side and does not touch it.
    """
    speed = largest(it.y[it.n_q :], it.n)
    it.near, it.still = CLOSED * (1.0 + largest(it.y, it.n_q)), STILL * (1.0 + speed)
    deep = it.near * (1.0 + speed)  # event times are located to round-off, gaps are not
    it.needed = 0
    for k in range(it.contacts):
        touches = -deep <= it.gap[k] <= it.near and it.reach[k] >= -it.near
        if touches and it.reach[k] <= it.near and (it.left[k] != 0 or it.away[k] < -it.still):
            touches = False
        it.closed[k] = 1 if touches else 0
    for k in range(it.contacts):
        if it.closed[k] != 0 and it.side[k] >= 0 and it.closed[it.side[k]] != 0:
            it.closed[k] = 0
        if it.held[k] != 0:  # it takes no part in impacts and rests
            it.closed[k] = 0
        if it.closed[k] != 0 or it.held[k] != 0:
            it.needed += 1 + it.tangents[k]
    if it.adhesive > 0:
        adhere(it)


@compiled
def adhere(it: EventRun) -> None:
    """Let the adhesion A of closed contacts that neither approach nor leave pull: λ = N + A is the force of a decision.

    The accelerations without contact forces then have -A along each normal.
    """
    for k in range(it.contacts):
        holds = it.closed[k] != 0 and it.parted[k] == 0 and it.adhesion[k] > 0.0
        if abs(normal_speed(it, k)) > it.still:
            holds = False
        change = (1 if holds else 0) - it.adhering[k]
        if change != 0:
            pull(it, k, change)


@compiled
def pull(it: EventRun, k: int, change: int) -> None:
    """Add the adhesion of a contact to the accelerations, or take it away, by a change of 1 or -1."""
    X, force = row_of(it, it.X, it.first[k]), -change * it.adhesion[k]
    for i in range(it.n):
        it.free[i] += force * X[i]
    for r in range(it.rows):
        it.c[r] += force * dot(row_of(it, it.W, r), X, it.n)
    it.adhering[k] += change


@inlined
def normal_speed(it: EventRun, k: int) -> float:
    """Return the speed at which a contact opens."""
    return it.rate[it.first[k]]


@compiled
def size_of(x: Reals, n: int) -> float:
    """Return the length of a vector."""
    return root(dot(x, x, n))


@compiled
def slip_speed(it: EventRun, k: int) -> float:
    """Return the slip speed of a contact [m/s]."""
    return size_of(it.rate[it.first[k] + 1 :], it.tangents[k])


@inlined
def is_smooth(it: EventRun, k: int) -> Truth:
    """Return True if the coefficients of friction are zero in this run."""
    return it.coefficients[4 * k] == 0.0 and it.coefficients[4 * k + 1] == 0.0


@compiled
def choose(it: EventRun) -> None:
    """List the closed contacts that do not leave, each followed by what resists its rolling and spinning."""
    it.count = 0
    for k in range(it.contacts):
        if it.closed[k] != 0 and normal_speed(it, k) <= it.still:
            append(it, k)


@compiled
def append(it: EventRun, k: int) -> None:
    """Append a contact, and what resists its rolling and spinning, to the list."""
    it.chosen[it.count], r = k, k + 1
    it.count += 1
    while r < it.contacts and it.presser[r] == k:
        it.chosen[it.count] = r
        it.count, r = it.count + 1, r + 1


@compiled
def choose_all(it: EventRun) -> None:
    """List the closed contacts that do not leave, then those whose normal force the state gives."""
    choose(it)
    for k in range(it.contacts):
        if it.held[k] != 0 and it.presser[k] < 0 and (it.compliant[k] == 0 or presses(it, k) != 0):
            append(it, k)


@compiled
def presses(it: EventRun, k: int) -> int:
    """Return 1 if a compliant contact presses: it is deep and its law does not pull, or it begins to be deep.

    As an event of its own the mode has changed, whatever the round-off of depth and force says.
    """
    if it.reason[k] == GAP_CLOSED or it.reason[k] == NORMAL_ZERO:
        return 1 if it.reason[k] == GAP_CLOSED else 0
    v = normal_speed(it, k)
    if it.gap[k] < -it.near:
        return 1 if it.given[k] > 0.0 else 0
    begins = v < -it.still or (v <= it.still and it.c[it.first[k]] < 0.0)
    return 1 if it.gap[k] <= it.near and begins else 0


@compiled
def approaches(it: EventRun) -> int:
    """Return 1 if a closed contact approaches, else 0."""
    for k in range(it.contacts):
        if it.closed[k] != 0 and normal_speed(it, k) < -it.still:
            return 1
    return 0


@compiled
def joined(it: EventRun) -> int:
    """Return 1 if a contact approaches beside those that were closed at this moment before, else 0.

    A correction of the state closed it. Each 1 adds a contact to those of the moment, so their number is the limit of
    such impacts.
    """
    if approaches(it) == 0:
        return 0
    new = 0
    for k in range(it.contacts):
        if it.met_at != it.t:
            it.met[k] = 0
        if it.closed[k] != 0 and it.met[k] == 0:
            it.met[k], new = 1, 1
    it.met_at = it.t
    return new


@compiled
def response(it: EventRun, r: int, s: int) -> float:
    """Return W_r M⁻¹ W_sᵀ, the change of the rate of row r per unit of impulse of row s."""
    W, X = row_of(it, it.W, r), row_of(it, it.X, s)
    if it.blocks == 1:
        return dot(W, X, it.n)
    total = 0.0
    for i in range(2):
        b, c = it.beside[2 * it.owner[r] + i], 2 * it.owner[s]
        if (b == it.beside[c] or b == it.beside[c + 1]) and (i == 0 or b != it.beside[2 * it.owner[r]]):
            first = it.starts[b]
            total += dot(W[first:], X[first:], it.starts[b + 1] - first)
    return total


@compiled
def add_response(it: EventRun, x: float, r: int, v: Reals) -> None:
    """Add M⁻¹ W_rᵀ x, the change of the speeds by an impulse on row r, to v."""
    X, k = row_of(it, it.X, r), 2 * it.owner[r]
    for i in range(2):
        b = it.beside[k + i]
        if i == 0 or b != it.beside[k]:
            for p in range(it.starts[b], it.starts[b + 1]):
                v[p] += x * X[p]


@compiled
def add_responses(it: EventRun, x: Reals, v: Reals) -> None:
    """Add M⁻¹ Wᵀ x, the change of the speeds by impulses on all rows, to v."""
    for r in range(it.rows):
        if x[r] != 0.0:
            add_response(it, x[r], r, v)


@compiled
def set_response(it: EventRun, x: Reals) -> None:
    """Set ``v`` to M⁻¹ Wᵀ x."""
    for i in range(it.n):
        it.v[i] = 0.0
    add_responses(it, x, it.v)


@compiled
def acceleration_of(it: EventRun, r: int) -> float:
    """Return the derivative of the rate of row r; ``v`` is the response to the forces."""
    return it.c[r] + dot(row_of(it, it.W, r), it.v, it.n)


@compiled
def copy(x: Reals, to: Reals, n: int) -> None:
    """Copy n numbers."""
    for i in range(n):
        to[i] = x[i]


@compiled
def copy_wholes(x: Integers, to: Integers, n: int) -> None:
    """Copy n integers."""
    for i in range(n):
        to[i] = x[i]


@compiled
def row_of(it: EventRun, M: Reals, r: int) -> Reals:
    """Return a row of W or of X."""
    return M[r * it.n :]
