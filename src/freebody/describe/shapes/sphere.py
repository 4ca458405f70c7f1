"""Spheres and bowls, and the space that a rope leaves."""

from __future__ import annotations

from typing import Any

from ...scalar.algebra import Expression, Scalar, Vector, add, scale
from ..frame import Frame, place_in
from .data import flag, length
from .round import between_round
from .shape import ContactShape, Law, expressions


class Ball(ContactShape, kind="sphere"):
    """The surface of a sphere; ``inside`` if the body is around it, a bowl."""

    at: Vector
    radius: Scalar
    inside: bool = False

    door = True
    words = expressions("radius", "at", "inside")
    required = ("radius",)
    look, bound, hollow, round = "ball", "ball", "bowl", True

    def support(self, at: Any, direction: Vector) -> Vector:
        """Return C + r d."""
        return add(self.middle(at), scale(at(self.radius), direction))

    def middle(self, at: Any) -> Vector:
        """Return the centre, in ground axes."""
        return at.place(self.body, self.at)

    def size(self, at: Any) -> Scalar:
        """Return the radius."""
        return at(self.radius)

    def lies_across(self, R: Any, k: Vector) -> bool:
        """Return True: a sphere touches in the plane of its centre."""
        return True

    @property
    def depth(self) -> Vector:
        """The centre."""
        return self.at

    @property
    def corners(self) -> tuple[Vector, ...]:
        """The centre, the core of a round solid."""
        return (self.at,)

    @classmethod
    def law_with(cls, feature: type[ContactShape]) -> Law | None:
        """Return the law of round shapes."""
        return between_round if feature.round else None

    @classmethod
    def made(cls, body: Any, **data: Any) -> ContactShape:
        """Return the sphere of a body from the data of a file."""
        return sphere(body, **data)


class Tether(Ball, kind="tether", listed=False):
    """The space that a rope of length ``radius`` from ``at`` leaves to its other end: the inside of a sphere."""

    inside: bool = True

    in_families, look, section = False, "rope", "constraints"


def sphere(body: Frame, radius: Expression, *, at: Any = None, inside: bool = False) -> Ball:
    """Return a sphere fixed in the body, for contacts; ``inside=True`` for a bowl, whose body is around the sphere.

    Parameters
    ----------
    radius : expression of parameters [m]
    at : Point of the body or three components, optional
        Its centre; by default the body's origin.
    inside : bool
        True if other bodies touch it from within.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("ball in a bowl")
    >>> ball = s.body("ball", fb.sphere(1, 0.1))
    >>> air = s.free("air", s.ground, ball)
    >>> bowl = s.contact("bowl", ball.sphere(0.1), s.ground.sphere(1, at=(0, 1, 0), inside=True), friction=0.3)
    """
    what = f"the sphere of {body!r}"
    return Ball(body, place_in(body, at, what), length(body, radius, what), flag(inside, what))
