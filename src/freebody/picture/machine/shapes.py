"""Shapes of the bodies of a model: primitives in body axes, from solids, wheels and the points of joints.

A body made from a solid is drawn as that solid. If a joint lies beside the solid, as the pivot of a gyroscope does, a
rod leads to it. A body described by numbers alone is drawn as the wheel that rolls or the round surface that touches,
as rods between the points of its joints, or as the ellipsoid of its inertia.

This file is longer than others because the shape of a body depends on the places of its joints, loads and contacts.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...describe.constraints.constraint import Rolling, Rope
from ...describe.frame import Point
from ...describe.loads.action import PointForce
from ...describe.loads.load import Load
from ...describe.looks import NOTHING
from ...dynamics.loads.actions import places
from ...dynamics.state import State, float_state
from ...errors import ModelError
from ...model.closure import Closure
from ...model.model import Model, Place
from ...scalar.algebra import Vector, floats
from ...scalar.expression import evaluate
from ...space.shape import Shape
from ..paper.palette import BODY_FILLS, pale

Array = NDArray[np.float64]

PARTICLE = 0.045
"""Radius of a particle, relative to the size of the machine."""

ROD = 0.012
"""Radius of a rod without one of its own, relative to the size of the machine."""

AXIAL = ("slender_bar", "disk", "ring", "cylinder", "tube", "cone", "torus", "plate", "rod", "revolved")
"""Kinds of pieces with a symmetry axis or a normal."""


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
        Position from the body's origin, in body axes [m]: the mass centre of the piece, except for ``revolved`` and
        ``mesh``.
    axes : array (3, 3)
        Columns are the axes of the piece in body axes. The third is the symmetry axis of an axial piece, from base to
        apex of a cone. The edges a and b of a plate lie along the first and second.
    hole : bool
        True if the piece is cut out of the body.
    solid : bool
        True if the piece has mass; rods that only lead to a joint have none.
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
        """Symmetry axis (or normal), in body axes."""
        return self.axes[:, 2]

    def points(self) -> Array:
        """Points in body axes whose convex hull contains the piece, shape (n, 3) [m]."""
        local = self["vertices"] if self.kind == "mesh" else list(product(*zip(*self.box(), strict=True)))
        return self.center + np.asarray(local, dtype=float) @ self.axes.T

    def box(self) -> tuple[Array, Array]:
        """Least and greatest components along the axes of the piece, from ``center`` [m]."""
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
        """Middle of the box, in body axes: a mesh or a solid of revolution may lie beside its ``center``."""
        low, high = self.box()
        return np.asarray(self.center + self.axes @ ((low + high) / 2))

    def half(self) -> tuple[float, float, float]:
        """Half of the extent along the axes of the piece [m]."""
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


def numbers(state: State, components: Iterable[Any]) -> Array:
    """Return components, such as those of a vector, at a state."""
    return np.array([float(state(x)) for x in components])


def shapes(
    model: Model, values: Mapping[Any, Any] | None = None, size: float | None = None
) -> dict[str, tuple[Primitive, ...]]:
    """Pieces of every body by name, in body axes, at values of the parameters.

    Parameters
    ----------
    model : Model
    values : mapping, optional
        Values of parameters, in place of their defaults.
    size : float, optional
        Length that the radius of particles and rods without thickness is relative to [m]; by default the size of the
        machine.

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
    """Colours that the user chose for bodies, by name of the body."""
    result = {}
    for name, place in model.bodies.items():
        if place.shape is not None and place.shape.color:
            result[name] = place.shape.color
    return result


def hidden(model: Model) -> set[str]:
    """Names of the bodies that their descriptions do not want drawn."""
    shapes = {name: place.shape for name, place in model.bodies.items()}
    return {name for name, shape in shapes.items() if shape is not None and shape.kind == NOTHING}


def scenery_of(model: Model, state: State, size: float) -> list[Primitive]:
    """Pieces of the scenery, and solids of the ground that bodies touch, in ground axes."""
    pieces = [] if model.scenery is None else _pieces(state, model.scenery, size)
    return pieces + _solids(model, state, "ground", pieces, size)


def fill_of(model: Model, body: str) -> str:
    """Fill of a body in a line drawing: a pale tone of the chosen colour, or the colour of its place in the model."""
    chosen = colors(model)
    place = list(model.bodies).index(body)
    return pale(chosen[body]) if body in chosen else BODY_FILLS[place % len(BODY_FILLS)]


def machine_size(model: Model, values: Mapping[Any, Any] | None = None) -> float:
    """Typical length of the machine: the greatest distance of its joints or extent of its solids [m].

    Bodies that are not drawn count only if the others are points: the arm of a curve is no part of the motorcycle.
    """
    state = float_state(model, values=values)
    unseen = hidden(model)
    seen = _longest(model, state, [name for name in model.bodies if name not in unseen])
    longest = seen if seen > 0 else _longest(model, state, list(model.bodies))
    for joint in model.joints.values():
        if joint.parent == "ground":
            longest = max(longest, float(np.linalg.norm([float(x) for x in state.vector(joint.at)])))
    return longest if longest > 0 else 1.0


def _longest(model: Model, state: State, names: list[str]) -> float:
    """Greatest extent of these bodies with their joints [m]."""
    longest = 0.0
    for name in names:
        place = model.bodies[name]
        points = list(attachments(model, state, name).values())
        shape = place.shape
        if shape is not None and shape.kind != "particle":
            for piece in _pieces(state, shape, 0.0):
                points += list(piece.points())
        if points:
            span = np.ptp(np.array([*points, np.zeros(3)]), axis=0)
            longest = max(longest, float(np.linalg.norm(span)))
    return longest


def attachments(model: Model, state: State, body: str) -> dict[str, Array]:
    """Points of a body that joints, wheels, ropes, springs and forces act on, by name, in body axes [m]."""
    components: dict[str, Vector] = {}
    for name, joint in model.joints.items():
        if joint.pair.holds:  # these hold no point of the body
            if joint.child == body:
                components[name] = joint.to
            elif joint.parent == body:
                components[name] = joint.at
    for name, constraint in model.constraints.items():
        if isinstance(constraint, Closure):
            if constraint.child.name == body:
                components[name] = constraint.to
            elif constraint.parent.name == body:
                components[name] = constraint.at
        elif isinstance(constraint, Rolling) and constraint.center.body.name == body:
            components[name] = constraint.center.components
    ends = {f"{name} {k}": point for name, rope in ropes_of(model).items() for k, point in enumerate(rope)}
    components |= {name: point.components for name, point in ends.items() if point.body.name == body}
    for name, load in model.loads.items():
        for point in load.points.values():
            if point.body.name == body:
                components[name] = point.components
    return {name: numbers(state, point) for name, point in components.items()}


def ends_of(model: Model, load: Load) -> tuple[Point, ...]:
    """Return the two points between which the symbol of a load stands; none if it has no symbol, or other points."""
    points = [action.point for action in places(model)[load.name] if isinstance(action, PointForce)]
    match points:
        case [start, end] if load.look.symbol:
            return start, end
    return ()


def ropes_of(model: Model) -> dict[str, tuple[Point, ...]]:
    """Points of every rope by name, including the ropes that may go slack."""
    result = {name: rope.points for name, rope in model.constraints.items() if isinstance(rope, Rope)}
    for contact in model.contacts:
        if contact.surface.look == "rope":
            result[contact.name] = (Point(contact.surface.body, contact.surface.at), contact.feature)
    return result


def _body(model: Model, state: State, name: str, place: Place, size: float) -> list[Primitive]:
    """Pieces of one body."""
    shape = place.shape
    points = list(attachments(model, state, name).values())
    center = numbers(state, place.center)
    pieces = [] if shape is None else _pieces(state, shape, size)
    if not pieces:
        pieces = _wheels(model, state, name) or _skins(model, state, name)
    pieces += _solids(model, state, name, pieces, size)
    if not pieces:
        return _unknown(state, place, center, points, size)
    solid = [piece for piece in pieces if not piece.hole]
    pieces += _bridges(solid, size)
    for point in _distinct(points, size):
        if not any(holds(piece, point, 0.02 * size) for piece in (*solid, *pieces)):
            near = min(solid, key=lambda piece: float(np.linalg.norm(piece.middle - point)))
            pieces.append(rod(near.middle, point, ROD * size))
    for point in _distinct(_feet(model, state, name), size):
        if not any(holds(piece, point, 0.02 * size) for piece in solid):
            ends = [_nearest(piece, point, size) for piece in solid]
            pieces.append(rod(min(ends, key=lambda q: float(np.linalg.norm(q - point))), point, ROD * size))
    return pieces


def _bridges(solid: list[Primitive], size: float) -> list[Primitive]:
    """Rods between the particles of a body and its next pieces, each piece held once."""
    rods: list[Primitive] = []
    for a, b in zip(solid, solid[1:], strict=False):
        through = np.linspace(0.0, 1.0, 41)
        passed = [r.center + (2 * t - 1) * r["length"] / 2 * r.axis for r in rods for t in through]
        if "particle" not in (a.kind, b.kind) or holds(a, b.middle, 0.02 * size):
            continue
        if not any(holds(b, q, 0.02 * size) for q in passed):  # a rod through the next piece holds it already
            rods.append(rod(a.middle, b.middle, ROD * size))
    return rods


def _nearest(piece: Primitive, point: Array, size: float) -> Array:
    """Point of the box of a piece that is nearest to a point; its middle for a point in the box of a round piece."""
    end = piece.center + piece.axes @ np.clip(piece.axes.T @ (point - piece.center), *piece.box())
    return piece.middle if float(np.linalg.norm(end - point)) < 1e-9 * size else np.asarray(end)


def _feet(model: Model, state: State, body: str) -> list[Array]:
    """Points of a body that touch other bodies: feet, axles, hangers."""
    return [
        numbers(state, shape.components)
        for shape in model.touching
        if shape.look == "spot" and shape.body.name == body
    ]


def _pieces(state: State, shape: Shape, size: float) -> list[Primitive]:
    """Pieces of a solid.

    Raises
    ------
    ModelError
        If a dimension is not positive and finite.
    """
    if shape.kind == NOTHING:
        return []
    if shape.kind == "compound":
        return [piece for part in shape.parts for piece in _pieces(state, part, size)]
    if shape.kind == "revolved":
        dimensions = _revolved(state, shape)
    elif shape.kind == "mesh":
        vertices, faces = shape["surface"].arrays
        if not len(faces):  # its file could not be read, as the report of the reading says
            return []
        dimensions = {"vertices": vertices, "faces": faces}
    else:
        dimensions = {name: _number(state, value) for name, value in shape.dimensions}
    for name, value in dimensions.items():
        checked = value if isinstance(value, float) and name != "inner" else 1.0
        if not (checked > 0 and math.isfinite(checked)):
            raise ModelError(
                f"Expected positive dimensions to draw a {shape.kind.replace('_', ' ')}, got {name} = {value:g}. Give "
                f"other values to the parameters it depends on."
            )
    if shape.kind == "particle":
        dimensions["radius"] = PARTICLE * size
    R = np.array([[float(x) for x in row] for row in state.matrix(shape.axes)])
    axes = np.eye(3)
    if shape.kind == "plate":
        k = int(np.argmax(np.abs([float(state(x)) for x in shape.axis])))
        axes = np.eye(3)[:, [(k + 1) % 3, (k + 2) % 3, k]]
    elif shape.kind in AXIAL:
        axes = axes_along(numbers(state, shape.axis))
    center = numbers(state, shape.center)
    return [Primitive(shape.kind, dimensions, center, R @ axes, shape.hole)]


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
    """Value of a dimension: a float, or an array."""
    if isinstance(value, np.ndarray):
        return value
    if isinstance(value, list | tuple):
        return np.array([_number(state, x) for x in value])
    return float(state(value))


def _wheels(model: Model, state: State, body: str) -> list[Primitive]:
    """Wheels of a body that rolls: disks of the radius of rolling, or spheres if the rolling has no axis."""
    wheels = []
    for rolling in model.constraints.values():
        if isinstance(rolling, Rolling) and rolling.center.body.name == body:
            at = numbers(state, rolling.center.components)
            radius = {"radius": float(state(rolling.radius))}
            if rolling.axis is None:
                wheels.append(Primitive("sphere", radius, at))
            else:
                axes = axes_along(numbers(state, rolling.axis))
                wheels.append(Primitive("disk", radius, at, axes))
    return wheels


def _skins(model: Model, state: State, body: str) -> list[Primitive]:
    """Round surfaces of a body that touch other bodies: spheres, ellipsoids and disks."""
    skins: dict[Any, Primitive] = {}
    for shape in model.touching:
        look = shape.look
        if shape.body.name != body or look not in ("ball", "oval", "disk") or shape in skins:
            continue
        at = numbers(state, shape.at)
        if look == "oval":
            a, b, c = (float(state(x)) for x in shape.half_axes)
            skins[shape] = Primitive("ellipsoid", {"a": a, "b": b, "c": c}, at)
        elif not shape.inside:
            radius = {"radius": float(state(shape.radius))}
            axis = (0, 0, 1) if look == "ball" else state.vector(shape.axis)
            axes = axes_along(np.array([float(x) for x in axis]))
            skins[shape] = Primitive("sphere" if look == "ball" else "disk", radius, at, axes)
    return list(skins.values())


def _solids(model: Model, state: State, body: str, pieces: list[Primitive], size: float) -> list[Primitive]:
    """Boxes, hulls and capsules by which a body touches others, as far as its other pieces do not show them."""
    found: list[Primitive] = []
    for shape in dict.fromkeys(s for s in model.touching if s.look == "solid" and s.body.name == body):
        corners = np.array([[float(state(x)) for x in corner] for corner in shape.corners])
        around = float(state(shape.radius))
        if around > 0:
            (a, b), along = corners, float(np.linalg.norm(corners[1] - corners[0]))
            round_side = {"radius": around, "length": along}
            solid = [Primitive("cylinder", round_side, (a + b) / 2, axes_along(b - a))]
            solid += [Primitive("sphere", {"radius": around}, corner) for corner in corners]
        else:
            faces = [
                (face[0], b, c) for face in shape.faces for b, c in zip(face[1:], face[2:], strict=False)
            ]
            middle, (low, high) = corners.mean(axis=0), (corners.min(axis=0), corners.max(axis=0))
            solid = [Primitive("mesh", {"vertices": corners - middle, "faces": np.array(faces)}, middle)]
            if len(corners) == 8 and ((corners == low) | (corners == high)).all():
                solid = [Primitive("box", dict(zip("xyz", (high - low).tolist(), strict=True)), middle)]
        hidden_by = [piece for piece in pieces if not piece.hole]
        if not all(any(holds(piece, corner, 0.01 * size) for piece in hidden_by) for corner in corners):
            found += solid
    return found


def _unknown(state: State, place: Place, center: Array, points: list[Array], size: float) -> list[Primitive]:
    """Rods between the points of the joints and the mass centre; the ellipsoid of inertia for fewer than two points."""
    mass = float(state(place.mass))
    inertia = np.array([[float(x) for x in row] for row in state.matrix(place.inertia)])
    points = _distinct(points, size)
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
    pieces = [rod(hub, p, ROD * size) for p in points if float(np.linalg.norm(p - hub)) > 1e-9 * size]
    pieces += [rod(a, b, ROD * size) for a, b in zip(points, points[1:], strict=False)]
    return pieces or [Primitive("particle", {"radius": PARTICLE * size}, center, solid=mass > 0)]


def rod(start: Array, end: Array, radius: float) -> Primitive:
    """A round rod without mass between two points."""
    along = np.asarray(end, dtype=float) - start
    length = float(np.linalg.norm(along))
    return Primitive(
        "rod",
        {"length": length, "radius": radius},
        (np.asarray(start) + end) / 2,
        axes_along(along),
        solid=False,
    )


def axes_along(axis: Array) -> Array:
    """Return a rotation matrix whose third column lies along ``axis``."""
    n = axis / np.linalg.norm(axis)
    helper = np.eye(3)[int(np.argmin(np.abs(n)))]
    first = np.cross(helper, n)
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(n, first), n])


def _distinct(points: list[Array], size: float) -> list[Array]:
    """The points without repetitions."""
    result: list[Array] = []
    for p in points:
        if all(float(np.linalg.norm(p - q)) > 1e-6 * size for q in result):
            result.append(p)
    return result


def holds(piece: Primitive, point: Array, slack: float) -> bool:
    """True if a point, in body axes, lies in a piece or within ``slack`` of it."""
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
