"""All motions of a body: three displacements and all turns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .primitive import Primitive


@dataclass(frozen=True)
class Free(Primitive):
    """Three displacements, a unit quaternion, and six speeds (w, v)."""

    kind: ClassVar[str] = "free"
    n_coordinates: ClassVar[int] = 7
    n_speeds: ClassVar[int] = 6
    turns: ClassVar[bool] = True
    slides: ClassVar[bool] = True
    quaternion: ClassVar[int] = 3
    endings: ClassVar[tuple[str, ...]] = ("x", "y", "z", "e0", "e1", "e2", "e3")
    speed_endings: ClassVar[tuple[str, ...]] = ("wx", "wy", "wz", "vx", "vy", "vz")
