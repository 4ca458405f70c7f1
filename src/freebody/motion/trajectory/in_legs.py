"""Course of a motion in one leg or in several: quantities follow from the states at any moment."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...dynamics.conditions.unilateral import MotionWarning
from ..kernels.program import Program, at_states
from ..ode.dense_output import Array, observe
from .computed_motion import ComputedMotion
from .course import Piece
from .event import Happening
from .one_sided_limits import piece_of
from .phases import Phases, segments_of
from .quantities import Energy


@dataclass(frozen=True, eq=False)
class InLegs:
    """Course of a motion without contacts, in one leg or in several."""

    happenings: tuple[Happening, ...] = ()
    derivatives: Any = None
    stepping: None = None
    residual: None = None
    indeterminate: tuple[str, ...] = ()

    def modes(self, motion: ComputedMotion) -> Sequence[Any]:
        """Return no modes."""
        return ()

    def contacts(self, motion: ComputedMotion) -> Mapping[str, Any]:
        """Return no contacts."""
        return {}

    def works(self, motion: ComputedMotion) -> bool:
        """Return True if the work done is a component of the state."""
        return motion.kernels.works

    def observed(
        self, motion: ComputedMotion, program: Program, function: str, times: Array, states: Array
    ) -> Array:
        """Return outputs with the constants of each leg, and for forces and rates with its conditions."""
        segments = segments_of(motion.path, motion.kernels)
        if all(s.parameters is None and s.kernels is motion.kernels for s in segments):
            constants = program.constants(motion._parameters)
            return at_states(program, function, times, states, constants)
        result = np.empty((len(times), program.outputs(function)))
        for k, chosen in phases_of(motion).split(times):
            segment, own_program = segments[k], program
            if function in ("reactions", "multipliers"):  # segments have different active conditions
                own_program = segment.kernels.reactions()
            elif function == "rates":
                own_program = segment.kernels.motion()
            parameters = segment.values(motion._parameters)
            result[chosen] = observe(
                own_program.address(function), result.shape[1], times[chosen], states[chosen],
                own_program.constants(parameters),
            )  # fmt: skip
        return result

    def quantity(self, motion: ComputedMotion, name: str) -> Array:
        """Return the rates, reactions or multipliers at the output times."""
        program = motion.kernels.motion() if name == "rates" else motion.kernels.reactions()
        return self.observed(motion, program, name, motion.t, motion.states)

    def energy(self, motion: ComputedMotion) -> Energy:
        """Return the energy ledger; ``impulses``, the work of blows and impacts, is None for a path in one leg."""
        path, model = motion.path, motion.kernels.model
        times = np.concatenate([[path.start], motion.t])
        states = np.concatenate([path.states[:1], motion.states])
        energies = self.observed(motion, motion.kernels.motion(), "energy", times, states)
        n = model.n_q + model.n_u
        work, impulses = states[:, n] if motion.has_work else np.zeros(len(times)), None
        if isinstance(path, Phases):
            impulses = np.array([s.impulses for s in path.segments])[path.places(times)]
            impulses[0] = path.segments[0].impulses
            work, impulses = work + impulses, impulses[1:]
        residual = energies.sum(axis=1) - energies[0].sum() - (work - work[0])
        return Energy(energies[1:, 0], energies[1:, 1], work[1:], residual[1:], impulses)

    def limit_pieces(self, motion: ComputedMotion) -> Iterator[Piece]:
        """Yield the legs with the margins to the limits of one-sided constraints."""
        for segment in segments_of(motion.path, motion.kernels):
            program = segment.kernels.limits()
            yield piece_of(segment.path, program, program.constants(segment.values(motion._parameters)))

    def warnings(self, motion: ComputedMotion) -> tuple[MotionWarning, ...]:
        """Return the warnings of blows and impacts, one for each limit that they pass."""
        blows: dict[str, MotionWarning] = {}
        for warning in (warning for happening in self.happenings for warning in happening.warnings):
            first = blows.setdefault(warning.event, warning)
            if first is not warning:
                least, spans = min(first.value, warning.value), (*first.spans, *warning.spans)
                blows[warning.event] = replace(first, value=least, spans=spans)
        return tuple(blows.values())


ONE_LEG = InLegs()
"""Course of a motion without blows and changes."""


def phases_of(motion: ComputedMotion) -> Phases:
    """Return the path of a motion in phases."""
    assert isinstance(motion.path, Phases)
    return motion.path
