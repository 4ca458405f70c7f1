"""Codes and limits that the compiled loop and Python share.

Nothing in this file needs a compiler. A run with compiled code on the disk does not load one.
"""

from __future__ import annotations

from ..ending import End

# Status codes that `advance` returns: the numbers of `End`.
RUNNING, FINISHED, TERMINAL, NOT_FINITE = (
    int(end) for end in (End.RUNNING, End.FINISHED, End.TERMINAL, End.NOT_FINITE)
)
COLLAPSED, DIVERGED, STIFF, UNDEFINED, UNRESOLVED, STUCK = (
    int(end) for end in (End.COLLAPSED, End.DIVERGED, End.STIFF, End.UNDEFINED, End.UNRESOLVED, End.STUCK)
)

EXPLICIT: dict[str, int] = {"dop853": 8, "dop54": 5, "tsit5": 5}
"""Explicit methods, which need nothing but the rates, and their orders. A new one is a file, and a place in this
list; a user's own method is a value (`tableau.RungeKutta`)."""
ORDERS = {**EXPLICIT, "radau": 5, "gauss": 16, "structure": 6, "taylor": 16, "crossing": 16}
"""All methods and their orders (`method.Method`); each is the file of its name."""
ITERATED = ("radau", "gauss", "structure")
"""Methods that find the end of a step by iteration."""

SINGLE_STEPS = ("crossing",)
"""Methods whose states between the ends of a step come from the step as a whole."""

MANY_COMPONENTS = 100
"""Size of a state from which a few steps cost more than a look at them."""

MANY = 10_000
"""Number of remaining steps from which a stiff run is stopped: an implicit method is then faster."""
