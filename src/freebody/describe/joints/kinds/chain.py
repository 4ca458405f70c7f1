"""Chains of primitive motions, with an anchor for each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ....scalar.algebra import Vector
from ...description import Description
from ...frame import Frame
from ...part import add
from ..joint import Joint, Motions
from ..primitive import Primitive


class ChainJoint(Joint, kind="chain"):
    """A chain of primitive motions, without bodies between them."""

    parts: Motions

    words = {"parts": "motions"}

    def motions(self) -> Sequence[Primitive]:
        """Return the motions."""
        return self.parts

    def stored(self, motions: Sequence[Primitive], position: Vector) -> dict[str, Any]:
        """Return the motions in the system's terms, with the coordinates."""
        return {"parts": tuple(motions), "coordinate": None}


def chain(
    system: Description, name: str, parent: Frame, child: Frame, motions: Sequence[Primitive], *, at: Any = None,
    to: Any = None, parent_axes: Any = None, child_axes: Any = None,
) -> Joint:  # fmt: skip
    """Add a joint that is a chain of primitive motions, from the parent to the child, without bodies between them.

    With all coordinates zero the joint's points and axes on both bodies coincide, and the anchors stand where they are
    given. Each motion then carries the anchors and axes of the later ones with it, and the child.

    Parameters
    ----------
    name : str
    parent, child : Frame
    motions : sequence of Hinge, Slider, Screw or Ball
        Such as ``[fb.Hinge("x", "roll"), fb.Hinge("y", "pitch", at=(0, 0, L))]``: the axis in joint axes, the
        coordinate (by default NAME_1, NAME_2, …), the anchor ``at`` from the joint's point in joint axes.
    at, to, parent_axes, child_axes : optional
        As for :meth:`hinge`.

    Raises
    ------
    ModelError
        No motions or a joint of another sort among them; two motions that are the same, such as a ball and a turn
        about an axis through its point; a chain that closes a loop.

    Examples
    --------
    A hip and a knee in one joint, as robots have them:

    >>> import freebody as fb
    >>> s = fb.System("leg")
    >>> foot = s.body("foot", fb.particle(1))
    >>> s.chain("leg", s.ground, foot, [fb.Hinge("z", "hip"), fb.Hinge("z", "knee", at=(0, -1, 0))], to=(0, 2, 0))
    chain 'leg' (ground -> foot)
    >>> print(fb.equations(s).text())
    2*(1 + cos(knee))*hip'' + (1 + cos(knee))*knee'' - 2*hip'*knee'*sin(knee) - knee'^2*sin(knee) = 0
    (1 + cos(knee))*hip'' + knee'' + hip'^2*sin(knee) = 0
    """
    joint = ChainJoint(
        parent, child, motions, at=at, to=to, parent_axes=parent_axes, child_axes=child_axes,
    )  # fmt: skip
    return add(system, name, joint)
