"""What every joint needs when it joins a system: its coordinates, and its point on each body."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NoReturn

from ...errors import ModelError, shown
from ...scalar.algebra import Scalar, Vector
from ..description import Description, coordinates_of, declare_coordinate, names_of, varying, vector
from ..frame import Frame, Point, closes_loop
from ..names import is_identifier


def own_coordinates(
    system: Description, joint: Any, defaults: list[str], own: Sequence[bool] = ()
) -> list[Any]:
    """Return the displacements of a joint: new coordinates or expressions; None for each if it closes a loop.

    Motions with coordinates of their ``own`` have a prefix in place of a displacement.
    """
    name, child, coordinate = joint.name, joint.child, joint.coordinate
    if closes_loop(system, child):
        if coordinate is not None:
            refuse_coordinate(joint)
        return [None] * len(defaults)
    arguments = defaults if coordinate is None else _arguments(coordinate, own)
    if len(arguments) != len(defaults):
        count = "1 coordinate" if len(defaults) == 1 else f"{len(defaults)} coordinates"
        raise ModelError(
            f"Expected {count} for joint '{name}', got {len(arguments)}: {', '.join(map(str, arguments))}."
        )
    result = []
    for k, argument in enumerate(arguments):
        prefix = own[k] if own else False
        result.append(argument if prefix else displacement(system, name, argument))
    return result


def _arguments(coordinate: Any, own: Sequence[bool]) -> list[Any]:
    """Return the coordinates that a joint is given, one for each motion."""
    if isinstance(coordinate, str):
        tokens = coordinate.replace(",", " ").split()
        return tokens if len(tokens) > 1 and all(map(is_identifier, tokens)) else [coordinate]
    several = isinstance(coordinate, list | tuple) and (len(own) != 1 or not own[0])
    return list(coordinate) if several else [coordinate]


def refuse_coordinate(joint: Any) -> NoReturn:
    """Refuse a coordinate of a joint that closes a loop."""
    raise ModelError(
        f"Joint '{joint.name}' closes a loop, since '{joint.child.name}' is already held by an earlier "
        f"joint: its displacement follows from the other coordinates. Leave out coordinate=, or declare this "
        f"joint before the joint that is to close the loop."
    )


def displacement(system: Description, name: str, argument: Any) -> Any:
    """Return the displacement of one motion of a joint: a new coordinate, or an expression."""
    what = f"the coordinate of joint '{name}'"
    if isinstance(argument, str) and is_identifier(argument.strip()):
        text = argument.strip()
        if text not in names_of(system).kinds:
            return declare_coordinate(system, text)
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
    foreign = [n for n in names_of(system).depends(value, "coordinate") if n not in coordinates_of(system)]
    if foreign:
        raise ModelError(
            f"In {what}: {', '.join(foreign)} is a component of a ball or free joint; a displacement may depend on "
            f"coordinates of the other joints only. Use a gimbal, or sliders and hinges, to couple joints."
        )
    return value


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
