"""Which modes of contacts a motion is drawn and written in: those that last longest."""

from __future__ import annotations

from typing import Any

from ...symbolic.equations import Equations, equations

MOST = 3
"""Sets of modes that a report shows."""


def lasting(trajectory: Any) -> list[tuple[dict[str, str], float]]:
    """The sets of modes of a motion that lasted longest, with how long [s], in the order in which they began.

    Empty for machines without contacts, and for motions of method "timestepping", whose forces are means over steps.
    """
    names = [contact.name for contact in trajectory.kernels.model.contacts]
    segments = getattr(trajectory.path, "segments", ())
    if not names or not segments or not hasattr(trajectory, "modes"):
        return []
    found: dict[tuple[str, ...], float] = {}
    for one in segments:
        found[one.modes] = found.get(one.modes, 0.0) + abs(one.path.end - one.path.start)
    kept = sorted(found, key=lambda modes: -found[modes])[:MOST]
    return [(dict(zip(names, modes, strict=True)), found[modes]) for modes in found if modes in kept]


def most_lasting(e: Equations, trajectory: Any) -> Equations:
    """The equations in the modes in which a motion was longest with a contact closed, or those given."""
    sets = [(modes, time) for modes, time in lasting(trajectory) if set(modes.values()) != {"open"}]
    if not sets:
        return e
    modes, _ = max(sets, key=lambda one: one[1])
    return equations(trajectory.kernels.model, modes=modes)


def lasting_place(trajectory: Any) -> dict[str, float]:
    """Coordinates in the middle of the longest time for which a motion had a contact closed, on its contacts.

    Empty where `lasting` is, and where no contact was closed.
    """
    if not lasting(trajectory):
        return {}
    closed = [one for one in trajectory.path.segments if set(one.modes) != {"open"}]
    if not closed:
        return {}
    longest = max(closed, key=lambda one: abs(one.path.end - one.path.start))
    there = trajectory.at((longest.path.start + longest.path.end) / 2)
    return {name: float(there[name]) for name in trajectory.kernels.model.coordinate_names}
