"""Round shapes on each other and on flat ones: the geometry by centre, radius and axis."""

from __future__ import annotations

from typing import Any

from ...scalar.algebra import add, divide, dot, scale, subtract
from .shape import Nearest


def between_round(at: Any, a: Any, b: Any) -> Nearest:
    """Return the nearest points of points, spheres and walls of cylinders.

    With d from the centre of b to the centre of a, at right angles to the axis,

    outside  n = d/|d|,   g = |d| - r_a - r_b;        inside  n = -d/|d|,   g = r_b - r_a - |d|.
    """
    A, B = a.middle(at), b.middle(at)
    d = subtract(A, B)
    # the centre of a cylinder moves along its axis to the depth of the other shape
    axis = b.axle(at)
    if axis is not None:
        along = scale(dot(axis, d), axis)
        B, d = add(B, along), subtract(d, along)
    else:
        axis = a.axle(at)
        if axis is not None:
            along = scale(dot(axis, d), axis)
            A, d = subtract(A, along), subtract(d, along)
    distance = at.field.sqrt(dot(d, d))
    r_a, r_b = a.size(at), b.size(at)
    if b.inside:
        n = scale(divide(-1, distance), d)
        return Nearest(subtract(A, scale(r_a, n)), subtract(B, scale(r_b, n)), n, r_b - r_a - distance)
    n = scale(divide(1, distance), d)
    return Nearest(subtract(A, scale(r_a, n)), add(B, scale(r_b, n)), n, distance - r_a - r_b)
