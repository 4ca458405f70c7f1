"""Bodies."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import arguments_named
from .frame import Frame
from .shapes.circle import circle
from .shapes.corners import corners
from .shapes.cylinder import cylinder
from .shapes.drum import drum
from .shapes.ellipsoid import ellipsoid
from .shapes.heightline import heightline
from .shapes.plane import plane
from .shapes.segment import segment
from .shapes.solid import box, capsule, hull
from .shapes.sphere import sphere


@arguments_named
@dataclass(frozen=True, eq=False, repr=False)
class Body(Frame):
    """A rigid body: a frame (origin and axes x, y, z) that carries mass.

    Made by :meth:`System.body`; the ground of a system is a body without mass properties.

    Attributes
    ----------
    system : System
    name : str
    mass_properties : MassProperties or None
        Mass, mass centre and inertia; None for the ground.
    """

    sphere = sphere
    box = box
    capsule = capsule
    hull = hull
    ellipsoid = ellipsoid
    circle = circle
    cylinder = cylinder
    drum = drum
    plane = plane
    segment = segment
    corners = corners
    heightline = heightline
