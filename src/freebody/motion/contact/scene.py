"""Compiled code of a machine with contacts: the quantities that decide mode changes, and the equations of each phase.

scene    gap, speeds and accelerations of all contacts, A = W M⁻¹ Wᵀ and the change of u' per unit of force
phase    equations of one set of modes, contact forces, and the functions that end the phase
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, cast

import numpy as np

from ...dynamics import State, coordinate_rates, kinetic_energy, potential_energy
from ...dynamics.composite import mass_matrix
from ...dynamics.constrained import constrained_loading
from ...dynamics.constraints import linearized, rows
from ...dynamics.contact import contact_layout, contact_rows, touches
from ...dynamics.contact_motion import (
    contact_accelerations,
    contact_forces,
    contact_problem,
    friction_power,
    in_modes,
)
from ...dynamics.linear import Elimination, Factorization
from ...dynamics.motion import Motion, total_power
from ...dynamics.state import float_state
from ...dynamics.unilateral import multiplier_sizes
from ...model import Model
from ...model.contact import Contact
from ...scalar.derivative import forward
from ...scalar.trace import Tape
from ..kernels.kernels import Kernels, Program
from ..ode.dense_output import Array, observe
from .complementarity import SMALL

STOPPED = 1e-8
"""Slip speed in space below which the slip ends with one straight step [m/s]."""
_STOPPED_SQUARE = Fraction(1, 10**16)

Modes = tuple[str, ...]
"""Mode of every contact: open, stick, slip+, slip-, slip or smooth."""

SMOOTH = "smooth"
"""Mode of a closed contact whose friction is zero in this run: the sense of its slip is not watched."""


@dataclass(frozen=True)
class Snapshot:
    """The contacts at one moment: E elements, m rows in the order of :func:`contact_layout`."""

    gap: Array
    reach: Array
    rate: Array
    A: Array
    c: Array
    responses: Array
    free: Array
    friction: Array
    static: Array
    restitution: Array


def scene_of_layout(model: Model) -> tuple[list[int], list[int], int]:
    """Return the first row and the number of tangents of every element, and the number of rows."""
    layout = contact_layout(model.contacts)
    kinds = [(row.contact, row.kind) for row in layout]
    count = range(len(model.contacts))
    return [kinds.index((k, "N")) for k in count], [kinds.count((k, "T")) for k in count], len(layout)


def _ends(model: Model) -> dict[int, list[tuple[int, int]]]:
    """For each corner that ends a side: the side's element, and the index of its reach that is zero there."""
    names = {c.name: k for k, c in enumerate(model.contacts)}
    result: dict[int, list[tuple[int, int]]] = {}
    for k, c in enumerate(model.contacts):
        side = names.get(c.owner, k)
        if side != k:
            result[k] = [(side, k - side - 1)]
    return result


def _described(contact: Contact, mode: str) -> Any:
    """Return a mode in the form that `in_modes` expects."""
    if mode != SMOOTH:
        return mode
    return "slip+" if contact.tangents == 1 else ("slip", (1, 0))


ROUNDED = Fraction(1, 2**44)
"""Round-off of a contact force relative to the sum of its parts: 256 units in the last place.

A sum of n parts, or the Cholesky solution of n equations, has an error of n units in the last place of Σ|parts|
(Higham, Accuracy and Stability, 2002, chapters 4 and 10). The value therefore suits machines of up to some hundred
speeds and closed contacts. Contacts with almost dependent rows lose more digits, by the condition number of A, and are
not covered. With this ε, contact ends at N < -ε P and stick ends at |T| > μ N + ε (1 + μ) P, where P is the sum of the
parts of all closed contacts. A load exactly at a limit then causes one decision only: the present law continues at
equality.
"""


class Scene:
    """The contacts of a model as numbers, computed by one compiled kernel."""

    def __init__(self, kernels: Kernels) -> None:
        self.kernels = kernels
        self.model: Model = kernels.model
        self.first, self.tangents, self.rows = scene_of_layout(self.model)
        self.names = tuple(row.name for row in contact_layout(self.model.contacts))
        self._phases: dict[Any, Phase] = {}
        self._moded: dict[Modes, Model] = {}
        self._reaching: list[int] = []
        self.ends = _ends(self.model)

    def _functions(self, state: State) -> Mapping[str, Sequence[Any]]:
        model = self.model
        given = contact_rows(model, state)
        problem = contact_problem(model, state, self.kernels.active)
        seen = touches(model, state)
        self._reaching = [len(one.reach) for one in seen]
        coefficients = [
            state(x) for c in model.contacts for x in (c.friction, c.static_friction, c.restitution)
        ]
        return {
            "scene": [
                *given.gap,
                *given.rate,
                *problem.c,
                *problem.free,
                *(x for row in problem.A for x in row),
                *(x for row in problem.responses for x in row),
                *coefficients,
                *(x for one in seen for x in one.reach),
            ]
        }

    @cached_property
    def program(self) -> Program:
        """The compiled functions of the contacts."""
        return self.kernels.program("scene", self._functions)

    def constants(self, parameters: Array) -> Array:
        """Return the constants of the kernel for these parameters."""
        return self.program.constants(parameters)

    def slopes(self, t: float, y: Array, parameters: Array, udot: Array, forces: Array) -> Array:
        """Return d(A λ + c)/dt along the motion with the accelerations ``udot``, for constant λ."""

        def functions(state: State, given: Sequence[Any]) -> Mapping[str, Sequence[Any]]:
            along, lam = given[: self.model.n_u], given[self.model.n_u :]
            rates = contact_accelerations(self.model, state, lam, self.kernels.active)
            seeds = [1, *coordinate_rates(self.model, state), *along]
            place = [state.t, *state.q, *state.u]
            return {"slopes": forward(cast(Tape, state.field), rates, place, seeds)}

        program = self.kernels.program("slopes", functions, self.model.n_u + self.rows)
        given = np.concatenate([y[: self.model.n_q + self.model.n_u], udot, forces])
        return observe(
            program.address("slopes"), self.rows, np.array([t]), given[None], program.constants(parameters)
        )[0]

    def at(self, t: float, y: Array, constants: Array) -> Snapshot:
        """Return the contacts at a state."""
        program = self.program
        values = observe(
            program.address("scene"), program.outputs("scene"), np.array([t]), y[None], constants
        )[0]
        if not self._reaching:
            self._reaching = [len(one.reach) for one in touches(self.model, self._float(t, y, constants))]
        return self.snapshot(values)

    def snapshot(self, values: Array) -> Snapshot:
        """Return the outputs of :meth:`_functions` by their names."""
        n_u, E, m = self.model.n_u, len(self.first), self.rows
        parts, at = [], 0
        for size in (E, m, m, n_u, m * m, m * n_u, 3 * E):
            parts.append(values[at : at + size])
            at += size
        reach = np.full(E, np.inf)
        for k, size in enumerate(self._reaching):
            if size:
                reach[k] = values[at : at + size].min()
            at += size
        coefficients = parts[6].reshape(E, 3)
        return Snapshot(
            parts[0], reach, parts[1], parts[4].reshape(m, m), parts[2], parts[5].reshape(m, n_u), parts[3],
            coefficients[:, 0], coefficients[:, 1], coefficients[:, 2],
        )  # fmt: skip

    def _float(self, t: float, y: Array, constants: Array) -> State:
        del constants
        n = self.model.n_q
        return float_state(self.model, y[:n].tolist(), y[n : n + self.model.n_u].tolist(), t)

    def phase(self, modes: Modes, seen: Snapshot | None = None) -> Phase:
        """Return the equations of a set of modes; ``seen`` decides which contact conditions are independent."""
        active = self.kernels.active
        if seen is not None:
            active = (*active, *self._independent(modes, seen.A))
        return self.holding(modes, active)

    def holding(self, modes: Modes, active: tuple[int, ...]) -> Phase:
        """Return the equations of a set of modes with these independent conditions."""
        if modes not in self._moded:
            named = {
                c.name: _described(c, mode)
                for c, mode in zip(self.model.contacts, modes, strict=True)
                if mode != "open"
            }
            self._moded[modes] = in_modes(self.model, named) if named else self.model
        key = (modes, active)
        if key not in self._phases:
            self._phases[key] = Phase(self, self._moded[modes], modes, active)
        return self._phases[key]

    def _independent(self, modes: Modes, A: Array) -> list[int]:
        """Return independent conditions of closed contacts by Cholesky pivots of A; earlier ones take precedence."""
        held = [
            i
            for k, mode in enumerate(modes)
            if mode != "open"
            for i in range(self.first[k], self.first[k] + 1 + (self.tangents[k] if mode == "stick" else 0))
        ]
        kept: list[int] = []
        L = np.zeros((len(held), len(held)))
        for place, i in enumerate(held):
            count = len(kept)
            row = np.array([A[i, held[j]] for j in kept])
            for j in range(count):
                row[j] = (row[j] - L[j, :j] @ row[:j]) / L[j, j]
            left = A[i, i] - row @ row
            if left > SMALL * A[i, i]:
                L[count, :count] = row
                L[count, count] = np.sqrt(left)
                kept.append(place)
        own = len(rows(self.model))
        return [own + place for place in kept]


@dataclass(frozen=True)
class Ending:
    """A function that ends a phase when it falls through zero: its contact and its meaning."""

    contact: int
    law: str  # gap, normal, cone, slip, reach, side
    sign: int = 0
    place: int = 0  # index of the end of a side among its reaches


class Phase(Kernels):
    """Compiled equations of one set of modes; the state is (q, u, W, heat)."""

    def __init__(self, scene: Scene, model: Model, modes: Modes, active: tuple[int, ...]) -> None:
        super().__init__(model, active)
        self.scene = scene
        self.modes = modes
        self._work = True
        self._endings: dict[Any, tuple[Ending, ...]] = {}
        self.loose: Any = None
        self.shown: Modes = modes
        self._closed = any(mode != "open" for mode in modes)

    def __reduce__(self) -> Any:
        return phase_of, (self.scene.kernels, self.modes, self.active)

    @cached_property
    def size(self) -> int:
        """Number of components of y."""
        return self.model.n_q + self.model.n_u + 2

    # -- equations -------------------------------------------------------------------------------

    def motion(self) -> Program:
        """Functions ``rates`` (of q, u, work and heat of friction), ``energy`` and ``projection``.

        Only phases with active conditions have ``projection``.
        """

        def functions(state: State) -> dict[str, Sequence[Any]]:
            moving = self._motion(state)
            forces = contact_forces(self.model, state, moving.multipliers)
            heat = -friction_power(self.model, state, forces) if self._closed else 0
            found: dict[str, Sequence[Any]] = {
                "rates": [
                    *coordinate_rates(self.model, state),
                    *moving.udot,
                    total_power(self.model, state, moving),
                    heat,
                ],
                "energy": [kinetic_energy(self.model, state), potential_energy(self.model, state)],
            }
            if self.active:
                found["projection"] = self._projected(state)
            return found

        return self.program("motion", functions)

    def _motion(self, state: State) -> Motion:
        """Return the motion; indeterminate forces are those of contacts of equal compliance.

        Where the motion does not depend on them, N is then least in norm, and T is the least in Σ |T|²/N.
        Friction shared in proportion to N reaches its limit at all contacts of a sliding body at once.
        """
        moving = super()._motion(state)
        if not self.spare:
            return moving
        moving = self._shared(state, moving, [1] * len(moving.multipliers))
        if not linearized(self.model, state).symmetric:
            return moving
        kinds = rows(self.model)
        normal = {row.owner: x for row, x in zip(kinds, moving.multipliers, strict=True) if not row.on_speeds}
        mine = {c.name for c in self.model.contacts}
        weights = [normal[row.owner] if row.on_speeds and row.owner in mine else 1 for row in kinds]
        return self._shared(state, moving, weights)

    def _shared(self, state: State, moving: Motion, weights: Sequence[Any]) -> Motion:
        """Return the motion with the forces λ of least Σ λ²/w that satisfy the independent conditions.

        With K their generalized forces and S = G M⁻¹ Kᵀ:  S λ = S λ₀,  λ = W Sᵀ ν,  (S W Sᵀ) ν = S λ₀. In slip, where
        K differs from G, λ = W G M⁻¹ Gᵀ ν is in the range of the conditions: contacts of equal compliance.
        """
        given = linearized(self.model, state)
        M = Factorization(mass_matrix(self.model, state))
        mine = [*self.active, *self.spare]
        X = [M.solve(given.acting[i]) for i in mine]
        S = [[_dot(given.matrix[i], x) for x in X] for i in self.active]
        same = X if given.symmetric else [M.solve(given.matrix[i]) for i in mine]
        G = [[_dot(given.matrix[i], x) for x in same] for i in self.active]
        weighted = [[weights[i] * x for i, x in zip(mine, row, strict=True)] for row in G]
        square = [[_dot(a, b) for b in weighted] for a in S]
        goal = [_dot(row, [moving.multipliers[i] for i in mine]) for row in S]
        nu = (Factorization(square) if given.symmetric else Elimination(square)).solve(goal)
        multipliers, udot = list(moving.multipliers), list(moving.udot)
        for place, (i, x) in enumerate(zip(mine, X, strict=True)):
            value = _dot([row[place] for row in weighted], nu)
            if not given.symmetric:  # with symmetric conditions the motion does not change
                udot = [a + (value - multipliers[i]) * b for a, b in zip(udot, x, strict=True)]
            multipliers[i] = value
        return Motion(tuple(udot), tuple(multipliers), constrained_loading(self.model, state, multipliers))

    @cached_property
    def spare(self) -> list[int]:
        """Redundant contact conditions: they follow from the others."""
        names = {c.name for c in self.model.contacts}
        return [i for i, row in enumerate(rows(self.model)) if row.owner in names and i not in self.active]

    # -- contacts --------------------------------------------------------------------------------

    def _quantities(self, state: State) -> dict[str, list[Any]]:
        moving = self._motion(state)
        forces = contact_forces(self.model, state, moving.multipliers)
        given = contact_rows(self.model, state)
        a = [_dot(row, moving.udot) + b for row, b in zip(given.matrix, given.bias, strict=True)]
        lam: list[Any] = []
        for k, contact in enumerate(self.model.contacts):
            n = 1 + self.scene.tangents[k]
            lam += list(forces.get(contact.name, (0,) * n))
        return {"gap": list(given.gap), "rate": list(given.rate), "acceleration": a, "force": lam}

    def _parts(self, state: State) -> Any:
        """Sum of the parts of the forces of all closed contacts [N]."""
        mine = {c.name for c in self.model.contacts}
        held = [i for i, row in enumerate(rows(self.model)) if row.owner in mine and i in self.active]
        return sum(multiplier_sizes(self.model, state, held).values())

    def contact(self) -> Program:
        """Functions ``gap`` (E), ``rate``, ``acceleration`` and ``force`` (m) of all contacts."""
        return self.program("contact", self._quantities)

    def _elsewhere(self, k: int) -> bool:
        """Return True if the foot is on the side that this corner ends, or on a corner of this side."""
        ends = self.scene.ends
        return any(self.modes[side] != "open" for side, _ in ends.get(k, ())) or any(
            self.modes[j] != "open" and (k, place) in ends[j] for j in ends for place in (0, 1)
        )

    def watching(
        self, expressions: Sequence[Any], dead: frozenset[int] = frozenset()
    ) -> tuple[Program, tuple[Ending, ...]]:
        """Function ``values``: the user's expressions, then the functions that end the phase.

        ``dead`` are contacts that the others hold: open contacts with constant zero gap, slipping contacts with
        constant zero slip.
        """
        endings: list[Ending] = []

        def functions(state: State) -> dict[str, Sequence[Any]]:
            found = self._quantities(state)
            seen = touches(self.model, state)
            values: list[Any] = [state(e) for e in expressions]
            endings.clear()

            size = self._parts(state)

            def end(value: Any, contact: int, law: str, sign: int = 0, place: int = 0) -> None:
                values.append(value)
                endings.append(Ending(contact, law, sign, place))

            for k, (contact, mode) in enumerate(zip(self.model.contacts, self.modes, strict=True)):
                at, n = self.scene.first[k], self.scene.tangents[k]
                if mode == "open":
                    if k not in dead and not self._elsewhere(k):
                        end(found["gap"][k], k, "gap")
                    continue
                N, T = found["force"][at], found["force"][at + 1 : at + 1 + n]
                v = found["rate"][at + 1 : at + 1 + n]
                end(N + ROUNDED * size, k, "normal")
                for place, x in enumerate(seen[k].reach):
                    end(x, k, "reach", place=place)
                for side, place in self.scene.ends.get(k, ()):
                    end(-seen[side].reach[place], side, "side", place=place)
                if mode == "stick":
                    mu = state(contact.static_friction)
                    most = mu * N + ROUNDED * (1 + mu) * size
                    if n == 1:
                        end(most - T[0], k, "cone", 1)
                        end(most + T[0], k, "cone", -1)
                    else:
                        end(most * most - T[0] * T[0] - T[1] * T[1], k, "cone")
                elif mode in ("slip+", "slip-") and k not in dead:
                    end(v[0] if mode == "slip+" else -v[0], k, "slip")
                elif mode == "slip" and n == 2 and not contact.frictionless:
                    end(v[0] * v[0] + v[1] * v[1] - _STOPPED_SQUARE, k, "slip")
            return {"values": values}

        key = ("watch", tuple(expressions), dead)
        program = self.program(key, functions)
        if key not in self._endings:
            self._endings[key] = tuple(endings)
        return program, self._endings[key]


def _dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    total: Any = 0
    for x, y in zip(a, b, strict=True):
        total = total + x * y
    return total


def phase_of(kernels: Kernels, modes: Modes, active: tuple[int, ...]) -> Phase:
    """Return the equations of a set of modes of a machine."""
    return scene_of(kernels).holding(modes, active)


def scene_of(kernels: Kernels) -> Scene:
    """Return the compiled contacts of a machine, kept for its next run."""
    scene = getattr(kernels, "_scene", None)
    if scene is None:
        scene = Scene(kernels)
        kernels._scene = scene  # type: ignore[attr-defined]
    return scene
