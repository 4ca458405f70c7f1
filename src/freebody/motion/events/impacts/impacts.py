"""Impacts at contacts, in compiled code.

An impact is a contact problem of impulses (`cones.collision`):

    v⁺ = A Λ + v⁻,     A = W M⁻¹ Wᵀ

    Newton     0 <= Λ_N  ⟂  v_N⁺ + e v_N⁻ >= 0          -Λ_T in μ Λ_N Sgn(v_T⁺)
    Poisson    compression: the same with e = 0, impulse Λ_C;
               expansion:   0 <= Λ_E - e Λ_C  ⟂  v_N⁺ >= 0,  -Λ_TE in μ Λ_NE Sgn(v_T⁺)

Either all closed contacts take part at once, including contacts at rest ("simultaneous"), or the contacts collide one
after another, always the fastest approaching contact first ("sequential"). These are two different assumptions; the
rigid-body model does not decide between them.

Newton's law with friction can raise the kinetic energy if the slip reverses (Kane), Poisson's with several contacts
(Glocker), and a wedged body has no rebound at all. The restitution of that impact is then halved until impulses exist
and the energy falls, at last to zero: with e = 0 and no moving surface, ΔT = -Σ μ Λ_N |v_T⁺| - Λ A Λ/2 <= 0.

Sources: J. J. Moreau (1988); C. Glocker, F. Pfeiffer (1996), chapter 8; T. R. Kane, Stanford Mechanics Alumni Club
Newsletter (1984); C. Glocker, Energetic consistency conditions for standard impacts, Multibody System Dynamics (2013).
"""

from __future__ import annotations

from ....native.instructions import compiled, greater, lesser, run_by
from ...cones.contacts import ACCEPTED, Contacts
from .. import event_run, limits
from ..event_run import EventRun
from ..impulse_system import move_speeds
from ..log import begin, end, mark, note, note_all
from ..moment import (
    choose,
    copy,
    largest,
    look,
    normal_speed,
    slip_speed,
)
from ..problem import gather, split, take_all, take_island
from ..shares import impulses_decide
from .loaded_impacts import append_loaded, collided_under_loads


@compiled
def strike(it: EventRun, contacts: Contacts) -> int:
    """Find the impulses of the approaching contacts; set ``hit``, 1 if there are any. Return a reason to stop, or 0.

    ``open`` is 1 if others would move the machine otherwise.
    """
    choose(it)
    it.open = 0
    for r in range(it.rows):
        it.whole[r] = 0.0
    it.hit = is_hit(it)
    if it.hit == 0:
        return 0
    if it.loads > 0 and it.sequential != 0:
        return event_run.LOADED_IMPACT
    if it.loads > 0:
        append_loaded(it)
    contacts.still = it.still
    if it.sequential != 0:
        gather(it, contacts, 1, 1.0)
        status = one_by_one(it, contacts)
        take_impulses(it, contacts)
        return status
    contacts.poisson = law_of_impact(it)
    if contacts.poisson < 0:
        return event_run.MIXED
    split(it)
    first, least, most, residual, status = 0, 1.0, 0.0, 0.0, 0
    while first < it.concerned_count and status == 0:
        first = take_island(it, first)
        if is_hit(it) != 0:
            status = together(it, contacts)
            least, most = lesser(least, contacts.part), greater(most, contacts.part)
            residual = greater(residual, contacts.residual)
    if status != 0:
        return status
    take_all(it)
    contacts.part, contacts.residual = least, residual
    return together(it, contacts) if least < most else 0  # an impact has one restitution


@compiled
def law_of_impact(it: EventRun) -> int:
    """Return 1 if the chosen contacts that approach rebound by Poisson's law, 0 by Newton's, and -1 if some by each."""
    newton, poisson = 0, 0
    for i in range(it.count):
        k = it.chosen[i]
        # both laws are the same one for a contact that does not rebound
        if normal_speed(it, k) < -it.still and it.coefficients[4 * k + 2] > 0.0:
            newton, poisson = newton + 1 - it.poisson[k], poisson + it.poisson[k]
    return -1 if newton > 0 and poisson > 0 else (1 if poisson > 0 else 0)


@compiled
def is_hit(it: EventRun) -> int:
    """Return 1 if one of the chosen contacts approaches, else 0."""
    for i in range(it.count):
        if normal_speed(it, it.chosen[i]) < -it.still:
            return 1
    return 0


@compiled
def take_impulses(it: EventRun, contacts: Contacts) -> None:
    """Take the impulses of the problem."""
    for a in range(contacts.rows):
        it.whole[it.list[a]] = contacts.forces[a]


@compiled
def rub(it: EventRun, contacts: Contacts) -> int:
    """Let the friction of joints under the load ``blown`` of a blow act. Return a reason to stop, or 0."""
    look(it)
    it.count, contacts.poisson, contacts.still = 0, 0, it.still
    append_loaded(it)
    gather(it, contacts, 1, 1.0)
    for i in range(it.count):
        contacts.restitution[i] = 0.0
    status = collided_under_loads(it, contacts)
    for r in range(it.rows):
        it.whole[r] = 0.0
    take_impulses(it, contacts)
    move_speeds(it)
    return status


@compiled
def collide(it: EventRun, contacts: Contacts) -> int:
    """Let the approaching contacts collide. Return a reason to stop, or 0."""
    status = strike(it, contacts)
    if status != 0 or it.hit == 0:
        return status
    copy(it.y, it.start, it.n_y)
    copy(it.rate, it.speeds, it.rows)
    fastest = 0.0
    for k in range(it.contacts):
        it.taking[k] = 0
    for i in range(it.count):
        if normal_speed(it, it.chosen[i]) < -it.still:
            it.taking[it.chosen[i]] = 1
            fastest = greater(fastest, -normal_speed(it, it.chosen[i]))
    before = it.still
    move_speeds(it)
    copy(it.whole, it.force, it.rows)
    look(it)
    it.worst = greater(it.worst, contacts.residual)
    log_impact(it, contacts, before)
    remember(it, fastest, before)
    return 0


@compiled
def together(it: EventRun, contacts: Contacts) -> int:
    """Let the chosen contacts collide at once. Return a reason to stop, or 0."""
    gather(it, contacts, 1, 1.0)
    for i in range(it.count):
        contacts.restitution[i] = it.coefficients[4 * it.chosen[i] + 2]
    status = 0
    if it.loads > 0:
        status = collided_under_loads(it, contacts)
    else:
        run_by(it.colliding, contacts)
        status = 0 if contacts.residual <= ACCEPTED else event_run.NO_IMPULSES
    take_impulses(it, contacts)
    if status == 0 and contacts.directions < contacts.rows and impulses_decide(it, contacts) != 0:
        it.open = 1
    return status


@compiled
def one_by_one(it: EventRun, contacts: Contacts) -> int:
    """Let the chosen contacts collide one after another, always the fastest first."""
    m, part, residual = contacts.rows, 1.0, 0.0
    v, total = it.x, it.nu
    copy(contacts.given, v, m)
    for a in range(m):
        total[a] = 0.0
    size = greater(largest(v, m), it.still)
    for _ in range(limits.PASSES):
        fastest, place, at, first = 0.0, -1, 0, 0
        for i in range(it.count):
            if it.presser[it.chosen[i]] < 0 and (place < 0 or v[at] < fastest):
                fastest, place, first = v[at], i, at
            at += 1 + it.tangents[it.chosen[i]]
        if fastest >= -greater(it.still, 1e-13 * size):
            copy(total, contacts.forces, m)
            copy(v, contacts.after, m)
            contacts.part, contacts.residual, contacts.directions = part, residual, m
            contacts.contacts = it.count
            return 0
        contacts.contacts, contacts.poisson = (
            take_one(it, contacts, place, first),
            it.poisson[it.chosen[place]],
        )
        copy(v, contacts.given, m)
        run_by(it.colliding, contacts)
        residual, part = greater(residual, contacts.residual), lesser(part, contacts.part)
        if not residual <= ACCEPTED:
            return event_run.NO_IMPULSES
        for a in range(m):
            total[a] += contacts.forces[a]
        copy(contacts.after, v, m)
    return event_run.SEQUENCE


@compiled
def take_one(it: EventRun, contacts: Contacts, place: int, at: int) -> int:
    """Write a contact, whose rows begin at ``at``, and what resists its rolling and spinning as those that collide.

    Return their number.
    """
    count, k = 0, it.chosen[place]
    while place + count < it.count and (count == 0 or it.presser[it.chosen[place + count]] == k):
        r = it.chosen[place + count]
        contacts.at[count], contacts.tangents[count] = at, it.tangents[r]
        contacts.presser[count], contacts.held[count] = -1 if count == 0 else 0, it.held[r]
        contacts.friction[count] = contacts.static[count] = it.coefficients[4 * r]
        contacts.restitution[count] = it.coefficients[4 * r + 2]
        at += 1 + it.tangents[r]
        count += 1
    return count


@compiled
def log_impact(it: EventRun, contacts: Contacts, still: float) -> None:
    """Log an impact: states and speeds before and after it, and its impulses."""
    at = begin(it, event_run.IMPACT)
    mark(it, it.open)
    mark(it, it.count)
    note(it, it.t)
    note(it, contacts.part)
    note(it, contacts.residual)
    note(it, still)
    note_all(it, it.start, it.n_y)
    note_all(it, it.y, it.n_y)
    for i in range(it.count):
        mark(it, it.chosen[i])
        note(it, it.speeds[it.first[it.chosen[i]]])
        note(it, it.rate[it.first[it.chosen[i]]])
        for j in range(1 + it.tangents[it.chosen[i]]):
            note(it, it.force[it.first[it.chosen[i]] + j])
    end(it, at)


@compiled
def remember(it: EventRun, fastest: float, still: float) -> None:
    """Keep the impact of the contacts ``taking`` in mind, one of a possible series of bounces."""
    if it.bounces == limits.BOUNCES:
        for i in range(limits.BOUNCES - 1):
            it.bounce_time[i], it.bounce_speed[i] = it.bounce_time[i + 1], it.bounce_speed[i + 1]
            it.bounce_stuck[i] = it.bounce_stuck[i + 1]
        for i in range((limits.BOUNCES - 1) * it.contacts):
            it.bounced[i] = it.bounced[i + it.contacts]
        it.bounces -= 1
    b, stuck = it.bounces, 1
    for k in range(it.contacts):
        it.bounced[b * it.contacts + k] = it.taking[k]
        if it.taking[k] != 0 and slip_speed(it, k) > still:
            stuck = 0
    it.bounce_time[b], it.bounce_speed[b], it.bounce_stuck[b] = it.t, fastest, stuck
    it.bounces += 1
