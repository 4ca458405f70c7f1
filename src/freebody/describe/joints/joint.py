"""Joints: what a child body may do relative to its parent.

Every joint is a chain of *primitive* motions (turn, slide, screw, ball, free) from the point
``at`` on the parent to the point ``to`` on the child; the links between the primitives carry no mass.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..body import Body


@dataclass(frozen=True)
class Primitive:
    """One elementary motion.

    ``kind`` is hinge, slider, screw, ball, free or weld; ``axis`` in joint axes; ``coordinate`` the
    displacement, an expression of coordinates and time (1-dof kinds), or the tuple of the names of
    the joint's own coordinates (ball, free).
    """

    kind: str
    axis: tuple[Any, Any, Any] = (0, 0, 0)
    coordinate: Any = None
    pitch: Any = 0


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint as the user gave it; see the methods of :class:`System` that make one."""

    name: str
    type: str
    parent: Body
    child: Body
    at: tuple[Any, Any, Any]
    to: tuple[Any, Any, Any]
    parent_axes: Any
    child_axes: Any
    primitives: tuple[Primitive, ...]
    given: dict[str, Any]
    closes: bool = False
    """Whether the joint closes a loop, because its child hangs on an earlier joint or is the ground."""

    def __repr__(self) -> str:
        return f"{self.type} '{self.name}' ({self.parent.name} -> {self.child.name})"
