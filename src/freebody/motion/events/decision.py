"""The modes of closed contacts from the contact problem of their accelerations, in compiled code, where it decides.

It decides if the motion is the only one (`unique`), or if the limit of equal compliance is taken: the motion leaves the
shares of the normal forces open (`depend`), or the contacts are many. Every law has to hold with a margin, or its end
is the event: a force that has fallen to zero opens, friction that has reached its limit slips against it. Otherwise
Python compares all sets of modes (`contact.modes`).
"""

from __future__ import annotations

from ...native.instructions import Reals, compiled, greater, lesser, root, run_by
from ..cones.contacts import EXACT, Contacts
from ..cones.newton import factor
from ..cones.uniqueness import held, is_held, unique
from ..phase import places
from . import event_run
from .event_run import EventRun
from .impulses import gather
from .moment import product_of
from .setting import depends, listed

WHOLE, MOST = 2, 1 << 8
"""Largest number of contacts at rest in space, and of combinations of modes, for which all of them are compared."""
ALIKE = 1e-9
"""Force or speed, relative to the greatest, that is zero in a solution."""


@compiled
def are_many(contacts: Contacts) -> int:
    """Return 1 if too many combinations of modes are possible to compare them, else 0."""
    count, may_begin = 1, 0
    for i in range(contacts.contacts):
        smooth = contacts.tangents[i] == 0 or contacts.static[i] == 0.0
        choices = 2
        if not smooth and contacts.slides[i] == 0:
            choices = 4 if contacts.tangents[i] == 1 else 3
            may_begin += 1 if contacts.tangents[i] == 2 else 0
        count = count * choices if count <= MOST else count
    return 1 if count > MOST or may_begin > WHOLE else 0


@compiled
def alone(contacts: Contacts) -> int:
    """Return 1 if all contacts slide, or have no friction, and every principal minor of S is positive, else 0.

    S are the normal rates per unit of the forces along the rays; the forces are then unique, whatever c is (R. Cottle,
    J.-S. Pang, R. Stone, The Linear Complementarity Problem, theorem 3.3.7).
    """
    m, k, S = contacts.rows, contacts.contacts, contacts.H
    for i in range(k):
        if contacts.slides[i] == 0 and contacts.tangents[i] > 0 and contacts.static[i] > 0.0:
            return 0
        for j in range(k):
            S[i * k + j] = contacts.A[contacts.at[i] * m + contacts.at[j]]
            if contacts.slides[j] != 0:
                for d in range(contacts.tangents[j]):
                    ray = -contacts.friction[j] * contacts.way[2 * j + d]
                    S[i * k + j] += ray * contacts.A[contacts.at[i] * m + contacts.at[j] + 1 + d]
            if is_held(contacts, i) != 0 or is_held(contacts, j) != 0:  # a given force
                S[i * k + j] = 1.0 if i == j else 0.0
    if k > 8:
        return 0
    for chosen in range(1, 1 << k):
        if minor(contacts, S, k, chosen) == 0:
            return 0
    return 1


@compiled
def minor(contacts: Contacts, S: Reals, k: int, chosen: int) -> int:
    """Return 1 if a principal minor of S is positive, well above its round-off, else 0."""
    part, n, sign = contacts.slope, 0, 1.0
    for i in range(k):
        if (chosen >> i) & 1 != 0:
            q = 0
            for j in range(k):
                if (chosen >> j) & 1 != 0:
                    contacts.normal[n * k + q] = S[i * k + j] / root(abs(S[i * k + i] * S[j * k + j]))
                    q += 1
            n += 1
    for i in range(n):
        for j in range(n):
            part[i * n + j] = contacts.normal[i * k + j]
    for c in range(n):
        p = c
        for i in range(c + 1, n):
            if abs(part[i * n + c]) > abs(part[p * n + c]):
                p = i
        if not abs(part[p * n + c]) > event_run.SMALL:
            return 0
        if p != c:
            sign = -sign
            for j in range(n):
                part[p * n + j], part[c * n + j] = part[c * n + j], part[p * n + j]
        sign = sign if part[c * n + c] > 0.0 else -sign
        for i in range(c + 1, n):
            x = part[i * n + c] / part[c * n + c]
            for j in range(c, n):
                part[i * n + j] -= x * part[c * n + j]
    return 1 if sign > 0.0 else 0


# -- the solution and its modes --------------------------------------------------------------------------


@compiled
def decide(it: EventRun, contacts: Contacts) -> int:
    """Set modes, directions and forces of the chosen contacts; return 0 if Python has to compare the sets, else 1."""
    for k in range(it.contacts):
        it.mode[k], it.way[k, 0], it.way[k, 1] = places.OPEN, 0.0, 0.0
    for r in range(it.rows):
        it.force[r] = 0.0
    if it.count == 0:
        return 1
    gather(it, contacts, 0)
    if it.refuse != 0:
        return 0
    for i in range(it.count):
        if it.hit == 0 and it.reason[it.chosen[i]] == event_run.CONE_REACHED:
            contacts.static[i] = contacts.friction[i]
    rank = factor(contacts.A, contacts.rows, contacts.factors, event_run.SMALL, contacts.left, contacts.order)
    sole = 1 if alone(contacts) != 0 or unique(contacts, rank) != 0 else 0
    if sole == 0 and are_many(contacts) == 0 and depend(contacts) == 0:
        return 0
    run_by(it.finding, contacts)
    if not contacts.residual <= EXACT:
        return 0
    while released(contacts) != 0:
        run_by(it.finding, contacts)
        if not contacts.residual <= EXACT:
            return 0
    return named(it, contacts, sole)


@compiled
def depend(contacts: Contacts) -> int:
    """Return 1 if the motion does not determine how the contacts share the normal forces, else 0."""
    k, m, S = contacts.contacts, contacts.rows, contacts.H
    for i in range(k):
        for j in range(k):
            S[i * k + j] = contacts.A[contacts.at[i] * m + contacts.at[j]]
    independent = factor(S, k, contacts.factors, event_run.SMALL, contacts.left, contacts.order)
    return 1 if independent < k - held(contacts) else 0


@compiled
def greatest(x: Reals, n: int) -> float:
    """Return the greatest of n numbers in magnitude."""
    result = 0.0
    for i in range(n):
        result = greater(result, abs(x[i]))
    return result


@compiled
def released(contacts: Contacts) -> int:
    """Give slips that begin the kinetic friction; return 1 if any has static friction yet, else 0."""
    found = 0
    for i in range(contacts.contacts):
        if (
            mode_of(contacts, i) == places.SLIDE
            and contacts.slides[i] == 0
            and contacts.static[i] > contacts.friction[i]
        ):
            contacts.static[i], found = contacts.friction[i], 1
    return found


@compiled
def mode_of(contacts: Contacts, i: int) -> int:
    """Return the mode of a contact in the solution: open, stick or slip."""
    at, n, m = contacts.at[i], contacts.tangents[i], contacts.rows
    slow = ALIKE * greater(greatest(contacts.given, m), greatest(contacts.after, m))
    if is_held(contacts, i) == 0 and contacts.forces[at] <= ALIKE * greatest(contacts.forces, m):
        return places.OPEN
    if n == 0 or contacts.static[i] == 0.0 or contacts.slides[i] != 0:
        return places.SLIDE
    square = 0.0
    for j in range(n):
        square += contacts.after[at + 1 + j] * contacts.after[at + 1 + j]
    return places.SLIDE if root(square) > slow else places.STICK


@compiled
def named(it: EventRun, contacts: Contacts, sole: int) -> int:
    """Set the modes of the solution; return 0 if a law holds with equality and that is not the event, else 1.

    ``sole`` is 1 if the motion is the only one.
    """
    m, A = contacts.rows, contacts.A
    most_force, most_rate = greatest(contacts.forces, m), greatest(contacts.given, m)
    for a in range(m):
        size = 0.0
        for b in range(m):
            size += abs(A[a * m + b] * contacts.forces[b])
        most_rate = greater(most_rate, size)
        if abs(A[a * m + a]) > 0.0:
            most_force = greater(most_force, abs(contacts.given[a] / A[a * m + a]))
    f, r = 1.0 / most_force if most_force > 0.0 else 1.0, 1.0 / most_rate if most_rate > 0.0 else 1.0
    idle = 0
    for i in range(contacts.contacts):
        at, n, k = contacts.at[i], contacts.tangents[i], it.chosen[i]
        it.mode[k] = mode_of(contacts, i)
        for j in range(1 + n):
            it.force[it.first[k] + j] = contacts.forces[at + j]
        if not margin(contacts, i, it.mode[k], f, r) > event_run.SMALL:
            ends = it.hit == 0 and sole != 0
            if it.mode[k] == places.OPEN and ends and it.reason[k] == event_run.NORMAL_ZERO:
                pass
            elif it.mode[k] == places.OPEN and sole == 0:
                idle += 1
            elif it.mode[k] == places.STICK and ends and it.reason[k] == event_run.CONE_REACHED:
                it.mode[k] = places.SLIDE
            else:
                return 0
        if it.mode[k] == places.SLIDE and it.rough[k] != 0:
            if n == 0 or contacts.static[i] == 0.0:
                it.mode[k] = places.SMOOTH
            else:
                set_way(it, contacts, i)
    return 1 if idle == 0 or all_idle(it, contacts) != 0 else 0


@compiled
def all_idle(it: EventRun, contacts: Contacts) -> int:
    """Return 1 if the others hold all open contacts of the problem in place whose rates are zero, else 0."""
    slow = ALIKE * greater(greatest(contacts.given, contacts.rows), greatest(contacts.after, contacts.rows))
    count = listed(it)
    for i in range(it.count):
        k = it.chosen[i]
        still = it.mode[k] == places.OPEN and abs(contacts.after[contacts.at[i]]) <= slow
        if still and depends(it, contacts, it.first[k], count) == 0:
            return 0
    return 1


@compiled
def size_of(x: Reals, n: int) -> float:
    """Return the length of a vector."""
    return root(product_of(x, x, n))


@compiled
def margin(contacts: Contacts, i: int, mode: int, f: float, r: float) -> float:
    """Return by how much the laws of a contact hold; f and r are the reciprocals of typical forces and rates."""
    at, n = contacts.at[i], contacts.tangents[i]
    rests = contacts.slides[i] == 0 and n > 0 and contacts.static[i] > 0.0
    if mode == places.OPEN:
        return contacts.after[at] * r
    least = contacts.forces[at] * f if is_held(contacts, i) == 0 else 1.0
    if mode == places.STICK:
        least = lesser(
            least, f * (contacts.static[i] * contacts.forces[at] - size_of(contacts.forces[at + 1 :], n))
        )
    elif rests:
        least = lesser(least, r * size_of(contacts.after[at + 1 :], n))
    return least


@compiled
def set_way(it: EventRun, contacts: Contacts, i: int) -> None:
    """Set the direction of slip of a contact."""
    at, n, k = contacts.at[i], contacts.tangents[i], it.chosen[i]
    speed, friction = size_of(contacts.after[at + 1 :], n), size_of(contacts.forces[at + 1 :], n)
    begins = mode_of(contacts, i) == places.STICK  # friction has reached its limit
    for j in range(n):
        if contacts.slides[i] != 0:
            it.way[k, j] = contacts.way[2 * i + j]
        elif begins:
            it.way[k, j] = -contacts.forces[at + 1 + j] / friction
        else:
            it.way[k, j] = contacts.after[at + 1 + j] / speed
    if n == 1:
        it.mode[k] = places.SLIDE_BACK if it.way[k, 0] < 0.0 else places.SLIDE_ON
