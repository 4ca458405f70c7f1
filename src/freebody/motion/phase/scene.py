"""The contacts of a machine as numbers at one moment, and its sets of modes.

The numbers are gap, speeds and accelerations of all contacts, their rows W and the change of u' per unit of force.
"""

from __future__ import annotations

import copyreg
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

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
from ..kernels.kernels import Kernels
from ..kernels.sides import SidedKernels, sides_of
from ..ode.dense_output import Array, outputs_at
from .candidates.candidates import Candidates
from .laws import CLOSED, DEPENDENT
from .phase import KINDS, LIMIT, Modes, Phase, direction_of
from .phase_data import DataProgram
from .phase_record import PhaseData

_NEWTON = "motion.cones.newton"


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


@dataclass(frozen=True)
class Ending:
    """A function that ends a phase when it falls through zero: its contact, and the end of a side among its reaches."""

    contact: int
    place: int = -1


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


def _reduced(phase: Phase) -> tuple[Any, ...]:
    """Return how a phase is made again from a file or in another process."""
    return phase_of, (phase.scene.kernels, phase.modes, phase.active, phase.sides)


copyreg.pickle(Phase, _reduced)


def scene_of(kernels: Kernels) -> Scene:
    """Return the compiled contacts of a machine, kept for its next run."""
    scene = getattr(kernels, "_scene", None)
    if scene is None:
        scene = Scene(kernels)
        kernels._scene = scene  # type: ignore[attr-defined]
    return scene
