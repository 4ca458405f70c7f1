"""Edges of disks."""

from __future__ import annotations

from typing import Any

from ...scalar.algebra import Expression, Scalar, Vector, add, apply, cross, scale
from ...scalar.expression import exact
from ..frame import Frame, place_in
from .data import flag, length, unit_vector
from .round import between_round
from .shape import ContactShape, Law, expressions


class Circle(ContactShape, kind="circle"):
    """The edge of a disk at right angles to ``axis``; for round shapes and points, the wall of a cylinder."""

    at: Vector
    axis: Vector
    radius: Scalar
    inside: bool = False

    door = True
    words = expressions("radius", "at", "axis", "inside")
    required = ("radius",)
    look, bound, hollow, round, extruded, precedence = "disk", "edge", "ring", True, True, 1

    def support(self, at: Any, direction: Vector) -> Vector:
        """Return C + r p/|p|  with p = d - (d·a) a = a × (d × a).

        As a product p is exact to its last digits for a disk that lies almost flat; for a flat disk the whole edge
        touches, and the force acts at the middle.
        """
        a = self.axle(at)
        return add(self.middle(at), scale(at(self.radius), at.field.unit(cross(a, cross(direction, a)))))

    def middle(self, at: Any) -> Vector:
        """Return the centre, in ground axes."""
        return at.place(self.body, self.at)

    def axle(self, at: Any) -> Vector:
        """Return the axis, in ground axes."""
        return at.turned(self.body, self.axis)

    def size(self, at: Any) -> Scalar:
        """Return the radius."""
        return at(self.radius)

    def tangents(self, at: Any, normal: Vector, turned: bool) -> tuple[Vector, Vector]:
        """Return the axis, and the direction around it."""
        axis = self.axle(at)
        return axis, cross(normal, axis)

    def lies_across(self, R: Any, k: Vector) -> bool:
        """Return True if the axis is parallel to k."""
        return all(exact(x) == 0 for x in cross(apply(R, self.axis), k))

    @classmethod
    def law_with(cls, feature: type[ContactShape]) -> Law | None:
        """Return the law of round shapes."""
        return between_round if feature.round else None

    @classmethod
    def made(cls, body: Any, **data: Any) -> ContactShape:
        """Return the circle of a body from the data of a file."""
        return circle(body, **data)


def circle(
    body: Frame, radius: Expression, *, at: Any = None, axis: Any = "z", inside: bool = False
) -> Circle:
    """Return a circle fixed in the body at right angles to ``axis``: a disk's edge.

    It touches a plane with its lowest point, tilted or not. Points and round shapes touch it like the wall of a
    cylinder along ``axis``, which in planar machines is the same.

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
