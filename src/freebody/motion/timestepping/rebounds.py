"""Energy that compliant contacts give back beyond what they took, since a step acts with one force.

    W = Σ N (g⁺ - g)          from a closing to the next opening;   W = 0 by a law N(d), and W <= 0 by one with a damper

The ledger counts these W as work, so that it is balanced however long the steps are. The law itself tells that they are
too long beside the time of a contact.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...describe.contacts.normal_law import RATE
from ...dynamics.conditions.unilateral import MotionWarning
from ..families.memory import link_poses
from ..families.pair_quantities import pair_quantities
from ..ode.dense_output import Array
from .stepped_kernels import gaps

TOLERATED = 0.01
"""Part of what contacts took by which they may give back more: those of ten steps and more stay below."""


def rebounds(course: Any) -> tuple[MotionWarning, ...]:
    """Return a warning if the compliant contacts of a motion in time steps give back what they did not take."""
    found = [(law, *rebound) for law, works in _works(course) for rebound in _episodes(works)]
    took = sum(float(taken) for _, _, _, taken, _ in found)
    result = []
    for contact in dict.fromkeys(law for law, *_ in found):
        name, conservative = contact
        own = [one[1:] for one in found if one[0] == contact]
        made = sum(work if conservative and over else max(work, 0.0) for _, work, _, over in own)
        if not abs(made) > TOLERATED * took:
            continue
        first, h = float(course.path.times[min(step for step, *_ in own)]), course.stepping.step
        word = "more" if made > 0 else "less"
        result.append(
            MotionWarning(
                name, "energy", first, f"the contact gives back {word} energy than it took", float(made),
                ((first, float(course.path.end)),),
                "A step must be short beside the time of a compliant contact",
                f"Take a step shorter than {h:g} s, or method='auto'.", "J",
            )
        )  # fmt: skip
    return tuple(result)


def _works(course: Any) -> Iterator[tuple[tuple[str, bool], Array]]:
    """Yield each compliant contact and pair, with whether its law is one of the depth alone, and its work by steps.

    Work is nan in steps in which it does not press. Laws that depend on the state and time may give energy.
    """
    model, path, log = course.kernels.model, course.path, course.impulses
    if not len(log.contacts):
        return
    ends = path.states[1:].copy()
    ends[:, : log.corrections.shape[1]] -= log.corrections
    states, times = (
        np.concatenate([path.states[:-1], ends]),
        np.concatenate([path.times[:-1], path.times[1:]]),
    )
    lengths = np.diff(path.times)

    def alone(law: Any) -> bool | None:
        moving = model.names.depends(law, "coordinate", "speed", "time", "signal")
        return None if moving else RATE not in law.free_symbols

    soft = [k for k, c in enumerate(model.contacts) if c.compliant and alone(c.normal_force) is not None]
    if soft:
        seen = course.observed(None, gaps(course.kernels), "gap", times, states)
        opened = seen[len(ends) :] - seen[: len(ends)]
        for k in soft:
            pressed = log.contacts[:, course.layout[0][k]] / lengths
            contact = model.contacts[k]
            yield (
                (contact.name, bool(alone(contact.normal_force))),
                np.where(pressed > 0, pressed * opened[:, k], np.nan),
            )
    first = 0
    for family in model.families:
        law, entries, steps = family.law.normal_force, log.pairs.entries, log.pairs.steps
        if law is not None and alone(law) is not None and len(entries):
            both = entries[:, 10:12].astype(np.int64) - first
            for i, j in np.unique(both[((both >= 0) & (both < len(family.members))).all(axis=1)], axis=0):
                own = np.flatnonzero((both == (i, j)).all(axis=1))
                at = np.concatenate([steps[own], steps[own] + len(ends)])
                poses = course.observed(None, *link_poses(course.kernels), times[at], states[at])
                gap = pair_quantities(
                    course.kernels, course.values, family, (int(i), int(j)), times[at], poses
                )[0]
                work = np.full(len(ends), np.nan)
                work[steps[own]] = entries[own, 0] / lengths[steps[own]] * (gap[len(own) :] - gap[: len(own)])
                yield (family.label(int(i), int(j)), bool(alone(law))), work
        first += len(family.members)


def _episodes(works: Array) -> Iterator[tuple[int, float, float, bool]]:
    """Yield of each time in which a contact presses, and before which it was open: first step, work, what it took, and
    whether it opens again.
    """
    presses = np.concatenate([[False], np.isfinite(works), [False]])
    starts = np.flatnonzero(presses[1:-1] & ~presses[:-2])
    ends = np.flatnonzero(presses[1:-1] & ~presses[2:]) + 1
    for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
        if start > 0:
            total = np.cumsum(works[start:end])
            yield start, float(total[-1]), float(-min(total.min(), 0.0)), end < len(works)
