"""The protocol of a joint: the motions of a child body relative to its parent.

Every joint is a chain of *primitive* motions (turn, slide, screw, ball, free) from the point ``at`` on the parent to
the point ``to`` on the child; the links between the primitives carry no mass. A kind of joint says its motions, or its
pose as a function of its coordinates.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self, TypeAlias, dataclass_transform

from ...errors import ModelError, shown
from ...scalar.algebra import IDENTITY, ZERO, Matrix, Vector, apply
from ...scalar.expression import exact
from ..axes import direction, orientation
from ..description import Description, children_of, vector
from ..frame import Frame, closes_loop, own_body
from ..part import SORTS, Part, answer, register, said_by
from .functions import displacements_of
from .joining import place_on
from .motions import resolved
from .pair import Pair, pair_of
from .primitive import Primitive
from .rotor import Rotor, constant, with_inertia

Anchor: TypeAlias = Any
"""A point of the joint's body: three components, a point, or None for the origin."""
Axes: TypeAlias = Any
"""A rotation matrix, or None for the axes of the body."""
Direction: TypeAlias = Any
"""'x', 'y', 'z' or three components."""
Displacements: TypeAlias = Any
"""Names of new coordinates or expressions, one for each motion."""
Directions: TypeAlias = Any
"""Several directions."""
Motions: TypeAlias = Any
"""A list of primitive motions."""
Components: TypeAlias = Any
"""Three expressions of the coordinates that the joint declares."""
Turns: TypeAlias = Any
"""A list of pairs (axis, angle)."""
Armature: TypeAlias = Any
"""Inertia that the speeds of a joint alone move."""

KINDS: dict[str, type[Joint]] = {}
"""Kinds of joints that model files know, by name."""


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
@dataclass(frozen=True, repr=False, eq=False)
class Joint(Part):
    """A kind of joint: subclass it, declare its data as fields, and say its motions or its pose.

    The fields of a subclass are those of :class:`freebody.Load`. Every joint has ``parent`` and ``child``, and takes by
    name what :meth:`System.hinge` takes: ``at``, ``to``, ``parent_axes``, ``child_axes``, ``coordinate``, ``armature``
    and ``rotor``. ``s.add(name, joint)`` puts it into the machine.

    ``motions()`` yields the primitive motions from the parent to the child, :class:`~freebody.Hinge`,
    :class:`~freebody.Slider`, :class:`~freebody.Screw` and :class:`~freebody.Ball`, each with its axis and its anchor
    ``at`` in joint axes. Their coordinates are named after the joint, ``NAME_ENDING`` with the ``endings`` of the
    class.

    ``pose(q)``, or ``pose(u, v)`` with two endings, says in its place the position and the turns of the child as
    functions of the joint's own coordinates, SymPy symbols: ``return (x, y, z), [("z", angle)]``
    (:meth:`System.path_joint`). They are differentiated exactly.

    ``class Leg(fb.Joint, kind="leg")`` gives the kind a name in model files.

    Attributes
    ----------
    name : str
    type : str
        Name of the kind, such as "hinge".
    parent, child : Body
    at, to : three expressions [m]
        The joint's point on the parent and on the child, in the axes of each body.
    parent_axes, child_axes : 3 x 3
        Rotation matrices whose columns are the joint axes on the parent and on the child.
    axis : axes of the kinds that have one
    coordinate : tuple or str
        Displacements of the motions whose coordinates the joint names, or what ball and free joints begin names with.
    armature : expression or tuple
    rotor : Rotor
        Inertia that its speeds alone move, and the rotor of a motor.
    endings : tuple of str
        Endings of the names of its coordinates.
    primitives : tuple of Primitive
        Elementary motions, from the parent to the child.
    pair : Pair
        What the motions leave free.
    start, end : three expressions [m]
        Anchor of the first motion on the parent, and of the last one on the child.
    closes : bool
        True if the joint closes a loop: its child already has a joint, or is the ground.

    Examples
    --------
    A hip and a knee in one joint:

    >>> import freebody as fb
    >>> class Leg(fb.Joint):
    ...     thigh: fb.Expression  # length [m]
    ...
    ...     endings = ("hip", "knee")
    ...
    ...     def motions(self):
    ...         yield fb.Hinge("z")
    ...         yield fb.Hinge("z", at=(0, -self.thigh, 0))
    >>> s = fb.System("robot")
    >>> foot = s.body("foot", fb.particle(1))
    >>> s.add("left", Leg(s.ground, foot, 1, to=(0, 2, 0)))
    leg 'left' (ground -> foot)
    >>> list(fb.assemble(s).coordinate_names)
    ['left_hip', 'left_knee']
    """

    parent: Frame
    child: Frame
    at: Anchor = field(default=None, kw_only=True)
    to: Anchor = field(default=None, kw_only=True)
    parent_axes: Axes = field(default=None, kw_only=True)
    child_axes: Axes = field(default=None, kw_only=True)
    coordinate: Displacements = field(default=None, kw_only=True)
    armature: Armature = field(default=0, kw_only=True)
    rotor: Rotor | None = field(default=None, kw_only=True)
    primitives: tuple[Primitive, ...] = field(default=(), init=False)
    pair: Pair = field(default=Pair(), init=False)
    start: Vector = field(default=ZERO, init=False)
    end: Vector = field(default=ZERO, init=False)
    closes: bool = field(default=False, init=False)

    table: ClassVar[str] = "joints"
    article: ClassVar[str] = "joint"
    base: ClassVar[str] = "fb.Joint"
    cure: ClassVar[str] = "A motion that changes its sizes is a joint by functions, s.path_joint."
    rules: ClassVar[str] = (
        "Motions are yielded for the data of the joint; a pose is made of SymPy expressions of its coordinates, such "
        "as sympy.sin(q), without if on them."
    )
    endings: ClassVar[Sequence[str]] = ()
    """Endings of the names of its coordinates; by default their numbers, if there are several."""

    def __init_subclass__(cls, *, kind: str = "") -> None:
        super().__init_subclass__()
        register(cls, kind, KINDS, by_data=False)

    def motions(self) -> Iterable[Primitive]:
        """Yield the primitive motions from the parent to the child."""
        raise ModelError(
            f"{self.heading}: its class {type(self).__name__} has no motions. Define motions(self), which yields "
            f"fb.Hinge, fb.Slider, fb.Screw or fb.Ball, or pose(self, q), which returns a position and turns."
        )

    def pose(self, *coordinates: Any) -> tuple[Any, Any]:
        """Return the position of the child, three components, and its turns, (axis, angle), in joint axes."""
        raise ModelError(f"{self.heading} has no pose.")

    def stored(self, motions: Sequence[Primitive], position: Vector) -> dict[str, Any]:
        """Return data of the kind that its motions in the system's terms replace, or the ``position`` of its pose."""
        return {}

    @property
    def type(self) -> str:
        """Name of the kind."""
        return self.kind or super().__repr__().partition(" '")[0]

    @property
    def title(self) -> str:
        """Kind and name, as messages write them."""
        return f"{self.noun or self.type} '{self.name}'"

    def __repr__(self) -> str:
        ends = (getattr(end, "name", end) for end in (self.parent, self.child))
        return f"{self.type} '{self.name}' ({' -> '.join(map(str, ends))})"

    def joined(self, system: Description) -> Self:
        """Return the joint with its motions in the system's terms; its child is then held."""
        if self.parent is self.child:
            raise ModelError(
                f"{self.heading} joins body '{self.parent.name}' to itself. Name two different bodies."
            )
        answer(self, self.check)
        axes = [IDENTITY if x is None else x for x in (self.parent_axes, self.child_axes)]
        points = [ZERO if x is None else x for x in (self.at, self.to)]
        closes = closes_loop(system, self.child)
        path = type(self).pose is not Joint.pose
        told: Mapping[str, Any]
        with said_by(self, self.pose if path else self.motions):
            if path:
                motions, anchors, told = displacements_of(system, self)
            else:
                motions, told = resolved(system, self)
                anchors = (motions[0].at, motions[-1].at)
        motions = with_inertia(system, self, motions)
        pair = pair_of(motions, path)
        if closes and not pair.closes:
            self.refuse_loop()
        joint = replace(self)
        if self.rotor is not None:
            told = {**told, "rotor": motions[0].rotor}
        values = {
            "at": points[0], "to": points[1], "parent_axes": axes[0], "child_axes": axes[1], **told,
            "primitives": tuple(motions), "pair": pair, "closes": closes,
            "start": _moved(points[0], axes[0], anchors[0]), "end": _moved(points[1], axes[1], anchors[1]),
        }  # fmt: skip
        for key, value in values.items():
            object.__setattr__(joint, key, value)
        children_of(system).add(self.child.name)
        return joint

    def refuse_loop(self) -> None:
        """Refuse a joint that closes a loop, whose conditions would not be those of its motions."""
        raise ModelError(
            f"{self.heading} closes a loop, which joints of this type cannot. Open the loop elsewhere: declare this "
            f"joint before the one that closes it."
        )


def turns_freely(joint: Any, index: Any = None) -> bool:
    """Return True if a motion of a joint, by its number, is a ball, alone or of a free joint; without, if any is."""
    motions = enumerate(joint.primitives) if isinstance(joint, Joint) else ()
    return any(motion.quaternion >= 0 for k, motion in motions if index is None or k == index)


def _moved(place: Vector, axes: Matrix, anchor: Vector) -> Vector:
    """Return a place on a body, moved by an anchor in joint axes."""
    if anchor == ZERO:
        return place
    x, y, z = (exact(a + b) for a, b in zip(place, apply(axes, anchor), strict=True))
    return (x, y, z)


def _place(system: Description, value: Any, joint: Any, name: str) -> Any:
    what = f"{name}= of {joint.title}"
    return place_on(
        system, value, own_body(system, {"at": joint.parent, "to": joint.child}[name], joint.title), what
    )


def _direction(system: Description, value: Any, joint: Any, name: str) -> Any:
    direction(system, value, f"the {name} of {joint.title}")
    return (
        value if isinstance(value, str) else vector(system, value, joint.title)
    )  # files have the user's letter


def _rotor(system: Description, value: Any, joint: Any, name: str) -> Any:
    if value is not None and not isinstance(value, Rotor):
        raise ModelError(
            f"Expected a rotor for {joint.title}, such as fb.Rotor(J, ratio=100), got {shown(value)}."
        )
    return value


def _armature(system: Description, value: Any, joint: Any, name: str) -> Any:
    what = f"the armature of {joint.title}"
    if isinstance(value, list | tuple):
        return tuple(constant(system, part, what) for part in value)
    return 0 if value is None else constant(system, value, what)


SORTS["Anchor"] = _place
SORTS["Armature"] = _armature
SORTS["Axes"] = lambda system, value, joint, name: orientation(system, value, f"{name}= of {joint.title}")
SORTS["Direction"] = _direction
SORTS["Rotor"] = _rotor
