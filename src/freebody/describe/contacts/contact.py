"""Contacts: pairs of shapes that may touch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...scalar.algebra import Scalar, Vector


@dataclass(frozen=True)
class ContactPair:
    """A contact as the user described it: two shapes that may touch, and the laws of friction and impact.

    ``friction`` is the coefficient while slipping, ``static_friction`` while sticking; ``impact`` is
    "newton" if ``restitution`` is the ratio of speeds, "poisson" if it is the ratio of impulses. ``normal_force`` is
    that of a compliant contact, None for a rigid one. ``friction_across`` is the coefficient at right angles to the
    direction ``along`` of the surface's body, None if one holds for all directions; ``adhesion`` is the pull that the
    contact bears; ``rolling`` and ``spinning`` are lengths whose product with the normal force bounds the moments that
    resist these.
    """

    name: str
    feature: Any
    surface: Any
    friction: Scalar
    static_friction: Scalar
    restitution: Scalar
    impact: str
    normal_force: Scalar = None
    friction_across: Scalar = None
    along: Vector | None = None
    adhesion: Scalar = 0
    rolling: Scalar = 0
    spinning: Scalar = 0

    @property
    def parts(self) -> tuple[str, str]:
        """What touches what, in words."""
        feature, surface = (f"{shape.kind} of {shape.body.name}" for shape in (self.feature, self.surface))
        return feature, surface

    def __repr__(self) -> str:
        return f"contact '{self.name}'"
