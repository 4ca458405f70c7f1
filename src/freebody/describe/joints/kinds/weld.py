"""No motion."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...description import Description
from ...frame import Frame
from ...part import add
from ..joint import Joint
from ..primitive import Primitive
from ..weld import Weld


class WeldJoint(Joint, kind="weld"):
    """The child is fixed to the parent."""

    def motions(self) -> Iterator[Primitive]:
        """Yield no motion."""
        yield Weld()


def weld(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None,
    parent_axes: Any = None, child_axes: Any = None,
) -> Joint:  # fmt: skip
    """Fix the child to the parent; the joint's reaction has all six components."""
    joint = WeldJoint(
        parent, child, at=at, to=to, parent_axes=parent_axes, child_axes=child_axes,
    )  # fmt: skip
    return add(system, name, joint)
