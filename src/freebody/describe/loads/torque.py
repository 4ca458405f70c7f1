"""A couple on a body."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...errors import ModelError
from ...scalar.algebra import Vector
from ..frame import Frame
from .action import Action, Couple
from .load import Load


class Torque(Load, kind="torque", sections=("torques",)):
    """A couple on a body, components [N m] in the axes of ``frame``, by default the ground's.

    Its opposite acts on ``reaction_on``, if that is given.
    """

    body: Frame
    components: Vector
    frame: Frame | None = None
    reaction_on: Frame | None = None

    units = {"components": "N m"}
    noun = "torque"
    words = {"body": "on"}

    def check(self) -> None:
        """Refuse a couple without effect."""
        if self.body is self.reaction_on or (self.body.is_ground and self.reaction_on is None):
            where = (
                "the ground, which nothing moves"
                if self.body.is_ground
                else f"'{self.body.name}' and so does its opposite"
            )
            raise ModelError(
                f"Torque '{self.name}' acts on {where}: it would have no effect. Name the body that turns, or another "
                f"one as reaction_on."
            )

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the couple and its opposite."""
        moment = at.vector(self.components, self.frame)
        yield Couple(self.body, moment)
        if self.reaction_on is not None:
            yield Couple(self.reaction_on, -moment)
