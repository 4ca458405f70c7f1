"""Independent conditions that change on the way.

Of a machine with redundant conditions a run keeps those that are independent at its start. Further on they may come to
lose their hold where all conditions together do not: in a loop in space that turns over, each direction does once in a
turn. There others take over; the machine moves on as it did.

    G_d = C G_a        rows of what is left out, of those that hold, each in units of its kind (`alike`)

A dropped condition is C times as inaccurate as those that hold. A run is interrupted at the first state with an entry
of C beyond LOOSE, and the two conditions that belong to the largest change places, which makes the volume of G_a larger
by that factor, until no entry is large. Where all conditions lose their hold together, C stays small: there the machine
itself locks, or could branch.

Source: S. A. Goreinov, E. E. Tyrtyshnikov, N. L. Zamarashkin, A theory of pseudoskeleton approximations, Linear Algebra
and its Applications 261 (1997) 1-21 (of a submatrix of greatest volume no entry of C is larger than 1).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, cast

import numpy as np

from ...dynamics.constrained import DEPENDENT, condition_groups
from ...dynamics.constraints import rows
from ...errors import SimulationError
from ..kernels.kernels import LOOSE, Kernels
from ..ode.dense_output import CONTRADICTED, FINISHED, RELEASED, Array, Path, Rates, cut, observe, projected
from ..ode.integration import Halt, first_halt
from ..trajectory.event import Happening
from ..trajectory.phases import Phases, Segment, parts_of
from ..trajectory.trajectory import Trajectory
from .branch import Crossing

LARGE = 2.0
"""Entries of C from which conditions change places, once one is beyond LOOSE."""
DRIFTED = 1e-6
"""Residual beyond which a condition left out as redundant is seen not to follow from the others."""


class Holding:
    """The conditions that hold a machine in the course of a run.

    ``told``     what changed, in its order
    """

    def __init__(self, kernels: Kernels, finest: float | None = None) -> None:
        self.begun = self.now = kernels
        self.told: list[Happening] = []
        self.crossing = Crossing(finest) if finest is not None and kernels.active else None

    def path(
        self, leg: Callable[..., Path], parameters: Array, rates: Rates, y: Array, start: float, until: float,
        work: float = 0.0,
    ) -> Path | Phases:  # fmt: skip
        """The path from a state, in segments if conditions have changed.

        Parameters
        ----------
        leg              (kernels, rates, state, from, to, halt, method) -> Path
        rates            of the conditions that the run began with
        work             that blows have done until now
        """
        crossing = self.crossing
        if not (self.begun.active and (self.begun.dropped or crossing)):
            return leg(self.now, rates, y, start, until, None)
        segments: list[Segment] = []
        while True:
            kernels = self.now
            here = rates if kernels is self.begun else kernels.rates(parameters)
            change = self._halt(parameters, here)
            near = None if crossing is None else crossing.halt(kernels, here)
            part = leg(kernels, here, y, start, until, first_halt(near, change))
            if crossing is not None and crossing.ahead is not None and part.status == RELEASED:
                parts, told = crossing.across(leg, kernels, parameters, here, part, until)
                segments += [Segment(one, kernels, work) for one in parts]
                self.told += told
                start, y = parts[-1].end, parts[-1].states[-1]
                if parts[-1].status not in (RELEASED, FINISHED) or start == until:
                    break
                continue
            segments.append(Segment(part, kernels, work))
            if part.status != RELEASED:
                break
            start, y = part.end, self._changed(parameters, part.end, part.states[-1])
        if self.now is self.begun and len(segments) == 1:
            return part
        return Phases(tuple(segments), segments[-1].path.status)

    def _halt(self, parameters: Array, rates: Rates) -> Halt | None:
        """Of times and states: the first at which other conditions hold better, if there is one."""
        kernels = self.now
        count = 2 * len(kernels.dropped) + 1
        if count == 1:
            return None
        address = kernels.motion().address("dropped")

        def first(times: Array, states: Array) -> tuple[int, str, int] | None:
            loose = observe(address, count, times, states, rates.constants)[:, -1]
            for k in np.flatnonzero(~(loose <= 0)):
                if taking_over(kernels, parameters, times[k], states[k]) != kernels.active:
                    return int(k), RELEASED, 0
            return None

        return first

    def _changed(self, parameters: Array, t: float, y: Array) -> Array:
        """The state on the conditions that take over."""
        model, old = self.now.model, self.now.active
        new = taking_over(self.now, parameters, t, y)
        self.now = self.now.holding(new)
        after = projected(self.now.rates(parameters), t, y)
        names = [row.name for row in rows(model)]
        lost, gained = (
            " and ".join(names[i] for i in some if i not in rest) for some, rest in ((old, new), (new, old))
        )
        states = [dict(zip(self.now.names, x.tolist(), strict=False)) for x in (y, after)]
        text = f"{gained} holds the machine in place of {lost}"
        self.told.append(Happening(t, gained, 0, states[0], text, states[1]))
        return after


def taking_over(kernels: Kernels, parameters: Array, t: float, y: Array) -> tuple[int, ...]:
    """The conditions that hold a machine from a state on; those in use if they hold well, or none does better."""
    m, n, active = len(kernels.on_speeds), kernels.model.n_u, list(kernels.active)
    program = kernels.closing()
    state = y[: kernels.model.n_q + n]
    found = observe(
        program.address("motion"),
        m + m * n + n * n,
        np.array([t]),
        state[None],
        program.constants(parameters),
    )[0]
    G = found[m : m + m * n].reshape(m, n)
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
    """Conditions that were redundant at the start of a segment must hold along the whole motion.

    Raises
    ------
    SimulationError
        They do not: the start was a singular position, where the machine could have gone either way. The motion until
        then is ``error.trajectory``.
    """
    path = cast(Any, trajectory.path)
    parts = parts_of(path, trajectory.kernels)
    for i, segment in enumerate(parts):
        held, part = segment.kernels, segment.path
        names = held.dropped
        if not names:
            continue
        address, count = held.motion().address("dropped"), 2 * len(names) + 1
        missed = np.abs(observe(address, count, part.times, part.states, part.rates.constants)[:, :-1])
        missed /= 1 + np.abs(part.states).max(axis=1, keepdims=True)
        late = np.flatnonzero((missed > DRIFTED).any(axis=1))
        if not len(late):
            continue
        k = int(late[0])
        short = cut(part, k, CONTRADICTED)
        whole = Phases((*parts[:i], replace(segment, path=short)), CONTRADICTED)
        trajectory.path = cast(Any, whole) if isinstance(path, Phases) else short
        error = SimulationError(
            f"The constraint '{names[int(missed[k].argmax()) // 2]}' of '{held.model.name}' followed from the others "
            f"at the start, but at t = {part.times[k]:.6g} s it does not. The start is a singular position, such as "
            "bars in line, from which the machine can move in more ways than elsewhere. Start a little beside it."
        )
        error.trajectory = trajectory  # type: ignore[attr-defined]
        raise error
