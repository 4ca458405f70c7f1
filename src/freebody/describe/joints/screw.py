"""A turn about an axis that advances along it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from .primitive import Primitive


@dataclass(frozen=True)
class Screw(Primitive):
    """One turn by ``coordinate`` [rad] about ``axis`` that advances ``pitch`` [m] per radian; a part of ``s.chain``.

    Examples
    --------
    >>> import freebody as fb
    >>> fb.Screw("z", "turn", pitch="p").pitch
    'p'
    """

    kind: ClassVar[str] = "screw"
    chained: ClassVar[bool] = True
    turns: ClassVar[bool] = True
    slides: ClassVar[bool] = True
    displaces: ClassVar[bool] = True

    pitch: Any = 0
