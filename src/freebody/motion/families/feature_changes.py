"""The moments at which patches change their features, as two functions of a motion by events.

    approach    least gap of the pairs that have no places now; it falls through zero where two solids meet
    kept        1 while the places of all other pairs hold, else -1

A patch is what :func:`freebody.motion.families.patches.measure` finds: only points with gaps up to a limit count, so
that far features may change unseen. The places of a pair hold while they have the features of all these points, and
each of them is such a point, unless its own gap is between half of that limit and its multiple `AWAY`.

At a tie, such as two faces that come to lie on each other, round-off would change the features back and forth. A place
that is kept there holds while it is near and within its sides: the foot of a corner in its face, a crossing between the
ends of both edges. If it is closed, it leaves at twice the distance outside a side at which places come
(`faces.BESIDE`), an open one as far inside, so that nothing closes where the solids only pass each other. It does no
harm: of two convex solids, what lies within the sides is apart. One that has left and come back at one moment leaves as
a closed one does: it stands at the end of its sides, and each correction of the state moves it by round-off.

An edge almost flat on a face crosses two of its sides, and the patch has one crossing at a time: two edges separate the
solids better than the face. One that has closed stays until it is far or at an end of its edges (`crosses`).

Round solids have one normal at each point, so that places of other features at a point of the patch, such as the end of
an edge, hold it as well, up to a distance of round-off (`SAME`) greater than that at which features change. Places
that the patch does not have hold as those of a tie do.
"""

from __future__ import annotations

from typing import Annotated, Any

from ...native.instructions import Integers, Reals, bits, compiled, greater, inlined, lesser, reals_at, root
from ...native.records import Count, Kernel, Record, Row, Wholes, record
from .faces import ALONG, BESIDE, CORNER, FACE, FAR, HEAD, NOWHERE, face_normal
from .family_record import POSE, Core, Families
from .nearest import outside
from .patches import measure
from .vectors import along, cross, vector

NEAR = 64
"""Size of a solid by the limit of the gaps that count."""
PARALLEL = 1e-9
"""Sine of the angle of two edges that meet below which their normal has lost half of its digits."""
ROUNDED = 1e-7
"""Depth, relative to the limit, beyond which a pair without places is no longer at a parallel pair of edges."""
SUNK = 1e-4
"""Depth, relative to the limit, beyond which solids have sunk into each other by no round-off."""
BAND, AWAY = 2.0 * BESIDE, 4.0
"""Distance outside a side, relative to the size, at which a closed place of a tie leaves; gap, relative to the limit,
at which any place leaves."""
CROSSES, ALTERNATES = 2, 3
"""Marks of a crossing that stays, and of a place that has come back at one moment."""
SAME, LEAST = 4.0 * ALONG, 1e-15
"""Distance of two points, relative to the size, up to which they are one; difference of gaps that are one."""


@record
class Followed(Record):
    """Patches that are followed, and the kernels that a function of the motion needs for it.

    ``first``, ``second``    members of each pair;  ``limit``: greatest gap that counts
    ``used``                 number of its places that have features, -1 while the pair is apart
    ``features``             four numbers of each place (`faces`), ``most`` places for a pair
    ``tied``                 1 for a place that is kept at a tie, or `CROSSES` or `ALTERNATES`
    ``contact``              its number among the contacts of the machine, whose modes are ``mode``, 0 for open
    ``result``               approach and kept;  ``normal``, ``point``, ``part``: of a place, and where on its edges
    ``poses``, ``poses_c``   kernel of the poses of the links, which stand in ``families``, and its constants
    ``values``, ``values_c`` kernel of the functions of the user, ``asked`` of them, and its constants
    """

    families: Families
    pairs: Count
    most: Count
    first: Annotated[Wholes, "pairs"]
    second: Annotated[Wholes, "pairs"]
    limit: Annotated[Row, "pairs"]
    used: Annotated[Wholes, "pairs"]
    features: Wholes
    tied: Wholes
    contact: Wholes
    mode: Wholes
    result: Annotated[Row, 2]
    normal: Annotated[Row, 3]
    point: Annotated[Row, 3]
    part: Annotated[Row, 2]
    poses: Kernel
    poses_c: Row
    asked: Count
    values: Kernel
    values_c: Row


@compiled
def follow(it: Followed) -> int:
    """Set approach and kept at the poses of the links; return the number of a pair whose features change, or -1."""
    of, changed = it.families, -1
    approach = 1.0
    for p in range(it.pairs):
        if it.used[p] < 0:
            gap = measure(of, it.first[p], it.second[p], 0.0)
            approach = lesser(approach, gap)
            if gap < -ROUNDED * it.limit[p]:
                changed = p
        elif kept(it, p) == 0:
            changed = p
    it.result[0], it.result[1] = approach, 1.0 if changed < 0 else -1.0
    return changed


@compiled
def kept(it: Followed, p: int) -> int:
    """Return 1 if the places of a pair hold at the poses of the links, else 0, as where one was passed over."""
    of, features = it.families, it.features[4 * it.most * p :]
    patch = of.patch
    if measure(of, it.first[p], it.second[p], FAR) < -SUNK * it.limit[p]:
        return 0
    for k in range(patch.count):
        one = patch.features[4 * k :]
        has_place = patch.points[k, 6] <= it.limit[p] and counts(it, k) != 0
        if has_place and among(one, features, it.used[p]) == 0 and met_by_others(it, p, k) == 0:
            return 0
    for k in range(it.used[p]):
        if holds(it, p, k) == 0:
            return 0
    return 1


@compiled
def counts(it: Followed, k: int) -> int:
    """Return 1 if a point of the patch that has been measured has a normal, else 0: edges that are parallel have none.

    Solids that leave each other over an edge pass such a moment.
    """
    one = it.families.patch.features[4 * k :]
    if one[1] == NOWHERE:
        return 0
    if one[1] < 0 or one[3] < 0:  # a face or a corner
        return 1
    a, b, n = it.families.one, it.families.other, it.normal
    p, q, r, s = edges(a, b, one)
    x, y, z = vector(p, q)
    u, v, w = vector(r, s)
    n[0], n[1], n[2] = cross(x, y, z, u, v, w)
    lengths = root((x * x + y * y + z * z) * (u * u + v * v + w * w))
    return 1 if root(along(n, n)) > PARALLEL * lengths else 0


@compiled
def holds(it: Followed, p: int, k: int) -> int:
    """Return 1 if a place is a point of the patch that has been measured, or may stay without being one, else 0."""
    patch, at = it.families.patch, it.most * p + k
    one = it.features[4 * at :]
    if among(one, patch.features, patch.count) == 1:
        return 1
    for point in range(patch.count):
        if is_point(it, at, point) == 1:
            return 1
    gap = gap_of(it, one)
    if 0.5 * it.limit[p] < gap <= AWAY * it.limit[p]:
        return 1
    stays = it.tied[at] != 0 or it.families.one.radius + it.families.other.radius > 0.0
    return 1 if stays and gap <= it.limit[p] and within(it, at) == 1 else 0


@compiled
def met_by_others(it: Followed, p: int, k: int) -> int:
    """Return 1 if a place with other features is at a point of the patch that has been measured, else 0."""
    for j in range(it.used[p]):
        if is_point(it, it.most * p + j, k) == 1:
            return 1
    return 0


@compiled
def is_point(it: Followed, at: int, k: int) -> int:
    """Return 1 if a place of round solids is at a point of the patch that has been measured, else 0.

    So is one whose features alternate with those of the point while both have one gap. Edges of cores that are nearly
    parallel cross to the square root of round-off, so that of round solids it may be anywhere.
    """
    of, one, near = it.families, it.features[4 * at :], SAME
    round_pair = of.one.radius + of.other.radius > 0.0
    if it.tied[at] == ALTERNATES and abs(gap_of(it, one) - of.patch.points[k, 6]) <= LEAST * of.patch.extent:
        if round_pair:
            return 1
        near = BAND
    elif not round_pair:
        return 0
    set_point(it, one)
    square = 0.0
    for j in range(3):
        square += (of.patch.points[k, j] - it.point[j]) * (of.patch.points[k, j] - it.point[j])
    return 1 if root(square) <= near * of.patch.extent else 0


@compiled
def within(it: Followed, at: int) -> int:
    """Return 1 if a place of a tie lies within its sides, whose cores are laid, else 0."""
    band = BAND * it.families.patch.extent
    passes = it.mode[it.contact[at]] == 0 and it.tied[at] != ALTERNATES
    if passes or it.tied[at] == CROSSES:
        band = -band
    return 1 if beside(it, it.features[4 * at :]) <= band else 0


@compiled
def crosses(it: Followed, at: int) -> int:
    """Return 1 if a place, whose cores are laid, is a crossing of edges that stays though the patch may not have it.

    It is near, away from the ends of both edges, and closed; or it stays since it was.
    """
    one, marked = it.features[4 * at :], it.tied[at] == CROSSES
    if one[1] < 0 or one[3] < 0 or it.families.one.radius + it.families.other.radius > 0.0:
        return 0
    if it.mode[it.contact[at]] == 0 and not marked:
        return 0
    near = gap_of(it, one) <= it.limit[at // it.most]
    return 1 if near and beside(it, one) <= -BAND * it.families.patch.extent else 0


@compiled
def among(one: Integers, others: Integers, count: int) -> int:
    """Return 1 if a feature is one of a list."""
    for k in range(count):
        equal = 1
        for j in range(4):
            if others[4 * k + j] != one[j]:
                equal = 0
        if equal == 1:
            return 1
    return 0


@compiled
def beside(it: Followed, one: Integers) -> float:
    """Return how far a place lies outside its sides, whose cores are laid; negative inside."""
    of = it.families
    a, b = of.one, of.other
    if one[1] == FACE:
        return outside_of(it, a, one[0], b, one[2])
    if one[3] == FACE:
        return outside_of(it, b, one[2], a, one[0])
    if meet(it, one) == 0:
        return FAR
    return greater(beyond(a, one, 0, it.part[0]), beyond(b, one, 2, it.part[1]))


@compiled
def outside_sides(it: Followed, at: int) -> float:
    """Return how far a place lies outside its sides, whose cores are laid."""
    return beside(it, it.features[4 * at :])


@compiled
def beyond(core: Core, one: Integers, at: int, part: float) -> float:
    """Return how far a point at a part of an edge lies outside it; a corner has no outside."""
    p, q, square = core.corners[3 * one[at] :], core.corners[3 * end_of(one, at) :], 0.0
    for k in range(3):
        square += (q[k] - p[k]) * (q[k] - p[k])
    return greater(-part, part - 1.0) * root(square) if square > 0.0 else -FAR


@compiled
def meet(it: Followed, one: Integers) -> int:
    """Set the parts along two edges, whose cores are laid, at which they are nearest; of a corner it is 0.

    Return 0 if they are parallel, else 1.
    """
    a, b = it.families.one, it.families.other
    p, q, r, s = edges(a, b, one)
    uu, uw, ww, ud, wd = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        u, w, d = q[k] - p[k], s[k] - r[k], r[k] - p[k]
        uu += u * u
        uw += u * w
        ww += w * w
        ud += u * d
        wd += w * d
    square, part = uu * ww - uw * uw, it.part
    part[0] = part[1] = 0.0
    if uu > 0.0 and ww > 0.0:
        if not square > 0.0:
            return 0
        part[0], part[1] = (ud * ww - wd * uw) / square, (ud * uw - wd * uu) / square
    elif uu > 0.0:
        part[0] = ud / uu
    elif ww > 0.0:
        part[1] = -wd / ww
    return 1


@compiled
def set_point(it: Followed, one: Integers) -> None:
    """Set the point of a place, in the middle between its nearest points; the cores are laid."""
    a, b, n = it.families.one, it.families.other, it.normal
    gap = gap_of(it, one)  # sets the normal, too
    shift = b.radius + 0.5 * gap  # from the core of the second body towards the first one
    if one[1] == FACE:
        for k in range(3):
            it.point[k] = b.corners[3 * one[2] + k] - shift * n[k]
    elif one[3] == FACE:
        for k in range(3):
            it.point[k] = a.corners[3 * one[0] + k] - (a.radius + 0.5 * gap) * n[k]
    else:
        meet(it, one)
        part, length = it.part, gap + a.radius + b.radius
        p, q, r, s = edges(a, b, one)
        for k in range(3):
            x, y = p[k] + part[0] * (q[k] - p[k]), r[k] + part[1] * (s[k] - r[k])
            it.point[k] = y + (shift * (x - y) / length if length != 0.0 else 0.0)


@compiled
def end_of(one: Integers, at: int) -> int:
    """Return the other corner of an edge; of a corner itself."""
    return one[at] if one[at + 1] == CORNER else one[at + 1]


@inlined
def edges(a: Core, b: Core, one: Integers) -> tuple[Reals, Reals, Reals, Reals]:
    """Return the ends of the two edges of a place; a corner is both ends of its own."""
    p, q = a.corners[3 * one[0] :], a.corners[3 * end_of(one, 0) :]
    r, s = b.corners[3 * one[2] :], b.corners[3 * end_of(one, 2) :]
    return p, q, r, s


@compiled
def outside_of(it: Followed, core: Core, face: int, other: Core, corner: int) -> float:
    """Return how far the foot of a corner lies outside the sides of a face."""
    mesh = it.families.members.mesh[core.mesh :]
    at, count = mesh[mesh[HEAD + face] :], mesh[HEAD + face + 1] - mesh[HEAD + face]
    face_normal(core, at, it.normal)
    return outside(core, at, count, it.normal, other.corners[3 * corner :])


@compiled
def gap_of(it: Followed, one: Integers) -> float:
    """Return the gap of a place, whose cores are laid."""
    of = it.families
    a, b = of.one, of.other
    both = a.radius + b.radius
    if one[1] == FACE:
        return over(it, a, one[0], b, one[2]) - both
    if one[3] == FACE:
        return over(it, b, one[2], a, one[0]) - both
    p, q, r, s = edges(a, b, one)
    n = it.normal
    x, y, z = vector(p, q)
    u, v, w = vector(r, s)
    if one[1] == CORNER or one[3] == CORNER:
        x, y, z = x + u, y + v, z + w  # of the edge, if there is one
        square, part = x * x + y * y + z * z, 0.0
        for k in range(3):
            n[k] = p[k] - r[k]
        if square > 0.0:
            part = (n[0] * x + n[1] * y + n[2] * z) / square
        n[0], n[1], n[2] = n[0] - part * x, n[1] - part * y, n[2] - part * z
        return root(along(n, n)) - both
    n[0], n[1], n[2] = cross(x, y, z, u, v, w)
    gap, points = (along(n, p) - along(n, r)) / root(along(n, n)), of.patch
    # an edge that is steep over a face crosses it on the side of the face, whatever the middles say
    towards = along(n, points.points[0][3:]) if points.count > 0 else along(n, a.middle) - along(n, b.middle)
    return (gap if towards >= 0.0 else -gap) - both


@compiled
def over(it: Followed, core: Core, face: int, other: Core, corner: int) -> float:
    """Return the height of a corner over a face."""
    mesh = it.families.members.mesh[core.mesh :]
    at = mesh[mesh[HEAD + face] :]
    face_normal(core, at, it.normal)
    return along(it.normal, other.corners[3 * corner :]) - along(it.normal, core.corners[3 * at[0] :])


@compiled
def values(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the functions of the user, then approach and kept: a kernel whose constant is an address."""
    it = Followed(reals_at(bits(c[0])))
    if it.asked > 0:
        it.values(t, y, it.values_c, out)
    it.poses(t, y, it.poses_c, it.families.links.poses[POSE:])
    follow(it)
    out[it.asked], out[it.asked + 1] = it.result[0], it.result[1]


def functions() -> dict[str, Any]:
    """Return the functions of this file as machine code."""
    from ...native.loop import made

    label = __name__.partition(".")[2]
    space = {
        "follow": follow,
        "values": values,
        "kept": kept,
        "counts": counts,
        "within": within,
        "crosses": crosses,
        "measure": measure,
        "outside": outside_sides,
    }
    return made(label, (label,), tuple(space), lambda: space, passes="few").functions
