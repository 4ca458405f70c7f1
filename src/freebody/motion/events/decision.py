"""The modes of closed contacts from the contact problem of their accelerations, in compiled code.

Where the motion is proven to be the only one (`unique`, `alone`), the problem is solved; elsewhere few contacts whose
directions are known are tried in all combinations of modes (`combinations`), and none or several motions are refused
(Painlevé). Where the motion leaves the shares of the normal forces open (`depend`), or the contacts are many, the limit
of equal compliance is taken.

A law may hold with equality, such as |T| = μ_s N. Then its end is the event, or the motion decides (`ties`).
"""

from __future__ import annotations

from ...native.instructions import compiled, greater, lesser, root, run_by
from ..cones.broyden import TURNS, begin, take
from ..cones.combinations import combinations, motions, shares_move, take_first, typical_force, typical_rate
from ..cones.contacts import EXACT, Contacts
from ..cones.newton import factor
from ..cones.uniqueness import alone, behind, depend, is_held, unique
from ..phase import laws
from . import event_run, limits
from .event_run import EventRun
from .impacts.borne_loads import borne, set_loads
from .moment import copy_wholes, largest, pull, size_of
from .problem import gather, is_unloaded, split, take_all, take_island
from .setting import depends, has_spare, listed_in
from .shares import share
from .ties import end_at_once

ALIKE = 1e-9
"""Force or speed, relative to the greatest, that is zero in a solution."""
NEAR, AMPLIFIED = 1e-6, 100.0
"""Residual of forces that show modes, and by how much more than it they may be wrong.

Contacts at the limit of friction that share forces are not solved for to round-off, since cone and slip both vanish.
Loads of joints may stay that far from agreeing, where slips begin whose directions are those of small accelerations.
"""
AGREE = 1e-13
"""Relative difference of loads that agree with their modes."""


# -- the solution and its modes --------------------------------------------------------------------------


@compiled
def decide(it: EventRun, contacts: Contacts) -> int:
    """Set modes, directions and forces of the chosen contacts. Return why there are none, or 0."""
    it.choice = 0
    for k in range(it.contacts):
        ends = it.reason[k] == event_run.NORMAL_ZERO
        if it.reason[k] == event_run.CONE_REACHED:  # else the friction may be constant, up to round-off
            ends = it.coefficients[4 * k + 1] > it.coefficients[4 * k + 3]
        goes = ends and it.hit == 0 and is_unloaded(it, k) == 0
        it.ends[k] = it.reason[k] if goes else event_run.NO_REASON
    why = parted_modes(it, contacts)
    turn = 0
    while why == 0 and it.ties > 0 and turn < 2 * it.contacts:
        if it.ready == 0:
            return event_run.ASK_KERNELS
        copy_wholes(it.ends, it.ended, it.contacts)
        if end_at_once(it, contacts) == 0:
            return 0
        why, turn = parted_modes(it, contacts), turn + 1
        if why != 0:  # nothing follows from their end: they go on
            copy_wholes(it.ended, it.ends, it.contacts)
            return parted_modes(it, contacts)
    return why


@compiled
def parted_modes(it: EventRun, contacts: Contacts) -> int:
    """Set modes as `solved_modes` does; contacts that open lose their adhesion, so that the others are decided anew."""
    why = loaded_modes(it, contacts)
    while why == 0 and part(it) > 0:
        why = loaded_modes(it, contacts)
    return why


@compiled
def loaded_modes(it: EventRun, contacts: Contacts) -> int:
    """Set modes as `solved_modes` does, under loads of joints that are those of their forces (`broyden`).

    Where static friction is the greater one, loads jump as a slip begins: a contact may stick under the loads of its
    slip, and slip under those of its stick. It does not stick then, and those that have begun to slip go on.
    """
    for k in range(it.contacts):
        it.let_go[k] = 0
    if it.loads == 0:
        return solved_modes(it, contacts)
    if it.ready == 0:
        return event_run.ASK_KERNELS
    why = agreed_modes(it, contacts, 0)
    return agreed_modes(it, contacts, 1) if why == event_run.JAMMED else why


@compiled
def agreed_modes(it: EventRun, contacts: Contacts, slips_on: int) -> int:
    """Set modes under loads that agree; with ``slips_on`` 1 what begins to slip under any of them does under all."""
    begin(it.bounds, it.loads)
    j, last = 0, 1.0
    for k in range(it.contacts):
        if it.loaded[k] != 0:
            it.bounds[j] = it.load[k]
            j += 1
    for _ in range(TURNS):
        set_loads(it)
        for k in range(it.contacts):
            it.let_go[k] *= slips_on
        why = solved_modes(it, contacts)
        if why != 0:
            return why
        change = borne(it)
        if change <= AGREE or NEAR >= change >= last:
            return 0
        last = change
        take(it.bounds, it.loads)
    return event_run.JAMMED


@compiled
def part(it: EventRun) -> int:
    """Take the adhesion of contacts that open away, and them and what resists their rolling from the list; return their
    number.
    """
    found, count = 0, 0
    for i in range(it.count):
        k = it.chosen[i]
        presser = it.presser[k]
        if it.adhering[k] != 0 and it.mode[k] == laws.OPEN:
            it.parted[k], found = 1, found + 1
            pull(it, k, -1)
        elif presser < 0 or it.parted[presser] == 0:
            it.chosen[count] = k
            count += 1
    it.count = count
    return found


@compiled
def solved_modes(it: EventRun, contacts: Contacts) -> int:
    """Set modes, directions and forces with the laws that ``ends`` says to end. Return why there are none, or 0.

    Then the chosen contacts are those of the island that has none.
    """
    for k in range(it.contacts):
        it.mode[k], it.way[k, 0], it.way[k, 1] = laws.OPEN, 0.0, 0.0
    for r in range(it.rows):
        it.force[r] = 0.0
    split(it)
    first, it.ties = 0, 0
    while first < it.concerned_count:
        first = take_island(it, first)
        why = island_modes(it, contacts)
        if why != 0:
            return why
    take_all(it)
    for i in range(it.count):
        it.ties += it.tied[it.chosen[i]]
    return 0


@compiled
def island_modes(it: EventRun, contacts: Contacts) -> int:
    """Set modes, directions and forces of the chosen contacts of one island. Return why there are none, or 0."""
    gather(it, contacts, 0, 1.0)
    for i in range(it.count):
        if it.ends[it.chosen[i]] == event_run.CONE_REACHED or it.let_go[it.chosen[i]] != 0:
            contacts.static[i] = contacts.friction[i]
    rank = factor(contacts.A, contacts.rows, contacts.factors, limits.SMALL, contacts.left, contacts.order)
    few = 0
    if alone(contacts) == 0 and unique(contacts, rank) == 0 and depend(contacts) == 0:
        few = combinations(contacts)
        if few > 0 and motions(contacts) > 1:
            if shares_move(contacts) == 0:
                return event_run.SEVERAL
            few, it.choice = 0, 1
    again = 1
    while again != 0:
        run_by(it.finding, contacts)
        if not contacts.residual <= EXACT:
            if few > 0 and motions(contacts) == 1:
                take_first(contacts)
                contacts.residual = 0.0
            elif few > 0 or not contacts.residual <= NEAR:
                return event_run.NO_MOTION
        again = released(it, contacts)
    it.worst = greater(it.worst, contacts.residual)
    name(it, contacts)
    shares = it.count == it.concerned_count or has_spare(it, contacts) != 0
    if it.ready != 0 and shares and share(it, contacts) != 0:
        name(it, contacts)
    return 0


@compiled
def released(it: EventRun, contacts: Contacts) -> int:
    """Give slips that begin the kinetic friction; return 1 if any has static friction yet, else 0."""
    found = 0
    for i in range(contacts.contacts):
        if (
            mode_of(contacts, i) == laws.SLIDE
            and contacts.slides[i] == 0
            and contacts.static[i] > contacts.friction[i]
        ):
            contacts.static[i], found = contacts.friction[i], 1
            it.let_go[it.chosen[i]] = 1
    return found


@compiled
def rounded(contacts: Contacts, small: float) -> float:
    """Return the relative error of the forces and rates, ``small`` if they are a solution to round-off."""
    return small if contacts.residual <= EXACT else AMPLIFIED * contacts.residual


@compiled
def mode_of(contacts: Contacts, i: int) -> int:
    """Return the mode of a contact in the solution: open, stick or slip."""
    at, n, m = contacts.at[i], contacts.tangents[i], contacts.rows
    alike = rounded(contacts, ALIKE)
    slow = alike * greater(largest(contacts.given, m), largest(contacts.after, m))
    p = contacts.presser[i] if contacts.presser[i] >= 0 else i
    load = largest(contacts.forces[contacts.at[p] :], 1 + contacts.tangents[p])
    if (is_held(contacts, i) == 0 or p != i) and load <= alike * largest(contacts.forces, m):
        return laws.OPEN
    if n == 0 or contacts.static[i] == 0.0 or contacts.slides[i] != 0:
        return laws.SLIDE
    square = 0.0
    for j in range(n):
        square += contacts.after[at + 1 + j] * contacts.after[at + 1 + j]
    return laws.SLIDE if root(square) > slow else laws.STICK


@compiled
def name(it: EventRun, contacts: Contacts) -> None:
    """Set the modes of the solution, and of which contacts a law holds with equality, ``tied``."""
    force, rate = typical_force(contacts), typical_rate(contacts)
    f, r = 1.0 / force if force > 0.0 else 1.0, 1.0 / rate if rate > 0.0 else 1.0
    small, slipping = rounded(contacts, limits.SMALL), 0
    for i in range(contacts.contacts):
        slipping += 1 if it.ends[it.chosen[i]] == event_run.CONE_REACHED else 0
    for i in range(contacts.contacts):
        at, n, k = contacts.at[i], contacts.tangents[i], it.chosen[i]
        it.mode[k], it.tied[k] = mode_of(contacts, i), 0
        # N + A has the round-off of A
        gone = it.adhering[k] != 0 and contacts.forces[at] <= limits.SMALL * it.adhesion[k]
        if gone and it.ends[k] == event_run.NORMAL_ZERO:
            it.mode[k] = laws.OPEN
        for j in range(1 + n):
            it.force[it.first[k] + j] = contacts.forces[at + j]
        if gone or not margin(contacts, i, it.mode[k], f, r) > small:
            if it.mode[k] == laws.OPEN:
                it.tied[k] = 1 if it.ends[k] != event_run.NORMAL_ZERO and contacts.presser[i] < 0 else 0
            elif it.mode[k] == laws.STICK:
                # those at their limits of friction slip together
                limit = size_of(contacts.forces[at + 1 :], n) * f > limits.SMALL
                begins = slipping > 0 and limit and cone_margin(contacts, i) * f <= small
                if begins or (it.ends[k] == event_run.CONE_REACHED and is_unloaded(it, k) != 0):
                    it.mode[k] = laws.SLIDE
                else:
                    it.tied[k] = 1
            else:
                it.tied[k] = 1
        name_slip(it, contacts, i)
    for i in range(contacts.contacts):
        k = it.chosen[i]
        if it.tied[k] != 0 and it.mode[k] == laws.OPEN:
            close(it, contacts, i, r)


@compiled
def name_slip(it: EventRun, contacts: Contacts, i: int) -> None:
    """Set the direction of the slip of a contact, or that it has no friction."""
    k = it.chosen[i]
    if it.mode[k] == laws.SLIDE and it.rough[k] != 0:
        if contacts.tangents[i] == 0 or contacts.static[i] == 0.0:
            it.mode[k] = laws.SMOOTH
        else:
            set_way(it, contacts, i)


@compiled
def close(it: EventRun, contacts: Contacts, i: int, r: float) -> None:
    """Let a contact without force and acceleration be closed, unless the others hold it in place."""
    k = it.chosen[i]
    if depends(it, contacts, it.first[k], listed_in(it, it.island[k])) != 0:
        it.tied[k] = 0
        return
    for s in range(i, behind(contacts, i)):
        at, n = contacts.at[s], contacts.tangents[s]
        rests = contacts.slides[s] == 0 and r * size_of(contacts.after[at + 1 :], n) <= ALIKE
        it.mode[it.chosen[s]] = laws.STICK if rests and n > 0 and contacts.static[s] > 0.0 else laws.SLIDE
        name_slip(it, contacts, s)


@compiled
def margin(contacts: Contacts, i: int, mode: int, f: float, r: float) -> float:
    """Return by how much the laws of a contact hold; f and r are the reciprocals of typical forces and rates."""
    at, n = contacts.at[i], contacts.tangents[i]
    rests = contacts.slides[i] == 0 and n > 0 and contacts.static[i] > 0.0
    if mode == laws.OPEN:
        return contacts.after[at] * r
    least = contacts.forces[at] * f if is_held(contacts, i) == 0 else 1.0
    if mode == laws.STICK:
        least = lesser(least, f * cone_margin(contacts, i))
    elif rests:
        least = lesser(least, r * size_of(contacts.after[at + 1 :], n))
    return least


@compiled
def cone_margin(contacts: Contacts, i: int) -> float:
    """Return μ_s N - |T|."""
    at, n = contacts.at[i], contacts.tangents[i]
    return contacts.static[i] * contacts.forces[at] - size_of(contacts.forces[at + 1 :], n)


@compiled
def set_way(it: EventRun, contacts: Contacts, i: int) -> None:
    """Set the direction of slip of a contact."""
    at, n, k = contacts.at[i], contacts.tangents[i], it.chosen[i]
    speed, friction = size_of(contacts.after[at + 1 :], n), size_of(contacts.forces[at + 1 :], n)
    begins = mode_of(contacts, i) == laws.STICK  # friction has reached its limit
    for j in range(n):
        if contacts.slides[i] != 0:
            it.way[k, j] = contacts.way[2 * i + j]
        elif begins and friction == 0.0:
            it.way[k, j] = 1.0 if it.later[k] < 0.0 else -1.0
        elif begins:
            it.way[k, j] = -contacts.forces[at + 1 + j] / friction
        else:
            it.way[k, j] = contacts.after[at + 1 + j] / speed
    if n == 1:
        it.mode[k] = laws.SLIDE_BACK if it.way[k, 0] < 0.0 else laws.SLIDE_ON
