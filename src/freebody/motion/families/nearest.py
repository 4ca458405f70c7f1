"""The nearest points of two convex cores that are apart, or whose edges cross, and the features that have them."""

from __future__ import annotations

from ...native.instructions import Integers, Reals, compiled, greater, hot, lesser, root
from .faces import ALONG, CORNER, FAR, HEAD, add_point, meet_edge
from .family_record import Core, Families, Patch
from .vectors import along, cross, vector

PARALLEL = 1e-12
"""Square of the sine of the angle up to which two edges count as parallel."""
FACE_OF_A, FACE_OF_B, EDGES = 1, 2, 3


@hot
@compiled
def least(core: Core, n: Reals) -> float:
    """Return the least n·v of the corners of a core."""
    result, v = FAR, core.corners
    for k in range(core.count):
        result = lesser(result, along(n, v[3 * k :]))
    return result


@hot
@compiled
def least_beyond(core: Core, n: Reals, height: float, bar: float) -> float:
    """Return the least n·v of the corners of a core, or one of them that is less than ``bar`` above a height."""
    result, v = FAR, core.corners
    for k in range(core.count):
        result = lesser(result, along(n, v[3 * k :]))
        if result - height < bar:
            break
    return result


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
def nearest(of: Families, a: Core, b: Core, flat: float, wall: int, patch: Patch, limit: float) -> None:
    """Set distance, normal and feature for two cores that are apart: of two edges, or of what lies over a face.

    ``flat`` is the greatest separation by a face, one of the core that ``wall`` says. If a corner over a face is
    nearest, it is over this one. Edges are sought up to a distance, ``limit``, which is taken if there are none.
    """
    if wall == FACE_OF_A and flat > 0.0 and over_face(of, a, b, wall, flat, patch) == 1:
        return
    if wall == FACE_OF_B and flat > 0.0 and over_face(of, b, a, wall, flat, patch) == 1:
        return
    if wall == FACE_OF_A and flat > 0.0 and under_face(of, a, b, wall, flat, patch) == 1:
        return
    if wall == FACE_OF_B and flat > 0.0 and under_face(of, b, a, wall, flat, patch) == 1:
        return
    distance = nearest_edges(of, a, b, patch, limit)
    if (
        flat > 0.0 and distance <= flat + ALONG * patch.extent
    ):  # along the face: the crossings of an edge with its sides
        patch.apart, patch.kind = flat, wall
        return
    across_pair(patch, distance)


@compiled
def across_pair(patch: Patch, distance: float) -> None:
    """Take the direction between the nearest points of two edges as the normal; edges that meet have none of it."""
    if distance == 0.0:
        patch.apart = greater(patch.apart, 0.0)
    else:
        patch.apart, patch.kind = distance, EDGES
        for k in range(3):
            patch.normal[k] = (patch.pair[3 + k] - patch.pair[k]) / distance


@compiled
def nearest_edges(of: Families, a: Core, b: Core, patch: Patch, limit: float) -> float:
    """Set the nearest points of the edges of two cores, and the edges; return their distance, or the limit.

    Of round solids, parallel edges are taken where others are as near up to round-off.
    """
    best = nearest_pair(of, a, b, 0, limit, patch)
    if a.radius + b.radius > 0.0:
        nearest_pair(of, a, b, 1, root(best) + ALONG * patch.extent, patch)
    return root(best)


@compiled
def nearest_pair(of: Families, a: Core, b: Core, parallel: int, limit: float, patch: Patch) -> float:
    """Set the nearest points of the edges within a limit, of all or of the ``parallel`` ones; return their square.

    Edges that are as far from each other along the normal, or a ground axis, as the nearest ones are passed.
    """
    n, slack = patch.normal, ALONG * patch.extent
    one, other, best = of.members.mesh[a.mesh :], of.members.mesh[b.mesh :], FAR
    edges, edges_b, got = one[one[HEAD - 1] :], other[other[HEAD - 1] :], patch.pair
    if limit < FAR:
        best = limit * limit
    below, above, heights = FAR, -FAR, patch.heights
    for k in range(b.count):
        x = along(n, b.corners[3 * k :])
        heights[k], below, above = x, lesser(below, x), greater(above, x)
    for i in range(edges[0]):
        p, q = a.corners[3 * edges[2 + 2 * i] :], a.corners[3 * edges[3 + 2 * i] :]
        x, y = along(n, p), along(n, q)
        low, high = lesser(x, y), greater(x, y)
        apart = greater(below - high, low - above) - slack
        for j in range(0 if apart > 0.0 and apart * apart >= best else edges_b[0]):
            x, y = heights[edges_b[2 + 2 * j]], heights[edges_b[3 + 2 * j]]
            apart = greater(lesser(x, y) - high, low - greater(x, y)) - slack
            if apart > 0.0 and apart * apart >= best:
                continue
            r, s = b.corners[3 * edges_b[2 + 2 * j] :], b.corners[3 * edges_b[3 + 2 * j] :]
            for k in range(3):  # along the ground axes, too
                x = lesser(r[k], s[k]) - greater(p[k], q[k])
                y = lesser(p[k], q[k]) - greater(r[k], s[k])
                apart = greater(apart, greater(x, y) - slack)
            if apart > 0.0 and apart * apart >= best:
                continue
            if parallel == 0 or side_by_side(p, q, r, s) == 1:
                square = segments(p, q, r, s, patch.trial)
                if square < best:
                    best = square
                    for k in range(6):
                        got[k] = patch.trial[k]
                    meet_edge(patch.met, 0, edges[2 + 2 * i], edges[3 + 2 * i])
                    meet_edge(patch.met, 2, edges_b[2 + 2 * j], edges_b[3 + 2 * j])
    return best


@compiled
def over_face(of: Families, core: Core, other: Core, wall: int, flat: float, patch: Patch) -> int:
    """Take the face that separates the cores best, by ``flat``, if a nearest corner of the other core lies over it.

    Return 1 if so, else 0.
    """
    mesh, n = of.members.mesh[core.mesh :], core.normals[3 * patch.face :]
    face, count = (
        mesh[mesh[HEAD + patch.face] :],
        mesh[HEAD + patch.face + 1] - mesh[HEAD + patch.face],
    )
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
def under_face(of: Families, core: Core, other: Core, wall: int, flat: float, patch: Patch) -> int:
    """Take the face that separates the cores best if a corner of it lies over a face of the other that does so, too.

    Return 1 if so, else 0.
    """
    mesh, room, found = of.members.mesh[other.mesh :], ALONG * patch.extent, 0
    for f in range(mesh[1]):
        face, count = mesh[mesh[HEAD + f] :], mesh[HEAD + f + 1] - mesh[HEAD + f]
        n = other.normals[3 * f :]
        height = least(core, n)
        if height - along(n, other.corners[3 * face[0] :]) >= flat - room:
            for v in range(core.count):
                w = core.corners[3 * v :]
                if along(n, w) <= height + room and outside(other, face, count, n, w) <= room:
                    found = 1
    if found == 1:
        patch.apart, patch.kind, n = flat, wall, core.normals[3 * patch.face :]
        for k in range(3):
            patch.normal[k] = n[k]
    return found


@compiled
def outside(core: Core, face: Integers, count: int, n: Reals, w: Reals) -> float:
    """Return how far the foot of a point lies outside the sides of a face; negative inside."""
    result = -FAR
    for k in range(count):
        p, q = core.corners[3 * face[k] :], core.corners[3 * face[(k + 1) % count] :]
        x, y, z = vector(p, q)
        a, b, c = cross(x, y, z, n[0], n[1], n[2])
        length = root(a * a + b * b + c * c)
        result = greater(result, (a * (w[0] - p[0]) + b * (w[1] - p[1]) + c * (w[2] - p[2])) / length)
    return result


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
def side_by_side(p: Reals, q: Reals, r: Reals, s: Reals) -> int:
    """Return 1 if the edges pq and rs are parallel; a corner is parallel to nothing."""
    x, y, z = vector(p, q)
    u, v, w = vector(r, s)
    c, d, e = cross(x, y, z, u, v, w)
    size = (x * x + y * y + z * z) * (u * u + v * v + w * w)
    return 1 if size > 0.0 and c * c + d * d + e * e <= PARALLEL * size else 0


@compiled
def round_points(a: Core, b: Core, patch: Patch) -> None:
    """Add the points of round solids at their nearest edges: one, or the two ends of what parallel ones have in common.

    An edge whose nearest point is its end is that corner.
    """
    met = patch.met
    i, j, k, m = met[0], met[1], met[2], met[3]
    p, q, r, s = a.corners[3 * i :], a.corners[3 * j :], b.corners[3 * k :], b.corners[3 * m :]
    if side_by_side(p, q, r, s) == 1:
        square, low, high = 0.0, 0.0, 0.0
        for n in range(3):
            square += (q[n] - p[n]) * (q[n] - p[n])
            low += (r[n] - p[n]) * (q[n] - p[n])
            high += (s[n] - p[n]) * (q[n] - p[n])
        low, high = low / square, high / square
        if low > high:
            low, high, k, m = high, low, met[3], met[2]
        if greater(0.0, low) < lesser(1.0, high):
            slack = ALONG * patch.extent / root(square)
            for end in range(2):
                x = greater(0.0, low) if end == 0 else lesser(1.0, high)
                for n in range(3):
                    patch.pair[n] = p[n] + x * (q[n] - p[n])
                    patch.pair[3 + n] = patch.pair[n] + patch.apart * patch.normal[n]
                meet_edge(met, 0, i, j)
                meet_edge(met, 2, k, m)
                if end == 0 and low > slack:
                    met[2], met[3] = k, CORNER
                elif end == 0:
                    met[0], met[1] = i, CORNER
                elif high < 1.0 - slack:
                    met[2], met[3] = m, CORNER
                else:
                    met[0], met[1] = j, CORNER
                between(patch, a, b)
            return
    at_corner(a, i, j, patch.pair, 0, patch)
    at_corner(b, k, m, patch.pair[3:], 2, patch)
    between(patch, a, b)


@compiled
def at_corner(core: Core, i: int, j: int, x: Reals, at: int, patch: Patch) -> None:
    """Write the corner as the feature if a point of an edge is its end."""
    for end in range(2):
        corner, square = j if end == 1 else i, 0.0
        for k in range(3):
            d = x[k] - core.corners[3 * corner + k]
            square += d * d
        if root(square) <= ALONG * patch.extent:
            patch.met[at], patch.met[at + 1] = corner, CORNER


@compiled
def between(patch: Patch, a: Core, b: Core) -> None:
    """Add the point between the nearest points of two cores."""
    got = patch.pair
    for k in range(3):
        shift = 0.5 * (a.radius - b.radius) * patch.normal[k]
        patch.trial[k] = 0.5 * (got[k] + got[3 + k]) + shift
    add_point(patch, patch.trial, patch.apart - a.radius - b.radius, -1.0)
