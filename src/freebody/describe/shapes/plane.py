"""Planes without end."""

from __future__ import annotations

from typing import Any

import sympy

from ...scalar.algebra import Vector, apply, cross, dot, negate, scale, subtract
from ...scalar.expression import exact
from ..axes import UNIT
from ..frame import Frame, place_in
from .data import unit_vector
from .shape import ContactShape, Law, Nearest


class Plane(ContactShape, kind="plane"):
    """An infinite plane; ``normal`` points out of the body, and (first, second, normal) is right-handed."""

    at: Vector
    normal: Vector
    first: Vector
    second: Vector

    door = True
    words = {"at": "vector", "normal": "direction"}
    look, endless, precedence = "plane", True, 2

    def tangents(self, at: Any, normal: Vector, turned: bool) -> tuple[Vector, Vector]:
        """Return the axes of the plane."""
        first, second = (at.turned(self.body, e) for e in (self.first, self.second))
        return (second, first) if turned else (first, second)

    def lies_across(self, R: Any, k: Vector) -> bool:
        """Return True if the normal is at right angles to k."""
        return bool(exact(dot(apply(R, self.normal), k)) == 0)

    @classmethod
    def law_with(cls, feature: type[ContactShape]) -> Law | None:
        """Return the law of shapes with a support point."""
        return on_plane if feature.has_support() else None

    @classmethod
    def made(cls, body: Any, **data: Any) -> ContactShape:
        """Return the plane of a body from the data of a file."""
        return plane(body, **data)


def on_plane(at: Any, feature: Any, flat: Any) -> Nearest:
    """Return the nearest points of a shape and a plane of normal n: the support point P along -n, and Q = P - g n."""
    n = at.turned(flat.body, flat.normal)
    P = feature.support(at, negate(n))
    gap = dot(n, subtract(P, at.place(flat.body, flat.at)))
    return Nearest(P, subtract(P, scale(gap, n)), n, gap, feature.reaches(at, n))


def plane(body: Frame, *, at: Any = None, normal: Any = "y") -> Plane:
    """Return an infinite plane fixed in the body: a floor, a wall, a table.

    Parameters
    ----------
    at : Point of the body or three components, optional
        A point of the plane; by default the body's origin.
    normal : "y", "-x", … or three components
        Direction out of the body, to the side of the bodies that touch it.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("slope")
    >>> beta = s.parameters(beta="30deg")
    >>> s.ground.plane(normal=("sin(beta)", "cos(beta)", 0)).normal
    (sin(beta), cos(beta), 0)
    """
    what = f"the plane of {body!r}"
    n = unit_vector(body, normal, f"the normal of {what}")
    first, second = across(n)
    return Plane(body, place_in(body, at, what), n, first, second)


def across(n: Vector) -> tuple[Vector, Vector]:
    """Return two unit vectors that complete a right-handed set with ``n``; coordinate axes if possible."""
    units = list(UNIT.values())
    for k in range(3):
        if n[k] in (1, -1):
            i, j = (k + 1) % 3, (k + 2) % 3
            return (units[i], units[j]) if n[k] == 1 else (units[j], units[i])
    level = [k for k in range(3) if n[k] == 0]
    if level:
        e = units[level[-1]]
    else:
        square = 1 - sympy.sympify(n[2]) ** 2
        e = tuple(sympy.sympify(c) / sympy.sqrt(square) for c in cross(n, UNIT["z"]))
    second = cross(n, e)
    x, y, z = (exact(c) for c in second)
    a, b, c = (exact(c) for c in e)
    return (a, b, c), (x, y, z)
