"""All turns about a point, by three Euler angles."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ....errors import ModelError, shown
from ...description import Description
from ...frame import Frame
from ...part import add
from ..hinge import Hinge
from ..joint import Joint
from ..primitive import Primitive


class GimbalJoint(Joint, kind="gimbal"):
    """All turns about a point, by three Euler angles in the body-fixed sequence ``axis``, such as "ZXZ"."""

    axis: str = "ZXZ"

    noun = "gimbal"

    def check(self) -> None:
        """Refuse anything but a sequence of body-fixed turns."""
        axis = self.axis
        if not isinstance(axis, str) or len(axis) != 3:
            raise ModelError(
                f"Expected a sequence of three axes, such as 'ZXZ', for {self.title}, got {shown(axis)}."
            )
        if axis.islower():
            raise ModelError(
                f"{self.heading}: lower case '{axis}' means space-fixed axes in SciPy. freebody's sequences are "
                f"body-fixed and in capitals: '{axis[::-1].upper()}' with the angles in reverse order is the same."
            )
        if any(letter not in "XYZ" for letter in axis) or axis[0] == axis[1] or axis[1] == axis[2]:
            raise ModelError(
                f"{self.heading}: '{axis}' is not an Euler sequence; use three of X, Y, Z with neighbours different."
            )

    def motions(self) -> Iterator[Primitive]:
        """Yield the turns."""
        for letter in self.axis:
            yield Hinge(letter.lower())


def gimbal(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None, axis: str = "ZXZ",
    parent_axes: Any = None, child_axes: Any = None, coordinate: Any = None,
    armature: Any = 0,
) -> Joint:  # fmt: skip
    """Add all turns about a point, by three Euler angles in the body-fixed sequence ``axis``, such as "ZXZ"."""
    joint = GimbalJoint(
        parent, child, at=at, to=to, parent_axes=parent_axes, child_axes=child_axes, axis=axis,
        coordinate=coordinate, armature=armature,
    )  # fmt: skip
    return add(system, name, joint)
