"""Shapes that the gallery's bodies are drawn with, where the solids of their mass do not show what they are."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import sympy

import freebody as fb


def tube_between(start: Sequence[Any], end: Sequence[Any], radius: Any) -> fb.MassProperties:
    """Return a round tube from one point to another."""
    way = [sympy.sympify(b) - sympy.sympify(a) for a, b in zip(start, end, strict=True)]
    middle = tuple((sympy.sympify(a) + sympy.sympify(b)) / 2 for a, b in zip(start, end, strict=True))
    return fb.cylinder(1, radius, sympy.sqrt(sum(x**2 for x in way)), axis=tuple(way)).moved(middle)


def wheel(radius: Any, center: Sequence[Any], axis: str = "z") -> fb.MassProperties:
    """Return a wheel, a disk with a hub, at right angles to its axis."""
    return fb.disk(1, radius, axis=axis).moved(tuple(center))


def with_shaft(rotor: fb.MassProperties, length: Any) -> fb.MassProperties:
    """Return a rotor on a thin shaft along z, in two halves: the nearer one is drawn over the rotor."""
    half = fb.cylinder(1, length / 60, length / 2)
    return rotor + half.moved((0, 0, length / 4)) + half.moved((0, 0, -length / 4))


def box_between(low: Sequence[Any], high: Sequence[Any]) -> fb.MassProperties:
    """Return a box from one corner to the opposite one, 1 deep if both lie in the plane."""
    sizes = [sympy.sympify(b) - sympy.sympify(a) for a, b in zip(low, high, strict=True)]
    middle = tuple((sympy.sympify(a) + sympy.sympify(b)) / 2 for a, b in zip(low, high, strict=True))
    return fb.box(1, [x if x != 0 else Fraction(1) for x in sizes]).moved(middle)
