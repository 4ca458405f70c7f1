"""Changes of mode of the contacts of a motion in time steps, and its happenings, each at the beginning of its step."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..contact.course import Change, shown
from ..trajectory.event import Happening
from .pair_motion import MODES


def changes(course: Any) -> list[tuple[int, int, Change]]:
    """Return (step, contact, change) of every mode, in the order of their beginnings."""
    times, modes = course.path.times, course.impulses.modes
    if not len(modes):
        return []
    found = []
    for e, contact in enumerate(course.kernels.model.contacts):
        begins = [0, *(np.flatnonzero(np.diff(modes[:, e])) + 1).tolist()]
        for k, end in zip(begins, [*begins[1:], len(modes)], strict=True):
            why = "the start" if k == 0 else _why(course, k, e)
            mode = contact.shown(MODES[modes[k, e]])
            change = Change(contact.name, mode, float(times[k]), float(times[end]), why)
            found.append((k, e, change))
    return sorted(found, key=lambda one: one[:2])


def _why(course: Any, step: int, e: int) -> str:
    """Return why a contact has another mode from a step on."""
    before, now = (MODES[course.impulses.modes[k, e]] for k in (step - 1, step))
    if before == "open":
        return "the gap closed"
    contact = course.kernels.model.contacts[e]
    if now == "open":
        return "N reached 0" if contact.adhesion == 0 else "N reached the adhesion"
    if now == "stick":
        return "the slip stopped"
    if before != "stick":
        return "the slip turned round"
    at = course.layout[0][e]
    if contact.friction_across is not None:
        return "T reached its ellipse"
    T = course.impulses.contacts[step, at + 1 : at + 1 + course.layout[1][e]] / course.path.lengths[step]
    unit = contact.units["tangential"]
    return f"|T| reached {float(np.linalg.norm(T)):.6g} {unit}"


def happenings(course: Any) -> tuple[Happening, ...]:
    """Return blows and changes of mode in order of time, each at the beginning of its step."""
    model, path = course.kernels.model, course.path
    found: list[tuple[int, int, str, str]] = []
    for step, blows in course.impulses.blows.items():
        speeds = path.states[step : step + 2, model.n_q :].T.tolist()
        jumps = ", ".join(
            f"{name} {before:.6g} → {after:.6g}"
            for name, (before, after) in zip(model.speed_names, speeds, strict=True)
            if before != after
        )
        found += [(step, -1, name, f"{name}: {jumps or 'no speed changes'}") for name, _ in blows]
    last: dict[int, str] = {}
    for step, e, change in course.changes:
        if step > 0:
            text = f"contact {change.contact}: {shown(last[e])} → {shown(change.mode)}, {change.why}"
            found.append((step, e, change.contact, text))
        last[e] = change.mode
    return tuple(
        Happening.between(
            model.state_names, float(path.times[step]), name, (path.states[step], path.states[step + 1]), text
        )
        for step, _, name, text in sorted(found, key=lambda one: one[:2])
    )
