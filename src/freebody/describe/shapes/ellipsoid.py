"""Ellipsoids."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...errors import ModelError, shown
from ...scalar.algebra import IDENTITY, Vector, add, cross, divide, dot, scale
from ...scalar.algebra import apply as turned
from ...scalar.expression import exact
from ..frame import Frame, place_in
from .data import length
from .shape import ContactShape


class Ellipsoid(ContactShape, kind="ellipsoid"):
    """The surface of an ellipsoid, its axes along those of the body."""

    at: Vector
    half_axes: Vector

    door = True
    words = {"half_axes": "vector", "at": "vector"}
    required = ("half_axes",)
    look, bound = "oval", "oval"

    def support(self, at: Any, direction: Vector) -> Vector:
        """Return C + D d/sqrt(d·D d)  with D = R diag(a², b², c²) Rᵀ of the half axes."""
        within = at.within(self.body, direction)
        squares = tuple(at(half) * at(half) for half in self.half_axes)
        support = tuple(square * x for square, x in zip(squares, within, strict=True))
        width = at.field.sqrt(dot(within, support))
        return add(at.place(self.body, self.at), scale(divide(1, width), at.outward(self.body, support)))

    def lies_across(self, R: Any, k: Vector) -> bool:
        """Return True if an axis is parallel to k."""
        axes: Sequence[Vector] = [cross(turned(R, axis), k) for axis in IDENTITY]
        return any(all(exact(x) == 0 for x in v) for v in axes)

    @property
    def depth(self) -> Vector:
        """The centre."""
        return self.at

    @classmethod
    def made(cls, body: Any, **data: Any) -> ContactShape:
        """Return the ellipsoid of a body from the data of a file."""
        return ellipsoid(body, **data)


def ellipsoid(body: Frame, half_axes: Any, *, at: Any = None) -> Ellipsoid:
    """Return an ellipsoid along the axes of the body, for contacts with planes: a wobblestone, an egg.

    Parameters
    ----------
    half_axes : three expressions of parameters [m]
        Along x, y and z.
    at : Point of the body or three components, optional
        Its centre; by default the body's origin.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("egg")
    >>> egg = s.body("egg", fb.sphere(0.06, 0.02))
    >>> air = s.free("air", s.ground, egg)
    >>> table = s.contact("table", egg.ellipsoid((0.02, 0.02, 0.03)), s.ground.plane(normal="z"), friction=0.3)
    """
    what = f"the ellipsoid of {body!r}"
    if isinstance(half_axes, str) or not isinstance(half_axes, Sequence) or len(half_axes) != 3:
        raise ModelError(f"Expected three half axes (a, b, c) for {what}, got {shown(half_axes)}.")
    a, b, c = (length(body, axis, what) for axis in half_axes)
    return Ellipsoid(body, place_in(body, at, what), (a, b, c))
