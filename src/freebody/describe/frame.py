"""Frames of bodies and the points fixed in them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..errors import ModelError, nearest, shown
from ..scalar.algebra import Vector
from .description import Description, children_of, varying, vector

if TYPE_CHECKING:
    from ..space.mass import MassProperties


@dataclass(frozen=True, eq=False)
class Frame:
    """The frame of a rigid body (origin and axes x, y, z), which carries its mass; the base class of Body."""

    system: Description
    name: str
    mass_properties: MassProperties | None = None

    def point(self, *components: Any) -> Point:
        """Point fixed in the body, components in body axes from the body's origin [m].

        Examples
        --------
        >>> import freebody as fb
        >>> s = fb.System("one bar")
        >>> bar = s.body("bar", fb.slender_bar(1, 2, axis="y"))
        >>> bar.point(0, -1, 0)
        point (0, -1, 0) of bar
        """
        arguments = components[0] if len(components) == 1 else components
        place = vector(self.system, arguments, f"the point of body '{self.name}'")
        for component in place:
            moving = varying(self.system, component)
            if moving:
                raise ModelError(
                    f"A point of body '{self.name}' is fixed in it and cannot depend on {', '.join(moving)}. "
                    f"A point that moves belongs to a body of its own."
                )
        return Point(self, place)

    @property
    def origin(self) -> Point:
        """The body's origin."""
        return Point(self, (0, 0, 0))

    @property
    def center(self) -> Point:
        """The mass centre."""
        if self.mass_properties is None:
            return self.origin
        return self.point(*self.mass_properties.center)

    @property
    def is_ground(self) -> bool:
        """True for the inertial frame."""
        return self.mass_properties is None

    def __repr__(self) -> str:
        return f"body '{self.name}'" if not self.is_ground else "the ground"


@dataclass(frozen=True)
class Point:
    """A point fixed in a body.

    Attributes
    ----------
    body : Body
    components : three expressions [m]
        From the body's origin, in body axes.
    """

    body: Frame
    components: Vector

    def __repr__(self) -> str:
        return f"point ({', '.join(map(str, self.components))}) of {self.body.name}"


def own_body(system: Description, body: Any, what: str) -> Any:
    """Return ``body``, or the body of that name, if it belongs to the system.

    Raises
    ------
    ModelError
        An unknown name, a body of another system, or anything else.
    """
    if isinstance(body, str):
        if body == "ground":
            return system.ground
        if body not in system.bodies:
            raise ModelError(f"Unknown body '{body}' in {what}; {nearest(body, [*system.bodies, 'ground'])}")
        return system.bodies[body]
    if not isinstance(body, Frame):
        raise ModelError(f"Expected a body for {what}, got {shown(body)}.")
    if body.system is not system:
        names = f"'{body.system.name}', not to '{system.name}'"
        names = names if body.system.name != system.name else f"of the same name, '{system.name}'"
        raise ModelError(
            f"{what[0].upper()}{what[1:]}: body '{body.name}' belongs to the system {names}. Both ends must be "
            f"bodies of one system."
        )
    return body


def own_point(system: Description, point: Any, what: str) -> Point:
    """Return ``point``, or the origin of a body, if it belongs to the system.

    Raises
    ------
    ModelError
        A point of another system, or anything else.
    """
    if isinstance(point, Frame):
        point = point.origin
    if not isinstance(point, Point):
        raise ModelError(f"Expected a point, such as bar.point(0, 1, 0), for {what}, got {shown(point)}.")
    own_body(system, point.body, what)
    return point


def closes_loop(system: Description, child: Any) -> bool:
    """Return True if a joint with this child closes a loop: the child is the ground, or already has a joint."""
    if isinstance(child, str):
        return child == "ground" or child in children_of(system)
    if not isinstance(child, Frame):
        return False
    return child.system is system and (child.is_ground or child.name in children_of(system))


def place_in(body: Frame, place: Any, what: str) -> Vector:
    """Return components of a point of the body, given as a point, a body or components; None is the origin.

    Raises
    ------
    ModelError
        A point of another body.
    """
    if place is None:
        return (0, 0, 0)
    if isinstance(place, Frame):
        place = place.origin
    if isinstance(place, Point):
        if place.body is not body:
            raise ModelError(f"Expected a point of {body!r} for {what}, got a {place!r}.")
        return place.components
    return body.point(*vector(body.system, place, what)).components
