"""What a motion with contacts must obey at every moment of each of its phases, whatever computed it."""

from __future__ import annotations

from typing import Any

import numpy as np

import freebody as fb
from freebody.motion.start.initial import number
from freebody.motion.trajectory.trajectory import Trajectory

DEPTH = 1e-9
"""Greatest gap of a closed rigid contact, and slip of one that sticks, of machines of about 1 m and 1 m/s."""
ROUNDED = 1e-6
"""Error of forces relative to the greatest one of a moment."""
DIRECTED = 1e-5
"""Slip above which the direction of friction is compared: slips below end and begin in straight steps [m/s]."""
STEPS = (2e-3, 1e-3, 5e-4)
SCATTER = 5.0
"""By how much more than the results of three steps differ among themselves the last may differ from the limit.

Of a method of first order it is once the difference of the last two; errors of impacts have any sign, and sizes up to
h v.
"""


def steps_come_to(motion: Any, system: Any, start: Any, names: Any) -> bool:
    """Return True if motions in time steps come to the end of a motion by events, in these coordinates."""
    limit, ends = np.array([motion[name][-1] for name in names]), []
    for h in STEPS:
        steps = fb.simulate(system, motion.t[-1], initial=start, method="timestepping", step=h)
        ends.append(np.array([steps[name][-1] for name in names]))
    scatter = max(np.abs(a - b).max() for a in ends for b in ends)
    # a motion that all three have alike is off by round-off, h² and what events leave of slips
    return bool(np.abs(ends[-1] - limit).max() <= SCATTER * scatter + STEPS[-1] ** 2)


def moments(motion: Any, most: int) -> Any:
    """Return times inside all phases: so many a second, and at least one of each."""
    times = []
    for segment in motion.path.segments:
        a, b = segment.path.start, segment.path.end
        if b - a > 1e-12 and getattr(
            segment.path, "curved", True
        ):  # a straight step begins or ends without direction
            count = int(np.clip((b - a) * most, 3, most))
            times.append(a + (b - a) * (np.arange(count) + 0.5) / count)
    return np.concatenate(times)


def sampled(motion: Any, times: Any) -> Any:
    """Return the motion at other output times."""
    return Trajectory(
        motion.kernels,
        motion.numbers,
        motion.path,
        motion.specs,
        motion.tolerances,
        times,
        course=motion.course,
    )


def violations(motion: Any, kinetic: Any) -> list[str]:
    """Return what a motion violates: of gaps, forces, cones, stick and slip.

    ``kinetic`` has coefficients of friction along both tangents at a slip speed, by the name of a contact.
    """
    result, contacts = [], motion.contacts
    largest = np.max([np.abs(one.least).max(axis=1) for one in contacts.values()], axis=0)
    small = ROUNDED * (1e-3 + largest)
    for described in motion.kernels.model.contacts:
        one = contacts[described.name]
        N, T = one.least[:, 0], one.least[:, 1:]
        pull = number(motion.kernels.model, motion.numbers, described.adhesion, "an adhesion")
        slip = one.slip.reshape(T.shape)
        opened, sticks = one.mode == "open", one.mode == "stick"
        loose = np.isnan(one.normal) | np.isnan(one.tangential.reshape(T.shape)).any(axis=1)
        slides = ~opened & ~sticks & (np.linalg.norm(slip, axis=1) > DIRECTED)
        touches = not (described.compliant or described.loaded or described.held)
        found = {
            "pulls": np.where(loose, 0, -N - pull) - small,
            "has forces while open": np.where(opened, np.abs(one.least).max(axis=1), 0) - small,
            "sticks beyond its cone": np.where(sticks & ~loose, -one.least_margin, 0) - small,
            "slips while it sticks": np.where(sticks, np.abs(slip).max(axis=1, initial=0), 0) - DEPTH,
            "gains": np.where(opened, 0, (T * slip).sum(axis=1)) - small * DIRECTED,
        }
        if touches:
            found["is deep"] = np.where(opened, -one.gap, np.abs(one.gap)) - DEPTH
        law = kinetic.get(described.name) or kinetic.get(described.name.rpartition("_")[0])
        if law is not None and T.shape[1]:
            mu = np.array(np.broadcast_arrays(*law(np.linalg.norm(slip, axis=1)), N)[: T.shape[1]]).T
            along = mu**2 * slip
            power = np.linalg.norm(mu * slip, axis=1, keepdims=True)
            expected = -along * N[:, None] / np.where(power > 0, power, 1)
            found["has other friction"] = np.where(slides, np.abs(T - expected).max(axis=1), 0) - small
        for what, excess in found.items():
            if excess.max() > 0:
                k = int(np.argmax(excess))
                t, bad = motion.t[k], int((excess > 0).sum())
                result.append(
                    f"{described.name} {what} by {excess[k]:.3g} at t = {t:.12g} s, {bad} of {len(excess)}"
                )
    return result
