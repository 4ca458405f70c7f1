"""Pairs of families in a step: their rows in the problem, their first guess, and the log of what they do.

Rows of pairs stand behind those of the contacts and constraints. The impulses of the last step are found again by the
numbers of the pairs, which are in ascending order then and now.
"""

from __future__ import annotations

from ...native.instructions import Reals, call, compiled, greater, inlined, lesser
from ..cones.block_rows import add
from ..cones.contact_problem import FIRST, LINE, NORMAL
from ..families.family_record import ENTRY, POINTS, RESISTED, Pairs
from ..families.narrow_phase import P, Q, T, find, nearer, place_in_past, seek, stays
from ..families.pair_rows import axis, rate, row_rate, rows, stretch_of
from .curvature import after, lasting, negligible, turned
from .stepping_record import BACKWARDS, BEGINS, FORWARDS, LANDED, OPENS, SLIP, STAYED, STICK, Run


@compiled
def lay_pairs(run: Run, t: float, near: float, friction: int) -> int:
    """Find the pairs with gaps up to ``near`` at z, and write their rows, those of normals only without ``friction``;
    return 0 if there is no room for them.
    """
    pairs = run.families.pairs
    if near <= pairs.within and pairs.count <= pairs.most:
        nearer(run.families, t, run.z, near)
    else:
        seek(run.families, t, run.z, near)
    if pairs.count > pairs.most:
        return 0
    rows(run.families, run.problem.blocks, run.contacts.rows + run.constraints, run.W, friction)
    return 1


@compiled
def deepest(run: Run, t: float, depth: float, near: float) -> float:
    """Return the greatest depth of all pairs at z, or ``depth`` if that is greater.

    What `lay_pairs` needs is found up to ``near``.
    """
    families, pairs, c = run.families, run.families.pairs, 0
    find(families, t + run.h, run.z, near)
    count = pairs.count if pairs.count < pairs.most else pairs.most
    while c < count:
        both, apart, least = pairs.ids[c] // POINTS, pairs.apart[c], pairs.touch[c, 0]
        r = families.members.radius[pairs.first[c]] + families.members.radius[pairs.second[c]]
        while c < count and pairs.ids[c] // POINTS == both:
            least = lesser(least, pairs.touch[c, 0])
            if pairs.touch[c, 0] > depth and stays(pairs, pairs.ids[c]) > OPENS:
                depth = pairs.touch[c, 0]
            c += 1
        # all points over the face are open: the one beside it, which has none then (`faces.deepest`)
        depth = greater(depth, -apart if least > 0.0 and apart + r <= 0.0 else -least)
    return depth


@compiled
def begin_closed(run: Run, t: float, near: float) -> None:
    """Let the pairs with gaps up to ``near`` at z, the state before the first step, begin closed."""
    pairs = run.families.pairs
    pairs.known = 0
    seek(run.families, t, run.z, near)
    pairs.known = pairs.count if pairs.count <= pairs.most else 0
    for p in range(pairs.known):
        slot = pairs.slots[p]
        begins = run.families.laws.normal[family_of(run, slot)] == 0
        pairs.past[p], pairs.stays[p] = pairs.ids[p], BEGINS if begins else OPENS
        pairs.stuck[p] = pairs.stays[p]
        for k in range(rows_of(run, slot)):
            pairs.impulses[p, k] = 0.0
            pairs.last[p, 2 * k] = row_rate(run.families, slot, k)


@compiled
def close_pairs(run: Run, friction: int) -> None:
    """Add the rows of the closed pairs to the problem; tangent rows only if ``friction`` is not 0."""
    contacts, problem, pairs, laws = run.contacts, run.problem, run.families.pairs, run.families.laws
    count, row = problem.count, contacts.rows + run.constraints
    for c in range(pairs.count):
        f = run.families.members.family[pairs.first[pairs.slots[c]]]
        tangents, rolls, rigid = laws.tangents[f], laws.rolls[f], 1 if laws.normal[f] == 0 else 0
        for k in range(laws.rows[f] if friction != 0 else rigid):
            problem.rows[count], problem.mu[count], problem.between[count] = row + k, laws.mu[f], 0
            problem.kinds[count] = NORMAL if k == 0 else (LINE if tangents == 1 else FIRST + k - 1)
            if k > tangents + rolls:
                problem.mu[count], problem.between[count], problem.kinds[count] = (
                    laws.spinning[f],
                    k - 1,
                    LINE,
                )
            elif k > tangents:
                problem.mu[count], problem.between[count] = laws.rolling[f], k - 1
                problem.kinds[count] = LINE if rolls == 1 else FIRST + k - 1 - tangents
            contacts.owner[count], contacts.rebound[count] = c, laws.restitution[f] if k == 0 else 0.0
            problem.low[count] = 0.0
            if friction == 0:
                p = place_in_past(pairs, pairs.ids[c])
                if p >= 0 and pairs.stays[p] > OPENS:
                    problem.low[count] = -run.h * pairs.impulses[p, 0]
            count += 1
        row += laws.rows[f]
    problem.count = count


@compiled
def press_pairs(run: Run, t: float) -> None:
    """Set the normal forces of compliant pairs, N = max(N(d, d'), 0), whose rows are those of the problem.

    They are loads, with their power; no impulse is to be found along their normals, whose rows become 0.
    """
    contacts, problem, families, W = run.contacts, run.problem, run.families, run.W
    pairs, laws, blocks, given = families.pairs, families.laws, problem.blocks, families.laws.given
    size = run.machine.n_q + run.machine.n
    if run.machine.looped == 1:  # no kernel writes them
        run.pressing[0] = 0.0
        for i in range(run.machine.n):
            run.pressed[i] = 0.0
    for i in range(size if laws.compliant != 0 else 0):
        given[i] = run.z[i]
    for a in range(contacts.closed, problem.count):
        slot = pairs.slots[contacts.owner[a]]
        f = family_of(run, slot)
        if problem.kinds[a] != NORMAL or laws.normal[f] == 0:
            continue
        r, N, found = problem.rows[a], 0.0, pairs.found
        speed = rate(families, slot, pairs.touch[slot][1:])
        if pairs.depth[slot] > 0.0:
            given[size], given[size + 1] = pairs.depth[slot], -speed
            call(laws.normal[f], t, given, 0, laws.normal_c[laws.normal_at[f] :], found, 0)
            N = greater(found[0], 0.0)
        add(blocks, r, W, N, run.pressed)
        run.pressing[0] += N * speed
        for n in range(blocks.at[r], blocks.at[r + 1]):
            W[n] = 0.0
        problem.low[a] = N * run.h


@compiled
def pair_gap(run: Run, a: int) -> float:
    """Return the gap of the pair whose normal is row ``a`` of the problem."""
    pairs = run.families.pairs
    return pairs.touch[pairs.slots[run.contacts.owner[a]], 0]


@compiled
def pair_rate(run: Run, a: int) -> float:
    """Return the rate of the gap of the pair whose normal is row ``a`` of the problem."""
    slot = run.families.pairs.slots[run.contacts.owner[a]]
    return rate(run.families, slot, run.families.pairs.touch[slot][1:])


@compiled
def hang(run: Run, a: int) -> None:
    """Leave open, until the next step, the contact whose normal is row ``a`` of the problem."""
    contacts, pairs, e = run.contacts, run.families.pairs, run.contacts.owner[a]
    if a < contacts.closed:
        contacts.kept[e] = -contacts.kept[e]
    else:
        p = place_in_past(pairs, pairs.ids[e])
        pairs.stays[p] = -pairs.stays[p]


@compiled
def pressed(pairs: Pairs, c: int) -> int:
    """Return 1 if a pair, or the point of a patch, pressed in the step."""
    return 1 if place_in_past(pairs, pairs.ids[c]) >= 0 else 0


@compiled
def begin_pairs(run: Run) -> None:
    """Set the rates of the pairs at the beginning of the step, and the guess of their impulses."""
    contacts, problem, pairs, p, e, normal = run.contacts, run.problem, run.families.pairs, 0, 0, 0
    for a in range(contacts.closed, problem.count):
        c = contacts.owner[a]
        if problem.kinds[a] == NORMAL:
            normal = a
        k, tangents = a - normal, run.families.laws.tangents[family_of(run, pairs.slots[c])]
        contacts.before[a] = row_rate(run.families, pairs.slots[c], k)
        while p < pairs.known and pairs.past[p] < pairs.ids[c]:
            p += 1
        known = p < pairs.known and pairs.past[p] == pairs.ids[c]
        problem.x[a] = pairs.impulses[p, k] * (run.h / run.past[0]) if known else 0.0
        if run.families.laws.normal[family_of(run, pairs.slots[c])] != 0 and k <= tangents:
            problem.x[a] = problem.low[a] if k == 0 else (problem.x[a] if problem.low[normal] > 0.0 else 0.0)
        contacts.stays[a] = (abs(pairs.stays[p]) if k == 0 else pairs.stuck[p]) if known else OPENS
        while e < pairs.earlier and pairs.earlier_past[e] < pairs.ids[c]:
            e += 1
        earlier = pairs.alternates == 1 and e < pairs.earlier and pairs.earlier_past[e] == pairs.ids[c]
        if earlier and patched(run, pairs.slots[c]) == 1:
            problem.x[a] = pairs.earlier_impulses[e, k]
        if k > tangents or patched(run, pairs.slots[c]) == 1:  # a body stands on several points of a patch
            contacts.stays[a] = OPENS
        last = pairs.last[p if known else 0][2 * k :]
        contacts.half[a], contacts.turn[a] = turned(run, contacts.stays[a], last, contacts.before[a])


@compiled
def room_left(run: Run) -> int:
    """Return 1 if the log has room for another step."""
    return 1 if run.log_room - run.logged >= run.families.pairs.most else 0


@compiled
def log_pairs(run: Run) -> None:
    """Remember the impulses of the pairs that press, and write them to the log."""
    contacts, problem, pairs, laws = run.contacts, run.problem, run.families.pairs, run.families.laws
    pairs.alternates = alternates(run)
    pairs.earlier = pairs.known
    for p in range(pairs.known):
        pairs.earlier_past[p] = pairs.past[p]
        for k in range(3):
            pairs.earlier_impulses[p, k] = pairs.impulses[p, k]
    pairs.known = 0
    for a in range(contacts.closed, problem.count):
        if problem.kinds[a] == NORMAL and problem.x[a] > 0.0:
            c = contacts.owner[a]
            slot, p, entry = pairs.slots[c], pairs.known, run.log[run.logged]
            touch = pairs.touch[slot]
            f = family_of(run, slot)
            pairs.stays[p] = OPENS if laws.normal[f] != 0 else lasting(run, a)
            pairs.stuck[p] = sticking(run, a) if pairs.stays[p] != OPENS else OPENS
            pairs.past[p] = pairs.ids[c]
            tangents, rows = laws.tangents[f], laws.rows[f]
            for k in range(rows):
                pairs.impulses[p, k] = problem.x[a + k]
                pairs.last[p, 2 * k], pairs.last[p, 2 * k + 1] = after(run, a + k), contacts.half[a + k]
            entry[2] = 0.0
            for k in range(1 + tangents):
                entry[k] = problem.x[a + k] * stretch_of(run.families, f, k)
            entry[0] -= run.h * pairs.pull[c]
            entry[3] = mode(run, a)
            for i in range(3):
                entry[4 + i] = touch[1 + i] * entry[0] + touch[T + i] * entry[1] + touch[T + 3 + i] * entry[2]
                entry[7 + i], entry[12 + i] = touch[P + i], touch[Q + i]
            if rows > 1 + tangents:
                log_resistance(run, a, slot, entry[ENTRY:])
            elif run.resisted == 1:
                for i in range(RESISTED):
                    entry[ENTRY + i] = 0.0
            entry[10], entry[11] = pairs.first[slot], pairs.second[slot]
            pairs.known += 1
            run.logged += 1
    run.log_end[run.done] = run.logged


@compiled
def log_resistance(run: Run, a: int, slot: int, entry: Reals) -> None:
    """Write the impulses of the moments that resist rolling and spinning, and their modes; ``a`` is the normal row."""
    problem, f = run.problem, family_of(run, slot)
    rolls, first = run.families.laws.rolls[f], a + 1 + run.families.laws.tangents[f]
    for i in range(RESISTED):
        entry[i] = 0.0
    for k in range(rolls + run.families.laws.spins[f]):
        x, e = problem.x[first + k], axis(run.families, slot, first + k - a)
        entry[k if k < rolls else 2] = x
        for i in range(3):
            entry[3 + i] += x * e[i]
    if rolls > 0:
        entry[6] = slip(run, first)
    if run.families.laws.spins[f] > 0:
        entry[7] = slip(run, first + rolls)


@inlined
def family_of(run: Run, slot: int) -> int:
    """Return the number of the family of a pair."""
    return run.families.members.family[run.families.pairs.first[slot]]


@inlined
def rows_of(run: Run, slot: int) -> int:
    """Return the number of rows of a pair."""
    return run.families.laws.rows[family_of(run, slot)]


@compiled
def alternates(run: Run) -> int:
    """Return 1 if the normal impulses are nearer to those of the step before the last one than to the last ones.

    What flies between the ends of two steps lands in every second one. Only pairs that touch in patches are asked.
    """
    problem, pairs, p, e, last, earlier = run.problem, run.families.pairs, 0, 0, 0.0, 0.0
    for a in range(run.contacts.closed, problem.count):
        x, number = problem.x[a], pairs.ids[run.contacts.owner[a]]
        if problem.kinds[a] == NORMAL and x > 0.0 and patched(run, pairs.slots[run.contacts.owner[a]]) == 1:
            while p < pairs.known and pairs.past[p] < number:
                p += 1
            while e < pairs.earlier and pairs.earlier_past[e] < number:
                e += 1
            change = x - pairs.impulses[p, 0] if p < pairs.known and pairs.past[p] == number else x
            last += change * change
            change = x
            if e < pairs.earlier and pairs.earlier_past[e] == number:
                change = x - pairs.earlier_impulses[e, 0]
            earlier += change * change
    return 1 if earlier < last else 0


@compiled
def patched(run: Run, slot: int) -> int:
    """Return 1 if the members of a pair touch in a patch, whose points come and go."""
    families, pairs = run.families, run.families.pairs
    members, laws = families.members, families.laws
    i, j = pairs.first[slot], pairs.second[slot]
    return laws.patched[(members.family[i] * laws.kinds + members.kind[i]) * laws.kinds + members.kind[j]]


@compiled
def faced(run: Run) -> int:
    """Return 1 if most contacts of the problem are points of patches, whose forces are open."""
    contacts, problem, points = run.contacts, run.problem, 0
    for a in range(problem.count):
        if problem.kinds[a] == NORMAL:
            in_patch = a >= contacts.closed and patched(run, run.families.pairs.slots[contacts.owner[a]]) == 1
            points += 1 if in_patch else -1
    return 1 if points > 0 else 0


@compiled
def mode(run: Run, a: int) -> int:
    """Return the mode of the pressed contact whose normal is row ``a``: without friction it does not stick."""
    problem = run.problem
    tangent = a < problem.count - 1 and problem.kinds[a + 1] > NORMAL
    found = slip(run, a + 1) if tangent else STICK
    return SLIP if found == STICK and problem.mu[a] == 0.0 else found


@compiled
def sticking(run: Run, a: int) -> int:
    """Return how long the contact whose normal is row ``a``, which presses and stays closed, has stuck."""
    if mode(run, a) != STICK or a == run.problem.count - 1 or run.problem.kinds[a + 1] <= NORMAL:
        return OPENS
    return LANDED if run.contacts.stays[a + 1] == OPENS else STAYED


@compiled
def slip(run: Run, a: int) -> int:
    """Return the mode of a pressed contact whose tangents begin at row ``a``."""
    problem = run.problem
    still, v = negligible(run), problem.r[a]
    if problem.kinds[a] == LINE:
        return FORWARDS if v > still else (BACKWARDS if v < -still else STICK)
    w = problem.r[a + 1]
    return SLIP if v * v + w * w > still * still else STICK
