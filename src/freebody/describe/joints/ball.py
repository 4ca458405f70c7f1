"""All turns about a point, by a unit quaternion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .primitive import Primitive


@dataclass(frozen=True)
class Ball(Primitive):
    """All turns about the point, by a unit quaternion and three speeds w."""

    kind: ClassVar[str] = "ball"
    chained: ClassVar[bool] = True
    n_coordinates: ClassVar[int] = 4
    n_speeds: ClassVar[int] = 3
    turns: ClassVar[bool] = True
    quaternion: ClassVar[int] = 0
    endings: ClassVar[tuple[str, ...]] = ("e0", "e1", "e2", "e3")
    speed_endings: ClassVar[tuple[str, ...]] = ("wx", "wy", "wz")
