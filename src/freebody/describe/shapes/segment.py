"""Straight sides with two ends."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy

from ...errors import ModelError, shown
from ...scalar.algebra import Scalar, Vector, apply, cross, dot, scale, subtract
from ...scalar.expression import exact
from ..frame import Frame, place_in
from .data import root_of, text_of, unit_vector
from .point import Spot
from .shape import ContactShape, Law, Nearest


class End(Spot, kind="end", listed=False):
    """An end of a side, which round shapes can roll over."""


class Segment(ContactShape, kind="segment"):
    """A straight side from ``start`` to ``end``; ``normal`` points out of the body, at right angles to the side."""

    start: Vector
    end: Vector
    along: Vector
    normal: Vector
    length: Scalar

    door = True
    words = {"start": "vector", "end": "vector", "normal": "direction"}
    required = ("start", "end", "normal")
    places = ("start", "end")
    look, extruded = "side", True

    def lies_across(self, R: Any, k: Vector) -> bool:
        """Return True if the normal is at right angles to k."""
        return bool(exact(dot(apply(R, self.normal), k)) == 0)

    @classmethod
    def law_with(cls, feature: type[ContactShape]) -> Law | None:
        """Return the law of round shapes and points, but not of the ends of another side."""
        return on_side if feature.round and not issubclass(feature, End) else None

    @classmethod
    def part(cls, other: type[ContactShape]) -> type[ContactShape]:
        """Return the kind of an end for planes, else the side."""
        return End if other.endless else cls

    def parts(self, other: ContactShape) -> Sequence[ContactShape]:
        """Return the two ends for planes and hollows, else the side."""
        return self._ends if other.endless or other.inside else (self,)

    def ends(self, other: ContactShape) -> Sequence[ContactShape]:
        """Return the ends for round shapes with a size."""
        return self._ends if other.round and hasattr(other, "radius") else ()

    @property
    def members(self) -> Sequence[ContactShape]:
        """The side and its ends."""
        return (self, *self._ends)

    @property
    def _ends(self) -> tuple[End, End]:
        return End(self.body, self.start), End(self.body, self.end)

    @classmethod
    def made(cls, body: Any, **data: Any) -> ContactShape:
        """Return the side of a body from the data of a file."""
        return segment(body, **data)


def on_side(at: Any, feature: Any, side: Any) -> Nearest:
    """Return the nearest points of a point, sphere or wall and a side of normal n:

        P = C,    C - r n,    C - r p/|p|, p = n - (n·a) a = a × (n × a)  with the axis a;      Q = P - g n.

    The foot is at s = e·(P - start) along the side.
    """
    n = at.turned(side.body, side.normal)
    P = feature.middle(at)
    axis = feature.axle(at)
    down = n if axis is None else at.field.unit(cross(axis, cross(n, axis)))
    P = subtract(P, scale(feature.size(at), down))
    O = at.place(side.body, side.start)  # noqa: E741
    gap = dot(n, subtract(P, O))
    s = dot(at.turned(side.body, side.along), subtract(P, O))
    return Nearest(P, subtract(P, scale(gap, n)), n, gap, (s, at(side.length) - s))


def segment(body: Frame, start: Any, end: Any, *, normal: Any) -> Segment:
    """Return a straight side of the body from ``start`` to ``end``: the side of a bar, the top of a ledge.

    Parameters
    ----------
    start, end : Points of the body or three components each
    normal : "y", "-x", … or three components
        Direction out of the body, at right angles to the side.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("bar on a ledge")
    >>> bar = s.body("bar", fb.slender_bar(2, 1.2))
    >>> joint = s.planar("plane", s.ground, bar, coordinate="x y phi")
    >>> side = bar.segment((-0.6, 0, 0), (0.6, 0, 0), normal="-y")
    >>> ledge = s.contact("ledge", side, s.ground.point(0, 0, 0), friction=0.4)
    """
    what = f"the segment of {body!r}"
    a, b = place_in(body, start, what), place_in(body, end, what)
    n = unit_vector(body, normal, f"the normal of {what}")
    d = tuple(sympy.sympify(x) for x in subtract(b, a))
    if sympy.simplify(dot(d, n)) != 0:
        raise ModelError(
            f"The normal of {what} must be at right angles to the side from {text_of(a)} to {text_of(b)}, got "
            f"{shown(normal)}."
        )
    if all(x == 0 for x in d):
        raise ModelError(f"Start and end of {what} are the same point, {text_of(a)}.")
    length = root_of(body, sympy.Add(*(x**2 for x in d)))
    e = tuple(exact(x / length) for x in d)
    return Segment(body, a, b, e, n, exact(length))
