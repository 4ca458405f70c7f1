"""Coordinates, lengths and axes in the drawing of a machine."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...dynamics.kinematics import link_postures
from ...model.model import Link
from ...symbolic.printing.display import latex
from ..paper.palette import GREY, PALE
from ..paper.sheet import Arrow, Line, Style, box_of
from .machine_drawing import MachineDrawing
from .measures import Measured, angle_of, dimensions_of, ground_dimensions
from .shapes import numbers
from .space_dimensions import mark_tilts, space_dimensions

Array = NDArray[np.float64]

NEAR = 60.0
"""Distance of the centres of arcs within which an arc is drawn where it meets the others least [pt]."""

SQUARE = 0.3
"""Least length on paper of a unit vector along an axis on which an arc is moved: an arc moves where it is seen to."""


def mark_coordinates(m: MachineDrawing) -> None:
    """Draw displacements and angles of the joints, and the axes of bodies that turn freely."""
    shown: list[tuple[str, Array]] = []
    for name, joint in m.model.joints.items():
        for number in joint.links:
            link = m.model.links[number]
            if link.slides_only:
                _slide(m, name, number, link)
            elif link.turns_only and not m.view.planar:
                _turn(m, name, number, link)
        links = [m.model.links[i] for i in joint.links]
        if any(link.own for link in links):
            _body_axes(m, joint.child)
        if m.view.planar and any(link.turns_only for link in links):
            angles = [angle_of(m, joint.child, relative) for relative in (False, True)]
            # the angle with the shorter label: the absolute one, if that is what the coordinate measures
            best = min((angle for angle in angles if angle), key=lambda angle: len(angle[0][1]), default=[])
            at = m.page(m.joints[name].point)
            known = [q for tex, q in shown if best and tex == best[0][1]]
            if any(float(np.linalg.norm(at - q)) < 1.0 for q in known):
                continue  # the same angle about the same point
            shown += [(tex, at) for _, tex, _ in best]
            _add_measures(m, best)


def _add_measures(m: MachineDrawing, measures: list[Measured]) -> None:
    for group, tex, anchor in measures:
        m.root.add(group)
        for item in group.items:
            m.placer.line(item.points)
        m.labels.append((tex, [anchor], 10.5, GREY))


def _slide(m: MachineDrawing, name: str, number: int, link: Link) -> None:
    """Draw a displacement: an arrow from the point of the joint on the parent, beside the path."""
    tex = latex(m.e.state(link.displacement), m.e.ring)
    if not m.e.ring.atoms_of(m.e.ring.coerce(m.e.state(link.displacement))):
        return
    value = float(m.now.state(link.displacement))
    axis = m.axis_in_space(link, number)
    end = np.array(link_postures(m.model, m.now.state)[number].position, dtype=float)
    start, end = m.page(end - value * axis), m.page(end)
    path = end - start
    length = float(np.linalg.norm(path))
    if length < 8.0:
        return
    d = path / length
    far = length > math.sqrt(2) * m.wide  # more than the diagonal of the machine
    if far:  # the arrow does not start at a distant origin
        start = end - 0.6 * m.wide * d
    side = np.array([-d[1], d[0]])
    choices = []
    child = m.model.joints[name].child
    # in a plane, beside the body: lines do not lead through it
    edges = {
        s: m.reach(child, end, s * side) if m.view.planar and child in m.drawn else 0.0 for s in (1.0, -1.0)
    }
    for k, (sign, gap) in enumerate((s, g) for g in (24.0, 34.0, 46.0) for s in (1.0, -1.0)):
        gap = max(gap, edges[sign] + gap - 10.0)
        line = np.array([start, end]) + sign * gap * side
        choices.append((m.placer.crowding(line) + 0.004 * gap + 0.001 * k, k, sign * gap * side))
    shift = min(choices, key=lambda choice: choice[:2])[2]
    out = shift / np.linalg.norm(shift)
    edge = max(13.0, edges[float(np.sign(shift @ side))] + 3.0)
    items = [
        Line(np.array([end + edge * out, end + shift + 4 * out]), Style(GREY, 0.7)),
        Arrow(np.array([start, end]) + shift, Style(GREY, 0.9)),
    ]
    if far:
        items.append(Line(np.array([start, start - 22.0 * d]) + shift, Style(GREY, 0.9, (3.0, 3.0))))
    else:
        foot = max(3.0, float(np.linalg.norm(shift)) - 22.0)
        items.append(Line(np.array([start + foot * out, start + shift + 4 * out]), Style(GREY, 0.7)))
    m.add(items, class_="coordinate", data_joint=name)
    m.labels.append((f"${tex}$", [((start + end) / 2 + shift, out)], 10.5, GREY))


def _turn(m: MachineDrawing, name: str, number: int, link: Link) -> None:
    """Draw an angle in space: an arc about its axis, from a direction before the turn to that direction after it."""
    value = float(m.now.state(link.displacement))
    exact = m.e.state(link.displacement)
    if not m.e.ring.atoms_of(m.e.ring.coerce(exact)):
        return
    posture = link_postures(m.model, m.now.state)[number]
    R = np.array(posture.rotation, dtype=float)
    n = m.axis_in_space(link, number)
    chain = m.model.joints[name].links
    place = chain.index(number)
    neighbours = [chain[place + 1]] if place + 1 < len(chain) else []
    neighbours += [chain[place - 1]] if place > 0 else []
    candidates = [numbers(m.now.state, m.model.links[i].axis) for i in neighbours]
    candidates += [np.eye(3)[k] for k in range(3)]
    local = numbers(m.now.state, link.axis)
    across = np.cross(local, np.eye(3)[int(np.argmin(np.abs(local)))])  # an oblique axis has no other one
    candidates.append(across / float(np.linalg.norm(across)))
    square = [R @ d for d in candidates if abs(float(d @ local)) < 1e-9]
    # a turn between others is measured from their axes, a single one from where there is room
    square = square[:1] if neighbours else [sign * d for d in square[:2] for sign in (1, -1)]
    point = m.joints[name].point
    at = m.page(point)
    box = m.page(m.extent)
    if float(np.abs(at - box.mean(axis=0)).max()) > 2 * m.wide:
        _far_axis(m, name, at, box)
        return
    # arcs about one point have increasing radii, or lie apart on their axes
    concentric = sum(float(np.linalg.norm(at - q)) < 1.0 for q in m.arcs)
    m.arcs.append(at)
    near = sum(float(np.linalg.norm(at - q)) < NEAR for q in _turning(m)) > 1
    count = max(8, int(abs(math.degrees(value)) / 4))
    choices = []
    places = [0.0, *_along_axis(m, name, number, at, n)] if near else [0.0]
    for k, (shift, r) in enumerate((s, r) for s in places for r in (square if near else square[:1])):
        center = point + shift * n
        before = _about(n, -value) @ r
        for further in range(3 if near else 1):
            more = further if shift else concentric + further
            radius = ((24.0 if m.many or shift else 40.0) + 13.0 * more) / m.scale
            turns = np.linspace(0, value, count)
            curve = np.array([m.page(center + radius * (_about(n, a) @ before)) for a in turns])
            foot = m.page(center)
            ends = [np.array([foot, m.page(center + 1.35 * radius * d)]) for d in (before, r)]
            cost = sum(m.placer.crowding(line) for line in (curve, *ends)) if near else 0.0
            choices.append((cost + 0.1 * (further + (shift != 0.0)), k, further, radius, curve, ends))
    *_, radius, curve, ends = min(choices, key=lambda choice: choice[:3])
    sides = [Line(ends[0], Style(GREY, 0.7, (4.0, 2.5))), Line(ends[1], Style(GREY, 0.7))]
    items: list[Any] = [
        *([] if m.many else sides),
        Line(np.array([at, m.page(point + 1.5 * radius * n)]), Style(PALE, 0.9, (8.0, 2.0, 1.5, 2.0))),
    ]
    if float(np.linalg.norm(np.diff(curve, axis=0), axis=1).sum()) > 10.0:
        items.append(Arrow(curve, Style(GREY, 0.9)))
    m.add(items, class_="coordinate", data_joint=name)
    middle = curve[len(curve) // 2]
    out = middle - ends[0][0]
    out = out / max(float(np.linalg.norm(out)), 1e-9)
    m.labels.append((f"${latex(exact, m.e.ring)}$", [(middle, out)], 10.5, GREY))


def _turning(m: MachineDrawing) -> list[Array]:
    """Points of all turns of joints whose angles are drawn, on paper."""
    return [
        m.page(m.joints[name].point)
        for name, joint in m.model.joints.items()
        for link in (m.model.links[i] for i in joint.links)
        if link.turns_only and m.e.ring.atoms_of(m.e.ring.coerce(m.e.state(link.displacement)))
    ]


def _along_axis(m: MachineDrawing, name: str, number: int, at: Array, n: Array) -> list[float]:
    """Distances from a joint, along an axis of its, at which the arc of a turn may lie as well.

    That of a hinge lies at either end of its shaft, that of the last of several turns between the joint and the mass
    centre of its body: an arc measures the same angle anywhere along its axis.
    """
    _, _, parent, child, point = m.joints[name]
    chain = m.model.joints[name].links
    paper = m.view(n)
    length = float(np.linalg.norm(paper))
    if number != chain[-1] or length < SQUARE:
        return []
    d = paper / length
    if len(chain) > 1:
        arm = float((m.now.place(child, m.model.bodies[child].center) - point) @ n)
        return [part * arm for part in (0.5, 0.7)] if abs(arm) * m.scale * length > NEAR else []
    return [s * (m.along(child, at, s * d) + 4.0) / (m.scale * length) for s in (1.0, -1.0)]


def _far_axis(m: MachineDrawing, name: str, at: Array, box: Array) -> None:
    """Draw the way to the distant axis of a hidden frame that carries the machine, with its length."""
    child = m.model.joints[name].child
    for key, joint in m.model.joints.items():
        distances = [m.e.state(x) for x in joint.at if x != 0]
        if joint.parent != child or len(distances) != 1:
            continue
        start = m.page(m.joints[key].point)
        d = (at - start) / np.linalg.norm(at - start)
        reach = max(float((q - start) @ d) for q in box) + 14.0
        line = np.array([start + reach * d, start + (reach + 52.0) * d])
        items = [
            Line(np.array([start, line[0]]), Style(GREY, 0.7, (3.0, 3.0))),
            Arrow(line, Style(GREY, 0.9)),
        ]
        m.add(items, class_="dimension", data_joint=name)
        m.labels.append((f"${latex(distances[0], m.e.ring)}$", [(line[1], d)], 10.5, GREY))


def _body_axes(m: MachineDrawing, body: str) -> None:
    """Draw the axes of a body that turns freely, as 1, 2, 3, unless its inertia is the same about every axis."""
    inertia = np.array([[float(m.now.state(x)) for x in row] for row in m.model.bodies[body].inertia])
    if np.allclose(inertia, inertia[0, 0] * np.eye(3), rtol=1e-9, atol=0):
        return
    R, p = m.now.posture(body)
    at = m.page(p)
    items = []
    for k in range(3):
        d = 34.0 * (m.view.matrix @ R[:, k])
        length = float(np.linalg.norm(d))
        if length > 6.0:
            items.append(Arrow(np.array([at, at + d]), Style(GREY, 1.0)))
            m.labels.append((f"${k + 1}$", [(at + d, d / length)], 10.0, GREY))
    m.add(items, class_="body-axes", data_body=body)


def mark_dimensions(m: MachineDrawing) -> None:
    """Draw the dimensions of the bodies; in space and in a machine of more than three bodies, each expression once."""
    done: set[str] = set()
    once = len(m.model.bodies) > 3 or not m.view.planar
    for name in m.model.bodies:
        if m.view.planar:
            placer = m.placer.about(m.areas_of(name))
            measures = dimensions_of(m, name, placer, center=False)
        else:
            measures = space_dimensions(m, name) if name in m.drawn else []
        for group, tex, anchor in measures:
            if tex in done and once:
                continue
            done.add(tex)
            _add_measures(m, [(group, tex, anchor)])
    if not m.view.planar:
        mark_tilts(m)
        return
    placer = m.placer.about([area for name in m.drawn for area in m.areas_of(name)])
    for group, tex, anchor in ground_dimensions(m, placer):
        if tex not in done:
            _add_measures(m, [(group, tex, anchor)])


def ground_axes(m: MachineDrawing) -> None:
    """Draw the directions of the ground axes, below to the left."""
    x0, y0, _, _ = box_of(m.root)
    origin = np.array([x0 + 14.0, y0 - 40.0])
    items = []
    for letter, k in m.view.axes:
        d = m.view.matrix[:, k]
        tip = origin + 26.0 * d
        items.append(Arrow(np.array([origin, tip]), Style(GREY, 0.9)))
        m.labels.append((f"${letter}$", [(tip, d / np.linalg.norm(d))], 10.0, GREY))
    m.add(items, class_="axes")


def _about(n: Array, angle: float) -> Array:
    """Rotation matrix of a turn by an angle about a unit vector."""
    K = np.array([[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]])
    return np.eye(3) + math.sin(angle) * K + (1 - math.cos(angle)) * (K @ K)
