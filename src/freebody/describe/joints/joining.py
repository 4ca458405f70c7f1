"""What every joint needs when it is described: its two ends, its coordinates, its place in the system."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any, NamedTuple, ParamSpec

from ...errors import ModelError, shown
from ...scalar.algebra import Scalar, Vector
from ..axes import orientation
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
from .joint import Joint
from .primitive import Primitive
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


def whole(make: Callable[Arguments, Joint]) -> Callable[Arguments, Joint]:
    """Return a function that makes a joint whole or not at all: a refused joint leaves no coordinates behind."""

    @wraps(make)
    def attempt(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Joint:
        system: Any = args[0]
        with all_or_nothing(system):
            return make(*args, **kwargs)

    return attempt


def own_coordinates(
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


def components_of(system: Description, prefix: Any, endings: list[str], kind: str) -> list[Any]:
    """Declare the components of a ball or free joint, and return their atoms."""
    if not isinstance(prefix, str) or not prefix:
        raise ModelError(
            f"Expected a prefix (text) for the coordinates of a ball or free joint, got {shown(prefix)}."
        )
    return [names_of(system).component(f"{prefix}_{ending}", kind) for ending in endings]


def add_joint(
    system: Description,
    kind: str,
    name: str,
    ends: Ends,
    primitives: Sequence[Primitive],
    arguments: dict[str, Any],
    armature: Any = 0,
    rotor: Rotor | None = None,
) -> Joint:
    """Add a joint to the system, checked, and return it."""
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
        place_on(system, ends.at, parent, f"at= of {what}"), place_on(system, ends.to, child, f"to= of {what}"),
        orientation(system, ends.parent_axes, f"parent_axes= of {what}"),
        orientation(system, ends.child_axes, f"child_axes= of {what}"),
        tuple(primitives), {**arguments, "parent_axes": ends.parent_axes, "child_axes": ends.child_axes},
        closes,
    )  # fmt: skip
    system.joints[name] = joint
    children_of(system).add(child.name)
    return joint


def place_on(system: Description, place: Any, body: Frame, what: str) -> Vector:
    """Return the components of a point fixed in a body; None is its origin."""
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
