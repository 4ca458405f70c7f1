"""Shapes that the gallery's bodies are drawn with, where the solids of their mass do not show what they are.

They are shapes without mass, so that no moments of inertia are computed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy

import freebody as fb

from ...space.shape import Shape

Corner = Sequence[Any]


def placed(solid: fb.MassProperties, center: Corner = (0, 0, 0)) -> Shape:
    """Return the shape of a solid, displaced."""
    assert solid.shape is not None
    x, y, z = _exact(center)
    return solid.shape.moved((x, y, z))


def _exact(corner: Corner) -> list[Any]:
    """Return components with decimals as the fractions that they print as."""
    return [sympy.nsimplify(x, rational=True) for x in corner]


def together(*shapes: Shape) -> Shape:
    """Return shapes as one."""
    return Shape("compound", parts=tuple(part for shape in shapes for part in shape.parts or (shape,)))


def tube_between(start: Corner, end: Corner, radius: Any) -> Shape:
    """Return a round tube from one point to another."""
    first, last = _exact(start), _exact(end)
    way = [b - a for a, b in zip(first, last, strict=True)]
    middle = [(a + b) / 2 for a, b in zip(first, last, strict=True)]
    return placed(fb.cylinder(1, radius, sympy.sqrt(sum(x**2 for x in way)), axis=tuple(way)), middle)


def wheel(radius: Any, center: Corner, axis: str = "z") -> Shape:
    """Return a wheel at right angles to its axis."""
    return placed(fb.disk(1, radius, axis=axis), center)


def rim(radius: Any, width: Any, center: Corner, axis: str) -> Shape:
    """Return a wheel with a tyre of this half width, without spokes."""
    return placed(fb.torus(1, radius - width, width, axis=axis), center)


def with_shaft(rotor: fb.MassProperties, length: Any) -> Shape:
    """Return a rotor on a thin shaft along z, in two halves: the nearer one is drawn over the rotor."""
    half = fb.cylinder(1, length / 80, length / 2)
    halves = [placed(half, (0, 0, sign * length / 4)) for sign in (1, -1)]
    return together(placed(rotor), *halves)


def box_between(low: Corner, high: Corner) -> Shape:
    """Return a box from one corner to the opposite one, 1 deep if both lie in the plane."""
    sizes = [sympy.sympify(b) - sympy.sympify(a) for a, b in zip(low, high, strict=True)]
    middle = [(sympy.sympify(a) + sympy.sympify(b)) / 2 for a, b in zip(low, high, strict=True)]
    return placed(fb.box(1, [x if x != 0 else sympy.Integer(1) for x in sizes]), middle)
