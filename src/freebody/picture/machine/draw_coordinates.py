"""Coordinates, lengths and axes in the drawing of a machine, where they are measured."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...dynamics.kinematics import link_postures
from ...model.model import Link
from ...symbolic.printing.display import latex
from ..paper.palette import GREY, PALE
from ..paper.sheet import Arrow, Line, Style, box_of
from .measures import angle_of, dimensions_of

if TYPE_CHECKING:
    from .draw import Machine

Array = NDArray[np.float64]


def mark_coordinates(m: Machine) -> None:
    for name, joint in m.model.joints.items():
        for number in joint.links:
            link = m.model.links[number]
            if link.kind == "slider":
                _slide(m, name, number, link)
            elif link.kind == "hinge" and not m.view.planar:
                _turned(m, name, number, link)
        kinds = [m.model.links[i].kind for i in joint.links]
        if "ball" in kinds or "free" in kinds:
            _own_axes(m, joint.child)
        if m.view.planar and "hinge" in kinds:
            found = [
                angle_of(m.e, m.now, m.view, m.scale, joint.child, relative) for relative in (False, True)
            ]
            # the absolute angle, where it is what the coordinate measures
            best = min((one for one in found if one), key=lambda one: len(one[0][1]), default=[])
            _measured(m, best)


def _measured(m: Machine, found: list[Any]) -> None:
    for group, tex, anchor in found:
        m.root.add(group)
        for item in group.items:
            m.placer.line(item.points)
        m.labels.append((tex, [anchor], 10.5, GREY))


def _slide(m: Machine, name: str, number: int, link: Link) -> None:
    """A displacement: an arrow from the joint's point on the parent, beside the path."""
    shown = latex(m.e.state(link.displacement), m.e.ring)
    if not m.e.ring.atoms_of(m.e.ring.coerce(m.e.state(link.displacement))):
        return
    value = float(m.now.state(link.displacement))
    axis = m.axis_in_space(link, number)
    end = np.array(link_postures(m.model, m.now.state)[number].position, dtype=float)
    start, end = m.page(end - value * axis), m.page(end)
    way = end - start
    length = float(np.linalg.norm(way))
    if length < 8.0:
        return
    d = way / length
    far = length > m.wide
    if far:  # not all the way from a far origin
        start = end - 0.6 * m.wide * d
    side = np.array([-d[1], d[0]])
    choices = []
    for k, (sign, gap) in enumerate((s, g) for g in (24.0, 34.0, 46.0) for s in (1.0, -1.0)):
        line = np.array([start, end]) + sign * gap * side
        choices.append((m.placer.crowding(line) + 0.004 * gap + 0.001 * k, k, sign * gap * side))
    shift = min(choices, key=lambda one: one[:2])[2]
    out = shift / np.linalg.norm(shift)
    items = [
        Line(np.array([end + 13 * out, end + shift + 4 * out]), Style(GREY, 0.7)),
        Arrow(np.array([start, end]) + shift, Style(GREY, 0.9)),
    ]
    if far:
        items.append(Line(np.array([start, start - 22.0 * d]) + shift, Style(GREY, 0.9, (3.0, 3.0))))
    else:
        items.append(Line(np.array([start + 3 * out, start + shift + 4 * out]), Style(GREY, 0.7)))
    m.add(items, class_="coordinate", data_joint=name)
    m.labels.append((f"${shown}$", [((start + end) / 2 + shift, out)], 10.5, GREY))


def _turned(m: Machine, name: str, number: int, link: Link) -> None:
    """An angle in space: an arc about its axis, from where a direction was before the turn."""
    value = float(m.now.state(link.displacement))
    exact = m.e.state(link.displacement)
    if not m.e.ring.atoms_of(m.e.ring.coerce(exact)):
        return
    posture = link_postures(m.model, m.now.state)[number]
    R = np.array(posture.rotation, dtype=float)
    n = m.axis_in_space(link, number)
    chain = m.model.joints[name].links
    place = chain.index(number)
    beside = [chain[place + 1]] if place + 1 < len(chain) else []
    beside += [chain[place - 1]] if place > 0 else []
    own = [np.array([float(m.now.state(x)) for x in m.model.links[i].axis]) for i in beside]
    own += [np.eye(3)[k] for k in range(3)]
    local = np.array([float(m.now.state(x)) for x in link.axis])
    r = R @ next(d for d in own if abs(float(d @ local)) < 1e-9)
    before = _about(n, -value) @ r
    point = m.joints[name][3]
    # arcs about one point lie about each other
    beside_it = sum(float(np.linalg.norm(m.page(point) - q)) < 1.0 for q in m.arcs)
    m.arcs.append(m.page(point))
    radius = (40.0 + 13.0 * beside_it) / m.scale
    count = max(8, int(abs(math.degrees(value)) / 4))
    curve = np.array([m.page(point + radius * (_about(n, a) @ before)) for a in np.linspace(0, value, count)])
    at = m.page(point)
    fine = Style(GREY, 0.7, (4.0, 2.5))
    items: list[Any] = [
        Line(np.array([at, m.page(point + 1.35 * radius * before)]), fine),
        Line(np.array([at, m.page(point + 1.35 * radius * r)]), Style(GREY, 0.7)),
        Line(np.array([at, m.page(point + 1.5 * radius * n)]), Style(PALE, 0.9, (8.0, 2.0, 1.5, 2.0))),
    ]
    if float(np.linalg.norm(np.diff(curve, axis=0), axis=1).sum()) > 10.0:
        items.append(Arrow(curve, Style(GREY, 0.9)))
    m.add(items, class_="coordinate", data_joint=name)
    middle = curve[len(curve) // 2]
    out = middle - at
    out = out / max(float(np.linalg.norm(out)), 1e-9)
    m.labels.append((f"${latex(exact, m.e.ring)}$", [(middle, out)], 10.5, GREY))


def _own_axes(m: Machine, body: str) -> None:
    """The axes of a body that turns freely, as 1, 2, 3."""
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


def mark_dimensions(m: Machine) -> None:
    done: set[str] = set()
    for name in m.model.bodies:
        own = m.placer.about(m.areas_of(name))
        for group, tex, anchor in dimensions_of(m.e, m.now, m.view, m.scale, name, own, center=False):
            if tex in done and len(m.model.bodies) > 3:
                continue
            done.add(tex)
            _measured(m, [(group, tex, anchor)])


def ground_axes(m: Machine) -> None:
    """The directions of the ground's axes, below to the left."""
    x0, y0, _, _ = box_of(m.root)
    clear = np.array([x0 + 14.0, y0 - 40.0])
    items = []
    for letter, k in m.view.axes:
        d = m.view.matrix[:, k]
        tip = clear + 26.0 * d
        items.append(Arrow(np.array([clear, tip]), Style(GREY, 0.9)))
        m.labels.append((f"${letter}$", [(tip, d / np.linalg.norm(d))], 10.0, GREY))
    m.add(items, class_="axes")


def _about(n: Array, angle: float) -> Array:
    """The rotation by an angle about a unit vector."""
    K = np.array([[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]])
    return np.eye(3) + math.sin(angle) * K + (1 - math.cos(angle)) * (K @ K)
