"""A motion as the data of a page: bodies as primitives, keyframes, arrows, quantities over time.

Numbers are arrays over the same keyframes (see :mod:`freebody.picture.moving.keyframes`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...describe.constraints.constraint import Rolling
from ...describe.frame import Point
from ...dynamics.state import State, float_state
from ...errors import SimulationError
from ...model.closure import Closure
from ...model.model import Model
from ...motion.trajectory.quantities import quaternions
from ...scalar.algebra import Vector
from ..machine.shapes import (
    ROD,
    Primitive,
    axes_along,
    ends_of,
    hidden,
    machine_size,
    rod,
    ropes_of,
    scenery_of,
    shapes,
)
from ..moving.forces import Arrow
from ..moving.joint_springs import joint_springs
from ..moving.keyframes import TOLERANCE, Keyframes, keyframes, paths_of_arrows
from ..moving.quantities import channels, charts
from ..moving.touching import distinct, modes, surface_parts, touching
from ..paper.palette import KINDS
from .symbols import in_letters

if TYPE_CHECKING:
    from ...motion.trajectory.trajectory import Trajectory

Array = NDArray[np.float64]

THIN = 0.012
"""Half the thickness of disks and plates without one of their own, relative to the size of the machine."""

SOLIDS = ("#7fa9d1", "#e0a35f", "#74b897", "#c690b5", "#d6c05a", "#8cc4e4")
"""Colours of bodies: the hues of their pale fills in drawings, dark enough to be shaded on white."""

PAPER = 5.0
"""Lengths of its machine that a motion covers which is drawn over the lines of a paper."""
ROUND = 1e-10
"""Forces (and moments over the size of the machine) below this fraction of the largest are round-off."""


def animation(trajectory: Trajectory, tolerance: float = TOLERANCE) -> dict[str, Any]:
    """Return everything that the player of a page needs, as plain data.

    Parameters
    ----------
    trajectory : Trajectory
    tolerance : float
        Tolerance of the interpolation between keyframes.

    Returns
    -------
    dict
        Data that `packed` can hold.

    Raises
    ------
    SimulationError
        If the machine has no bodies, or the tolerance is not between 0 and 1.
    """
    return scene_of(trajectory, frames_of(trajectory, tolerance))


def frames_of(trajectory: Trajectory, tolerance: float) -> Keyframes:
    """Return the keyframes of a motion of bodies."""
    model = trajectory.kernels.model
    if not model.bodies:
        raise SimulationError(f"Expected a machine with bodies to animate, but '{model.name}' has none.")
    if not 0 < tolerance < 1:
        raise SimulationError(f"Expected a tolerance between 0 and 1 for the keyframes, got {tolerance!r}.")
    return keyframes(trajectory, tolerance)


def scene_of(trajectory: Trajectory, keys: Keyframes) -> dict[str, Any]:
    """Return the data of :func:`animation` at given keyframes."""
    model = trajectory.kernels.model
    scene = posed(model, trajectory.values, keys, trajectory.name)
    size = scene["size"]
    acting = _acting(keys, size)
    places = paths_of_arrows(trajectory, keys)
    for arrow, place in zip(keys.arrows, scene["arrows"], strict=True):
        if arrow.contact is not None and keys.touched is not None:
            place["path"] = keys.touched.place[:, arrow.contact]
        elif arrow.moves:
            place["path"] = places[arrow.key]
    scene["arrows"] = [arrow for arrow in scene["arrows"] if arrow["channel"] in acting]
    return {
        **scene,
        "channels": channels(trajectory, keys, acting),
        "charts": charts(trajectory, keys, acting, size),
        "events": [[event.time, getattr(event, "text", "") or event.name] for event in trajectory.events],
        "modes": modes(trajectory),
        "touching": touching(keys),
    }


def posed(model: Model, values: Mapping[str, float], keys: Keyframes, title: str) -> dict[str, Any]:
    """Return the bodies of a machine with their poses over time, without quantities, events and contacts."""
    size = machine_size(model, values)
    state = float_state(model, values=values)
    up, toward = _view(model, state, keys)
    scene = figure(model, values, keys, size, up)
    for i, body in enumerate(scene["bodies"]):
        body["position"] = keys.position[:, i]
        body["quaternion"] = keys.quaternion[:, i]
        body["spin"] = keys.spin[:, i]
    drawn = {i for i in range(len(model.bodies)) if _draws_cone(keys.spin[:, i])}
    scene["cones"] = [cone for cone in scene["cones"] if cone["body"] in drawn]
    return {
        "title": title,
        "up": up.tolist(),
        "gravity": any(float(state(c)) for c in model.gravity),
        "toward": toward.tolist(),
        "size": size,
        "t": keys.t.astype(np.float32),
        "tolerance": keys.tolerance,
        **scene,
        "channels": {},
        "charts": [],
        "events": [],
        "breaks": keys.breaks,
        "modes": [],
        "touching": [],
    }


def figure(
    model: Model, values: Mapping[str, float], keys: Keyframes, size: float, up: Array
) -> dict[str, Any]:
    """Return what does not move with time: parts of bodies and of the ground, and points of bodies.

    ``size`` is the length that symbols are relative to. The numbers depend on the values of the parameters.
    """
    state, names = float_state(model, values=values), list(model.bodies)
    springs, walls = joint_springs(model, state, keys, size)
    ground = _ground(model, state, keys, size, up)
    ground["parts"] += [{**wall, "color": STEEL} for wall in walls]
    return {
        "bodies": _bodies(model, state, values, size),
        "ground": ground,
        "lines": _lines(model, state, names, size) + springs,
        "arrows": [_arrow(arrow, state, names) for arrow in keys.arrows],
        "cones": [{"body": i, "apex": _apex(model, state, name)} for i, name in enumerate(names)],
    }


def _view(model: Model, state: State, keys: Keyframes) -> tuple[Array, Array]:
    """(upward direction, direction toward the eye): a planar motion is seen perpendicular to its plane."""
    g = np.array([float(state(c)) for c in model.gravity])
    up = -g / np.linalg.norm(g) if np.any(g) else np.array([0.0, 0.0, 1.0])
    moved = np.ptp(keys.position, axis=0).max(axis=0, initial=0.0)
    spin = np.abs(keys.spin).max(axis=(0, 1), initial=0.0)
    still = 1e-9 * max(1e-300, float(moved.max()), float(spin.max()))
    for k in (2, 1, 0):
        others = [i for i in range(3) if i != k]
        if moved[k] <= still and all(spin[i] <= still for i in others) and abs(up[k]) < 1e-9:
            n = np.eye(3)[k]
            return up, -n if k == 1 else n  # with y toward the eye, x would point to the left
    if not np.any(g) and np.all(spin[:2] <= still) and moved[2] <= still:
        return np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
    side = np.cross(up, np.eye(3)[int(np.argmin(np.abs(up)))])
    if up[2] > 0.9:  # x to the lower left, y to the right, as axes are drawn
        side = np.array([0.0, 1.0, 0.0])
    front = np.cross(side, up)
    toward = 0.85 * front + 0.45 * side + 0.38 * up
    return up, toward / np.linalg.norm(toward)


def _draws_cone(spin: Array) -> bool:
    """True if the direction of an angular velocity changes, so that it draws a cone."""
    length = np.linalg.norm(spin, axis=1)
    if not length.max(initial=0.0) > 0:
        return False
    n = spin[length > 1e-3 * length.max()]
    n = n / np.linalg.norm(n, axis=1)[:, None]
    return bool(np.min(n @ n[0]) < math.cos(1e-3) and np.linalg.matrix_rank(n, tol=1e-3) == 3)


def _apex(model: Model, state: State, body: str) -> list[float]:
    """Tip of the cones of a body, in body axes: the point that a joint fixes in the ground, or the mass centre."""
    for joint in model.joints.values():
        if joint.child == body and joint.parent == "ground" and joint.pair.spherical:
            return _numbers(state, joint.to)
    return _numbers(state, model.bodies[body].center)


# -- bodies ------------------------------------------------------------------------------------------------


def _bodies(model: Model, state: State, values: Mapping[str, float], size: float) -> list[dict[str, Any]]:
    """Bodies with their parts."""
    pieces_of = shapes(model, values, size)
    pins, unseen = _pins(model, state, size), hidden(model)
    result = []
    for i, (name, place) in enumerate(model.bodies.items()):
        color = _rgb((place.shape.color if place.shape is not None else None) or SOLIDS[i % len(SOLIDS)])
        pieces = [piece for piece in pieces_of[name] if not piece.hole]
        parts = [] if name in unseen else [part(piece, size) for piece in pieces] + pins.get(name, [])
        result.append({"name": name, "color": color, "center": _numbers(state, place.center), "parts": parts})
    return result


def part(piece: Primitive, size: float) -> dict[str, Any]:
    """Return a piece of a body as the page draws it: a box, a profile turned about z, an ellipsoid, or triangles."""
    d, kind, thin = piece.dimensions, piece.kind, THIN * size
    pose = {
        "at": [float(x) for x in piece.center],
        "turn": quaternions(np.asarray(piece.axes, dtype=float)[None])[0].tolist(),
    }
    if kind == "mesh":
        return {
            "kind": "mesh",
            "vertices": np.asarray(d["vertices"], dtype=np.float32),
            "faces": np.asarray(d["faces"], dtype=np.uint32),
            **pose,
        }
    if kind in ("particle", "sphere", "spherical_shell"):
        return {"kind": "ellipsoid", "radii": [d["radius"]] * 3, **pose}
    if kind == "ellipsoid":
        return {"kind": "ellipsoid", "radii": [d["a"], d["b"], d["c"]], **pose}
    if kind == "box":
        return {"kind": "box", "size": [d["x"], d["y"], d["z"]], **pose}
    if kind == "plate":
        return {"kind": "box", "size": [d["a"], d["b"], 2 * thin], **pose}
    if kind == "cone":
        r, h = d["radius"], d["height"]
        profile = [(0, -h / 4), (r, -h / 4), (0, 3 * h / 4)]
    elif kind == "torus":
        profile = _circle(d["major"], d["minor"])
    elif kind == "ring":
        profile = _circle(d["radius"], min(1.5 * thin, d["radius"] / 4))
    elif kind == "tube":
        a, b, h = d["inner"], d["outer"], d["length"] / 2
        profile = [(a, -h), (b, -h), (b, h), (a, h), (a, -h)]
    elif kind == "revolved":
        line = np.asarray(d["profile"], dtype=float)
        outer = [(float(row[1]), float(row[0])) for row in line]
        inner = [(float(row[2]) if len(row) > 2 else 0.0, float(row[0])) for row in line]
        profile = [inner[0], *outer, *inner[::-1]]
    else:
        r = 1.6 * ROD * size if kind == "slender_bar" else d["radius"]
        h = thin if kind == "disk" else d["length"] / 2
        profile = [(0, -h), (r, -h), (r, h), (0, h)]
    return {"kind": "lathe", "profile": [[float(r), float(z)] for r, z in profile], **pose}


def _circle(major: float, minor: float) -> list[tuple[float, float]]:
    """Profile of a torus."""
    turn = 2 * math.pi * np.arange(25) / 24
    points = [(major + minor * math.cos(a), minor * math.sin(a)) for a in turn]
    return [*points[:-1], points[0]]


INK = [0.22, 0.22, 0.24]
STEEL = [0.62, 0.64, 0.67]
SCENERY = [0.8, 0.79, 0.77]


def _pins(model: Model, state: State, size: float) -> dict[str, list[dict[str, Any]]]:
    """Parts that show joints on their children: a pin along the axis of a hinge, a ball for joints about a point."""
    result: dict[str, list[dict[str, Any]]] = {}
    for joint in model.joints.values():
        links = [model.links[i] for i in joint.links]
        at = _numbers(state, joint.to)
        if joint.pair.revolute:
            axis = np.array(_numbers(state, links[0].axis))
            result.setdefault(joint.child, []).append(_pin(at, axis, size))
        elif joint.pair.spherical:
            result.setdefault(joint.child, []).append(_ball(at, 0.025 * size, INK))
    for closure in model.constraints.values():
        if isinstance(closure, Closure) and (closure.pair.revolute or closure.pair.spherical):
            at = _numbers(state, closure.to)
            symbol = _ball(at, 0.025 * size, INK)
            if closure.pair.revolute:
                symbol = _pin(at, np.array(_numbers(state, closure.square[0][2])), size)
            result.setdefault(closure.child.name, []).append(symbol)
    return {name: parts for name, parts in result.items() if name in model.bodies}


def _ball(at: list[float], radius: float, color: list[float]) -> dict[str, Any]:
    return {"kind": "ellipsoid", "radii": [radius] * 3, "at": at, "color": color}


def _pin(at: list[float], axis: Array, size: float) -> dict[str, Any]:
    r, h = 0.018 * size, 0.035 * size
    return _turned([[0, -h], [r, -h], [r, h], [0, h]], at, axis, INK)


def _foot(at: Array, toward: Array, size: float) -> dict[str, Any]:
    """A bracket with its base, on the side of a joint where the machine is not."""
    profile = [[0.0, 0.0], [0.035, 0.085], [0.07, 0.085], [0.07, 0.1], [0.0, 0.1]]
    return _turned([[r * size, z * size] for r, z in profile], at.tolist(), toward, STEEL)


def _turned(profile: list[list[float]], at: list[float], axis: Array, color: list[float]) -> dict[str, Any]:
    """Return a solid of revolution about an axis."""
    turn = quaternions(axes_along(axis)[None])[0].tolist()
    return {"kind": "lathe", "profile": profile, "at": at, "turn": turn, "color": color}


def _supports(model: Model, state: State, keys: Keyframes, size: float, up: Array) -> list[dict[str, Any]]:
    """Brackets of joints on the ground that carry a force, and guides of sliders."""
    parts: list[dict[str, Any]] = []
    acting = _acting(keys, size)
    carrying = {
        arrow.name
        for arrow in keys.arrows
        if arrow.key in acting and arrow.group == "reaction" and arrow.kind == "force"
    }
    for name, joint in model.joints.items():
        if joint.parent != "ground" or not joint.pair.holds:
            continue
        held = joint.pair.spherical or joint.pair.revolute
        at = np.array(_numbers(state, joint.at))
        link = model.links[joint.links[0]]
        if joint.pair.guided:
            R = np.array([[float(state(x)) for x in row] for row in link.rotation])
            axis = R @ np.array(_numbers(state, link.axis))
            body = list(model.bodies).index(joint.child)
            reach = (keys.position[:, body] - at) @ axis
            low, high = min(0.0, float(reach.min())) - 0.2 * size, max(0.0, float(reach.max())) + 0.2 * size
            guide = rod(at + low * axis, at + high * axis, 0.6 * ROD * size)
            parts.append({**part(guide, size), "color": STEEL})
        elif not held or name in carrying or not keys.arrows:
            parts.append(_ball(at.tolist(), 0.022 * size, STEEL))
            if held and joint.child in model.bodies:
                body = list(model.bodies).index(joint.child)
                above = float((keys.position[:, body] - at).mean(axis=0) @ up) >= 0
                parts.append(_foot(at, -up if above else up, size))
    return parts


def _ground(model: Model, state: State, keys: Keyframes, size: float, up: Array) -> dict[str, Any]:
    """Scenery, supports, surfaces of contacts, and planes that wheels roll on."""
    parts = [{**part(piece, size), "color": SCENERY} for piece in scenery_of(model, state, size)]
    parts += _supports(model, state, keys, size, up)
    planes: list[dict[str, Any]] = []
    for constraint in model.constraints.values():
        if isinstance(constraint, Closure):
            for end, point in ((constraint.parent, constraint.at), (constraint.child, constraint.to)):
                if end.is_ground:
                    parts.append(_ball(_numbers(state, point), 0.022 * size, STEEL))
        elif isinstance(constraint, Rolling):
            origin, normal = constraint.plane.components, constraint.normal[1]
            planes.append({"at": _numbers(state, origin), "normal": _numbers(state, normal)})
    surfaces: list[Any] = []
    for shape in model.touching:
        if shape.body.is_ground and shape not in surfaces:
            surfaces.append(shape)
    for shape in surfaces:
        if shape.look == "plane":
            planes.append({"at": _numbers(state, shape.at), "normal": _numbers(state, shape.normal)})
        else:
            reach = (float(keys.position[:, :, 0].min()) - size, float(keys.position[:, :, 0].max()) + size)
            for piece in surface_parts(state, shape, reach, size):
                parts.append({**(piece if isinstance(piece, dict) else part(piece, size)), "color": STEEL})
    # a machine that travels over paper without ground is seen to move by the lines it passes
    moved = np.ptp(keys.position, axis=0).max(axis=0, initial=0.0)
    if not planes and not any(map(state, model.gravity)) and moved[2] == 0 and moved.max() > PAPER * size:
        planes.append({"at": [0.0, 0.0, -size], "normal": [0.0, 0.0, 1.0]})
    return {"parts": parts, "planes": distinct(planes, size)}


def _lines(model: Model, state: State, names: list[str], size: float) -> list[dict[str, Any]]:
    """Springs, dampers, ropes and belts, between points of bodies (number -1 is the ground)."""

    def end(point: Point) -> list[Any]:
        body = -1 if point.body.is_ground else names.index(point.body.name)
        return [body, _numbers(state, point.components)]

    result: list[dict[str, Any]] = []
    for name, load in model.loads.items():
        if ends := ends_of(model, load):
            kind = "spring" if load.look.symbol == "zigzag" else "damper"
            result.append({"name": name, "kind": kind, "ends": [*map(end, ends)]})
    for name, points in ropes_of(model).items():
        result.append({"name": name, "kind": "rope", "ends": [end(point) for point in points]})
    for name, load in model.loads.items():
        if load.strand:
            result.append({"name": name, "kind": "rope", "ends": [*map(end, load.strand)]})
    return result


# -- forces and quantities ---------------------------------------------------------------------------------


def _arrow(arrow: Arrow, state: State, names: list[str]) -> dict[str, Any]:
    """An arrow with its label and its colour."""
    return {
        "name": arrow.name,
        "group": arrow.group,
        "kind": arrow.kind,
        "body": names.index(arrow.body) if arrow.body in names else -1,
        "at": _numbers(state, arrow.at),
        "label": f"weight of {arrow.body}" if arrow.role == "weight" else in_letters(arrow.name),
        "channel": arrow.key,
        "color": _rgb(KINDS[arrow.role][0]),
        **({} if arrow.contact is None else {"contact": arrow.contact}),
    }


def _acting(keys: Keyframes, size: float) -> set[str]:
    """Keys of the forces and moments that are more than round-off."""
    greatest = {arrow.key: float(np.abs(keys.vectors[arrow.key]).max(initial=0.0)) for arrow in keys.arrows}
    arms = {arrow.key: 1.0 if arrow.kind == "force" else size for arrow in keys.arrows}
    largest = max((greatest[key] / arm for key, arm in arms.items()), default=0.0)
    return {key for key, arm in arms.items() if greatest[key] > ROUND * largest * arm}


def _numbers(state: State, vector: Vector) -> list[float]:
    return [float(state(x)) for x in vector]


def _rgb(color: str) -> list[float]:
    return [int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)]
