"""The battery of a method of integration."""

from __future__ import annotations

from typing import Any


def check_method(method: Any) -> None:
    """To come."""
