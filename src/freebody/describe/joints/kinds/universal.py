"""Two turns about crossed axes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import sympy

from ....errors import ModelError, shown
from ....scalar.algebra import cross
from ...axes import direction
from ...description import Description
from ...frame import Frame
from ...part import add
from ..hinge import Hinge
from ..joint import Directions, Joint
from ..primitive import Primitive


class UniversalJoint(Joint, kind="universal"):
    """Two turns: about the first ``axis``, fixed in the parent, then about the second, fixed in the child."""

    axis: Directions = ("x", "y")

    noun = "universal joint"

    def check(self) -> None:
        """Refuse anything but two axes."""
        if isinstance(self.axis, str) or not hasattr(self.axis, "__len__") or len(self.axis) != 2:
            raise ModelError(
                f"Expected two axes, such as ('x', 'y'), for {self.title}, got {shown(self.axis)}."
            )
        system: Any = self.parent.system
        first, second = (direction(system, part, f"the axis of {self.title}") for part in self.axis)
        if all(sympy.sympify(component) == 0 for component in cross(first, second)):
            raise ModelError(
                f"The two axes of {self.title} are parallel: {shown(self.axis)}. Give two directions, or make a "
                "hinge."
            )

    def motions(self) -> Iterator[Primitive]:
        """Yield the turns."""
        for axis in self.axis:
            yield Hinge(axis)


def universal(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None,
    axis: Any = ("x", "y"), parent_axes: Any = None, child_axes: Any = None, coordinate: Any = None,
    armature: Any = 0,
) -> Joint:  # fmt: skip
    """Add two turns: about the first ``axis``, fixed in the parent, then about the second, fixed in the child."""
    joint = UniversalJoint(
        parent, child, at=at, to=to, parent_axes=parent_axes, child_axes=child_axes, axis=axis,
        coordinate=coordinate, armature=armature,
    )  # fmt: skip
    return add(system, name, joint)
