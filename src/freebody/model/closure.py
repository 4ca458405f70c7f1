"""Conditions of joints that close a loop.

With d the vector from the joint's point on the parent to its point on the child, in the joint axes of the parent:

    no displacement           d = 0
    one displacement          d along its axis
    two displacements         d in their plane
    a screw                   d along its axis, by pitch × the angle of the turn

Displacements come before turns, and all axes go through one point (`describe.joints.pair.Pair.closes`). Conditions on
the directions of the axes are dot products of unit vectors, one fixed in each body, that stay zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy

from ..describe.frame import Frame
from ..describe.joints.joint import Joint
from ..describe.joints.pair import Pair
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
    pair: Pair
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
    slides = [axis for axis, motion in zip(axes, joint.primitives, strict=True) if motion.slides]
    turns = [axis for axis, motion in zip(axes, joint.primitives, strict=True) if motion.turns]
    along: tuple[tuple[str, Vector], ...] = letters
    if len(slides) == 1:
        along = tuple(_across(slides[0]))
    elif slides:
        normal = cross(*slides)
        along = ((_letter(normal), normal),)
    square: tuple[tuple[str, Vector, Vector], ...] = ()
    thread: Thread | None = None
    if joint.pair.turns == 0:
        square = locked
    elif joint.pair.turns == 1:
        square = _aligned(turns[0])
    elif joint.pair.turns == 2:
        square = (("n", turns[0], turns[1]),)
    if joint.pair.threaded:
        (_, e1), (_, e2) = along
        (pitch,) = (motion.pitch for motion in joint.primitives if motion.turns)
        thread = Thread(_letter(turns[0]), turns[0], e1, e2, pitch)
    return Closure(
        joint.name, joint.type, joint.pair, joint.parent, joint.child, joint.start, joint.end, joint.parent_axes,
        joint.child_axes, along, not slides, square, thread,
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
