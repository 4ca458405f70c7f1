"""The closed pairs of families at a configuration, g <= limit: geometry by the programs of pairs.

Pairs stand in ascending order of their members, whatever the order of the broad phase.
"""

from __future__ import annotations

from ...native.instructions import Integers, Reals, call, compiled, greater, hot, inlined, root
from .broad_phase import bounds, choose_axis, overlap, sort
from .faces import CORNER, FAR, NOWHERE
from .family_record import POINTS, POSE, TOUCH, Families, Members, Pairs
from .nearest import EDGES
from .patches import TILT, measure_cores, take_core
from .vectors import along, from_axes

P, Q, T = 4, 7, 10
"""Places in the geometry of a touch."""


@compiled
def seek(of: Families, t: float, y: Reals, limit: float) -> None:
    """Find the pairs whose gaps are at most ``limit`` at a state, or that stay closed.

    ``pairs.count`` beyond ``most``: there is no room for all.
    """
    find(of, t, y, limit)
    arrange(of.pairs)


@compiled
def find(of: Families, t: float, y: Reals, limit: float) -> None:
    """Do the same in any order."""
    links, members, pairs = of.links, of.members, of.pairs
    pairs.count, pairs.within = 0, limit
    if members.count == 0:
        return
    links.code(t, y, links.c, links.poses[POSE:])
    if members.bounded > 0:
        bounds(of, greater(limit, 0.0))
        choose_axis(members)
        sort(members)
    last = -1
    for p in range(pairs.known):
        both = pairs.past[p] // POINTS
        if pairs.stays[p] != 0 and both != last:
            last = both
            consider(of, both // members.count, both % members.count, limit, 1)
    order, axis = members.order, members.axis
    for a in range(members.bounded):
        i = order[a]
        end = members.upper[i, axis]
        for b in range(a + 1, members.bounded):
            j = order[b]
            if members.lower[j, axis] > end:
                break
            if overlap(members, i, j) == 1:
                consider(of, i, j, limit, 0)
    for a in range(members.unbounded):
        i = members.wide[a]
        for b in range(members.bounded):
            consider(of, i, order[b], limit, 0)
        for b in range(a + 1, members.unbounded):
            consider(of, i, members.wide[b], limit, 0)


@compiled
def nearer(of: Families, t: float, y: Reals, limit: float) -> None:
    """Leave of the pairs that `find` has found at a state those that `seek` finds with a lower limit.

    A patch of two edges is measured again, since ``patch.even`` may be greater now, and so is one with points beyond
    the limit only, since it may have others then.
    """
    links, members, pairs, kept, again, c = of.links, of.members, of.pairs, 0, 0, 0
    if members.count > 0:
        links.code(t, y, links.c, links.poses[POSE:])
    while c < pairs.count:
        both, apart, crossed, before = pairs.ids[c] // POINTS, pairs.apart[c], pairs.crossed[c], kept
        while c < pairs.count and pairs.ids[c] // POINTS == both:
            if crossed == 0 and (pairs.touch[c, 0] <= limit or stays(pairs, pairs.ids[c]) != 0):
                move(pairs, c, kept)
                kept += 1
            c += 1
        if kept == before and apart <= limit:
            pairs.again[again] = both
            again += 1
    pairs.count = kept
    for k in range(again):
        i, j = pairs.again[k] // members.count, pairs.again[k] % members.count
        consider(of, i, j, limit, any_stays(pairs, pairs.again[k]))
    arrange(pairs)


@compiled
def move(pairs: Pairs, c: int, k: int) -> None:
    """Move a pair to another place."""
    pairs.first[k], pairs.second[k], pairs.ids[k], pairs.slots[k] = (
        pairs.first[c],
        pairs.second[c],
        pairs.ids[c],
        k,
    )
    pairs.depth[k] = pairs.depth[c]
    for n in range(TOUCH):
        pairs.touch[k, n] = pairs.touch[c, n]


@compiled
def joined(members: Members, a: int, b: int) -> int:
    """Return 1 if two bodies do not touch: they are joined directly, or held apart."""
    for k in range(members.joined_at[a], members.joined_at[a + 1]):
        if members.joined[k] == b:
            return 1
    return 0


@compiled
def of_one_side(of: Families, i: int, j: int) -> int:
    """Return 1 if two members of a family stand on one body, or in one group that does not touch itself."""
    members, grouped = of.members, of.laws.grouped[of.members.family[i]]
    if members.body[i] == members.body[j]:
        return 1
    return 1 if grouped == 1 and members.group[i] == members.group[j] else 0


@inlined
def measure(of: Families, first: int, second: int, law: int) -> None:
    """Set what the law of a pair finds at the poses of its members, from their sizes."""
    members, links, given, k = of.members, of.links, of.pairs.given, 24
    for n in range(12):
        given[n] = links.poses[POSE * members.link[first] + n]
        given[12 + n] = links.poses[POSE * members.link[second] + n]
    for n in range(members.sizes_at[first], members.sizes_at[first + 1]):
        given[k] = members.sizes[n]
        k += 1
    for n in range(members.sizes_at[second], members.sizes_at[second + 1]):
        given[k] = members.sizes[n]
        k += 1
    call(of.laws.program[law], 0.0, given, 0, given, of.pairs.found, 0)


@hot
@compiled
def consider(of: Families, one: int, other: int, limit: float, closed: int) -> None:
    """Add a pair if its members may touch and its gap is at most ``limit``, or if it is ``closed`` and stays so.

    A pair that stays closed is added as such only.
    """
    members, laws, pairs = of.members, of.laws, of.pairs
    i, j = one, other
    if other < one:
        i, j = other, one
    f = members.family[i]
    if members.family[j] != f or of_one_side(of, i, j) == 1:
        return
    law = (f * laws.kinds + members.kind[i]) * laws.kinds + members.kind[j]
    if laws.program[law] == 0 or joined(members, members.body[i], members.body[j]) == 1:
        return
    first, second = i, j
    if laws.turned[law] == 1:
        first, second = j, i
    both = i * members.count + j
    if laws.patched[law] == 1:
        if closed == 1 or (is_above(of, first, second, limit) == 0 and any_stays(pairs, both) == 0):
            spread(of, first, second, both, limit, closed)
        return
    found = pairs.found
    measure(of, first, second, law)
    if closed == 0 and (not found[0] <= limit or stays(pairs, both * POINTS) != 0):
        return
    for n in range(laws.reaches[law]):
        if found[TOUCH - 2 + n] < 0.0:
            return
    slot = pairs.count
    pairs.count += 1
    if slot >= pairs.most:
        return
    if laws.directed[f] == 1:
        direct(of, second, found)
    elif laws.defined[law] == 0:
        turn(found, laws.up[3 * f :])
    pairs.first[slot], pairs.second[slot] = first, second
    pairs.ids[slot], pairs.slots[slot] = both * POINTS, slot
    pairs.crossed[slot] = 0
    pairs.apart[slot] = take(of, slot, found, found[0])


@compiled
def take(of: Families, slot: int, found: Reals, apart: float) -> float:
    """Keep the geometry of a pair; return its gap. Compliant ones have their depth beside it, and a gap of 0."""
    pairs = of.pairs
    for n in range(TOUCH):
        pairs.touch[slot, n] = found[n]
    pairs.depth[slot] = -found[0]
    if of.laws.normal[of.members.family[pairs.first[slot]]] == 0:
        return apart
    pairs.touch[slot, 0] = greater(found[0], 0.0)
    return greater(apart, 0.0)


@compiled
def first_in_past(pairs: Pairs, number: int) -> int:
    """Return the place of the first of those that pressed in the last step whose number is not less than this one."""
    first, end = 0, pairs.known
    while first < end:
        middle = (first + end) // 2
        if pairs.past[middle] < number:
            first = middle + 1
        else:
            end = middle
    return first


@compiled
def place_in_past(pairs: Pairs, number: int) -> int:
    """Return the place of a point among those that pressed in the last step, -1 if it did not."""
    p = first_in_past(pairs, number)
    return p if p < pairs.known and pairs.past[p] == number else -1


@compiled
def stays(pairs: Pairs, number: int) -> int:
    """Return how long a point has stayed closed; not 0: until its force vanishes, also where surfaces curve away."""
    p = place_in_past(pairs, number)
    return pairs.stays[p] if p >= 0 else 0


@compiled
def any_stays(pairs: Pairs, both: int) -> int:
    """Return 1 if any point of a pair stays closed, else 0."""
    p = first_in_past(pairs, both * POINTS)
    while p < pairs.known and pairs.past[p] // POINTS == both:
        if pairs.stays[p] != 0:
            return 1
        p += 1
    return 0


@compiled
def spread(of: Families, first: int, second: int, both: int, limit: float, closed: int) -> None:
    """Add the points of two solids whose gaps are at most ``limit``, and those that stay closed if one is ``closed``.

    A point on a face opens as soon as its solid turns about it, however far it is then (`curvature`).
    """
    take_core(of, of.one, first)
    if of.members.mesh[of.members.mesh_at[second]] > 0:
        take_core(of, of.other, second)
    tilt = TILT if closed == 1 and of.sharp == 0 else 0.0
    apart, count = measure_cores(of, second, FAR if closed == 1 else limit, tilt), of.pairs.count
    add_points(of, first, second, both, limit, apart)
    if closed == 1 and of.pairs.count == count and apart <= limit:  # of other points, as beside a face
        add_points(of, first, second, both, limit, measure_cores(of, second, limit, 0.0))


@compiled
def is_above(of: Families, first: int, second: int, limit: float) -> int:
    """Return 1 if the second member is a plane from which the bounds of the first one are farther than a limit."""
    members = of.members
    if members.mesh[members.mesh_at[second]] > 0:
        return 0
    pose, sizes, gap = (
        of.links.poses[POSE * members.link[second] :],
        members.sizes[members.sizes_at[second] :],
        0.0,
    )
    for i in range(3):
        n = from_axes(pose, i, sizes[3], sizes[4], sizes[5])
        x = members.lower[first, i] if n > 0.0 else members.upper[first, i]
        gap += n * (x - pose[9 + i] - from_axes(pose, i, sizes[0], sizes[1], sizes[2]))
    return 1 if gap > limit else 0


@compiled
def add_points(of: Families, first: int, second: int, both: int, limit: float, apart: float) -> None:
    """Add the points of the patch that has been measured whose gaps are at most ``limit``, or that stay closed."""
    pairs, patch, found = of.pairs, of.patch, of.pairs.found
    for p in range(patch.count):
        point, place = patch.points[p], both * POINTS + number(of, first, second, patch.features[4 * p :])
        if not point[6] <= limit and stays(pairs, place) == 0:
            continue
        slot = pairs.count
        pairs.count += 1
        if slot < pairs.most:
            found[0] = point[6]
            for n in range(3):
                found[1 + n], found[P + n], found[Q + n] = point[3 + n], point[n], point[n]
            if of.laws.directed[of.members.family[first]] == 1:
                direct(of, second, found)
            else:
                turn(found, of.laws.up[3 * of.members.family[first] :])
            pairs.first[slot], pairs.second[slot], pairs.ids[slot] = first, second, place
            pairs.slots[slot], pairs.apart[slot] = slot, take(of, slot, found, apart)
            pairs.crossed[slot] = 1 if patch.kind == EDGES else 0


@compiled
def number(of: Families, first: int, second: int, met: Integers) -> int:
    """Return the number of a point by the features that meet there: it keeps it while others come and go.

    Two pairs of edges of large solids may have the same number.
    """
    members = of.members
    a, b = members.mesh[members.mesh_at[first]], members.mesh[members.mesh_at[second]]
    if met[1] == CORNER:
        return met[0]
    if met[3] == CORNER:
        return a + met[2]
    if met[1] == NOWHERE:
        return POINTS - 1
    return a + b + (((met[0] * a + met[1]) * b + met[2]) * b + met[3]) % (POINTS - 1 - a - b)


@compiled
def turn(found: Reals, up: Reals) -> None:
    """Set the tangents to the axes at right angles to ``up``, turned with it, or with its opposite, to n the short way.

    Source: Duff and others, Journal of Computer Graphics Techniques 6 (2017).
    """
    k = 0 if up[0] != 0.0 else (1 if up[1] != 0.0 else 2)
    a, b = (k + 1) % 3, (k + 2) % 3
    x, y, z = found[1 + a], found[1 + b], found[1 + k]
    s = 1.0 if z >= 0.0 else -1.0
    share = 1.0 / (1.0 + s * z)
    found[T + a], found[T + b], found[T + k] = 1.0 - x * x * share, -x * y * share, -s * x
    found[T + 3 + a], found[T + 3 + b], found[T + 3 + k] = -s * (x * y * share), s * (1.0 - y * y * share), -y


@compiled
def direct(of: Families, second: int, found: Reals) -> None:
    """Set the tangents to the direction of friction of the second member, in its surface, and to n × t1."""
    d, R = of.laws.along[3 * of.members.family[second] :], of.links.poses[POSE * of.members.link[second] :]
    n, t = found[1:], found[T:]
    for i in range(3):
        t[i] = from_axes(R, i, d[0], d[1], d[2])
    across = along(t, n)
    for i in range(3):
        t[i] -= across * n[i]
    size = root(along(t, t))
    for i in range(3):
        t[i] /= size
    for i in range(3):
        t[3 + i] = n[(i + 1) % 3] * t[(i + 2) % 3] - n[(i + 2) % 3] * t[(i + 1) % 3]


@compiled
def arrange(pairs: Pairs) -> None:
    """Sort the pairs by their ids (Shell's method)."""
    pairs.within = -1.0
    if pairs.count > pairs.most:
        return
    step = 1
    while 3 * step + 1 < pairs.count:
        step = 3 * step + 1
    while step > 0:
        for k in range(step, pairs.count):
            number, slot, a = pairs.ids[k], pairs.slots[k], k
            while a >= step and pairs.ids[a - step] > number:
                pairs.ids[a], pairs.slots[a] = pairs.ids[a - step], pairs.slots[a - step]
                a -= step
            pairs.ids[a], pairs.slots[a] = number, slot
        step //= 3
