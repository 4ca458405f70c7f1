"""Links of a URDF file: masses, solids that are shown or touch, and colour.

Source: the XML specification of URDF (ROS wiki, urdf/XML), and what its reference reader (urdfdom) accepts.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from ...errors import FormatError
from ...scalar.algebra import ZERO
from ...space.mass import MassProperties
from ...space.shape import Shape, compound
from ..builder import NOTHING_MASSIVE, placed
from ..meshes import Meshes
from ..reading import Reading
from ..xml_tree import Element
from .origin import pose_of
from .words import say_unknown


@dataclass(frozen=True)
class Link:
    """Mass properties in the link's axes, with the solids that are shown, and the colour of these."""

    name: str
    element: Element
    properties: MassProperties
    color: str = ""
    collisions: tuple[Element, ...] = ()


def link(element: Element, materials: dict[str, Element], reading: Reading, meshes: Meshes | None) -> Link:
    """Return a link."""
    name, what = element.get("name"), f"link '{element.get('name')}'"
    shown = [shape for part in element.all("visual") for shape in _solids(part, what, reading, meshes)]
    if not shown:
        shown = [shape for part in element.all("collision") for shape in _solids(part, what, reading, meshes)]
    collisions = tuple(element.all("collision"))
    colour = next((c for part in element.all("visual") if (c := _color(part, materials))), "")
    say_unknown(element, what, reading)
    inertial = element.first("inertial")
    properties = NOTHING_MASSIVE if inertial is None else _massive(inertial, what, reading)
    return Link(name, element, replace(properties, shape=reduce(compound, shown, None)), colour, collisions)


def _massive(inertial: Element, what: str, reading: Reading) -> MassProperties:
    """Return the mass properties of a link, in its axes, whether a body can have them or not."""
    mass = inertial.first("mass")
    m = 0.0 if mass is None else mass.number("value")
    if m < 0:
        raise inertial.error(f"expected a mass of {what} that is not negative, got {m:g} kg")
    values = [0.0] * 6
    inertia = inertial.first("inertia")
    if inertia is not None:
        names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        turned = {"ixy": "iyx", "ixz": "izx", "iyz": "izy"}
        for i, name in enumerate(names):
            other = turned.get(name, name)
            values[i] = inertia.number(name if name in inertia.attributes else other, 0.0)
    if m == 0 and any(values):
        reading.changed(what, inertial.line, "an inertia without mass is kept as it is")
    xx, xy, xz, yy, yz, zz = values
    own = MassProperties.as_given(m, ZERO, ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)), possible=False)
    return placed(own, pose_of(inertial, reading))


def _solids(part: Element, what: str, reading: Reading, meshes: Meshes | None) -> list[Shape]:
    """Return the solid of a visual or collision element, in the link's axes."""
    geometry = part.first("geometry")
    if geometry is None or not geometry.children:
        return []
    solid = geometry.children[0]
    if solid.tag == "box":
        x, y, z = solid.numbers("size", 3)
        shape = Shape("box", (("x", x), ("y", y), ("z", z)))
    elif solid.tag == "cylinder":
        shape = Shape("cylinder", (("radius", solid.number("radius")), ("length", solid.number("length"))))
    elif solid.tag == "sphere":
        shape = Shape("sphere", (("radius", solid.number("radius")),))
    elif solid.tag == "mesh" and meshes is not None:
        name = solid.attributes.get("filename", "").rpartition("/")[2][:60]

        def unread(problem: str) -> None:
            rule = "a mesh that cannot be read is not drawn"
            reading.left_out(f"{what}, <{part.tag}>", solid.line, rule, f"{name}: {problem}")

        try:
            scale = np.array(solid.numbers("scale", 3, (1.0, 1.0, 1.0)))
            return [
                placed(
                    meshes.shape(solid.get("filename"), lambda points: points * scale, unread), pose_of(part)
                )
            ]
        except FormatError as error:
            unread(str(error))
            return []
    else:
        reading.left_out(f"{what}, <{part.tag}>", solid.line, f"a {solid.tag} is not drawn")
        return []
    if any(size <= 0 for _, size in shape.dimensions):
        reading.left_out(f"{what}, <{part.tag}>", solid.line, "a solid without size is not drawn")
        return []
    return [placed(shape, pose_of(part))]


def _color(part: Element, materials: dict[str, Element]) -> str:
    """Return the colour of a visual element as "#rrggbb", or nothing."""
    material = part.first("material")
    if material is not None and material.first("color") is None:
        material = materials.get(material.attributes.get("name", ""), material)
    color = None if material is None else material.first("color")
    if color is None:
        return ""
    r, g, b, _ = color.numbers("rgba", 4)
    return "#" + "".join(f"{round(255 * min(max(x, 0.0), 1.0)):02x}" for x in (r, g, b))
