"""The points of a patch in which a face carries, and the features of both solids that meet at each.

The face of the other core that looks most against the face is a polygon, which the sides of the face cut. A corner of
what is left is a corner of the other core over the face, a corner of the face under that of the other core, or a
crossing of two edges. It is known by its features: for each core a corner, a face, or the two corners of an edge.

Source: I. E. Sutherland, G. W. Hodgman, Reentrant polygon clipping, Comm. ACM 17 (1974) 32-42.
"""

from __future__ import annotations

from ...native.instructions import Integers, Reals, compiled, greater, root
from .family_record import Core, Families, Patch
from .vectors import along, cross, vector

ALONG = 1e-11
"""Distance, relative to the size of a solid, that is round-off."""
BESIDE = 1e-8
"""Distance outside a side of a face, relative to the size, up to which a corner carries: bricks of one width on each
other. Edges that cross are then so far from parallel that their common normal keeps half of its digits."""
FAR = 1e300
HEAD = 3
CORNER, FACE, NOWHERE = -1, -2, -3
"""Second number of a feature that is a corner or a face; of an edge it is the greater corner. A point that is only the
deepest corner has no features."""


@compiled
def face_normal(core: Core, face: Integers, n: Reals) -> None:
    """Set the outward unit normal of a face, whose corners are given."""
    p, q, s = core.corners[3 * face[0] :], core.corners[3 * face[1] :], core.corners[3 * face[2] :]
    a, b, c = vector(p, q)
    d, e, f = vector(p, s)
    n[0], n[1], n[2] = cross(a, b, c, d, e, f)
    length = root(along(n, n))
    for j in range(3):
        n[j] /= length


@compiled
def add_point(patch: Patch, x: Reals, gap: float, sign: float) -> None:
    """Add a point, at the features ``met``; ``sign`` times the normal points from the second body to the first one."""
    if patch.count < patch.most:
        point = patch.points[patch.count]
        point[6] = gap
        for k in range(3):
            point[k], point[3 + k] = x[k], sign * patch.normal[k]
        for k in range(4):
            patch.features[4 * patch.count + k] = patch.met[k]
        patch.count += 1


@compiled
def meet_edge(met: Integers, at: int, one: int, other: int) -> None:
    """Write a feature: the edge between two corners."""
    met[at], met[at + 1] = one, other
    if other < one:
        met[at], met[at + 1] = other, one


@compiled
def cut(of: Families, core: Core, other: Core, limit: float, sign: float) -> None:
    """Set the points of the other core over the face of a core that is nearest to it."""
    patch, n = of.patch, of.patch.normal
    mesh = of.members.mesh[core.mesh :]
    face = mesh[mesh[HEAD + patch.face] :]
    sides = mesh[HEAD + patch.face + 1] - mesh[HEAD + patch.face]
    normal = core.normals[3 * patch.face :]
    for j in range(3):
        n[j] = normal[j]
    count = towards(of, other, patch)
    for k in range(sides):
        p, q = core.corners[3 * face[k] :], core.corners[3 * face[(k + 1) % sides] :]
        x, y, z = vector(p, q)
        m = patch.trial
        m[0], m[1], m[2] = cross(x, y, z, n[0], n[1], n[2])
        count = cut_side(patch, count, p, m, k)
    p = core.corners[3 * face[0] :]
    height, r = along(n, p), core.radius + other.radius
    for v in range(count):
        x_v = patch.polygon[3 * v :]
        gap = along(n, x_v) - height - r
        if gap <= limit:
            meet_features(of, core, other, (v + count - 1) % count, v, sign)
            for k in range(3):
                patch.trial[k] = x_v[k] - (other.radius + 0.5 * gap) * n[k]
            add_point(patch, patch.trial, gap, sign)
    if patch.count == 0 and (r == 0.0 or patch.apart <= 0.0):
        deepest(of, core, other, height, limit, sign)


@compiled
def deepest(of: Families, core: Core, other: Core, height: float, limit: float, sign: float) -> None:
    """Set the deepest corner, which is beside the face: two edges are parallel there up to round-off."""
    patch, n, best = of.patch, of.patch.normal, FAR
    for v in range(other.count):
        x_v = other.corners[3 * v :]
        if along(n, x_v) < best:
            best = along(n, x_v)
            for k in range(3):
                patch.pair[k] = x_v[k]
    gap = best - height - core.radius - other.radius
    if gap <= limit and best <= height:
        for k in range(3):
            patch.trial[k] = patch.pair[k] - (other.radius + 0.5 * gap) * n[k]
        for k in range(4):
            patch.met[k] = NOWHERE
        add_point(patch, patch.trial, gap, sign)


@compiled
def meet_features(of: Families, core: Core, other: Core, before: int, v: int, sign: float) -> None:
    """Write the features that meet at a corner of the polygon: of the first core, then of the second one."""
    patch, met = of.patch, of.patch.met
    mesh, own = of.members.mesh[core.mesh :], 0 if sign < 0.0 else 2
    face = mesh[mesh[HEAD + patch.face] :]
    sides = mesh[HEAD + patch.face + 1] - mesh[HEAD + patch.face]
    into, out = patch.tags[2 * before + 1], patch.tags[2 * v + 1]
    if patch.tags[2 * v] >= 0:  # a corner of the other core
        met[own], met[own + 1] = patch.face, FACE
        met[2 - own], met[3 - own] = patch.tags[2 * v], CORNER
    elif patch.towards < 0:
        k = -2 - patch.tags[2 * v]
        meet_edge(met, own, face[k], face[(k + 1) % sides])
        meet_edge(met, 2 - own, 0, 1)
    elif into < 0 and out < 0:  # a corner of the face
        best, chosen, x_v = FAR, 0, patch.polygon[3 * v :]
        for k in range(sides):
            c, square = core.corners[3 * face[k] :], 0.0
            for j in range(3):
                square += (c[j] - x_v[j]) * (c[j] - x_v[j])
            if square < best:
                best, chosen = square, face[k]
        met[own], met[own + 1] = chosen, CORNER
        met[2 - own], met[3 - own] = patch.towards, FACE
    else:
        side, edge, polygon = into, out, of.members.mesh[other.mesh :]
        if into >= 0:
            side, edge = out, into
        k = -1 - side
        meet_edge(met, own, face[k], face[(k + 1) % sides])
        first = polygon[HEAD + patch.towards]
        corners = polygon[HEAD + patch.towards + 1] - first
        meet_edge(met, 2 - own, polygon[first + edge], polygon[first + (edge + 1) % corners])


@compiled
def towards(of: Families, core: Core, patch: Patch) -> int:
    """Set the polygon to the face of a core that looks most against the normal; return the number of its corners.

    A core without faces gives its corners.
    """
    mesh, best, chosen = of.members.mesh[core.mesh :], FAR, -1
    for f in range(mesh[1]):
        x = along(patch.normal, core.normals[3 * f :])
        if x < best:
            best, chosen = x, f
    count, patch.towards = core.count, chosen
    if chosen >= 0:
        count = mesh[HEAD + chosen + 1] - mesh[HEAD + chosen]
    for k in range(count):
        corner = k
        if chosen >= 0:
            corner = mesh[mesh[HEAD + chosen] + k]
        patch.tags[2 * k], patch.tags[2 * k + 1] = corner, k
        for j in range(3):
            patch.polygon[3 * k + j] = core.corners[3 * corner + j]
    return count


@compiled
def cut_side(patch: Patch, count: int, p: Reals, m: Reals, side: int) -> int:
    """Cut the polygon at the plane through p at right angles to m, which points out of it; return what is left.

    A corner has two tags: its number in the other core (-1 of a crossing, -2 - k of side k with an edge alone), and the
    edge from it to the next corner: its number among those of the uncut polygon, or -1 - k for side k of the face.
    """
    slack = (
        (ALONG if count == 1 else BESIDE) * patch.extent * root(along(m, m))
    )  # a ball: its normal turns there
    height, kept, tags, rest, heights = along(m, p), 0, patch.tags, patch.rest_tags, patch.heights
    most = -FAR
    for k in range(count):
        heights[k] = along(m, patch.polygon[3 * k :]) - height
        most = greater(most, heights[k])
    if most <= slack:
        return count
    for k in range(count):
        last = (k + count - 1) % count
        x, before, here, there = patch.polygon[3 * k :], patch.polygon[3 * last :], heights[k], heights[last]
        open_end = 1 if count < 3 and k == 0 else 0
        if open_end == 0 and ((here > slack and there < -slack) or (here < -slack and there > slack)):
            part = there / (there - here)
            for j in range(3):
                patch.rest[3 * kept + j] = before[j] + part * (x[j] - before[j])
            rest[2 * kept] = CORNER if patch.towards >= 0 else -2 - side
            rest[2 * kept + 1] = -1 - side if here > slack else tags[2 * last + 1]
            kept += 1
        if here <= slack:
            for j in range(3):
                patch.rest[3 * kept + j] = x[j]
            rest[2 * kept], rest[2 * kept + 1] = tags[2 * k], tags[2 * k + 1]
            if here >= -slack and heights[(k + 1) % count] > slack:  # what follows runs along the side
                rest[2 * kept + 1] = -1 - side
            kept += 1
    for k in range(3 * kept):
        patch.polygon[k] = patch.rest[k]
    for k in range(2 * kept):
        tags[k] = rest[k]
    return kept
