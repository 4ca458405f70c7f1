"""Angles and dimensions of a body on paper, labelled with the expressions of the model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
import sympy
from numpy.typing import NDArray

from ...describe.constraints.constraint import Rolling
from ...model.closure import Closure
from ...model.model import GROUND
from ...scalar.algebra import Scalar, Vector, floats
from ...scalar.element import Polynomial
from ...scalar.expression import evaluate
from ...symbolic.equations import Equations
from ...symbolic.printing.display import latex
from ..paper.palette import GREY
from ..paper.placing import Placer, inside
from ..paper.sheet import Arrow, Group, Line, Style, arc
from ..paper.view import View
from .configuration import Configuration
from .shapes import Primitive, attachments, holds, numbers
from .solid_pieces import pieces_of

Array = NDArray[np.float64]

THIN = Style(GREY, 0.7)
DASHED = Style(GREY, 0.7, (4.0, 2.5))
CENTRE_LINE = Style(GREY, 0.7, (8.0, 2.0, 1.5, 2.0))

ROUND = ("disk", "ring", "cylinder", "sphere", "spherical_shell", "tube")
"""Kinds of solids that have a radius."""

FORESHORTENED = 0.35
"""Least part of a length that is left on paper for it to be dimensioned."""

SHORT = 20.0
"""Length below which its arrows stand outside [pt]."""

Measured = tuple[Group, str, tuple[Array, Array | None]]
"""A measure: its lines, its label, and the anchor of the label (point, direction from it)."""


class OnPaper(Protocol):
    """Bodies on paper: the model, its configuration, the view, and the points per unit of length."""

    e: Equations
    now: Configuration
    view: View
    scale: float

    def page(self, point: Any) -> Array:
        """Map a point in ground axes to paper [pt]."""


def angle_of(
    m: OnPaper, body: str, relative: bool = False, pieces: Sequence[Primitive] = ()
) -> list[Measured]:
    """Angle of a body in a planar machine, from its direction at zero coordinates; empty if there is none to show.

    With ``relative``, the angle is that of the body's own joint, from the direction at zero of that coordinate alone.
    If no piece in ``pieces`` contains the joint, the angle is drawn at the mass centre.
    """
    e, now, view, model, state = m.e, m.now, m.view, m.e.model, m.e.state
    if view.normal is None:
        return []
    total: Scalar = 0
    angle = 0.0
    i = model.bodies[body].link
    while i != GROUND:
        link = model.links[i]
        if link.turns_only:
            sign = 1.0 if float(now.state(link.axis[view.normal])) * view.toward[view.normal] > 0 else -1.0
            exact_sign = 1 if float(now.state(link.axis[view.normal])) > 0 else -1
            total = total + exact_sign * state(link.displacement)
            angle += sign * float(now.state(link.displacement))
            if relative:
                break
        elif link.own or link.advances:
            return []
        i = link.parent
    shown = latex(total, e.ring)
    if not e.ring.atoms_of(e.ring.coerce(total)):
        return []
    if shown.startswith("-"):
        shown = latex(-total, e.ring)
    joint = next(joint for joint in model.joints.values() if joint.child == body)
    base = now.place(body, joint.to)
    start = m.page(base)
    ends = [m.page(now.place(body, model.bodies[body].center))]
    R, p = now.posture(body)
    ends += [m.page(p + R @ q) for q in attachments(model, now.state, body).values()]
    ends += [  # what slides along the body shows its direction, too
        m.page(now.place(other.child, other.to))
        for other in model.joints.values()
        if other.parent == body and other.pair.guided
    ]
    local = numbers(now.state, joint.to)
    if pieces and not any(holds(piece, local, 3.0 / m.scale) for piece in pieces):
        start = m.page(now.place(body, model.bodies[body].center))
        ends = [q for piece in pieces for q in m.page(p + piece.points() @ R.T)]
    reach = [float(np.linalg.norm(q - start)) for q in ends]
    far = int(np.argmax(reach))
    if reach[far] < 14.0:
        if pieces:
            return []
        # a body that turns about its mass centre: the direction of its axis 1
        ends, reach, far = [start + 48.0 * view(R[:, 0])], [48.0], 0
    d = (ends[far] - start) / reach[far]
    angle = math.remainder(angle, 2 * math.pi)
    if abs(angle) < math.radians(4):
        return []
    now_at = math.atan2(d[1], d[0])
    zero = now_at - angle
    radius = min(34.0, 0.62 * reach[far])
    reference = np.array([start, start + (radius + 14.0) * np.array([math.cos(zero), math.sin(zero)])])
    swept = arc(start, radius, zero, now_at)
    barred = any(
        piece.kind in ("slender_bar", "rod") and holds(piece, local, 3.0 / m.scale)
        for piece in pieces_of(now, planar=True)[body]
    )
    axis = [] if barred or pieces else [Line(np.array([start, ends[far]]), CENTRE_LINE)]
    group = Group(
        [*axis, Line(reference, DASHED), Arrow(swept, Style(GREY, 0.8), "full")],
        {"class": "angle", "data-symbol": shown},
        f"angle of {body}",
    )
    middle = swept[len(swept) // 2]
    out = (middle - start) / radius
    return [(group, f"${shown}$", (middle, out))]


def dimensions_of(m: OnPaper, body: str, placer: Placer, center: bool = True) -> list[Measured]:
    """Distances between points of a body along its axes, and the radius of a round body.

    With ``center``, the chain along the length has the mass centre as a point; otherwise in both chains, except on
    a bar, and where it lies midway.
    """
    e, now = m.e, m.now
    result = _radius(m, body, placer)
    points = named_points(e, body)
    touched = _touched(e, body)
    if center:
        return result + chain(m, body, placer, points, _longest(now, points))
    shape = e.model.bodies[body].shape
    if shape is not None and shape.kind == "slender_bar":
        del points["C"]
    shown = {tex for _, tex, _ in result}
    for k in range(3):
        if k != m.view.normal:
            along = _without_midway(e, now, points | touched | _faces(e, body, k), k)
            # the distance of a rim from its centre is the radius
            for measured in chain(m, body, placer, along, k):
                if measured[1] not in shown:
                    for item in measured[0].items:
                        placer.line(item.points)
                    result.append(measured)
    return result


def ground_dimensions(m: OnPaper, placer: Placer) -> list[Measured]:
    """Distances between the hinges and pivots that are fixed in the ground, along ground axes."""
    fixed: dict[str, Vector] = {
        name: joint.at
        for name, joint in m.e.model.joints.items()
        if joint.parent == "ground" and (joint.pair.revolute or joint.pair.spherical)
    }
    for name, closure in m.e.model.constraints.items():
        held = isinstance(closure, Closure) and (closure.pair.revolute or closure.pair.spherical)
        if held and closure.parent.is_ground:
            fixed[name] = closure.at
    axes = [k for k in range(3) if k != m.view.normal] if len(fixed) > 1 else []
    return [measured for k in axes for measured in chain(m, "ground", placer, fixed, k)]


def _longest(now: Configuration, points: dict[str, Vector]) -> int:
    """Number of the body axis along which points lie farthest apart."""
    values = np.array([[float(now.state(x)) for x in v] for v in points.values()])
    return int(np.argmax(np.ptp(values, axis=0)))


def _without_midway(e: Equations, now: Configuration, points: dict[str, Vector], k: int) -> dict[str, Vector]:
    """The points without those that lie midway between their neighbours for all values of the parameters.

    Only the mass centre, and points that a planar joint gives coordinates, are left out.
    """
    movable = {name for name, joint in e.model.joints.items() if joint.pair.planar} | {"C"}
    for name in sorted(movable & set(points)):
        if name not in points:
            continue
        p = points[name]
        at = {key: float(now.state(q[k])) - float(now.state(p[k])) for key, q in points.items()}
        here = [key for key in at if sympy.expand(points[key][k] - p[k]) == 0]
        below = [key for key in at if at[key] < 0 and key not in here]
        above = [key for key in at if at[key] > 0 and key not in here]
        if set(here) <= movable and below and above:
            low, high = max(below, key=at.__getitem__), min(above, key=at.__getitem__)
            if sympy.expand(points[low][k] + points[high][k] - 2 * p[k]) == 0:
                points = {key: q for key, q in points.items() if key not in here}
    return points


def _touched(e: Equations, body: str) -> dict[str, Vector]:
    """Points of a body that touch, by the name of the contact."""
    return {
        contact.name: shape.components
        for contact in e.model.contacts
        for shape in (contact.feature, contact.surface)
        if shape.look == "spot" and shape.body.name == body
    }


def _faces(e: Equations, body: str, k: int) -> dict[str, Vector]:
    """Middles of the two faces of a box across an axis, if their distance depends on parameters; in body axes."""
    shape = e.model.bodies[body].shape
    if shape is None or shape.kind != "box":
        return {}
    result: dict[str, Vector] = {}
    edge = shape.dimensions[k][1]
    if sympy.sympify(edge).free_symbols:
        for sign in (-1, 1):
            middle = sympy.Matrix(shape.center) + sympy.Matrix(shape.axes)[:, k] * edge * sign / 2
            result[f"face {sign}"] = tuple(middle)
    return result


def named_points(e: Equations, body: str) -> dict[str, Vector]:
    """Points of joints, loads and constraints on a body, and the ends of a bar: expressions in body axes, by name."""
    model = e.model
    named: dict[str, Vector] = {"C": model.bodies[body].center}
    for name, joint in model.joints.items():
        if joint.child == body and not joint.pair.free:
            named[name] = joint.to
        elif joint.parent == body and joint.pair.holds:
            named[name] = joint.at
    for load in model.loads.values():
        for end, point in load.points.items():
            if point.body.name == body:
                named[f"{load.name} {end}"] = point.components
    for name, constraint in model.constraints.items():
        for side, point_name in (("child", "to"), ("parent", "at")):
            holder = getattr(constraint, side, None)
            if holder is not None and holder.name == body:
                named[name] = getattr(constraint, point_name)
        if isinstance(constraint, Rolling) and constraint.center.body.name == body:
            named[name] = constraint.center.components
    shape = model.bodies[body].shape
    if shape is not None and shape.kind == "slender_bar" and not shape.parts and not shape.look:
        half = shape["length"] / 2
        unit = sympy.Matrix(shape.axis)
        unit = unit / unit.norm()
        for sign in (1, -1):
            named[f"end {sign}"] = tuple(
                sympy.Matrix(shape.axes) * unit * half * sign + sympy.Matrix(shape.center)
            )
    return named


def _radius(m: OnPaper, body: str, placer: Placer) -> list[Measured]:
    """Radius of a round body, along the least crowded direction; empty for other bodies."""
    shape = m.e.model.bodies[body].shape
    if shape is None or shape.kind not in ROUND:
        return []
    radius = shape["outer" if shape.kind == "tube" else "radius"]
    middle = m.page(m.now.place(body, shape.center))
    r = m.scale * float(m.now.state(radius))
    choices = []
    for j in range(12):
        t = math.radians(30 * j + 20)
        line = np.array([middle, middle + r * np.array([math.cos(t), math.sin(t)])])
        choices.append((placer.crowding(line), j, line))
    line = min(choices, key=lambda choice: choice[:2])[2]
    if m.e.model.parameters and not isinstance(m.e.state(radius), Polynomial):
        return []
    tex = latex(m.e.state(radius), m.e.ring)
    group = Group([Arrow(line, Style(GREY, 0.8))], {"class": "dimension", "data-symbol": tex}, "radius")
    d = (line[1] - line[0]) / max(r, 1e-9)
    return [(group, f"${tex}$", (line.mean(axis=0), np.array([-d[1], d[0]])))]


def _clear(placer: Placer, at: Array, d: Array) -> Array:
    """Foot of the line of a length: beyond the last area that a ray from a point crosses."""
    ray = at + np.arange(0.0, 500.0, 2.0)[:, None] * d
    within = (
        np.any([inside(area, ray) for area in placer.areas], axis=0) if placer.areas else np.zeros(1, bool)
    )
    last = int(np.flatnonzero(within).max(initial=0))
    return np.asarray(ray[last] + (4.0 if last else 7.0) * d)


def _has_number(e: Equations, distance: Scalar) -> bool:
    """True if a distance is a number, or the sum of a number and others."""
    return not isinstance(distance, Polynomial) or bool(e.sympy(distance).expand().as_coeff_Add()[0] != 0)


def chain(m: OnPaper, body: str, placer: Placer, named: dict[str, Vector], k: int) -> list[Measured]:
    """One chain of dimensions, along axis ``k`` of the body."""
    e, now, view = m.e, m.now, m.view
    exact = {name: tuple(e.state(x) for x in v) for name, v in named.items()}
    points = {name: numbers(now.state, v) for name, v in named.items()}
    if not points:
        return []
    span = np.ptp(np.array(list(points.values())), axis=0)
    stops: list[str] = []
    for name in sorted(points, key=lambda name: float(points[name][k])):
        if not stops or (points[name][k] - points[stops[-1]][k]) * m.scale > 6.0:
            stops.append(name)
    R, p = now.posture(body)
    along = view(R[:, k])
    length = float(np.linalg.norm(along))
    if span[k] * m.scale < 12.0 or length < FORESHORTENED or len(stops) < 2:
        return []
    across = np.array([-along[1], along[0]]) / length
    # in space, where axes are not at right angles on paper: on the line along the axis through the first point
    unit, first = np.eye(3)[k], points[stops[0]]
    on_line = [points[name] if view.planar else first + (points[name][k] - first[k]) * unit for name in stops]
    pages = [m.page(p + R @ point) for point in on_line]
    places = [m.page(p + R @ points[name]) for name in stops]
    choices: list[tuple[float, int, Array, float]] = []
    for rank, normal in enumerate((across, -across)):
        edge = max((float((area @ normal).max()) for area in placer.areas), default=0.0)
        for gap in (24.0, 36.0, 48.0):
            line = np.array([q + (edge + gap - float(q @ normal)) * normal for q in (pages[0], pages[-1])])
            leads = [np.array([q + 7 * normal, p]) for q, p in zip((pages[0], pages[-1]), line, strict=True)]
            # better below than above, and no lines through the body
            cost = (
                0.5 * sum(map(placer.crowding, leads))
                + placer.crowding(line)
                + 0.1 * float(normal[1] > 0)
                + 0.003 * gap
                + 0.001 * rank
            )
            choices.append((cost, len(choices), normal, edge + gap))
    _, _, normal, level = min(choices, key=lambda choice: choice[:2])
    result: list[Measured] = []
    for i, (before, after) in enumerate(zip(stops, stops[1:], strict=False)):
        a, b = pages[i : i + 2]
        room = float(np.linalg.norm(b - a)) >= SHORT
        feet = [_clear(placer, q, normal) if room and not view.planar else q + 7 * normal for q in (a, b)]
        distance = exact[after][k] - exact[before][k]
        if e.model.parameters and _has_number(e, distance):
            continue  # a number among parameters belongs to the look of a body, or to data that have no symbol
        tex = latex(distance, e.ring)
        low, high = (q + (level - float(q @ normal)) * normal for q in (a, b))
        group = Group(
            [
                Line(np.array([feet[0], low + 4 * normal]), THIN),
                Line(np.array([feet[1], high + 4 * normal]), THIN),
                Arrow(np.array([low, high]), Style(GREY, 0.8), "both" if room else "inward"),
            ],
            {
                "class": "dimension",
                "data-symbol": tex,
                "data-axis": f"{body} {'xyz'[k]}",
                "data-value": f"{float(evaluate(e.sympy(distance), now.lookup, floats)):.12g}",
            },
            f"from {before} to {after}",
        )
        group.add(
            *(
                Line(np.array([q, r]), DASHED)
                for q, r in zip(places, pages, strict=True)
                if np.hypot(*(q - r)) > 3.0
            )
        )
        result.append((group, f"${tex}$", ((low + high) / 2, normal)))
    return result
