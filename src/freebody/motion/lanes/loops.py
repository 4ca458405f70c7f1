"""The compiled loop of an integration method over many lanes (`lanes`)."""

from __future__ import annotations

from ...native.loop import Function, made, module_named, sibling
from ..ode.loops import label, place


def function(method: str, lanes: int) -> Function:
    """Return the compiled loop of a method over lanes, one at a time or so many side by side."""
    name = sibling(__name__, "lanes")
    loop = made(
        f"{label(method)} lanes {lanes}", (place(method), name), ("lanes",),  # the loop imports the methods by name
        lambda: module_named(name).functions(method), lanes,
    )  # fmt: skip
    return loop.functions["lanes"]
