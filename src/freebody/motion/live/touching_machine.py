"""A machine with contacts as a live motion: its functions on the tape, and the memory of the loop from event to event.

    machine, pair k, contact k    what `phase.candidates` has: the machine, gaps and reaches, one contact
    power                         of drives and of moving conditions
    observation                   what a caller wants to see, of state, accelerations, contact forces and multipliers

The functions of `phase.phase_kernels` call them, with modes as data (`PhaseData`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...dynamics import State
from ...scalar.algebra import Scalar
from ..cones.contacts import Contacts, contacts_room
from ..contact.memory import equip_loop
from ..events import event_run, limits
from ..kernels.hoisted import Hoisted
from ..kernels.sided_run import SidedRun, sided_run
from ..kernels.sides import sided_kernels
from ..ode.memory import watch
from ..phase.phase import Source
from ..phase.phase_data import DataProgram
from ..phase.scene import scene_of
from .memory import Live
from .setting import Setting

PIECE = limits.PIECE
MOST_ROWS, MOST_PHASES = 100, 1000
"""Most rows of contacts (the room for their problem grows with the square), and most phases of a motion."""


@dataclass(frozen=True)
class Placed:
    """Kernels at known addresses that share one block of constants."""

    addresses: Mapping[str, int]
    hoisted: int

    @property
    def compiled(self) -> Placed:
        """The set of kernels: itself."""
        return self

    def address(self, name: str) -> int:
        """Address of a kernel."""
        return self.addresses[name]

    def outputs(self, name: str) -> int:
        """Return 0: a live motion knows the number of outputs."""
        return 0


ROWS = (
    "ending", "place", "final", "signs", "ways", "crossed_at", "watch", "watch_later", "marks", "numbers", "times",
    "lengths", "states",
)  # fmt: skip
"""Rows of `EventRun` that are those of `memory.Touching`."""
SIZES = (
    "n_fresh", "n_of_phase", "n_of_looking", "n_endings",
    "n_final", "n_watched", "n_marks", "n_numbers_logged", "n_logged", "n_states_logged", "n_found", "room_of_phases",
    "room_of_modes", "n_laws",
)  # fmt: skip


class TouchingMachine:
    """What a machine with contacts has besides others.

    ``run``, ``problem``       memory of the run and of its contact problem, once there is a `Live`
    ``laws``                   that of laws that switch, if there are any
    ``endings``                number of functions that end a phase: of these laws, and of contacts
    """

    run: event_run.EventRun
    problem: Contacts

    def __init__(self, setting: Setting) -> None:
        self.setting, self.scene = setting, scene_of(sided_kernels(setting.kernels))
        self.laws: tuple[SidedRun, ...] = ()
        self.endings = self.scene.laws + len(self.scene.endings)
        self.candidates = self.scene.candidates
        self.candidates.program()  # for the pattern of its outputs

    def functions(self, state: State, given: Sequence[Scalar], observed: Any) -> dict[str, list[Scalar]]:
        """Outputs of the functions that move the machine; ``given`` follows the state."""
        candidates = self.candidates
        moving = candidates.motion(state, given[: candidates.inputs])
        forces = candidates.forces(state, given)
        result = {name: list(outputs) for name, outputs in candidates.functions(state).items()}
        parts = ((candidates.driven, candidates.power_of), (self.scene.loaded, candidates.bearings_of))
        for has, outputs_of in parts:
            if has:
                result |= {k: list(x) for k, x in outputs_of(state, given[: candidates.inputs]).items()}
        return {**result, "observation": list(observed(state, moving, forces))}

    # -- memory -----------------------------------------------------------------------------------------------

    def programs(self, addresses: Mapping[str, int], constants: int) -> tuple[DataProgram, DataProgram]:
        """Data of the functions of phases, and of all contacts, for functions at these addresses."""
        scene, first = self.scene, len(self.setting.specs)
        count = first + scene.laws
        absent = {"observation": 0, "values": addresses.get("events", 0)}  # they may have no outputs
        kernels = Placed({**absent, **addresses}, constants)
        driven = kernels if self.candidates.driven else None
        source = Source(addresses.__getitem__, kernels, driven, kernels if scene.loaded else None)
        E, m, n = len(scene.first), scene.rows, scene.model.n_u
        phase = scene.holding(("open",) * E, scene.kernels.active)
        sizes = {
            "rates": phase.size,
            "projection": scene.model.n_q + n,
            "watched": count + len(scene.endings),
        }
        watched, observed = kernels if count else None, ("observation", kernels)
        return (
            phase.data(sizes, observed, watched, count, whole=True, source=source, first=first),
            phase.data({"looked": 6 * E + 2 * m + n + 2 * m * n}, source=source),
        )

    def sizes(self, addresses: Mapping[str, int], constants: int, zeros: int) -> dict[str, int]:
        """Sizes of the rows of `memory.Touching`, and of the phases."""
        scene, n_y = self.scene, self.scene.model.n_q + self.scene.model.n_u + 2
        self.of_phase, self.of_looking = self.programs(addresses, constants)
        self.run = event_run.event_run(scene, n_y)
        self.problem = contacts_room(min(scene.rows, len(scene.first)), scene.rows)
        E, m, count = len(scene.first), scene.rows, len(self.setting.specs)
        found = PIECE + zeros + 1
        crossed, rows = found if count else 0, 2 * PIECE + 64
        # four times what one stage adds (`events.log.room_for_event`)
        marks = 16 * (16 + 4 * E + m + scene.laws) + 8 * crossed
        numbers = 16 * (16 + 4 * n_y + 4 * E + 4 * m) + 2 * (n_y + 1) * crossed
        return dict(zip(SIZES, (
            self.run.memory.size, len(self.of_phase.programs), len(self.of_looking.programs), len(scene.endings),
            count + 1, count + self.endings, marks, numbers, rows, rows * n_y, found, MOST_PHASES,
            MOST_PHASES * E, scene.laws,
        ), strict=True))  # fmt: skip

    def equip(self, live: Live, addresses: Mapping[str, int], hoisted: Hoisted) -> None:
        """Write what the loop reads of the machine."""
        it, hold, scene, setting = self.run, live.touching, self.scene, self.setting
        model, count = scene.model, len(setting.specs)
        directions, terminal = (
            [spec.direction for spec in setting.specs],
            [spec.terminal for spec in setting.specs],
        )
        hold.run, hold.problem = it.memory, self.problem.memory
        hold.observing = addresses["derived"]
        for name, program in (("phase", self.of_phase), ("looking", self.of_looking)):
            setattr(hold, name, program.data.memory)
            getattr(hold, f"of_{name}")[:] = [
                program.data.placed[f"{kernel}_c"][0] for kernel in program.programs
            ]
        live.quaternions[:] = model.quaternions
        for run in (live.run, live.viewer):
            run.rates, run.projection = addresses["rates"], addresses["projection"]
            run.projected = model.n_q + model.n_u
            run.c, run.quaternions, run.n_quaternions = hold.phase, live.quaternions, len(model.quaternions)
            run.longest, run.required = np.inf, count + self.endings
            run.times, run.lengths, run.states = live.step_times, live.step_lengths, live.step_states
        search = live.run.search
        watch(search, addresses["watched"], hold.phase, directions, terminal, self.endings)
        search.log_times, search.log_states = hold.event_times, hold.event_states
        search.log_numbers, search.log_signs = hold.event_numbers, hold.event_signs
        it.piece, it.finding, it.colliding = (addresses[name] for name in ("piece", "find", "collided"))
        it.energy, it.energy_c = addresses["energies"], live.constants
        it.looking, it.phase = hold.looking, hold.phase
        it.hoisted = hoisted.memory
        for name in ROWS:
            setattr(it, name, getattr(hold, name))
        equip_loop(it, scene, addresses.__getitem__, live.quaternions, terminal)
        it.marks_room, it.numbers_room, it.path_room = hold.marks.size, hold.numbers.size, hold.times.size
        it.events, it.asked = count + scene.laws, count
        it.crossed = hold.event_times.size if count else 0
        it.sequential, it.refuse = setting.sequential, setting.refuse
        it.longest, it.stale, it.most_phases = setting.longest, 1, limits.PHASES
        live.tolerances[:] = [*setting.relative[: model.n_q + model.n_u], *[max(setting.relative)] * 2]
        if scene.sides is not None:
            laws = sided_run(scene.sides, live.tolerances.size, hoisted, addresses["laws"], live.constants)
            laws.relative[:], it.sided, self.laws = live.tolerances, laws.memory, (laws,)
