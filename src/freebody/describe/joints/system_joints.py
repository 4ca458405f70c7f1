"""Methods of System that make joints: hinge, slider, cylindrical, screw, universal, ball, gimbal, planar, free, weld.

All take ``name, parent, child``, the point ``at`` on the parent and ``to`` on the child (components in
the axes of each body, from its origin), and ``parent_axes`` / ``child_axes`` (rotation matrices whose
columns are the joint axes) if the joint's axes are not parallel to the body's. With all coordinates
zero the joint axes on both bodies coincide.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, NamedTuple, ParamSpec

import sympy

from ...errors import ModelError, shown
from ...scalar.algebra import Expression, Scalar, Vector, cross
from ..axes import UNIT, direction, orientation
from ..description import (
    Description,
    all_or_nothing,
    children_of,
    claim,
    coordinates_of,
    declare_coordinate,
    names_of,
    varying,
    vector,
)
from ..frame import Frame, Point, closes_loop, own_body
from ..names import is_identifier
from .joint import Joint, Primitive
from .rotor import Rotor, with_inertia

Arguments = ParamSpec("Arguments")


class Ends(NamedTuple):
    """The two bodies of a joint, its point on each, and its axes on each."""

    parent: Any
    child: Any
    at: Any
    to: Any
    parent_axes: Any
    child_axes: Any


def _whole(make: Callable[Arguments, Joint]) -> Callable[Arguments, Joint]:
    """Return a function that makes a joint whole or not at all: a refused joint leaves no coordinates behind."""

    @wraps(make)
    def attempt(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Joint:
        system: Any = args[0]
        with all_or_nothing(system):
            return make(*args, **kwargs)

    return attempt


@_whole
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
    n = direction(system, axis, f"the axis of hinge '{name}'")
    (angle,) = _coordinates(system, child, name, coordinate, [name])
    return _add(system, "hinge", name, Ends(parent, child, at, to, parent_axes, child_axes),
                [Primitive("hinge", n, angle)], {"axis": axis, "coordinate": coordinate}, armature, rotor)  # fmt: skip


@_whole
def slider(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None, axis: Any = "x",
    parent_axes: Any = None, child_axes: Any = None, coordinate: Any = None,
    armature: Expression = 0, rotor: Rotor | None = None,
) -> Joint:  # fmt: skip
    """Add a slider: one displacement ``coordinate`` [m] along ``axis``, without turning. Arguments as :meth:`hinge`."""
    n = direction(system, axis, f"the axis of slider '{name}'")
    (slide,) = _coordinates(system, child, name, coordinate, [name])
    return _add(system, "slider", name, Ends(parent, child, at, to, parent_axes, child_axes),
                [Primitive("slider", n, slide)], {"axis": axis, "coordinate": coordinate}, armature, rotor)  # fmt: skip


@_whole
def cylindrical(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None, axis: Any = "z",
    parent_axes: Any = None, child_axes: Any = None, coordinate: Any = None,
    armature: Any = 0,
) -> Joint:  # fmt: skip
    """Add a displacement along ``axis`` and a turn about it; ``coordinate`` is (displacement, angle)."""
    n = direction(system, axis, f"the axis of cylindrical joint '{name}'")
    slide, turn = _coordinates(system, child, name, coordinate, [f"{name}_slide", f"{name}_turn"])
    return _add(system, "cylindrical", name, Ends(parent, child, at, to, parent_axes, child_axes),
                [Primitive("slider", n, slide), Primitive("hinge", n, turn)],
                {"axis": axis, "coordinate": coordinate}, armature)  # fmt: skip


@_whole
def screw(
    system: Description, name: str, parent: Frame, child: Frame, *, pitch: Expression, at: Any = None, to: Any = None,
    axis: Any = "z", parent_axes: Any = None, child_axes: Any = None, coordinate: Any = None,
    armature: Expression = 0, rotor: Rotor | None = None,
) -> Joint:  # fmt: skip
    """Add a turn by ``coordinate`` [rad] about ``axis`` that advances ``pitch`` [m] per radian along it."""
    n = direction(system, axis, f"the axis of screw '{name}'")
    (turn,) = _coordinates(system, child, name, coordinate, [name])
    advance = system.expression(pitch, f"the pitch of screw '{name}'")
    moving = varying(system, advance)
    if moving:
        raise ModelError(
            f"The pitch of screw '{name}' must be constant, but it depends on {', '.join(moving)}."
        )
    return _add(system, "screw", name, Ends(parent, child, at, to, parent_axes, child_axes),
                [Primitive("screw", n, turn, advance)],
                {"axis": axis, "coordinate": coordinate, "pitch": pitch}, armature, rotor)  # fmt: skip


@_whole
def universal(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None,
    axis: Any = ("x", "y"), parent_axes: Any = None, child_axes: Any = None, coordinate: Any = None,
    armature: Any = 0,
) -> Joint:  # fmt: skip
    """Add two turns: about the first ``axis``, fixed in the parent, then about the second, fixed in the child."""
    if isinstance(axis, str) or not hasattr(axis, "__len__") or len(axis) != 2:
        raise ModelError(
            f"Expected two axes, such as ('x', 'y'), for universal joint '{name}', got {shown(axis)}."
        )
    axes = [direction(system, part, f"the axis of universal joint '{name}'") for part in axis]
    if all(sympy.sympify(component) == 0 for component in cross(*axes)):
        raise ModelError(
            f"The two axes of universal joint '{name}' are parallel: {shown(axis)}. Give two directions, or make a "
            "hinge."
        )
    angles = _coordinates(system, child, name, coordinate, [f"{name}_1", f"{name}_2"])
    return _add(system, "universal", name, Ends(parent, child, at, to, parent_axes, child_axes),
                [Primitive("hinge", n, angle) for n, angle in zip(axes, angles, strict=True)],
                {"axis": axis, "coordinate": coordinate}, armature)  # fmt: skip


@_whole
def gimbal(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None, axis: str = "ZXZ",
    parent_axes: Any = None, child_axes: Any = None, coordinate: Any = None,
    armature: Any = 0,
) -> Joint:  # fmt: skip
    """Add all turns about a point, by three Euler angles in the body-fixed sequence ``axis``, such as "ZXZ"."""
    if not isinstance(axis, str) or len(axis) != 3:
        raise ModelError(
            f"Expected a sequence of three axes, such as 'ZXZ', for gimbal '{name}', got {shown(axis)}."
        )
    if axis.islower():
        raise ModelError(
            f"Gimbal '{name}': lower case '{axis}' means space-fixed axes in SciPy. freebody's sequences are "
            f"body-fixed and in capitals: '{axis[::-1].upper()}' with the angles in reverse order is the same."
        )
    if any(letter not in "XYZ" for letter in axis) or axis[0] == axis[1] or axis[1] == axis[2]:
        raise ModelError(
            f"Gimbal '{name}': '{axis}' is not an Euler sequence; use three of X, Y, Z with neighbours different."
        )
    angles = _coordinates(system, child, name, coordinate, [f"{name}_1", f"{name}_2", f"{name}_3"])
    return _add(system, "gimbal", name, Ends(parent, child, at, to, parent_axes, child_axes),
                [Primitive("hinge", UNIT[letter.lower()], angle) for letter, angle in zip(axis, angles, strict=True)],
                {"axis": axis, "coordinate": coordinate}, armature)  # fmt: skip


@_whole
def planar(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None, axis: Any = "z",
    parent_axes: Any = None, child_axes: Any = None, coordinate: Any = None,
    armature: Any = 0,
) -> Joint:  # fmt: skip
    """Add motion in the plane normal to ``axis``: two displacements and a turn, (x, y, angle) for axis z.

    For axis x the displacements are along y and z, for axis y along z and x. Use ``parent_axes`` for
    any other normal.
    """
    order = {"x": "yz", "y": "zx", "z": "xy"}
    if not isinstance(axis, str) or axis not in order:
        raise ModelError(
            f"Expected 'x', 'y' or 'z' for the normal of planar joint '{name}', got {shown(axis)}. "
            f"Turn the joint by parent_axes for another plane."
        )
    first, second = order[axis][0], order[axis][1]
    a, b, turn = _coordinates(
        system, child, name, coordinate, [f"{name}_{first}", f"{name}_{second}", f"{name}_turn"]
    )
    return _add(system, "planar", name, Ends(parent, child, at, to, parent_axes, child_axes),
                [Primitive("slider", UNIT[first], a), Primitive("slider", UNIT[second], b),
                 Primitive("hinge", UNIT[axis], turn)],
                {"axis": axis, "coordinate": coordinate}, armature)  # fmt: skip


@_whole
def ball(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None,
    parent_axes: Any = None, child_axes: Any = None, coordinate: str | None = None, armature: Any = 0,
) -> Joint:  # fmt: skip
    """Add all turns about a point, by a unit quaternion; no attitude is singular.

    Coordinates ``NAME_e0 … NAME_e3`` (scalar first), speeds ``NAME_wx, NAME_wy, NAME_wz``: the angular
    velocity of the child in the parent, components in the child's joint axes. ``coordinate`` replaces NAME.
    """
    claim(system, name, "joint")
    q: list[Any] = []
    if not closes_loop(system, child):
        q = _components(
            system, name if coordinate is None else coordinate, ["e0", "e1", "e2", "e3"], "coordinate"
        )
        _components(system, name if coordinate is None else coordinate, ["wx", "wy", "wz"], "speed")
    return _add(system, "ball", name, Ends(parent, child, at, to, parent_axes, child_axes),
                [Primitive("ball", coordinate=tuple(q))], {"coordinate": coordinate}, armature)  # fmt: skip


@_whole
def free(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None,
    parent_axes: Any = None, child_axes: Any = None, coordinate: str | None = None, armature: Any = 0,
) -> Joint:  # fmt: skip
    """Add six degrees of freedom.

    Coordinates ``NAME_x, NAME_y, NAME_z`` (position of ``to`` from ``at``, in the parent's joint axes) and the unit
    quaternion ``NAME_e0 … NAME_e3``; speeds ``NAME_wx …`` and ``NAME_vx …``: angular velocity of the child
    and velocity of the point ``to``, both relative to the parent and in the child's joint axes.
    """
    claim(system, name, "joint")
    if closes_loop(system, child):
        raise ModelError(
            f"Free joint '{name}' has no effect, since another joint already holds '{getattr(child, 'name', child)}'. "
            f"Leave it out."
        )
    prefix = name if coordinate is None else coordinate
    q = _components(system, prefix, ["x", "y", "z", "e0", "e1", "e2", "e3"], "coordinate")
    _components(system, prefix, ["wx", "wy", "wz", "vx", "vy", "vz"], "speed")
    return _add(system, "free", name, Ends(parent, child, at, to, parent_axes, child_axes),
                [Primitive("free", coordinate=tuple(q))], {"coordinate": coordinate}, armature)  # fmt: skip


@_whole
def weld(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None,
    parent_axes: Any = None, child_axes: Any = None,
) -> Joint:  # fmt: skip
    """Fix the child to the parent; the joint's reaction has all six components."""
    return _add(
        system, "weld", name, Ends(parent, child, at, to, parent_axes, child_axes), [Primitive("weld")], {}
    )


def _coordinates(
    system: Description, child: Any, name: str, coordinate: Any, defaults: list[str]
) -> list[Any]:
    """Return the displacements of a joint: new coordinates or expressions; None for each if it closes a loop."""
    what = f"the coordinate of joint '{name}'"
    claim(system, name, "joint")
    if closes_loop(system, child):
        if coordinate is not None:
            raise ModelError(
                f"Joint '{name}' closes a loop, since '{getattr(child, 'name', child)}' is already held by an earlier "
                f"joint: its displacement follows from the other coordinates. Leave out coordinate=, or declare this "
                f"joint before the joint that is to close the loop."
            )
        return [None] * len(defaults)
    if coordinate is None:
        arguments = defaults
    elif isinstance(coordinate, str):
        tokens = coordinate.replace(",", " ").split()
        arguments = tokens if len(tokens) > 1 and all(map(is_identifier, tokens)) else [coordinate]
    else:
        arguments = list(coordinate) if isinstance(coordinate, list | tuple) else [coordinate]
    if len(arguments) != len(defaults):
        count = f"{len(defaults)} coordinates" if len(defaults) > 1 else "1 coordinate"
        raise ModelError(
            f"Expected {count} for joint '{name}', got {len(arguments)}: {', '.join(map(str, arguments))}."
        )
    result = []
    for argument in arguments:
        if isinstance(argument, str) and is_identifier(argument.strip()):
            text = argument.strip()
            if text not in names_of(system).kinds:
                result.append(declare_coordinate(system, text))
                continue
            if names_of(system).kinds[text] == "coordinate" and _in_use(system, names_of(system).atoms[text]):
                raise ModelError(
                    f"The coordinate '{text}' is already the displacement of another joint, so joint '{name}' cannot "
                    f"take it by name. Choose a new name; to couple the joints on purpose, pass the expression."
                )
        value = system.expression(argument, what)
        speeds = names_of(system).depends(value, "speed")
        if speeds:
            raise ModelError(
                f"In {what}: a displacement may depend on coordinates, parameters and time, not on {', '.join(speeds)}."
            )
        check_smooth(system, value, what)
        foreign = [
            n for n in names_of(system).depends(value, "coordinate") if n not in coordinates_of(system)
        ]
        if foreign:
            raise ModelError(
                f"In {what}: {', '.join(foreign)} is a component of a ball or free joint; a displacement may depend on "
                f"coordinates of the other joints only. Use a gimbal, or sliders and hinges, to couple joints."
            )
        result.append(value)
    return result


def check_smooth(system: Description, value: Scalar, what: str) -> None:
    """Raise ModelError if a displacement is not twice differentiable, since its reactions would be infinite."""
    rough = names_of(system).rough(value)
    if rough:
        raise ModelError(
            f"In {what}: signal '{rough[0]}' bends or jumps, so its motion would need infinite forces. Use "
            "fb.signal(..., kind='cubic'), which has a velocity and an acceleration (with outside='hold' also "
            "ends='clamped')."
        )


def check_unbroken(system: Description, value: Scalar, what: str) -> None:
    """Raise ModelError if a speed jumps, since its reactions would be infinite."""
    jumps = [
        name
        for name in names_of(system).rough(value)
        if names_of(system).signal_named(name).interpolation == "previous"
    ]
    if jumps:
        raise ModelError(
            f"In {what}: signal '{jumps[0]}' jumps, so its motion would need infinite forces. Use "
            "fb.signal(..., kind='linear') or kind='cubic'."
        )


def _in_use(system: Description, atom: Any) -> bool:
    """Return True if the coordinate is the displacement of a joint."""
    return any(
        primitive.coordinate == atom for joint in system.joints.values() for primitive in joint.primitives
    )


def _components(system: Description, prefix: Any, endings: list[str], kind: str) -> list[Any]:
    if not isinstance(prefix, str) or not prefix:
        raise ModelError(
            f"Expected a prefix (text) for the coordinates of a ball or free joint, got {shown(prefix)}."
        )
    return [names_of(system).component(f"{prefix}_{ending}", kind) for ending in endings]


def _add(
    system: Description,
    kind: str,
    name: str,
    ends: Ends,
    primitives: list[Primitive],
    arguments: dict[str, Any],
    armature: Any = 0,
    rotor: Rotor | None = None,
) -> Joint:
    claim(system, name, "joint")
    what = f"{kind} '{name}'"
    parent, child = own_body(system, ends.parent, what), own_body(system, ends.child, what)
    if parent is child:
        raise ModelError(
            f"{what[0].upper()}{what[1:]} joins body '{parent.name}' to itself. Name two different bodies."
        )
    closes = closes_loop(system, child)
    primitives = with_inertia(system, what, primitives, armature, rotor, closes)
    joint = Joint(
        name, kind, parent, child,
        _place(system, ends.at, parent, f"at= of {what}"), _place(system, ends.to, child, f"to= of {what}"),
        orientation(system, ends.parent_axes, f"parent_axes= of {what}"),
        orientation(system, ends.child_axes, f"child_axes= of {what}"),
        tuple(primitives), {**arguments, "parent_axes": ends.parent_axes, "child_axes": ends.child_axes},
        closes,
    )  # fmt: skip
    system.joints[name] = joint
    children_of(system).add(child.name)
    return joint


def _place(system: Description, place: Any, body: Frame, what: str) -> Vector:
    if place is None:
        return (0, 0, 0)
    if isinstance(place, Point):
        if place.body is not body:
            raise ModelError(f"Expected a point of body '{body.name}' for {what}, got a {place!r}.")
        return place.components
    components = vector(system, place, what)
    for component in components:
        moving = varying(system, component)
        if moving:
            raise ModelError(
                f"The point {what} is fixed in body '{body.name}' and cannot depend on {', '.join(moving)}."
            )
    return components
