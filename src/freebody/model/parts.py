"""Parts of a model: coordinates, speeds, links, and the places of bodies and joints among the links."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..describe.joints.moving import Moving
from ..describe.joints.pair import Pair
from ..scalar.algebra import Expression, Matrix, Vector
from ..space.mass import MassProperties
from ..space.shape import Shape

GROUND = -1


@dataclass(frozen=True)
class Coordinate:
    """An entry of q: its name, its SymPy atom and its kind.

    A scalar coordinate has its own speed; the coordinates of a quaternion or of the position of a free joint do not.
    """

    name: str
    symbol: Any
    kind: str  # "scalar", "position" or "quaternion"


@dataclass(frozen=True)
class Speed:
    """An entry of u: its name, its SymPy atom and the atom of its time derivative."""

    name: str
    symbol: Any
    acceleration: Any


@dataclass(frozen=True)
class Link(Moving):
    """A primitive motion and the link that it moves.

    The link's frame has its origin at the joint's point and the axes of its body (the axes of the joint
    for the massless links inside a joint). In the frame of the parent link, the joint's
    frame has the origin ``position`` and the constant rotation ``rotation`` (parent from joint).
    """

    joint: str
    body: str | None
    kind: str  # hinge, slider, screw, ball, free, weld
    parent: int
    rotation: Matrix
    position: Vector
    axis: Vector
    pitch: Expression
    displacement: Expression  # y(q, t) of a primitive with one degree of freedom
    partials: tuple[tuple[int, Expression], ...]  # (index of the speed, dy/dq) where dy/dq is not zero
    drift: Expression  # dy/dt at constant q
    bias: Expression  # second derivative of y without the terms with accelerations
    q: int  # first coordinate of a ball or free joint, else -1
    u: int  # first speed of a ball or free joint, else -1
    mass: Expression
    center: Vector
    inertia: Matrix  # about the mass centre
    armature: tuple[Expression, ...] = ()  # inertia that each speed of the motion alone moves, or none
    rotor: Vector = (
        0,
        0,
        0,
    )  # spin of rotors in the parent per unit rate, in the link's axes at no displacement

    @property
    def quaternion(self) -> int:
        """Index in q of the scalar part of its unit quaternion, of a motion that has one."""
        return self.q + self.motion.quaternion

    @property
    def driven(self) -> bool:
        """True if the motion is a given function of time."""
        return self.one_dof and not self.partials


@dataclass(frozen=True)
class Place:
    """Place of a body's frame: its link, and its origin from the origin of the link."""

    link: int
    origin: Vector
    mass: Expression
    center: Vector  # from the body's origin
    inertia: Matrix
    properties: MassProperties | None = None

    @property
    def shape(self) -> Shape | None:
        """Shape of the body's solid, of a body that has one."""
        return None if self.properties is None else self.properties.shape


@dataclass(frozen=True)
class JointPlace:
    """The links of a joint, first to last, and the bodies it joins."""

    type: str
    pair: Pair
    links: tuple[int, ...]
    parent: str
    child: str
    at: Vector
    to: Vector
    parallel: tuple[tuple[int, int], ...] = ()  # pair.parallel_turns of its motions
