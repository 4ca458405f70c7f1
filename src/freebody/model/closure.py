"""Joints that close a loop: the conditions that they put on the bodies they join.

In the joint axes of the parent, with d the vector from the joint's point on the parent to that on the child:

    point joints              d = 0
    slider, cylindrical       d at right angles to the axis
    planar                    d in the plane
    screw                     as cylindrical, and d along the axis = pitch × the angle of the turn

and on the direction of the axes: dot products of unit vectors, one fixed in each body, that stay zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import sympy

from ..describe.frame import Frame
from ..describe.joints.joint import Joint
from ..errors import ModelError
from ..scalar.algebra import IDENTITY, Matrix, Vector, cross

X, Y, Z = IDENTITY
LETTERS = "xyz"


@dataclass(frozen=True)
class Thread:
    """Of a screw: its letter and axis, two unit vectors across that make a right-handed set with it, its pitch [m]."""

    letter: str
    axis: Vector
    first: Vector
    second: Vector
    pitch: Any


@dataclass(frozen=True)
class Closure:
    """A loop-closing joint.

    ``along`` are the (letter, unit vector) in parent joint axes in which d vanishes; ``in_ground`` says that they are
    ground axes instead; ``square`` the (letter, vector on the parent, vector on the child) whose dot products keep the
    value that they have when the axes of both are parallel, mostly zero. Letters are x, y, z of the joint's axes, and
    of an oblique axis n, with p and q across.
    """

    name: str
    type: str
    parent: Frame
    child: Frame
    at: Vector
    to: Vector
    parent_axes: Matrix
    child_axes: Matrix
    along: tuple[tuple[str, Vector], ...]
    in_ground: bool
    square: tuple[tuple[str, Vector, Vector], ...]
    thread: Thread | None = None


def closure(joint: Joint) -> Closure:
    """The conditions of a joint that closes a loop."""
    # turned round, the axis of a loop-closing joint is the same: it has no displacement, a screw the same pitch
    axes = [_positive(primitive.axis) for primitive in joint.primitives]
    letters = tuple(zip(LETTERS, IDENTITY, strict=True))
    # the moment of a condition a·b = 0 acts along b × a: these three turn about x, y and z
    locked = (("x", Z, Y), ("y", X, Z), ("z", Y, X))
    along: tuple[tuple[str, Vector], ...] = letters
    square: tuple[tuple[str, Vector, Vector], ...] = ()
    thread: Thread | None = None
    in_ground = True
    if joint.type == "hinge":
        square = _aligned(axes[0])
    elif joint.type == "universal":
        square = (("n", axes[0], axes[1]),)
    elif joint.type == "weld":
        square = locked
    elif joint.type == "slider":
        along, in_ground, square = tuple(_across(axes[0])), False, locked
    elif joint.type in ("cylindrical", "screw"):
        along, in_ground, square = tuple(_across(axes[0])), False, _aligned(axes[0])
        if joint.type == "screw":
            (_, e1), (_, e2) = along
            thread = Thread(_letter(axes[0]), axes[0], e1, e2, joint.primitives[0].pitch)
    elif joint.type == "planar":
        along, in_ground, square = ((_letter(axes[2]), axes[2]),), False, _aligned(axes[2])
    elif joint.type not in ("ball", "gimbal"):
        raise ModelError(
            f"{joint.type[0].upper()}{joint.type[1:]} '{joint.name}' closes a loop, which joints of this type can not. "
            f"Open the loop elsewhere: declare this joint before the one that closes it."
        )
    return Closure(
        joint.name, joint.type, joint.parent, joint.child, joint.at, joint.to, joint.parent_axes, joint.child_axes,
        along, in_ground, square, thread,
    )  # fmt: skip


def _positive(axis: Vector) -> Vector:
    return _minus(axis) if _minus(axis) in IDENTITY else axis


def _aligned(n: Vector) -> tuple[tuple[str, Vector, Vector], ...]:
    """Conditions that keep the axis n of the child along that of the parent."""
    (a, e1), (b, e2) = _across(n)
    return ((a, _minus(e2), n), (b, e1, n))


def _letter(n: Vector) -> str:
    """Of a direction: its letter, or n where it is oblique."""
    return LETTERS[IDENTITY.index(n)] if n in IDENTITY else "n"


def _across(n: Vector) -> list[tuple[str, Vector]]:
    """Two unit vectors that make a right-handed set with the axis, named by their letters; p and q if it is oblique."""
    if n in IDENTITY:
        k = IDENTITY.index(n)
        i, j = (k + 1) % 3, (k + 2) % 3
        return [(LETTERS[i], IDENTITY[i]), (LETTERS[j], IDENTITY[j])]
    zero = next((k for k in range(3) if n[k] == 0), None)
    if zero is not None:
        first: Vector = IDENTITY[zero]
    else:
        size = sympy.sqrt(n[0] ** 2 + n[1] ** 2)
        first = (n[1] / size, -n[0] / size, 0)
    return [("p", first), ("q", cross(n, first))]


def _minus(v: Vector) -> Vector:
    return (-v[0], -v[1], -v[2])
