"""Conditions of joints that close a loop.

With d the vector from the joint's point on the parent to its point on the child, in the joint axes of the parent:

    point joints              d = 0
    slider, cylindrical       d along the axis
    planar                    d in the plane
    screw                     as cylindrical, and d along the axis = pitch × the angle of the turn

Conditions on the directions of the axes are dot products of unit vectors, one fixed in each body, that stay zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy

from ..describe.frame import Frame
from ..describe.joints.joint import Joint
from ..errors import ModelError
from ..scalar.algebra import IDENTITY, Expression, Matrix, Vector, cross

X, Y, Z = IDENTITY
LETTERS = "xyz"


@dataclass(frozen=True)
class Thread:
    """A screw: letter and direction of its axis, two unit vectors that make a right-handed set with it, pitch [m]."""

    letter: str
    axis: Vector
    first: Vector
    second: Vector
    pitch: Expression


@dataclass(frozen=True)
class Closure:
    """A loop-closing joint.

    ``along`` are the directions (letter, unit vector) along which d vanishes, in the joint axes of the parent, or in
    ground axes if ``in_ground`` is true. ``square`` are the triples (letter, vector on the parent, vector on the child)
    whose dot products keep the value that they have when the axes of both are parallel, mostly zero. The letters are
    x, y, z of the joint's axes; an oblique axis has the letter n, and the directions across it have p and q.
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
    """Return the conditions of a joint that closes a loop."""
    # the axis may be reversed: a loop-closing joint has no displacement, and the pitch of a screw stays the same
    axes = [_positive(primitive.axis) for primitive in joint.primitives]
    letters = tuple(zip(LETTERS, IDENTITY, strict=True))
    # the moment of a condition a·b = 0 acts along b × a: here along x, y and z
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
            f"{joint.type[0].upper()}{joint.type[1:]} '{joint.name}' closes a loop, which joints of this type cannot. "
            f"Open the loop elsewhere: declare this joint before the one that closes it."
        )
    return Closure(
        joint.name, joint.type, joint.parent, joint.child, joint.at, joint.to, joint.parent_axes, joint.child_axes,
        along, in_ground, square, thread,
    )  # fmt: skip


def _positive(axis: Vector) -> Vector:
    """The axis, reversed if it is a negative coordinate axis."""
    return _minus(axis) if _minus(axis) in IDENTITY else axis


def _aligned(n: Vector) -> tuple[tuple[str, Vector, Vector], ...]:
    """Conditions that keep the axis n of the child parallel to the axis n of the parent."""
    (a, e1), (b, e2) = _across(n)
    return ((a, _minus(e2), n), (b, e1, n))


def _letter(n: Vector) -> str:
    """Letter of a direction; n if it is oblique."""
    return LETTERS[IDENTITY.index(n)] if n in IDENTITY else "n"


def _across(n: Vector) -> list[tuple[str, Vector]]:
    """Two unit vectors that make a right-handed set with the axis, with their letters; p and q if it is oblique."""
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
