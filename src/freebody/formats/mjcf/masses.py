"""Masses of meshes and of bodies by MuJoCo's rules.

A mesh's volume is that of the pyramids from a point P to its triangles, whose volumes V_i are all taken as positive, so
that open and badly wound surfaces have one too: first P is the centroid of the surface, which gives the mass centre;
then P is this mass centre, which gives volume and inertia.

    V = Σ |V_i|      c = Σ |V_i| (3 m_i + P)/4 / V      ∫ r rᵀ dV = Σ |V_i| (a aᵀ + b bᵀ + d dᵀ + s sᵀ)/20

with the corners a, b, d of triangle i from P, m_i its mean and s their sum. With inertia="exact" the volumes have
signs, with "convex" the triangles are those of the convex hull, with "shell" areas take the place of volumes (and 12
that of 20).

Source: MuJoCo's documentation, XML reference, asset/mesh/inertia; measured against its compiled models.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...errors import FormatError
from ...space.mass import MassProperties
from .document import Compiler

SMALLEST = 1 / 10**15
"""Volume below which a mesh has none, as in MuJoCo [m³]."""


class Solid(NamedTuple):
    """A solid of density 1: volume, mass centre, inertia about it."""

    volume: float
    center: Any
    inertia: Any


def mesh_solid(points: np.ndarray, faces: np.ndarray | None, way: str) -> Solid:
    """Return the solid of a mesh; without ``faces`` it is the convex hull.

    Raises
    ------
    FormatError
        A mesh without a volume.
    """
    if faces is None or way == "convex":
        faces = _hull(points)
    a, b, c = (points[faces[:, i]] for i in range(3))
    area, mean = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2, (a + b + c) / 3
    total = float(area.sum())
    origin = (area[:, None] * mean).sum(axis=0) / (total or 1)
    if way != "shell":
        parts = _volumes(a - origin, b - origin, c - origin, way)
        if abs(parts.sum()) < SMALLEST:
            raise FormatError("expected a mesh with a volume; inertia='shell' gives one to a sheet")
        origin = (parts[:, None] * (3 * mean + origin) / 4).sum(axis=0) / parts.sum()
    a, b, c = a - origin, b - origin, c - origin
    parts = area if way == "shell" else _volumes(a, b, c, way)
    s, count = a + b + c, 12 if way == "shell" else 20
    second = sum(np.einsum("i,ij,ik->jk", parts, v, v) for v in (a, b, c, s)) / count
    volume = float(parts.sum())
    if volume < SMALLEST:
        raise FormatError("expected a mesh with a volume, got one that is inside out or flat")
    inertia = np.trace(second) * np.eye(3) - (second + second.T) / 2
    return Solid(volume, tuple(map(float, origin)), tuple(tuple(map(float, row)) for row in inertia))


def _volumes(a: Any, b: Any, c: Any, way: str) -> Any:
    """Return the volume of each pyramid from the origin."""
    parts = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    return abs(parts) if way == "legacy" else parts


def _hull(points: np.ndarray) -> np.ndarray:
    """Return the triangles of the convex hull, counter-clockwise seen from outside."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points, qhull_options="Qt")
    except (QhullError, ValueError):
        raise FormatError("expected points with a convex hull") from None
    faces = hull.simplices.copy()
    a, b, c = (points[faces[:, i]] for i in range(3))
    inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    faces[inwards] = faces[inwards][:, ::-1]
    return faces


def bounded(properties: MassProperties, compiler: Compiler) -> tuple[MassProperties, bool]:
    """Return the mass properties of a body within the bounds of the compiler, and whether they were changed."""
    if not (compiler.boundmass > 0 or compiler.boundinertia > 0 or compiler.balanceinertia):
        return properties, False
    inertia = np.array(properties.inertia, float)
    if np.count_nonzero(inertia - np.diag(np.diagonal(inertia))):
        moments, axes = np.linalg.eigh(inertia)
    else:
        moments, axes = np.diagonal(inertia).copy(), np.eye(3)
    new = np.maximum(moments, compiler.boundinertia)
    a, b, c = sorted(new)
    if compiler.balanceinertia and a + b < c:
        new = np.full(3, new.mean())
    mass = max(float(properties.mass), compiler.boundmass)
    if mass == properties.mass and (new == moments).all():
        return properties, False
    rows: Any = tuple(tuple(map(float, row)) for row in (axes * new) @ axes.T)
    return MassProperties.as_given(mass, properties.center, rows, properties.shape, possible=False), True
