"""One displacement along an axis."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ....scalar.algebra import Expression
from ...description import Description
from ...frame import Frame
from ...part import add
from ..joint import Direction, Joint
from ..primitive import Primitive
from ..rotor import Rotor
from ..slider import Slider


class SliderJoint(Joint, kind="slider"):
    """One displacement ``coordinate`` [m] along ``axis``, without turning."""

    axis: Direction = "x"

    def motions(self) -> Iterator[Primitive]:
        """Yield the displacement."""
        yield Slider(self.axis)


def slider(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None, axis: Any = "x",
    parent_axes: Any = None, child_axes: Any = None, coordinate: Any = None,
    armature: Expression = 0, rotor: Rotor | None = None,
) -> Joint:  # fmt: skip
    """Add a slider: one displacement ``coordinate`` [m] along ``axis``, without turning. Arguments as :meth:`hinge`."""
    joint = SliderJoint(
        parent, child, at=at, to=to, parent_axes=parent_axes, child_axes=child_axes, axis=axis,
        coordinate=coordinate, armature=armature, rotor=rotor,
    )  # fmt: skip
    return add(system, name, joint)
