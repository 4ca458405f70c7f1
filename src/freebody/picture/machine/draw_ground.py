"""The ground of a drawing: planes, guides and walls; ropes and belts."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...describe.constraints.constraint import Rolling
from ...dynamics.conditions.constraints import lowest_arm
from ...dynamics.conditions.contact import definite_touches
from ...dynamics.state import State
from ...scalar.element import Polynomial
from ...symbolic.printing.display import latex
from ...symbolic.printing.latex import latex_name
from ..paper import symbols
from ..paper.palette import GREEN, GREY, INK
from ..paper.placing import inside, sampled
from ..paper.sheet import Arrow, Circle, Line, Style, arc
from .configuration import NEAR
from .machine_drawing import ROUND, MachineDrawing
from .outlines import outlines, polygon
from .shapes import numbers, ropes_of, scenery_of

Array = NDArray[np.float64]


def scenery(m: MachineDrawing) -> None:
    """Draw the solids fixed in the ground: cut by the page in a planar machine, in pale grey in space."""
    pieces = scenery_of(m.model, m.now.state, m.wide / m.scale)
    for piece in pieces:
        fill = "#ffffff" if m.view.planar else "#e6e6e6"
        items = outlines(piece, np.eye(3), np.zeros(3), m.view, m.scale, fill)
        if m.view.planar:
            areas = [area for item in items if (area := polygon(item)) is not None]
            items = [part for area in areas for part in symbols.section(area)]
        m.add(items, class_="scenery")


def rolling_planes(m: MachineDrawing) -> None:
    """Draw the ground on which wheels roll."""
    wheels = [rolling for rolling in m.model.constraints.values() if isinstance(rolling, Rolling)]
    if not wheels:
        return
    footpoints = []
    for wheel in wheels:
        arm = np.array([float(x) for x in lowest_arm(m.model, m.now.state, wheel)])
        footpoints.append(m.now.point(wheel.center) + arm)
    middle = np.mean(footpoints, axis=0)
    if m.view.planar:
        _ground(m, middle, np.array([float(x) for x in wheels[0].normal[1]]))
        return
    size = max(m.wide / m.scale * 0.42, float(np.ptp(np.array(footpoints), axis=0).max()) * 0.75)
    first = np.array([float(x) for x in wheels[0].first[1]])
    second = np.array([float(x) for x in wheels[0].second[1]])
    corners = [
        m.page(middle + size * (a * first + b * second * 0.7))
        for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    m.add([Line(np.array(corners), Style(GREY, 0.8, (), "#f4f4f4"), True)], class_="plane")
    for foot in footpoints:
        m.add([Circle(m.page(foot), 2.0, Style(INK, 0.8, (), INK))], class_="contact")


def surfaces(m: MachineDrawing) -> None:
    """Draw the surfaces of the ground that bodies may touch: planes, sides, round walls and edges."""
    drawn: list[Any] = []
    names = {
        s: contact.name for contact in m.model.contacts[::-1] for s in (contact.feature, contact.surface)
    }
    for shape in m.model.touching:
        if not shape.body.is_ground or any(shape == other for other in drawn):
            continue
        drawn.append(shape)
        look = shape.look
        if look == "plane":
            _ground(m, numbers(m.now.state, shape.at), numbers(m.now.state, shape.normal))
        elif look == "side" and m.view.planar:
            start, end = (m.page(numbers(m.now.state, point)) for point in (shape.start, shape.end))
            _edge(m, start, end, m.view(numbers(m.now.state, shape.normal)))
        elif look in ROUND and m.view.planar:
            (_tin if _seen_along(m, shape) else _wall_round)(m, shape)
        elif look == "profile" and m.view.planar and not m.view(np.eye(3)[2]).any():
            _profile(m, shape)
        elif look == "spot" and m.view.planar:  # an edge of the ground, seen along it
            at = m.page(numbers(m.now.state, shape.components))
            if shape in names:
                m.labels.append((f"${latex_name(names[shape])}$", [(at, None)], 9.5, GREY))
            if m.model.scenery is None:
                m.add(symbols.pin_on_ground(at, m.down), class_="plane")


def feet(m: MachineDrawing) -> None:
    """Draw the points at which bodies touch."""
    if not m.model.contacts:
        return
    size = m.wide / m.scale
    for contact, touch in definite_touches(m.model, m.now.state):
        if abs(float(touch.gap)) < NEAR * size and all(float(x) >= -NEAR * size for x in touch.reach):
            at = m.page(np.array([float(x) for x in touch.on_feature]))
            m.add([Circle(at, 2.2, Style(INK, 0.8, (), INK))], class_="contact", data_contact=contact.name)


def _edge(m: MachineDrawing, start: Array, end: Array, up: Array) -> None:
    """Draw an edge of the ground, hatched on the side that ``up`` points away from."""
    along = end - start
    side = 1.0 if float(np.array([along[1], -along[0]]) @ up) < 0 else -1.0
    m.add(symbols.hatched(start, end, side), class_="plane")


def _ground(m: MachineDrawing, point: Array, normal: Array) -> None:
    """Draw a plane of the ground, under the whole machine."""
    machine = m.page(m.extent)
    if m.view.planar:
        up = m.view(normal)
        along = np.array([-up[1], up[0]]) / np.linalg.norm(up)
        foot = m.page(point)
        reach = (machine - foot) @ along
        start, end = (foot + s * along for s in (reach.min() - 20.0, reach.max() + 20.0))
        _edge(m, start, end, up)
        return
    middle = m.extent.mean(axis=0)
    middle = middle - float((middle - point) @ normal) * normal
    first = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = first - float(first @ normal) * normal
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    size = 0.6 * m.wide / m.scale
    square = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    corners = np.array([m.page(middle + size * (a * first + b * second)) for a, b in square])
    m.add([Line(corners, Style(GREY, 0.8, (), "#f4f4f4"), True)], class_="plane")


def _profile(m: MachineDrawing, shape: Any) -> None:
    """Draw what is under the machine of a line of heights."""
    x, beyond = m.extent[:, 0], 20.0 / m.scale
    at = numbers(m.now.state, shape.at)
    line = heights(m.now.state, shape, at, (float(x.min()) - beyond, float(x.max()) + beyond))
    if line[0, 0] < line[-1, 0]:
        points = np.array([m.page(point) for point in line])
        side = 1.0 if float(m.view(np.eye(3)[0])[0]) > 0 else -1.0
        m.add(symbols.hatched_along(points, side), class_="plane")


def heights(state: State, shape: Any, at: Array, reach: tuple[float, float]) -> Array:
    """Return points of a line of heights in the ground, whose origin is ``at``, over the range ``reach`` of X."""
    start, end = (x - at[0] for x in reach)
    if shape.between:
        low, high = (float(state(x)) for x in shape.between)
        start, end = min(max(start, low), high), min(max(end, low), high)
    x = np.linspace(start, end, 81)
    y = [float(state.with_values(shape.height, {shape.variable: value})) for value in x.tolist()]
    return np.asarray(at + np.column_stack([x, y, np.zeros(len(x))]))


def _seen_along(m: MachineDrawing, shape: Any) -> bool:
    """Return True for a tin whose axis lies in the plane of the drawing."""
    return (
        hasattr(shape, "length")
        and abs(float(np.linalg.norm(m.view(numbers(m.now.state, shape.axis)))) - 1) < 1e-9
    )


def _tin(m: MachineDrawing, shape: Any) -> None:
    """Draw a tin along its axis: two lines of its wall, and its ends."""
    at, axis = (m.view(numbers(m.now.state, x)) for x in (shape.at, shape.axis))
    r, half = (float(m.now.state(x)) for x in (shape.radius, shape.length / 2))
    across = np.array([-axis[1], axis[0]])
    corner = {
        (i, j): m.page(numbers(m.now.state, shape.at)) + m.scale * (i * half * axis + j * r * across)
        for i in (-1, 1)
        for j in (-1, 1)
    }
    for j in (-1, 1):
        _edge(m, corner[-1, j], corner[1, j], -j * across)
        _edge(m, corner[j, -1], corner[j, 1], -j * axis)


def _wall_round(m: MachineDrawing, shape: Any) -> None:
    """A round wall, hatched where the ground is."""
    center = m.page(numbers(m.now.state, shape.at))
    r = m.scale * float(m.now.state(shape.radius))
    items: list[Any] = [Line(arc(center, r, 0.0, 2 * math.pi), Style(INK, 1.3))]
    sign = 1.0 if shape.inside else -1.0
    for k in range(max(12, round(r * 2 * math.pi / 9.0))):
        t = 2 * math.pi * k / max(12, round(r * 2 * math.pi / 9.0))
        d = np.array([math.cos(t), math.sin(t)])
        foot = center + r * d
        items.append(Line(np.array([foot, foot + 5.0 * (sign * d + np.array([-d[1], d[0]]))]), symbols.FINE))
    m.add(items, class_="plane")
    radius = m.e.state(shape.radius)
    if not isinstance(radius, Polynomial):
        return
    areas = [area for name in m.drawn for area in m.areas_of(name)]
    choices = []
    for k in range(12):
        t = math.radians(30 * k + 10)
        d = np.array([math.cos(t), math.sin(t)])
        clear = 20.0 * sum(
            inside(area, sampled(np.array([center, center + r * d]), 4.0)).any() for area in areas
        )
        choices.append((clear + abs(d[0] - d[1]), k, d))
    d = min(choices, key=lambda choice: choice[:2])[2]
    line = np.array([center, center + r * d])
    tex = latex(radius, m.e.ring)
    m.add([Arrow(line, Style(GREY, 0.8))], class_="dimension", data_symbol=tex)
    m.labels.append((f"${tex}$", [(line.mean(axis=0), np.array([-d[1], d[0]]))], 10.5, GREY))


def guides(m: MachineDrawing) -> None:
    """Draw the ground beside the bodies that slide on it, in a planar machine."""
    if not m.view.planar:
        return
    for name, (kind, pair, parent, child, point) in m.joints.items():
        if not pair.prismatic or parent != "ground":
            continue
        d = m.axis(name)
        if d is None:
            continue
        if d[0] < -0.01:
            d = -d
        at = m.page(point)
        base = m.page(m.now.place("ground", m.model.joints[name].at)) if name in m.model.joints else at
        s = sorted((0.0, float((base - at) @ d)))
        # a guide reaches neither beyond its origin nor all the way to a distant one, but under the whole body
        ends = [m.reach(child, at, sign * d) + 14.0 for sign in (-1.0, 1.0)]
        reach = (
            min(max(s[0] - 34.0 * (s[0] == 0), -110.0), -ends[0]),
            max(min(s[1] + 34.0 * (s[1] == 0), 110.0), ends[1]),
        )
        choices = []
        for side in (1.0, -1.0) if abs(d[1]) > abs(d[0]) else (1.0,):  # bodies stand on level guides
            gap = m.reach(child, at, side * np.array([d[1], -d[0]]))
            items = symbols.guide(at, d, reach, gap, side)
            choices.append((m.placer.crowding(items[0].points), -side, items))
        m.add(min(choices, key=lambda choice: choice[:2])[2], class_=f"joint {kind}", data_joint=name)


def ropes(m: MachineDrawing) -> None:
    """Draw ropes, and the pulleys and the ceiling that they hang on."""
    for name, points in ropes_of(m.model).items():
        pages = [m.page(m.now.point(point)) for point in points]
        offsets = _strands(pages)
        total = len(pages) - 1
        # a sheave for each width of the strands that it joins
        sheaves = [
            {max(4.0, abs(x)) for x in offsets[k - 1 : k + 1]} if 0 < k < total else set()
            for k in range(total + 1)
        ]
        for k, (point, q) in enumerate(zip(points, pages, strict=True)):
            if sheaves[k] and not point.body.is_ground:  # a block hangs on the edge of its body
                toward = pages[k - 1] - q
                along = toward / max(float(np.linalg.norm(toward)), 1e-9)
                pages[k] = q + (m.reach(point.body.name, q, along) + max(sheaves[k]) + 4.0) * along
        m.add(
            [
                Line(np.array([a, b]) + offset * _across(a, b), Style(GREEN, 1.3))
                for a, b, offset in zip(pages, pages[1:], offsets, strict=False)
            ],
            class_="rope",
            data_constraint=name,
        )
        wheels: list[Any] = []
        blocks: dict[tuple[float, float], set[float]] = {}
        for k, (point, q) in enumerate(zip(points, pages, strict=True)):
            radii = sheaves[k] or ({4.0} if point.body.is_ground and k == total else set())
            blocks.setdefault((float(q[0]), float(q[1])), set()).update(radii)
            if sheaves[k] and not point.body.is_ground:
                wheels.append(Line(np.array([m.page(m.now.point(point)), q]), symbols.FINE))
        for place, radii in blocks.items():
            for r in sorted(radii, reverse=True):
                wheels += symbols.pulley(np.array(place), r)
        fixed = [q for point, q in zip(points, pages, strict=True) if point.body.is_ground]
        if fixed and m.view.planar:
            x0, x1 = min(q[0] for q in fixed) - 22.0, max(q[0] for q in fixed) + 22.0
            y = max(q[1] for q in fixed) + 12.0
            wheels += symbols.hatched(np.array([x0, y]), np.array([x1, y]), -1.0)
            wheels += [Line(np.array([q, (q[0], y)]), symbols.FINE) for q in fixed]
        m.add(wheels, class_="pulleys", data_constraint=name)
        middle = (pages[-1] + pages[-2]) / 2
        m.labels.append((f"${latex_name(name)}$", [(middle, np.array([1.0, 0.0]))], 10.0, GREEN))


def belts(m: MachineDrawing) -> None:
    """Draw belts around their pulleys."""
    for name, load in m.model.loads.items():
        if points := load.strand:
            line = np.array([m.page(m.now.point(point)) for point in points])
            m.add([Line(line, Style(GREEN, 1.3))], class_="belt", data_load=name)


def _across(a: Array, b: Array) -> Array:
    """Direction to the right of a line that goes up."""
    along = b - a if (b - a)[1] > 0 or ((b - a)[1] == 0 and (b - a)[0] > 0) else a - b
    length = float(np.linalg.norm(along))
    return np.array([along[1], -along[0]]) / length if length > 0 else np.zeros(2)


def _strands(pages: list[Array]) -> list[float]:
    """Distances of strands from the lines between their points: those between the same two are side by side."""
    ends = list(zip(pages, pages[1:], strict=False))
    result = []
    for k, (a, b) in enumerate(ends):
        same = [
            j
            for j, (c, d) in enumerate(ends)
            if (np.allclose(a, c) and np.allclose(b, d)) or (np.allclose(a, d) and np.allclose(b, c))
        ]
        result.append(7.0 * (same.index(k) - (len(same) - 1) / 2))
    return result
