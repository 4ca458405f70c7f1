"""Features by which two convex solids touch at one point of their patch: a corner, a face, an edge.

Which corner, face or edge it is, is data: ``used`` is 1, and 0 for a feature that no point of the patch has now, which
is away from everything. A motion by events writes these numbers where its patches change (`motion.contact.patches`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from ...scalar.algebra import Scalar, Vector, add, cross, divide, dot, scale, subtract
from .shape import ContactShape, Law, Nearest


class Feature(ContactShape, listed=False):
    """A feature of a solid; ``used`` is 1 or 0."""

    at: Vector
    used: Scalar

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


def corner_on_face(at: Any, corner: Corner, face: Face) -> Nearest:
    """Return g = n·(P - F) of a corner P over the plane through F."""
    used, n = at(face.used), at.turned(face.body, face.normal)
    P = at.place(corner.body, corner.at)
    gap = dot(n, subtract(P, at.place(face.body, face.at)))
    return Nearest(P, subtract(P, scale(gap, n)), n, used * gap + (1 - used), (2 * used - 1,))


def edge_on_edge(at: Any, edge: Edge, other: Edge) -> Nearest:
    """Return the nearest points of two lines A + x a and B + y b, with m = a × b:

    n = ± m/|m|,   g = n·(A - B),   x = (B - A) × b · m/m²,   y = (B - A) × a · m/m²
    """
    used = at(other.used)
    a, b = at.turned(edge.body, edge.along), at.turned(other.body, other.along)
    A, B = at.place(edge.body, edge.at), at.place(other.body, other.at)
    m = add(
        scale(used, cross(a, b)), scale(1 - used, a)
    )  # of a feature that is not used: any vector of length 1
    square = dot(m, m)
    n = scale(divide(at(other.side), at.field.sqrt(square)), m)
    d, m = subtract(B, A), scale(divide(1, square), m)
    P = add(A, scale(dot(cross(d, b), m), a))
    Q = add(B, scale(dot(cross(d, a), m), b))
    return Nearest(P, Q, n, used * dot(n, subtract(A, B)) + (1 - used), (2 * used - 1,))


Corner.touches = {Face.kind: corner_on_face}
Edge.touches = {Edge.kind: edge_on_edge}
