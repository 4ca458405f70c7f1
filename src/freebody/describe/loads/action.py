"""What a load does to a machine: actions of four sorts, with values of any scalar type."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from ...scalar.algebra import Scalar
from ..frame import Frame
from ..joints.joint import Joint


@dataclass(frozen=True)
class PointForce:
    """A force at a point of a body, components in ground axes [N]."""

    point: Any  # a point of a body, or a place on it that may move
    force: Any


@dataclass(frozen=True)
class Couple:
    """A couple on a body, components in ground axes [N m]."""

    body: Frame
    moment: Any

    def times(self, factor: Scalar) -> Couple:
        """Return the couple, multiplied by a number."""
        return replace(self, moment=factor * self.moment)


@dataclass(frozen=True)
class JointForce:
    """A force [N] or moment [N m] along one displacement of a joint: on its child, and opposite on its parent."""

    joint: Joint
    value: Scalar
    index: int = 0

    def times(self, factor: Scalar) -> JointForce:
        """Return the force, multiplied by a number."""
        return replace(self, value=factor * self.value)


@dataclass(frozen=True)
class GeneralizedForce:
    """A force conjugate to a coordinate, given by its name or its function of time; power is value times speed."""

    coordinate: Any
    value: Scalar


Action: TypeAlias = PointForce | Couple | JointForce | GeneralizedForce
