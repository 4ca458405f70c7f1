"""Convex solids: boxes, convex hulls and capsules, as corners, faces and edges, rounded by a radius.

A corner touches a plane or a hollow by itself, as the corners of `corners` do. Solids touch each other, spheres and
points in patches: the corners of one over a face of the other, and the crossings of their edges; a family of contacts
finds them at every state (`motion.families.patches`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import sympy

from ...errors import ModelError, shown
from ...scalar.algebra import Scalar, Vector, dot, subtract
from ...scalar.expression import exact
from ..constants import default_value
from ..frame import Frame, Point, place_in
from .corners import vertices_of
from .data import length, root_of, sum_of
from .point import Spot
from .round import AboutAxis, between_round
from .shape import ContactShape, Law, Nearest
from .sphere import Ball

Faces = tuple[tuple[int, ...], ...]
MOST = 4000
"""Most corners of a hull."""


class Tip(Spot, kind="tip of a solid", listed=False):
    """A corner of a solid in a hollow."""

    enclosed = True

    @classmethod
    def law_with(cls, feature: type[ContactShape]) -> Law | None:
        """Return None: it touches hollows alone."""
        return None


class RoundTip(Ball, kind="round tip of a solid", listed=False):
    """A round corner of a solid in a hollow."""

    enclosed = True

    @classmethod
    def law_with(cls, feature: type[ContactShape]) -> Law | None:
        """Return None: it touches hollows alone."""
        return None


class Solid(ContactShape, listed=False):
    """A convex solid; ``faces`` are the corners of each face, counter-clockwise from outside."""

    corners: tuple[Vector, ...]
    faces: Faces = ()
    radius: Scalar = 0

    look, bound, patches, door = "solid", "solid", True, True

    @classmethod
    def part(cls, other: type[ContactShape]) -> type[ContactShape]:
        """Return the kind of a corner for planes, else the solid."""
        return Spot if other.endless else cls

    def parts(self, other: ContactShape) -> Sequence[ContactShape]:
        """Return the corners for planes and hollows, else the solid."""
        if not (other.endless or other.inside):
            return (self,)
        if self.radius == 0:
            return [Spot(self.body, corner) for corner in self.corners]
        return [Ball(self.body, corner, self.radius) for corner in self.corners]

    @property
    def enclosures(self) -> Sequence[ContactShape]:
        """The corners."""
        if self.radius == 0:
            return [Tip(self.body, corner) for corner in self.corners]
        return [RoundTip(self.body, corner, self.radius) for corner in self.corners]


class Box(Solid, kind="box"):
    """A box along the axes of its body."""

    words = {"size": "edges", "at": "vector"}
    required = ("size",)

    @classmethod
    def made(cls, body: Any, **data: Any) -> ContactShape:
        """Return the box of a body from the data of a file."""
        return box(body, data.pop("size"), **data)

    def told(self, word: str) -> Any:
        """Return the edges and the middle."""
        low, high = self.corners[0], self.corners[6]
        if word == "size":
            return tuple(sympy.sympify(b) - a for a, b in zip(low, high, strict=True))
        middle = tuple((sympy.sympify(a) + b) / 2 for a, b in zip(low, high, strict=True))
        return None if middle == (0, 0, 0) else middle


class Hull(Solid, kind="hull"):
    """The convex hull of points."""

    words = {"points": "points"}
    required = ()

    @classmethod
    def made(cls, body: Any, **data: Any) -> ContactShape:
        """Return the hull of a body from the data of a file."""
        return hull(body, *data.pop("points", ()))

    def told(self, word: str) -> Any:
        """Return the corners."""
        return self.corners


class Barrel(AboutAxis, kind="wall of a capsule", listed=False):
    """The wall of a capsule between its round ends, for spheres and points."""

    length: Scalar = 0

    in_families = False

    @classmethod
    def law_with(cls, feature: type[ContactShape]) -> Law | None:
        """Return the law of spheres and points."""
        return cls.touches.get(feature.kind)


def on_barrel(at: Any, feature: Any, surface: Any) -> Nearest:
    """Return the nearest points of a barrel and a round shape; the foot is at s = e·(P - start) along the barrel."""
    nearest = between_round(at, feature, surface)
    barrel, P = (
        (feature, nearest.on_feature) if isinstance(feature, Barrel) else (surface, nearest.on_surface)
    )
    s = dot(barrel.axle(at), subtract(P, barrel.middle(at)))
    return nearest._replace(reach=(s, at(barrel.length) - s))


Barrel.touches = dict.fromkeys((Ball.kind, Spot.kind), on_barrel)


class Capsule(Solid, kind="capsule"):
    """A segment, rounded by a radius. Spheres and points touch its wall, or roll over its ends."""

    words = {"start": "vector", "end": "vector", "radius": "expression"}
    required = ("start", "end", "radius")

    @classmethod
    def made(cls, body: Any, **data: Any) -> ContactShape:
        """Return the capsule of a body from the data of a file."""
        return capsule(body, **data)

    def parts(self, other: ContactShape) -> Sequence[ContactShape]:
        """Return the ends for planes, the wall for spheres and points, else the capsule."""
        if not _is_ball(other):
            return super().parts(other)
        start, end = self.corners
        d = tuple(sympy.sympify(x) for x in subtract(end, start))
        length = root_of(self.body, sympy.Add(*(x**2 for x in d)))
        along = tuple(exact(x / length) for x in d)
        return (Barrel(self.body, start, along, self.radius, False, exact(length)),)

    def ends(self, other: ContactShape) -> Sequence[ContactShape]:
        """Return the round ends for spheres and points."""
        return [Ball(self.body, corner, self.radius) for corner in self.corners] if _is_ball(other) else ()

    def told(self, word: str) -> Any:
        """Return an end, or the radius."""
        return {"start": self.corners[0], "end": self.corners[1], "radius": self.radius}[word]


def _is_ball(shape: ContactShape) -> bool:
    """Return True for a sphere or a point, which touch from outside."""
    return shape.bound in ("spot", "ball") and not shape.inside


BOX: Faces = ((3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))


def box(body: Frame, size: Any, *, at: Any = None) -> Box:
    """Return a box fixed in the body, its edges along the axes of the body: a brick, a table, a card.

    Boxes touch planes at their corners. In a family of contacts they touch spheres, points and each other too, at the
    corners that lie over a face and where edges cross.

    Parameters
    ----------
    size : three expressions of parameters [m]
        Edges along x, y and z.
    at : Point of the body or three components, optional
        The middle; by default the body's origin.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("two bricks")
    >>> s.gravity = (0, 0, -9.81)
    >>> bricks = [s.body(f"b{i}", fb.box(1, (0.2, 0.1, 0.1))) for i in (1, 2)]
    >>> joints = [s.free(f"f{i}", s.ground, b) for i, b in enumerate(bricks)]
    >>> shapes = [*(b.box((0.2, 0.1, 0.1)) for b in bricks), s.ground.plane(normal="z")]
    >>> wall = s.contacts("wall", shapes, friction=0.5)
    >>> start = {"f0_z": 0.05, "f1_z": 0.15, "f1_x": 0.05}
    >>> motion = fb.simulate(s, 0.1, initial=start, method="timestepping", step=2e-3)
    >>> round(float(motion.contacts["wall[b1,b2]"].normal[-1]), 6)
    9.81
    """
    what = f"the box of {body!r}"
    if isinstance(size, str) or not hasattr(size, "__len__") or len(size) != 3:
        raise ModelError(f"Expected three edges (a, b, c) for {what}, got {shown(size)}.")
    a, b, c = (sympy.sympify(length(body, edge, what)) / 2 for edge in size)
    middle = place_in(body, at, what)
    around = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    corners = tuple(sum_of(middle, (i * a, j * b, k * c)) for k in (-1, 1) for i, j in around)
    return Box(body, corners, BOX)


def hull(body: Frame, *points: Any) -> Hull:
    """Return the convex hull of points of the body, or of the vertices of its mesh.

    Parameters
    ----------
    *points : Points of the body, three components each, or one array of shape (n, 3)
        Numbers, or expressions of parameters with default values: these say which points are corners of which faces.
        Without points, the vertices of the mesh that the body is made of.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("stone")
    >>> stone = s.body("stone", fb.sphere(1, 0.1))
    >>> stone.hull((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)).faces
    ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    """
    what = f"the hull of {body!r}"
    if not points:
        points = vertices_of(body, what)
    if len(points) == 1 and not isinstance(points[0], Point):
        rows = points[0].tolist() if hasattr(points[0], "tolist") else points[0]
        if hasattr(rows, "__len__") and not isinstance(rows, str) and rows and hasattr(rows[0], "__len__"):
            points = tuple(rows)
    places = [place_in(body, point, what) for point in points]
    values = [[default_value(body.system, x) for x in place] for place in places]
    if any(x is None for row in values for x in row):
        raise ModelError(
            f"Expected points with numbers for {what}: give the parameters in them default values, which say which "
            "points are its corners."
        )
    from scipy.spatial import ConvexHull, QhullError  # takes longer to load than most machines to describe

    array = np.array(values, dtype=float).reshape(-1, 3)
    try:
        found = ConvexHull(array)
    except (QhullError, ValueError) as error:
        raise ModelError(
            f"Expected four points or more that are not in one plane for {what}, got {len(places)}. A flat body is a "
            "box with a small edge, a rod is a capsule."
        ) from error
    kept = sorted(found.vertices.tolist())
    if len(kept) > MOST:
        raise ModelError(f"Expected a hull of at most {MOST} corners for {what}, got {len(kept)}.")
    number = {k: i for i, k in enumerate(kept)}
    return Hull(body, tuple(places[k] for k in kept), _faces(array, found, number))


def _faces(array: Any, found: Any, number: dict[int, int]) -> Faces:
    """Return the faces of a hull, whose triangles in one plane are joined."""
    size = float(np.ptp(array, axis=0).max())
    planes: list[tuple[Any, set[int]]] = []
    for equation, triangle in zip(found.equations, found.simplices, strict=True):
        scale = np.array([1, 1, 1, 1 / size])
        same = next((p for p in planes if np.abs((p[0] - equation) * scale).max() < FLAT), None)
        if same is None:
            planes.append((equation, set(triangle.tolist())))
        else:
            same[1].update(triangle.tolist())
    faces = []
    for equation, corners in planes:
        n, points = equation[:3], sorted(corners)
        middle = array[points].mean(axis=0)
        first = array[points[0]] - middle
        second = np.cross(n, first)
        around = sorted(
            points, key=lambda k: float(np.arctan2((array[k] - middle) @ second, (array[k] - middle) @ first))
        )
        start = around.index(min(around))
        faces.append(tuple(number[k] for k in (*around[start:], *around[:start])))
    return tuple(sorted(faces, key=lambda face: (sorted(face), face)))


FLAT = 1e-9
"""Difference of two planes, relative to the size of the hull, up to which they are one face."""


def capsule(body: Frame, start: Any, end: Any, radius: Any) -> Capsule:
    """Return a capsule fixed in the body: the points within a radius of the line between two points.

    Parameters
    ----------
    start, end : Points of the body or three components each
        Middles of the round ends.
    radius : expression of parameters [m]

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("pill")
    >>> pill = s.body("pill", fb.cylinder(1, 0.1, 0.4))
    >>> air = s.free("air", s.ground, pill)
    >>> floor = s.contact("floor", pill.capsule((0, 0, -0.1), (0, 0, 0.1), 0.1), s.ground.plane(normal="z"))
    """
    what = f"the capsule of {body!r}"
    a, b = place_in(body, start, what), place_in(body, end, what)
    if all(sympy.sympify(x - y) == 0 for x, y in zip(a, b, strict=True)):
        raise ModelError(
            f"Start and end of {what} are the same point. Such a shape is body.sphere(radius, at=...)."
        )
    return Capsule(body, (a, b), (), length(body, radius, what))
