"""Modules of rooms above, for values that show or save themselves, and for requests that rooms above answer.

A system or a trajectory draws itself in a notebook, and a trajectory saves itself, but both know nothing of drawings or
of files of motions; the list of the ways to a motion names the batch, which keeps
studies; a program exports itself with the loop that moves it. The package registers, for
each kind of work, a function that imports the module that does it. The module is imported when it is first needed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_loaders: dict[str, Callable[[], Any]] = {}


def offer(work: str, load: Callable[[], Any]) -> None:
    """Register the function that imports the module for one kind of work."""
    _loaders[work] = load


def module_for(work: str) -> Any:
    """Return the module for one kind of work: "draw", "plots", "animate", "save", "load", "batch" or "wasm"."""
    return _loaders[work]()
