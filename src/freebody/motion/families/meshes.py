"""Meshes of members as the compiled code reads them: corners, faces and edges of solids (`family_record.Members`)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from ...scalar.algebra import Vector

PARALLEL = 1e-9
"""Sine of the angle up to which two edges of a solid have one direction."""


def core_of(shape: Any, origin: Vector) -> list[Any]:
    """Return the expressions of the corners of a solid, from the origin of the link; of other shapes nothing."""
    if not shape.patches:
        return []
    return [a + b for corner in shape.corners for a, b in zip(corner, origin, strict=True)]


def mesh_of(shape: Any, numbers: Any = None) -> list[int]:
    """Return the mesh of a member; a plane has no corners, a sphere or a point has one.

    Parameters
    ----------
    numbers : array of shape (3 n,)
        Places of the corners of a solid.
    """
    if not shape.patches:
        return [0, 0, 3] if shape.endless else [1, 0, 4, 4, 1, 0, 0, 0]
    return list(_mesh_of_solid(tuple(map(tuple, shape.faces)), tuple(numbers)))


@lru_cache(maxsize=64)
def _mesh_of_solid(faces: Sequence[Sequence[int]], numbers: Sequence[float]) -> tuple[int, ...]:
    """Return the mesh of a solid; bricks of one shape share it."""
    places = np.reshape(numbers, (-1, 3))
    pairs = sorted(
        {tuple(sorted((a, b))) for face in faces for a, b in zip(face, (*face[1:], face[0]), strict=True)}
    ) or [(0, 1)]
    ways = [(places[b] - places[a]) / np.linalg.norm(places[b] - places[a]) for a, b in pairs]
    first: list[int] = []
    for k, way in enumerate(ways):
        if all(float(np.linalg.norm(np.cross(way, ways[j]))) > PARALLEL for j in first):
            first.append(k)
    order = [*first, *(k for k in range(len(pairs)) if k not in first)]
    starts = np.cumsum([3 + len(faces) + 1, *map(len, faces)]).tolist()
    edges = (len(pairs), len(first), *(corner for k in order for corner in pairs[k]))
    return len(places), len(faces), starts[-1], *starts, *(c for face in faces for c in face), *edges


def most_points(shape: Any) -> int:
    """Return a bound of the points of a patch of a shape with one that is no larger: the corners of two faces."""
    return 2 * len(shape.corners) + 2 if shape.patches else 2
