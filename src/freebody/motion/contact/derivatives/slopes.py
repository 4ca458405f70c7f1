"""Derivatives of the equations of phases along changes of the state, of time and of the unknowns, and their names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np

from ....errors import NoDerivativesError
from ....model import Model
from ....native import loop
from ...events.rings import POINTS
from ...kernels.contact_quantities import NAMES
from ...kernels.kernels import Kernels
from ...kernels.program import at_state
from ...legs.driven_slopes import inputs_of
from ...legs.variation import Unknown
from ...ode.dense_output import Array, Rates, outputs_at
from ...phase.candidates.candidate_slopes import candidate_slopes
from ...phase.phase import Phase
from ...phase.scene import Scene, Snapshot, scene_of
from ...phase.slopes_record import PhaseSlopes, phase_slopes

_MODULES = "motion.phase.phase_slopes", "motion.phase.projection"
_FUNCTIONS = ("varied", "slopes", "corrected_state")
CURE = (
    "Ask for the derivatives of a motion that ends before, by unknowns that do not change this event, or take "
    "differences of runs with values= that differ."
)


ENERGIES = ("kinetic_energy", "potential_energy", "energy")


@dataclass(frozen=True, eq=False)
class Touch:
    """Outputs of the kernel of a contact at a state, or their derivatives along a direction."""

    scene: Scene
    k: int
    outputs: Array

    @property
    def pattern(self) -> Any:
        """Places among the outputs."""
        return self.scene.candidates.pattern.contacts[self.k]

    @property
    def gap(self) -> float:
        """The gap."""
        return float(self.outputs[0])

    @property
    def reaches(self) -> Array:
        """Distances inside the ends of sides."""
        return self.outputs[1 : 1 + self.pattern.reaches]

    @property
    def rates(self) -> Array:
        """Rates of the gap and along the tangents."""
        at = self.pattern.rates
        return self.outputs[at : at + 1 + self.scene.tangents[self.k]]

    @property
    def laws(self) -> Array:
        """μ, μ_s, e, μ at rest, the normal force that the state gives, and the pull that the contact bears."""
        return self.outputs[self.pattern.laws :][:6]

    def row(self, r: int) -> Array:
        """Return row r of W, in the order of the speeds."""
        pattern, result = self.scene.candidates.pattern, np.zeros(self.scene.model.n_u)
        first, count, place = pattern.rows[r]
        for i in range(count):
            result[pattern.order[pattern.columns[first + i]]] = self.outputs[place + i]
        return result


NORMAL_FORCE, ADHESION = 4, 5
"""Places among the `Touch.laws`."""


class Direction(NamedTuple):
    """Derivatives at a state along a change (s, τ, dp): of (q', u'), the contact forces, and the contacts' outputs."""

    rates: Array
    forces: Array
    touches: Array


class Slopes:
    """The derivatives of a run by its unknowns, in any of its phases, while parameters have these values.

    ``symbols``  parameters among the unknowns, and those that controllers set
    ``seeds``    change of each of these with each unknown, shape (unknowns, symbols)
    """

    def __init__(
        self, kernels: Kernels, unknowns: Sequence[Unknown], parameters: Array, seeds: Any = None
    ) -> None:
        self.kernels, self.model, self.unknowns = kernels, kernels.model, tuple(unknowns)
        self.scene: Scene = scene_of(kernels)
        self.parameters = parameters
        symbols = [x.symbol for x in self.unknowns if x.symbol is not None]
        self.symbols = [*symbols, *(x for x in inputs_of(self.model) if x not in symbols)]
        if seeds is None:
            seeds = np.array([[float(x.symbol == p) for p in self.symbols] for x in self.unknowns])
        self.seeds: Array = seeds.reshape(len(self.unknowns), len(self.symbols))
        self.moved = self.model.n_q + self.model.n_u
        self.starts = [0, *accumulate(self.scene.candidates.pattern.sizes)]
        self._constants: dict[int, tuple[PhaseSlopes, Array]] = {}

    def __reduce__(self) -> Any:
        return Slopes, (self.kernels, self.unknowns, self.parameters, self.seeds)

    @property
    def size(self) -> int:
        """Number of components of (q, u, work, heat) and of all derivatives of (q, u)."""
        return self.moved + 2 + len(self.unknowns) * self.moved

    @cached_property
    def looking(self) -> Array:
        """Constants of the functions of all contacts."""
        return self.scene.constants(self.parameters)

    def look(self, t: float, y: Array) -> Snapshot:
        """Return the contacts at a state."""
        return self.scene.at(t, np.ascontiguousarray(y, dtype=float), self.looking)

    def _of(self, phase: Phase) -> tuple[PhaseSlopes, Array]:
        key = id(phase)
        if key not in self._constants:
            self._constants[key] = self._made(phase, np.zeros(len(self.unknowns)))
        return self._constants[key]

    def _made(self, phase: Phase, shifts: Array) -> tuple[PhaseSlopes, Array]:
        constants = phase.motion().constants(self.parameters)
        made = phase_slopes(self.scene, constants, self.parameters, self.symbols, self.seeds, shifts)
        return made, constants

    def rates(self, phase: Phase, shifts: Array) -> Rates:
        """Return the right-hand side of (q, u, work, heat) and of the derivatives of y(t + θ p, p) in a phase."""
        it, constants = self._made(phase, shifts)
        keep = constants, it, self
        projection = slopes_code("corrected_state").address if phase.active else 0
        return Rates(
            slopes_code("varied").address, self.size, it.memory, self.model.quaternions, keep,
            projection=projection, projected=self.size if projection else 0, recipe=(self.rates, phase, shifts),
        )  # fmt: skip

    def velocity(self, phase: Phase, t: float, y: Array) -> Array:
        """Return (q', u') in a phase."""
        return at_state(phase.motion(), "rates", t, y, self._of(phase)[1])[: self.moved]

    def forces(self, phase: Phase, t: float, y: Array) -> Array:
        """Return the contact forces in a phase."""
        return self._contact("force", phase, t, y)

    def accelerations(self, phase: Phase, t: float, y: Array) -> Array:
        """Return the derivatives of the rates of all contacts in a phase."""
        return self._contact("acceleration", phase, t, y)

    def _contact(self, name: str, phase: Phase, t: float, y: Array) -> Array:
        program = phase.contact()
        return at_state(program, name, t, y, program.constants(self.parameters))

    def along(
        self, phase: Phase, t: float, y: Array, s: Array, tau: float = 0.0, dp: Any = None
    ) -> Direction:
        """Return the derivatives along a direction in a phase."""
        it, _ = self._of(phase)
        change = np.zeros(len(self.symbols)) if dp is None else dp
        given = np.concatenate([y[: self.moved], [0.0, 0.0], s, [tau], change])
        n, rows = self.moved, self.scene.rows
        found = outputs_at(slopes_code("slopes").address, n + rows + self.starts[-1], t, given, it.memory)
        return Direction(found[:n], found[n : n + rows], found[n + rows :])

    # -- at a state, without a phase ---------------------------------------------------------------

    def outputs(self, k: int, t: float, y: Array) -> Touch:
        """Return the outputs of a contact."""
        program, (name, own) = self.scene.candidates.program(), self.scene.candidates.kernel_of(k)
        found = at_state(program, name, t, y[: self.moved], program.constants(self.parameters))
        return Touch(self.scene, k, found[own])

    def of_contact(self, k: int, t: float, y: Array, s: Array, tau: float, dp: Array) -> Touch:
        """Return the derivatives of the outputs of a contact along a direction."""
        name, own = self.scene.candidates.kernel_of(k)
        return Touch(self.scene, k, self._output(name, t, y, np.zeros(self.model.n_u), s, tau, dp)[own])

    def touch(self, along: Direction, k: int) -> Touch:
        """Return the derivatives of the outputs of a contact, of which those of all are known."""
        return Touch(self.scene, k, along.touches[self.starts[k] : self.starts[k + 1]])

    def of_momentum(self, t: float, y: Array, w: Array, s: Array, tau: float, dp: Array) -> Array:
        """Return the derivative of M w along a direction."""
        return self._machine(t, y, w, s, tau, dp)[self.model.n_u :][: self.model.n_u]

    def of_conditions(self, t: float, y: Array, s: Array, tau: float, dp: Array) -> tuple[Array, Array]:
        """Return the derivatives of the rates of the machine's own conditions, and of G, along a direction."""
        n, w = self.model.n_u, np.zeros(self.model.n_u)
        own = len(self.kernels.active)
        G = self._machine(t, y, w, s, tau, dp)[2 * n + own :].reshape(own, n)
        return self._output("rates", t, y, w, s, tau, dp), G

    def mass(self, t: float, y: Array) -> tuple[Array, Array]:
        """Return M, and G of the machine's own conditions."""
        n, zero = self.model.n_u, np.zeros(self.moved)
        found = self._output("mass", t, y, zero[:n], zero, 0.0, np.zeros(len(self.symbols))).reshape(-1, n)
        return found[:n], found[n:]

    def _machine(self, t: float, y: Array, w: Array, s: Array, tau: float, dp: Array) -> Array:
        """Return the derivatives of h - Q, M w, γ and G along a direction."""
        return self._output("machine", t, y, w, s, tau, dp)[self.model.n_q :]

    def _output(self, name: str, t: float, y: Array, w: Array, s: Array, tau: float, dp: Array) -> Array:
        program = candidate_slopes(self.scene.candidates, self.symbols)
        given = np.concatenate([y[: self.moved], w, s, [tau], dp])
        return at_state(program, name, t, given, program.constants(self.parameters))


def slopes_code(name: str) -> loop.Function:
    """Return a compiled function of `phase_slopes`."""

    def named() -> dict[str, Any]:
        from ...phase import phase_slopes, projection

        return vars(projection) | vars(phase_slopes)

    return loop.made(_MODULES[0], _MODULES, _FUNCTIONS, named, passes="few").functions[name]


def turned_points(model: Model, parameters: Array) -> list[range]:
    """Return the points of each disk that have turned with the load (`events.rings`), as numbers of contacts."""
    values = dict(zip((p.name for p in model.parameters), parameters.tolist(), strict=True))
    return [
        range(ring.first, ring.first + POINTS)
        for ring in model.rings
        if tuple(values[name] for name in ring.names) != (1.0, 0.0)
    ]


def title(slopes: Slopes, k: int) -> str:
    """Return how messages name a contact."""
    return f"contact '{slopes.model.contacts[k].name}'"


def refused(slopes: Slopes, t: float, what: str) -> NoDerivativesError:
    """Return the error for a motion without derivatives after a time."""
    return NoDerivativesError(
        f"The motion of '{slopes.model.name}' has no derivatives by the unknowns of sensitivities= after t = {t:.9g} "
        f"s: {what}. {CURE}"
    )


def without_derivative(name: str) -> NoDerivativesError:
    """Return the error for a quantity without a derivative."""
    return NoDerivativesError(
        "Expected a quantity of coordinates, speeds, time and parameters, one of "
        f"{', '.join(ENERGIES)}, or {', '.join(NAMES)} of a contact with one coefficient of friction that no end "
        f"of a side has left, for a derivative of a motion with contacts, got '{name}'."
    )
