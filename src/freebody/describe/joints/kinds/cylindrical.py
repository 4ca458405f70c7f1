"""A displacement along an axis and a turn about it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...description import Description
from ...frame import Frame
from ...part import add
from ..hinge import Hinge
from ..joint import Direction, Joint
from ..primitive import Primitive
from ..slider import Slider


class CylindricalJoint(Joint, kind="cylindrical"):
    """A displacement along ``axis`` and a turn about it."""

    axis: Direction = "z"

    noun = "cylindrical joint"
    endings = ("slide", "turn")

    def motions(self) -> Iterator[Primitive]:
        """Yield the displacement, then the turn."""
        yield Slider(self.axis)
        yield Hinge(self.axis)


def cylindrical(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None, axis: Any = "z",
    parent_axes: Any = None, child_axes: Any = None, coordinate: Any = None,
    armature: Any = 0,
) -> Joint:  # fmt: skip
    """Add a displacement along ``axis`` and a turn about it; ``coordinate`` is (displacement, angle)."""
    joint = CylindricalJoint(
        parent, child, at=at, to=to, parent_axes=parent_axes, child_axes=child_axes, axis=axis,
        coordinate=coordinate, armature=armature,
    )  # fmt: skip
    return add(system, name, joint)
