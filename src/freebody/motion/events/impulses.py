"""Impulses at contacts in compiled code: impacts, and the least motion that takes speeds or gaps away.

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

from ...native.instructions import Reals, compiled, greater, lesser, run_by
from ..cones.contacts import ACCEPTED, Contacts
from ..phase.contact_outputs import evaluated
from ..phase.phase_record import PhaseData
from . import event_run
from .event_run import EventRun
from .impulse_system import add_ray, add_row, impelled
from .loaded_impacts import append_loaded, collided_under_loads
from .log import begin, end, mark, note, note_all
from .moment import (
    choose,
    copy,
    is_smooth,
    largest,
    look,
    normal_speed,
    presses,
    product_of,
    row_of,
    slip_speed,
)
from .shares import impulses_decide

# -- the problem of the chosen contacts ------------------------------------------------------------------


@compiled
def gather(it: EventRun, contacts: Contacts, impact: int, time: float) -> None:
    """Write the problem of the chosen contacts: of their speeds in an ``impact`` (1), else of accelerations.

    Given forces, or bounds of friction, act for a ``time``; 1 for accelerations.
    """
    m = 0
    contacts.contacts, contacts.equalities = it.count, 0
    for i in range(it.count):
        k = it.chosen[i]
        contacts.at[i], contacts.tangents[i] = m, it.tangents[k]
        speed = slip_speed(it, k)
        contacts.friction[i] = it.coefficients[4 * k if speed > it.still else 4 * k + 3]
        contacts.static[i] = it.coefficients[4 * k + 1]
        contacts.least[i], contacts.held[i], contacts.slides[i] = time * it.given[k], it.held[k], 0
        contacts.presser[i], presser = -1, it.presser[k]
        if presser >= 0 and it.held[presser] != 0:
            contacts.least[i] = time * it.given[presser]
        elif presser >= 0:
            contacts.presser[i] = place_of(it, i, presser)
        if impact != 0:
            contacts.static[i] = contacts.friction[i]
        elif speed > it.still:
            contacts.slides[i] = 1
            for j in range(it.tangents[k]):
                contacts.way[2 * i + j] = it.rate[it.first[k] + 1 + j] / speed
        for j in range(1 + it.tangents[k]):
            it.list[m] = it.first[k] + j
            m += 1
    contacts.rows = m
    for a in range(m):
        r = it.list[a]
        contacts.given[a] = it.rate[r] if impact != 0 else it.c[r]
        for b in range(m):
            contacts.A[a * m + b] = product_of(row_of(it, it.W, r), row_of(it, it.X, it.list[b]), it.n)
    for i in range(it.count):
        if it.compliant[it.chosen[i]] != 0:
            press(contacts, contacts.at[i], contacts.least[i])
        elif it.held[it.chosen[i]] != 0 and impact == 0:
            contacts.given[contacts.at[i]] = rate_of_bound(contacts, i)


@compiled
def place_of(it: EventRun, i: int, k: int) -> int:
    """Return the place of a contact in the list, up to the place i."""
    while it.chosen[i] != k:
        i -= 1
    return i


@compiled
def press(contacts: Contacts, r: int, force: float) -> None:
    """Let a given normal force act on all rates, and be no unknown: its row and column of A are zero then.

    Its own rate, which is 0 or more as the law of contact has it, becomes the size of the parts of the acceleration:
    beside it the others are judged.
    """
    m = contacts.rows
    size = abs(contacts.given[r]) + force * contacts.A[r * m + r]
    for a in range(m):
        contacts.given[a] += force * contacts.A[a * m + r]
        contacts.A[a * m + r] = 0.0
    for a in range(m):
        contacts.A[r * m + a] = 0.0
    contacts.given[r] = size


@compiled
def rate_of_bound(contacts: Contacts, i: int) -> float:
    """Return the greatest rate that the bounded friction of a joint gives its tangent.

    It stands in its normal row, which moves nothing: beside it others are judged, where all of them vanish in balance.
    """
    r = contacts.at[i] + contacts.tangents[i]
    return contacts.static[i] * contacts.least[i] * contacts.A[r * contacts.rows + r]


@compiled
def move_speeds(it: EventRun) -> None:
    """Apply the impulses of all rows to the state, and add their work."""
    n, work = it.n, 0.0
    for i in range(n):
        it.v[i] = 0.0
    for r in range(it.rows):
        if it.whole[r] != 0.0:
            for i in range(n):
                it.v[i] += it.whole[r] * it.X[r * n + i]
    for r in range(it.rows):
        if it.whole[r] != 0.0:
            work += it.whole[r] * (it.rate[r] + product_of(row_of(it, it.W, r), it.v, n) / 2.0)
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
    return result - product_of(it.whole, it.x, it.rows)


# -- impacts ---------------------------------------------------------------------------------------------


@compiled
def strike(it: EventRun, contacts: Contacts) -> int:
    """Find the impulses of the approaching contacts; set ``hit``, 1 if there are any. Return a reason to stop, or 0."""
    choose(it)
    it.hit = 0
    for r in range(it.rows):
        it.whole[r] = 0.0
    for i in range(it.count):
        if normal_speed(it, it.chosen[i]) < -it.still:
            it.hit = 1
    if it.hit == 0:
        return 0
    if it.loads > 0 and (it.sequential != 0 or PhaseData(it.looking).own > 0):
        return event_run.LOADED_IMPACT
    if it.loads > 0:
        append_loaded(it)
    gather(it, contacts, 1, 1.0)
    contacts.still = it.still
    status = one_by_one(it, contacts) if it.sequential != 0 else together(it, contacts)
    for a in range(contacts.rows):
        it.whole[it.list[a]] = contacts.forces[a]
    return status


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
    for a in range(contacts.rows):
        it.whole[it.list[a]] = contacts.forces[a]
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
    it.open = impulses_decide(it, contacts) if contacts.directions < contacts.rows else 0
    look(it)
    log_impact(it, contacts, before)
    remember(it, fastest, before)
    return 0


@compiled
def together(it: EventRun, contacts: Contacts) -> int:
    """Let the chosen contacts collide at once."""
    newton, poisson = 0, 0
    for i in range(it.count):
        k = it.chosen[i]
        contacts.restitution[i] = it.coefficients[4 * k + 2]
        # both laws are the same one for a contact that does not rebound
        if normal_speed(it, k) < -it.still and contacts.restitution[i] > 0.0:
            newton, poisson = newton + 1 - it.poisson[k], poisson + it.poisson[k]
    if newton > 0 and poisson > 0:
        return event_run.MIXED
    contacts.poisson = 1 if poisson > 0 else 0
    if it.loads > 0:
        return collided_under_loads(it, contacts)
    run_by(it.colliding, contacts)
    return 0 if contacts.residual <= ACCEPTED else event_run.NO_IMPULSES


@compiled
def one_by_one(it: EventRun, contacts: Contacts) -> int:
    """Let the chosen contacts collide one after another, always the fastest first."""
    m, part, residual = contacts.rows, 1.0, 0.0
    v, total = it.x, it.nu
    copy(contacts.given, v, m)
    for a in range(m):
        total[a] = 0.0
    size = greater(largest(v, m), it.still)
    for _ in range(event_run.PASSES):
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
    if it.bounces == event_run.BOUNCES:
        for i in range(event_run.BOUNCES - 1):
            it.bounce_time[i], it.bounce_speed[i] = it.bounce_time[i + 1], it.bounce_speed[i + 1]
            it.bounce_stuck[i] = it.bounce_stuck[i + 1]
        for i in range((event_run.BOUNCES - 1) * it.contacts):
            it.bounced[i] = it.bounced[i + it.contacts]
        it.bounces -= 1
    b, stuck = it.bounces, 1
    for k in range(it.contacts):
        it.bounced[b * it.contacts + k] = it.taking[k]
        if it.taking[k] != 0 and slip_speed(it, k) > still:
            stuck = 0
    it.bounce_time[b], it.bounce_speed[b], it.bounce_stuck[b] = it.t, fastest, stuck
    it.bounces += 1


@compiled
def take_away(it: EventRun, contacts: Contacts) -> None:
    """Take the normal speeds of the contacts ``taking`` away, and the slip where they stick (`sticks`).

    The remaining bounces press with the sum of the weights less the normal momentum removed here. On a slipping contact
    the friction is smaller accordingly, by -μ d per unit of normal impulse. Other contacts at rest stay closed, under
    the same friction.
    """
    count = 0
    for k in range(it.contacts):
        at = it.first[k]
        rests = it.closed[k] != 0 and it.presser[k] < 0 and abs(it.rate[at]) <= it.still
        if it.taking[k] != 0 or rests:
            count = add_row(it, count, at, -it.rate[at])
            if it.tangents[k] > 0 and not is_smooth(it, k):
                if sticks(it, k) != 0:
                    for j in range(1, 1 + it.tangents[k]):
                        count = add_row(it, count, at + j, -it.rate[at + j])
                else:
                    add_ray(it, count - 1, k)
            count = add_resistances(it, count, k)
    impelled(it, contacts, count)
    move_speeds(it)
    look(it)


@compiled
def add_resistances(it: EventRun, count: int, k: int) -> int:
    """Add what resists the rolling and spinning of a contact in the list: rows at rest, else parts of its ray."""
    normal, r = count - 1, k + 1
    while it.list[normal] != it.first[k]:
        normal -= 1
    while r < it.contacts and it.presser[r] == k:
        if slip_speed(it, r) > it.still:
            add_ray(it, normal, r)
        elif not is_smooth(it, r):
            for j in range(1, 1 + it.tangents[r]):
                count = add_row(it, count, it.first[r] + j, -it.rate[it.first[r] + j])
        r += 1
    return count


@compiled
def sticks(it: EventRun, k: int) -> int:
    """Return 1 if a contact has no slip, or one so slow that it ends within its bounces, or its last impact left none.

    Else 0.
    """
    if slip_speed(it, k) <= event_run.SLOW:
        return 1
    for b in range(it.bounces - 1, it.bounces - 1 - event_run.PERIOD, -1):
        if it.taking[k] != 0 and b >= 0 and it.bounced[b * it.contacts + k] != 0:
            return it.bounce_stuck[b]
    return 0


@compiled
def take_approach(it: EventRun, contacts: Contacts) -> None:
    """Take away the approach of contacts that have collided at this moment: what corrections left, or the rest of a
    series of impacts that goes on between several of them closer than times differ.

    That may press others that have just left; each pass brings one more to rest.
    """
    for _ in range(it.contacts):
        found = 0
        for k in range(it.contacts):
            it.taking[k] = 1 if it.closed[k] != 0 and normal_speed(it, k) < -it.still else 0
            found += it.taking[k]
        if found == 0:
            return
        take_away(it, contacts)


@compiled
def log_rest(it: EventRun, kind: int) -> None:
    """Log that the contacts ``taking`` come to rest, from the state ``start``."""
    at = begin(it, event_run.RESTING)
    mark(it, kind)
    note(it, it.t)
    note_all(it, it.start, it.n_y)
    note_all(it, it.y, it.n_y)
    for k in range(it.contacts):
        if it.taking[k] != 0:
            mark(it, k)
    end(it, at)


@compiled
def end_slow_slips(it: EventRun, contacts: Contacts) -> None:
    """End slips in space slower than `SLOW`, where events crowd at one moment.

    A body that turns about one of its contacts as it stops has no direction of slip there, and a straight step that
    begins one outlasts the slip at the others. The impulses move the masses least: the energy falls.
    """
    count, slow = 0, 0
    for k in range(it.contacts):
        it.taking[k], rests = 0, it.closed[k] != 0 and abs(normal_speed(it, k)) <= it.still
        if rests:
            count = add_row(it, count, it.first[k], -normal_speed(it, k))
        slow_enough = it.tangents[k] == 2 and not is_smooth(it, k) and slip_speed(it, k) <= event_run.SLOW
        if slow_enough and (rests or (it.compliant[k] != 0 and presses(it, k) != 0)):
            it.taking[k] = 1
            for j in range(1, 3):
                count = add_row(it, count, it.first[k] + j, -it.rate[it.first[k] + j])
            if slip_speed(it, k) > it.still:
                slow = 1
    if slow != 0:
        copy(it.y, it.start, it.n_y)
        impelled(it, contacts, count)
        move_speeds(it)
        log_rest(it, event_run.SLOWED)
        look(it)


@compiled
def lift(it: EventRun, contacts: Contacts) -> None:
    """Move contacts that open from a slightly negative gap (closed within tolerance) to gap zero.

    Their return is then a zero crossing of the gap; from a negative gap it would not be. It is the least motion that
    leaves no gap of a closed contact negative, g + W dq >= 0, dq = M⁻¹ Wᵀ x, x >= 0: an impact without friction whose
    speeds are gaps. Equations for all gaps would turn bodies by the gap over the distance of two contacts.
    """
    low, below, count, n = event_run.LOW * (1.0 + largest(it.y, it.n_q)), 0, 0, it.n
    for k in range(it.contacts):
        if it.closed[k] != 0:
            below += 1 if it.gap[k] < -low and it.rate[it.first[k]] > it.still else 0
            count = add_row(it, count, it.first[k], it.gap[k])
    if below == 0:
        return
    contacts.contacts, contacts.rows, contacts.equalities = count, count, 0
    for a in range(count):
        contacts.at[a], contacts.tangents[a], contacts.given[a] = a, 0, it.goal[a]
        contacts.friction[a] = contacts.static[a] = contacts.least[a] = 0.0
        contacts.slides[a], contacts.held[a], contacts.presser[a] = 0, 0, -1
        for b in range(count):
            contacts.A[a * count + b] = product_of(
                row_of(it, it.W, it.list[a]), row_of(it, it.X, it.list[b]), n
            )
    run_by(it.finding, contacts)
    displace(it, contacts.forces, count)


@compiled
def displace(it: EventRun, impulses: Reals, count: int) -> None:
    """Move the coordinates by M⁻¹ Wᵀ x, with numbers x for the rows of the list."""
    n, machine, state = it.n, PhaseData(it.looking), it.trial
    copy(it.y, state, it.n_y)
    for i in range(n):
        state[it.n_q + i] = 0.0
    evaluated(it.t, state, machine)
    copy(machine.q_dot, it.step, it.n_q)
    for a in range(count):
        for i in range(n):
            state[it.n_q + i] += impulses[a] * it.X[it.list[a] * n + i]
    evaluated(it.t, state, machine)
    for i in range(it.n_q):
        it.y[i] += machine.q_dot[i] - it.step[i]
    look(it)
