"""The end of a sequence of bounces, in compiled code: the sum of their geometric series once they are too low.

v is the speed after the last bounce, a the acceleration of the flight back, with the forces of the other contacts, and
e the ratio of the speeds after and before a bounce. All remaining bounces take the time

    2 v / a · (1 + e + e² + ...) = 2 v / (a (1 - e))

and rise at most v²/(2a) above the surface. For contacts that alternate (a rocking block), e is the measured ratio of a
cycle. The sum is used if the height is below 1e-9, or 1e-11 among others, and the measured a is constant to 1e-12 over
the remaining time. It is always used at heights below 1e-13, where a change of a has an effect of that size only: also
for contacts whose impacts follow each other in no order, and for those that an impact of others lifts.
"""

from __future__ import annotations

from ....native.instructions import EPS, compiled, greater
from .. import event_run, limits
from ..event_run import EventRun
from ..moment import copy, copy_wholes, largest, normal_speed
from .rests import log_rest

ALONE, AMONG = 1e-9, 1e-11
"""Height below which the bounces of a contact end, relative to 1 m or the greatest coordinate, and where the forces of
others, which slip meanwhile, act on them."""
LOWEST = 1e-12
"""Height below which bounces end where events crowd, or others end, relative to 1 m or the greatest coordinate."""


@compiled
def alike(it: EventRun, a: int, b: int) -> int:
    """Return 1 if two impacts were of the same contacts, else 0."""
    for k in range(it.contacts):
        if it.bounced[a * it.contacts + k] != it.bounced[b * it.contacts + k]:
            return 0
    return 1


@compiled
def limited(it: EventRun) -> int:
    """Set ``taking`` and ``rest_left``, the contacts and the duration of bounces too low to follow; return 1, or 0.

    ``flight`` is known of contacts that fly.
    """
    if it.hit == 0 or it.bounces == 0 or it.bounce_time[it.bounces - 1] != it.t:
        return 0
    if of_one_contact(it) != 0 or of_a_cycle(it) != 0:
        take_flights(it, LOWEST)
        return 1
    clear(it)
    return 1 if take_flights(it, LOWEST if it.crowd >= limits.ENDLESS // 4 else limits.SUMMED) > 0 else 0


@compiled
def unseen(it: EventRun) -> int:
    """Set ``taking`` for flights lower than the round-off of their gap; return their number."""
    clear(it)
    return take_flights(it, limits.LOW)


@compiled
def clear(it: EventRun) -> None:
    """Take no contact."""
    it.rest_left = 0.0
    for k in range(it.contacts):
        it.taking[k] = 0


@compiled
def take_flights(it: EventRun, height: float) -> int:
    """Let contacts that fly lower than this height come to rest, too; return their number.

    One that rebounds as fast as it comes flies on while its flights can be told from round-off.
    """
    found, low, last = 0, height * (1.0 + largest(it.y, it.n_q)), it.bounces - 1
    for k in range(it.contacts):
        v, e = normal_speed(it, k), it.coefficients[4 * k + 2]
        top = greater(it.gap[k], 0.0) + v * it.flight[k] / 2.0
        if it.taking[k] != 0 or it.compliant[k] != 0 or it.flight[k] == 0.0 or top > low:
            continue
        if last >= 0 and it.bounced[last * it.contacts + k] != 0:
            e = greater(e, v / it.bounce_speed[last])
        if e < 1.0:
            it.rest_left = greater(it.rest_left, 2.0 * it.flight[k] / (1.0 - e))
        if e < 1.0 or height == limits.LOW:
            it.taking[k], found = 1, found + 1
    return found


@compiled
def of_one_contact(it: EventRun) -> int:
    """Return 1 if one contact bounces, at an acceleration that stays, and too low to follow it, else 0."""
    b, count, k, size = it.bounces - 1, 0, 0, 1.0 + largest(it.y, it.n_q)
    for i in range(it.contacts):
        it.taking[i] = it.bounced[b * it.contacts + i]
        if it.taking[i] != 0:
            k, count = i, count + 1
    if count != 1:
        return 0
    v = normal_speed(it, k)
    e = v / it.bounce_speed[b]  # the restitution by Newton's law; friction changes it by Poisson's law
    if not (it.flight[k] > 0.0 and e < 1.0) or b == 0 or alike(it, b, b - 1) == 0:
        return 0
    a = v / it.flight[k]
    it.rest_left = 2.0 * v / (a * (1.0 - e))
    alone = abs(a + it.c[it.first[k]]) <= limits.SMALL * a
    if v * it.flight[k] > 2.0 * (ALONE if alone else AMONG) * size:
        return 0
    # the change of a over the remaining time is estimated from the last flight: a = 2 v_before / (t - t_before)
    flight = it.t - it.bounce_time[b - 1]
    drift = abs(2.0 * it.bounce_speed[b] / flight - a) / a
    rounded = 8.0 * EPS * abs(it.t) / flight * it.rest_left
    return 1 if drift * it.rest_left <= 1e-12 * greater(1.0, abs(it.t)) + rounded else 0


@compiled
def of_a_cycle(it: EventRun) -> int:
    """Return 1 if impacts come in cycles that shrink by a constant factor and are too low to follow, else 0."""
    last = it.bounces - 1
    for period in range(1, limits.PERIOD + 1):
        if it.bounces < 3 * period + 1:
            return 0
        same = 1
        for i in range(2 * period):
            if alike(it, last - i, last - i - period) == 0:
                same = 0
        first = it.bounce_time[last - period] - it.bounce_time[last - 2 * period]
        second = it.t - it.bounce_time[last - period]
        if same == 0 or not 0.0 < second < first:
            continue
        ratio, speeds = second / first, it.bounce_speed[last] / it.bounce_speed[last - period]
        if not (ratio < 1.0 and speeds < 1.0):
            continue
        if it.bounce_speed[last] * second > AMONG * (1.0 + largest(it.y, it.n_q)):
            continue
        for k in range(it.contacts):
            it.taking[k] = 0
            for i in range(period):
                if it.bounced[(last - i) * it.contacts + k] != 0:
                    it.taking[k] = 1
        it.rest_left = second * ratio / (1.0 - ratio)
        return 1
    return 0


@compiled
def end_rest(it: EventRun) -> None:
    """End the time that a series of bounces takes."""
    copy_wholes(it.resters, it.taking, it.contacts)
    copy(it.y, it.start, it.n_y)
    log_rest(it, event_run.SERIES)
    for k in range(it.contacts):
        if it.resters[k] != 0:
            it.reason[k] = event_run.BOUNCES_END
    it.stage = event_run.ARRIVE
