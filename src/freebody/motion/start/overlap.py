"""Refusal of an initial state in which bodies are inside each other."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from ...errors import SimulationError
from ...model.contact import Contact

LISTED = 8
"""Number of contacts that the message names, the deepest first."""


def sides_of(contacts: Iterable[Contact]) -> set[str]:
    """Return the names of the contacts with straight sides, behind which everything counts as inside the body."""
    return {c.name for c in contacts if "side" in (c.feature.look, c.surface.look)}


def refuse_overlap(
    machine: str,
    gaps: Iterable[tuple[str, float]],
    near: float,
    cure: str = "",
    sides: Collection[str] = (),
) -> None:
    """Raise SimulationError if gaps (contact, gap [m]) are below ``-near``; the message names all these contacts.

    ``sides`` are the contacts with straight sides.

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
    behind = ", ".join(f"'{name}'" for name, _ in inside[:LISTED] if name in sides)
    body = (
        f" All that is behind the side of {behind} counts as inside its body. A body that others touch all around is a "
        "solid in a family: s.contacts([body.box(...) or body.hull(...), ...]), with body.sphere(radius) for a disk."
    )
    raise SimulationError(
        f"The initial state of '{machine}' has contact{'s' * (len(inside) > 1)} {listed}{more}. "
        f"Begin with every gap at zero or above{cure}.{body if behind else ''}"
    )
