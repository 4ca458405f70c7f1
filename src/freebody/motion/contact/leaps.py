"""Slip in space at speed zero, where it has no direction: its first and last moments, as straight steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...dynamics import coordinate_rates
from ...dynamics.state import float_state
from ...errors import SimulationError
from ..ending import End
from ..ode.dense_output import Array, Path, Rates, outputs_at, projected
from ..phase.places import STOPPED
from ..phase.scene import Modes, Phase, Snapshot, at_limit
from ..trajectory.phases import Segment
from .complementarity import OPEN, SLIP, SMALL, STICK, Solution
from .modes import modes_at
from .state import NUDGE, ContactRun

LONGEST = 1e-6
"""Greatest length of a straight step [s]; a slip that would take longer to begin, or longer than a contact needs to
return, is nudged."""


@dataclass(eq=False)
class Leap(Path):
    """One straight step, so short that double precision does not resolve its curvature."""

    curved = False

    def sample(self, times: Any, dense: bool = False) -> Array:
        """Return the states at ``times`` on the straight line between the two ends of the step."""
        del dense
        wanted = np.atleast_1d(np.asarray(times, dtype=float))
        length = self.times[-1] - self.times[0]
        x = (wanted - self.times[0]) / length if length > 0 else np.zeros_like(wanted)
        return self.states[0] + x[:, None] * (self.states[-1] - self.states[0])


def onset(
    work: ContactRun, t: float, y: Array, modes: Modes, one: Solution | None, seen: Snapshot, end: float,
    longest: float = LONGEST,
) -> Any:  # fmt: skip
    """Return time and state after the first moment of a slip in space that begins at rest.

    This moment is a straight step of at most ``longest`` that gives the slip a direction. Without such a slip, both are
    unchanged.
    """
    starting = _starting(work, modes, seen, y)
    if not starting or one is None:
        return t, y
    chosen = _chosen(work, t, y, seen)
    rows = [
        i
        for k in chosen
        for i in range(work.scene.first[k], work.scene.first[k] + 1 + work.scene.tangents[k])
    ]
    udot = seen.free + one.forces @ seen.responses[rows]
    pull = min(
        float(
            np.linalg.norm(
                (seen.matrix @ (one.forces @ seen.responses[rows]) + seen.c)[work.scene.first[k] + 1 :][:2]
            )
        )
        for k in starting
    )
    if pull <= SMALL * (float(np.abs(seen.c).max(initial=0)) + 1e-300) or pull * longest < 4 * STOPPED:
        after, fits = nudged(work, y, modes, starting, chosen, one, seen)
        return t, after if fits else y
    step = min(max(4 * STOPPED / pull, 1e-9), end - t)
    y_after = y.copy()
    y_after[work.n : work.n + work.n_u] += step * udot

    middle = (work.u(y) + work.u(y_after)) / 2
    state = float_state(work.model, y[: work.n].tolist(), middle.tolist(), t, work.values)
    y_after[: work.n] += step * np.array([float(x) for x in coordinate_rates(work.model, state)])
    return leap(work, t, y, t + step, y_after, modes)


def nudged(
    work: ContactRun, y: Array, modes: Modes, starting: Sequence[int], chosen: Sequence[int], one: Solution,
    seen: Snapshot,
) -> tuple[Array, bool]:  # fmt: skip
    """Return the state in which a slip that begins without acceleration has a direction, with the speed :data:`NUDGE`,
    and False if sticking contacts prevent that slip.
    """
    rows, wanted = [], []
    for k, (mode, d) in zip(chosen, one.modes, strict=True):
        if mode == OPEN:
            continue
        at, n = work.scene.first[k], work.scene.tangents[k]
        rows.append(at)
        wanted.append(0.0)
        if mode == STICK or k in starting:
            rows += range(at + 1, at + 1 + n)
            wanted += [NUDGE * x for x in d] if k in starting else [0.0] * n
    A, goal = seen.between(rows), np.array(wanted)
    impulses = np.linalg.lstsq(A, goal, rcond=SMALL)[0]
    loose = not work.shared and len(starting) > 1 and work.loose_forces(modes, frozenset(), seen)[rows].any()
    fits = not loose and np.abs(A @ impulses - goal).max(initial=0) <= 1e-3 * NUDGE
    after = y.copy()
    after[work.n : work.n + work.n_u] += impulses @ seen.responses[rows]
    return after, bool(fits)


def held(work: ContactRun, t: float, y: Array, modes: Modes, one: Solution | None, seen: Snapshot) -> Modes:
    """Return the modes in which a contact whose slip would begin, but that the others hold at rest, is at its limit.

    Its friction stays at μ_s N, and the others share what is left: the path of equal compliance. The slip begins when
    all that can hold it have reached their limits.

    Raises
    ------
    SimulationError
        If indeterminate forces are refused.
    """
    starting = _starting(work, modes, seen, y)
    if not starting or one is None:
        return modes
    chosen = _chosen(work, t, y, seen)
    rows = [work.scene.first[k] + j for k in chosen for j in range(1 + work.scene.tangents[k])]
    a = seen.matrix @ (one.forces @ seen.responses[rows]) + seen.c
    still = SMALL * float(np.abs(seen.c).max(initial=0))
    if any(float(np.linalg.norm(a[work.scene.first[k] + 1 :][:2])) > still for k in starting):
        return modes
    if nudged(work, y, modes, starting, chosen, one, seen)[1]:
        return modes
    if not work.shared:
        names = ", ".join(f"'{work.names[k]}'" for k in chosen if modes[k] != OPEN)
        raise SimulationError(
            f"Contacts {names} at t = {t:.9g} s are statically indeterminate: friction, shared in proportion to N, "
            f"has reached μ_s N, and the motion does not determine the shares beyond that. Rest the "
            f"body on fewer contacts, describe it in its plane of motion, or use method='timestepping'."
        )
    directions = {k: d for k, (_, d) in zip(chosen, one.modes, strict=True)}
    return tuple(at_limit(directions[k]) if k in starting else mode for k, mode in enumerate(modes))


def _starting(work: ContactRun, modes: Modes, seen: Snapshot, y: Array) -> list[int]:
    """Return the contacts in space whose slip begins at rest."""
    return [
        k
        for k, mode in enumerate(modes)
        if mode == SLIP
        and work.scene.tangents[k] == 2
        and not work.model.contacts[k].frictionless
        and work.speed(seen, k) <= work.still(y)
    ]


def _chosen(work: ContactRun, t: float, y: Array, seen: Snapshot) -> list[int]:
    """Return the closed contacts that do not leave."""
    return [k for k in work.closed(t, seen, y) if seen.rate[work.scene.first[k]] <= work.still(y)]


def leap(
    work: ContactRun, t: float, y: Array, t_after: float, y_after: Array, modes: Modes
) -> tuple[float, Array]:
    """Record a straight step to the given state in the run and return its final time and state."""
    phase, rates, _, _ = work.setup(modes, y_after, work.look(t_after, y_after))
    if phase.active:
        y_after = projected(rates, t_after, y_after)
    path = Leap(
        rates,
        np.array([t, t_after]),
        np.array([t_after - t]),
        np.array([y, y_after]),
        (),
        End.FINISHED,
        0,
        0,
        0,
    )
    work.segments.append(Segment(path, phase, work.impulses, phase.shown, phase.loose))
    return t_after, y_after


def fading(
    work: ContactRun, phase: Phase, rates: Rates, t: float, y: Array, modes: Modes
) -> tuple[float, Array]:
    """Return time and state after the end of a slip in space that begins below :data:`STOPPED` and slows.

    Its speed does not pass the end of slips, and the direction turns at rates of 1/speed. Without such a slip, both are
    unchanged.
    """
    seen, first = work.look(t, y), work.scene.first
    slow = [
        k
        for k, mode in enumerate(modes)
        if mode == SLIP
        and work.scene.tangents[k] == 2
        and not work.smooth(seen, k)
        and work.still(y) < work.speed(seen, k) <= STOPPED
    ]
    if not slow:
        return t, y
    a = work.along(phase, "acceleration", t, y)
    for k in slow:
        if work.slip(seen, k) @ a[first[k] + 1 : first[k] + 3] < 0:
            return halt(work, phase, rates, k, t, y, modes)
    return t, y


def halt(
    work: ContactRun, phase: Phase, rates: Rates, k: int, t: float, y: Array, modes: Modes
) -> tuple[float, Array]:
    """Return time and state at the end of a slip in space whose speed has fallen to :data:`STOPPED`.

    A straight step leads to this end.
    """
    m, at = work.scene.rows, work.scene.first[k]
    rate = work.along(phase, "rate", t, y)[at + 1 : at + 3]
    a = work.along(phase, "acceleration", t, y)[at + 1 : at + 3]
    speed = float(np.linalg.norm(rate))
    if not speed > 0:
        return t, y
    slowing = -float(rate @ a) / speed

    def stopped(t: float, y: Array, contacts: Sequence[int]) -> tuple[Array, float]:
        """Return the state after impulses that cancel the remaining slip, and their work; closed contacts stay so."""
        seen = work.look(t, y)
        first = work.scene.first
        rows = [i for j in contacts for i in (first[j] + 1, first[j] + 2)]
        rows += [first[j] for j, mode in enumerate(modes) if mode != OPEN]
        impulses = np.zeros(m)
        impulses[rows] = np.linalg.lstsq(seen.between(rows), -seen.rate[rows], rcond=SMALL)[0]
        result = y.copy()
        result[work.n : work.n + work.n_u] += impulses @ seen.responses
        return result, work.gained(t, y, seen, impulses)

    if not slowing > 0:  # it turns as it slows: a new slip begins, or it sticks
        after, gained = stopped(t, y, [k])
        work.impulses += gained
        return t, after
    step = speed / slowing
    if step > LONGEST:
        # hardly slowing: it stops if the contact then sticks; otherwise the slip has only just begun
        after, gained = stopped(t, y, [k])
        if modes_at(work, t, after, modes)[0][k] != STICK:
            return t, y
        work.impulses += gained
        return t, after
    f = outputs_at(rates.address, rates.size, t, y, rates.constants)
    after = y + step * f
    before, then = work.look(t, y), work.look(t + step, after)
    together = [k]  # a body that turns as it stops comes to rest at all its contacts at once
    for j, mode in enumerate(modes):
        if (
            j != k
            and mode == SLIP
            and work.scene.tangents[j] == 2
            and not work.model.contacts[j].frictionless
        ):
            was, left = (work.speed(one, j) for one in (before, then))
            if was <= 100 * STOPPED and left <= was / 10:
                together.append(j)
    # the slip that remains after a straight step is of second order in its length
    after, gained = stopped(t + step, after, together)
    work.impulses += gained
    path = Leap(
        rates, np.array([t, t + step]), np.array([step]), np.array([y, after]), (), End.FINISHED, 0, 0, 0
    )
    work.segments.append(Segment(path, phase, work.impulses, phase.shown, phase.loose))
    return t + step, after
