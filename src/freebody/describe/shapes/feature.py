"""Features by which two convex solids touch at one point of their patch: a corner, a face, an edge.

Which corner, face or edge it is, is data: ``used`` is 1, and 0 for a feature that no point of the patch has now, which
is away from everything. A motion by events writes these numbers where its patches change (`motion.contact.patches`).
They are rounded by a radius; a sphere is a corner. With radii r_A and r_B, and A and B the nearest points of the
features themselves,

    P = A - r_A n,     Q = B + r_B n,     g = n·(A - B) - r_A - r_B
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from ...scalar.algebra import IDENTITY, Scalar, Vector, add, cross, divide, dot, scale, subtract
from .shape import ContactShape, Law, Nearest


class Feature(ContactShape, listed=False):
    """A feature of a solid of this radius; ``used`` is 1 or 0."""

    at: Vector
    used: Scalar
    radius: Scalar

    in_families = False


class Face(Feature, kind="face of a solid", listed=False):
    """A face: a point of its plane and the unit normal out of the body."""

    normal: Vector


class Corner(Feature, kind="corner of a solid", listed=False):
    """A corner."""

    touches: ClassVar[Mapping[str, Law]]


class Edge(Feature, kind="edge of a solid", listed=False):
    """An edge: a point and a unit vector along it; ``side`` is the sign of the normal, along × other edge."""

    along: Vector
    side: Scalar

    touches: ClassVar[Mapping[str, Law]]


def touching(at: Any, a: Feature, b: Feature, used: Scalar, A: Vector, B: Vector, n: Vector) -> Nearest:
    """Return the nearest points of two features by those of their cores; the gap of one that is not used is 1."""
    r_a, r_b = at(a.radius), at(b.radius)
    gap = dot(n, subtract(A, B)) - r_a - r_b
    P, Q = subtract(A, scale(r_a, n)), add(B, scale(r_b, n))
    return Nearest(P, Q, n, used * gap + (1 - used), (2 * used - 1,))


def instead(used: Scalar, v: Vector, other: Vector) -> Vector:
    """Return a vector, or another one if the features are not used, so that it has a direction."""
    return add(scale(used, v), scale(1 - used, other))


def corner_on_face(at: Any, corner: Corner, face: Face) -> Nearest:
    """Return the nearest points of a corner A and the plane through F: B = A - n·(A - F) n."""
    n, A = at.turned(face.body, face.normal), at.place(corner.body, corner.at)
    B = subtract(A, scale(dot(n, subtract(A, at.place(face.body, face.at))), n))
    return touching(at, corner, face, at(face.used), A, B, n)


def corner_on_corner(at: Any, corner: Corner, other: Corner) -> Nearest:
    """Return the nearest points of two corners: n = (A - B)/|A - B|."""
    used, A, B = at(other.used), at.place(corner.body, corner.at), at.place(other.body, other.at)
    n = at.field.unit(instead(used, subtract(A, B), IDENTITY[2]))
    return touching(at, corner, other, used, A, B, n)


def corner_on_edge(at: Any, corner: Corner, edge: Edge) -> Nearest:
    """Return the nearest points of a corner A and a line F + y b: y = b·(A - F), n = (A - B)/|A - B|."""
    used, b = at(edge.used), at.turned(edge.body, edge.along)
    A, F = at.place(corner.body, corner.at), at.place(edge.body, edge.at)
    B = add(F, scale(dot(b, subtract(A, F)), b))
    n = at.field.unit(instead(used, subtract(A, B), b))
    return touching(at, corner, edge, used, A, B, n)


def edge_on_edge(at: Any, edge: Edge, other: Edge) -> Nearest:
    """Return the nearest points of two lines E + x a and F + y b, with m = a × b:

    n = ± m/|m|,   x = (F - E) × b · m/m²,   y = (F - E) × a · m/m²
    """
    used = at(other.used)
    a, b = at.turned(edge.body, edge.along), at.turned(other.body, other.along)
    E, F = at.place(edge.body, edge.at), at.place(other.body, other.at)
    m = instead(used, cross(a, b), a)
    square = dot(m, m)
    n = scale(divide(at(other.side), at.field.sqrt(square)), m)
    d, m = subtract(F, E), scale(divide(1, square), m)
    A, B = add(E, scale(dot(cross(d, b), m), a)), add(F, scale(dot(cross(d, a), m), b))
    return touching(at, edge, other, used, A, B, n)


Corner.touches = {Face.kind: corner_on_face, Corner.kind: corner_on_corner, Edge.kind: corner_on_edge}
Edge.touches = {Edge.kind: edge_on_edge}
