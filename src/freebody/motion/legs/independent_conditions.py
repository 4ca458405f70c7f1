"""Independent conditions that change during a run.

A run of a machine with redundant conditions keeps the conditions that are independent at its start. Later in the motion
the selected conditions may become dependent although the full set is not: in a loop in space that turns over, each
direction does so once in a turn. Other conditions then take over, and the motion goes on unchanged.

    G_d = C G_a        rows of the dropped and of the active conditions, each in units of its kind (`alike`)

A dropped condition is C times as inaccurate as the active ones. A run is interrupted at the first state with an entry
of C beyond LOOSE. The two conditions of the largest entry change places, which makes the volume of G_a larger by that
factor, until no entry is large. If all conditions together become dependent, C stays small: there the machine itself
locks, or could branch.

Source: S. A. Goreinov, E. E. Tyrtyshnikov, N. L. Zamarashkin, A theory of pseudoskeleton approximations, Linear Algebra
and its Applications 261 (1997) 1-21 (of a submatrix of greatest volume no entry of C is larger than 1).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, cast

import numpy as np

from ...dynamics.conditions.constrained import DEPENDENT, condition_groups
from ...dynamics.conditions.constraints import rows
from ...errors import SimulationError
from ..ending import End
from ..kernels.kernels import Kernels
from ..kernels.redundant_conditions import LOOSE
from ..ode.dense_output import Array, Path, Rates, cut, observe, projected
from ..ode.integration import Halt, first_halt
from ..trajectory.event import Happening
from ..trajectory.phases import Phases, Segment, segments_of
from ..trajectory.trajectory import Trajectory
from .branch import Crossing

LARGE = 2.0
"""Entries of C above which conditions change places, once an entry is beyond LOOSE."""
DRIFTED = 1e-6
"""Residual beyond which a condition that was dropped as redundant does not follow from the others."""


class Holding:
    """The active conditions of a machine during a run.

    ``initial``      programs with the conditions that are active at the start
    ``current``      programs with the conditions that are active now
    ``happenings``   changes of the conditions, in order
    """

    def __init__(self, kernels: Kernels, finest: float | None = None, method: str = "auto") -> None:
        self.initial = self.current = kernels
        self.happenings: list[Happening] = []
        self.crossing = Crossing(finest, method) if finest is not None and kernels.active else None

    @property
    def finer(self) -> float:
        """Part of the tolerance that ordinary steps keep."""
        return 1.0 if self.crossing is None else self.crossing.finer

    @property
    def longest(self) -> float:
        """Length that ordinary steps do not exceed."""
        return np.inf if self.crossing is None else self.crossing.longest

    def path(
        self, leg: Callable[..., Path | Phases], parameters: Array, rates: Rates, y: Array, start: float, until: float,
        work: float = 0.0, watched: bool = True,
    ) -> Path | Phases:  # fmt: skip
        """Return the path from a state, in segments if conditions have changed.

        Parameters
        ----------
        leg              (kernels, rates, state, start, end, halt, method) -> Path, or Phases where laws switch
        rates            right-hand side with the conditions that were active at the start
        work             work of blows until now
        watched          True if the leg looks for events
        """
        crossing = self.crossing
        if not (self.initial.active and (self.initial.dropped or crossing)):
            return leg(self.current, rates, y, start, until, None)
        segments: list[Segment] = []
        while True:
            kernels = self.current
            current = rates if kernels is self.initial else kernels.rates(parameters)
            change = self._halt(parameters, current)
            near = None if crossing is None else crossing.halt(kernels, current)
            longest = self.longest
            *before, last = segments_of(
                leg(kernels, current, y, start, until, first_halt(near, change)), kernels, work
            )
            segments += before
            part = last.path
            if crossing is not None and crossing.ahead is not None and part.status == End.RELEASED:
                parts, happenings = crossing.across(leg, kernels, parameters, current, part, until, watched)
                segments += [Segment(path, kernels, work) for path in parts]
                self.happenings += happenings
                start, y = parts[-1].end, parts[-1].states[-1]
                if parts[-1].status not in (End.RELEASED, End.FINISHED) or start == until:
                    break
                continue
            if part.steps or not self.longest < longest:
                segments.append(Segment(part, kernels, work))
            if part.status != End.RELEASED:
                break
            if self.longest < longest:  # the same steps again, but shorter ones
                start, y = part.end, part.states[-1]
                continue
            start, y = part.end, self._changed(parameters, part.end, part.states[-1])
        if self.current is self.initial and len(segments) == 1:
            return part
        return Phases(tuple(segments), segments[-1].path.status)

    def _halt(self, parameters: Array, rates: Rates) -> Halt | None:
        """Return a function that stops the run at the first state in which other conditions should take over."""
        kernels = self.current
        count = 2 * len(kernels.dropped) + 1
        if count == 1:
            return None
        address = kernels.motion().address("dropped")

        def first(times: Array, states: Array) -> tuple[int, End, int] | None:
            loose = observe(address, count, times, states, rates.constants)[:, -1]
            for k in np.flatnonzero(~(loose <= 0)):
                if taking_over(kernels, parameters, times[k], states[k]) != kernels.active:
                    return int(k), End.RELEASED, 0
            return None

        return first

    def _changed(self, parameters: Array, t: float, y: Array) -> Array:
        """Let other conditions take over; return the state moved onto them."""
        model, old = self.current.model, self.current.active
        new = taking_over(self.current, parameters, t, y)
        self.current = self.current.holding(new)
        after = projected(self.current.rates(parameters), t, y)
        names = [row.name for row in rows(model)]
        lost, gained = (
            " and ".join(names[i] for i in these if i not in those)
            for these, those in ((old, new), (new, old))
        )
        text = f"{gained} holds the machine in place of {lost}"
        self.happenings.append(Happening.between(self.current.names, t, gained, (y, after), text))
        return after


def taking_over(kernels: Kernels, parameters: Array, t: float, y: Array) -> tuple[int, ...]:
    """Return the conditions to use from a state on: the active ones, unless others are much better conditioned."""
    m, n, active = len(kernels.on_speeds), kernels.model.n_u, list(kernels.active)
    program = kernels.closing()
    state = y[None, : kernels.model.n_q + n]
    outputs = program.observed("motion", np.array([t]), state, program.constants(parameters))[0]
    G = program.matrix(outputs)
    if len(active) == m or not np.isfinite(G).all():
        return kernels.active
    for group in condition_groups(kernels.model):
        size = np.linalg.norm(G[group])
        G[group] /= size if size > 0 else 1.0
    least = float(LOOSE)
    for _ in range(m):
        others = [i for i in range(m) if i not in active]
        C = np.linalg.lstsq(G[active].T, G[others].T, rcond=DEPENDENT)[0]
        j, d = np.unravel_index(np.argmax(np.abs(C)), C.shape)
        if abs(C[j, d]) <= least:
            break
        active[j], least = others[d], LARGE
    return tuple(sorted(active))


def check_redundant(trajectory: Trajectory) -> None:
    """Check that conditions that were redundant at the start of a segment hold along the whole motion.

    Raises
    ------
    SimulationError
        They do not: the start was a singular position, where the machine could have gone either way. The motion until
        then is ``error.trajectory``.
    """
    path = cast(Any, trajectory.path)
    parts = segments_of(path, trajectory.kernels)
    for i, segment in enumerate(parts):
        kernels, part = segment.kernels, segment.path
        names = kernels.dropped
        if not names:
            continue
        address, count = kernels.motion().address("dropped"), 2 * len(names) + 1
        missed = np.abs(observe(address, count, part.times, part.states, part.rates.constants)[:, :-1])
        missed /= 1 + np.abs(part.states).max(axis=1, keepdims=True)
        late = np.flatnonzero((missed > DRIFTED).any(axis=1))
        if not len(late):
            continue
        k = int(late[0])
        short = cut(part, k, End.CONTRADICTED)
        whole = Phases((*parts[:i], replace(segment, path=short)), End.CONTRADICTED)
        trajectory.path = cast(Any, whole) if isinstance(path, Phases) else short
        error = SimulationError(
            f"The constraint '{names[int(missed[k].argmax()) // 2]}' of '{kernels.model.name}' followed from the "
            f"others at the start, but at t = {part.times[k]:.6g} s it does not. The start is a singular position, "
            "such as bars in line, from which the machine can move in more ways than elsewhere. Start beside it."
        )
        error.trajectory = trajectory  # type: ignore[attr-defined]
        raise error
