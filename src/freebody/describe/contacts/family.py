"""Families of contacts: shapes of many bodies, each of which may touch each other one, with one law for all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...scalar.algebra import Scalar


@dataclass(frozen=True)
class ContactFamily:
    """A family as the user described it.

    ``shapes`` touch each other, or only those of ``against`` if there are any. ``friction`` is Coulomb's coefficient,
    ``restitution`` the ratio of the normal speeds in an impact. ``apart`` are pairs of bodies that do not touch.
    """

    name: str
    shapes: tuple[Any, ...]
    against: tuple[Any, ...]
    friction: Scalar
    restitution: Scalar
    apart: tuple[tuple[Any, Any], ...] = ()

    def __repr__(self) -> str:
        return f"family of contacts '{self.name}'"
