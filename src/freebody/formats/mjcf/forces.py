"""Tendons, actuators and equalities of an MJCF file."""

from __future__ import annotations

from typing import Any


def add_forces(reader: Any) -> None:
    """Add tendons, actuators and equalities."""
