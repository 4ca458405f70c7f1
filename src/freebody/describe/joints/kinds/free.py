"""Six degrees of freedom."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ....errors import ModelError
from ...description import Description
from ...frame import Frame
from ...part import add
from ..free import Free
from ..joint import Joint
from ..primitive import Primitive


class FreeJoint(Joint, kind="free"):
    """All motions of a body."""

    def motions(self) -> Iterator[Primitive]:
        """Yield the motion."""
        yield Free()

    def refuse_loop(self) -> None:
        """Refuse a joint without effect."""
        raise ModelError(
            f"Free joint '{self.name}' has no effect, since another joint already holds '{self.child.name}'. "
            f"Leave it out."
        )


def free(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None,
    parent_axes: Any = None, child_axes: Any = None, coordinate: str | None = None, armature: Any = 0,
) -> Joint:  # fmt: skip
    """Add six degrees of freedom.

    Coordinates ``NAME_x, NAME_y, NAME_z`` (position of ``to`` from ``at``, in the parent's joint axes) and the unit
    quaternion ``NAME_e0 … NAME_e3``; speeds ``NAME_wx …`` and ``NAME_vx …``: angular velocity of the child
    and velocity of the point ``to``, both relative to the parent and in the child's joint axes.
    """
    joint = FreeJoint(
        parent, child, at=at, to=to, parent_axes=parent_axes, child_axes=child_axes, coordinate=coordinate,
        armature=armature,
    )  # fmt: skip
    return add(system, name, joint)
