"""The contacts of a machine as numbers at one moment, and the motion between two events as data of compiled code.

scene    gap, speeds and accelerations of all contacts, their rows W and the change of u' per unit of force
phase    a set of modes: right-hand side, contact forces, and the functions that end the phase

A phase needs no code of its own: it is a table of integers (`places`) for the functions of `closed_contacts`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, cast

import numpy as np

from ...dynamics import State
from ...dynamics.conditions.constraints import rows
from ...dynamics.conditions.contact import contact_layout, contact_rows, reaches_along, touches
from ...dynamics.contact_motion import contact_problem
from ...dynamics.state import float_state
from ...errors import SimulationError
from ...model import Model
from ...native import loop
from ..kernels.kernels import Kernels, Program
from ..ode.dense_output import Array, Rates, outputs_at
from . import places
from .candidates import Candidates, coefficients

Modes = tuple[str, ...]
"""Mode of every contact: open, stick, slip+, slip-, slip, smooth, or limit and a direction (:func:`at_limit`)."""

SMOOTH = "smooth"
"""Mode of a closed contact whose friction is zero in this run: the sense of its slip is not watched."""
LIMIT = "limit"
"""Mode of a contact in space at its limit of friction that the others hold at rest: -T/|T| is a fixed direction."""
KINDS = ("open", "stick", "slip+", "slip-", "slip", SMOOTH, LIMIT)
"""Kinds of modes, in the order of their numbers (`places`)."""
NUMBERS = {kind: number for number, kind in enumerate(KINDS)}
_FUNCTIONS = (
    "rates", "projection", "derived", "multipliers", "gap", "rate", "acceleration", "force", "static_friction",
    "watched", "looked", "set_modes",
)  # fmt: skip
_MODULES = tuple(loop.sibling(__name__, name) for name in ("closed_contacts", "mode_table"))
_LABEL = _MODULES[0]
_NEWTON = "motion.cones.newton"
_SLIPPING = ("slip+", "slip-", "slip")


@dataclass(frozen=True)
class Snapshot:
    """The contacts at one moment: E elements, m rows in the order of :func:`contact_layout`.

    ``c`` are the derivatives of the rates without contact forces, ``free`` the accelerations u' so, ``matrix`` is W,
    and ``responses`` the change of u' per unit of each contact force. ``away`` are the least rates of reaches that are
    zero.
    """

    gap: Array
    reach: Array
    rate: Array
    c: Array
    free: Array
    matrix: Array
    responses: Array
    friction: Array
    static: Array
    restitution: Array
    away: Array

    @cached_property
    def A(self) -> Array:
        """A = W M⁻¹ Wᵀ, rates per unit of each force; symmetric."""
        return self.between(range(len(self.rate)))

    def between(self, rows: Sequence[int]) -> Array:
        """Return the rows and columns of A."""
        chosen = list(rows)
        return self.matrix[chosen] @ self.responses[chosen].T


@dataclass(frozen=True, eq=False)
class DataProgram:
    """Functions of (t, y, c) whose constants c are the data of a phase (`places`).

    ``functions``  address and number of outputs of each
    ``table``      integers of the phase
    ``size``       length of c
    ``parts``      a place in c and the program whose constants stand there; ``numbers``: a place and a number
    """

    functions: Mapping[str, tuple[int, int]]
    table: Any
    size: int
    parts: Sequence[tuple[int, Any]]
    numbers: Sequence[tuple[int, float]]
    _last: list[tuple[bytes, Any]] = field(default_factory=list)

    def address(self, name: str) -> int:
        """Address of a function."""
        return self.functions[name][0]

    def outputs(self, name: str) -> int:
        """Number of outputs of a function."""
        return self.functions[name][1]

    def constants(self, parameters: Array) -> Array:
        """Return c for these parameters; it is memory of the functions too, so no two threads may share it."""
        key = parameters.tobytes()
        last: tuple[bytes, Any] = (
            self._last[0] if self._last else (b"", None)
        )  # another thread may replace it meanwhile
        if last[1] is None or last[0] != key:
            c = np.zeros(self.size)
            c.view(np.int64)[0] = loop.address(self.table)
            for at, program in self.parts:
                own = program.constants(parameters)
                c[at : at + own.size] = own
            for at, number in self.numbers:
                c[at] = number
            last = key, c
            self._last[:] = [last]
        return cast(Array, last[1].copy())


def at_limit(direction: Sequence[float]) -> str:
    """Return the mode of a contact at rest at its limit of friction, T = -μ_s N d."""
    return " ".join((LIMIT, *(repr(float(x)) for x in direction)))


def direction_of(mode: str) -> tuple[float, ...]:
    """Return the fixed direction of a mode, empty if it has none."""
    return tuple(map(float, mode.split()[1:]))


def functions() -> dict[str, Any]:
    """Return the compiled functions of this room."""

    def named() -> dict[str, Any]:
        from . import closed_contacts, mode_table

        return vars(closed_contacts) | vars(mode_table)

    return loop.made(_LABEL, _MODULES, _FUNCTIONS, named, short=True).functions


def _ends(model: Model) -> dict[int, list[tuple[int, int]]]:
    """For each corner that ends a side: the side's element, and the index of its reach that is zero there."""
    names = {c.name: k for k, c in enumerate(model.contacts)}
    result: dict[int, list[tuple[int, int]]] = {}
    for k, c in enumerate(model.contacts):
        side = names.get(c.owner, k)
        if side != k:
            result[k] = [(side, k - side - 1)]
    return result


class Scene:
    """The contacts of a model as numbers, computed by one compiled kernel."""

    def __init__(self, kernels: Kernels) -> None:
        self.kernels = kernels
        self.model: Model = kernels.model
        self.candidates = Candidates(kernels)
        self.first, self.tangents, self.rows = (
            self.candidates.first,
            self.candidates.tangents,
            self.candidates.rows,
        )
        self.held = tuple(int(c.held) for c in self.model.contacts)
        self.names = tuple(row.name for row in contact_layout(self.model.contacts))
        self._phases: dict[Any, Phase] = {}
        self.ends = _ends(self.model)

    @cached_property
    def endings(self) -> tuple[Ending, ...]:
        """Return the functions that may end a phase, contact by contact: normal, tangents, reaches, end of a side."""
        result: list[Ending] = []
        for k, n in enumerate(self.tangents):
            result += [Ending(k), *[Ending(k)] * (2 * (n == 1) + (n == 2))]
            result += [
                Ending(k, place) for place in range(self.candidates.pattern.contacts[k][places.REACHES])
            ]
            result += [Ending(side, place) for side, place in self.ends.get(k, ())]
        return tuple(result)

    @cached_property
    def program(self) -> DataProgram:
        """The function ``looked`` of all contacts."""
        n, E, m = self.model.n_u, len(self.first), self.rows
        none = self.holding(("open",) * E, self.kernels.active)
        return none.data({"looked": 7 * E + 2 * m + n + 2 * m * n})

    def constants(self, parameters: Array) -> Array:
        """Return the constants of the kernel for these parameters."""
        return self.program.constants(parameters)

    def at(self, t: float, y: Array, constants: Array) -> Snapshot:
        """Return the contacts at a state."""
        program = self.program
        return self.snapshot(
            outputs_at(program.address("looked"), program.outputs("looked"), t, y, constants)
        )

    def outputs(self, t: float, y: Array, values: Mapping[str, float]) -> Array:
        """Return the outputs of ``looked`` without compiled kernels: for one state this is cheaper."""
        model, n = self.model, self.model.n_q
        state = float_state(model, y[:n].tolist(), y[n : n + model.n_u].tolist(), t, values)
        seen, problem = contact_rows(model, state), contact_problem(model, state, self.kernels.active)
        return np.array(
            [
                *map(float, seen.gap),
                *(min(map(float, one.reach), default=np.inf) for one in touches(model, state)),
                *map(float, seen.rate),
                *map(float, problem.c),
                *map(float, problem.free),
                *(float(x) for row in seen.matrix for x in row),
                *(float(x) for row in problem.responses for x in row),
                *(float(x) for c in model.contacts for x in coefficients(model, state, c)),
                *(self._away(state, c, y[:n]) for c in model.contacts),
            ]
        )

    def _away(self, state: State, contact: Any, q: Array) -> float:
        """Return the least rate of the reaches of a contact that are zero."""
        near, still = places.CLOSED * (1 + float(np.abs(q).max(initial=0))), [0.0] * self.model.n_u
        reaches = reaches_along(self.model, state, contact, still)
        return min((float(rate) for value, rate, _ in reaches if abs(value) <= near), default=np.inf)

    def snapshot(self, values: Array) -> Snapshot:
        """Return the outputs of ``looked`` by their names."""
        n_u, E, m = self.model.n_u, len(self.first), self.rows
        parts, at = [], 0
        for size in (E, E, m, m, n_u, m * n_u, m * n_u, 4 * E, E):
            parts.append(values[at : at + size])
            at += size
        gap, reach, rate, c, free, matrix, responses, laws, away = parts
        friction, static, restitution, _ = laws.reshape(E, 4).T.copy()
        return Snapshot(
            gap, reach, rate, c, free, matrix.reshape(m, n_u), responses.reshape(m, n_u), friction, static,
            restitution, away,
        )  # fmt: skip

    def phase(self, modes: Modes, seen: Snapshot | None = None) -> Phase:
        """Return a set of modes; ``seen`` decides which contact conditions are independent."""
        active = self.kernels.active
        if seen is not None:
            active = (*active, *self._independent(modes, seen))
        return self.holding(modes, active)

    def holding(self, modes: Modes, active: tuple[int, ...]) -> Phase:
        """Return a set of modes with these independent conditions: the machine's own, then those of contacts."""
        key = (modes, active)
        if key not in self._phases:
            self._phases[key] = Phase(self, modes, active)
        return self._phases[key]

    def conditions(self, modes: Modes) -> list[tuple[int, int]]:
        """Return (contact, row of the contact) of each condition of closed contacts."""
        return [
            (k, j)
            for k, mode in enumerate(modes)
            if mode != "open"
            for j in range(self.held[k], 1 + (self.tangents[k] if mode == "stick" else 0))
        ]

    def _independent(self, modes: Modes, seen: Snapshot) -> list[int]:
        """Return independent conditions of closed contacts by Cholesky pivots of A, the largest first."""
        held = [self.first[k] + j for k, j in self.conditions(modes)]
        m = len(held)
        order = np.zeros(m, dtype=np.int64)
        loop.code(_NEWTON, "factor")(
            seen.between(held), m, np.zeros(m * m), places.DEPENDENT, np.zeros(m), order
        )
        return [self.candidates.own + i for i in np.flatnonzero(order).tolist()]


@dataclass(frozen=True)
class Ending:
    """A function that ends a phase when it falls through zero: its contact, and the end of a side among its reaches."""

    contact: int
    place: int = -1


class Phase:
    """The motion in one set of modes; the state is (q, u, W, heat)."""

    def __init__(self, scene: Scene, modes: Modes, active: tuple[int, ...]) -> None:
        self.scene, self.modes, self.active = scene, modes, active
        self.model = scene.model
        self.loose: Any = None
        self.shown: Modes = modes
        self.own = scene.kernels.active
        self.conditions = scene.conditions(modes)
        self._programs: dict[Any, Any] = {}

    def __reduce__(self) -> Any:
        return phase_of, (self.scene.kernels, self.modes, self.active)

    @property
    def size(self) -> int:
        """Number of components of y."""
        return self.model.n_q + self.model.n_u + 2

    def parameters(self, values: Mapping[str, float]) -> Array:
        """Return the values in the order of the model's parameters."""
        return self.scene.kernels.parameters(values)

    @cached_property
    def spare(self) -> list[int]:
        """Redundant contact conditions: they follow from the others."""
        own = self.scene.candidates.own
        return [i for i in range(own, own + len(self.conditions)) if i not in self.active]

    # -- programs --------------------------------------------------------------------------------

    def _program(self, key: Any, make: Any) -> Any:
        if key not in self._programs:
            self._programs[key] = make()
        return self._programs[key]

    def motion(self) -> DataProgram:
        """Functions ``rates``, of q, u, work and heat of friction, and ``projection``."""
        moved = self.model.n_q + self.model.n_u
        return cast(
            DataProgram,
            self._program("motion", lambda: self.data({"rates": self.size, "projection": moved})),
        )

    def contact(self) -> DataProgram:
        """Functions ``gap``, ``static_friction`` (E), ``rate``, ``acceleration`` and ``force`` (m) of all contacts."""
        E = len(self.modes)
        sizes = {
            "gap": E,
            "static_friction": E,
            **dict.fromkeys(("rate", "acceleration", "force"), self.scene.rows),
        }
        return cast(DataProgram, self._program("contact", lambda: self.data(sizes)))

    def reactions(self) -> DataProgram:
        """Functions ``reactions`` of every joint, and ``multipliers`` of the machine's own conditions."""

        def make() -> DataProgram:
            program = self.scene.candidates.reactions()
            return self.data({"multipliers": self.scene.candidates.own}, derived=("reactions", program))

        return cast(DataProgram, self._program("reactions", make))

    def limits(self) -> DataProgram:
        """Function ``limits``, as :meth:`Kernels.limits` has it."""
        return cast(
            DataProgram,
            self._program(
                "limits", lambda: self.data({}, derived=("limits", self.scene.candidates.limits()))
            ),
        )

    def whole(self, expressions: Sequence[Any], patches: Any = None) -> DataProgram:
        """Functions ``rates``, ``projection`` and ``watched`` with room for any modes.

        The last gives the user's expressions, approach and kept of the ``patches`` of the run, if it has any, then the
        functions that end the phase (:attr:`Scene.endings`).
        """

        def make() -> DataProgram:
            values: Any = self.scene.kernels.expressions(expressions) if expressions else None
            moved, count = self.model.n_q + self.model.n_u, len(expressions)
            if patches is not None:
                values, count = patches.with_values(values, count), count + patches.functions_count
            sizes = {"rates": self.size, "projection": moved, "watched": count + len(self.scene.endings)}
            return self.data(sizes, values=values, count=count, whole=True)

        return make() if patches is not None else cast(DataProgram, self._program(tuple(expressions), make))

    def rates_of(self, program: DataProgram, constants: Array) -> Rates:
        """Return the right-hand side, and the projection, of a program with these constants."""
        return Rates(
            program.address("rates"), self.size, constants, self.model.quaternions, program,
            projection=program.address("projection"), projected=program.outputs("projection"),
        )  # fmt: skip

    def rates(self, parameters: Array) -> Rates:
        """Return the right-hand side with the constants of these parameters."""
        program = self.motion()
        result = Rates(
            program.address("rates"), self.size, program.constants(parameters), self.model.quaternions, program,
            recipe=(self.rates, parameters),
        )  # fmt: skip
        if not self.active:
            return result
        return replace(
            result, projection=program.address("projection"), projected=program.outputs("projection")
        )

    def watching(self, expressions: Sequence[Any]) -> DataProgram:
        """Function ``watched``: the user's expressions, then the functions that end the phase (:func:`endings`)."""

        def make() -> DataProgram:
            values = self.scene.kernels.expressions(expressions) if expressions else None
            count = len(expressions) + len(self.scene.endings)
            return self.data({"watched": count}, values=values, count=len(expressions))

        return cast(DataProgram, self._program(tuple(expressions), make))

    # -- data ------------------------------------------------------------------------------------

    def data(
        self,
        outputs: Mapping[str, int],
        derived: tuple[str, Program] | None = None,
        values: Any = None,
        count: int = 0,
        whole: bool = False,
    ) -> DataProgram:
        """Return compiled functions for these modes.

        Parameters
        ----------
        outputs     function of `closed_contacts` -> number of its outputs; ``watched`` needs endings
        derived     name and program of a function of the state, accelerations, forces and multipliers
        values      program of the ``count`` functions of the user
        whole       True for room for any modes
        """
        candidates, code = self.scene.candidates, functions()
        program, power = candidates.program(), candidates.power() if candidates.driven else None
        table = _Table(self, "watched" in outputs, whole)
        parts: list[tuple[int, Any]] = []
        table.kernel(places.MACHINE, program.address("machine"))
        table.constants(places.CONSTANTS, program, parts)
        pattern = candidates.pattern
        table.list(places.PAIRS, [program.address(f"pair {p}") for p in range(len(pattern.pairs))])
        table.list(places.TOUCHES, [program.address(f"contact {k}") for k in range(len(pattern.sizes))])
        if power is not None:
            table.kernel(places.POWER, power.address("power"))
            table.constants(places.POWER_CONSTANTS, power, parts)
        found = {name: (code[name].address, size) for name, size in outputs.items()}
        if values is not None:
            table.kernel(places.VALUES, values.address("values"))
            table.constants(places.VALUES_CONSTANTS, values, parts)
            table.head[places.EXPRESSIONS] = count
        if derived is not None:
            name, of_forces = derived
            table.kernel(places.DERIVED, of_forces.address(name))
            table.constants(places.DERIVED_CONSTANTS, of_forces, parts)
            found[name] = code["derived"].address, of_forces.outputs(name)
        at = table.head[places.DIRECTION_AT]
        numbers = [
            (at + 2 * k + j, x) for k, mode in enumerate(self.modes) for j, x in enumerate(direction_of(mode))
        ]
        return DataProgram(found, table.finished(), table.size, parts, numbers)


class _Table:
    """The table of integers of a phase while it is written.

    ``endings``    True if the end of the phase is watched
    ``whole``      True for room for all modes, which compiled code may write then
    """

    def __init__(self, phase: Phase, endings: bool, whole: bool) -> None:
        self.head = [0] * places.HEAD
        self.tail: list[int] = []
        self.size, self.phase = 1, phase
        scene, candidates, model = phase.scene, phase.scene.candidates, phase.model
        pattern, own = candidates.pattern, phase.own
        kinds, first, n, m = rows(model), len(own), model.n_u, scene.rows
        E, a, count, slipping = len(model.contacts), len(phase.active), first + len(phase.conditions), 0
        if whole:
            a, count, slipping = min(first + m, n), first + m, E
        else:
            slipping = sum(mode in _SLIPPING or mode.startswith(LIMIT) for mode in phase.modes)
        for place, value in {
            places.N_Q: model.n_q, places.N_U: n, places.CONTACTS: E, places.ROWS: m, places.OWN: first,
            places.ALL_OWN: candidates.own, places.ENDINGS: len(scene.endings) if endings else 0,
            places.PAIR_COUNT: len(pattern.pairs), places.HELD_COUNT: sum(scene.held),
        }.items():  # fmt: skip
            self.head[place] = value
        L = len(pattern.below)
        for place, size in (
            (places.MACHINE_AT, model.n_q), (places.FREE_AT, n), (places.SCALE_AT, n), (places.L_AT, L),
            (places.LOAD_AT, 1), (places.OWN_AT, len(own) * (3 + n)), (places.Y_AT, count * n),
            (places.K_AT, slipping * n), (places.RIGHT_AT, count), (places.LAMBDA_AT, count),
            (places.WEIGHT_AT, count), (places.SQUARE_AT, 2 * a * a + a), (places.G_AT, 2 * a * count),
            (places.STEP_AT, n), (places.SPARE_AT, n), (places.BAND_AT, E),
            (places.DIRECTION_AT, 2 * E), (places.STATE_AT, model.n_q + n), (places.UDOT_AT, n),
            (places.FORCE_AT, m), (places.MULTIPLIER_AT, candidates.own),
        ):  # fmt: skip
            self.room(place, size)
        at_pair, blocks = list(map(self._more, pattern.pairs)), list(map(self._more, pattern.sizes))
        self.list(places.PAIR_AT, at_pair)
        self.list(
            places.CONTACT,
            [
                x
                for at, (pair, seen, n_t, reaches, row, away) in zip(blocks, pattern.contacts, strict=True)
                for x in (at_pair[pair] + seen, at, n_t, reaches, row, at + away)
            ],
        )
        sides = {k: side for k, ((side, _),) in scene.ends.items()}
        self.list(
            places.KIND,
            [
                x
                for k, c in enumerate(model.contacts)
                for x in (int(not c.frictionless), sides.get(k, -1), int(c.held), 0)
            ],
        )
        of_row = [at for at, n_t in zip(blocks, scene.tangents, strict=True) for _ in range(1 + n_t)]
        self.list(
            places.ROW,
            [x for at, (start, size, place) in zip(of_row, pattern.rows, strict=True)
             for x in (start, size, at + place)],
        )  # fmt: skip
        self.list(places.COLUMNS, pattern.columns)
        self.list(places.ORDER, pattern.order)
        self.list(places.STARTS, pattern.starts)
        self.list(places.PLACES, pattern.below)
        self.list(places.INDEPENDENT, [0] * (first + count))
        self.list(places.HOLONOMIC, [0] * (1 + first + count))
        self.list(places.OWN_NUMBER, own)
        self.list(places.OWN_HOLONOMIC, [int(not kinds[i].on_speeds) for i in own])
        self.list(places.CONDITION, [0] * (places.CONDITION_SIZE * count))
        self.list(
            places.ENDING, [x for end in scene.endings if endings for x in (0, end.contact, 0, end.place)]
        )
        self.list(places.CALLED, [0] * (1 + E))
        self.list(places.WATCHED, [0] * (1 + E))

    def _more(self, size: int) -> int:
        self.size += size
        return self.size - size

    def room(self, place: int, size: int) -> None:
        """Reserve numbers in c."""
        self.head[place] = self._more(size)

    def list(self, place: int, numbers: Sequence[int]) -> None:
        """Append a list to the table."""
        self.head[place] = places.HEAD + len(self.tail)
        self.tail += numbers

    def kernel(self, place: int, address: int) -> None:
        """Write the address of a kernel."""
        self.head[place] = address

    def constants(self, place: int, program: Any, parts: Any) -> None:
        """Reserve the constants of a kernel."""
        parts.append((self._more(program.compiled.hoisted), program))
        self.head[place] = parts[-1][0]

    def finished(self) -> Any:
        """Return the table, for the modes of the phase."""
        table, phase = np.array([*self.head, *self.tail], dtype=np.int64), self.phase
        modes = np.array([NUMBERS[mode.partition(" ")[0]] for mode in phase.modes], dtype=np.int64)
        first, own = len(phase.own), phase.scene.candidates.own
        active = np.array([i - own for i in phase.active[first:]], dtype=np.int64)
        functions()["set_modes"](table, modes, np.zeros_like(modes), active, active.size)
        return table


def phase_of(kernels: Kernels, modes: Modes, active: tuple[int, ...]) -> Phase:
    """Return a set of modes of a machine.

    Raises
    ------
    SimulationError
        If the machine has no such modes or conditions: a motion of another machine.
    """
    scene = scene_of(kernels)
    known = all(
        mode in KINDS or (mode.startswith(LIMIT) and len(direction_of(mode)) == n == 2)
        for mode, n in zip(modes, scene.tangents, strict=True)
    )
    last = scene.candidates.own + len(scene.conditions(modes)) if known else 0
    if not known or len(set(active)) != len(active) or not all(0 <= i < last for i in active):
        raise SimulationError(
            f"Expected modes and conditions of the contacts of '{kernels.model.name}', got {modes} and {active}: the "
            "motion is not of this machine."
        )
    return scene.holding(modes, active)


def scene_of(kernels: Kernels) -> Scene:
    """Return the compiled contacts of a machine, kept for its next run."""
    scene = getattr(kernels, "_scene", None)
    if scene is None:
        scene = Scene(kernels)
        kernels._scene = scene  # type: ignore[attr-defined]
    return scene
