"""What the kinds of primitive motions can do, for whatever holds the word of one.

Algorithms ask here, and compare no words: a further kind is one more file.
"""

from __future__ import annotations

from .ball import Ball
from .free import Free
from .hinge import Hinge
from .primitive import Primitive
from .screw import Screw
from .slider import Slider
from .weld import Weld

MOTIONS: dict[str, type[Primitive]] = {kind.kind: kind for kind in (Hinge, Slider, Screw, Ball, Free, Weld)}
"""The kinds of primitive motions by their words."""


class Moving:
    """Has a ``kind``: the word of a primitive motion."""

    kind: str

    @property
    def motion(self) -> type[Primitive]:
        """The kind of the motion."""
        return MOTIONS[self.kind]

    @property
    def one_dof(self) -> bool:
        """True if the motion has a displacement."""
        return MOTIONS[self.kind].displaces

    @property
    def turns_only(self) -> bool:
        """True if the displacement is an angle, and nothing slides."""
        motion = MOTIONS[self.kind]
        return motion.displaces and not motion.slides

    @property
    def slides_only(self) -> bool:
        """True if the displacement is a length, and nothing turns."""
        motion = MOTIONS[self.kind]
        return motion.displaces and not motion.turns

    @property
    def advances(self) -> bool:
        """True if the displacement is an angle of a turn that slides along its axis."""
        motion = MOTIONS[self.kind]
        return motion.displaces and motion.turns and motion.slides

    @property
    def fixed(self) -> bool:
        """True if there is no motion."""
        return not (MOTIONS[self.kind].displaces or self.own)

    @property
    def own(self) -> bool:
        """True if the motion has coordinates and speeds of its own, and no displacement."""
        return MOTIONS[self.kind].n_speeds > 0

    @property
    def pivots(self) -> bool:
        """True if the motion is all turns about a point."""
        return self.own and not MOTIONS[self.kind].slides

    @property
    def flies(self) -> bool:
        """True if the motion is all motions of a body."""
        return self.own and MOTIONS[self.kind].slides

    @property
    def n_coordinates(self) -> int:
        """Number of coordinates of its own."""
        return MOTIONS[self.kind].n_coordinates

    @property
    def n_speeds(self) -> int:
        """Number of speeds of its own."""
        return MOTIONS[self.kind].n_speeds
