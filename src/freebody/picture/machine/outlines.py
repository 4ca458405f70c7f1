"""Outlines of bodies on paper, as a draughtsman draws bars, disks, boxes and other pieces."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...dynamics.kinematics import link_postures
from ..paper.palette import INK
from ..paper.sheet import Circle, Line, Style
from ..paper.view import View
from .configuration import Configuration
from .shapes import Primitive, numbers

Array = NDArray[np.float64]

BAR, ROD, THIN = 8.0, 4.5, 5.0
"""Widths on paper of slender bars, of rods, and of thin pieces seen edge-on [pt]."""

PARTICLE, NOTHING = 9.0, 4.0
"""Radius on paper of a particle, and of a body without mass and size [pt]."""

_LINE = 1.1


def outlines(
    piece: Primitive, R: Array, p: Array, view: View, scale: float, fill: str, guide: Array | None = None
) -> list[Any]:
    """Lines and circles of one piece of a body with the posture ``R, p``, on paper [pt].

    With ``guide``, its direction on paper, a particle of a planar machine is drawn as a block that slides on it.
    """
    style = Style(INK, _LINE, (), "#ffffff" if piece.hole else fill)
    A = R @ piece.axes
    c = p + R @ piece.center

    def page(local: Any) -> Array:
        return scale * view(c + np.asarray(local, dtype=float) @ A.T)

    middle = page((0.0, 0.0, 0.0))
    d = piece.dimensions
    kind = piece.kind
    if kind == "particle":
        if guide is not None and view.planar:
            w, h = 17.0, 11.0
            # its long edge along the guide or across it, whichever is more level
            level = guide if abs(guide[0]) >= abs(guide[1]) else np.array([guide[1], -guide[0]])
            corners = np.array([(-w, -h), (w, -h), (w, h), (-w, h)]) @ np.array(
                [level, (-level[1], level[0])]
            )
            return [Line(middle + corners, style, True)]
        return [Circle(middle, PARTICLE if piece.solid else NOTHING, style)]
    if kind in ("slender_bar", "rod"):
        half = d["length"] / 2
        width = BAR if kind == "slender_bar" else ROD
        return [Line(_capsule(page((0, 0, -half)), page((0, 0, half)), width), style, True)]
    if kind in ("sphere", "spherical_shell"):
        return [Circle(middle, scale * d["radius"], style)]
    if kind in ("disk", "ring"):
        return _round(page, d["radius"], view, A, style, kind == "ring")
    if kind == "plate":
        a, b = d["a"] / 2, d["b"] / 2
        return _face(page([(-a, -b, 0), (a, -b, 0), (a, b, 0), (-a, b, 0)]), style)
    if kind == "box":
        return _box(page, piece, view, A, style)
    if kind == "ellipsoid":
        return _ellipsoid(page, d, view, A, scale, style)
    if kind in ("cylinder", "tube"):
        r, half = d["outer" if kind == "tube" else "radius"], d["length"] / 2
        ends = [page(_circle(r, z)) for z in (-half, half)]
        near = ends[1] if A[:, 2] @ view.toward >= 0 else ends[0]
        result = [Line(hull(np.vstack(ends)), style, True), Line(near, style, True)]
        if kind == "tube" and d["inner"] > 0:
            z = half if A[:, 2] @ view.toward >= 0 else -half
            result.append(Line(page(_circle(d["inner"], z)), Style(INK, _LINE, (), "#ffffff"), True))
        return result
    if kind == "cone":
        base = page(_circle(d["radius"], -d["height"] / 4))
        apex = page((0, 0, 3 * d["height"] / 4))
        result = [Line(hull(np.vstack([base, apex])), style, True)]
        return [*result, Line(base, style, True)] if A[:, 2] @ view.toward < 0 else result
    if kind == "torus":
        return _torus(page, d, style)
    if kind == "revolved":
        rows = d["profile"]
        circles = [page(_circle(r, z)) for z, r, _ in rows]
        end = circles[-1] if A[:, 2] @ view.toward >= 0 else circles[0]
        return [Line(hull(np.vstack(circles)), style, True), Line(end, style, True)]
    corners = page(d["vertices"])
    return [Line(hull(corners), style, True)]


def polygon(item: Any) -> Array | None:
    """Polygon that an outline covers, for placing arrows and labels; None for an open line."""
    if isinstance(item, Circle):
        return item.center + item.radius * np.array([(math.cos(t), math.sin(t)) for t in _turns(32)])
    return item.points if item.closed else None


def hull(points: Array) -> Array:
    """Convex hull of points on paper, counter-clockwise."""
    order = np.unique(np.round(points, 6), axis=0).tolist()
    if len(order) < 3:
        return np.array(order)

    def half(run: Any) -> list[tuple[float, float]]:
        chain: list[tuple[float, float]] = []
        for x, y in run:
            while len(chain) > 1:
                (ax, ay), (bx, by) = chain[-2], chain[-1]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 1e-9:
                    break
                chain.pop()
            chain.append((x, y))
        return chain

    return np.array(half(order)[:-1] + half(reversed(order))[:-1])


def _turns(n: int = 60) -> Array:
    """``n`` angles, evenly over a full turn [rad]."""
    return np.linspace(0.0, 2 * math.pi, n, endpoint=False)


def _circle(r: float, z: float) -> Array:
    t = _turns()
    return np.column_stack([r * np.cos(t), r * np.sin(t), np.full_like(t, z)])


def _ellipsoid(page: Any, d: Any, view: View, A: Array, scale: float, style: Style) -> list[Any]:
    M = scale * view.matrix @ A * np.array([d["a"], d["b"], d["c"]])
    lines = [Line(_ellipse(page((0.0, 0.0, 0.0)), M), style, True)]
    near = np.array([_depth(A, view, d, t) >= 0 for t in _turns()])
    if near.sum() < 2 or view.planar:
        return lines
    equator = page([(d["a"] * math.cos(t), d["b"] * math.sin(t), 0.0) for t in _turns()])
    return [*lines, Line(_unbroken(equator, near), Style(INK, 0.7))]


def _ellipse(middle: Array, M: Array) -> Array:
    """Silhouette of the image of the unit sphere under a 2 x 3 matrix."""
    w, V = np.linalg.eigh(M @ M.T)
    t = _turns(72)
    return middle + np.column_stack([np.cos(t), np.sin(t)]) * np.sqrt(np.maximum(w, 0.0)) @ V.T


def _depth(A: Array, view: View, d: Any, t: float) -> float:
    """Component toward the reader of the normal at a point of an ellipsoid's equator."""
    normal = A @ np.array([math.cos(t) / d["a"], math.sin(t) / d["b"], 0.0])
    return float(normal @ view.toward)


def _unbroken(curve: Array, near: Array) -> Array:
    """The points of a closed curve that are ``near``, in one piece."""
    if near.all():
        return np.vstack([curve, curve[:1]])
    start = next(i for i in range(len(near)) if near[i] and not near[i - 1])
    order = [(start + k) % len(near) for k in range(int(near.sum()))]
    return curve[order]


def _capsule(a: Array, b: Array, width: float) -> Array:
    """A bar with round ends, which reach half its width beyond its points."""
    d = b - a
    length = float(np.linalg.norm(d))
    angle = math.atan2(d[1], d[0]) if length > 0 else 0.0
    r = width / 2
    t = np.linspace(-math.pi / 2, math.pi / 2, 13)
    far = b + r * np.column_stack([np.cos(angle + t), np.sin(angle + t)])
    near = a - r * np.column_stack([np.cos(angle + t), np.sin(angle + t)])
    return np.vstack([far, near])


def _round(page: Any, r: float, view: View, A: Array, style: Style, hollow: bool) -> list[Any]:
    rim = page(_circle(r, 0.0))
    center = page((0.0, 0.0, 0.0))
    facing = abs(float(A[:, 2] @ view.toward))
    if facing < 0.05:
        return [_edge_on(rim, center, style)]
    if hollow:
        return [
            Line(rim, Style(INK, 6.5), True),
            Line(rim, Style(style.fill, 4.5), True),
        ]
    return [Line(rim, style, True)]


def _face(corners: Array, style: Style) -> list[Any]:
    area = 0.5 * abs(
        float(
            np.dot(corners[:, 0], np.roll(corners[:, 1], 1))
            - np.dot(corners[:, 1], np.roll(corners[:, 0], 1))
        )
    )
    if area < 1.0:
        return [_edge_on(corners, corners.mean(axis=0), style)]
    return [Line(corners, style, True)]


def _edge_on(points: Array, center: Array, style: Style) -> Line:
    """A thin piece seen edge-on: a bar as long as its points are spread about the centre."""
    spread = points - center
    far = spread[int(np.argmax(np.linalg.norm(spread, axis=1)))]
    return Line(_capsule(center - far, center + far, THIN), style, True)


def _box(page: Any, piece: Primitive, view: View, A: Array, style: Style) -> list[Any]:
    half = np.array(piece.half())
    result = []
    for k in range(3):
        for side in (-1.0, 1.0):
            if side * float(A[:, k] @ view.toward) <= 1e-9:
                continue
            i, j = (k + 1) % 3, (k + 2) % 3
            corners = []
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                corner = np.zeros(3)
                corner[[k, i, j]] = side * half[k], a * half[i], b * half[j]
                corners.append(corner)
            result += _face(page(corners), style)
    return result


def _torus(page: Any, d: Any, style: Style) -> list[Any]:
    R, r = d["major"], d["minor"]
    points = [
        ((R + r * math.cos(v)) * math.cos(u), (R + r * math.cos(v)) * math.sin(u), r * math.sin(v))
        for u in _turns()
        for v in _turns(16)
    ]
    inner = page(_circle(max(R - r, 0.0), 0.0))
    return [Line(hull(page(points)), style, True), Line(inner, Style(INK, _LINE, (), "#ffffff"), True)]


def axis_in_space(now: Configuration, number: int) -> Array:
    """Axis of a link, by its number, in ground axes."""
    R = np.array(link_postures(now.model, now.state)[number].rotation, dtype=float)
    return R @ numbers(now.state, now.model.links[number].axis)


def axis_on_paper(now: Configuration, view: View, number: int) -> Array | None:
    """Direction on paper of the axis of a link; None if it points at the reader."""
    d = view(axis_in_space(now, number))
    length = float(np.linalg.norm(d))
    return d / length if length > 0.05 else None


def guide_of(now: Configuration, view: View, body: str) -> Array | None:
    """Direction on paper of the guide on which a body slides; None if it slides on none, or toward the reader."""
    for joint in now.model.joints.values():
        if joint.child == body and joint.pair.prismatic:
            return axis_on_paper(now, view, joint.links[0])
    return None
