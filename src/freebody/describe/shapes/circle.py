"""Edges of disks."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from ...scalar.algebra import Expression, Scalar, Vector, add, cross, dot, negate, scale
from ..frame import Frame, place_in
from .data import flag, length, unit_vector
from .plane import across
from .point import Spot
from .round import AboutAxis
from .shape import ContactShape, expressions

FLAT = Fraction(1, 10**11)
"""Height of the highest point of an edge over its lowest one below which a disk lies flat [m]: a tenth of the gap below
which contacts are closed, so that all points of the edge are."""
BAND = Fraction(1, 10**9)
"""Change of the reach of an edge where that height changes by half [m]: a correction of the state moves it by less."""


class Circle(AboutAxis, kind="circle"):
    """The edge of a disk at right angles to ``axis``; for round shapes and points, the wall of a cylinder."""

    door = True
    words = expressions("radius", "at", "axis", "inside")
    required = ("radius",)
    look, bound, hollow = "disk", "edge", "ring"

    def support(self, at: Any, direction: Vector) -> Vector:
        """Return C + r p/|p|  with p = d - (d·a) a = a × (d × a).

        As a product p is exact to its last digits for a disk that lies almost flat; for a flat disk the whole edge
        touches, and the force acts at the middle.
        """
        a = self.axle(at)
        return add(self.middle(at), scale(at(self.radius), at.field.unit(cross(a, cross(direction, a)))))

    def standing(self, other: ContactShape) -> Sequence[ContactShape]:
        """Return the edge and four points of it for a plane."""
        if self.inside or not other.endless:
            return ()
        u, v = (scale(self.radius, e) for e in across(self.axis))
        edge = Edge(self.body, self.at, self.axis, self.radius)
        return edge, *(Rest(self.body, add(self.at, e), edge) for e in (u, v, negate(u), negate(v)))

    @classmethod
    def made(cls, body: Any, **data: Any) -> ContactShape:
        """Return the circle of a body from the data of a file."""
        return circle(body, **data)


class Edge(Circle, kind="edge", listed=False):
    """The edge of a disk in space that may lie flat on a plane, where four points of it touch in its place."""

    def reaches(self, at: Any, normal: Vector) -> tuple[Scalar, ...]:
        """Return b ((h/h_0)² - 1)  with the height h = 2 r |a × n| of the highest point of the edge over the lowest."""
        c = cross(self.axle(at), normal)
        r = at(self.radius)
        return (BAND * (dot(c, c) * (2 / FLAT) ** 2 * r * r - 1),)


class Rest(Spot, kind="rest", listed=False):
    """A point of an edge on which a disk stands that lies flat: it touches where the edge does not."""

    edge: Any

    stands = True

    def reaches(self, at: Any, normal: Vector) -> tuple[Scalar, ...]:
        """Return the opposite of what the edge has."""
        (b,) = self.edge.reaches(at, normal)
        return (-b,)


class Footing(ContactShape, kind="footing", listed=False):
    """A point of an edge on which a disk stands that lies flat, in a direction of the plane: it turns with the load."""

    edge: Any
    plane: Any
    along: Vector

    stands = True

    def support(self, at: Any, direction: Vector) -> Vector:
        """Return C + r a × (d × a): a point of the edge of a disk that lies flat, a point of the disk of any other."""
        edge, d = self.edge, at.turned(self.plane.body, self.along)
        a = edge.axle(at)
        return add(edge.middle(at), scale(at(edge.radius), cross(a, cross(d, a))))

    def reaches(self, at: Any, normal: Vector) -> tuple[Scalar, ...]:
        """Return the opposite of what the edge has."""
        (b,) = self.edge.reaches(at, normal)
        return (-b,)


def circle(
    body: Frame, radius: Expression, *, at: Any = None, axis: Any = "z", inside: bool = False
) -> Circle:
    """Return a circle fixed in the body at right angles to ``axis``: a disk's edge.

    It touches a plane with its lowest point, and in space with four of its points where it lies flat. Points and round
    shapes touch it like the wall of a cylinder along ``axis``, which in planar machines is the same.

    Parameters
    ----------
    radius : expression of parameters [m]
    at : Point of the body or three components, optional
        Its centre; by default the body's origin.
    axis : "x", "y", "z" or three components
    inside : bool
        True if other bodies touch it from within: a ring, a round hole.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("coin")
    >>> coin = s.body("coin", fb.disk(0.01, 0.012))
    >>> air = s.free("air", s.ground, coin)
    >>> table = s.contact("table", coin.circle(0.012), s.ground.plane(normal="z"), friction=0.2)
    """
    what = f"the circle of {body!r}"
    n = unit_vector(body, axis, f"the axis of {what}")
    return Circle(body, place_in(body, at, what), n, length(body, radius, what), flag(inside, what))
