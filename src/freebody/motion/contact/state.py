"""Data of one run with contacts: its compiled memory, and what Python decides or keeps of it."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..events.code import code
from ..events.event_run import EventRun
from ..kernels.contact_quantities import asked_by
from ..kernels.kernels import Kernels
from ..kernels.program import at_state
from ..kernels.sides import sided_kernels
from ..legs.blow import Blow, call_of
from ..legs.driven import Drives
from ..ode.dense_output import Array, outputs_at
from ..phase.candidates.candidates import stretch_numbers
from ..phase.scene import Scene, Snapshot, scene_of
from ..request import Problem
from ..trajectory.event import EventSpec, expressions_of
from .memory import Memory, Watched, memory_of
from .patches import Patches

CHOICES = ("compliance", "refuse")
"""Values of ``indeterminate``: treatment of a motion that depends on the distribution of indeterminate forces."""


class Entry(NamedTuple):
    """An entry of the log: its kind, integers and real numbers."""

    kind: int
    marks: Any
    numbers: Any


class ContactRun:
    """One run of a machine with contacts. See :func:`run`.

    ``specs``      events of the user, ``asked`` of them, then those that call for blows
    ``blows``, ``called``, ``counts``    blows at given times, those of events, and how often these may still act
    ``method``, ``relative``, ``absolute``    method and tolerances of the steps
    ``memory``     its records; ``it``: that of the compiled loop. A finished run has given it back
    ``told``       happenings of blows, ``struck``, that Python adds to the log
    ``shared``     True if indeterminate forces are those of equal compliance
    ``drives``     signals and controllers, or None
    ``changes``    number of a phase, and the parameters that hold from there
    ``changed_at`` time and state of each of these that a signal or controller makes, by its number
    ``patches``    patches of solids, or None
    """

    specs: tuple[EventSpec, ...]
    asked: int
    method: str
    blows: list[tuple[float, Blow]]
    called: tuple[Blow, ...]
    counts: list[float]
    relative: Array
    absolute: Array

    def __init__(
        self,
        kernels: Kernels,
        values: Mapping[str, float],
        scene: Scene | None = None,
        watched: Watched | None = None,
        sided: bool = False,
    ) -> None:
        """Make a run ready to go with the functions that it watches, or, without any, for the modes of a state.

        With ``sided`` laws of loads that switch have sides.
        """
        self.kernels, self.values, self.model = kernels, values, kernels.model
        self.scene = scene_of(sided_kernels(kernels) if sided else kernels) if scene is None else scene
        self.parameters = kernels.parameters(values)
        self._begun = values
        self.names = [c.name for c in self.model.contacts]
        self.n, self.n_u = self.model.n_q, self.model.n_u
        self.shared = True
        self.drives: Drives | None = None
        self.changes: list[tuple[int, Array]] = []
        self.changed_at: dict[int, tuple[float, Array]] = {}
        self.told: list[Any] = []
        self.struck: list[Blow] = []
        patches = Patches(kernels, values) if self.model.patches else None
        self.patches, self.watched = patches, watched
        if watched is None:
            self.memory = Memory(kernels, self.scene, patches)
        else:
            self.memory = memory_of(kernels, self.scene, watched, self.parameters, patches)
        self.it: EventRun = self.memory.it

    @classmethod
    def of(
        cls,
        problem: Problem,
        relative: Array,
        absolute: Array,
        blows: Sequence[tuple[float, Blow]] = (),
        called: Sequence[Blow] = (),
        sided: bool = True,
    ) -> ContactRun:
        """Return the run of a problem, with blows at given times and those that events call for."""
        request, kernels = problem.request, problem.kernels
        calls = tuple(call_of(one) for one in called)  # events that trigger a blow, after those of the user
        specs, drives = (*problem.specs, *calls), None
        if kernels.model.switched:
            drives = Drives(kernels, problem.numbers, problem.begin, problem.end, problem.most_steps)
        watched = Watched(
            "dop853" if request.method == "auto" else request.method,
            (*problem.expressions, *expressions_of(kernels.model, calls)),
            tuple(spec.direction for spec in specs),
            tuple(spec.terminal for spec in specs),
            len(problem.specs),
            () if drives is None else drives.sensed,
        )
        self = cls(kernels, problem.numbers, watched=watched, sided=sided)
        self.specs, self.asked, self.method = specs, watched.asked, watched.method
        self.shared = request.indeterminate == "compliance"
        self.blows, self.called = list(blows), tuple(called)
        self.counts = [math.inf if one.times is None else one.times for one in called]
        self.relative, self.absolute = relative, absolute
        it, steps = self.it, self.memory.steps
        it.refuse, it.sequential = not self.shared, request.impacts == "sequential"
        it.longest, it.steps_left = request.longest_step, problem.most_steps
        steps.relative[:], steps.absolute[:] = relative, absolute
        if self.memory.laws is not None:
            self.memory.laws.relative[:] = relative
            code("forget_sides")(it, problem.begin, problem.end)
        steps.stop_if_stiff = int(request.method == "auto")
        self.drives = drives
        if drives is not None:
            drives.touched = self.touched
            self.changes.append((0, self.parameters))
        return self

    def give_back(self) -> None:
        """Give the memory of a finished run back. What its history asks for later is in memory of its own."""
        if self.watched is not None:
            self.memory.give_back(self.watched)

    def set_values(self, values: Mapping[str, float]) -> None:
        """Go on with other values of the parameters."""
        if self.patches is not None and self.patches.values is not values:
            self.patches.set_values(values)
            values = self.patches.values
        self.values, self.parameters = values, self.kernels.parameters(values)
        self.memory.set_parameters(self.parameters)
        self.changes.append((self.it.phases, self.parameters))

    @cached_property
    def ratios(self) -> Array:
        """Ratios of the friction along the second tangents, at the values of the start (`candidates.stretches`)."""
        return stretch_numbers(self.model, self._begun)

    def parameters_of(self, phase: int) -> Array | None:
        """Return the parameters of a phase by its number, if they change during the run."""
        k = bisect_right(self.changes, phase, key=lambda change: change[0])
        return self.changes[k - 1][1] if k else None

    def touched(self) -> dict[Any, float]:
        """Return the quantities of contacts that functions of the user take, in the present phase."""
        memory = self.memory
        asked = asked_by((*memory.watching.expressions, *memory.watching.sensed))
        self.watch(np.array(self.it.y))
        place, _, (size,) = memory.program.data.placed["inputs"]
        return dict(zip(asked, memory.phase[place + size - len(asked) : place + size].tolist(), strict=True))

    def watch(self, y: Array) -> Array:
        """Return the functions of the user's events, and of those that call blows."""
        memory = self.memory
        return at_state(memory.program, "watched", self.it.t, y, memory.phase)[: len(self.specs)]

    def next_stop(self) -> float:
        """Return the time of the next blow or change of values."""
        change = math.inf if self.drives is None else self.drives.until()
        return min(change, self.blows[0][0]) if self.blows else change

    def energies(self, t: float, y: Array) -> Array:
        """Return the kinetic and the potential energy at a state."""
        return outputs_at(self.it.energy, 2, t, y, self.memory.energy)

    # -- the moment --------------------------------------------------------------------------------

    def look(self, t: float, y: Array, parameters: Array | None = None) -> Snapshot:
        """Return the contacts at a moment of the run, or, after it too, with given values of the parameters."""
        constants = self.memory.looking if parameters is None else self.scene.constants(parameters)
        return self.scene.at(t, y, constants)

    def seen(self) -> Snapshot:
        """Return the contacts at the present moment."""
        return self.scene.snapshot(np.array(self.it.seen))

    def chosen(self) -> list[int]:
        """Return the contacts that take part in the problem of the present moment."""
        return list(self.it.chosen[: self.it.count].tolist())

    def slip(self, seen: Snapshot, k: int) -> Array:
        """Return the slip velocity of a contact along its tangents [m/s]."""
        at = self.scene.first[k]
        return seen.rate[at + 1 : at + 1 + self.scene.tangents[k]]

    def smooth(self, seen: Snapshot, k: int) -> bool:
        """Return True if the coefficients of friction are zero in this run."""
        return bool(seen.friction[k] == seen.static[k] == 0)
