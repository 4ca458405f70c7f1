"""Points that touch."""

from __future__ import annotations

from typing import Any

from ...scalar.algebra import ZERO, Scalar, Vector
from ..frame import Point
from .round import between_round
from .shape import ContactShape, Law


class Spot(Point, ContactShape, kind="point"):
    """A point of a body that touches."""

    door = True
    words = {"point": "vector"}
    places = ("components",)
    look, bound, round = "spot", "spot", True

    def support(self, at: Any, direction: Vector) -> Vector:
        """Return the point itself."""
        return self.middle(at)

    def middle(self, at: Any) -> Vector:
        """Return the point, in ground axes."""
        return at.place(self.body, self.components)

    def size(self, at: Any) -> Scalar:
        """Return the radius 0."""
        return 0

    def lies_across(self, R: Any, k: Vector) -> bool:
        """Return True: a point lies in a plane."""
        return True

    @property
    def corners(self) -> tuple[Vector, ...]:
        """The place itself."""
        return (self.components,)

    @property
    def depth(self) -> Vector:
        """The point."""
        return self.components

    @classmethod
    def law_with(cls, feature: type[ContactShape]) -> Law | None:
        """Return the law of a round shape, but no point touches another."""
        return between_round if feature.round and not issubclass(feature, Spot) else None

    @classmethod
    def made(cls, body: Any, **data: Any) -> ContactShape:
        """Return the point of a body from the data of a file."""
        return spot(body.point(*data.get("point", ZERO)))

    def told(self, word: str) -> Any:
        """Return the components."""
        return self.components


def spot(point: Point) -> Spot:
    """Return a point as a shape."""
    return Spot(point.body, point.components)
