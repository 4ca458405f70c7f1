"""A turn about an axis that advances along it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ....scalar.algebra import Expression
from ...description import Description
from ...frame import Frame
from ...part import Constant, add
from ..joint import Direction, Joint
from ..primitive import Primitive
from ..rotor import Rotor
from ..screw import Screw


class ScrewJoint(Joint, kind="screw"):
    """A turn by ``coordinate`` [rad] about ``axis`` that advances ``pitch`` [m] per radian along it."""

    pitch: Constant
    axis: Direction = "z"

    def motions(self) -> Iterator[Primitive]:
        """Yield the turn."""
        yield Screw(self.axis, pitch=self.pitch)


def screw(
    system: Description, name: str, parent: Frame, child: Frame, *, pitch: Expression, at: Any = None, to: Any = None,
    axis: Any = "z", parent_axes: Any = None, child_axes: Any = None, coordinate: Any = None,
    armature: Expression = 0, rotor: Rotor | None = None,
) -> Joint:  # fmt: skip
    """Add a turn by ``coordinate`` [rad] about ``axis`` that advances ``pitch`` [m] per radian along it."""
    joint = ScrewJoint(
        parent, child, at=at, to=to, parent_axes=parent_axes, child_axes=child_axes, pitch=pitch, axis=axis,
        coordinate=coordinate, armature=armature, rotor=rotor,
    )  # fmt: skip
    return add(system, name, joint)
