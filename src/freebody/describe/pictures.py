"""Pictures of descriptions and motions, which a room above draws.

A system or a trajectory shows itself in a notebook, but knows nothing of drawing. The package registers, for each kind
of picture, a function that imports the module that draws it. The module is imported when a picture is needed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_loaders: dict[str, Callable[[], Any]] = {}


def offer(name: str, load: Callable[[], Any]) -> None:
    """Register the function that imports the module of one kind of picture."""
    _loaders[name] = load


def picture(name: str) -> Any:
    """Return the module that makes one kind of picture: "draw", "plots" or "animate"."""
    return _loaders[name]()
