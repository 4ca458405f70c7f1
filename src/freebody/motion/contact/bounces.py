"""The end of bounces: their geometric series, once they are lower than what double precision resolves.

With v the speed after the last bounce, a = -r_N the approach acceleration and e the part of the speed that is kept, all
that is left takes

    2 v / a · (1 + e + e² + ...) = 2 v / (a (1 - e))

at most v²/(2a) above the surface. For contacts that alternate (a rocking block) e is the measured ratio of a cycle. The
sum is taken when the height is below 1e-9 and a is seen to be constant to 1e-12 over what is left, and at 1e-13 in any
case, where what a could change is of that size.
"""

from __future__ import annotations

import numpy as np

from ...dynamics import coordinate_rates
from ...dynamics.state import float_state
from ..ode.dense_output import Array
from .complementarity import SMALL
from .scene import Snapshot
from .state import LOW, ContactRun


def limit(work: ContactRun, t: float, y: Array) -> tuple[Array, float, frozenset[int]] | None:
    """If bounces have become too low to follow: the state without them, their time left, and the contacts.

    The contacts that bounce then have neither gap nor normal speed; what their normal speeds lose is the sum of
    the impulses that are left.
    """
    if not work.bounces or work.bounces[-1].time != t:
        return None
    seen = work.look(t, y)
    last = work.bounces[-1]
    if len(last.contacts) == 1:
        (k,) = last.contacts
        at = work.scene.first[k]
        v = float(seen.rate[at])
        e = v / last.speed  # by Newton the restitution; by Poisson friction changes it
        a = -free_rate(work, seen, y, k)
        if not (v > work.still(y) and a > 0 and e < 1):
            return cycle(work, t, y, seen)
        height, left = v * v / (2 * a), 2 * v / (a * (1 - e))
        if height > 1e-9 * (1 + work.size(y)):
            return cycle(work, t, y, seen)
        earlier = [b for b in work.bounces[:-1] if b.contacts == last.contacts]
        if height > 1e-13 * (1 + work.size(y)):
            if not earlier or earlier[-1] is not work.bounces[-2]:
                return cycle(work, t, y, seen)
            # flight times foretell how far a changes in what is left: v_before (t - t_before) measures it
            flight = t - earlier[-1].time
            drift = abs(2 * last.speed / flight - a) / a
            if drift * left > 1e-12 * max(1.0, abs(t)) + 8 * np.finfo(float).eps * abs(t) / flight * left:
                return cycle(work, t, y, seen)
        return settled(work, t, y, seen, last.contacts), left, last.contacts
    return cycle(work, t, y, seen)


def free_rate(work: ContactRun, seen: Snapshot, y: Array, k: int) -> float:
    """Normal acceleration of a contact in flight, the other closed contacts held as they are."""
    del y
    return float(seen.c[work.scene.first[k]])


def cycle(work: ContactRun, t: float, y: Array, seen: Snapshot) -> tuple[Array, float, frozenset[int]] | None:
    """Impacts that repeat in cycles, each a constant part of the last: their geometric sum."""
    history = work.bounces[-40:]
    for period in range(1, 7):
        if len(history) < 3 * period + 1:
            break
        pattern = [b.contacts for b in history]
        if any(pattern[-1 - i] != pattern[-1 - i - period] for i in range(2 * period)):
            continue
        one, two, three = history[-1], history[-1 - period], history[-1 - 2 * period]
        first, second = two.time - three.time, one.time - two.time
        if not 0 < second < first:
            continue
        ratio, speeds = second / first, one.speed / two.speed
        if not (ratio < 1 and speeds < 1):
            continue
        contacts = frozenset().union(*(b.contacts for b in history[-period:]))
        height = one.speed * second
        if height > 1e-11 * (1 + work.size(y)):
            continue
        return settled(work, t, y, seen, contacts), second * ratio / (1 - ratio), contacts
    return None


def settled(work: ContactRun, t: float, y: Array, seen: Snapshot, contacts: frozenset[int]) -> Array:
    """Normal speeds of the contacts taken away, and their slip, if the last impact of each left none.

    The bounces that are left press with the sum of the weights less the normal momentum that is taken away here: where
    a contact slips, so much less friction acts, -μ d per unit of normal impulse. What sticks stays.
    """
    m = work.scene.rows
    rows: list[int] = []
    columns: list[Array] = []

    def take(i: int, column: Array) -> None:
        rows.append(i)
        columns.append(column)

    identity = np.eye(m)
    for k in sorted(contacts):
        at, n = work.scene.first[k], work.scene.tangents[k]
        last = next((b for b in reversed(work.bounces) if k in b.contacts), None)
        rough = n > 0 and not work.smooth(seen, k)
        if rough and last is not None and last.stuck:
            take(at, identity[at])
            for i in range(at + 1, at + 1 + n):
                take(i, identity[i])
            continue
        column = identity[at].copy()
        v = work.slip(seen, k)
        speed = float(np.linalg.norm(v))
        if rough and speed > work.still(y):
            column[at + 1 : at + 1 + n] = -seen.friction[k] * v / speed
        take(at, column)
    for k in work.closed(t, seen, y):
        at = work.scene.first[k]
        if k not in contacts and abs(seen.rate[at]) <= work.still(y):
            take(at, identity[at])
    F = np.array(columns).T
    impulses = F @ np.linalg.lstsq(seen.A[rows] @ F, -seen.rate[rows], rcond=SMALL)[0]
    after = y.copy()
    after[work.n : work.n + work.model.n_u] += impulses @ seen.responses
    work.impulses += work.gained(t, y, seen, impulses)
    return after


def lifted(work: ContactRun, t: float, y: Array) -> Array:
    """The state with contacts that leave from below zero, as far as they count as closed, at zero.

    From there their return is a zero of the gap; from below, it would be none.
    """
    seen = work.look(t, y)
    low = LOW * (1 + work.size(y))
    closed = work.closed(t, seen, y)
    first = work.scene.first
    if not any(seen.gap[k] < -low and seen.rate[first[k]] > work.still(y) for k in closed):
        return y
    rows = [first[k] for k in closed]
    gaps = np.array([min(seen.gap[k], 0.0) for k in closed])
    step = np.linalg.lstsq(seen.A[np.ix_(rows, rows)], -gaps, rcond=SMALL)[0] @ seen.responses[rows]
    state = float_state(work.model, y[: work.n].tolist(), step.tolist(), t, work.values)
    still = float_state(work.model, y[: work.n].tolist(), None, t, work.values)
    moved = [float(x) for x in coordinate_rates(work.model, state)]
    driven = [float(x) for x in coordinate_rates(work.model, still)]
    result = y.copy()
    result[: work.n] += np.array(moved) - np.array(driven)
    return result
