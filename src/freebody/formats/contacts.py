"""Solids of a robot's links as shapes of contacts, and the floor that they touch.

A solid touches a plane at its corners, a capsule at the spheres and a cylinder at the circles of its ends.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import FreebodyError, ModelError, nearest, shown
from ..space.pose import Pose
from .xml_tree import Element

MOST = 100
"""Most corners of a mesh that touches: each is a contact of its own."""
FLOOR = ("at", "normal", "friction")
"""What a mapping ``contacts=`` may say of the floor."""
FRICTION = 1.0
"""Coefficient of friction where neither the file nor the user gives one, as in MJCF."""


@dataclass(frozen=True)
class Solid:
    """A solid of a link, or a plane of the world, in the axes of the ``body`` of the system that carries it.

    ``sizes`` are a radius, half lengths along z, half edges or half axes, in the order of MJCF; ``vertices`` those of a
    mesh.
    """

    name: str
    what: str
    element: Element
    body: Any
    pose: Pose
    kind: str
    sizes: tuple[float, ...] = ()
    vertices: Any = None


def check_contacts(value: Any) -> None:
    """Raise ModelError for a value of ``contacts=`` that does not exist."""
    if value is None or (isinstance(value, str) and value == "floor"):
        return
    if not isinstance(value, Mapping):
        raise ModelError(
            f"Expected contacts= None, 'floor' or a mapping that gives a floor, such as {{'friction': 0.8}}, got "
            f"{shown(value)}."
        )
    for key in value:
        if key not in FLOOR:
            raise ModelError(f"Unknown key {key!r} of contacts=; {nearest(str(key), FLOOR)}")


def shapes_of(solid: Solid) -> list[Any]:
    """Return the shapes by which a solid touches a plane; ModelError if it has none."""
    body, place, R = solid.body, solid.pose.point, solid.pose.rotation.matrix
    match solid.kind:
        case "sphere":
            return [body.sphere(solid.sizes[0], at=solid.pose.position)]
        case "capsule":
            radius, half = solid.sizes
            return [body.capsule(place((0, 0, -half)), place((0, 0, half)), radius)]
        case "cylinder":
            radius, half = solid.sizes
            axis = tuple(row[2] for row in R)
            return [body.circle(radius, at=place((0, 0, z)), axis=axis) for z in (-half, half)]
        case "box":
            signs = ((x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1))
            edges = [tuple(s * a for s, a in zip(one, solid.sizes, strict=True)) for one in signs]
            return [body.corners(*map(place, edges))]
        case "ellipsoid":
            # along the body's axes: each row of R has one entry, ±1
            if not all(x in (-1, 0, 1) for row in R for x in row):
                raise ModelError("an ellipsoid that is turned in its body has no law of contact")
            half_axes = tuple(sum(abs(x) * a for x, a in zip(row, solid.sizes, strict=True)) for row in R)
            return [body.ellipsoid(half_axes, at=solid.pose.position)]
        case "mesh":
            return [body.corners(*(place(tuple(v)) for v in hull_of(solid.vertices).tolist()))]
    raise ModelError(f"a {solid.kind} has no law of contact with a plane")


def hull_of(vertices: Any) -> Any:
    """Return the corners of the convex hull of a mesh; ModelError if there are more than :data:`MOST`."""
    from scipy.spatial import ConvexHull, QhullError

    points = np.unique(np.asarray(vertices, float), axis=0)
    try:
        corners = points[np.sort(ConvexHull(points).vertices)]
    except (QhullError, ValueError):
        raise ModelError("a flat mesh has no hull") from None
    if len(corners) > MOST:
        raise ModelError(f"a mesh of more than {MOST} corners is not read: give its link a simpler solid")
    return corners


def touch(builder: Any, solid: Solid, plane: Any, floor: str, friction: float) -> None:
    """Let a solid touch a plane, or report why it does not."""
    try:
        shapes = shapes_of(solid)
    except FreebodyError as error:
        builder.reading.left_out(
            solid.what, solid.element.line, "it does not touch the floor", str(error).rstrip(".")
        )
        return
    mu = builder.coefficient(friction)
    for shape in shapes:
        name = builder.renamed(f"{solid.name}_{floor}", builder.joints)
        builder.s.contact(name, shape, plane, friction=mu)
    builder.reading.counts["contact"] += len(shapes)


def given_floor(builder: Any, line: int, why: str) -> tuple[Any, float | None]:
    """Return the plane that ``contacts=`` gives, by default z = 0, and its coefficient of friction."""
    option = builder.options.contacts
    given = dict(option) if isinstance(option, Mapping) else {}
    friction = given.pop("friction", None)
    plane = builder.s.ground.plane(**{"normal": "z", **given})
    if option == "floor":
        builder.reading.changed("the floor", line, f"the plane z = 0, {why}; contacts={{...}} gives another")
    return plane, friction
