"""Shapes of bodies for contact: points, round and flat shapes fixed in a body.

All components are in the axes of the body, from its origin [m]. The *outside* of a shape is the side without its body.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..scalar.algebra import Scalar, Vector
from .frame import Frame, Point
from .labels import OfBody


@dataclass(frozen=True, repr=False)
class Ball(OfBody):
    """The surface of a sphere; ``inside`` if the body is around it, a bowl."""

    body: Frame
    at: Vector
    radius: Scalar
    inside: bool = False
    kind = "sphere"


@dataclass(frozen=True, repr=False)
class Tether(Ball):
    """The space that a rope of length ``radius`` from ``at`` leaves to its other end: the inside of a sphere."""

    inside: bool = True
    kind = "tether"


@dataclass(frozen=True, repr=False)
class Ellipsoid(OfBody):
    """The surface of an ellipsoid, its axes along those of the body."""

    body: Frame
    at: Vector
    half_axes: Vector
    kind = "ellipsoid"


@dataclass(frozen=True, repr=False)
class Circle(OfBody):
    """The edge of a disk at right angles to ``axis``; for round shapes and points, the wall of a cylinder."""

    body: Frame
    at: Vector
    axis: Vector
    radius: Scalar
    inside: bool = False
    kind = "circle"


@dataclass(frozen=True, repr=False)
class Cylinder(OfBody):
    """The wall of an infinite circular cylinder; ``inside`` if the body is around it, a pipe."""

    body: Frame
    at: Vector
    axis: Vector
    radius: Scalar
    inside: bool = False
    kind = "cylinder"


@dataclass(frozen=True, repr=False)
class Plane(OfBody):
    """An infinite plane; ``normal`` points out of the body, and (first, second, normal) is right-handed."""

    body: Frame
    at: Vector
    normal: Vector
    first: Vector
    second: Vector
    kind = "plane"


@dataclass(frozen=True, repr=False)
class Segment(OfBody):
    """A straight side from ``start`` to ``end``; ``normal`` points out of the body, at right angles to the side."""

    body: Frame
    start: Vector
    end: Vector
    along: Vector
    normal: Vector
    length: Scalar
    kind = "segment"


@dataclass(frozen=True, repr=False)
class Corners(OfBody):
    """Corners of a box, a polygon or a mesh; each touches by itself."""

    body: Frame
    points: tuple[Point, ...]
    kind = "corners"


@dataclass(frozen=True, repr=False)
class Heightline(OfBody):
    """The line y = f(x) (in 3-D the surface over x and z) of a body that lies below it."""

    body: Frame
    at: Vector
    variable: Any
    height: Scalar
    slope: Scalar
    kind = "heightline"


def kind_of(shape: Any) -> str:
    """Return the kind of a shape, "point" for a point."""
    return str(getattr(shape, "kind", "point"))
