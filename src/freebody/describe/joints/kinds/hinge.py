"""One turn about an axis."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ....scalar.algebra import Expression
from ...description import Description
from ...frame import Frame
from ...part import add
from ..hinge import Hinge
from ..joint import Direction, Joint
from ..primitive import Primitive
from ..rotor import Rotor


class HingeJoint(Joint, kind="hinge"):
    """One turn about ``axis`` by the angle ``coordinate`` [rad]."""

    axis: Direction = "z"

    def motions(self) -> Iterator[Primitive]:
        """Yield the turn."""
        yield Hinge(self.axis)


def hinge(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None, axis: Any = "z",
    parent_axes: Any = None, child_axes: Any = None, coordinate: Any = None,
    armature: Expression = 0, rotor: Rotor | None = None,
) -> Joint:  # fmt: skip
    """Add a hinge: one turn about ``axis`` by the angle ``coordinate`` [rad].

    Parameters
    ----------
    name : str
    parent, child : Frame
    at, to : three components or Point, optional
        The joint's point on the parent and on the child; by default their origins.
    axis : 'x', 'y', 'z' or three components
        Direction in joint axes; its length does not matter.
    parent_axes, child_axes : Rotation or 3 x 3 matrix, optional
    coordinate : str or expression, optional
        A new name, or an expression of declared coordinates and time; by default the joint's name.
    armature : expression, optional
        Inertia that the joint's speed alone moves, ½ A θ'² of the kinetic energy [kg m²], as in MuJoCo.
    rotor : Rotor, optional
        Rotor of a motor in the parent, behind a gear: reflected inertia, and the gyroscopic moments of its spin.

    Raises
    ------
    ModelError
        A body of another system, a name in use, an axis of length zero, two components instead of three.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("driven crank")
    >>> omega = s.parameters(omega=3.0)
    >>> crank = s.body("crank", fb.slender_bar(1, 2))
    >>> s.hinge("shaft", s.ground, crank, axis="z", coordinate=omega * s.t)
    hinge 'shaft' (ground -> crank)
    """
    joint = HingeJoint(
        parent, child, at=at, to=to, parent_axes=parent_axes, child_axes=child_axes, axis=axis,
        coordinate=coordinate, armature=armature, rotor=rotor,
    )  # fmt: skip
    return add(system, name, joint)
