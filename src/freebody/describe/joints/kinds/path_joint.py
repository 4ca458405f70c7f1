"""Joints by functions of one coordinate, or of two."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ....scalar.algebra import Vector
from ...description import Description
from ...frame import Frame
from ...part import add
from ..joint import Components, Joint, Turns
from ..primitive import Primitive


class PathJoint(Joint, kind="path_joint"):
    """A joint by functions: its pose is data."""

    position: Components = (0, 0, 0)
    turns: Turns = ()

    noun = "path joint"

    def pose(self, *coordinates: Any) -> tuple[Any, Any]:
        """Return the position and the turns."""
        return self.position, self.turns

    def stored(self, motions: Sequence[Primitive], position: Vector) -> dict[str, Any]:
        """Return the position and the turns in the system's terms."""
        turns = tuple((motion.axis, motion.coordinate) for motion in motions if motion.turns)
        return {"position": position, "turns": turns}


def path_joint(
    system: Description, name: str, parent: Frame, child: Frame, *, coordinate: Any = None, position: Any = (0, 0, 0),
    turns: Sequence[tuple[Any, Any]] = (), at: Any = None, to: Any = None, parent_axes: Any = None,
    child_axes: Any = None,
) -> Joint:  # fmt: skip
    """Add a joint by functions: the pose of the child is a function of one coordinate, or of two.

    A bead on a curve, a knee, a cam, a puck on a surface. The joint is ideal: its reaction does no work in its motion.

    Parameters
    ----------
    name : str
    parent, child : Frame
    coordinate : str
        Name of the joint's coordinate, or of two, ``"u v"``; by default the joint's name.
    position : three expressions
        The child's point ``to`` from the parent's point ``at``, in joint axes on the parent [m].
    turns : sequence of (axis, angle)
        Turns of the child in this order, each about an axis that the earlier ones carry along, such as
        ``[("z", "0.9*q")]``; by default none.
    at, to, parent_axes, child_axes : optional
        As for :meth:`hinge`.

    Raises
    ------
    ModelError
        A pose that does not depend on a coordinate, that depends on speeds, or on a signal that bends; a joint that
        closes a loop.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("bead on a parabola")
    >>> m, k, g = s.parameters(m=1.0, k=0.5, g=9.81)
    >>> s.gravity = (0, -g, 0)
    >>> bead = s.body("bead", fb.particle(m))
    >>> s.path_joint("wire", s.ground, bead, coordinate="x", position=("x", "k*x^2", 0))
    path_joint 'wire' (ground -> bead)
    >>> print(fb.equations(s).text())
    m*(1 + 4*k^2*x^2)*x'' + 4*m*k^2*x*x'^2 + 2*m*k*g*x = 0
    """
    joint = PathJoint(
        parent, child, position, turns, at=at, to=to, parent_axes=parent_axes, child_axes=child_axes,
        coordinate=coordinate,
    )  # fmt: skip
    return add(system, name, joint)
