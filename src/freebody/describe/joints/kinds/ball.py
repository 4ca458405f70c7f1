"""All turns about a point, by a unit quaternion."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...description import Description
from ...frame import Frame
from ...part import add
from ..ball import Ball
from ..joint import Joint
from ..primitive import Primitive


class BallJoint(Joint, kind="ball"):
    """All turns about a point, by a unit quaternion; no attitude is singular."""

    def motions(self) -> Iterator[Primitive]:
        """Yield the turns."""
        yield Ball()


def ball(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None,
    parent_axes: Any = None, child_axes: Any = None, coordinate: str | None = None, armature: Any = 0,
) -> Joint:  # fmt: skip
    """Add all turns about a point, by a unit quaternion; no attitude is singular.

    Coordinates ``NAME_e0 … NAME_e3`` (scalar first), speeds ``NAME_wx, NAME_wy, NAME_wz``: the angular
    velocity of the child in the parent, components in the child's joint axes. ``coordinate`` replaces NAME.
    """
    joint = BallJoint(
        parent, child, at=at, to=to, parent_axes=parent_axes, child_axes=child_axes, coordinate=coordinate,
        armature=armature,
    )  # fmt: skip
    return add(system, name, joint)
