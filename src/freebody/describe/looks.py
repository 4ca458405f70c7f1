"""Shape and colour of a body in drawings, if they differ from the solid it was made from."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

from ..errors import ModelError, shown
from ..space.mass import MassProperties
from ..space.shape import Shape

NOTHING = "nothing"
"""Shape of a body that is not drawn: a frame between two joints, which only carries coordinates."""


def solid_of(shape: Any, what: str) -> Shape:
    """Return the shape of a solid.

    Raises
    ------
    ModelError
        If it is not a solid.
    """
    if isinstance(shape, MassProperties):
        shape = shape.shape
    if not isinstance(shape, Shape):
        raise ModelError(
            f"Expected a solid for {what}, such as fb.box(1, (0.4, 0.2, 0.2)), got {shown(shape)}."
        )
    return shape


def drawn_as(mass: MassProperties, shape: Any, color: Any, name: str) -> MassProperties:
    """Return the mass properties with the shape and the colour chosen for drawing.

    Raises
    ------
    ModelError
        A shape that is not a solid, or a colour that is not "#rrggbb".
    """
    if shape is not None:
        hidden = isinstance(shape, str) and shape == NOTHING
        solid = Shape(NOTHING) if hidden else solid_of(shape, f"shape= of body '{name}'")
        parts = tuple(replace(part, look=True) for part in solid.parts)
        mass = replace(mass, shape=replace(solid, look=True, parts=parts))
    if color is not None:
        if not isinstance(color, str) or not re.fullmatch(r"#[0-9A-Fa-f]{6}", color):
            raise ModelError(
                f"Expected a colour such as '#0072B2' for color= of body '{name}', got {shown(color)}."
            )
        # a body without a solid has a shape without parts that holds only the colour
        mass = replace(mass, shape=replace(mass.shape or Shape("compound"), color=color))
    return mass
