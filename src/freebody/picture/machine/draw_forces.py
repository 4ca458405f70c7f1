"""Springs, dampers, loads and gravity in the drawing of a machine."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...describe.description import vector
from ...describe.frame import Point
from ...describe.loads.action import Action, Couple, JointForce, PointForce
from ...describe.loads.load import Load
from ...dynamics.loads.actions import places
from ...dynamics.loads.power import joint_link
from ...errors import ModelError, shown
from ...symbolic.printing.display import latex
from ...symbolic.printing.latex import latex_name, latex_number
from ..paper import symbols
from ..paper.palette import INK, VERMILLION
from ..paper.sheet import Arrow, Line, Style, arc, box_of
from .force_arrows import Mark, Marks
from .lines_of_action import mark_line, moved_forces
from .machine_drawing import MachineDrawing
from .shapes import ends_of, numbers

Array = NDArray[np.float64]

FORCE = 42.0
"""Length of the arrow of a load [pt]."""


def springs(m: MachineDrawing) -> None:
    """Draw loads with a symbol, between points and on joints, with the walls that hold them."""
    for name, load in m.model.loads.items():
        if not _has_symbol(m, load):
            continue
        if ends := ends_of(m.model, load):
            start, end = ends
            a, b = m.page(m.now.point(start)), m.page(m.now.point(end))
            a, b = _surface(m, start, a, b - a), _surface(m, end, b, a - b)
            m.add(_symbol(load)(a, b), class_=load.look.role, data_load=name)
            _spring_label(m, load, (a + b) / 2, b - a)
            for point, q in ((start, a), (end, b)):
                if point.body.is_ground:
                    _wall(m, q, b - a if point is start else a - b)
        for action in places(m.model)[name]:
            if isinstance(action, JointForce):
                _joint_spring(m, load, action)


def _has_symbol(m: MachineDrawing, load: Load) -> bool:
    """True if a load is drawn as a symbol between two points or along a joint, and not by the arrows of its actions."""
    along = any(isinstance(action, JointForce) for action in places(m.model)[load.name])
    return bool(load.look.symbol) and (along or bool(ends_of(m.model, load)))


def _symbol(load: Load) -> Callable[[Array, Array], list[Any]]:
    return symbols.zigzag if load.look.symbol == "zigzag" else symbols.dashpot


def _surface(m: MachineDrawing, point: Point, at: Array, along: Array) -> Array:
    """Return the end of a spring at a body: on the edge of a particle, which is drawn larger than it is."""
    name, length = point.body.name, float(np.linalg.norm(along))
    pieces = m.pieces.get(name, ())
    if name not in m.drawn or length == 0 or not pieces or any(piece.kind != "particle" for piece in pieces):
        return at
    return np.asarray(at + min(m.reach(name, at, along / length), 0.4 * length) * along / length)


def _spring_label(m: MachineDrawing, load: Load, at: Array, along: Array) -> None:
    if not load.look.label:
        return
    length = float(np.linalg.norm(along))
    side = np.array([-along[1], along[0]]) / length if length > 0 else np.array([0.0, 1.0])
    if side[1] < 0:
        side = -side
    tex = f"${latex(m.e.state(getattr(load, load.look.label)), m.e.ring)}$"
    m.labels.append((tex, [(at + 6.0 * side, side), (at - 6.0 * side, -side)], 11.0, INK))


def _joint_spring(m: MachineDrawing, load: Load, action: JointForce) -> None:
    joint = m.joints[action.joint.name]
    at, name = m.page(joint.point), load.name
    d = m.axis(action.joint.name, action.index)
    link = m.model.links[joint_link(m.model, action)]
    if not link.slides_only or d is None:
        _turning(m, load, at, joint.child, d, joint_link(m.model, action))
        return
    base = m.page(m.now.place(joint.parent, m.model.joints[action.joint.name].at))
    same = [
        key
        for key, other in m.model.loads.items()
        if other.look.symbol and any(_alike(action, x) for x in places(m.model)[key])
    ]
    beside = same.index(name)
    normal = np.array([-d[1], d[0]])
    shift = (9.0 if beside == 0 else -9.0) * normal if len(same) > 1 else np.zeros(2)
    half = m.reach(joint.child, at, -d)
    # on the line of this axis, if the joint has several
    wall = at + float((base - at) @ d) * d - (half + 60.0) * d
    start, end = wall + shift, at - half * d + shift
    m.add(_symbol(load)(start, end), class_=load.look.role, data_load=name)
    if not beside:
        _wall(m, wall, d)
    _spring_label(m, load, (start + end) / 2, end - start)


def _turning(m: MachineDrawing, load: Load, at: Array, child: str, axis: Array | None, number: int) -> None:
    """Draw a spring or a damper of a turn across its axis, beside the body if the axis does not point at the reader."""
    make = symbols.spiral if load.look.symbol == "zigzag" else symbols.turning_dashpot
    places, across = [at], np.eye(2)
    shafts: list[list[Any]] = [[]]
    if axis is not None and not m.view.planar and m.model.links[number].turns_only:
        # seen along its axis by a half at least: from the side it is a line
        reaches = [(side * axis, m.reach(child, at, side * axis)) for side in (1.0, -1.0)]
        places = [at + (reach + 10.0) * d for d, reach in reaches]
        shafts = [
            [Line(np.array([at + reach * d, at + (reach + 14.0) * d]), symbols.THIN)] for d, reach in reaches
        ]
        seen = abs(float(m.view.toward @ m.axis_in_space(m.model.links[number], number)))
        across = np.array([[-axis[1], axis[0]], max(seen, 0.5) * axis])
    turns = [
        np.array([[math.cos(a), math.sin(a)], [-math.sin(a), math.cos(a)]])
        for a in np.radians(range(0, 360, 30))
    ]
    choices = [
        (place, [*shaft, *make(place, turn @ across)])
        for place, shaft in zip(places, shafts, strict=True)
        for turn in turns
    ]
    costs = [
        m.placer.crowding(np.vstack([line.points for line in items]), at) + 0.001 * k
        for k, (_, items) in enumerate(choices)
    ]
    place, items = choices[int(np.argmin(costs))]
    m.add(items, class_=load.look.role, data_load=load.name)
    if not m.many and load.look.label:
        middle = np.mean(np.vstack([line.points for line in items]), axis=0)
        out = middle - place
        length = float(np.linalg.norm(out))
        along = np.array([1.0, 0.0]) if length < 3.0 else np.array([out[1], -out[0]]) / length
        _spring_label(m, load, middle, 20.0 * along)


def _alike(action: JointForce, other: Action) -> bool:
    """True if the other action is along the same axis of the same joint."""
    return isinstance(other, JointForce) and other.joint is action.joint and other.index == action.index


def _wall(m: MachineDrawing, at: Array, toward: Array) -> None:
    """Draw a piece of hatched wall whose free side faces a direction."""
    d = toward / np.linalg.norm(toward)
    across = np.array([-d[1], d[0]])
    m.add(symbols.hatched(at - 14.0 * across, at + 14.0 * across, -1.0), class_="wall")


def loads(m: MachineDrawing) -> None:
    """Draw the arrows of applied forces and couples, and label each with its name or value.

    A crowded machine is drawn without the arrows of what acts along its joints.
    """
    applied = [
        name
        for name, load in m.model.loads.items()
        if not _has_symbol(m, load)
        and not (m.many and all(isinstance(action, JointForce) for action in places(m.model)[name]))
    ]
    if not applied:
        return
    marks = Marks(m.e, m.now, m.view.planar, reactions=False)
    style = Style(VERMILLION, 1.8)
    anchors_of: dict[tuple[str, str], list[Any]] = {}
    at_of: dict[tuple[str, str], list[Array]] = defaultdict(list)
    moved = moved_forces(m)
    combined = {couple for couple, _, _ in moved.values()}
    for name in applied:
        if name in combined:
            continue
        for body in _carriers(m, name):
            free = m.e.free_body(body)
            for action in free.actions:
                if action.load != name:
                    continue
                for exact, couple in ((action.force, False), (action.moment, True)):
                    if any(x != 0 for x in exact):
                        for mark in marks.resolved(action.name, "load", couple, exact, action.at, free):
                            at = mark_line(m, name, *moved[name]) if name in moved else m.page(mark.point)
                            # an action and its reaction share one label; at one point one arrow is enough
                            shared = anchors_of.setdefault((name, mark.label), [])
                            if not any(
                                float(np.linalg.norm(at - other)) < 1.0 for other in at_of[(name, mark.label)]
                            ):
                                shared.append(_load(m, name, mark, at, style))
                                at_of[(name, mark.label)].append(at)
    for (_, label), anchors in anchors_of.items():
        m.labels.append((f"${label}$", anchors, 11.0, VERMILLION))


def _carriers(m: MachineDrawing, name: str) -> list[str]:
    """Names of the bodies on which a load is drawn: those that it acts on, and the child of a joint."""
    result: dict[str, None] = {}
    for action in places(m.model)[name]:
        match action:
            case PointForce(point):
                result[point.body.name] = None
            case Couple(body):
                result[body.name] = None
            case JointForce(joint):
                result[m.model.joints[joint.name].child] = None
    return [body for body in result if body != "ground"]


def _load(m: MachineDrawing, name: str, mark: Mark, at: Array, style: Style) -> tuple[Array, Array]:
    """Draw the arrow of a load; return the anchor of its label: (point, direction from it)."""
    if mark.couple and m.view.planar:
        turn = 1.0 if m.view.turn(mark.direction) > 0 else -1.0
        choices = [
            arc(at, r, math.radians(a), math.radians(a) + turn * math.radians(200))
            for r in (20.0, 27.0, 34.0)
            for a in range(0, 360, 30)
        ]
    else:
        projected = m.view(mark.direction)
        d = projected / max(float(np.linalg.norm(projected)), 1e-9)
        choices = [np.array([at, at + FORCE * d]), np.array([at - FORCE * d, at])]
    costs = [m.placer.crowding(points, at) + 0.01 * k for k, points in enumerate(choices)]
    points = choices[int(np.argmin(costs))]
    arrow = Arrow(points, style, "double" if mark.couple and not m.view.planar else "full")
    m.add([arrow], class_="load", data_load=name)
    far = points[-1] if float(np.linalg.norm(points[-1] - at)) > 6.0 else points[0]
    if mark.couple and m.view.planar:
        far = points[len(points) // 2]
    out = far - at
    return far, out / max(float(np.linalg.norm(out)), 1e-9)


def impulses(m: MachineDrawing, blows: Mapping[str, Any]) -> None:
    """Draw blows: an open arrow whose tip is at the point that is struck, labelled with a hat.

    Raises
    ------
    ModelError
        If the point is not a point of the machine, or the impulse is zero there.
    """
    for name, (point, components) in blows.items():
        body = getattr(getattr(point, "body", None), "name", None)
        if body not in m.model.bodies:
            raise ModelError(
                f"Expected a point of a body of '{m.model.name}' for the impulse '{name}', got {shown(point)}."
            )
        system = point.body.system
        v = numbers(m.now.state, vector(system, components, f"the impulse '{name}'"))
        at, d = m.page(m.now.point(point)), m.view(v)
        if not d.any():
            raise ModelError(f"Expected an impulse '{name}' that the drawing can show, got zero in its view.")
        d = d / np.linalg.norm(d)
        arrow = Arrow(np.array([at - 1.2 * FORCE * d, at]), Style(VERMILLION, 1.8), "open")
        m.add([arrow], class_="impulse", data_load=name)
        m.labels.append((rf"$\hat{{{latex_name(name)}}}$", [(at - 1.2 * FORCE * d, -d)], 11.0, VERMILLION))


def gravity(m: MachineDrawing) -> None:
    """Draw the direction of gravity, above to the right."""
    g = m.view.gravity
    if g is None or not g.any():
        return
    d = m.view(g)
    length = float(np.linalg.norm(d))
    if length == 0:
        return
    x0, y0, x1, y1 = box_of(m.root)
    start = np.array([x1 + 16.0, y1 - 4.0])
    arrow = Arrow(np.array([start, start + 30.0 * d / length]), Style(INK, 1.2))
    m.add([arrow], class_="gravity")
    components = [c for c in m.model.gravity if not (isinstance(c, int) and c == 0)]
    tex = r"\mathbf{g}"
    if len(components) == 1 and isinstance(components[0], int | Fraction):
        tex = latex_number(abs(float(components[0]))) + r"\,\mathrm{m/s^2}"
    elif len(components) == 1:
        tex = latex(m.e.state(components[0]), m.e.ring).removeprefix("-")
    m.labels.append((f"${tex}$", [(start + 15.0 * d / length, np.array([1.0, 0.0]))], 11.0, INK))
