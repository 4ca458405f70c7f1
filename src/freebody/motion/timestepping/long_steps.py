"""Warnings for steps that are too long: energy that they make, and turns of more than half a turn."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...dynamics.conditions.unilateral import MotionWarning
from ...dynamics.energy import kinetic_energy, potential_energy
from ...dynamics.state import state_at

LOOKS = 33
"""Number of moments of a run at which the energy is checked for an artificial gain."""
CLOSED = 1e-9
"""Safe upper bound on the displacement that removes overlap at the end of a step [m]."""
ROUNDED = 1e-12
"""Relative round-off of the energies."""


def far_turns(course: Any) -> tuple[MotionWarning, ...]:
    """Return a warning for each ball and free joint that turns by more than half a turn in a step.

    A step turns by Cayley's 2 atan(|ω|h/2) < π: energy and momenta stay, the attitude does not follow.
    """
    model, path, h, result = course.kernels.model, course.path, course.stepping.step, []
    longer = np.append(path.lengths, 0.0), np.append(0.0, path.lengths)  # of the steps beside each state
    for link in model.links:
        if not link.own:
            continue
        turns = np.linalg.norm(path.states[:, model.n_q + link.u :][:, :3], axis=1) * np.maximum(*longer)
        far = np.flatnonzero(turns > np.pi)
        if not len(far):
            continue
        first, most, end = float(path.times[far[0]]), float(turns.max()), float(path.end)
        result.append(
            MotionWarning(
                link.joint, "turns", first, f"'{link.joint}' turns by more than half a turn in a step", most,
                ((first, end),), "The attitude follows turns that are short beside that",
                f"Take a step shorter than {h / most:.3g} s, or method='auto'.", "rad",
            )
        )  # fmt: skip
    return tuple(result)


def made_energy(course: Any) -> tuple[MotionWarning, ...]:
    """Return a warning if the steps make energy: (T + V) - (T₀ + V₀) - W > T₀ + (range of V) + |W| at a checked moment.

    Springs that are too stiff for the step do this: kh²/m > 4 for one spring, which is a limit of any explicit
    force, and so does the removal of deep overlap. Terms of the speeds cannot: they act with the mean speeds of a
    step.
    """
    path, model = course.path, course.kernels.model
    driven = any(link.driven for link in model.links)  # a drive supplies any energy its motion needs
    if driven or not len(course.impulses.works):
        return ()
    work = np.concatenate([[[0.0, 0.0]], np.cumsum(course.impulses.works, axis=0)])
    work[:, 0] += course.intervals.work_until(np.minimum(np.arange(len(work)), len(work) - 2))
    some = np.unique(np.linspace(0, min(len(path.states), len(work)) - 1, LOOKS).astype(int))
    energies = []
    for k in some.tolist():
        try:
            energies.append(_energies(course, k))
        except (ArithmeticError, ValueError):  # the potential has no value there, or overflows
            break
    if not energies:
        return ()
    some = some[: len(energies)]
    T, V = np.array(energies).T
    with np.errstate(over="ignore", invalid="ignore"):
        made = T + V - T[0] - V[0] - work[some].sum(axis=1)
        had = T[0] + np.maximum.accumulate(V) - np.minimum.accumulate(V) + np.abs(work[some, 1])
        log = course.impulses.pairs
        pairs = np.bincount(log.steps, np.abs(log.entries[:, :3]).sum(axis=1), minlength=len(log))
        forces = (np.abs(course.impulses.contacts).sum(axis=1) + pairs) / path.lengths
        pressed = np.concatenate([[0], np.cumsum(forces)])
        height = np.maximum.accumulate(np.abs(V))
        had += CLOSED * pressed[some] + ROUNDED * height  # removing overlap also does work
        bad = np.flatnonzero(~(made <= had))
    if not len(bad):
        return ()
    first, h, end = some[bad[0]], course.stepping.step, float(path.end)
    cure = f"Take a step shorter than {h:g} s, or method='auto'."
    when = float(path.times[first])
    worst = float(np.nan_to_num(made[bad], nan=np.inf).max())
    return (
        MotionWarning(
            model.name, "energy", when, "the steps make energy", worst, ((when, end),), "A step can make none",
            cure, "J",
        ),
    )  # fmt: skip


def _energies(course: Any, k: int) -> tuple[float, float]:
    """Return kinetic energy and potential energy after k steps."""
    model, path = course.kernels.model, course.path
    numbers = course.intervals.numbers(course.kernels, min(k, len(path.lengths) - 1))
    state = state_at(model, path.states[k], float(path.times[k]), numbers)
    return float(kinetic_energy(model, state)), float(potential_energy(model, state))
