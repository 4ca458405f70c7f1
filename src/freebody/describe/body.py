"""Bodies and the points fixed in them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..errors import ModelError
from . import shapes as _shapes

if TYPE_CHECKING:
    from ..space.mass import MassProperties
    from .system import System


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body: a frame (origin and axes x, y, z) that carries mass.

    Made by :meth:`System.body`; the ground of a system is a body without mass properties.
    """

    system: System
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
        given = components[0] if len(components) == 1 else components
        vector = self.system.vector(given, f"the point of body '{self.name}'")
        for component in vector:
            moving = self.system.names.depends(component, "coordinate", "speed", "time")
            if moving:
                raise ModelError(
                    f"A point of body '{self.name}' is fixed in it and can not depend on {', '.join(moving)}. "
                    f"A point that moves belongs to a body of its own."
                )
        return Point(self, vector)

    # -- shapes to touch with: one function each in `shapes` ---------------------------------------

    sphere = _shapes.sphere
    ellipsoid = _shapes.ellipsoid
    circle = _shapes.circle
    cylinder = _shapes.cylinder
    plane = _shapes.plane
    segment = _shapes.segment
    corners = _shapes.corners
    heightline = _shapes.heightline

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
        """Whether this is the inertial frame."""
        return self.mass_properties is None

    def __repr__(self) -> str:
        return f"body '{self.name}'" if not self.is_ground else "the ground"


@dataclass(frozen=True)
class Point:
    """A point fixed in a body: components from the body's origin, in body axes [m]."""

    body: Body
    components: tuple[Any, Any, Any]

    def __repr__(self) -> str:
        return f"point ({', '.join(map(str, self.components))}) of {self.body.name}"
