"""Standard symbols of mechanics: hinges, bearings, guides, ground, springs, dampers, gear wheels, pulleys.

Each function returns the lines and circles of one symbol; points and lengths are in points of the sheet.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .palette import GREY, INK
from .sheet import Circle, Line, Style, arc

Array = NDArray[np.float64]

THIN, FINE = Style(INK, 1.1), Style(INK, 0.7)


def hatched(start: Array, end: Array, side: float = 1.0) -> list[Any]:
    """Edge of the ground from start to end, hatched on its right (on its left for side -1)."""
    return hatched_along(np.array([start, end]), side)


def hatched_along(line: Array, side: float = 1.0) -> list[Any]:
    """Edge of the ground along a line of points, hatched on its right (on its left for side -1)."""
    d = np.diff(line, axis=0)
    lengths = np.linalg.norm(d, axis=1)
    d /= lengths[:, None]
    ends = np.cumsum(lengths)
    result: list[Any] = [Line(line, Style(INK, 1.3))]
    count = max(3, round(ends[-1] / 6.0))
    for k in range(count):
        at = (k + 0.6) * ends[-1] / count
        i = int(np.searchsorted(ends, at))
        foot = line[i + 1] + (at - ends[i]) * d[i]
        normal = side * np.array([d[i, 1], -d[i, 0]])
        result.append(Line(np.array([foot, foot + 5.0 * (normal - d[i])]), FINE))
    return result


def pin_on_ground(at: Array, down: Array) -> list[Any]:
    """A hinge on the ground: a bracket that stands on hatched ground, in the direction ``down`` from the hinge."""
    across = np.array([-down[1], down[0]])
    foot = at + 15.0 * down
    bracket = np.array([foot + 9.0 * across, at + 3.4 * across, at - 3.4 * across, foot - 9.0 * across])
    hatch = hatched(foot + 14.0 * across, foot - 14.0 * across, -_turn(across, down))
    return [Line(bracket, Style(INK, 1.1, (), "#ffffff"), True), *hatch]


def bearing(at: Array, along: Array, down: Array) -> list[Any]:
    """Bearing of a shaft: a stroke on each side of the axis, hatched ground behind one of them."""
    normal = np.array([-along[1], along[0]])
    normal = normal if float(normal @ down) >= 0 else -normal
    low, high = at + 4.0 * normal, at - 4.0 * normal
    ends = [(middle - 8.0 * along, middle + 8.0 * along) for middle in (low, high)]
    side = 1.0 if along[0] * normal[1] - along[1] * normal[0] < 0 else -1.0
    return [*hatched(*ends[0], side), Line(np.array(ends[1]), Style(INK, 1.3))]


def pin(at: Array) -> list[Any]:
    """A hinge."""
    return [Circle(at, 3.2, Style(INK, 1.1, (), "#ffffff"))]


def ball_on_ground(at: Array, down: Array) -> list[Any]:
    """A ball joint (or a pivot) on the ground."""
    return [*pin_on_ground(at, down), Circle(at, 4.0, Style(INK, 1.1, (), INK))]


def mass_centre(at: Array) -> list[Any]:
    """The mass centre of a body that nothing holds: a circle with two of its quarters filled."""
    quarters = [
        Line(np.vstack([at, arc(at, 4.0, start, start + math.pi / 2)]), Style(None, fill=INK), True)
        for start in (0.0, math.pi)
    ]
    return [Circle(at, 4.0, Style(INK, 1.0, (), "#ffffff")), *quarters]


def section(corners: Array) -> list[Any]:
    """A solid fixed in the ground, cut by the page: a convex polygon, hatched all over at 45 degrees."""
    items: list[Any] = [Line(corners, Style(INK, 1.2, (), "#f2f2f2"), True)]
    # lines x - y = c, each clipped to the polygon
    along, across = np.array([1.0, 1.0]) / math.sqrt(2), np.array([1.0, -1.0]) / math.sqrt(2)
    depth = corners @ across
    for c in np.arange(float(depth.min()) + 3.5, float(depth.max()), 7.0):
        meets = []
        for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            u, v = float(a @ across) - c, float(b @ across) - c
            if (u > 0) != (v > 0):
                meets.append(float((a + (b - a) * u / (u - v)) @ along))
        if len(meets) >= 2:
            items.append(Line(np.array([c * across + s * along for s in (min(meets), max(meets))]), FINE))
    return items


def guide(at: Array, along: Array, reach: tuple[float, float], gap: float, side: float) -> list[Any]:
    """The hatched edge on which a block slides, at a distance ``gap`` from its middle."""
    normal = side * np.array([along[1], -along[0]])
    start, end = (at + s * along + gap * normal for s in reach)
    return hatched(start, end, side)


def zigzag(start: Array, end: Array, width: float = 5.5) -> list[Any]:
    """A spring."""
    d = end - start
    length = float(np.linalg.norm(d))
    if length < 4.0:
        return [Line(np.array([start, end]), THIN)]
    d = d / length
    normal = np.array([-d[1], d[0]])
    straight = min(8.0, 0.16 * length)
    turns = max(4, min(9, round((length - 2 * straight) / 9.0)))
    points = [start, start + straight * d]
    step = (length - 2 * straight) / (2 * turns)
    for k in range(2 * turns):
        offset = width if k % 2 == 0 else -width
        points.append(start + (straight + (k + 0.5) * step) * d + offset * normal)
    return [Line(np.array([*points, end - straight * d, end]), THIN)]


def dashpot(start: Array, end: Array) -> list[Any]:
    """A damper: a piston in a pot that is open toward the end."""
    d = end - start
    length = float(np.linalg.norm(d))
    if length < 4.0:
        return [Line(np.array([start, end]), THIN)]
    d = d / length
    n = np.array([-d[1], d[0]])
    middle = start + 0.5 * length * d
    a, b = middle - 7.0 * d, middle + 9.0 * d
    pot = np.array([b + 6.0 * n, a + 6.0 * n, a - 6.0 * n, b - 6.0 * n])
    head = middle + 1.0 * d
    return [
        Line(pot, THIN),
        Line(np.array([start, a]), THIN),
        Line(np.array([head + 4.6 * n, head - 4.6 * n]), Style(INK, 2.0)),
        Line(np.array([head, end]), THIN),
    ]


def spiral(at: Array, basis: Array, radius: float = 13.0) -> list[Any]:
    """A torsion spring about an axis; ``basis`` holds two directions across it, as rows, on paper."""
    t = np.linspace(0.0, 2.6 * 2 * math.pi, 90)
    r = 4.0 + (radius - 4.0) * t / t[-1]
    return [Line(at + np.column_stack([r * np.cos(t), r * np.sin(t)]) @ basis, FINE)]


def turning_dashpot(at: Array, basis: Array, radius: float = 15.0) -> list[Any]:
    """A damper of a turn: a piston in a pot bent about an axis, each on an arm; ``basis`` as of `spiral`."""
    wide, long, centre, hub = 4.5, math.radians(34), np.zeros(2), 3.0 / radius
    inner, outer = (arc(centre, radius + side * wide, long, -long) for side in (-1, 1))
    rod = arc(centre, radius, 0.0, math.radians(80))
    head = np.array([[radius - wide + 1.2, 0.0], [radius + wide - 1.2, 0.0]])
    arm = arc(centre, radius, -long, -math.radians(80))
    lines = [
        Line(np.vstack([outer, inner[::-1]]), FINE),
        Line(head, Style(INK, 1.8)),
        Line(np.vstack([rod, rod[-1:] * hub]), FINE),
        Line(np.vstack([arm, arm[-1:] * hub]), FINE),
    ]
    return [Line(at + line.points @ basis, line.style) for line in lines]


def teeth(center: Array, radius: float, count: int, phase: float, fill: str) -> list[Any]:
    """A gear wheel: its teeth, with one at the angle ``phase`` [rad], and its pitch circle."""
    depth = min(4.0, 0.24 * 2 * math.pi * radius / count)
    points = []
    for k in range(count):
        for share, r in ((-0.32, -depth), (-0.17, depth), (0.17, depth), (0.32, -depth)):
            angle = phase + 2 * math.pi * (k + share) / count
            points.append(center + (radius + r) * np.array([math.cos(angle), math.sin(angle)]))
    pitch = arc(center, radius, 0.0, 2 * math.pi)
    return [
        Line(np.array(points), Style(INK, 1.0, (), fill), True),
        Line(pitch, Style(GREY, 0.8, (8.0, 2.0, 1.5, 2.0))),
    ]


def rack(point: Array, along: Array, out: Array, pitch: float, length: float, shifted: bool) -> list[Any]:
    """The teeth of a rack about its pitch point, with one there or, ``shifted``, a gap; and its pitch line."""
    depth = min(4.0, 0.24 * pitch)
    count = max(2, round(length / pitch))
    first = -count + (0.5 if shifted else 0.0)
    points = [
        point + (first + k + share) * pitch * along + r * out
        for k in range(2 * count + 1)
        for share, r in ((-0.32, -depth), (-0.17, depth), (0.17, depth), (0.32, -depth))
    ]
    ends = [point + sign * length * along for sign in (-1, 1)]
    return [
        Line(np.array(points), Style(INK, 1.0)),
        Line(np.array(ends), Style(GREY, 0.8, (8.0, 2.0, 1.5, 2.0))),
    ]


def pulley(at: Array, radius: float) -> list[Any]:
    """A pulley."""
    return [Circle(at, radius, Style(INK, 1.1, (), "#ffffff")), Circle(at, 1.6, Style(INK, 0.8, (), INK))]


def _turn(a: Array, b: Array) -> float:
    return 1.0 if a[0] * b[1] - a[1] * b[0] > 0 else -1.0
