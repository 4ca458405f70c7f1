"""Edges of disks."""

from __future__ import annotations

from typing import Any

from ...scalar.algebra import Expression, Vector, add, cross, scale
from ..frame import Frame, place_in
from .data import flag, length, unit_vector
from .round import AboutAxis
from .shape import ContactShape, expressions


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
