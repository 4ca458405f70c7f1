"""A displacement along an axis, without turning."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .primitive import Primitive


@dataclass(frozen=True)
class Slider(Primitive):
    """One displacement ``coordinate`` [m] along ``axis``; a part of ``s.chain``.

    Examples
    --------
    >>> import freebody as fb
    >>> fb.Slider("x", "reach").turns
    False
    """

    kind: ClassVar[str] = "slider"
    chained: ClassVar[bool] = True
    slides: ClassVar[bool] = True
    displaces: ClassVar[bool] = True
