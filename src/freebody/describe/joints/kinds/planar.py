"""Motion in a plane: two displacements and a turn."""

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
from ..slider import Slider

PLANES = {"x": "yz", "y": "zx", "z": "xy"}
"""Directions of the displacements, by the normal of the plane."""


class PlanarJoint(Joint, kind="planar"):
    """Motion in the plane normal to ``axis``: two displacements and a turn."""

    axis: str = "z"

    noun = "planar joint"

    def check(self) -> None:
        """Refuse an oblique plane."""
        if not isinstance(self.axis, str) or self.axis not in PLANES:
            raise ModelError(
                f"Expected 'x', 'y' or 'z' for the normal of {self.title}, got {shown(self.axis)}. "
                f"Turn the joint by parent_axes for another plane."
            )

    @property
    def endings(self) -> tuple[str, ...]:  # type: ignore[override]
        """Endings of the names of its coordinates."""
        return (*PLANES[self.axis], "turn")

    def motions(self) -> Iterator[Primitive]:
        """Yield the displacements, then the turn."""
        for letter in PLANES[self.axis]:
            yield Slider(letter)
        yield Hinge(self.axis)


def planar(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None, axis: Any = "z",
    parent_axes: Any = None, child_axes: Any = None, coordinate: Any = None,
    armature: Any = 0,
) -> Joint:  # fmt: skip
    """Add motion in the plane normal to ``axis``: two displacements and a turn, (x, y, angle) for axis z.

    For axis x the displacements are along y and z, for axis y along z and x. Use ``parent_axes`` for
    any other normal.
    """
    joint = PlanarJoint(
        parent, child, at=at, to=to, parent_axes=parent_axes, child_axes=child_axes, axis=axis,
        coordinate=coordinate, armature=armature,
    )  # fmt: skip
    return add(system, name, joint)
