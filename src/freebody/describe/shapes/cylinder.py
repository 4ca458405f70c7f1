"""Walls of cylinders without end."""

from __future__ import annotations

from typing import Any

from ...scalar.algebra import Expression
from ..frame import Frame, place_in
from .data import flag, length, unit_vector
from .round import AboutAxis
from .shape import ContactShape, expressions


class Cylinder(AboutAxis, kind="cylinder"):
    """The wall of an infinite circular cylinder; ``inside`` if the body is around it, a pipe."""

    door = True
    words = expressions("radius", "at", "axis", "inside")
    required = ("radius",)
    look, hollow = "wall", "pipe"

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
