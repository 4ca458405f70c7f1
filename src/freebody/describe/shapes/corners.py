"""Corners, each of which touches by itself."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import sympy

from ...errors import ModelError, shown
from ...scalar.algebra import add, apply
from ..frame import Frame, Point, place_in
from .data import length, sum_of
from .point import Spot, spot
from .shape import ContactShape


class Corners(ContactShape, kind="corners"):
    """Corners of a box, a polygon or a mesh; each touches by itself."""

    points: tuple[Point, ...]

    door = True
    words = {"points": "points", "size": "edges", "at": "vector"}
    look = "spots"

    @classmethod
    def part(cls, other: type[ContactShape]) -> type[ContactShape]:
        """Return the kind of a point."""
        return Spot

    def parts(self, other: ContactShape) -> Sequence[ContactShape]:
        """Return the points."""
        return self.members

    @property
    def members(self) -> Sequence[ContactShape]:
        """The points."""
        return [spot(point) for point in self.points]

    @classmethod
    def made(cls, body: Any, **data: Any) -> ContactShape:
        """Return the corners of a body from the data of a file."""
        return corners(body, *data.pop("points", ()), **data)

    def told(self, word: str) -> Any:
        """Return the points, which contain the size and the place."""
        return tuple(point.components for point in self.points) if word == "points" else None


def corners(body: Frame, *points: Any, size: Any = None, at: Any = None) -> Corners:
    """Return the corners of a convex body, each of which touches by itself.

    Without points and size they are the vertices of the body's mesh; vertices in one place count once.

    Parameters
    ----------
    *points : Points of the body, three components each, or one array of shape (n, 3)
    size : two or three expressions of parameters [m], in place of points
        Edges of a box along the body's axes: two give four corners in the plane of x and y, three give eight.
    at : Point of the body or three components, optional
        The middle of that box; by default the body's origin.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("rocking block")
    >>> block = s.body("block", fb.box(1, (0.2, 1, 0.2)))
    >>> block.corners(size=(0.2, 1)).points[:2]
    (point (-1/10, -1/2, 0) of block, point (1/10, -1/2, 0) of block)
    >>> faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    >>> stone = s.body("stone", fb.mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], faces, mass=6))
    >>> len(stone.corners().points)
    4
    """
    what = f"the corners of {body!r}"
    if size is not None and points:
        raise ModelError(f"Expected either points or size=(a, b) for {what}, got both.")
    if size is None and not points:
        points = vertices_of(body, what)
    if size is not None:
        if isinstance(size, str) or not hasattr(size, "__len__") or len(size) not in (2, 3):
            raise ModelError(f"Expected two or three edges, size=(a, b, c), for {what}, got {shown(size)}.")
        edges = [sympy.sympify(length(body, edge, what)) / 2 for edge in size]
        middle = place_in(body, at, what)
        # counter-clockwise from the lower left, the lower four (smaller z) first
        around = ((-1, -1), (1, -1), (1, 1), (-1, 1))
        depths = (-1, 1) if len(edges) == 3 else (0,)
        edges = [*edges, 0][:3]
        vertices = [
            Point(body, sum_of(middle, (i * edges[0], j * edges[1], k * edges[2])))
            for k in depths
            for i, j in around
        ]
        return Corners(body, tuple(vertices))
    if at is not None:
        raise ModelError(f"at= displaces a box given by size=, but {what} are given as points.")
    if len(points) == 1 and isinstance(points[0], Sequence | np.ndarray):
        rows = points[0].tolist() if hasattr(points[0], "tolist") else points[0]
        if hasattr(rows, "__len__") and len(rows) > 0 and hasattr(rows[0], "__len__"):
            points = tuple(rows)
    return Corners(body, tuple(Point(body, place_in(body, point, what)) for point in points))


def vertices_of(body: Frame, what: str) -> tuple[Any, ...]:
    """Return the vertices of the mesh that a body is made of, in body axes."""
    shape = None if body.mass_properties is None else body.mass_properties.shape
    if shape is None or shape.kind != "mesh":
        raise ModelError(
            f"Expected points, or size=(a, b) of a box, for {what}, got none. A body made of a mesh has corners of its "
            f"own; this one is {'no mesh' if shape is None else f'a {shape.kind}'}."
        )
    return tuple(
        dict.fromkeys(
            add(shape.center, apply(shape.axes, tuple(v))) for v in shape["surface"].vertices.tolist()
        )
    )
