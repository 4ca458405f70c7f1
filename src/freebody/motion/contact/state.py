"""Data of one run with contacts: its compiled memory, and what Python decides or keeps of it."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..cones.collision import compiled_code
from ..cones.contacts import contacts_room
from ..events.event_run import PIECE, EventRun, event_run
from ..kernels.kernels import Kernels
from ..legs.blow import Blow, call_of
from ..legs.driven import Drives
from ..ode import loops
from ..ode.dense_output import Array, Rates
from ..ode.run import Run, equip, memory, most_events
from ..phase.scene import Phase, Scene, functions, scene_of
from ..phase.snapshot import Snapshot
from ..request import Problem
from ..trajectory.event import expressions_of
from .patches import Patches

CHOICES = ("compliance", "refuse")
"""Values of ``indeterminate``: treatment of a motion that depends on the distribution of indeterminate forces."""
KERNELS = {
    "looked": "looked", "rates_at": "rate", "rates": "rates", "projection": "projection",
    "accelerations": "acceleration", "forces": "force", "watched": "watched",
}  # fmt: skip
"""Functions of `phase_kernels` and its kin that the loop calls."""
IMPLICIT = "radau"
"""Method of the steps where the friction of a slow slip in space is stiff."""
AT_ONCE = 300
"""Number of rows up to which the contact problem has room for all of them from the start."""
LOG = 1 << 12
"""First number of rows of the log."""


def _piece(method: str) -> int:
    """Return the address of the compiled steps of a method."""
    address: int = loops.functions(method).functions["piece"].address
    return address


class ContactRun:
    """One run of a machine with contacts. See :func:`run`.

    ``it``         memory of the compiled loop;  ``steps``, ``problem``: of its integrator and of its contact problem
    ``told``       happenings that Python adds to the log
    ``shared``     True if indeterminate forces are those of equal compliance
    ``drives``     signals and controllers, or None
    ``changes``    number of a phase, and the parameters that hold from there
    ``patches``    patches of solids, or None
    """

    def __init__(self, kernels: Kernels, values: Mapping[str, float], scene: Scene | None = None) -> None:
        self.kernels, self.values, self.model = kernels, values, kernels.model
        self.scene = scene_of(kernels) if scene is None else scene
        self.parameters = kernels.parameters(values)
        self.names = [c.name for c in self.model.contacts]
        self.n, self.n_u = self.model.n_q, self.model.n_u
        self.shared = True
        self.drives: Drives | None = None
        self.changes: list[tuple[int, Array]] = []
        self.patches = Patches(kernels, values) if self.model.patches else None
        self.it: EventRun = event_run(self.scene, self.n + self.n_u + 2)
        if self.patches is not None:
            self.patches.it.mode = self.it.mode
        solvers = compiled_code()
        self.it.finding, self.it.colliding = solvers["find"].address, solvers["collided"].address
        rows = self.scene.rows
        self.make_room(rows if rows <= AT_ONCE else AT_ONCE // 4)

    def make_room(self, rows: int) -> None:
        """Make a contact problem with room for so many rows."""
        rows = min(rows, self.scene.rows)
        self.problem = contacts_room(min(rows, len(self.names)), rows)

    def prepare(
        self,
        problem: Problem,
        relative: Array,
        absolute: Array,
        blows: Sequence[tuple[float, Blow]] = (),
        called: Sequence[Blow] = (),
    ) -> None:
        """Prepare the steps and the events of the run, with blows at given times and those that events call for."""
        request, specs = problem.request, problem.specs
        it, scene = self.it, self.scene
        calls = tuple(call_of(one) for one in called)  # events that trigger a blow, after those of the user
        self.asked, self.specs = len(specs), (*specs, *calls)
        self.shared = request.indeterminate == "compliance"
        self.blows, self.called = list(blows), tuple(called)
        self.counts = [math.inf if one.times is None else one.times for one in called]
        self.relative, self.absolute = relative, absolute
        self.method = "dop853" if request.method == "auto" else request.method
        watched = (*problem.expressions, *expressions_of(self.model, calls))
        phase = self.equip(watched)
        rates = phase.rates_of(self.program, self.phase)
        stops = 0 if self.patches is None else self.patches.functions_count
        self.endings = stops + len(scene.endings)
        self.steps = self._steps(self.method, rates)
        self.steps.stop_if_stiff = int(request.method == "auto")
        logged = len(self.steps.search.log_times)
        it.moving, it.refuse = scene.candidates.moving, not self.shared
        it.sequential = request.impacts == "sequential"
        it.followed = len(self.specs) + stops if stops else 0
        it.asked, it.crossed = self.asked, logged if self.asked else 0
        self.constants_kept = rates
        it.piece, it.implicit = _piece(self.method), 0
        self._other: Run | None = None
        it.final = np.array([*(spec.terminal for spec in self.specs), 0], dtype=np.int64)
        it.longest = request.longest_step
        it.steps_left = problem.most_steps
        it.past[:] = -1
        it.last = it.met_at = -math.inf
        self.told: list[Any] = []
        self._log_rows(LOG, LOG, LOG)

    def _steps(self, method: str, rates: Rates) -> Run:
        """Return the memory of steps by a method, with the functions that end them."""
        m, n = len(self.specs) + self.endings, self.it.n_y
        run, own = memory(method, n, m)
        search = run.search
        equip(run, own, rates)
        run.relative[:], run.absolute[:] = self.relative, self.absolute
        run.required = len(self.specs)
        search.functions, search.c = self.program.address("watched"), self.phase
        search.guarded = self.endings
        search.directions[:] = [*(spec.direction for spec in self.specs), *[-1] * self.endings]
        search.terminal[:] = [*(spec.terminal for spec in self.specs), *[1] * self.endings]
        logged = PIECE + most_events(m) + 1
        buffer = np.empty((PIECE + 1) * (2 + n))
        run.times, run.lengths = buffer[: PIECE + 1], buffer[PIECE + 1 : 2 * PIECE + 2]
        run.states = buffer[2 * PIECE + 2 :].reshape(PIECE + 1, n)
        search.log_times, search.log_states = np.empty(logged), np.empty((logged, n))
        search.log_numbers, search.log_signs = (np.empty(logged, dtype=np.int64) for _ in range(2))
        return run

    def change_method(self) -> None:
        """Let implicit steps take the place of explicit ones, or these of those."""
        it = self.it
        if self._other is None:
            self._other = self._steps(IMPLICIT, self.constants_kept)
        self.steps, self._other, it.implicit = self._other, self.steps, 1 - it.implicit
        it.piece = _piece(IMPLICIT if it.implicit else self.method)

    def equip(self, watched: Sequence[Any] = ()) -> Phase:
        """Give the memory its kernels, compiled if they are not yet, with these functions of the user."""
        it, scene = self.it, self.scene
        phase = scene.holding(("open",) * len(self.names), self.kernels.active)
        self.looking, self.program = scene.constants(self.parameters), phase.whole(watched, self.patches)
        self.phase = self.program.constants(self.parameters)
        compiled, energy = functions(), self.kernels.motion()
        for name, kernel in KERNELS.items():
            setattr(it, name, compiled[kernel].address)
        self.energy_constants = energy.constants(self.parameters)
        it.energy, it.energy_c = energy.address("energy"), self.energy_constants
        it.looking, it.phase = self.looking, self.phase
        it.watch, it.watch_later = np.empty((2, self.program.outputs("watched")))
        indices = np.array(self.model.quaternions or [0], dtype=np.int64)
        it.turned, it.quaternions = len(self.model.quaternions), indices
        it.ending = np.array([end.contact for end in scene.endings], dtype=np.int64)
        it.place = np.array([end.place for end in scene.endings], dtype=np.int64)
        it.events, it.ready = self.program.outputs("watched") - len(scene.endings), 1
        return phase

    def set_values(self, values: Mapping[str, float]) -> None:
        """Go on with other values of the parameters."""
        if self.patches is not None and self.patches.values is not values:
            self.patches.set_values(values)
            values = self.patches.values
        self.values, self.parameters = values, self.kernels.parameters(values)
        scene, energy = self.scene, self.kernels.motion()
        scene.program.set_parameters(self.looking, self.parameters)
        self.energy_constants[:] = energy.constants(self.parameters)
        self.program.set_parameters(self.phase, self.parameters)
        self.changes.append((self.it.phases, self.parameters))

    def parameters_of(self, phase: int) -> Array | None:
        """Return the parameters of a phase by its number, if they change during the run."""
        k = bisect_right(self.changes, phase, key=lambda change: change[0])
        return self.changes[k - 1][1] if k else None

    def next_stop(self) -> float:
        """Return the time of the next blow or change of values."""
        change = math.inf if self.drives is None else self.drives.until()
        return min(change, self.blows[0][0]) if self.blows else change

    def longer_log(self) -> None:
        """Double what is full of the log."""
        it = self.it
        need = 64 + 4 * self.it.contacts, 64 + 8 * it.n_y
        self._log_rows(
            2 * it.marks_room + 40 * need[0] + 4 * it.crossed,
            2 * it.numbers_room + 40 * (need[1] + it.rows) + (it.n_y + 4) * it.crossed,
            2 * it.path_room + 2 * PIECE,
        )

    def _log_rows(self, marks: int, numbers: int, rows: int) -> None:
        """Make longer rows for the log, with what is in it."""
        it = self.it

        def row(old: Any, length: int, shape: Any, kind: Any = np.float64) -> Any:
            new = np.empty(shape, dtype=kind)
            if length:
                new[:length] = old[:length]
            return new

        arrays = it.arrays
        it.marks = row(arrays.get("marks"), it.marked, marks, np.int64)
        it.numbers = row(arrays.get("numbers"), it.numbered, numbers)
        it.times = row(arrays.get("times"), it.logged, rows)
        it.lengths = row(arrays.get("lengths"), it.logged, rows)
        states = row(arrays.get("states"), it.logged * it.n_y, rows * it.n_y)
        it.states = states
        it.marks_room, it.numbers_room, it.path_room = marks, numbers, rows

    # -- the moment --------------------------------------------------------------------------------

    def look(self, t: float, y: Array, parameters: Array | None = None) -> Snapshot:
        """Return the contacts at a moment, with the present values of the parameters or with others."""
        constants = self.looking if parameters is None else self.scene.constants(parameters)
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

    def speed(self, seen: Snapshot, k: int) -> float:
        """Return the slip speed of a contact [m/s]."""
        return math.hypot(*self.slip(seen, k).tolist())

    def smooth(self, seen: Snapshot, k: int) -> bool:
        """Return True if the coefficients of friction are zero in this run."""
        return bool(seen.friction[k] == seen.static[k] == 0)
