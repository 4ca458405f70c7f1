"""Memory of a run with contacts: its records with their kernels, kept for the next run of the same functions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np

from ...native.loop import make_together
from ..cones.collision import compiled_code
from ..cones.contacts import contacts_room
from ..events.code import code
from ..events.event_run import EventRun, event_run
from ..events.limits import PIECE
from ..kernels.hoisted import Hoisted
from ..kernels.kernels import Kernels
from ..kernels.sided_run import SidedRun
from ..ode import loops
from ..ode.dense_output import Array
from ..ode.memory import equip, make_log, make_rows, memory, watch
from ..ode.run import Run
from ..phase.phase import functions
from ..phase.phase_record import PhaseData
from ..phase.scene import Scene
from .patches import Patches

KERNELS = {
    "looked": "looked", "rates_at": "rate", "rates": "rates", "projection": "projection",
    "accelerations": "acceleration", "forces": "force", "watched": "watched",
}  # fmt: skip
"""Functions of `phase_kernels` and its kin that the loop calls."""
AT_ONCE = 300
"""Number of rows up to which the contact problem has room for all of them from the start."""
IMPLICIT = "radau"
"""Method of the steps where the friction of a slow slip in space is stiff."""
LOG = 1 << 12
"""First number of rows of the log."""
LONGEST = 1 << 15
"""Number of rows of the log with which the memory of a finished run is kept."""
SPARE = 8
"""Number of memories of finished runs that a machine keeps: one for each thread that asks for the same functions."""


def equip_loop(
    it: EventRun, scene: Scene, address_of: Callable[[str], int], quaternions: Any, terminal: Sequence[Any]
) -> None:
    """Write what the loop from event to event reads of every machine, before its first step.

    ``terminal`` says of each function of the user whether it ends the run.
    """
    for name, function in KERNELS.items():
        setattr(it, name, address_of(function))
    it.turned, it.quaternions = len(scene.model.quaternions), quaternions
    it.ending[:] = [end.contact for end in scene.endings]
    it.place[:] = [end.place for end in scene.endings]
    it.final[:] = [*terminal, 0]
    it.laws, it.first_law, it.moving, it.ready = scene.laws, len(terminal), scene.candidates.moving, 1
    blocks = scene.candidates.pattern.blocks
    if not scene.loaded:  # the load of a joint may come from anywhere
        it.blocks, it.beside[:] = len(blocks.starts) - 1, np.ravel(blocks.contacts)
        it.starts[: len(blocks.starts)] = blocks.starts
    it.past[:] = -1
    it.last = it.met_at = it.corrected_at = it.crept_from = -np.inf


class Watched(NamedTuple):
    """What shapes the memory of a run: its method, and the user's functions, each with its direction and whether it
    ends the run; the first ``asked`` are events, others call for blows. Controllers read what is ``sensed``.
    """

    method: str
    expressions: tuple[Any, ...] = ()
    directions: tuple[int, ...] = ()
    terminal: tuple[bool, ...] = ()
    asked: int = 0
    sensed: tuple[Any, ...] = ()


class Memory:
    """Memory of one run with contacts.

    ``it``         memory of the compiled loop;  ``steps``, ``problem``: of its integrator and of its contact problem
    ``other``      implicit steps and the address of their code, or explicit ones while these are in use; None until
                   they are needed
    ``laws``       laws that switch, or None
    ``looking``, ``phase``, ``energy``    constants of the functions of all contacts, of the present phase, of energies
    ``parameters``    values of the parameters, with the angles of disks that lie flat
    """

    steps: Run
    other: tuple[Run, int] | None

    def __init__(self, kernels: Kernels, scene: Scene, patches: Patches | None = None) -> None:
        self.kernels, self.scene, self.model, self.patches = kernels, scene, kernels.model, patches
        self.it: EventRun = event_run(scene, self.model.n_q + self.model.n_u + 2)
        solvers = compiled_code()
        self.it.finding, self.it.colliding = solvers["find"].address, solvers["collided"].address
        if patches is not None:
            patches.it.mode = self.it.mode
        self.make_room(scene.rows if scene.rows <= AT_ONCE else AT_ONCE // 4)
        self.laws: SidedRun | None = None
        self.bits, self.images = b"", list[tuple[Array, Array]]()

    def make_room(self, rows: int) -> None:
        """Make a contact problem with room for so many rows."""
        rows = min(rows, self.scene.rows)
        self.problem = contacts_room(min(rows, self.it.contacts), rows)

    def equip(self, parameters: Array, watched: Watched) -> Any:
        """Write the kernels, compiled if they are not yet, with these functions of the user; return the phase."""
        it, scene, model = self.it, self.scene, self.model
        phase = scene.holding(("open",) * it.contacts, self.kernels.active)
        self.looking = scene.constants(parameters)
        PhaseData(self.looking).only_near = 1
        self.program = phase.whole(watched.expressions, self.patches, watched.sensed)
        self.phase = self.program.constants(parameters)
        compiled, energy = functions(), self.kernels.motion()
        self.energy = np.array(energy.constants(parameters))
        it.energy, it.energy_c = energy.address("energy"), self.energy
        it.looking, it.phase = self.looking, self.phase
        it.watch, it.watch_later = np.zeros((2, self.program.outputs("watched")))
        it.events = self.program.outputs("watched") - len(scene.endings)
        it.ending, it.place = np.zeros((2, len(scene.endings)), dtype=np.int64)
        it.final = np.zeros(len(watched.terminal) + 1, dtype=np.int64)
        indices = np.array(model.quaternions or [0], dtype=np.int64)
        equip_loop(it, scene, lambda name: compiled[name].address, indices, watched.terminal)
        numbers = len(parameters) + scene.laws
        self.hoisted = Hoisted.made(numbers=numbers, most_programs=1 + 2 * len(self.program.programs))
        self.parameters, it.hoisted = self.hoisted.parameters[: len(parameters)], self.hoisted.memory
        self.parameters[:] = parameters
        scene.program.follow(self.hoisted, self.looking)
        self.program.follow(self.hoisted, self.phase)
        if scene.sides is not None:
            self.laws = scene.sides.run(it.n_y, self.hoisted)
            it.sided = self.laws.memory
        return phase

    def prepare(self, parameters: Array, watched: Watched) -> None:
        """Write all that does not depend on the values and tolerances of a run."""
        it, scene = self.it, self.scene
        phase = self.equip(parameters, watched)
        self.kept = phase.rates_of(self.program, self.phase)
        self.watching, count = watched, len(watched.expressions)
        stops = 0 if self.patches is None else self.patches.functions_count
        self.endings = scene.laws + stops + len(scene.endings)
        self.steps, self.other = self._steps(watched.method), None
        logged = len(self.steps.search.log_times)
        it.followed = count + scene.laws + stops if stops else 0
        it.asked, it.crossed = watched.asked, logged if watched.asked else 0
        it.piece = _piece(watched.method)
        it.signs, it.ways = np.zeros((2, watched.asked + 1), dtype=np.int64)
        it.crossed_at = np.zeros(watched.asked + 1)
        self._log_rows(LOG, LOG, LOG)
        self.bits = parameters.tobytes()
        self._keep()

    def _steps(self, method: str) -> Run:
        """Return the memory of steps by a method, with the functions that end them."""
        watched, n = self.watching, self.it.n_y
        count = len(watched.expressions)
        m = count + self.endings
        run, own = memory(method, n, m)
        search, address = run.search, self.program.address("watched")
        equip(run, own, self.kept)
        run.required = m
        watch(search, address, self.phase, watched.directions, watched.terminal, self.endings)
        search.unjudged[count + self.scene.laws :] = (
            1  # each phase says which gaps it judges (`phase_stages.begin_steps`)
        )
        search.smooth = int(m == len(self.scene.endings) and self.scene.candidates.pattern.smooth)
        make_rows(run, PIECE)
        make_log(search, PIECE, n)
        return run

    def change_method(self) -> None:
        """Let implicit steps take the place of explicit ones, or these of those."""
        it, steps = self.it, self.steps
        if self.other is None:
            implicit = self._steps(IMPLICIT)
            implicit.relative[:], implicit.absolute[:] = steps.relative, steps.absolute
            self.other = implicit, _piece(IMPLICIT)
        present = steps, it.piece
        (self.steps, it.piece), self.other, it.implicit = self.other, present, 1 - it.implicit

    def begin(self, parameters: Array) -> None:
        """Begin another run: all numbers are those after `prepare`, with these values of the parameters."""
        if self.it.implicit:
            self.change_method()
        self.other = None
        it = self.it
        rooms = it.marks_room, it.numbers_room, it.path_room
        for memory_of_one, image in self.images:
            memory_of_one[:] = image
        if it.path_room != rooms[2]:  # the log has grown
            it.marks_room, it.numbers_room, it.path_room = rooms
            for name in ("marks", "numbers", "times", "lengths", "states"):
                setattr(it, name, it.arrays[name])
        if self.bits != parameters.tobytes():
            self.set_parameters(parameters)
            self.bits = parameters.tobytes()
            self._keep()

    def _keep(self) -> None:
        blocks = [x.memory for x in (self.it, self.steps, self.hoisted)]
        blocks += [self.looking, self.phase, self.energy]
        if self.laws is not None:
            blocks += [self.laws.memory, self.laws.arrays["e_c"]]
        self.images = [(block, block.copy()) for block in blocks]

    def give_back(self, key: Watched) -> None:
        """Offer this memory to the next run of these functions, unless its log is long or it has patches."""
        spare = self.scene.spare
        if self.patches is None and self.it.path_room <= LONGEST:
            if key not in spare and len(spare) >= SPARE:
                spare.clear()
            of_key = spare.setdefault(key, [])
            if len(of_key) < SPARE:
                of_key.append(self)

    def set_parameters(self, parameters: Array) -> None:
        """Write other values of the parameters."""
        energy = self.kernels.motion()
        self.parameters[:] = parameters
        self.energy[:] = energy.constants(parameters)
        code("take_sides")(self.it)

    def fit_entry(self) -> None:
        """Make the log longer if it has no room for one entry of an event or of a happening."""
        it = self.it
        if it.marked + 8 > it.marks_room or it.numbered + 2 + it.n_y > it.numbers_room:
            self.longer_log()

    def longer_log(self) -> None:
        """Double what is full of the log."""
        it = self.it
        need = 64 + 4 * it.contacts, 64 + 8 * it.n_y
        self._log_rows(
            2 * it.marks_room + 40 * need[0] + 4 * it.crossed,
            2 * it.numbers_room + 40 * (need[1] + it.rows) + (it.n_y + 4) * it.crossed,
            2 * it.path_room + 2 * PIECE,
        )

    def _log_rows(self, marks: int, numbers: int, rows: int) -> None:
        """Make longer rows for the log, with what is in it."""
        it, n = self.it, self.it.n_y
        sizes = {
            "marks": (it.marked, marks), "numbers": (it.numbered, numbers), "times": (it.logged, rows),
            "lengths": (it.logged, rows), "states": (it.logged * n, rows * n),
        }  # fmt: skip
        for name, (filled, room) in sizes.items():
            new = np.empty(room, dtype=np.int64 if name == "marks" else np.float64)
            if filled:
                new[:filled] = it.arrays[name][:filled]
            setattr(it, name, new)
        it.marks_room, it.numbers_room, it.path_room = marks, numbers, rows


def _piece(method: str) -> int:
    """Return the address of the compiled steps of a method."""
    address: int = loops.functions(method).functions["piece"].address
    return address


@cache
def _load(method: str) -> None:
    """Load or compile the code of a run, once in a process."""
    make_together((compiled_code, functions, partial(loops.functions, method), partial(code, "go_on")))


def memory_of(
    kernels: Kernels, scene: Scene, key: Watched, parameters: Array, patches: Patches | None
) -> Memory:
    """Return memory for a run, ready to go: that of a finished run of the same functions if there is one."""
    spare = scene.spare.get(key, []) if patches is None else []
    try:
        result: Memory = spare.pop()
    except IndexError:  # none, or another thread took it
        _load(key.method)
        result = Memory(kernels, scene, patches)
        result.prepare(parameters, key)
    else:
        result.begin(parameters)
    return result
