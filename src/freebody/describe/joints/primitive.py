"""Primitive motions, of which chains every joint consists; one file for each kind.

A kind says how many coordinates and speeds of its own it has, whether it turns and whether it slides. A motion with
one displacement y (hinge, slider, screw) has none of its own: y is an expression of the machine's coordinates and time.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

from .rotor import Rotor


@dataclass(frozen=True)
class Primitive:
    """One elementary motion; the base class of Hinge, Slider, Screw, Ball, Free and Weld.

    Parameters
    ----------
    axis : 'x', 'y', 'z' or three components
        Direction in joint axes.
    coordinate : str or expression, optional
        Displacement; for ball and free, the tuple of the joint's own coordinates.
    at : three components, optional
        Anchor: a point of the axis, from the joint's point, in joint axes with all coordinates zero [m].
    armature : expression, optional
        Inertia that the motion's speed alone moves; in a joint, a tuple with an entry for each speed, or none.
    rotor : Rotor, optional
        Rotor of a motor in the parent, behind a gear.
    """

    kind: ClassVar[str] = ""
    """Word for the kind."""
    chained: ClassVar[bool] = False
    """True if it may stand in a chain with others."""
    n_coordinates: ClassVar[int] = 0
    """Coordinates of its own."""
    n_speeds: ClassVar[int] = 0
    """Speeds of its own."""
    turns: ClassVar[bool] = False
    slides: ClassVar[bool] = False
    displaces: ClassVar[bool] = False
    """True if the motion has one displacement along an axis."""
    quaternion: ClassVar[int] = -1
    """Place of its unit quaternion among its coordinates; -1 if it has none."""

    endings: ClassVar[tuple[str, ...]] = ()
    """Endings of the names of its own coordinates."""
    speed_endings: ClassVar[tuple[str, ...]] = ()
    """Endings of the names of its own speeds."""

    axis: Any = (0, 0, 0)
    coordinate: Any = None
    at: Any = None
    armature: Any = ()
    rotor: Rotor | None = None
    pitch: Any = field(default=0, init=False)
