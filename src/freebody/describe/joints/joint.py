"""Joints: the motions of a child body relative to its parent.

Every joint is a chain of *primitive* motions (turn, slide, screw, ball, free) from the point
``at`` on the parent to the point ``to`` on the child; the links between the primitives carry no mass.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...scalar.algebra import Matrix, Vector
from ..frame import Frame
from .primitive import Primitive


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint as the user described it; made by the methods of :class:`System`, such as ``s.hinge``.

    Attributes
    ----------
    name : str
    type : str
        Name of the method that made it, such as "hinge".
    parent, child : Body
    at, to : three expressions [m]
        The joint's point on the parent and on the child, in the axes of each body.
    parent_axes, child_axes : 3 x 3
        Rotation matrices whose columns are the joint axes on the parent and on the child.
    primitives : tuple of Primitive
        Elementary motions, from the parent to the child.
    arguments : dict
        Further arguments of the method, as the user wrote them.
    closes : bool
        True if the joint closes a loop: its child already has a joint, or is the ground.
    path : bool
        True if the displacements are functions of the joint's own coordinates, which make one motion.
    """

    name: str
    type: str
    parent: Frame
    child: Frame
    at: Vector
    to: Vector
    parent_axes: Matrix
    child_axes: Matrix
    primitives: tuple[Primitive, ...]
    arguments: dict[str, Any]
    closes: bool = False
    path: bool = False

    def __repr__(self) -> str:
        return f"{self.type} '{self.name}' ({self.parent.name} -> {self.child.name})"
