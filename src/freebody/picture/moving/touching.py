"""Contacts in an animation: surfaces of the ground, contact modes over time, and the points where bodies touch."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...dynamics.state import State
from ...motion.trajectory.quantities import quaternions
from ..machine.draw_ground import heights
from ..machine.shapes import ROD, Primitive, axes_along, numbers, rod
from .keyframes import Keyframes

if TYPE_CHECKING:
    from ...motion.trajectory.trajectory import Trajectory

MOST_MODES = 2000
"""Most changes of mode that a page holds."""


def surface_parts(
    state: State, shape: Any, reach: tuple[float, float], size: float
) -> list[Primitive | dict[str, Any]]:
    """Parts of a surface of the ground that is no plane: a side, a round wall, or heights over the range ``reach``.

    Of a tin there are the edges of its ends, between which one sees what is in it.
    """
    look, thin = shape.look, 0.6 * ROD * size
    if look == "side":
        start, end = (numbers(state, p) for p in (shape.start, shape.end))
        return [rod(start, end, thin)]
    if look not in ("disk", "wall", "ball", "profile"):
        return []
    at = numbers(state, shape.at)
    if look == "profile":
        points = heights(state, shape, at, reach)
        return [rod(a, b, thin) for a, b in zip(points, points[1:], strict=False)]
    r = float(state(shape.radius))
    if look == "ball":
        return [] if shape.inside else [{"kind": "ellipsoid", "radii": [r] * 3, "at": at.tolist()}]
    axis = numbers(state, shape.axis)
    turn = quaternions(axes_along(axis)[None])[0].tolist()
    half = float(state(getattr(shape, "length", 0))) / 2
    h = 2 * thin if look == "disk" or half else 0.3 * size
    wide = r + (thin if shape.inside else -thin)
    profile = [[r, -h], [wide, -h], [wide, h], [r, h], [r, -h]]
    middles = [at - half * axis, at + half * axis] if half else [at]
    return [{"kind": "lathe", "profile": profile, "at": x.tolist(), "turn": turn} for x in middles]


def distinct(planes: list[dict[str, Any]], size: float) -> list[dict[str, Any]]:
    """The planes without repetitions: several wheels or feet may stand on one plane."""
    result: list[dict[str, Any]] = []
    for plane in planes:
        n, at = np.array(plane["normal"]), np.array(plane["at"])
        if not any(
            float(n @ np.array(other["normal"])) > 1 - 1e-9
            and abs(float((at - np.array(other["at"])) @ n)) < 1e-9 * size
            for other in result
        ):
            result.append(plane)
    return result


def modes(trajectory: Trajectory) -> list[dict[str, Any]]:
    """Modes of every contact: for each span of time the mode, start, end and reason."""
    spans_of: dict[str, list[list[Any]]] = {}
    for change in list(getattr(trajectory, "modes", ()))[:MOST_MODES]:
        end = trajectory.path.end if change.end is None else change.end
        spans_of.setdefault(change.contact, []).append([change.mode, change.start, end, str(change)])
    return [{"contact": name, "spans": spans} for name, spans in spans_of.items()]


def touching(keys: Keyframes) -> list[dict[str, Any]]:
    """Path of each contact, and 1 or 0 at every moment for closed or open."""
    touched = keys.touched
    if touched is None:
        return []
    return [
        {
            "name": name,
            "path": touched.place[:, k],
            "closed": (np.abs(touched.forces[k]).max(axis=1) > 0).astype(np.uint8),
        }
        for k, name in enumerate(touched.names)
    ]
