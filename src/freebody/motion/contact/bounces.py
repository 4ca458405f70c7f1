"""The end of a sequence of bounces: the sum of their geometric series once they are too low to be resolved.

v is the speed after the last bounce, a = -r_N the approach acceleration and e the ratio of the speeds after and before
a bounce. All remaining bounces take the time

    2 v / a · (1 + e + e² + ...) = 2 v / (a (1 - e))

and rise at most v²/(2a) above the surface. For contacts that alternate (a rocking block), e is the measured ratio of a
cycle. The sum is used if the height is below 1e-9 and the measured a is constant to 1e-12 over the remaining time. It
is always used at heights below 1e-13, where a change of a has an effect of that size only.
"""

from __future__ import annotations

import numpy as np

from ...dynamics import coordinate_rates
from ...dynamics.state import float_state
from ..ode.dense_output import Array
from ..phase.scene import Snapshot
from .complementarity import SMALL
from .state import LOW, ContactRun


def limit(work: ContactRun, t: float, y: Array) -> tuple[Array, float, frozenset[int]] | None:
    """Return the state without the remaining bounces, their duration and their contacts if they are too low to follow.

    The bouncing contacts then have neither gap nor normal speed. The impulses that cancel their normal speeds equal
    the sum of the impulses of the remaining bounces. Return None if the bounces are still followed.
    """
    if not work.bounces or work.bounces[-1].time != t:
        return None
    seen = work.look(t, y)
    last = work.bounces[-1]
    if len(last.contacts) == 1:
        (k,) = last.contacts
        at = work.scene.first[k]
        v = float(seen.rate[at])
        e = v / last.speed  # the restitution by Newton's law; friction changes it by Poisson's law
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
            # the change of a over the remaining time is estimated from the last flight: a = 2 v_before / (t - t_before)
            flight = t - earlier[-1].time
            drift = abs(2 * last.speed / flight - a) / a
            if drift * left > 1e-12 * max(1.0, abs(t)) + 8 * np.finfo(float).eps * abs(t) / flight * left:
                return cycle(work, t, y, seen)
        return settled(work, t, y, seen, last.contacts), left, last.contacts
    return cycle(work, t, y, seen)


def free_rate(work: ContactRun, seen: Snapshot, y: Array, k: int) -> float:
    """Return the normal acceleration of a contact in flight, with the other closed contacts held in their modes."""
    del y
    return float(seen.c[work.scene.first[k]])


def cycle(work: ContactRun, t: float, y: Array, seen: Snapshot) -> tuple[Array, float, frozenset[int]] | None:
    """Return what :func:`limit` returns for impacts in cycles that shrink by a constant factor: a geometric sum."""
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
    """Return the state without the normal speeds of the contacts, and without slip where the last impact left none.

    The remaining bounces press with the sum of the weights less the normal momentum removed here. On a slipping contact
    the friction is smaller accordingly, by -μ d per unit of normal impulse. Sticking contacts keep sticking.
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
    impulses = (
        F @ np.linalg.lstsq(seen.matrix[rows] @ (seen.responses.T @ F), -seen.rate[rows], rcond=SMALL)[0]
    )
    after = y.copy()
    after[work.n : work.n + work.n_u] += impulses @ seen.responses
    work.impulses += work.gained(t, y, seen, impulses)
    return after


def lifted(work: ContactRun, t: float, y: Array) -> Array:
    """Return the state with contacts that open from a slightly negative gap (closed within tolerance) at gap zero.

    Their return is then a zero crossing of the gap; from a negative gap it would not be.
    """
    seen = work.look(t, y)
    low = LOW * (1 + work.size(y))
    closed = work.closed(t, seen, y)
    first = work.scene.first
    if not any(seen.gap[k] < -low and seen.rate[first[k]] > work.still(y) for k in closed):
        return y
    # contacts that leave from above do not hold the others down: four corners of a face fit three conditions
    closed = [k for k in closed if seen.gap[k] <= low or seen.rate[first[k]] <= work.still(y)]
    rows = [first[k] for k in closed]
    gaps = np.array([min(seen.gap[k], 0.0) for k in closed])
    step = np.linalg.lstsq(seen.between(rows), -gaps, rcond=SMALL)[0] @ seen.responses[rows]
    state = float_state(work.model, y[: work.n].tolist(), step.tolist(), t, work.values)
    still = float_state(work.model, y[: work.n].tolist(), None, t, work.values)
    moved = [float(x) for x in coordinate_rates(work.model, state)]
    driven = [float(x) for x in coordinate_rates(work.model, still)]
    result = y.copy()
    result[: work.n] += np.array(moved) - np.array(driven)
    return result
