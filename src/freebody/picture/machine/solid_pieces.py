"""Pieces of bodies in one configuration: solids, sides that other bodies touch, rods that other bodies slide along.

Sides and rods are drawn only if no solid shows them. A plane has no end: it is drawn as far as the contact, and to
where the other planes of the body begin.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...dynamics.conditions.contact import definite_touches
from .configuration import Configuration
from .shapes import ROD, Primitive, holds, machine_size, numbers, rod, shapes

Array = NDArray[np.float64]

BEYOND = 0.15
"""Length of a plane that is drawn beyond the contact, relative to the size of the machine."""


def pieces_of(now: Configuration, planar: bool) -> dict[str, tuple[Primitive, ...]]:
    """Pieces of every body by name, in body axes."""
    pieces = shapes(now.model, now.values)
    size = machine_size(now.model, now.values)
    sides: dict[str, list[tuple[Any, Array]]] = {}
    for contact, touch in definite_touches(now.model, now.state):
        for shape, place in ((contact.feature, touch.on_feature), (contact.surface, touch.on_surface)):
            name = shape.body.name
            if shape.look not in ("plane", "side") or shape.body.is_ground:
                continue
            R, p = now.posture(name)
            foot = R.T @ (np.array([float(x) for x in place]) - p)
            if not any(
                piece.kind != "particle" and holds(piece, foot, 0.02 * size) for piece in pieces[name]
            ):
                sides.setdefault(name, []).append((shape, foot))
    for joint in now.model.joints.values():
        if not joint.pair.prismatic or joint.parent == "ground":
            continue
        R, p = now.posture(joint.parent)
        start, end = numbers(now.state, joint.at), R.T @ (now.place(joint.child, joint.to) - p)
        far = float(np.linalg.norm(end - start)) > 0.02 * size
        if far and not any(holds(piece, end, 0.02 * size) for piece in pieces[joint.parent]):
            pieces[joint.parent] += (rod(start, end, ROD * size),)
    for name, touched in sides.items():
        starts = [numbers(now.state, shape.at) for shape, _ in touched if shape.look == "plane"]
        pieces[name] += tuple(_side(now, shape, foot, starts, size, planar) for shape, foot in touched)
    return pieces


def _side(
    now: Configuration, shape: Any, foot: Array, starts: list[Array], size: float, planar: bool
) -> Primitive:
    if shape.look == "side":
        return rod(numbers(now.state, shape.start), numbers(now.state, shape.end), ROD * size)
    at, normal = numbers(now.state, shape.at), numbers(now.state, shape.normal)
    first, second = numbers(now.state, shape.first), numbers(now.state, shape.second)
    if not planar:
        edge = 2 * (float(np.abs([(foot - at) @ first, (foot - at) @ second]).max()) + BEYOND * size)
        axes = np.column_stack([first, second, normal])
        return Primitive("plate", {"a": edge, "b": edge}, at, axes, solid=False)
    along = first if abs(first[2]) < abs(second[2]) else second
    ends = [
        float((start - at) @ along) for start in starts if abs(float((start - at) @ normal)) < 1e-9 * size
    ]
    reach = float((foot - at) @ along)
    # beyond the contact, but not beyond the line where planes meet
    low = reach - BEYOND * size if reach <= min(ends) else min(ends)
    high = reach + BEYOND * size if reach >= max(ends) else max(ends)
    return rod(at + low * along, at + high * along, ROD * size)
