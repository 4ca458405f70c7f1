"""Cylinders that end: cans, pucks, rolls, thick coins."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy

from ...scalar.algebra import HALF, Expression, Scalar, Vector, add, divide, dot, scale, subtract
from ..frame import Frame, place_in
from .circle import Circle
from .data import length as size_of
from .data import sum_of, unit_vector
from .shape import ContactShape, Law, Nearest, expressions
from .sphere import Ball


class Rim(Circle, kind="rim of a drum", listed=False):
    """The edge of an end of a drum, for planes."""

    round, extruded, precedence = False, False, 0

    @classmethod
    def law_with(cls, feature: type[ContactShape]) -> Law | None:
        """Return None: the drum itself touches round shapes."""
        return None


def on_drum(at: Any, ball: Ball, drum: Drum) -> Nearest:
    """Return the nearest points of a sphere of radius R and a drum, by that of its centre P in the drum's solid.

    With d from the middle C to P, z = d·a along the axis and p = d - z a across it,

        Q = C + c a + f p,   c = z within ±L/2,   f = r/max(|p|, r),      v = (z - c) a + (1 - f) p,   g = |v| - R

    which is a point of the wall, of an end or of the rim between. |v| has a gradient n = v/|v| everywhere outside; only
    the curvature jumps where the nearest point passes from one to the other.
    """
    a, r, h = at.turned(drum.body, drum.axis), at(drum.radius), HALF * at(drum.length)
    C, P, R = at.place(drum.body, drum.at), ball.middle(at), ball.size(at)
    d = subtract(P, C)
    z = dot(a, d)
    p = subtract(d, scale(z, a))
    c = HALF * (at.field.apply("abs", z + h) - at.field.apply("abs", z - h))
    across = dot(p, p)
    most = HALF * (across + r * r + at.field.apply("abs", across - r * r))
    f = divide(r, at.field.sqrt(most))
    v = add(scale(z - c, a), scale(1 - f, p))
    distance = at.field.sqrt(dot(v, v))
    n = scale(divide(1, distance), v)
    return Nearest(subtract(P, scale(R, n)), subtract(P, v), n, distance - R)


class Drum(ContactShape, kind="drum"):
    """A circular cylinder between two flat ends, which touches planes with the edges of its ends."""

    at: Vector
    axis: Vector
    radius: Scalar
    length: Scalar

    door = True
    words = expressions("radius", "length", "at", "axis")
    required = ("radius", "length")
    bound = "drum"
    touched_by = {Ball.kind: on_drum}

    @classmethod
    def part(cls, other: type[ContactShape]) -> type[ContactShape]:
        """Return the kind of an edge for planes, else the drum."""
        return Rim if other.endless else cls

    def parts(self, other: ContactShape) -> Sequence[ContactShape]:
        """Return the edges of its ends for planes, else the drum."""
        return self.rims if other.endless else (self,)

    @property
    def rims(self) -> Sequence[ContactShape]:
        """Edges of its ends."""
        half = sympy.sympify(self.length) / 2
        ends = (sum_of(self.at, scale(side * half, self.axis)) for side in (-1, 1))
        return [Rim(self.body, end, self.axis, self.radius) for end in ends]

    @property
    def members(self) -> Sequence[ContactShape]:
        """Edges of its ends for planes, and the drum itself for spheres."""
        return [*self.rims, self]

    @classmethod
    def made(cls, body: Any, **data: Any) -> ContactShape:
        """Return the drum of a body from the data of a file."""
        return drum(body, **data)


def drum(body: Frame, radius: Expression, length: Expression, *, at: Any = None, axis: Any = "z") -> Drum:
    """Return a cylinder with ends fixed in the body: a can, a puck, a coin.

    It touches planes with the edges of its ends: standing at four points of one, lying along a line at both. Spheres
    roll on its wall, on its flat ends and over the rim between.

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
