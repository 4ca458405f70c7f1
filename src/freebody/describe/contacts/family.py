"""Families of contacts: shapes of many bodies, each of which may touch each other one, with one law for all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...scalar.algebra import Scalar, Vector


@dataclass(frozen=True)
class ContactFamily:
    """A family as the user described it.

    ``shapes`` touch each other, or only those of ``against`` if there are any. The laws are those of a `ContactPair`;
    ``along`` is a direction of the body of each shape of ``against``.
    ``apart`` are pairs of bodies that do not touch.
    """

    name: str
    shapes: tuple[Any, ...]
    against: tuple[Any, ...]
    friction: Scalar
    static_friction: Scalar
    restitution: Scalar
    impact: str = "newton"
    adhesion: Scalar = 0
    rolling: Scalar = 0
    spinning: Scalar = 0
    normal_force: Scalar = None
    friction_across: Scalar = None
    along: Vector | None = None
    apart: tuple[tuple[Any, Any], ...] = ()

    def __repr__(self) -> str:
        return f"family of contacts '{self.name}'"
