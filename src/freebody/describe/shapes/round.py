"""Round shapes on each other and on flat ones: the geometry by centre, radius and axis."""

from __future__ import annotations

from typing import Any

from ...scalar.algebra import Scalar, Vector, add, apply, cross, dot, scale, subtract
from ...scalar.expression import exact
from .shape import ContactShape, Law, Nearest


def between_round(at: Any, a: Any, b: Any) -> Nearest:
    """Return the nearest points of points, spheres and walls of cylinders.

    With d from the centre of b to the centre of a, at right angles to the axis,

    outside  n = d/|d|,   g = |d| - r_a - r_b;        inside  n = -d/|d|,   g = r_b - r_a - |d|.

    Where d is 0, n is too: it has no direction, and needs none while the contact is open, such as that of a pin in the
    middle of its hole, or beyond the end of a capsule. If the machine holds d at 0, a closed contact is refused.
    """
    A, B = a.middle(at), b.middle(at)
    d = subtract(A, B)
    # the centre of a cylinder moves along its axis to the depth of the other shape
    axis = b.axle(at)
    if axis is not None:
        along = scale(dot(axis, d), axis)
        B, d = add(B, along), subtract(d, along)
    else:
        axis = a.axle(at)
        if axis is not None:
            along = scale(dot(axis, d), axis)
            A, d = subtract(A, along), subtract(d, along)
    direction = at.field.unit(d)
    distance = dot(d, direction)
    r_a, r_b = a.size(at), b.size(at)
    if b.inside:
        n = scale(-1, direction)
        return Nearest(subtract(A, scale(r_a, n)), subtract(B, scale(r_b, n)), n, r_b - r_a - distance)
    return Nearest(
        subtract(A, scale(r_a, direction)), add(B, scale(r_b, direction)), direction, distance - r_a - r_b
    )


class AboutAxis(ContactShape, listed=False):
    """A shape that is round about an axis, and the same along it; ``inside`` if the body is around it."""

    at: Vector
    axis: Vector
    radius: Scalar
    inside: bool = False

    round, extruded, precedence = True, True, 1

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
