"""Files of motions, written and read by a room above the trajectory.

A trajectory offers `save` and `load`, but does not know the format: a file also holds what contacts and time steps
add. The package of motions registers the modules that do the work; each is imported when it is first needed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_modules: dict[str, Callable[[], Any]] = {}


def register(name: str, load: Callable[[], Any]) -> None:
    """Register the function that imports the module for ``name``: "save" or "load"."""
    _modules[name] = load


def file_module(name: str) -> Any:
    """Return the module that saves or loads a motion: "save" or "load"."""
    return _modules[name]()
