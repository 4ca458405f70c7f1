"""A turn about an axis by an angle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .primitive import Primitive


@dataclass(frozen=True)
class Hinge(Primitive):
    """One turn about ``axis`` by the angle ``coordinate`` [rad]; a part of ``s.chain``.

    Examples
    --------
    >>> import freebody as fb
    >>> fb.Hinge("z", "yaw", at=(0, 1, 0)).turns
    True
    """

    kind: ClassVar[str] = "hinge"
    chained: ClassVar[bool] = True
    turns: ClassVar[bool] = True
    displaces: ClassVar[bool] = True
