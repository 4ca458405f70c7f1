"""What bodies touch with: points, round and flat shapes fixed in a body, and the pairs of them that may touch.

All components are in the axes of the body, from its origin [m]. A shape's *outside* is where its body is not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..said import OfBody

if TYPE_CHECKING:
    from ..body import Body, Point

Components = tuple[Any, Any, Any]


@dataclass(frozen=True, repr=False)
class Ball(OfBody):
    """The surface of a sphere; ``inside`` if the body is around it, a bowl."""

    body: Body
    at: Components
    radius: Any
    inside: bool = False
    kind = "sphere"


@dataclass(frozen=True, repr=False)
class Tether(Ball):
    """What a rope of length ``radius`` from ``at`` leaves to its other end: the inside of a sphere."""

    inside: bool = True
    kind = "tether"


@dataclass(frozen=True, repr=False)
class Ellipsoid(OfBody):
    """The surface of an ellipsoid, its axes along those of the body."""

    body: Body
    at: Components
    half_axes: Components
    kind = "ellipsoid"


@dataclass(frozen=True, repr=False)
class Circle(OfBody):
    """The edge of a disk at right angles to ``axis``; against round shapes and points, the wall of a cylinder."""

    body: Body
    at: Components
    axis: Components
    radius: Any
    inside: bool = False
    kind = "circle"


@dataclass(frozen=True, repr=False)
class Cylinder(OfBody):
    """The wall of a circular cylinder without end; ``inside`` if the body is around it, a pipe."""

    body: Body
    at: Components
    axis: Components
    radius: Any
    inside: bool = False
    kind = "cylinder"


@dataclass(frozen=True, repr=False)
class Plane(OfBody):
    """A plane without end; ``normal`` points out of the body, and (first, second, normal) is right-handed."""

    body: Body
    at: Components
    normal: Components
    first: Components
    second: Components
    kind = "plane"


@dataclass(frozen=True, repr=False)
class Segment(OfBody):
    """A straight side from ``start`` to ``end``; ``normal`` points out of the body, at right angles to the side."""

    body: Body
    start: Components
    end: Components
    along: Components
    normal: Components
    length: Any
    kind = "segment"


@dataclass(frozen=True, repr=False)
class Corners(OfBody):
    """Corners of a box, a polygon or a mesh: each touches for itself."""

    body: Body
    points: tuple[Point, ...]
    kind = "corners"


@dataclass(frozen=True, repr=False)
class Heightline(OfBody):
    """The line y = f(x) (in 3-D the surface over x and z) of a body that lies below it."""

    body: Body
    at: Components
    variable: Any
    height: Any
    slope: Any
    kind = "heightline"


def kind_of(shape: Any) -> str:
    """What a shape is, in a word."""
    return str(getattr(shape, "kind", "point"))


@dataclass(frozen=True)
class ContactPair:
    """A contact as the user gave it: which shapes may touch, and the laws of friction and impact.

    ``friction`` is the coefficient while slipping, ``static_friction`` while sticking; ``impact`` says whether
    ``restitution`` is Newton's ratio of speeds or Poisson's ratio of impulses.
    """

    name: str
    feature: Any
    surface: Any
    friction: Any
    static_friction: Any
    restitution: Any
    impact: str

    def __repr__(self) -> str:
        return f"contact '{self.name}'"
