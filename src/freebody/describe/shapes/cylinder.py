"""Walls of cylinders without end."""

from __future__ import annotations

from typing import Any

from ...scalar.algebra import Expression, Scalar, Vector, apply, cross
from ...scalar.expression import exact
from ..frame import Frame, place_in
from .data import flag, length, unit_vector
from .round import between_round
from .shape import ContactShape, Law, expressions


class Cylinder(ContactShape, kind="cylinder"):
    """The wall of an infinite circular cylinder; ``inside`` if the body is around it, a pipe."""

    at: Vector
    axis: Vector
    radius: Scalar
    inside: bool = False

    door = True
    words = expressions("radius", "at", "axis", "inside")
    required = ("radius",)
    look, hollow, round, extruded, precedence = "wall", "pipe", True, True, 1

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
        """Return the cylinder of a body from the data of a file."""
        return cylinder(body, **data)


def cylinder(
    body: Frame, radius: Expression, *, at: Any = None, axis: Any = "z", inside: bool = False
) -> Cylinder:
    """Return the wall of an infinite circular cylinder fixed in the body.

    Parameters
    ----------
    radius : expression of parameters [m]
    at : Point of the body or three components, optional
        A point of its axis; by default the body's origin.
    axis : "x", "y", "z" or three components
    inside : bool
        True if other bodies touch it from within: a pipe.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("ball on a log")
    >>> ball = s.body("ball", fb.sphere(1, 0.1))
    >>> air = s.free("air", s.ground, ball)
    >>> log = s.contact("log", ball.sphere(0.1), s.ground.cylinder(0.5, axis="x"), friction=0.3)
    """
    what = f"the cylinder of {body!r}"
    n = unit_vector(body, axis, f"the axis of {what}")
    return Cylinder(body, place_in(body, at, what), n, length(body, radius, what), flag(inside, what))
