"""The contacts of a machine as numbers at one moment, and the motion between two events as data of compiled code.

scene    gap, speeds and accelerations of all contacts, their rows W and the change of u' per unit of force
phase    a set of modes: right-hand side, contact forces, and the functions that end the phase

A phase needs no code of its own: it is data (`PhaseData`) for the functions of `phase_kernels`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple, cast

import numpy as np

from ...dynamics import State
from ...dynamics.conditions.contact import coefficients, contact_layout, contact_rows, reaches_along, touches
from ...dynamics.contact_motion import contact_problem
from ...dynamics.state import float_state
from ...errors import SimulationError
from ...model import Model
from ...model.resistance import pressers
from ...model.ring import edge_of
from ...native import loop
from ..kernels.contact_quantities import Asked, asked_by, watched_program
from ..kernels.kernels import Kernels
from ..kernels.sides import SidedKernels, sides_of
from ..ode.dense_output import Array, Rates, outputs_at
from .candidates.candidates import Candidates
from .laws import CLOSED, DEPENDENT
from .phase_data import DataProgram, phase_data
from .phase_record import PhaseData
from .snapshot import Snapshot

Modes = tuple[str, ...]
"""Mode of every contact: open, stick, slip+, slip-, slip, smooth, or limit and a direction (:func:`at_limit`)."""

SMOOTH = "smooth"
"""Mode of a closed contact whose friction is zero in this run: the sense of its slip is not watched."""
LIMIT = "limit"
"""Mode of a contact in space at its limit of friction that the others hold at rest: -T/|T| is a fixed direction."""
KINDS = ("open", "stick", "slip+", "slip-", "slip", SMOOTH, LIMIT)
"""Kinds of modes, in the order of their numbers (`laws`)."""
NUMBERS = {kind: number for number, kind in enumerate(KINDS)}
_FUNCTIONS = (
    "rates", "tangent", "projection", "derived", "multipliers", "gap", "reach", "rate", "acceleration", "force",
    "static_friction", "watched", "looked", "set_modes",
)  # fmt: skip
_MODULES = tuple(
    loop.sibling(__name__, name) for name in ("phase_kernels", "projection", "endings", "mode_conditions")
)
_LABEL = _MODULES[0]
_NEWTON = "motion.cones.newton"


def at_limit(direction: Sequence[float]) -> str:
    """Return the mode of a contact at rest at its limit of friction, T = -μ_s N d."""
    return " ".join((LIMIT, *(repr(float(x)) for x in direction)))


def direction_of(mode: str) -> tuple[float, ...]:
    """Return the fixed direction of a mode, empty if it has none."""
    return tuple(map(float, mode.split()[1:]))


def functions() -> dict[str, Any]:
    """Return the compiled functions of this room."""

    def named() -> dict[str, Any]:
        from . import endings, mode_conditions, phase_kernels, projection

        return vars(phase_kernels) | vars(projection) | vars(endings) | vars(mode_conditions)

    return loop.made(_LABEL, _MODULES, _FUNCTIONS, named, passes="few").functions


def ends_of_sides(model: Model) -> dict[int, list[tuple[int, int]]]:
    """For each corner that ends a side: the side's element, and the index of its reach that is zero there."""
    names = {c.name: k for k, c in enumerate(model.contacts)}
    result: dict[int, list[tuple[int, int]]] = {}
    count: dict[int, int] = {}
    for k, c in enumerate(model.contacts):
        side = edge_of(model.contacts, c) if c.stands else names.get(c.owner, k)
        if side != k and not c.presser:
            count[side] = 0 if c.stands else count.get(side, -1) + 1
            result[k] = [(side, count[side])]
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
        self.compliant = tuple(int(c.compliant) for c in self.model.contacts)
        self.adhesive = tuple(int(c.adhesion != 0) for c in self.model.contacts)
        self.presser = tuple(pressers(self.model.contacts))
        self.loaded = tuple(k for k, c in enumerate(self.model.contacts) if c.loaded)
        self.names = tuple(row.name for row in contact_layout(self.model.contacts))
        self.sides = sides_of(kernels.whole) if isinstance(kernels, SidedKernels) else None
        self.laws = 0 if self.sides is None else len(self.sides.laws)
        self._phases: dict[Any, Phase] = {}
        self.layouts: dict[Any, PhaseData] = {}
        self.checked: Mapping[str, float] | None = (
            None  # values of the last run: its coefficients are possible
        )
        self.spare: dict[Any, list[Any]] = {}  # memory of finished runs
        self.ends = ends_of_sides(self.model)

    @cached_property
    def endings(self) -> tuple[Ending, ...]:
        """Return the functions that may end a phase, contact by contact: normal, tangents, reaches, end of a side."""
        result: list[Ending] = []
        for k, n in enumerate(self.tangents):
            result += [Ending(k), *[Ending(k)] * (2 * (n == 1) + (n == 2))]
            result += [Ending(k, place) for place in range(self.candidates.pattern.contacts[k].reaches)]
            result += [Ending(side, place) for side, place in self.ends.get(k, ())]
        return tuple(result)

    @cached_property
    def program(self) -> DataProgram:
        """The function ``looked`` of all contacts."""
        n, E, m = self.model.n_u, len(self.first), self.rows
        none = self.holding(("open",) * E, self.kernels.active)
        return none.data({"looked": 9 * E + 2 * m + n + 2 * m * n})

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
        given = [coefficients(model, state, c) for c in model.contacts]
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
                *(float(x) for *laws, _, _ in given for x in laws),
                *(self._away(state, c, y[:n]) for c in model.contacts),
                *(float(N) for *_, N, _ in given),
                *(float(adhesion) for *_, adhesion in given),
            ]
        )

    def _away(self, state: State, contact: Any, q: Array) -> float:
        """Return the least rate of the reaches of a contact that are zero."""
        near, still = CLOSED * (1 + float(np.abs(q).max(initial=0))), [0.0] * self.model.n_u
        reaches = reaches_along(self.model, state, contact, still)
        return min((float(rate) for value, rate, _ in reaches if abs(value) <= near), default=np.inf)

    def snapshot(self, values: Array) -> Snapshot:
        """Return the outputs of ``looked`` by their names."""
        n_u, E, m = self.model.n_u, len(self.first), self.rows
        parts, at = [], 0
        for size in (E, E, m, m, n_u, m * n_u, m * n_u, 4 * E, E, E, E):
            parts.append(values[at : at + size])
            at += size
        gap, reach, rate, c, free, matrix, responses, laws, away, _, _ = parts
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

    def holding(self, modes: Modes, active: tuple[int, ...], sides: tuple[float, ...] = ()) -> Phase:
        """Return a set of modes with these independent conditions: the machine's own, then those of contacts.

        ``sides`` are those of the laws that switch, if these are data of the scene.
        """
        key = (modes, active, sides)
        if key not in self._phases:
            self._phases[key] = Phase(self, modes, active, sides or (0.0,) * self.laws)
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
        loop.code(_NEWTON, "factor")(seen.between(held), m, np.zeros(m * m), DEPENDENT, np.zeros(m), order)
        return [self.candidates.own + i for i in np.flatnonzero(order).tolist()]


@dataclass(frozen=True)
class Ending:
    """A function that ends a phase when it falls through zero: its contact, and the end of a side among its reaches."""

    contact: int
    place: int = -1


class Phase:
    """The motion in one set of modes; the state is (q, u, W, heat)."""

    def __init__(
        self, scene: Scene, modes: Modes, active: tuple[int, ...], sides: tuple[float, ...] = ()
    ) -> None:
        self.scene, self.modes, self.active, self.sides = scene, modes, active, sides
        self.model = scene.model
        self.loose: Any = None
        self.shown: Modes = modes
        self.own = scene.kernels.active
        self.conditions = scene.conditions(modes)
        self._programs: dict[Any, Any] = {}

    def __reduce__(self) -> Any:
        return phase_of, (self.scene.kernels, self.modes, self.active, self.sides)

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
            self._program(
                "motion", lambda: self.data({"rates": self.size, "tangent": self.size, "projection": moved})
            ),
        )

    def contact(self) -> DataProgram:
        """Functions ``gap``, ``reach``, ``static_friction`` (E), ``rate``, ``acceleration`` and ``force`` (m)."""
        E = len(self.modes)
        sizes = {
            "gap": E,
            "reach": E,
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

    def whole(
        self, expressions: Sequence[Any], patches: Any = None, sensed: Sequence[Any] = ()
    ) -> DataProgram:
        """Functions ``rates``, ``projection`` and ``watched`` with room for any modes.

        The last gives the user's expressions, approach and kept of the ``patches`` of the run, if it has any, then the
        functions that end the phase (:attr:`Scene.endings`). It leaves the quantities of contacts that these and those
        ``sensed`` take behind the state in ``inputs``.
        """

        def make() -> DataProgram:
            count, asked = len(expressions) + self.scene.laws, asked_by((*expressions, *sensed))
            values: Any = watched_program(self.scene.kernels, expressions, asked) if count else None
            moved = self.model.n_q + self.model.n_u
            if patches is not None:
                values, count = patches.with_values(values, count), count + patches.functions_count
            sizes = {
                "rates": self.size,
                "tangent": self.size,
                "projection": moved,
                "watched": count + len(self.scene.endings),
            }
            return self.data(
                sizes, values=values, count=count, whole=True, asked=asked, first=len(expressions)
            )

        key = tuple(expressions), tuple(sensed)
        return make() if patches is not None else cast(DataProgram, self._program(key, make))

    def rates_of(self, program: DataProgram, constants: Array) -> Rates:
        """Return the right-hand side, and the projection, of a program with these constants."""
        return Rates(
            program.address("rates"), self.size, constants, self.model.quaternions, program,
            projection=program.address("projection"), projected=program.outputs("projection"),
            method_kernels=(program.address("tangent"),),
        )  # fmt: skip

    def rates(self, parameters: Array) -> Rates:
        """Return the right-hand side with the constants of these parameters."""
        program = self.motion()
        result = Rates(
            program.address("rates"), self.size, program.constants(parameters), self.model.quaternions, program,
            method_kernels=(program.address("tangent"),), recipe=(self.rates, parameters),
        )  # fmt: skip
        if not self.active:
            return result
        return replace(
            result, projection=program.address("projection"), projected=program.outputs("projection")
        )

    # -- data ------------------------------------------------------------------------------------

    def data(
        self,
        outputs: Mapping[str, int],
        derived: tuple[str, Any] | None = None,
        values: Any = None,
        count: int = 0,
        whole: bool = False,
        source: Source | None = None,
        asked: Asked = (),
        first: int = 0,
    ) -> DataProgram:
        """Return compiled functions for these modes.

        Parameters
        ----------
        outputs     function of a phase -> number of its outputs; ``watched`` needs endings
        derived     name and program of a function of the state, accelerations, forces and multipliers
        values      program of the ``count`` functions of the user, and of laws that switch from ``first``
        whole       True for room for any modes
        asked       quantities of contacts that these take
        source      where the functions and the kernels stand; by default, on this computer
        """
        candidates = self.scene.candidates
        code, program, power, bearings = source or Source.here(candidates)
        programs = {"machine": (program, "machine")}
        found = {name: (code(name), size) for name, size in outputs.items()}
        if power is not None:
            programs["power"] = power, "power"
        if bearings is not None:
            programs["bearings"] = bearings, "bearings"
        if values is not None:
            programs["values"] = values, "values"
        if derived is not None:
            name, of_forces = derived
            programs["derived"] = of_forces, name
            found[name] = code("derived"), of_forces.outputs(name)
        data = phase_data(self, programs, "watched" in outputs, whole, asked)
        data.expressions, data.first_law = count, first
        modes = np.array([NUMBERS[mode.partition(" ")[0]] for mode in self.modes], dtype=np.int64)
        active = np.array([i - candidates.own for i in self.active[len(self.own) :]], dtype=np.int64)
        functions()["set_modes"](data, modes, np.zeros_like(modes), active, active.size)
        return DataProgram(found, data, {name: program for name, (program, _) in programs.items()})


class Source(NamedTuple):
    """Address of each function of `phase_kernels`, and programs of the candidates, the power of drives and bearings."""

    code: Callable[[str], int]
    candidates: Any
    power: Any
    bearings: Any

    @classmethod
    def here(cls, candidates: Candidates) -> Source:
        """Return the functions and kernels on this computer."""
        power = candidates.power() if candidates.driven else None
        bearings = candidates.bearings() if any(c.loaded for c in candidates.model.contacts) else None
        return cls(lambda name: functions()[name].address, candidates.program(), power, bearings)


def phase_of(kernels: Kernels, modes: Modes, active: tuple[int, ...], sides: tuple[float, ...] = ()) -> Phase:
    """Return a set of modes of a machine, with the sides of the laws that switch.

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
    known = known and len(sides) in (0, scene.laws) and {*sides} <= {-1, 0, 1}
    if not known or len(set(active)) != len(active) or not all(0 <= i < last for i in active):
        raise SimulationError(
            f"Expected modes and conditions of the contacts of '{kernels.model.name}', got {modes} and {active}: the "
            "motion is not of this machine."
        )
    return scene.holding(modes, active, sides)


def scene_of(kernels: Kernels) -> Scene:
    """Return the compiled contacts of a machine, kept for its next run."""
    scene = getattr(kernels, "_scene", None)
    if scene is None:
        scene = Scene(kernels)
        kernels._scene = scene  # type: ignore[attr-defined]
    return scene
