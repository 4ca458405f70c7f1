"""Cylinders that end: cans, pucks, rolls, thick coins; from inside, tins.

The inside of a drum is convex, |p| <= r and |z| <= L/2 in terms that are convex in the place. On a convex body such
terms are greatest at a corner: it is inside if its corners are, those of a box or hull, or the balls at the ends of a
capsule, and no edge or face touches before them. So a tin is three surfaces, its wall and two planes, each with a gap

    r - R - |p|,      L/2 - R ± z      of a point (R = 0) or a ball,

which a ball in the edge between wall and end touches both.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy

from ...scalar.algebra import HALF, Expression, Scalar, Vector, add, divide, dot, negate, scale, subtract
from ..frame import Frame, place_in
from .circle import Circle
from .cylinder import Cylinder
from .data import flag, sum_of, unit_vector
from .data import length as size_of
from .plane import Plane, across
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


class Wall(Cylinder, kind="wall of a drum", listed=False):
    """The wall of a drum from inside."""

    length: Scalar = 0

    hollow = "wall of a tin"


class Lid(Plane, kind="end of a drum", listed=False):
    """An end of a drum from inside."""

    inside: bool = True

    look, hollow = "", "end of a tin"


class Drum(ContactShape, kind="drum"):
    """A circular cylinder between two flat ends, which touches planes with their edges; from inside a tin."""

    at: Vector
    axis: Vector
    radius: Scalar
    length: Scalar
    inside: bool = False

    door = True
    words = expressions("radius", "length", "at", "axis", "inside")
    required = ("radius", "length")
    bound, hollow = "drum", "tin"
    touched_by = {Ball.kind: on_drum}

    @classmethod
    def part(cls, other: type[ContactShape]) -> type[ContactShape]:
        """Return the kind of an edge for planes, else the drum."""
        return Rim if other.endless else cls

    def parts(self, other: ContactShape) -> Sequence[ContactShape]:
        """Return the edges of its ends for planes, else the drum; from inside, its wall and its ends."""
        if self.inside:
            return self.members
        return self.rims if other.endless else (self,)

    @property
    def rims(self) -> Sequence[ContactShape]:
        """Edges of its ends."""
        return [Rim(self.body, end, self.axis, self.radius) for end in self.middles]

    @property
    def middles(self) -> Sequence[Vector]:
        """Middles of its ends."""
        half = sympy.sympify(self.length) / 2
        return [sum_of(self.at, scale(side * half, self.axis)) for side in (-1, 1)]

    @property
    def members(self) -> Sequence[ContactShape]:
        """Edges of its ends for planes, and the drum itself for spheres; from inside, its wall and its ends."""
        if not self.inside:
            return [*self.rims, self]
        normals = self.axis, negate(self.axis)
        lids = [Lid(self.body, at, n, *across(n)) for at, n in zip(self.middles, normals, strict=True)]
        return [Wall(self.body, self.at, self.axis, self.radius, True, self.length), *lids]

    @classmethod
    def made(cls, body: Any, **data: Any) -> ContactShape:
        """Return the drum of a body from the data of a file."""
        return drum(body, **data)


def drum(
    body: Frame,
    radius: Expression,
    length: Expression,
    *,
    at: Any = None,
    axis: Any = "z",
    inside: bool = False,
) -> Drum:
    """Return a cylinder with ends fixed in the body: a can, a puck, a coin; with ``inside=True`` a tin.

    It touches planes with the edges of its ends: standing at four points of one, lying along a line at both. Spheres
    roll on its wall, on its flat ends and over the rim between. From inside it holds points, spheres, corners, boxes,
    hulls and capsules, by its wall and its two ends: contacts of three names, ``c_1`` with the wall, ``c_2`` and
    ``c_3`` with the ends.

    Parameters
    ----------
    radius, length : expressions of parameters [m]
    at : Point of the body or three components, optional
        Its middle; by default the body's origin.
    axis : "x", "y", "z" or three components
    inside : bool
        True if other bodies are in it.

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
    sizes = size_of(body, radius, what), size_of(body, length, what)
    return Drum(body, place_in(body, at, what), n, *sizes, flag(inside, what))
