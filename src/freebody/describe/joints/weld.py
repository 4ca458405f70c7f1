"""No motion: the child is fixed to the parent."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .primitive import Primitive


@dataclass(frozen=True)
class Weld(Primitive):
    """No motion."""

    kind: ClassVar[str] = "weld"
