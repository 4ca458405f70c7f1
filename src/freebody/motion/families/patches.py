"""The patch in which two convex solids touch: points with a common normal, and a gap at each.

A solid is a core, the convex hull of its corners, rounded by a radius; a sphere is a core of one corner, a point has
the radius 0. Two cores that overlap are separated the least along a normal of a face, or across an edge of each:

    g = max over n of  (min over w of B  n·w - max over v of A  n·v) - r_A - r_B,      n: face normals, a × b of edges

and g is the distance of their nearest features where they are apart (:func:`nearest`). If n is the normal of a face,
the face of the other core that looks towards it is cut by its sides (`faces`): the corners over it and the edge
crossings carry, each with a gap of its own. Both bodies are pressed at one point, so that the forces of a pair are
opposite in every sense.

Source: S. Gottschalk, M. C. Lin, D. Manocha, OBBTree, SIGGRAPH (1996), for the axes.
"""

from __future__ import annotations

from ...native.instructions import Integers, Reals, compiled, greater, lesser, root
from .faces import ALONG, CORNER, FACE, FAR, HEAD, NOWHERE, add_point, along, cut, face_normal, meet_edge
from .family_record import POSE, Core, Families, Patch

PARALLEL = 1e-12
"""Square of the sine of the angle up to which two edges count as parallel."""
FACE_OF_A, FACE_OF_B, EDGES = 1, 2, 3


@compiled
def lay_core(of: Families, core: Core, k: int) -> None:
    """Set the corners of a member in ground axes."""
    members = of.members
    pose, sizes = of.links.poses[POSE * members.link[k] :], members.sizes[members.sizes_at[k] :]
    core.mesh = members.mesh_at[k]
    core.count = members.mesh[core.mesh]
    core.radius = members.radius[k]
    for j in range(3):
        core.middle[j] = 0.0
    for v in range(core.count):
        x, y, z = sizes[3 * v], sizes[3 * v + 1], sizes[3 * v + 2]
        for j in range(3):
            core.corners[3 * v + j] = (
                pose[9 + j] + pose[3 * j] * x + pose[3 * j + 1] * y + pose[3 * j + 2] * z
            )
            core.middle[j] += core.corners[3 * v + j] / core.count


@compiled
def least(core: Core, n: Reals) -> float:
    """Return the least n·v of the corners of a core."""
    result, v = FAR, core.corners
    for k in range(core.count):
        result = lesser(result, n[0] * v[3 * k] + n[1] * v[3 * k + 1] + n[2] * v[3 * k + 2])
    return result


@compiled
def by_faces(of: Families, core: Core, other: Core, which: int, patch: Patch) -> None:
    """Try the face normals of a core, which point from it to the other one.

    One of the second core is taken only where it is better by more than round-off, so that a patch of two equal faces
    has the same points in every step.
    """
    mesh = of.members.mesh[core.mesh :]
    n, bar = patch.trial, ALONG * patch.extent if which == FACE_OF_B else 0.0
    for f in range(mesh[1]):
        face = mesh[mesh[HEAD + f] :]
        face_normal(core, face, n)
        p = core.corners[3 * face[0] :]
        apart = least(other, n) - (n[0] * p[0] + n[1] * p[1] + n[2] * p[2])
        if apart > patch.apart + bar:
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
    best = patch.apart + ALONG * patch.extent
    for i in range(edges[1]):
        p, q = a.corners[3 * edges[2 + 2 * i] :], a.corners[3 * edges[3 + 2 * i] :]
        x, y, z = q[0] - p[0], q[1] - p[1], q[2] - p[2]
        for j in range(edges_b[1]):
            r, s = b.corners[3 * edges_b[2 + 2 * j] :], b.corners[3 * edges_b[3 + 2 * j] :]
            u, v, w = s[0] - r[0], s[1] - r[1], s[2] - r[2]
            n[0], n[1], n[2] = y * w - z * v, z * u - x * w, x * v - y * u
            square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2]
            if square > PARALLEL * (x * x + y * y + z * z) * (u * u + v * v + w * w):
                length = root(square)
                side = (
                    n[0] * (b.middle[0] - a.middle[0])
                    + n[1] * (b.middle[1] - a.middle[1])
                    + n[2] * (b.middle[2] - a.middle[2])
                )
                if side < 0.0:
                    length = -length
                for k in range(3):
                    n[k] /= length
                apart = least(b, n)
                for k in range(3):
                    n[k] = -n[k]
                apart += least(a, n)
                if apart > best:
                    best = patch.apart = apart
                    patch.kind = EDGES
                    for k in range(3):
                        patch.normal[k] = -n[k]


@compiled
def segments(p: Reals, q: Reals, r: Reals, s: Reals, result: Reals) -> float:
    """Set the nearest points (3 each) of the segments pq and rs; return the square of their distance.

    Source: C. Ericson, Real-Time Collision Detection (2005), section 5.1.9.
    """
    a, b, c, d, e = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        u, v, w = q[k] - p[k], s[k] - r[k], p[k] - r[k]
        a += u * u
        b += u * v
        c += u * w
        d += v * v
        e += v * w
    x, y, span = 0.0, 0.0, a * d - b * b
    if a > 0.0:
        if d > 0.0:
            if span > PARALLEL * a * d:
                x = greater(0.0, lesser(1.0, (b * e - c * d) / span))
            y = (b * x + e) / d
            if y < 0.0:
                x, y = greater(0.0, lesser(1.0, -c / a)), 0.0
            elif y > 1.0:
                x, y = greater(0.0, lesser(1.0, (b - c) / a)), 1.0
        else:
            x = greater(0.0, lesser(1.0, -c / a))
    elif d > 0.0:
        y = greater(0.0, lesser(1.0, e / d))
    square = 0.0
    for k in range(3):
        result[k] = p[k] + x * (q[k] - p[k])
        result[3 + k] = r[k] + y * (s[k] - r[k])
        square += (result[3 + k] - result[k]) * (result[3 + k] - result[k])
    return square


@compiled
def nearest(of: Families, a: Core, b: Core, flat: float, wall: int, patch: Patch) -> None:
    """Set distance, normal and feature for two cores that are apart: of two edges, or of what lies over a face.

    ``flat`` is the greatest separation by a face, one of the core that ``wall`` says. If a corner over a face is
    nearest, it is over this one.
    """
    if wall == FACE_OF_A and flat > 0.0 and over_face(of, a, b, wall, flat, patch) == 1:
        return
    if wall == FACE_OF_B and flat > 0.0 and over_face(of, b, a, wall, flat, patch) == 1:
        return
    one, other, best = of.members.mesh[a.mesh :], of.members.mesh[b.mesh :], FAR
    edges, edges_b, got = one[one[HEAD - 1] :], other[other[HEAD - 1] :], patch.pair
    for i in range(edges[0]):
        p, q = a.corners[3 * edges[2 + 2 * i] :], a.corners[3 * edges[3 + 2 * i] :]
        for j in range(edges_b[0]):
            r, s = b.corners[3 * edges_b[2 + 2 * j] :], b.corners[3 * edges_b[3 + 2 * j] :]
            square = segments(p, q, r, s, patch.trial)
            if square < best:
                best = square
                for k in range(6):
                    got[k] = patch.trial[k]
                meet_edge(patch.met, 0, edges[2 + 2 * i], edges[3 + 2 * i])
                meet_edge(patch.met, 2, edges_b[2 + 2 * j], edges_b[3 + 2 * j])
    distance = root(best)
    if (
        flat > 0.0 and distance <= flat + ALONG * patch.extent
    ):  # along the face: the crossings of an edge with its sides
        patch.apart, patch.kind = flat, wall
        return
    if distance > 0.0:
        patch.apart, patch.kind = distance, EDGES
        for k in range(3):
            patch.normal[k] = (got[3 + k] - got[k]) / distance


@compiled
def over_face(of: Families, core: Core, other: Core, wall: int, flat: float, patch: Patch) -> int:
    """Take the face that separates the cores best, by ``flat``, if a nearest corner of the other core lies over it.

    Return 1 if so, else 0.
    """
    mesh, n = of.members.mesh[core.mesh :], patch.trial
    face, count = (
        mesh[mesh[HEAD + patch.face] :],
        mesh[HEAD + patch.face + 1] - mesh[HEAD + patch.face],
    )
    face_normal(core, face, n)
    height, inside = flat + along(n, core.corners[3 * face[0] :]) + ALONG * patch.extent, 0
    for v in range(other.count):
        w = other.corners[3 * v :]
        if along(n, w) <= height and outside(core, face, count, n, w) <= ALONG * patch.extent:
            inside = 1
    if inside == 1:
        patch.apart, patch.kind = flat, wall
        for k in range(3):
            patch.normal[k] = n[k]
    return inside


@compiled
def outside(core: Core, face: Integers, count: int, n: Reals, w: Reals) -> float:
    """Return how far the foot of a point lies outside the sides of a face; negative inside."""
    result = -FAR
    for k in range(count):
        p, q = core.corners[3 * face[k] :], core.corners[3 * face[(k + 1) % count] :]
        x, y, z = q[0] - p[0], q[1] - p[1], q[2] - p[2]
        a, b, c = y * n[2] - z * n[1], z * n[0] - x * n[2], x * n[1] - y * n[0]
        length = root(a * a + b * b + c * c)
        result = greater(result, (a * (w[0] - p[0]) + b * (w[1] - p[1]) + c * (w[2] - p[2])) / length)
    return result


# -- points ----------------------------------------------------------------------------------------------


@compiled
def measure(of: Families, first: int, second: int, limit: float) -> float:
    """Return the gap of two members, and set the points of their patch with gaps up to ``limit``.

    Beyond the limit the gap is a lower bound: that of the best of the axes.
    """
    a, b, patch = of.one, of.other, of.patch
    lay_core(of, a, first)
    patch.count = 0
    if of.members.mesh[of.members.mesh_at[second]] == 0:
        return over_plane(of, second, limit)
    lay_core(of, b, second)
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
    flat, wall = patch.apart, patch.kind
    by_edges(of, a, b, patch)
    if patch.apart > limit + r:
        return patch.apart - r
    if patch.kind == EDGES and flat > patch.apart - patch.even and almost_flat(of, wall, limit) == 1:
        return patch.apart - r
    if faces == 0 or patch.apart > 0.0:
        nearest(of, a, b, flat, wall, patch)
    elif patch.kind == EDGES:
        crossing(of, a, b, patch)
    if patch.apart > limit + r:
        return patch.apart - r
    if patch.kind == FACE_OF_A:
        cut(of, a, b, limit, -1.0)
    elif patch.kind == FACE_OF_B:
        cut(of, b, a, limit, 1.0)
    elif a.count == 2 and b.count == 2 and side_by_side(a, b) == 1:
        abreast(of, a, b, limit)
    else:
        got = patch.pair
        for k in range(3):
            shift = 0.5 * (a.radius - b.radius) * patch.normal[k]
            patch.trial[k] = 0.5 * (got[k] + got[3 + k]) + shift
        add_point(patch, patch.trial, patch.apart - r, -1.0)
    return patch.apart - r


@compiled
def almost_flat(of: Families, wall: int, limit: float) -> int:
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
    if best <= (0.5 * gap if gap < 0.0 else gap + patch.even) and patch.met[0] != NOWHERE:
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


@compiled
def crossing(of: Families, a: Core, b: Core, patch: Patch) -> None:
    """Set the nearest points of the edges of two overlapping cores that lie outermost along the normal."""
    one, other, best = of.members.mesh[a.mesh :], of.members.mesh[b.mesh :], FAR
    edges, edges_b, n, m = one[one[HEAD - 1] :], other[other[HEAD - 1] :], patch.normal, patch.trial
    low = least(b, n)
    for k in range(3):
        m[k] = -n[k]
    high, slack = -least(a, m), 10.0 * ALONG * patch.extent
    for i in range(edges[0]):
        p, q = a.corners[3 * edges[2 + 2 * i] :], a.corners[3 * edges[3 + 2 * i] :]
        if along(n, p) >= high - slack and along(n, q) >= high - slack:
            for j in range(edges_b[0]):
                r, s = b.corners[3 * edges_b[2 + 2 * j] :], b.corners[3 * edges_b[3 + 2 * j] :]
                if along(n, r) <= low + slack and along(n, s) <= low + slack:
                    square = segments(p, q, r, s, patch.trial)
                    if square < best:
                        best = square
                        for k in range(6):
                            patch.pair[k] = patch.trial[k]
                        meet_edge(patch.met, 0, edges[2 + 2 * i], edges[3 + 2 * i])
                        meet_edge(patch.met, 2, edges_b[2 + 2 * j], edges_b[3 + 2 * j])


@compiled
def side_by_side(a: Core, b: Core) -> int:
    """Return 1 if two cores of two corners are parallel."""
    p, q, r, s = a.corners, a.corners[3:], b.corners, b.corners[3:]
    x, y, z = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    u, v, w = s[0] - r[0], s[1] - r[1], s[2] - r[2]
    c, d, e = y * w - z * v, z * u - x * w, x * v - y * u
    bound = PARALLEL * (x * x + y * y + z * z) * (u * u + v * v + w * w)
    return 1 if c * c + d * d + e * e <= bound else 0


@compiled
def abreast(of: Families, a: Core, b: Core, limit: float) -> None:
    """Set the two ends of the common length of two parallel cores of two corners; one point if they have none."""
    patch, p, q, r, s = of.patch, a.corners, a.corners[3:], b.corners, b.corners[3:]
    square, low, high = 0.0, 0.0, 0.0
    for k in range(3):
        square += (q[k] - p[k]) * (q[k] - p[k])
        low += (r[k] - p[k]) * (q[k] - p[k])
        high += (s[k] - p[k]) * (q[k] - p[k])
    low, high = low / square, high / square
    start = greater(0.0, lesser(low, high))
    end = lesser(1.0, greater(low, high))
    gap = patch.apart - a.radius - b.radius
    for part in range(2):
        x = start if part == 0 else end
        if start < end or part == 0:
            for k in range(3):
                on_a = p[k] + x * (q[k] - p[k]) if start < end else patch.pair[k]
                patch.trial[k] = on_a + (a.radius + 0.5 * gap) * patch.normal[k]
            add_point(patch, patch.trial, gap, -1.0)
