"""Pictures of descriptions and of motions, drawn by a room above those that show them.

A system or a trajectory shows itself in a notebook, but knows nothing of drawing. The package offers the modules that
draw, each as a function that imports it, and they are imported when a picture is asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_offered: dict[str, Callable[[], Any]] = {}


def offer(name: str, load: Callable[[], Any]) -> None:
    """Register the function that imports the module of one kind of picture."""
    _offered[name] = load


def picture(name: str) -> Any:
    """Return the module that makes one kind of picture: "draw", "plots" or "animate"."""
    return _offered[name]()
