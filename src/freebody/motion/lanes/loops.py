"""The compiled loop of an integration method over many lanes (`lanes`, `lanes_wide`)."""

from __future__ import annotations

from ...native.loop import Function, made, module_named
from ..ode.loops import place


def function(method: str, wide: bool) -> Function:
    """Return the compiled loop of a method over lanes, one lane at a time or eight lanes to a vector."""
    name = "lanes_wide" if wide else "lanes"
    package = __name__.partition(".")[2].rpartition(".")[0]
    # the loop over lanes imports the methods by name
    modules = (place(method), f"{package}.{name}", *((f"{package}.{method}_wide",) if wide else ()))
    loop = made(
        f"{method} {name}", modules, (name,), lambda: module_named(f"{package}.{name}").functions(method)
    )
    return loop.functions[name]
