"""Cylinders that end: cans, pucks, rolls, thick coins."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy

from ...scalar.algebra import Expression, Scalar, Vector, scale
from ..frame import Frame, place_in
from .circle import Circle
from .data import length as size_of
from .data import sum_of, unit_vector
from .shape import ContactShape, expressions


class Drum(ContactShape, kind="drum"):
    """A circular cylinder between two flat ends, which touches planes with the edges of its ends."""

    at: Vector
    axis: Vector
    radius: Scalar
    length: Scalar

    door = True
    words = expressions("radius", "length", "at", "axis")
    required = ("radius", "length")

    @classmethod
    def part(cls, other: type[ContactShape]) -> type[ContactShape]:
        """Return the kind of an edge for planes, else the drum."""
        return Circle if other.endless else cls

    def parts(self, other: ContactShape) -> Sequence[ContactShape]:
        """Return the edges of its ends for planes, else the drum."""
        return self.members if other.endless else (self,)

    @property
    def members(self) -> Sequence[ContactShape]:
        """Edges of its ends."""
        half = sympy.sympify(self.length) / 2
        ends = (sum_of(self.at, scale(side * half, self.axis)) for side in (-1, 1))
        return [Circle(self.body, end, self.axis, self.radius) for end in ends]

    @classmethod
    def made(cls, body: Any, **data: Any) -> ContactShape:
        """Return the drum of a body from the data of a file."""
        return drum(body, **data)


def drum(body: Frame, radius: Expression, length: Expression, *, at: Any = None, axis: Any = "z") -> Drum:
    """Return a cylinder with ends fixed in the body: a can, a puck, a coin.

    It touches planes with the edges of its ends: standing at four points of one, lying along a line at both.

    Parameters
    ----------
    radius, length : expressions of parameters [m]
    at : Point of the body or three components, optional
        Its middle; by default the body's origin.
    axis : "x", "y", "z" or three components

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("can")
    >>> s.gravity = (0, 0, -9.81)
    >>> can = s.body("can", fb.cylinder(0.3, 0.03, 0.1))
    >>> air = s.free("air", s.ground, can)
    >>> table = s.contact("table", can.drum(0.03, 0.1), s.ground.plane(normal="z"), friction=0.4)
    >>> motion = fb.simulate(s, 1, initial={"air_z": 0.05, "air_vx": 0.2})
    >>> round(float(motion["air_x"][-1]), 6)  # v²/(2 μ g)
    0.005097
    """
    what = f"the drum of {body!r}"
    n = unit_vector(body, axis, f"the axis of {what}")
    return Drum(body, place_in(body, at, what), n, size_of(body, radius, what), size_of(body, length, what))
