"""Triangle meshes that a robot's file names: found, read with limits, and made coarse enough to be shown.

A mesh here is only seen: it may be open, or of many pieces. Masses come from `space.mesh`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from importlib.util import find_spec
from io import BytesIO
from os import environ, pathsep
from os.path import isfile, join
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FormatError
from ..space.shape import Shape, Surface
from .reading import Reading

LARGEST = 200_000_000
"""Greatest size of a mesh file, in bytes."""
MOST = 2000
"""Greatest number of triangles of a mesh that is shown."""
UPWARDS = 8
"""Number of folders above a robot's file in which its package is looked for."""


class Meshes:
    """The meshes of a robot's file, by the names that it gives them.

    ``package://NAME/PATH`` is looked for in a folder NAME beside the file or beside one of the folders above it, and
    in those of ``ROS_PACKAGE_PATH``; any other name is a path from the file's folder. Nothing else is opened.

    A mesh that is only shown is read when it is first drawn, or when ``reading`` is asked for what was left out.
    """

    def __init__(self, file: Path, reading: Reading) -> None:
        self.folder, self.reading = file.resolve().parent, reading
        self.subfolder = ""  # where meshes are that are named by a path
        self.surfaces: dict[Path, tuple[np.ndarray, np.ndarray]] = {}
        self.shown: dict[Path, tuple[np.ndarray, np.ndarray]] = {}

    @cached_property
    def roots(self) -> list[Path]:
        """Folders in which packages are looked for."""
        above = [self.folder, *self.folder.parents][:UPWARDS]
        return above + [Path(x) for x in environ.get("ROS_PACKAGE_PATH", "").split(pathsep) if x]

    @cached_property
    def allowed(self) -> list[Path]:
        """Folders of which files are read: not the top of the file system nor those in it, such as /dev and /home."""
        return [root for root in map(Path.resolve, self.roots) if len(root.parts) > 2] or [self.folder]

    def shape(self, name: str, put: Callable[[Any], Any], unread: Callable[[str], None]) -> Shape:
        """Return the mesh as a shape, of at most :data:`MOST` triangles. They are found later.

        ``put`` gives the vertices in the shape's axes, and ``unread`` is told what is wrong with the file's content.

        Raises
        ------
        FormatError
            A file that is not found, not allowed or too large, or of another kind.
        """
        path, known = self.path(name), self.shown
        check(path)

        def find() -> tuple[np.ndarray, np.ndarray]:
            try:
                if path not in known:
                    known[path] = coarse(*surface(path))
            except FormatError as error:
                unread(str(error))
                return np.zeros((0, 3)), np.zeros((0, 3), int)
            vertices, faces = known[path]
            return put(vertices), faces

        found = Surface(find)
        self.reading.pending.append(found)
        return Shape("mesh", (("surface", found),))

    def surface(self, path: Path) -> tuple[np.ndarray, np.ndarray]:
        """Return vertices and triangles of a file."""
        if path not in self.surfaces:
            self.surfaces[path] = surface(path)
        return self.surfaces[path]

    def path(self, name: str, folder: Path | None = None) -> Path:
        """Return the file of a name, which is beside the robot's file or in another ``folder``."""
        kind, mark, rest = name.rpartition("://")
        if kind not in ("", "package", "model"):
            raise FormatError(f"expected a path or package://, got {kind}://")
        if mark:
            # of the second names the package is above the file
            candidates = (join(root, end) for end in (rest, rest.partition("/")[2]) for root in self.roots)
        else:
            folders = [folder, self.folder] if folder else [self.folder / self.subfolder]
            candidates = (join(one, name) for one in folders)
        for candidate in candidates:
            try:
                if not isfile(candidate):
                    continue
                path = Path(candidate).resolve()
                if any(path.is_relative_to(root) for root in self.allowed):
                    return path
            except (OSError, ValueError):  # a name that no file can have
                continue
        raise FormatError("no such file near the robot's file")


def check(path: Path) -> None:
    """Raise FormatError for a file that is too large, or of a kind that is not read."""
    size, kind = path.stat().st_size, path.suffix.lower()
    if size > LARGEST:
        raise FormatError(f"expected at most {LARGEST} bytes, got {size}")
    if kind not in (*OWN, *OTHERS):
        raise FormatError(f"expected a mesh (STL, OBJ, DAE, PLY, glTF, OFF), got {kind or 'no suffix'}")
    library = OTHERS[kind][0] if kind in OTHERS else ""
    if library and find_spec(library) is None:
        raise FormatError(f"{kind} needs {library}: pip install 'freebody[mesh]'")


def surface(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (n, 3) and triangles (k, 3) of a file: STL, OBJ, MSH, DAE, and what trimesh reads."""
    kind = path.suffix.lower()
    try:
        check(path)
        data = path.read_bytes()
    except OSError as error:  # it was there when its name was read
        raise FormatError(f"cannot read it: {error.strerror}") from None
    if kind in OWN:
        return OWN[kind](data)
    library, read = OTHERS[kind]
    try:
        return read(BytesIO(data), kind)  # of its bytes: so it opens none of the files that it names
    except Exception as error:  # each of these readers has errors of its own
        raise FormatError(f"{library} cannot read it ({type(error).__name__}: {error})") from None


def _dae(file: BytesIO, kind: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles of the scene of a COLLADA file, in metres; the axis that it has upward changes nothing."""
    import collada

    document = collada.Collada(file, ignore=[collada.common.DaeError])
    vertices, faces, count = [np.zeros((0, 3))], [np.zeros((0, 3), int)], 0
    for geometry in document.scene.objects("geometry"):
        for part in geometry.primitives():
            if hasattr(part, "triangleset"):  # polygons
                part = part.triangleset()
            if len(part.vertex_index) and part.vertex_index.shape[1:] == (3,):  # others are lines
                faces.append(count + triangles_of(part.vertex_index, len(part.vertex), "COLLADA"))
                vertices.append(part.vertex)
                count += len(part.vertex)
    points = np.concatenate(vertices) * float(document.assetInfo.unitmeter or 1)
    if not np.isfinite(points).all():
        raise FormatError("expected finite vertices")
    return points, np.concatenate(faces)


def _by_trimesh(file: BytesIO, kind: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles of a file that trimesh reads."""
    import trimesh

    mesh = trimesh.load(file, file_type=kind[1:], force="mesh")
    return np.array(mesh.vertices, float), np.array(mesh.faces, int)


def _stl(data: bytes) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles of an STL file, binary or text."""
    count = int.from_bytes(data[80:84], "little") if len(data) >= 84 else -1
    if len(data) >= 84 + 50 * count >= 84:
        record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
        corners = np.frombuffer(data, record, count, 84)["corners"].reshape(-1, 3).astype(float)
    elif data.lstrip()[:5] == b"solid":
        words = [
            line.split()[1:4]
            for line in data.decode(errors="replace").splitlines()
            if line.split()[:1] == ["vertex"]
        ]
        corners = _numbers(words)
    else:
        raise FormatError(f"expected STL, got {len(data)} bytes whose header counts {count} triangles")
    if not len(corners) or len(corners) % 3 or not np.isfinite(corners).all():
        raise FormatError("expected STL with finite triangles")
    return corners, np.arange(len(corners)).reshape(-1, 3)


def _obj(data: bytes) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles of an OBJ file; polygons are fans."""
    text = data.decode(errors="replace")
    vertices: list[list[str]] = []
    faces: list[tuple[int, int, int]] = []
    for line in text.splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append(words[1:4])
        elif words[:1] == ["f"]:
            try:
                corners = [int(word.partition("/")[0]) for word in words[1:]]
            except ValueError:
                raise FormatError(f"expected corners of a face, got '{line[:60]}'") from None
            corners = [i - 1 if i > 0 else len(vertices) + i for i in corners]
            faces += [(corners[0], corners[k], corners[k + 1]) for k in range(1, len(corners) - 1)]
    return _numbers(vertices), triangles_of(faces, len(vertices), "OBJ")


def triangles_of(corners: Any, count: int, what: str) -> np.ndarray:
    """Return the triangles of a mesh with so many vertices; FormatError if there are none, or of other vertices."""
    numbers = np.asarray(corners, float).reshape(-1)
    if not numbers.size or numbers.size % 3 or not ((numbers >= 0) & (numbers < count)).all():
        raise FormatError(f"expected {what} with faces of its own vertices")
    return numbers.astype(int).reshape(-1, 3)


def _msh(data: bytes) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles of a binary MSH file of MuJoCo: four counts, vertices, normals, texture, triangles.

    Source: MuJoCo's documentation, XML reference, asset/mesh.
    """
    if len(data) < 16:
        raise FormatError("expected MSH with its counts")
    points, normals, texture, triangles = (int(x) for x in np.frombuffer(data, "<i4", 4))
    size = 4 * (4 + 3 * points + 3 * normals + 2 * texture + 3 * triangles)
    if min(points, normals, texture, triangles) < 0 or size != len(data):
        raise FormatError(f"expected MSH of {size} bytes, as its counts say, got {len(data)}")
    vertices = np.frombuffer(data, "<f4", 3 * points, 16).reshape(-1, 3).astype(float)
    faces = np.frombuffer(data, "<i4", 3 * triangles, size - 12 * triangles).reshape(-1, 3).astype(int)
    if not np.isfinite(vertices).all() or not len(faces) or faces.min() < 0 or faces.max() >= points:
        raise FormatError("expected MSH with triangles of its own finite vertices")
    return vertices, faces


def _numbers(rows: list[list[str]]) -> np.ndarray:
    try:
        points = np.array(rows, float).reshape(-1, 3)
    except ValueError:
        raise FormatError("expected three numbers for each vertex") from None
    if not np.isfinite(points).all():
        raise FormatError("expected finite vertices")
    return points


OWN = {".stl": _stl, ".obj": _obj, ".msh": _msh}
"""Readers of this module, by the ending of a file."""
OTHERS = {
    ".dae": ("collada", _dae),
    **dict.fromkeys((".ply", ".glb", ".gltf", ".off"), ("trimesh", _by_trimesh)),
}
"""Packages that read other files, and the readers that ask them."""


def coarse(vertices: np.ndarray, faces: np.ndarray, most: int = MOST) -> tuple[np.ndarray, np.ndarray]:
    """Return a mesh of at most ``most`` triangles: the vertices in each cell of a grid become their mean.

    Source: J. Rossignac, P. Borrel, Multi-resolution 3D approximations for rendering complex scenes (1993).
    """
    points, triangles, cells = vertices, faces, COARSE
    if len(triangles):
        points, triangles = vertices, faces = _merged(
            vertices, faces, FINEST
        )  # vertices of the same place are one
    while len(triangles) > most:
        points, triangles = _merged(vertices, faces, cells)
        cells = min(cells - 1, int(cells * (most / len(triangles)) ** 0.5))  # the triangles are as cells²
    if not len(triangles):
        raise FormatError("expected triangles with an area, got none")
    return points, triangles


FINEST, COARSE = 1 << 20, 256
"""Numbers of cells along the longest side of a mesh: to merge equal vertices, and to begin to coarsen."""


def _merged(vertices: np.ndarray, faces: np.ndarray, cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the mesh whose vertices are the means of those in each cell of a grid, and each triangle once."""
    low, size = vertices.min(axis=0), float(np.ptp(vertices, axis=0).max()) or 1.0
    x, y, z = np.round((vertices - low) * (cells / size)).astype(np.int64).T
    _, number = np.unique((x * (cells + 1) + y) * (cells + 1) + z, return_inverse=True)
    count = np.bincount(number)
    means: Any = np.stack([np.bincount(number, column) / count for column in vertices.T], axis=1)
    triangles = number[faces]
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    # each triangle once, whatever corner it begins with
    first = triangles.argmin(axis=1)[:, None]
    a, b, c = np.take_along_axis(triangles, (first + np.arange(3)) % 3, axis=1).T
    _, once = np.unique((a * len(means) + b) * len(means) + c, return_index=True)
    triangles = np.stack([a, b, c], axis=1)[np.sort(once)]
    used, triangles = np.unique(triangles, return_inverse=True)
    return means[used], triangles.reshape(-1, 3)
