"""What the bodies of a model look like: primitives in body axes, from solids, wheels and the points that joints need.

The solid a body was made from is drawn as it is. Where a joint takes hold beside the solid, as a gyroscope's pivot
does, a rod leads there. A body that was given by numbers alone is drawn by what is known of it: the wheel that rolls,
rods between the points of its joints, or else the ellipsoid of its inertia.

The file is longer than others: what is drawn of a body depends on what is drawn of its joints.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...describe.constraints.constraint import Rolling, Rope
from ...describe.contact_shapes import Tether, kind_of
from ...describe.frame import Point
from ...describe.loads.load import Damper, Force, Spring
from ...dynamics.state import State, float_state
from ...errors import ModelError
from ...model.closure import Closure
from ...model.model import Model, Place
from ...scalar.algebra import floats
from ...scalar.expression import evaluate
from ...space.shape import Shape
from ..paper.palette import BODY_FILLS, pale

Array = NDArray[np.float64]

PARTICLE = 0.045
"""Radius of a particle, in parts of the size of the machine."""

ROD = 0.012
"""Radius of a rod that has none, in parts of the size of the machine."""

AXIAL = ("slender_bar", "disk", "ring", "cylinder", "tube", "cone", "torus", "plate", "rod", "revolved")


@dataclass(frozen=True)
class Primitive:
    """One piece of a body, in body axes.

    Attributes
    ----------
    kind : str
        ``particle`` (dimension ``radius``), ``rod`` (``length``, ``radius``), ``slender_bar`` (``length``), ``disk``,
        ``ring`` (``radius``), ``cylinder`` (``radius``, ``length``), ``tube`` (``inner``, ``outer``, ``length``),
        ``cone`` (``radius``, ``height``), ``box`` (``x``, ``y``, ``z``: whole edges), ``plate`` (``a``, ``b``),
        ``sphere``, ``spherical_shell`` (``radius``), ``ellipsoid`` (``a``, ``b``, ``c``: half axes), ``torus``
        (``major``, ``minor``), ``mesh`` (arrays ``vertices``, ``faces``) or ``revolved`` (array
        ``profile`` of rows: height, radius, inner radius).
    dimensions : dict
        Numbers [m].
    center : array (3,)
        From the body's origin, in body axes [m]; the mass centre of the piece, but for ``revolved`` and ``mesh``.
    axes : array (3, 3)
        Columns are the piece's own axes in body axes; the third one is the symmetry axis of an axial piece, from base
        to apex of a cone. A plate has its edges a and b along the first and second.
    hole : bool
        Whether the piece is taken away.
    solid : bool
        Whether it carries the mass; rods that only lead to a joint do not.
    """

    kind: str
    dimensions: dict[str, Any]
    center: Array = field(default_factory=lambda: np.zeros(3))
    axes: Array = field(default_factory=lambda: np.eye(3))
    hole: bool = False
    solid: bool = True

    def __getitem__(self, name: str) -> Any:
        return self.dimensions[name]

    @property
    def axis(self) -> Array:
        """The symmetry axis (or normal), in body axes."""
        return self.axes[:, 2]

    def points(self) -> Array:
        """Points in body axes whose convex hull holds the piece, shape (n, 3) [m]."""
        local = self["vertices"] if self.kind == "mesh" else list(product(*zip(*self.box(), strict=True)))
        return self.center + np.asarray(local, dtype=float) @ self.axes.T

    def box(self) -> tuple[Array, Array]:
        """Least and greatest components along the piece's own axes, from ``center`` [m]."""
        d = self.dimensions
        if self.kind == "mesh":
            vertices = np.asarray(d["vertices"], dtype=float)
            return vertices.min(axis=0), vertices.max(axis=0)
        high = np.array(self.half(), dtype=float)
        low = -high
        if self.kind == "cone":
            low[2], high[2] = -d["height"] / 4, 3 * d["height"] / 4
        elif self.kind == "revolved":
            z = np.asarray(d["profile"], dtype=float)[:, 0]
            low[2], high[2] = z.min(), z.max()
        return low, high

    @property
    def middle(self) -> Array:
        """Of its box, in body axes: a mesh or a solid of revolution may lie beside its ``center``."""
        low, high = self.box()
        return np.asarray(self.center + self.axes @ ((low + high) / 2))

    def half(self) -> tuple[float, float, float]:
        """Half of the extent along the piece's own axes [m]."""
        d = self.dimensions
        if self.kind in ("particle", "sphere", "spherical_shell"):
            return (d["radius"],) * 3
        if self.kind == "ellipsoid":
            return (d["a"], d["b"], d["c"])
        if self.kind == "box":
            return (d["x"] / 2, d["y"] / 2, d["z"] / 2)
        if self.kind == "plate":
            return (d["a"] / 2, d["b"] / 2, 0.0)
        if self.kind == "torus":
            return (d["major"] + d["minor"],) * 2 + (d["minor"],)
        if self.kind == "revolved":
            r = np.abs(np.asarray(d["profile"], dtype=float)[:, 1]).max()
            return (float(r), float(r), 0.0)
        radius = d.get("radius", d.get("outer", 0.0))
        return (radius, radius, d.get("length", d.get("height", 0.0)) / 2)


def shapes(
    model: Model, values: Mapping[Any, Any] | None = None, size: float | None = None
) -> dict[str, tuple[Primitive, ...]]:
    """The pieces of every body by name, at values of the parameters.

    Parameters
    ----------
    model : Model
    values : mapping, optional
        Of parameters, in place of their defaults.
    size : float, optional
        Length that particles and rods without a thickness are drawn in parts of [m]; that of the machine if not given.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> bar = s.body("bar", fb.slender_bar(1, 2, axis="y"))
    >>> pin = s.hinge("pin", s.ground, bar, to=(0, 1, 0), coordinate="theta")
    >>> (piece,) = shapes(fb.assemble(s))["bar"]
    >>> piece.kind, piece["length"], piece.axis.tolist()
    ('slender_bar', 2.0, [0.0, 1.0, 0.0])
    """
    state = float_state(model, values=values)
    length = machine_size(model, values) if size is None else size
    return {name: tuple(_body(model, state, name, place, length)) for name, place in model.bodies.items()}


def colors(model: Model) -> dict[str, str]:
    """The colours that were chosen for bodies, by name."""
    found = {}
    for name, place in model.bodies.items():
        shape = place.properties.shape if place.properties is not None else None
        if shape is not None and shape.color:
            found[name] = shape.color
    return found


def fill_of(model: Model, body: str) -> str:
    """What a body is filled with in a line drawing: a pale one of the colour chosen, or of its place in the model."""
    chosen = colors(model)
    place = list(model.bodies).index(body)
    return pale(chosen[body]) if body in chosen else BODY_FILLS[place % len(BODY_FILLS)]


def machine_size(model: Model, values: Mapping[Any, Any] | None = None) -> float:
    """A length that is typical of the machine: the greatest distance of its joints or extent of its solids [m]."""
    state = float_state(model, values=values)
    longest = 0.0
    for name, place in model.bodies.items():
        at = [p for p in attachments(model, state, name).values()]
        shape = place.properties.shape if place.properties is not None else None
        if shape is not None and shape.kind != "particle":
            for piece in _pieces(state, shape, 0.0):
                at += list(piece.points())
        if at:
            span = np.ptp(np.array([*at, np.zeros(3)]), axis=0)
            longest = max(longest, float(np.linalg.norm(span)))
    for joint in model.joints.values():
        if joint.parent == "ground":
            longest = max(longest, float(np.linalg.norm([float(x) for x in state.vector(joint.at)])))
    return longest if longest > 0 else 1.0


def attachments(model: Model, state: State, body: str) -> dict[str, Array]:
    """Points of a body, in its axes from its origin, that joints, ropes, springs and forces take hold of, by name."""
    found: dict[str, Array] = {}

    def put(name: str, components: Any) -> None:
        found[name] = np.array([float(x) for x in state.vector(components)])

    for name, joint in model.joints.items():
        if joint.type not in ("free", "planar"):  # these hold no point of the body
            if joint.child == body:
                put(name, joint.to)
            elif joint.parent == body:
                put(name, joint.at)
    for name, one in model.constraints.items():
        if isinstance(one, Closure):
            if one.child.name == body:
                put(name, one.to)
            elif one.parent.name == body:
                put(name, one.at)
        elif isinstance(one, Rolling) and one.center.body.name == body:
            put(name, one.center.components)
    for name, points in ropes_of(model).items():
        for k, point in enumerate(points):
            if point.body.name == body:
                put(f"{name} {k}", point.components)
    for name, load in model.loads.items():
        ends: tuple[Any, ...] = (load.point,) if isinstance(load, Force) else ()
        if isinstance(load, Spring | Damper):
            ends = (load.start, load.end)
        for point in ends:
            if point.body.name == body:
                put(name, point.components)
    return found


def ropes_of(model: Model) -> dict[str, tuple[Point, ...]]:
    """The points of every rope, of those that may go slack too, by name."""
    result = {name: one.points for name, one in model.constraints.items() if isinstance(one, Rope)}
    for contact in model.contacts:
        if isinstance(contact.surface, Tether):
            result[contact.name] = (
                Point(contact.surface.body, contact.surface.at),
                contact.feature,
            )
    return result


def _body(model: Model, state: State, name: str, place: Place, size: float) -> list[Primitive]:
    shape = place.properties.shape if place.properties is not None else None
    at = attachments(model, state, name)
    center = np.array([float(x) for x in state.vector(place.center)])
    pieces = [] if shape is None else _pieces(state, shape, size)
    if not pieces:
        pieces = _wheels(model, state, name) or _skins(model, state, name)
    if not pieces:
        return _unknown(state, place, center, list(at.values()), size)
    solid = [piece for piece in pieces if not piece.hole]
    pieces += _bridges(solid, size)
    for point in _distinct(list(at.values()), size):
        if not any(holds(piece, point, 0.02 * size) for piece in (*solid, *pieces)):
            near = min(solid, key=lambda piece: float(np.linalg.norm(piece.middle - point)))
            pieces.append(rod(near.middle, point, ROD * size))
    for point in _distinct(_feet(model, state, name), size):
        if not any(holds(piece, point, 0.02 * size) for piece in solid):
            ends = [_nearest(piece, point) for piece in solid]
            pieces.append(rod(min(ends, key=lambda q: float(np.linalg.norm(q - point))), point, ROD * size))
    return pieces


def _bridges(solid: list[Primitive], size: float) -> list[Primitive]:
    """Rods between particles of one body and its next piece."""
    return [
        rod(one.middle, other.middle, ROD * size)
        for one, other in zip(solid, solid[1:], strict=False)
        if "particle" in (one.kind, other.kind) and not holds(one, other.middle, 0.02 * size)
    ]


def _nearest(piece: Primitive, point: Array) -> Array:
    """The point of a piece's box that is nearest to a point."""
    return np.asarray(
        piece.center + piece.axes @ np.clip(piece.axes.T @ (point - piece.center), *piece.box())
    )


def _feet(model: Model, state: State, body: str) -> list[Array]:
    """Points of a body that touch others: feet, axles, hangers."""
    return [
        np.array([float(x) for x in state.vector(shape.components)])
        for contact in model.contacts
        for shape in (contact.feature, contact.surface)
        if kind_of(shape) == "point" and shape.body.name == body
    ]


def _pieces(state: State, shape: Shape, size: float) -> list[Primitive]:
    if shape.kind == "compound":
        return [piece for part in shape.parts for piece in _pieces(state, part, size)]
    if shape.kind == "revolved":
        dimensions = _revolved(state, shape)
    else:
        dimensions = {name: _number(state, value) for name, value in shape.dimensions}
    for name, value in dimensions.items():
        least = value if isinstance(value, float) and name != "inner" else 1.0
        if not (least > 0 and math.isfinite(least)):
            raise ModelError(
                f"Expected positive dimensions to draw a {shape.kind.replace('_', ' ')}, got {name} = {value:g}. Give "
                f"other values to the parameters it depends on."
            )
    if shape.kind == "particle":
        dimensions["radius"] = PARTICLE * size
    R = np.array([[float(x) for x in row] for row in state.matrix(shape.axes)])
    own = np.eye(3)
    if shape.kind == "plate":
        k = int(np.argmax(np.abs([float(state(x)) for x in shape.axis])))
        own = np.eye(3)[:, [(k + 1) % 3, (k + 2) % 3, k]]
    elif shape.kind in AXIAL:
        own = turned_to(np.array([float(x) for x in state.vector(shape.axis)]))
    center = np.array([float(x) for x in state.vector(shape.center)])
    return [Primitive(shape.kind, dimensions, center, R @ own, shape.hole)]


def _revolved(state: State, shape: Shape) -> dict[str, Any]:
    """Sections of a solid of revolution: rows (height, radius, inner radius)."""
    low, high = (float(state(shape[name])) for name in ("lower", "upper"))
    rows = []
    for z in np.linspace(low, high, 33):
        lookup = {**state.values, shape["variable"]: float(z)}
        rows.append(
            (float(z), *(float(evaluate(shape[name], lookup, floats)) for name in ("profile", "inner")))
        )
    return {"profile": np.array(rows)}


def _number(state: State, value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value
    if isinstance(value, list | tuple):
        return np.array([_number(state, x) for x in value])
    return float(state(value))


def _wheels(model: Model, state: State, body: str) -> list[Primitive]:
    """A body that rolls is a disk (a sphere, where its contact has no axis) of the radius of its contact."""
    found = []
    for one in model.constraints.values():
        if isinstance(one, Rolling) and one.center.body.name == body:
            at = np.array([float(x) for x in state.vector(one.center.components)])
            radius = {"radius": float(state(one.radius))}
            if one.axis is None:
                found.append(Primitive("sphere", radius, at))
            else:
                axes = turned_to(np.array([float(x) for x in state.vector(one.axis)]))
                found.append(Primitive("disk", radius, at, axes))
    return found


def _skins(model: Model, state: State, body: str) -> list[Primitive]:
    """A body that touches with something round is as round as that."""
    found: dict[Any, Primitive] = {}
    for contact in model.contacts:
        for shape in (contact.feature, contact.surface):
            kind = kind_of(shape)
            if shape.body.name != body or kind not in ("sphere", "ellipsoid", "circle") or shape in found:
                continue
            at = np.array([float(x) for x in state.vector(shape.at)])
            if kind == "ellipsoid":
                a, b, c = (float(state(x)) for x in shape.half_axes)
                found[shape] = Primitive(kind, {"a": a, "b": b, "c": c}, at)
            elif not shape.inside:
                radius = {"radius": float(state(shape.radius))}
                round_about = (0, 0, 1) if kind == "sphere" else state.vector(shape.axis)
                axes = turned_to(np.array([float(x) for x in round_about]))
                found[shape] = Primitive("sphere" if kind == "sphere" else "disk", radius, at, axes)
    return list(found.values())


def _unknown(state: State, place: Place, center: Array, at: list[Array], size: float) -> list[Primitive]:
    """Rods between the points of the joints and the mass centre; of less than two points the ellipsoid of inertia."""
    mass = float(state(place.mass))
    inertia = np.array([[float(x) for x in row] for row in state.matrix(place.inertia)])
    points = _distinct(at, size)
    if len(points) < 2 and mass > 0:
        moments, axes = np.linalg.eigh((inertia + inertia.T) / 2)
        # m (b² + c²)/5 about the first axis, and so on
        squares = 5 / (2 * mass) * (moments.sum() - 2 * moments)
        a, b, c = np.sqrt(np.maximum(squares, 0.0))
        if max(a, b, c) > 0:
            if np.linalg.det(axes) < 0:
                axes = axes * np.array([1, 1, -1])
            thin = 0.02 * max(a, b, c)
            dimensions = {"a": max(a, thin), "b": max(b, thin), "c": max(c, thin)}
            result = [Primitive("ellipsoid", {k: float(v) for k, v in dimensions.items()}, center, axes)]
            return result + [
                rod(center, p, ROD * size) for p in points if not holds(result[0], p, 0.02 * size)
            ]
    hub = center if mass > 0 else points[0] if points else np.zeros(3)
    ends = _distinct(points, size)
    pieces = [rod(hub, p, ROD * size) for p in ends if float(np.linalg.norm(p - hub)) > 1e-9 * size]
    pieces += [rod(a, b, ROD * size) for a, b in zip(ends, ends[1:], strict=False)]
    return pieces or [Primitive("particle", {"radius": PARTICLE * size}, center, solid=mass > 0)]


def rod(start: Array, end: Array, radius: float) -> Primitive:
    """A round rod between two points, which carries no mass."""
    along = np.asarray(end, dtype=float) - start
    length = float(np.linalg.norm(along))
    return Primitive(
        "rod",
        {"length": length, "radius": radius},
        (np.asarray(start) + end) / 2,
        turned_to(along),
        solid=False,
    )


def turned_to(axis: Array) -> Array:
    """A rotation matrix whose third column lies along ``axis``."""
    n = axis / np.linalg.norm(axis)
    helper = np.eye(3)[int(np.argmin(np.abs(n)))]
    first = np.cross(helper, n)
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(n, first), n])


def _distinct(points: list[Array], size: float) -> list[Array]:
    result: list[Array] = []
    for p in points:
        if all(float(np.linalg.norm(p - q)) > 1e-6 * size for q in result):
            result.append(p)
    return result


def holds(piece: Primitive, point: Array, slack: float) -> bool:
    """Whether a point of a body, in its axes, lies in a piece, or on it."""
    x, y, z = piece.axes.T @ (point - piece.center)
    if piece.kind == "mesh":
        low, high = piece.box()
        return bool(np.all(low - slack <= (x, y, z)) and np.all((x, y, z) <= high + slack))
    a, b, c = (h + slack for h in piece.half())
    if piece.kind == "cone":
        return math.hypot(x, y) <= a and -piece["height"] / 4 - slack <= z <= 3 * piece["height"] / 4 + slack
    if piece.kind == "revolved":
        profile = np.asarray(piece["profile"], dtype=float)
        return math.hypot(x, y) <= a and bool(profile[:, 0].min() - slack <= z <= profile[:, 0].max() + slack)
    if piece.kind in ("box", "plate"):
        return abs(x) <= a and abs(y) <= b and abs(z) <= c
    if piece.kind in ("particle", "sphere", "spherical_shell", "ellipsoid"):
        return (x / a) ** 2 + (y / b) ** 2 + (z / c) ** 2 <= 1
    return math.hypot(x, y) <= a and abs(z) <= c
