"""Contact modes in which a motion is drawn and its equations are written: the ones that last longest."""

from __future__ import annotations

from typing import Any

from ...symbolic.equations import Equations, equations

MOST = 3
"""Most sets of contact modes that a report shows."""


def lasting(trajectory: Any) -> list[tuple[dict[str, str], float]]:
    """Return the sets of contact modes that lasted longest in a motion, with their durations [s], in order of time.

    Empty for machines without contacts, and for motions of method "timestepping", whose forces are means over steps.
    """
    names = [contact.name for contact in trajectory.kernels.model.contacts]
    segments = getattr(trajectory.path, "segments", ())
    if not names or not segments or not hasattr(trajectory, "modes"):
        return []
    durations: dict[tuple[str, ...], float] = {}
    for segment in segments:
        duration = abs(segment.path.end - segment.path.start)
        durations[segment.modes] = durations.get(segment.modes, 0.0) + duration
    longest = sorted(durations, key=lambda modes: -durations[modes])[:MOST]
    return [
        (dict(zip(names, modes, strict=True)), durations[modes]) for modes in durations if modes in longest
    ]


def longest_contact(trajectory: Any) -> dict[str, str] | None:
    """Return the set of modes, with a contact closed, that lasted longest; None if there is none."""
    sets = [(modes, time) for modes, time in lasting(trajectory) if set(modes.values()) != {"open"}]
    return max(sets, key=lambda pair: pair[1])[0] if sets else None


def most_lasting(e: Equations, trajectory: Any) -> Equations:
    """Return the equations in the modes of :func:`longest_contact`, or ``e`` if there are none."""
    modes = longest_contact(trajectory)
    return e if modes is None else equations(trajectory.kernels.model, modes=modes)


def lasting_place(trajectory: Any) -> dict[str, float]:
    """Return the coordinates at the middle of the longest phase with a contact closed.

    Empty if `lasting` is empty, or if no contact was closed.
    """
    if not lasting(trajectory):
        return {}
    closed = [segment for segment in trajectory.path.segments if set(segment.modes) != {"open"}]
    if not closed:
        return {}
    longest = max(closed, key=lambda segment: abs(segment.path.end - segment.path.start))
    middle = trajectory.at((longest.path.start + longest.path.end) / 2)
    return {name: float(middle[name]) for name in trajectory.kernels.model.coordinate_names}
