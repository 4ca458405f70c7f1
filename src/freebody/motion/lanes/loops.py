"""The compiled loop of an integration method over many lanes (`lanes`, `lanes_wide`)."""

from __future__ import annotations

from ...native.loop import Function, made, module_named, sibling
from ..ode.loops import place


def function(method: str, wide: bool) -> Function:
    """Return the compiled loop of a method over lanes, one lane at a time or eight lanes to a vector."""
    name = "lanes_wide" if wide else "lanes"
    lanes = sibling(__name__, name)
    # the loop over lanes imports the methods by name
    modules = (place(method), lanes, *((sibling(__name__, f"{method}_wide"),) if wide else ()))
    loop = made(f"{method} {name}", modules, (name,), lambda: module_named(lanes).functions(method))
    return loop.functions[name]
