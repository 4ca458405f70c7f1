"""Derivatives of the load of a joint in an impact: the impulses of its reaction bound that of its friction.

    P = r (|F_a| + |F_b|),      dP = dr (|F_a| + |F_b|) + r (F_a·dF_a/|F_a| + F_b·dF_b/|F_b|)

F is affine in the accelerations, the forces and the multipliers of a motion: the jump of the speeds, the impulses and
those of the machine's own conditions take their place, and what F is without them is taken away
(`events.impacts.loaded_impacts`). The reactions of a blow are added to F where its friction follows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...dynamics.bearing_loads import LOADED
from ...errors import NoDerivativesError
from ..kernels.program import at_state
from ..ode.dense_output import Array
from ..phase.candidates.candidate_slopes import bearing_slopes

NONE = 1e-12
"""Part of the load of a joint below which a place of it bears nothing."""


@dataclass(frozen=True, eq=False)
class Load:
    """The load of a joint in an impact.

    ``size``          P, and its derivatives ``by_jump`` of the speeds, ``by_impulses`` of all rows, and ``by_own``, by
                      the impulses of the machine's own active conditions
    ``slopes``        `contact.derivatives.slopes.Slopes`
    """

    size: float
    by_jump: Array
    by_impulses: Array
    by_own: Array
    slopes: Any
    hit: Any
    place: int

    def change(self, j: int, s: Array, tau: float) -> float:
        """Return dP for a change of the state before by s with the unknown j, at fixed speeds after and impulses."""
        n_q, n = self.slopes.model.n_q, self.slopes.model.n_u
        still = np.concatenate([s[:n_q], np.zeros(n)])
        along = _Bearing(self.slopes, self.hit, self.place).along(still, tau, self.slopes.seeds[j], j)
        return along - float(self.by_jump @ s[n_q:])


def load_of_impact(slopes: Any, hit: Any, k: int) -> Load:
    """Return the load of the joint of a contact in an impact."""
    bearing = _Bearing(slopes, hit, slopes.scene.loaded.index(k))
    return Load(bearing.size, *bearing.gradient(), slopes, hit, bearing.place)


def own_impulses(slopes: Any, hit: Any) -> Array:
    """Return the impulses Λ_c of the active conditions of the machine itself in an impact: Gᵀ Λ_c = M Δu - Wᵀ Λ."""
    n_q, n = slopes.model.n_q, slopes.model.n_u
    M, G = slopes.mass(hit.t, hit.before)
    left = M @ (hit.after - hit.before)[n_q : n_q + n] - hit.impulses @ slopes.look(hit.t, hit.before).matrix
    return np.asarray(np.linalg.lstsq(G.T, left, rcond=None)[0])


class _Bearing:
    """The bearing of a joint, by its number, in an impact."""

    def __init__(self, slopes: Any, hit: Any, place: int) -> None:
        self.slopes, self.hit, self.place = slopes, hit, place
        n_q, n, rows = slopes.model.n_q, slopes.model.n_u, slopes.scene.rows
        self.moved, own = n_q + n, np.zeros(slopes.scene.candidates.own)
        self.active = list(slopes.kernels.active)
        jump = (hit.after - hit.before)[n_q : self.moved]
        own[self.active] = own_impulses(slopes, hit)
        self.acting, self.still = np.concatenate([jump, hit.impulses, own]), np.zeros(n + rows + len(own))
        zero = np.zeros(self.moved + 1 + len(slopes.symbols))
        without = self._outputs(self.still, zero, self.still)[0]
        self.forces = self._outputs(self.acting, zero, self.still)[0] - without
        self.blown: Any = None if hit.blown is None else [x[..., place, :] for x in hit.blown]
        if self.blown is not None:
            self.forces = self.forces + self.blown[0]
        sizes = [float(np.linalg.norm(F)) for F in self._places(self.forces)]
        for at, size in zip((1, 4), sizes, strict=True):  # round-off is no load
            if size <= NONE * sum(sizes):
                self.forces[at : at + 3] = 0.0
        self.lever = without[0]

    @property
    def size(self) -> float:
        """P."""
        return float(self.lever * sum(np.linalg.norm(F) for F in self._places(self.forces)))

    def along(self, s: Array, tau: float, dp: Array, j: int) -> float:
        """Return dP along a direction, at a fixed jump and fixed impulses, with the unknown j."""
        direction = np.concatenate([s, [tau], dp])
        with_all = self._outputs(self.acting, direction, self.still)[1]
        without = self._outputs(self.still, direction, self.still)[1]
        change = with_all - without
        if self.blown is not None:
            change = change + self.blown[1][j]
        for F, dF in zip(self._places(self.forces), self._places(change), strict=True):
            if not F.any() and dF.any():
                raise self._undirected()
        return float(without[0]) * self.size / self.lever + self._turned(change)

    def gradient(self) -> tuple[Array, Array, Array]:
        """Return the derivatives of P by the jump of the speeds, the impulses of all rows, and those of conditions."""
        n, rows = self.slopes.model.n_u, self.slopes.scene.rows
        zero, units = np.zeros(self.moved + 1 + len(self.slopes.symbols)), np.eye(len(self.still))
        whole = np.array([self._turned(self._outputs(self.acting, zero, unit)[1]) for unit in units])
        return whole[:n], whole[n : n + rows], whole[n + rows :][self.active]

    def _undirected(self) -> NoDerivativesError:
        """Return the error for a place of a joint that bears nothing, but would if an unknown changed."""
        model = self.slopes.model
        name = [contact.name for contact in model.contacts if contact.loaded][self.place]
        return NoDerivativesError(
            f"The motion of '{model.name}' has no derivatives by the unknowns of sensitivities= after t = "
            f"{self.hit.t:.9g} s: one place of the joint with friction '{name}' bears no impulse there, and would if "
            "an unknown changed, whichever way. Take differences of runs with values= that differ on one side."
        )

    def _turned(self, change: Array) -> float:
        """Return r Σ F·dF/|F|."""
        pairs = zip(self._places(self.forces), self._places(change), strict=True)
        return float(self.lever * sum(F @ dF / np.linalg.norm(F) for F, dF in pairs if F.any()))

    def _places(self, outputs: Array) -> tuple[Array, Array]:
        """Return the forces at the two places."""
        return outputs[1:4], outputs[4:7]

    def _outputs(self, acting: Array, direction: Array, change: Array) -> tuple[Array, Array]:
        """Return the outputs of the bearing, and their derivatives."""
        slopes, at = self.slopes, 2 * LOADED * self.place
        program = bearing_slopes(slopes.scene.candidates, slopes.symbols)
        given = np.concatenate([self.hit.before[: self.moved], acting, direction, change])
        constants = program.constants(slopes.parameters)
        found = at_state(program, "bearings", self.hit.t, given, constants)
        return found[at : at + LOADED], found[at + LOADED : at + 2 * LOADED]
