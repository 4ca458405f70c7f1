"""Joints that close a loop: the conditions that they put on the bodies they join.

In the joint axes of the parent, with d the vector from the joint's point on the parent to that on the child:

    point joints              d = 0
    slider, cylindrical       d at right angles to the axis
    planar                    d in the plane

and on the direction of the axes: dot products of unit vectors, one fixed in each body, that stay zero.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..describe.body import Body
from ..describe.joint import Joint
from ..errors import ModelError
from ..scalar.algebra import IDENTITY, Matrix, Vector, cross

X, Y, Z = IDENTITY
LETTERS = "xyz"


@dataclass(frozen=True)
class Closure:
    """A loop-closing joint.

    ``along`` are the (letter, unit vector) in parent joint axes in which d vanishes; ``in_ground`` says that they are
    ground axes instead; ``square`` the (letter, vector on the parent, vector on the child) whose dot products keep the
    value that they have when the axes of both are parallel, mostly zero.
    """

    name: str
    type: str
    parent: Body
    child: Body
    at: Vector
    to: Vector
    parent_axes: Matrix
    child_axes: Matrix
    along: tuple[tuple[str, Vector], ...]
    in_ground: bool
    square: tuple[tuple[str, Vector, Vector], ...]


def closure(joint: Joint) -> Closure:
    """The conditions of a joint that closes a loop."""
    # a loop-closing joint has no displacement, so the sense of its axis means nothing
    axes = [_positive(primitive.axis) for primitive in joint.primitives]
    letters = tuple(zip(LETTERS, IDENTITY, strict=True))
    # the moment of a condition a·b = 0 acts along b × a: these three turn about x, y and z
    locked = (("x", Z, Y), ("y", X, Z), ("z", Y, X))
    along: tuple[tuple[str, Vector], ...] = letters
    square: tuple[tuple[str, Vector, Vector], ...] = ()
    in_ground = True
    if joint.type == "hinge":
        (_, e1), (_, e2) = _across(joint, axes[0])
        names = [letter for letter, _ in _across(joint, axes[0])]
        square = ((names[0], _minus(e2), axes[0]), (names[1], e1, axes[0]))
    elif joint.type == "universal":
        square = (("n", axes[0], axes[1]),)
    elif joint.type == "weld":
        square = locked
    elif joint.type in ("slider", "cylindrical"):
        along, in_ground = tuple(_across(joint, axes[0])), False
        (_, e1), (_, e2) = along
        square = (
            locked
            if joint.type == "slider"
            else ((along[0][0], _minus(e2), axes[0]), (along[1][0], e1, axes[0]))
        )
    elif joint.type == "planar":
        normal = axes[2]
        along, in_ground = ((LETTERS[normal.index(1)], normal),), False
        (a, e1), (b, e2) = _across(joint, normal)
        square = ((a, _minus(e2), normal), (b, e1, normal))
    elif joint.type not in ("ball", "gimbal"):
        raise ModelError(
            f"{joint.type[0].upper()}{joint.type[1:]} '{joint.name}' closes a loop, which joints of this type can not. "
            f"Open the loop elsewhere: declare this joint before the one that closes it."
        )
    return Closure(
        joint.name, joint.type, joint.parent, joint.child, joint.at, joint.to, joint.parent_axes, joint.child_axes,
        along, in_ground, square,
    )  # fmt: skip


def _positive(axis: Vector) -> Vector:
    return _minus(axis) if _minus(axis) in IDENTITY else axis


def _across(joint: Joint, n: Vector) -> list[tuple[str, Vector]]:
    """Two unit vectors that make a right-handed set with the axis, named by their letters."""
    for k in range(3):
        if n == IDENTITY[k]:
            i, j = (k + 1) % 3, (k + 2) % 3
            return [(LETTERS[i], IDENTITY[i]), (LETTERS[j], IDENTITY[j])]
    raise ModelError(
        f"Joint '{joint.name}' closes a loop with the oblique axis {n}. Turn its axes by parent_axes and child_axes so "
        f"that the axis is 'x', 'y' or 'z' in them."
    )


def _minus(v: Vector) -> Vector:
    return (-v[0], -v[1], -v[2])


def moment_of(a: Vector, b: Vector) -> Vector:
    """Moment on the child per unit multiplier of a·b = 0: d(a·b)/dt = w_rel·(b × a)."""
    return cross(b, a)
