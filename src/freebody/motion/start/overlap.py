"""Bodies inside each other: refused in an initial state, and told of where one comes around a side in the motion."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from itertools import pairwise
from typing import Any

import numpy as np

from ...dynamics.conditions.unilateral import MotionWarning
from ...errors import SimulationError
from ...model.contact import Contact

LISTED = 8
"""Number of contacts that the message names, the deepest first."""
DEEP = 1e-8
"""Depth [m] that is no round-off of a gap."""
INSIDE = "counts as inside its body"
SOLID = (
    "A body that others touch all around is a solid in a family: s.contacts([body.box(...) or body.hull(...), ...]), "
    "with body.sphere(radius) for a disk."
)


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
    body = f" All that is behind the side of {behind} {INSIDE}. {SOLID}"
    raise SimulationError(
        f"The initial state of '{machine}' has contact{'s' * (len(inside) > 1)} {listed}{more}. "
        f"Begin with every gap at zero or above{cure}.{body if behind else ''}"
    )


def behind_sides(motion: Any) -> Iterator[MotionWarning]:
    """Yield a warning for each contact of a straight side that is open and deep at some output times of a motion.

    A foot that leaves a side at its end may come around it. Nothing touches a side from behind.
    """
    times = motion.t
    for name in sorted(sides_of(motion.kernels.model.contacts)):
        gap, mode = motion.contacts[name].gap, motion.contacts[name].mode
        deep = (gap < -DEEP) & (mode == "open")
        edges = np.flatnonzero(np.diff(deep, prepend=False, append=False))
        if edges.size:
            spans = tuple((float(times[a]), float(times[b - 1])) for a, b in list(pairwise(edges))[::2])
            yield MotionWarning(
                name, "overlap", spans[0][0], "comes behind the side", float(gap[deep].min()), spans,
                f"All that is there {INSIDE}", SOLID, "m",
            )  # fmt: skip
