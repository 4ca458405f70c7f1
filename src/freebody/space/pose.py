"""Poses: position and orientation of a frame.

p_A = p_AB + R_AB p_B              a point
v_A = R_AB v_B                     a vector
(R_AB, p_AB) (R_BC, p_BC) = (R_AB R_BC, p_AB + R_AB p_BC)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..errors import ModelError, shown
from ..scalar.algebra import (
    ZERO,
    Expression,
    Matrix,
    Vector,
    add,
    apply,
    apply_transpose,
    multiply,
    negate,
    transpose,
)
from .entries import plain, substitution, vector
from .rotation import Rotation

RawPose = tuple[Matrix, Vector]


def compose(X_AB: RawPose, X_BC: RawPose) -> RawPose:
    """X_AC of two poses (R, p), any scalar type."""
    (R_AB, p_AB), (R_BC, p_BC) = X_AB, X_BC
    return (multiply(R_AB, R_BC), add(p_AB, apply(R_AB, p_BC)))


def invert(X_AB: RawPose) -> RawPose:
    """X_BA of a pose (R, p), any scalar type."""
    R_AB, p_AB = X_AB
    return (transpose(R_AB), negate(apply_transpose(R_AB, p_AB)))


@dataclass(frozen=True)
class Pose:
    """The pose X_AB of a frame B in a frame A.

    Parameters
    ----------
    rotation : Rotation, or 3 x 3
        R_AB.
    position : 3 entries
        p_AB from the origin of A to the origin of B, components in A [m].

    Examples
    --------
    >>> Pose(Rotation.axis_angle("z", 0), (1, 2, 3)).point((0, 0, 1))
    (1.0, 2.0, 4.0)
    """

    rotation: Rotation = Rotation.identity()
    position: Vector = ZERO

    def __post_init__(self) -> None:
        if not isinstance(self.rotation, Rotation):
            object.__setattr__(self, "rotation", Rotation(self.rotation))
        object.__setattr__(self, "position", vector(self.position, "the position"))

    @property
    def inverse(self) -> Pose:
        """X_BA."""
        return _pose(invert(self._raw))

    def __matmul__(self, other: Pose) -> Pose:
        """``X_AB @ X_BC`` is X_AC."""
        if not isinstance(other, Pose):
            raise ModelError(
                f"Expected a pose on the right of @, got {shown(other)}. "
                "Use .point(p) for a point, .vector(v) for a vector."
            )
        return _pose(compose(self._raw, other._raw))

    def point(self, p: Any) -> Vector:
        """Position in A, from A's origin, of a point with the position ``p`` in B [m]."""
        x, y, z = (plain(c) for c in add(self.position, apply(self.rotation.matrix, vector(p, "the point"))))
        return (x, y, z)

    def vector(self, v: Any) -> Vector:
        """Components in A of a vector with components ``v`` in B; the position has no influence."""
        return self.rotation.apply(v)

    def at(self, values: Mapping[Any, Expression]) -> Pose:
        """The pose with numbers for symbols (or their names)."""
        x, y, z = map(substitution(values), self.position)
        return Pose(self.rotation.at(values), (x, y, z))

    @property
    def _raw(self) -> RawPose:
        return (self.rotation.matrix, self.position)


def _pose(raw: RawPose) -> Pose:
    R, p = raw
    return Pose(Rotation.trusted(R), p)
