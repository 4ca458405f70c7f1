"""Refusal of an initial state in which bodies are inside each other."""

from __future__ import annotations

from collections.abc import Iterable

from ...errors import SimulationError

LISTED = 8
"""Number of contacts that the message names, the deepest first."""


def refuse_overlap(machine: str, gaps: Iterable[tuple[str, float]], near: float, cure: str = "") -> None:
    """Raise SimulationError if gaps (contact, gap [m]) are below ``-near``; the message names all these contacts.

    >>> refuse_overlap("stack", [("low", 0.1), ("high", -0.0)], 1e-9)
    """
    deepest: dict[str, float] = {}  # two bodies may touch in several places
    for name, gap in gaps:
        if gap < -near:
            deepest[name] = max(-gap, deepest.get(name, 0.0))
    if not deepest:
        return
    inside = sorted(deepest.items(), key=lambda pair: -pair[1])
    listed = ", ".join(f"'{name}' {depth:.6g} m deep" for name, depth in inside[:LISTED])
    more = f" and {len(inside) - LISTED} more" if len(inside) > LISTED else ""
    raise SimulationError(
        f"The initial state of '{machine}' has contact{'s' * (len(inside) > 1)} {listed}{more}. "
        f"Begin with every gap at zero or above{cure}."
    )
