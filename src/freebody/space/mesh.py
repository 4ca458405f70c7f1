"""Mass properties of the solid inside a closed triangle mesh.

Each triangle (a, b, c) spans with an origin a tetrahedron of signed volume V = a·(b × c)/6; over it

    ∫ dV = V      ∫ r dV = V s/4      ∫ r rᵀ dV = V (a aᵀ + b bᵀ + c cᵀ + s sᵀ)/20,   s = a + b + c

and the sum over an outward surface is the solid's integral, exact but for round-off
(Tonon, J. Mathematics and Statistics 1 (2005) 8-11).
"""

from __future__ import annotations

from os import PathLike, fspath
from os.path import isfile, splitext
from typing import TYPE_CHECKING, Any

from ..errors import FormatError, MassError
from ..scalar.algebra import Expression
from .entries import exact_number, reciprocal, value_of
from .mass import MassProperties
from .shape import Shape, surface

if TYPE_CHECKING:
    import numpy as np


def mesh(
    vertices: Any,
    faces: Any = None,
    *,
    density: Expression = None,
    mass: Expression = None,
    scale: Expression = 1,
    flip: bool = False,
) -> MassProperties:
    """Mass properties of a uniform solid whose surface is a closed triangle mesh.

    Parameters
    ----------
    vertices : array, shape (n, 3), or a path
        Points in body axes from the body's origin [m]; or a file that trimesh reads (STL, OBJ, PLY, ...).
    faces : array of int, shape (k, 3)
        Corners of each triangle, counter-clockwise seen from outside; not given with a path.
    density, mass : number or expression, one of the two
        [kg/m³] or [kg].
    scale : number
        Factor on the vertices, e.g. 0.001 for a file in millimetres.
    flip : bool
        Reverse every triangle, for a mesh whose normals point inwards.

    Raises
    ------
    MassError
        If the surface is not closed (with the number of open edges), not wound consistently, inside
        out, or encloses nothing.
    FormatError
        If the file cannot be read as triangles.
    ImportError
        If a path is given and trimesh is not installed.

    Examples
    --------
    >>> corner = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    >>> mesh(corner, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], mass=6).center
    (Fraction(1, 4), Fraction(1, 4), Fraction(1, 4))
    """
    import numpy as np

    if (mass is None) == (density is None):
        raise MassError("Expected either mass= or density= of the mesh, got both or none.")
    if isinstance(vertices, (str, PathLike)):
        if faces is not None:
            raise MassError("Expected a path alone, or vertices and faces, got a path and faces.")
        vertices, faces = _read(fspath(vertices))
    elif faces is None:
        raise MassError("Expected faces beside the vertices of the mesh, shape (k, 3), got none.")
    factor = value_of(exact_number(scale, "the scale"))
    if factor is None or factor <= 0:
        raise MassError(f"Expected a scale that is a number above zero, got {scale}.")
    points = _points(vertices) * float(factor)
    triangles = _triangles(faces, len(points))
    if flip:
        triangles = triangles[:, ::-1]
    _check_closed(points, triangles)
    volume, center, second = _integrals(points, triangles)
    size = float(np.ptp(points, axis=0).max())
    if abs(volume) <= _FLAT * size**3:
        raise MassError(
            f"Expected a mesh that encloses a volume, got {volume:.3g} m³ at a size of {size:.3g} m. "
            "A sheet has no volume: use plate, or thicken it."
        )
    if volume < 0:
        raise MassError(
            f"Expected triangles counter-clockwise seen from outside, got a mesh that is inside out (volume "
            f"{volume:.6g} m³). Turn it over with flip=True."
        )
    # inertia for unit density about the mass centre: I = tr(S) 1 - S
    unit = _clean(np.trace(second) * np.eye(3) - second, np.trace(second))
    center = _clean(center, abs(points).max())
    rho = exact_number(density, "the density") if density is not None else None
    m = exact_number(mass, "the mass") if rho is None else rho * exact_number(volume)
    ratio = m * reciprocal(exact_number(volume)) if rho is None else rho
    shape = Shape("mesh", (("surface", surface(points, triangles)),))
    inertia = [[exact_number(float(unit[i, j])) * ratio for j in range(3)] for i in range(3)]
    positive = tuple(x for x in (mass, density) if x is not None)
    return MassProperties(m, tuple(float(x) for x in center), inertia, shape, positive)  # type: ignore[arg-type]


def _clean(values: np.ndarray, size: float) -> np.ndarray:
    """The values with round-off replaced by exact zeros, so that a symmetric mesh has the exact zeros of its solid."""
    import numpy as np

    return np.where(abs(values) <= 64 * np.finfo(float).eps * size, 0, values)


# Volume of a mesh of round-off thickness, in units of its size cubed.
_FLAT = 1 / 10**13


def _integrals(points: np.ndarray, triangles: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Volume, centroid, and ∫ r rᵀ dV about the centroid."""
    import numpy as np

    origin = (points.min(axis=0) + points.max(axis=0)) / 2
    volume, center = _first(points - origin, triangles)
    if volume == 0:
        return volume, origin, np.zeros((3, 3))
    # a second pass about the centroid, so that no parallel-axis term cancels
    origin = origin + center
    a, b, c = (points[triangles[:, i]] - origin for i in range(3))
    V = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    s = a + b + c
    second = sum(np.einsum("i,ij,ik->jk", V, v, v) for v in (a, b, c, s)) / 20
    return volume, origin, (second + second.T) / 2


def _first(points: np.ndarray, triangles: np.ndarray) -> tuple[float, np.ndarray]:
    """Volume and centroid."""
    import numpy as np

    a, b, c = (points[triangles[:, i]] for i in range(3))
    V = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    volume = float(V.sum())
    center = (V[:, None] * (a + b + c)).sum(axis=0) / 4
    return volume, center / volume if volume else center


def _check_closed(points: np.ndarray, triangles: np.ndarray) -> None:
    """Refuse a mesh with an edge that is not traversed equally often in both directions."""
    import numpy as np

    # equal points are merged: STL files repeat them in every triangle
    same = np.unique(points, axis=0, return_inverse=True)[1].reshape(-1)
    corners = same[triangles]
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    edges = edges[edges[:, 0] != edges[:, 1]]
    sense = np.where(edges[:, 0] < edges[:, 1], 1, -1)
    _, index = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    index = index.reshape(-1)
    count = np.bincount(index)
    turns = np.bincount(index, weights=sense)
    leaks = int((count % 2 == 1).sum())
    if leaks:
        raise MassError(
            f"Expected a closed mesh, got one with {_edges(leaks, 'open')} of {len(count)}. "
            "Fill the holes in the program it comes from, or merge vertices that should be one."
        )
    flipped = int((turns != 0).sum())
    if flipped:
        raise MassError(
            f"Expected triangles that all turn the same way, got {_edges(flipped)} run through "
            "twice in one sense. Make the normals consistent in the program it comes from."
        )


def _edges(n: int, kind: str = "") -> str:
    return f"{n} {kind} edge{'s' if n > 1 else ''}".replace("  ", " ")


def _points(vertices: Any) -> np.ndarray:
    import numpy as np

    try:
        points = np.array(vertices, dtype=float)
    except (TypeError, ValueError):
        raise MassError("Expected vertices as numbers with shape (n, 3), got something else.") from None
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise MassError(f"Expected vertices with shape (n, 3), got shape {points.shape}.")
    if not np.isfinite(points).all():
        bad = points[~np.isfinite(points).all(axis=1)][0]
        raise MassError(f"Expected finite vertices, got {bad.tolist()}.")
    return points


def _triangles(faces: Any, n: int) -> np.ndarray:
    import numpy as np

    try:
        triangles = np.array(faces)
    except ValueError:
        raise MassError(
            "Expected faces with shape (k, 3), got rows of different lengths. Split them into triangles."
        ) from None
    if triangles.ndim != 2 or triangles.shape[1] != 3 or not len(triangles):
        raise MassError(f"Expected faces with shape (k, 3), got shape {triangles.shape}.")
    if triangles.dtype.kind not in "iu":
        raise MassError(f"Expected faces as integers (rows of vertices), got {triangles.dtype}.")
    if triangles.min() < 0 or triangles.max() >= n:
        bad = triangles.min() if triangles.min() < 0 else triangles.max()
        raise MassError(f"Expected faces with vertex numbers 0 to {n - 1}, got {bad}. Counting starts at 0.")
    return triangles.astype(int)


def _read(path: str) -> tuple[Any, Any]:
    """Vertices and faces from a file."""
    try:
        import trimesh
    except ImportError:
        raise ImportError(
            "Expected trimesh for reading a mesh file, but it is not installed: pip install "
            "'freebody[mesh]'. Arrays of vertices and faces do without it."
        ) from None
    if not isfile(path):
        raise FormatError(f"Expected a triangle mesh in '{path}', but there is no such file.")
    try:
        # an open file rather than its name: trimesh would follow a name that is a URL, and files named in the file
        with open(path, "rb") as file:
            surface = trimesh.load(file, file_type=splitext(path)[1].lower(), force="mesh")
        vertices, faces = surface.vertices, surface.faces
    except Exception as problem:  # every reader of trimesh has its own exceptions
        raise FormatError(
            f"Expected a triangle mesh in '{path}', but it cannot be read: {problem}"
        ) from problem
    if not len(faces):
        raise FormatError(f"Expected a triangle mesh in '{path}', got a file without triangles.")
    return vertices, faces
