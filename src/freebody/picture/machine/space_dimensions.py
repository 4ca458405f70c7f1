"""Lengths, radii and tilts in the drawing of a machine in space: each is drawn along what it measures, as projected.

The look of a body that is not its solid has no dimensions, except its whole length along an axis if that is a
parameter: the distance of the bearings of a shaft.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from ...scalar.algebra import Vector, apply
from ...scalar.element import Polynomial
from ...space.shape import Shape
from ...symbolic.printing.display import latex
from ..paper.palette import GREY
from ..paper.sheet import Arrow, Group, Line, Style
from .inclinations import angle_with
from .machine_drawing import MachineDrawing
from .measures import ROUND, Measured, chain, named_points
from .shapes import axes_along, numbers

Array = NDArray[np.float64]

REACH = 62.0
"""Radius of the arc of a tilt [pt]."""


def space_dimensions(m: MachineDrawing, name: str) -> list[Measured]:
    """Return the dimensions of a body: chains along its axes, and its radius, which avoids their lines."""
    solid = m.model.bodies[name].shape
    points = {key: p for key, p in named_points(m.e, name).items() if not key.startswith("end ")}
    result = _dumbbell(m, name, solid)
    for k in range(3):
        along = _ends(m, name, solid, k) or {
            key: p for key, p in points.items() if key != "C" or not _datum(p[k])
        }
        if len(along) > 1:
            placer = m.placer.about(m.areas_of(name))
            result += chain(m, name, placer, along, k)
    for group, _, _ in result:
        for item in group.items:
            m.placer.line(item.points)
    return [*_radius(m, name, solid), *result]


def _datum(x: Any) -> bool:
    """True for a coordinate of the mass centre that is a number among parameters: it has no symbol."""
    return x != 0 and not sympy.sympify(x).free_symbols


def _dumbbell(m: MachineDrawing, name: str, shape: Shape | None) -> list[Measured]:
    """Distance of two particles of one body, beside the line between them."""
    leaves = _leaves(shape)
    if len(leaves) < 2 or {leaves[0].kind, leaves[1].kind} != {"particle"}:
        return []
    apart = [a - b for a, b in zip(leaves[0].center, leaves[1].center, strict=True)]
    positive = {x: sympy.Dummy(x.name, positive=True) for p in apart for x in sympy.sympify(p).free_symbols}
    square = sympy.trigsimp(sum(sympy.sympify(x).xreplace(positive) ** 2 for x in apart))
    distance = sympy.sqrt(sympy.factor(square)).xreplace({dummy: x for x, dummy in positive.items()})
    tex = latex(m.e.state(distance), m.e.ring)
    ends = [m.page(m.now.place(name, leaf.center)) for leaf in leaves[:2]]
    d = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    n = np.array([-d[1], d[0]])
    side = min((24.0, -24.0), key=lambda gap: m.placer.crowding(np.array(ends) + gap * n))
    line = np.array(ends) + side * n
    out = n * np.sign(side)
    leads = [
        Line(np.array([p + 11 * out, q + 4 * out]), Style(GREY, 0.7)) for p, q in zip(ends, line, strict=True)
    ]
    group = Group(
        [*leads, Arrow(line, Style(GREY, 0.8), "both")],
        {"class": "dimension", "data-symbol": tex},
        "distance",
    )
    return [(group, f"${tex}$", (line.mean(axis=0), out))]


def _leaves(shape: Shape | None) -> tuple[Shape, ...]:
    return () if shape is None else shape.parts or (shape,)


def _ends(m: MachineDrawing, name: str, shape: Shape | None, k: int) -> dict[str, Vector]:
    """Points of the shape at its two ends along an axis of the body."""
    ends: list[tuple[Any, ...]] = []
    for leaf in _leaves(shape):
        half = _half(leaf, k)
        if half is not None:
            middle = _outer_edge(m, name, leaf, k)
            ends += [
                tuple(c + (sign * half if i == k else 0) for i, c in enumerate(middle)) for sign in (-1, 1)
            ]
    if len(ends) < 2 or shape is None:
        return {}
    ends.sort(key=lambda p: float(m.now.state(p[k])))
    whole = sympy.expand(ends[-1][k] - ends[0][k])
    if shape.look and not whole.is_Symbol:
        return {}
    return {"first end": ends[0], "last end": ends[-1]} if whole.free_symbols else {}


def _outer_edge(m: MachineDrawing, name: str, leaf: Shape, k: int) -> tuple[Any, ...]:
    """Middle of the edge of a box or plate along an axis that is farthest below it (or beside it) on paper.

    The centre of other solids.
    """
    R, _ = m.now.posture(name)
    along = m.view(R[:, k])
    across = np.array([-along[1], along[0]])
    across = -across if across[1] > 0 else across
    result = list(leaf.center)
    for i in range(3):
        half = _half(leaf, i) if leaf.kind in ("box", "plate") and i != k else None
        if half is not None:
            result[i] = result[i] + (half if float(m.view(R[:, i]) @ across) > 0 else -half)
    return tuple(result)


def _half(leaf: Shape, k: int) -> Any:
    """Half of the length of one solid along an axis of the body; None if it lies askew or has no ends."""
    dimensions = dict(leaf.dimensions)
    if leaf.kind in ("cylinder", "tube", "slender_bar"):
        axis = apply(leaf.axes, leaf.axis)
        askew = any(i != k and axis[i] != 0 for i in range(3))
        return None if askew else dimensions["length"] / sympy.Integer(2)
    if leaf.kind in ("box", "plate") and all(leaf.axes[i][j] == (i == j) for i in range(3) for j in range(3)):
        edges = list(dimensions.values())
        if leaf.kind == "plate":
            normal = next(i for i in range(3) if leaf.axis[i] != 0)
            around = {(normal + 1) % 3: edges[0], (normal + 2) % 3: edges[1]}
            return around[k] / sympy.Integer(2) if k in around else None
        return edges[k] / sympy.Integer(2)
    return None


def _radius(m: MachineDrawing, name: str, shape: Shape | None) -> list[Measured]:
    """Radius of the first round part, in the direction on its rim that is least crowded."""
    leaf = next((leaf for leaf in _leaves(shape) if leaf.kind in ROUND), None)
    if leaf is None:
        return []
    radius = m.e.state(leaf["outer" if leaf.kind == "tube" else "radius"])
    if not isinstance(radius, Polynomial) or (leaf.look and not sympy.sympify(leaf["radius"]).is_Symbol):
        return []
    r = float(m.now.state(leaf["radius"]))
    R, p = m.now.posture(name)
    turned = R @ np.array([[float(m.now.state(x)) for x in row] for row in leaf.axes])
    flat = axes_along(turned @ numbers(m.now.state, leaf.axis))
    if leaf.kind in ("sphere", "spherical_shell"):
        flat = np.vstack([m.view.matrix, m.view.toward]).T
    middle = m.now.place(name, leaf.center)
    if leaf.kind == "cylinder":  # on the end that is seen
        half = float(m.now.state(leaf["length"])) / 2
        middle = middle + (half if float(flat[:, 2] @ m.view.toward) > 0 else -half) * flat[:, 2]
    choices = []
    for j in range(16):
        t = math.radians(22.5 * j + 11)
        line = m.page(np.array([middle, middle + r * (math.cos(t) * flat[:, 0] + math.sin(t) * flat[:, 1])]))
        short = float(np.linalg.norm(line[1] - line[0])) < 0.6 * r * m.scale
        choices.append((m.placer.crowding(line) + 0.5 * short, j, line))
    line = min(choices, key=lambda choice: choice[:2])[2]
    tex = latex(radius, m.e.ring)
    group = Group([Arrow(line, Style(GREY, 0.8))], {"class": "dimension", "data-symbol": tex}, "radius")
    d = (line[1] - line[0]) / max(float(np.linalg.norm(line[1] - line[0])), 1e-9)
    return [(group, f"${tex}$", (line.mean(axis=0), np.array([-d[1], d[0]])))]


def mark_tilts(m: MachineDrawing) -> None:
    """Draw the angle of a fixed hinge line from the vertical, and that of a solid's axis from the hinge's."""
    up = next((k for k in range(3) if m.model.gravity[k] != 0), 2)
    for name, joint in m.model.joints.items():
        if not joint.pair.revolute or joint.child not in m.drawn:
            continue
        link = m.model.links[joint.links[0]]
        at = m.joints[name].point
        axis = np.array(m.axis_in_space(link, joint.links[0]))
        if joint.parent == "ground":
            exact = apply(link.rotation, link.axis)
            vertical = np.eye(3)[up] if float(axis[up]) > 0 else -np.eye(3)[up]
            _tilt(m, exact, tuple(int(k == up) for k in range(3)), at, axis, vertical)
        own = _axis(m.model.bodies[joint.child].shape)
        if own is not None:
            R, _ = m.now.posture(joint.child)
            number = R @ numbers(m.now.state, own)
            _tilt(m, own, link.axis, at, number / np.linalg.norm(number), axis)


def _axis(shape: Shape | None) -> Any:
    """Direction of the axis of a solid, or of the line between two particles, in body axes."""
    leaves = _leaves(shape)
    if leaves and leaves[0].kind in ("disk", "ring", "cylinder"):
        return apply(leaves[0].axes, leaves[0].axis)
    if len(leaves) > 1 and leaves[0].kind == leaves[1].kind == "particle":
        return tuple(a - b for a, b in zip(leaves[0].center, leaves[1].center, strict=True))
    return None


def _tilt(m: MachineDrawing, exact: Any, axis: Any, at: Array, first: Array, second: Array) -> None:
    """Draw the angle between a direction and an axis, if it is a parameter."""
    along = sum(a * b for a, b in zip(exact, axis, strict=True))
    across = [x for x in (sympy.expand(a - along * b) for a, b in zip(exact, axis, strict=True)) if x != 0]
    found = angle_with(along, across[0]) if len(across) == 1 else None
    if found is None or not found.free_symbols:
        return
    tex = latex(m.e.state(found), m.e.ring).removeprefix("-")
    if float(first @ second) < 0:
        first = -first
    radius = REACH / m.scale
    normal = np.cross(first, second)
    angle = math.atan2(float(np.linalg.norm(normal)), float(first @ second))
    if angle < math.radians(2):
        return
    sideways = np.cross(normal / np.linalg.norm(normal), first)
    curve = np.array(
        [
            m.page(at + radius * (math.cos(a) * first + math.sin(a) * sideways))
            for a in np.linspace(0, angle, 12)
        ]
    )
    items: list[Any] = [
        Line(np.array([m.page(at), m.page(at + 1.3 * radius * d)]), Style(GREY, 0.7, dash))
        for d, dash in ((first, (4.0, 2.5)), (second, (8.0, 2.0, 1.5, 2.0)))
    ]
    items.append(Arrow(curve, Style(GREY, 0.8)))
    m.add(items, class_="inclination", data_symbol=tex)
    middle = curve[len(curve) // 2]
    out = (middle - m.page(at)) / max(float(np.linalg.norm(middle - m.page(at))), 1e-9)
    m.labels.append((f"${tex}$", [(middle, out)], 10.5, GREY))
