"""Bodies."""

from __future__ import annotations

from dataclasses import dataclass

from . import body_shapes as _shapes
from .frame import Frame


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

    sphere = _shapes.sphere
    ellipsoid = _shapes.ellipsoid
    circle = _shapes.circle
    cylinder = _shapes.cylinder
    plane = _shapes.plane
    segment = _shapes.segment
    corners = _shapes.corners
    heightline = _shapes.heightline
