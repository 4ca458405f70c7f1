"""Contacts of a URDF file: solids of <collision> touch each other, and a floor, of which the format says nothing."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...errors import FormatError
from ...space.pose import Pose
from ...space.rotation import Rotation
from ..contacts import FRICTION, Solid, between_bodies, given_floor, touch, touch_each_other
from ..meshes import Meshes
from ..xml_tree import Element
from .link import Link
from .origin import pose_of


def add_contacts(reader: Any, meshes: Meshes) -> None:
    """Let the solids of all links that move touch the floor and each other, or report that nothing touches."""
    links = [link for link in reader.robot.links.values() if link.collisions]
    reading, option = reader.reading, reader.options.contacts
    if not links:
        return
    first = links[0]
    if option is None:
        for link in links:
            reading.left_out(
                f"link '{link.name}'",
                link.element.line,
                "nothing touches its <collision>, which contacts='floor' reads",
            )
        return
    plane, friction = given_floor(reader, first.element.line, "of friction 1, since the format has no floor")
    friction = FRICTION if friction is None else friction
    bodies, solids = between_bodies(option), []
    for link in links:
        point, axes = reading.frames[link.name]
        if point.body is reader.s.ground and not bodies:
            continue
        pose = Pose(Rotation.trusted(axes), point.components)
        solids += list(_solids(reader, link, point.body, pose, meshes))
    for solid in solids:
        if solid.body is not reader.s.ground:
            touch(reader, solid, plane, "floor", friction)
    if bodies:
        # a robot's fixed base is one of its links
        joints = [joint for joint in reader.s.joints.values() if joint.parent is reader.s.ground]
        touch_each_other(reader, [solids], lambda i, j: friction, [(one.parent, one.child) for one in joints])
    else:
        reading.left_out(
            "the links",
            first.element.line,
            "they touch the floor and not each other, which contacts='all' reads",
        )


def _solids(reader: Any, link: Link, body: Any, pose: Pose, meshes: Meshes) -> Iterator[Solid]:
    """Iterate over the solids of <collision> of a link; report those that cannot be read."""
    for part in link.collisions:
        geometry = part.first("geometry")
        if geometry is None or not geometry.children:
            continue
        one = geometry.children[0]
        what = f"link '{link.name}', <collision>"
        try:
            sizes, vertices = _sizes(one, meshes)
        except FormatError as error:
            reader.reading.left_out(what, one.line, "it does not touch the floor", str(error))
            continue
        yield Solid(link.name, what, one, body, pose @ pose_of(part), one.tag, sizes, vertices)


def _sizes(solid: Element, meshes: Meshes) -> tuple[tuple[float, ...], Any]:
    """Return the sizes of a solid, or the vertices of a mesh."""
    match solid.tag:
        case "box":
            sizes = tuple(x / 2 for x in solid.numbers("size", 3))
        case "cylinder" | "capsule":
            sizes = (solid.number("radius"), solid.number("length") / 2)
        case "sphere":
            sizes = (solid.number("radius"),)
        case "mesh":
            vertices, _ = meshes.surface(meshes.path(solid.get("filename")))
            return (), vertices * np.array(solid.numbers("scale", 3, (1.0, 1.0, 1.0)))
        case tag:
            raise FormatError(f"a {tag} is not a solid of URDF")
    if any(x <= 0 for x in sizes):
        raise FormatError("a solid without size")
    return sizes, None
