"""Geoms: their mass properties, and the solids that are shown.

A capsule of radius r and height h between the centres of its ends has a cylinder and two half spheres; that of the half
spheres, of mass m_s together, is I = 2/5 m_s r² along, and across it + m_s h (3 r + 2 h)/8.

Source: MuJoCo's documentation, XML reference, body/geom.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...errors import FormatError
from ...scalar.algebra import ZERO
from ...space.mass import MassProperties
from ...space.pose import Pose
from ...space.rotation import Rotation
from ...space.shape import Shape, compound
from ..builder import placed, whole
from ..meshes import triangles_of
from ..xml_tree import Element
from .document import Document
from .masses import Solid, mesh_solid
from .placing import of_quaternion, pose, to_axis, unit

TYPES = ("plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "sdf")
SIZES = {"sphere": 1, "capsule": 2, "ellipsoid": 3, "cylinder": 2, "box": 3}
"""Numbers that the size of a type has."""
DENSITY = 1000.0
SHOWN_GROUPS = 3
"""Geoms of the groups below are shown, as in MuJoCo's viewer."""


@dataclass(frozen=True)
class Geom:
    """A geom in the axes of its body."""

    kind: str
    element: Element
    pose: Pose
    size: tuple[float, ...]
    group: int
    properties: MassProperties | None
    shape: Shape | None
    problem: str = ""

    @property
    def touches(self) -> bool:
        """True if it may touch anything."""
        return any(self.element.whole(name, 1) != 0 for name in ("contype", "conaffinity"))


class Geoms:
    """Makes geoms; it keeps the meshes of the file."""

    def __init__(self, document: Document, drawn: bool) -> None:
        self.document, self.drawn = document, drawn
        self.assets: dict[str, Element] = {}
        self.solids: dict[str, Solid] = {}
        self.names: set[str] = set()
        for one in document.sections("asset"):
            if one.tag == "mesh":
                name = (
                    one.attributes.get("name")
                    or one.attributes.get("file", "").rpartition("/")[2].rpartition(".")[0]
                )
                if name in self.assets:
                    raise one.error(f"expected each mesh once, got '{name}' again")
                self.assets[name] = document.full(one)

    def geom(self, element: Element, body: str, massive: bool) -> Geom:
        """Return the geom of an element that has the attributes of its class, in a body.

        Unless it is ``massive``, the body's mass does not come from its geoms, and meshes are only drawn.
        """
        name = element.attributes.get("name", "")
        if name in self.names:
            raise element.error(f"expected each geom once, got '{name}' again")
        self.names.update([name] if name else [])
        kind = (
            element.choice("type", TYPES, "sphere")
            if "type" in element.attributes
            else ("mesh" if "mesh" in element.attributes else "sphere")
        )
        group = int(element.number("group", 0))
        where = pose(element, self.document.compiler)
        if kind == "mesh":
            low, high = self.document.compiler.inertiagrouprange
            return self._mesh(element, group, where, body, massive and low <= group <= high)
        if kind not in SIZES or "mesh" in element.attributes:
            problem = (
                ""
                if kind == "plane"
                else f"a {kind} that is fitted to a mesh"
                if kind in SIZES
                else f"a {kind}"
            )
            return Geom(kind, element, where, (), group, None, None, problem)
        size = self._size(element, kind)
        if "fromto" in element.attributes:
            if kind == "sphere":
                raise element.error(
                    "expected fromto= of a capsule, cylinder, ellipsoid or box, got it of a sphere"
                )
            ends = element.numbers("fromto", 6)
            along = [a - b for a, b in zip(ends[:3], ends[3:], strict=True)]
            half = math.hypot(*along) / 2
            size = (size[0], half) if kind in ("capsule", "cylinder") else (size[0], size[0], half)
            middle: Any = tuple(whole((a + b) / 2) for a, b in zip(ends[:3], ends[3:], strict=True))
            where = Pose(Rotation.trusted(to_axis(unit(element, "fromto", along))), middle)
        if any(x <= 0 for x in size):
            raise element.error(
                f"expected sizes of a {kind} above zero, got {' '.join(f'{x:g}' for x in size)}"
            )
        mass = self._mass(element, volume(kind, size))
        shell = element.choice("shellinertia", ("false", "true"), "false") == "true"
        own = (
            MassProperties.as_given(mass, ZERO, _diagonal(mass, kind, size), possible=False) if mass else None
        )
        shape = placed(shape_of(kind, size), where) if group < SHOWN_GROUPS and self.drawn else None
        problem = "the inertia of a shell is that of the solid" if shell else ""
        return Geom(kind, element, where, size, group, own and placed(own, where), shape, problem)

    def _size(self, element: Element, kind: str) -> tuple[float, ...]:
        """Return the numbers of the size that the type has."""
        values = [word for word in element.get("size").replace(",", " ").split()]
        wanted = 1 if "fromto" in element.attributes else SIZES[kind]
        if len(values) < wanted:
            raise element.error(f"expected {wanted} numbers for the size of a {kind}, got {len(values)}")
        return element.numbers("size", len(values))[:wanted]

    def _mass(self, element: Element, volume: float) -> float:
        """Return the mass of a geom, from its own or its density."""
        mass = (
            element.number("mass")
            if "mass" in element.attributes
            else element.number("density", DENSITY) * volume
        )
        if mass < 0:
            raise element.error(f"expected a mass or density that is not negative, got {mass:g} kg")
        return mass

    def _mesh(self, element: Element, group: int, where: Pose, body: str, massive: bool) -> Geom:
        """Return the geom of a mesh: its solid where it is, not about its mass centre."""
        name = element.get("mesh")
        asset = self.assets.get(name)
        if asset is None:
            raise element.error(f"unknown mesh '{name}'")
        own = shape = None
        problem = ""
        massless = element.number("density", DENSITY) == 0 or element.number("mass", 1) == 0
        try:
            if massive and not massless:
                solid = self.solid(name, asset)
                mass = self._mass(element, solid.volume)
                inertia: Any = tuple(tuple(mass / solid.volume * x for x in row) for row in solid.inertia)
                own = placed(MassProperties.as_given(mass, solid.center, inertia, possible=False), where)
        except FormatError as error:
            problem = f"{name}: {error}"
        if not problem and self.drawn and group < SHOWN_GROUPS and "file" in asset.attributes:
            meshes = self.document.meshes

            def unread(problem: str) -> None:
                rule = "a mesh that cannot be read is not drawn"
                meshes.reading.left_out(f"<geom> of body '{body}'", element.line, rule, f"{name}: {problem}")

            try:
                reference = _reference(asset)
                found = meshes.shape(self._file(asset), lambda points: _moved(points, *reference), unread)
                shape = placed(found, where)
            except FormatError as error:
                unread(str(error))
        return Geom("mesh", element, where, (), group, own, shape, problem)

    def _file(self, asset: Element) -> str:
        """Return the path of a mesh as the compiler's settings have it."""
        name = asset.get("file")
        return name.replace("\\", "/").rpartition("/")[2] if self.document.compiler.strippath else name

    def solid(self, name: str, asset: Element) -> Solid:
        """Return volume, mass centre and inertia of a mesh of density 1."""
        if name not in self.solids:
            way = asset.choice("inertia", ("legacy", "convex", "exact", "shell"), "legacy")
            self.solids[name] = mesh_solid(*self.surface(asset), way)
        return self.solids[name]

    def surface(self, asset: Element) -> tuple[Any, Any]:
        """Return vertices and triangles of a mesh; no triangles if the file gives none."""
        triangles: Any = None
        if "file" in asset.attributes:
            points, triangles = self.document.meshes.surface(self.document.meshes.path(self._file(asset)))
        else:
            numbers = asset.several("vertex")
            if not numbers or len(numbers) % 3:
                raise FormatError(f"expected three numbers for each vertex, got {len(numbers)} numbers")
            points = np.array(numbers).reshape(-1, 3)
            if "face" in asset.attributes:
                triangles = triangles_of(asset.several("face"), len(points), "face=")
        points = points.astype(np.float32).astype(float)  # the vertices of MuJoCo are of single precision
        return _moved(points, *_reference(asset)), triangles


def _moved(points: np.ndarray, refpos: np.ndarray, refquat: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Return the points of a file in the axes of its geom; the scale acts after the turn of ``refquat``."""
    return (points - refpos) @ refquat * scale


def _reference(asset: Element) -> tuple[Any, Any, Any]:
    """Return origin and axes of a mesh's coordinates, and its scale."""
    R = of_quaternion(asset, asset.numbers("refquat", 4, (1, 0, 0, 0)))
    refpos, scale = asset.numbers("refpos", 3, (0, 0, 0)), asset.numbers("scale", 3, (1, 1, 1))
    return np.array(refpos, float), np.array(R, float), np.array(scale, float)


def volume(kind: str, size: Sequence[float]) -> float:
    """Return the volume of a solid of these half sizes.

    >>> volume("box", (1, 2, 3))
    48
    """
    match kind:
        case "sphere":
            return 4 * math.pi * size[0] ** 3 / 3
        case "capsule":
            return math.pi * (size[0] ** 2 * 2 * size[1] + 4 * size[0] ** 3 / 3)
        case "cylinder":
            return math.pi * size[0] ** 2 * 2 * size[1]
        case "ellipsoid":
            return 4 * math.pi * size[0] * size[1] * size[2] / 3
        case _:
            return 8 * size[0] * size[1] * size[2]


def _diagonal(m: float, kind: str, size: Sequence[float]) -> Any:
    """Return the inertia of a solid about its centre."""
    a, b, c = (*size, *size, *size)[:3]
    match kind:
        case "sphere":
            x = y = z = 2 * m * a * a / 5
        case "ellipsoid":
            x, y, z = m * (b * b + c * c) / 5, m * (a * a + c * c) / 5, m * (a * a + b * b) / 5
        case "box":
            x, y, z = m * (b * b + c * c) / 3, m * (a * a + c * c) / 3, m * (a * a + b * b) / 3
        case _:
            r, h = size[0], 2 * size[1]
            ends = m * 4 * r / (4 * r + 3 * h) if kind == "capsule" else 0
            tube = m - ends
            x = tube * (3 * r * r + h * h) / 12 + 2 * ends * r * r / 5 + ends * h * (3 * r + 2 * h) / 8
            y, z = x, tube * r * r / 2 + 2 * ends * r * r / 5
    return ((x, 0, 0), (0, y, 0), (0, 0, z))


def shape_of(kind: str, size: Sequence[float]) -> Shape:
    """Return the solid that is drawn."""
    match kind:
        case "sphere":
            return Shape("sphere", (("radius", size[0]),))
        case "ellipsoid":
            return Shape("ellipsoid", tuple(zip("abc", size, strict=True)))
        case "box":
            return Shape("box", tuple((name, 2 * x) for name, x in zip("xyz", size, strict=True)))
    tube = Shape("cylinder", (("radius", size[0]), ("length", 2 * size[1])))
    if kind == "cylinder":
        return tube
    ball = Shape("sphere", (("radius", size[0]),))
    ends = [replace(ball, center=(0, 0, z)) for z in (size[1], -size[1])]
    result = compound(compound(tube, ends[0]), ends[1])
    assert result is not None
    return result
