"""The moments at which patches change their features, as two functions of a motion by events.

    approach    least gap of the pairs that have no places now; it falls through zero where two solids meet
    kept        1 while the places of all other pairs are those of their patches, else -1

A patch is what :func:`freebody.motion.families.patches.measure` finds: only points with gaps up to a limit count, so
that far features may change unseen. A place counts while its own gap is within half of that limit, for then its
feature must be one of the patch.
"""

from __future__ import annotations

from typing import Annotated, Any

from ...native.instructions import (
    Integers,
    Reals,
    bits,
    call,
    compiled,
    lesser,
    reals_at,
    root,
    run_by,
    shifted,
)
from ...native.records import Count, Record, Row, Wholes, record
from .faces import FACE, FAR, HEAD, NOWHERE, along, face_normal
from .family_record import POSE, Core, Families
from .patches import measure

NEAR = 64
"""Size of a solid by the limit of the gaps that count."""
ROUNDED = 1e-7
"""Depth, relative to the limit, beyond which a pair without places is no longer at a parallel pair of edges."""
(RUN, RECORD, RESULT, POSES, POSES_TO, VALUES, VALUES_AT, COUNT, OWN_AT) = range(9)
"""Numbers before the constants of the kernel :func:`values`: addresses of `follow`, of its record, of its result, of
the kernel of poses and its outputs, of the kernel of the user's functions; first of their constants, their number, and
first of the constants of poses."""


@record
class Followed(Record):
    """Patches that are followed.

    ``first``, ``second``    members of each pair;  ``limit``: greatest gap that counts
    ``used``                 number of its places that have features, -1 while the pair is apart
    ``features``             four numbers of each place (`faces`), ``most`` places for a pair
    ``result``               approach and kept;  ``normal``: a vector
    """

    families: Families
    pairs: Count
    most: Count
    first: Annotated[Wholes, "pairs"]
    second: Annotated[Wholes, "pairs"]
    limit: Annotated[Row, "pairs"]
    used: Annotated[Wholes, "pairs"]
    features: Wholes
    result: Annotated[Row, 2]
    normal: Annotated[Row, 3]


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
        else:
            measure(of, it.first[p], it.second[p], FAR)
            if same(it, p) == 0:
                changed = p
    it.result[0], it.result[1] = approach, 1.0 if changed < 0 else -1.0
    return changed


@compiled
def same(it: Followed, p: int) -> int:
    """Return 1 if the places of a pair are the points of its patch, as far as they are near; else 0."""
    of, features = it.families, it.features[4 * it.most * p :]
    patch = of.patch
    for k in range(patch.count):
        one = patch.features[4 * k :]
        if patch.points[k, 6] <= it.limit[p] and one[1] != NOWHERE and among(one, features, it.used[p]) == 0:
            return 0
    for k in range(it.used[p]):
        one = features[4 * k :]
        if among(one, patch.features, patch.count) == 0 and not gap_of(it, one) > 0.5 * it.limit[p]:
            return 0
    return 1


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
def gap_of(it: Followed, one: Integers) -> float:
    """Return the gap of a place, whose cores are laid."""
    of = it.families
    a, b = of.one, of.other
    if one[1] == FACE:
        return over(it, a, one[0], b, one[2])
    if one[3] == FACE:
        return over(it, b, one[2], a, one[0])
    p, q, r, s, n = (
        a.corners[3 * one[0] :],
        a.corners[3 * one[1] :],
        b.corners[3 * one[2] :],
        b.corners[3 * one[3] :],
        it.normal,
    )
    x, y, z, u, v, w = q[0] - p[0], q[1] - p[1], q[2] - p[2], s[0] - r[0], s[1] - r[1], s[2] - r[2]
    n[0], n[1], n[2] = y * w - z * v, z * u - x * w, x * v - y * u
    gap = (along(n, p) - along(n, r)) / root(along(n, n))
    return gap if along(n, a.middle) > along(n, b.middle) else -gap


@compiled
def over(it: Followed, core: Core, face: int, other: Core, corner: int) -> float:
    """Return the height of a corner over a face."""
    mesh = it.families.members.mesh[core.mesh :]
    at = mesh[mesh[HEAD + face] :]
    face_normal(core, at, it.normal)
    return along(it.normal, other.corners[3 * corner :]) - along(it.normal, core.corners[3 * at[0] :])


@compiled
def values(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """Set ``out`` to the functions of the user, then approach and kept: a kernel."""
    count, result = bits(c[COUNT]), reals_at(bits(c[RESULT]))
    if bits(c[VALUES]) != 0:
        call(bits(c[VALUES]), t, y, 0, shifted(c, bits(c[VALUES_AT])), out, 0)
    call(bits(c[POSES]), t, y, 0, shifted(c, bits(c[OWN_AT])), reals_at(bits(c[POSES_TO])), POSE)
    run_by(bits(c[RUN]), reals_at(bits(c[RECORD])))
    out[count], out[count + 1] = result[0], result[1]


def functions() -> dict[str, Any]:
    """Return the functions of this file as machine code."""
    from ...native.loop import made

    label = __name__.partition(".")[2]
    space = {"follow": follow, "values": values, "measure": measure}
    return made(label, (label,), tuple(space), lambda: space, short=True).functions
