"""Whether indeterminate forces decide the motion, in compiled code.

Forces along rays, λ = B x, whose combinations x of S x = 0 leave all rates of the closed contacts unchanged are
indeterminate, S = W_rows M⁻¹ Wᵀ B. Without friction, or if all slip in one direction with one coefficient, they move
nothing: M⁻¹ Wᵀ B x = 0. Otherwise each distribution moves the machine differently.
"""

from __future__ import annotations

import math

from ...native.instructions import Reals, compiled, greater
from ..cones.contacts import Contacts
from ..phase import laws
from . import limits
from .event_run import EventRun
from .impulse_system import add_ray, add_row, ray_product
from .moment import copy, copy_wholes, is_smooth, largest, look, slip_speed
from .setting import begins_slip, find_dead, find_islands, set_up

SAME = 1e-8
"""Relative size of a motion that is none."""


@compiled
def forces_decide(it: EventRun, contacts: Contacts) -> int:
    """Return 1 if the shares of indeterminate forces decide the motion in the present modes, else 0."""
    find_islands(it)
    for b in range(it.blocks):
        if it.holds[b] > 0 and forces_decide_in(it, contacts, b) != 0:
            return 1
    return 0


@compiled
def forces_decide_in(it: EventRun, contacts: Contacts, island: int) -> int:
    """Return 1 if the shares of indeterminate forces decide the motion of an island, else 0."""
    count, unsure = list_rays(it, island), SAME
    if count < 0:
        return 0
    for k in range(it.contacts):
        rough = it.mode[k] == laws.SLIDE and not is_smooth(it, k) and it.island[k] == island
        normal = it.presser[k] if it.presser[k] >= 0 else k
        if rough and it.tangents[k] == 2 and it.held[normal] == 0:
            noise = limits.NOISE * (1.0 + largest(it.y[it.n_q :], it.n))
            unsure = greater(unsure, noise / slip_speed(it, k))
    return 1 if moved_by_shares(it, contacts, count) > 10.0 * unsure else 0


@compiled
def list_rays(it: EventRun, island: int) -> int:
    """List the unknown forces of the present modes of an island; return their number.

    It is -1 if a slip has no direction yet.
    """
    count, normal = 0, -1
    for k in range(it.contacts):
        n, mode, at = it.tangents[k], it.mode[k], it.first[k]
        rough = n > 0 and not is_smooth(it, k)
        if mode == laws.OPEN or it.island[k] != island:
            continue
        if mode != laws.STICK and rough and slip_speed(it, k) <= it.still:
            return -1
        if it.presser[k] < 0:  # resistance to rolling and spinning follows its contact
            normal = -1 if it.held[k] != 0 else count
        if it.held[k] == 0:
            count = add_row(it, count, at, 0.0)
        if mode == laws.STICK:
            for j in range(n):
                count = add_row(it, count, at + 1 + j, 0.0)
        elif rough and normal >= 0:
            add_ray(it, normal, k)
    return count


@compiled
def impulses_decide(it: EventRun, contacts: Contacts) -> int:
    """Return 1 if impulses of the last impact that are distributed otherwise would change the motion, else 0."""
    count, most, fastest = 0, largest(contacts.forces, contacts.rows), largest(contacts.after, contacts.rows)
    normal = 0
    for i in range(contacts.contacts):
        at, n, r = contacts.at[i], contacts.tangents[i], it.first[it.chosen[i]]
        if contacts.forces[at] <= SAME * most or contacts.friction[i] == 0.0:
            n = 0
        # a given bound of friction, which has no share
        held = contacts.held[i] != 0 and contacts.presser[i] < 0
        if held and largest(contacts.after[at + 1 :], n) > SAME * fastest:
            continue
        if contacts.forces[at] > SAME * most:
            if contacts.presser[i] < 0 and not held:
                normal, count = count, add_row(it, count, r, 0.0)
            if n > 0 and largest(contacts.after[at + 1 :], n) > SAME * fastest:
                for j in range(n):
                    it.ray[normal, r - it.list[normal] + j] = (
                        contacts.forces[at + 1 + j] / contacts.forces[at]
                    )
            else:
                for j in range(n):
                    count = add_row(it, count, r + 1 + j, 0.0)
    return 1 if moved_by_shares(it, contacts, count) > SAME else 0


@compiled
def moved_by_shares(it: EventRun, contacts: Contacts, count: int) -> float:
    """Return the greatest motion by indeterminate forces of size 1, relative to the greatest by any force of size 1."""
    z, worst, unit = contacts.left, 0.0, 0.0
    rank = eliminated(it, contacts, count)
    if rank == count:
        return 0.0
    for b in range(count):
        z[b] = 0.0
    for b in range(count):
        z[b] = 1.0
        unit = greater(unit, motion_of(it, z, count))
        z[b] = 0.0
    for free in range(rank, count):
        size = combine(contacts, rank, free, count)
        worst = greater(worst, motion_of(it, z, count) / size)
    return worst / unit if unit > 0.0 else 0.0


@compiled
def combine(contacts: Contacts, rank: int, free: int, count: int) -> float:
    """Set ``left`` to the combination of forces without effect that has one that is not a pivot; return its size."""
    S, z, order, size = contacts.chosen, contacts.left, contacts.order, 1.0
    for b in range(count):
        z[b] = 0.0
    z[order[free]] = 1.0
    for p in range(rank - 1, -1, -1):
        x = -S[p * count + order[free]]
        for q in range(p + 1, rank):
            x -= S[p * count + order[q]] * z[order[q]]
        z[order[p]] = x / S[p * count + order[p]]
        size = greater(size, abs(z[order[p]]))
    return size


@compiled
def find_shared(it: EventRun, contacts: Contacts) -> None:
    """Find the contacts whose forces the motion leaves open in the present modes, `shared`."""
    find_islands(it)
    for b in range(it.blocks):
        if it.parent[b] == b:
            find_shared_in(it, contacts, b)


@compiled
def find_shared_in(it: EventRun, contacts: Contacts, island: int) -> None:
    """Find the contacts of an island whose forces the motion leaves open."""
    count, z = list_rays(it, island), contacts.left
    for k in range(it.contacts):
        if it.island[k] == island:
            it.shared[k] = 1 if count < 0 else 0
    rank = eliminated(it, contacts, count) if count > 0 else count
    for free in range(rank, count):
        size = combine(contacts, rank, free, count)
        for b in range(count):
            for k in range(it.contacts):
                if it.first[k] <= it.list[b] <= it.first[k] + it.tangents[k] and abs(z[b]) > SAME * size:
                    it.shared[k] = 1


@compiled
def eliminated(it: EventRun, contacts: Contacts, count: int) -> int:
    """Write S of the listed forces and eliminate in it with the largest pivots; return the rank.

    ``order`` becomes the columns in their order.
    """
    S, order = contacts.chosen, contacts.order
    for a in range(count):
        order[a] = a
        for b in range(count):
            S[a * count + b] = ray_product(it, a, b)
    most = largest(S, count * count)
    for p in range(count):
        row, column = p, p
        for a in range(p, count):
            for b in range(p, count):
                if abs(S[a * count + order[b]]) > abs(S[row * count + order[column]]):
                    row, column = a, b
        order[p], order[column] = order[column], order[p]
        if not abs(S[row * count + order[p]]) > limits.SMALL * most:
            return p
        for b in range(count):
            S[p * count + b], S[row * count + b] = S[row * count + b], S[p * count + b]
        for a in range(p + 1, count):
            part = S[a * count + order[p]] / S[p * count + order[p]]
            for b in range(p, count):
                S[a * count + order[b]] -= part * S[p * count + order[b]]
    return count


@compiled
def motion_of(it: EventRun, z: Reals, count: int) -> float:
    """Return the greatest acceleration, or change of a speed, by the forces z along the rays."""
    n = it.n
    for i in range(n):
        it.v[i] = 0.0
    for b in range(count):
        if z[b] == 0.0:
            continue
        r = it.list[b]
        for i in range(n):
            it.v[i] += z[b] * it.X[r * n + i]
        for j in range(limits.RAY):
            if it.ray[b, j] != 0.0:
                for i in range(n):
                    it.v[i] += z[b] * it.ray[b, j] * it.X[(r + 1 + j) * n + i]
    return largest(it.v, n)


@compiled
def forces_decided(it: EventRun, contacts: Contacts) -> int:
    """Return 1, at that moment, if the shares of indeterminate forces decided the last phase at a step, else 0."""
    end = it.t
    copy(it.y, it.kept, it.n_y)
    for i in range(it.first_row, it.logged):
        it.t = it.times[i]
        copy(it.states[i * it.n_y :], it.y, it.n_y)
        look(it)
        if forces_decide(it, contacts) != 0:
            return 1
    it.t = end
    copy(it.kept, it.y, it.n_y)
    look(it)
    return 0


# -- shares that a decision takes ---------------------------------------------------------------------------


@compiled
def share(it: EventRun, contacts: Contacts) -> int:
    """Take the shares of indeterminate forces that the equations of the modes have; return 1 if there are any, else 0.

    Contacts at rest share friction in proportion to N there, and reach their limits by it. One that would pull opens,
    if the others hold it in place.
    """
    set_up(it, contacts)
    if it.spare_count == 0 or has_forces(it) == 0:
        return 0
    while opens_pulling(it, contacts) != 0:
        set_up(it, contacts)
        if has_forces(it) == 0:
            return 0
    for i in range(contacts.contacts):
        for j in range(1 + contacts.tangents[i]):
            contacts.forces[contacts.at[i] + j] = it.speeds[it.first[it.chosen[i]] + j]
        if it.adhering[it.chosen[i]] != 0:
            contacts.forces[contacts.at[i]] += it.adhesion[it.chosen[i]]
    return 1


@compiled
def leave_pulling(it: EventRun, contacts: Contacts) -> None:
    """Open the chosen contacts whose shares of open forces would pull, if the others hold them in place."""
    set_up(it, contacts)
    opens = 1
    while opens != 0 and it.spare_count > 0 and has_forces(it) != 0:
        copy_wholes(it.mode, it.before, it.contacts)
        opens = opens_pulling(it, contacts)
        if opens == 0:
            copy_wholes(it.before, it.mode, it.contacts)
        set_up(it, contacts)


@compiled
def has_forces(it: EventRun) -> int:
    """Set ``speeds`` to the forces that the equations of the modes give; return 1 if there are any, else 0."""
    it.forces(it.t, it.y, it.phase, it.speeds)
    for i in range(it.count):
        if begins_slip(it, it.chosen[i]) != 0:
            return 0  # no direction yet: that of its speed is round-off
        for j in range(1 + it.tangents[it.chosen[i]]):
            if not math.isfinite(it.speeds[it.first[it.chosen[i]] + j]):
                return 0
    return 1


@compiled
def opens_pulling(it: EventRun, contacts: Contacts) -> int:
    """Open the contact whose share pulls most; return 1 if there is one, and the others hold it in place, else 0.

    If they do not, its mode is open only until the shares are named.
    """
    found = opened(it)
    if found < 0:
        return 0
    find_dead(it, contacts)
    return it.dead[found]


@compiled
def opened(it: EventRun) -> int:
    """Open the contact that pulls most, and what resists its rolling; return it, or -1 if none does.

    Forces are those in ``speeds`` (`has_forces`).
    """
    found, most = -1, 0.0
    for i in range(it.count):
        k = it.chosen[i]
        most = greater(most, largest(it.speeds[it.first[k] :], 1 + it.tangents[k]))
    least = -limits.SMALL * most
    for i in range(it.count):
        k = it.chosen[i]
        bears = it.adhesion[k] if it.adhering[k] != 0 else 0.0
        if it.held[k] == 0 and it.presser[k] < 0 and it.speeds[it.first[k]] + bears < least:
            found, least = k, it.speeds[it.first[k]] + bears
    if found >= 0:
        it.mode[found] = laws.OPEN
        for r in range(it.contacts):
            if it.presser[r] == found:
                it.mode[r] = laws.OPEN
    return found
