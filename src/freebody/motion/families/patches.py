"""The patch in which two convex solids touch: points with a common normal, and a gap at each.

A solid is a core, the convex hull of its corners, rounded by a radius; a sphere is a core of one corner, a point has
the radius 0. Two cores that overlap are separated the least along a normal of a face, or across an edge of each:

    g = max over n of  (min over w of B  n·w - max over v of A  n·v) - r_A - r_B,      n: face normals, a × b of edges

and g is the distance of their nearest features where they are apart (:func:`nearest`). If n is the normal of a face,
the face of the other core that looks towards it is cut by its sides (`faces`): the corners over it and the edge
crossings carry, each with a gap of its own. Else solids touch at one point of their nearest edges or corners, and round
ones at the ends of what two parallel edges have in common. Both bodies are pressed at one point, so that the forces of
a pair are opposite in every sense.

Source: S. Gottschalk, M. C. Lin, D. Manocha, OBBTree, SIGGRAPH (1996), for the axes.
"""

from __future__ import annotations

from ...native.instructions import Reals, compiled, greater, hot, inlined, lesser, root
from .faces import ALONG, CORNER, FACE, FAR, HEAD, NOWHERE, add_point, cut, face_normal
from .family_record import POSE, SOLID, Core, Families, Patch
from .nearest import (
    EDGES,
    FACE_OF_A,
    FACE_OF_B,
    PARALLEL,
    across_pair,
    between,
    crossing,
    least,
    least_beyond,
    nearest,
    nearest_edges,
    round_points,
)
from .vectors import along, cross, vector

TILT = 1e-4
"""Length, relative to the size, by which two edges may separate better than a face that is taken for them where points
stay closed: what a solid sinks at an end of a face, as it turns about the points that it stands on, in half a step."""


@compiled
def lay_core(of: Families, core: Core, k: int) -> None:
    """Set the corners of a member in ground axes, and the normals of its faces."""
    members = of.members
    pose, sizes = of.links.poses[POSE * members.link[k] :], members.sizes[members.sizes_at[k] :]
    begin_core(of, core, k)
    for j in range(3):
        core.middle[j] = 0.0
    for v in range(core.count):
        x, y, z = sizes[3 * v], sizes[3 * v + 1], sizes[3 * v + 2]
        for j in range(3):
            core.corners[3 * v + j] = (
                pose[9 + j] + pose[3 * j] * x + pose[3 * j + 1] * y + pose[3 * j + 2] * z
            )
            core.middle[j] += core.corners[3 * v + j] / core.count
    mesh = members.mesh[core.mesh :]
    for face in range(mesh[1]):
        face_normal(core, mesh[mesh[HEAD + face] :], core.normals[3 * face :])


@inlined
def begin_core(of: Families, core: Core, k: int) -> None:
    """Set what does not move."""
    members = of.members
    core.mesh = members.mesh_at[k]
    core.count, core.radius = members.mesh[core.mesh], members.radius[k]


@compiled
def keep_core(of: Families, core: Core, k: int) -> None:
    """Keep the core of a member for this search."""
    members = of.members
    corners, normals = members.corners[members.sizes_at[k] :], members.normals[members.normals_at[k] :]
    for j in range(3 * core.count):
        corners[j] = core.corners[j]
    for j in range(members.normals_at[k + 1] - members.normals_at[k]):
        normals[j] = core.normals[j]
    for j in range(3):
        members.middles[k, j] = core.middle[j]


@hot
@compiled
def take_core(of: Families, core: Core, k: int) -> None:
    """Set a core to that of a member in this search."""
    members = of.members
    if members.bound[k] != SOLID:
        lay_core(of, core, k)
        return
    begin_core(of, core, k)
    corners, normals = members.corners[members.sizes_at[k] :], members.normals[members.normals_at[k] :]
    for j in range(3 * core.count):
        core.corners[j] = corners[j]
    for j in range(members.normals_at[k + 1] - members.normals_at[k]):
        core.normals[j] = normals[j]
    for j in range(3):
        core.middle[j] = members.middles[k, j]


@compiled
def ahead(core: Core, faces: int, other: Core) -> int:
    """Return the face that looks most towards the other core, the likeliest one to separate them; without faces 0."""
    d, best, chosen = other.middle, -FAR, 0
    for f in range(faces):
        n = core.normals[3 * f :]
        x = along(n, d) - along(n, core.middle)
        if x > best:
            best, chosen = x, f
    return chosen


@compiled
def by_faces(of: Families, core: Core, other: Core, which: int, patch: Patch) -> None:
    """Try the face normals of a core, which point from it to the other one.

    One of the second core is taken only where it is better by more than round-off, so that a patch of two equal faces
    has the same points in every step. A face that one corner shows to separate less than the likeliest one is passed.
    """
    mesh = of.members.mesh[core.mesh :]
    if mesh[1] == 0:
        return
    bar, likely = ALONG * patch.extent if which == FACE_OF_B else 0.0, ahead(core, mesh[1], other)
    n = core.normals[3 * likely :]
    floor = least(other, n) - along(n, core.corners[3 * mesh[mesh[HEAD + likely]] :])
    for f in range(mesh[1]):
        n = core.normals[3 * f :]
        height = along(n, core.corners[3 * mesh[mesh[HEAD + f]] :])
        apart = least_beyond(other, n, height, greater(floor, patch.apart + bar)) - height
        if apart > patch.apart + bar and apart >= floor:
            patch.apart, patch.kind, patch.face, bar = apart, which, f, 0.0
            for j in range(3):
                patch.normal[j] = n[j]


@compiled
def by_edges(of: Families, a: Core, b: Core, patch: Patch) -> None:
    """Try the normals across an edge of each core, from the first one to the second.

    A face is taken where both are equal up to round-off.
    """
    one, other, n = of.members.mesh[a.mesh :], of.members.mesh[b.mesh :], patch.trial
    edges, edges_b = one[one[HEAD - 1] :], other[other[HEAD - 1] :]
    best, top, low = (
        patch.apart + ALONG * patch.extent,
        corner(a, foremost(a, patch.normal, 1.0)),
        corner(b, foremost(b, patch.normal, -1.0)),
    )
    tail, high = corner(a, farthest(a, top)), corner(b, farthest(b, low))
    d_x, d_y, d_z = vector(a.middle, b.middle)
    for i in range(edges[1]):
        p, q = a.corners[3 * edges[2 + 2 * i] :], a.corners[3 * edges[3 + 2 * i] :]
        x, y, z = vector(p, q)
        for j in range(edges_b[1]):
            r, s = b.corners[3 * edges_b[2 + 2 * j] :], b.corners[3 * edges_b[3 + 2 * j] :]
            u, v, w = vector(r, s)
            n_x, n_y, n_z = cross(x, y, z, u, v, w)
            square = n_x * n_x + n_y * n_y + n_z * n_z
            towards = n_x * d_x + n_y * d_y + n_z * d_z
            if towards < 0.0:
                n_x, n_y, n_z = -n_x, -n_y, -n_z
            n[0], n[1], n[2] = n_x, n_y, n_z
            apart = lesser(along(n, low), along(n, high)) - greater(along(n, top), along(n, tail))
            if beyond(apart, best, square) == 1 and square > PARALLEL * (x * x + y * y + z * z) * (
                u * u + v * v + w * w
            ):
                length = root(square)
                n[0], n[1], n[2] = n_x / length, n_y / length, n_z / length
                height = along(n, top)
                apart = least_beyond(b, n, height, best)
                if apart - height > best:
                    for k in range(3):
                        n[k] = -n[k]
                    apart += least(a, n)
                    if apart > best:
                        best = patch.apart = apart
                        patch.kind = EDGES
                        for k in range(3):
                            patch.normal[k] = -n[k]


@inlined
def corner(core: Core, v: int) -> Reals:
    """Return the place of a corner."""
    return core.corners[3 * v :]


@compiled
def farthest(core: Core, x: Reals) -> int:
    """Return the corner that is farthest from a point."""
    best, chosen = -1.0, 0
    for v in range(core.count):
        a, b, c = vector(x, core.corners[3 * v :])
        square = a * a + b * b + c * c
        if square > best:
            best, chosen = square, v
    return chosen


@inlined
def beyond(apart: float, best: float, square: float) -> int:
    """Return 0 if apart/√square <= best, for corners that thus show that a normal separates less; else 1."""
    far = apart * apart - best * best * square
    return 1 if (apart > 0.0 and (best < 0.0 or far > 0.0)) or (best < 0.0 and far < 0.0) else 0


@compiled
def foremost(core: Core, n: Reals, sign: float) -> int:
    """Return the corner that is farthest along n, or against it if ``sign`` is -1."""
    best, chosen = -FAR, 0
    for v in range(core.count):
        x = sign * along(n, core.corners[3 * v :])
        if x > best:
            best, chosen = x, v
    return chosen


# -- points ----------------------------------------------------------------------------------------------


@compiled
def measure(of: Families, first: int, second: int, limit: float) -> float:
    """Return the gap of two members, and set the points of their patch with gaps up to ``limit``.

    Beyond the limit the gap is a lower bound: that of the best of the axes.
    """
    lay_core(of, of.one, first)
    if of.members.mesh[of.members.mesh_at[second]] > 0:
        lay_core(of, of.other, second)
    return measure_cores(of, second, limit, 0.0)


@compiled
def measure_cores(of: Families, second: int, limit: float, tilt: float) -> float:
    """Do the same where the cores are set, with ``tilt`` = `TILT` for points that stay closed in time steps.

    These stay on their face though the edges of it that sink separate the cores better: of a solid that rocks by turns
    on two points each would be found alone, and the other one fall, for ever.
    """
    a, b, patch = of.one, of.other, of.patch
    patch.count = 0
    if of.members.mesh[of.members.mesh_at[second]] == 0:
        return over_plane(of, second, limit)
    r = a.radius + b.radius
    faces = of.members.mesh[a.mesh + 1] + of.members.mesh[b.mesh + 1]
    patch.apart, patch.kind, patch.extent = -FAR, EDGES, 0.0
    for j in range(3):
        patch.extent = greater(patch.extent, abs(a.corners[j] - a.middle[j]))
        patch.extent = greater(patch.extent, abs(b.corners[j] - b.middle[j]))
        patch.normal[j] = 0.0
    patch.normal[2] = 1.0
    by_faces(of, a, b, FACE_OF_A, patch)
    if patch.apart > limit + r:
        return patch.apart - r
    by_faces(of, b, a, FACE_OF_B, patch)
    if patch.apart > limit + r:
        return patch.apart - r
    flat, wall, even = patch.apart, patch.kind, greater(patch.even, tilt * patch.extent)
    by_edges(of, a, b, patch)
    if patch.apart > limit + r:
        return patch.apart - r
    if patch.kind == EDGES and flat > patch.apart - even and almost_flat(of, wall, limit, even) == 1:
        return patch.apart - r
    if faces == 0 or patch.apart > 0.0:
        far = 2.0 * (limit + r) + patch.extent * ALONG if faces > 0 and limit < FAR else FAR
        nearest(of, a, b, flat, wall, patch, far)
    elif patch.kind == EDGES:
        crossing(of, a, b, patch)
    if patch.apart > limit + r:
        return patch.apart - r
    if patch.kind == FACE_OF_A:
        cut(of, a, b, limit, -1.0)
    elif patch.kind == FACE_OF_B:
        cut(of, b, a, limit, 1.0)
    if r > 0.0 and patch.apart > 0.0 and patch.kind != EDGES and touches_face(patch, r) == 0:
        patch.count = 0
        across_pair(patch, nearest_edges(of, a, b, patch, FAR))
    if patch.kind == EDGES:
        if r > 0.0:
            round_points(a, b, patch)
        else:
            between(patch, a, b)
    return patch.apart - r


@compiled
def touches_face(patch: Patch, r: float) -> int:
    """Return 1 if the nearest point of round solids is one over the face; 0 if it is beside by more than round-off."""
    best = FAR
    for k in range(patch.count):
        best = lesser(best, patch.points[k, 6])
    return 1 if best <= patch.apart - r + 2.0 * ALONG * patch.extent else 0


@compiled
def almost_flat(of: Families, wall: int, limit: float, even: float) -> int:
    """Take the face for two edges that separate the cores a little better, if it has a point about as deep as theirs.

    Return 1 if so, else 0. The gap of the edges is 0 together with that of their crossing over the face. A correction
    that lifted the crossing alone would press the points beside it into each other.
    """
    a, b, patch = of.one, of.other, of.patch
    gap, best = patch.apart - a.radius - b.radius, FAR
    x, y, z = patch.normal[0], patch.normal[1], patch.normal[2]
    if wall == FACE_OF_A:
        cut(of, a, b, limit, -1.0)
    elif wall == FACE_OF_B:
        cut(of, b, a, limit, 1.0)
    for k in range(patch.count):
        best = lesser(best, patch.points[k][6])
    if best <= (0.5 * gap if gap < 0.0 else gap + even) and patch.met[0] != NOWHERE:
        return 1
    patch.count, patch.normal[0], patch.normal[1], patch.normal[2] = 0, x, y, z
    return 0


@compiled
def over_plane(of: Families, plane: int, limit: float) -> float:
    """Return the gap of the first core over a plane, and set its corners with gaps up to ``limit``."""
    a, patch, members = of.one, of.patch, of.members
    pose, sizes, n, best = (
        of.links.poses[POSE * members.link[plane] :],
        members.sizes[members.sizes_at[plane] :],
        patch.normal,
        FAR,
    )
    at = patch.pair
    for j in range(3):
        R = pose[3 * j :]
        n[j] = R[0] * sizes[3] + R[1] * sizes[4] + R[2] * sizes[5]
        at[j] = pose[9 + j] + R[0] * sizes[0] + R[1] * sizes[1] + R[2] * sizes[2]
    for v in range(a.count):
        x = a.corners[3 * v :]
        gap = n[0] * (x[0] - at[0]) + n[1] * (x[1] - at[1]) + n[2] * (x[2] - at[2]) - a.radius
        best = lesser(best, gap)
        if gap <= limit:
            for j in range(3):
                patch.trial[j] = x[j] - (a.radius + 0.5 * gap) * n[j]
            patch.met[0], patch.met[1], patch.met[2], patch.met[3] = v, CORNER, 0, FACE
            add_point(patch, patch.trial, gap, 1.0)
    return best
