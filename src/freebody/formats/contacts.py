"""Solids of a robot's links as shapes of contacts: they touch a floor, and each other in families.

A solid touches a plane at its corners, a capsule at the spheres and a cylinder at the edges of its ends. Spheres,
capsules, boxes and hulls touch each other, and spheres touch cylinders; a family has one coefficient of friction.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..describe.shapes.shape import may_touch
from ..errors import FreebodyError, ModelError, nearest, shown
from ..space.pose import Pose
from .xml_tree import Element

MOST = 100
"""Most corners of a mesh that touches: each is a contact of its own."""
FLOOR = ("at", "normal", "friction")
"""What a mapping ``contacts=`` may say of the floor."""
BODIES = ("bodies", "apart")
"""What it may say of contacts between bodies: whether there are any, and pairs of links without."""
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
    if value is None or (isinstance(value, str) and value in ("floor", "all")):
        return
    if not isinstance(value, Mapping):
        raise ModelError(
            f"Expected contacts= None, 'floor', 'all' or a mapping that gives a floor, such as {{'friction': 0.8}}, "
            f"got {shown(value)}."
        )
    for key in value:
        if key not in (*FLOOR, *BODIES):
            raise ModelError(f"Unknown key {key!r} of contacts=; {nearest(str(key), (*FLOOR, *BODIES))}")
    if not isinstance(value.get("bodies", True), bool):
        raise ModelError(f"Expected 'bodies' of contacts= True or False, got {shown(value['bodies'])}.")


def between_bodies(option: Any) -> bool:
    """Return True if ``contacts=`` lets bodies touch each other."""
    if isinstance(option, Mapping):
        return bool(option.get("bodies", "apart" in option))
    return bool(option == "all")


def gives_floor(option: Any) -> bool:
    """Return True if ``contacts=`` says where the floor is, or its friction."""
    return isinstance(option, Mapping) and any(key in option for key in FLOOR)


def shape_of(solid: Solid) -> Any:
    """Return the shape by which a solid touches a plane; ModelError if it has none."""
    body, place, R = solid.body, solid.pose.point, solid.pose.rotation.matrix
    match solid.kind:
        case "sphere":
            return body.sphere(solid.sizes[0], at=solid.pose.position)
        case "capsule":
            radius, half = solid.sizes
            return body.capsule(place((0, 0, -half)), place((0, 0, half)), radius)
        case "cylinder":
            radius, half = solid.sizes
            axis = tuple(row[2] for row in R)
            return body.drum(radius, 2 * half, at=solid.pose.position, axis=axis)
        case "box":
            return body.corners(*corners_of(solid))
        case "ellipsoid":
            # along the body's axes: each row of R has one entry, ±1
            if not all(x in (-1, 0, 1) for row in R for x in row):
                raise ModelError("an ellipsoid that is turned in its body has no law of contact")
            half_axes = tuple(sum(abs(x) * a for x, a in zip(row, solid.sizes, strict=True)) for row in R)
            return body.ellipsoid(half_axes, at=solid.pose.position)
        case "mesh":
            return body.corners(*(place(tuple(v)) for v in hull_of(solid.vertices).tolist()))
    raise ModelError(f"a {solid.kind} has no law of contact with a plane")


def solid_of(solid: Solid) -> Any:
    """Return the shape by which a solid touches other solids; ModelError if it has none."""
    body, R = solid.body, solid.pose.rotation.matrix
    match solid.kind:
        case "box" if all(x in (-1, 0, 1) for row in R for x in row):
            edges = tuple(2 * sum(abs(x) * a for x, a in zip(row, solid.sizes, strict=True)) for row in R)
            return body.box(edges, at=solid.pose.position)
        case "box":
            return body.hull(*corners_of(solid))
        case "mesh":
            return body.hull(*(solid.pose.point(tuple(v)) for v in hull_of(solid.vertices).tolist()))
        case "sphere" | "capsule" | "cylinder":
            return shape_of(solid)
    article = "an" if solid.kind[0] in "aeiou" else "a"
    raise ModelError(f"{article} {solid.kind} has no law of contact with solids")


def corners_of(box: Solid) -> list[Any]:
    """Return the corners of a box."""
    signs = ((x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1))
    return [box.pose.point(tuple(s * a for s, a in zip(one, box.sizes, strict=True))) for one in signs]


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
        shape = shape_of(solid)
    except FreebodyError as error:
        builder.reading.left_out(
            solid.what, solid.element.line, "it does not touch the floor", str(error).rstrip(".")
        )
        return
    name = builder.renamed(f"{solid.name}_{floor}", builder.joints)
    builder.s.contact(name, shape, plane, friction=builder.coefficient(friction))
    builder.reading.counts["contact"] += 1


def given_floor(builder: Any, line: int, why: str) -> tuple[Any, float | None]:
    """Return the plane that ``contacts=`` gives, by default z = 0, and its coefficient of friction."""
    option = builder.options.contacts
    given = {key: option[key] for key in FLOOR if key in option} if isinstance(option, Mapping) else {}
    friction = given.pop("friction", None)
    plane = builder.s.ground.plane(**{"normal": "z", **given})
    if not gives_floor(option):
        builder.reading.changed("the floor", line, f"the plane z = 0, {why}; contacts={{...}} gives another")
    return plane, friction


# -- bodies ---------------------------------------------------------------------------------------------


def touch_each_other(
    builder: Any,
    groups: Sequence[Sequence[Solid]],
    friction: Callable[[int, int], float | None],
    apart: Sequence[tuple[Any, Any]] = (),
) -> None:
    """Let solids touch each other, by ``friction(i, j)`` of their groups: None if these do not touch.

    ``apart`` are pairs of bodies that do not touch; those that ``contacts=`` names are among them.
    """
    shapes = [list(_shapes(builder, group)) for group in groups]
    apart = [*apart, *_named_apart(builder)]
    for mu, own, others in _families(len(groups), friction):
        first = list(dict.fromkeys(shape for i in own for shape in shapes[i]))
        second = list(dict.fromkeys(shape for i in others for shape in shapes[i]))
        for some, against in _with_laws(first, second):
            if all(a.body is b.body for a in some for b in against or some):
                continue
            name = builder.renamed("bodies", builder.joints)
            builder.s.contacts(
                name,
                some,
                against=against,
                friction=builder.coefficient(mu),
                apart=list(dict.fromkeys(apart)),
            )
            builder.reading.counts["family"] += 1


def _with_laws(first: list[Any], second: list[Any]) -> Iterator[tuple[list[Any], list[Any]]]:
    """Iterate over families of shapes of which all pairs have a law: drums touch spheres alone."""

    def drums(shapes: list[Any]) -> list[Any]:
        return [shape for shape in shapes if not may_touch(type(shape), type(shape))]

    def others(shapes: list[Any]) -> list[Any]:
        return [shape for shape in shapes if may_touch(type(shape), type(shape))]

    if not second or (others(first) and others(second)):
        yield others(first), others(second)
    for some, against in ((first, second or first), *(((second, first),) if second else ())):
        balls = [x for x in others(some) if all(may_touch(type(x), type(drum)) for drum in drums(against))]
        if balls and drums(against):
            yield balls, drums(against)


def _shapes(builder: Any, solids: Sequence[Solid]) -> Iterator[Any]:
    """Iterate over the shapes of solids; report those that have none, or that do not touch all others."""
    for solid in solids:
        what, line = solid.what, solid.element.line
        try:
            shape = solid_of(solid)
        except FreebodyError as error:
            builder.reading.left_out(what, line, "it does not touch other bodies", str(error).rstrip("."))
            continue
        if not may_touch(type(shape), type(shape)):
            reason = f"a {solid.kind} has no law of contact with other solids"
            builder.reading.left_out(what, line, "of other bodies it touches spheres alone", reason)
        yield shape


def _named_apart(builder: Any) -> Iterator[tuple[Any, Any]]:
    """Iterate over the pairs of bodies whose links ``contacts=`` holds apart."""
    option = builder.options.contacts
    frames = builder.reading.frames
    for pair in option.get("apart", ()) if isinstance(option, Mapping) else ():
        if isinstance(pair, str) or not isinstance(pair, Sequence) or len(pair) != 2:
            raise ModelError(
                f"Expected pairs of links for 'apart' of contacts=, such as [('hand', 'arm')], got {shown(pair)}."
            )
        for name in pair:
            if name not in frames:
                raise ModelError(
                    f"Unknown link {name!r} in 'apart' of contacts=; {nearest(str(name), frames)}"
                )
        first, second = (frames[name][0].body for name in pair)
        if first is not second:
            yield first, second


def _families(
    count: int, friction: Callable[[int, int], float | None]
) -> Iterator[tuple[float, list[int], list[int]]]:
    """Iterate over families of groups: a coefficient, groups, and those that these touch if not each other."""
    laws = {(i, j): friction(i, j) for i in range(count) for j in range(i, count)}
    for mu in dict.fromkeys(mu for mu in laws.values() if mu is not None):
        pairs = {pair for pair, value in laws.items() if value == mu}
        mutual: list[int] = []
        for i in range(count):
            if all((j, i) in pairs for j in (*mutual, i)):
                mutual.append(i)
        if mutual:
            yield mu, mutual, []
        pairs -= {(i, j) for i in mutual for j in mutual}
        for i in range(count):
            if (i, i) in pairs:
                yield mu, [i], []
            others = [j for j in range(i + 1, count) if (i, j) in pairs]
            if others:
                yield mu, [i], others
