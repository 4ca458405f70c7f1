"""Course of a motion in one leg or in several: quantities follow from the states at any moment."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...dynamics.unilateral import MotionWarning
from ..kernels.kernels import Program
from ..ode.dense_output import Array, observe
from .computed_motion import ComputedMotion
from .course import Piece
from .event import Happening
from .one_sided_limits import piece_of
from .phases import Phases, Segment, segments_of
from .quantities import Energy


@dataclass(frozen=True, eq=False)
class InLegs:
    """Course of a motion without contacts, in one leg or in several."""

    happenings: tuple[Happening, ...] = ()
    derivatives: Any = None
    stepping: Any = None
    indeterminate: tuple[str, ...] = ()

    def modes(self, motion: ComputedMotion) -> Sequence[Any]:
        """Return no modes."""
        return ()

    def works(self, motion: ComputedMotion) -> bool:
        """Return True if the work done is a component of the state."""
        return motion.kernels.works

    def observed(
        self, motion: ComputedMotion, program: Program, function: str, times: Array, states: Array
    ) -> Array:
        """Return outputs with the constants of each leg, and for forces and rates with its conditions."""
        return observed(motion, program, function, times, states)

    def rates(self, motion: ComputedMotion) -> Array:
        """Return the rates of the state at the output times."""
        return observed(motion, motion.kernels.motion(), "rates", motion.t, motion.states)

    def energy(self, motion: ComputedMotion) -> Energy:
        """Return the energy ledger at the output times."""
        return energy(motion)

    def reactions(self, motion: ComputedMotion) -> Array:
        """Return force and moment of each joint in turn."""
        return observed(motion, motion.kernels.reactions(), "reactions", motion.t, motion.states)

    def multipliers(self, motion: ComputedMotion) -> Array:
        """Return the constraint forces."""
        return observed(motion, motion.kernels.reactions(), "multipliers", motion.t, motion.states)

    def contacts(self, motion: ComputedMotion) -> Mapping[str, Any]:
        """Return no contacts."""
        return {}

    def limit_pieces(self, motion: ComputedMotion) -> Iterator[Piece]:
        """Yield the legs with the margins to the limits of one-sided constraints."""
        return limit_pieces(motion)

    def warnings(self, motion: ComputedMotion) -> tuple[MotionWarning, ...]:
        """Return the warnings of blows."""
        return blow_warnings(self.happenings)


ONE_LEG = InLegs()
"""Course of a motion without blows and changes."""


def legs_of_path(motion: ComputedMotion) -> tuple[Segment, ...]:
    """Return the segments of the path of a motion; a smooth path is one."""
    return segments_of(motion.path, motion.kernels)


def split(motion: ComputedMotion, times: Array) -> Iterable[tuple[int, Any]]:
    """Return (segment, indices of the times in it) of each segment that holds any of the times."""
    if isinstance(motion.path, Phases):
        return motion.path.split(times)
    return [(0, np.arange(len(times)))]


def observed(motion: ComputedMotion, program: Program, function: str, times: Array, states: Array) -> Array:
    """Return outputs with the constants of each leg, and for forces and rates with its conditions."""
    segments = legs_of_path(motion)
    if all(s.parameters is None and s.kernels is motion.kernels for s in segments):
        constants = program.constants(motion._parameters)
        return observe(program.address(function), program.outputs(function), times, states, constants)
    result = np.empty((len(times), program.outputs(function)))
    for k, chosen in split(motion, times):
        segment, own_program = segments[k], program
        if function in ("reactions", "multipliers"):  # segments have different active conditions
            own_program = segment.kernels.reactions()
        elif function == "rates":
            own_program = segment.kernels.motion()
        parameters = motion._parameters if segment.parameters is None else segment.parameters
        result[chosen] = observe(
            own_program.address(function), result.shape[1], times[chosen], states[chosen],
            own_program.constants(parameters),
        )  # fmt: skip
    return result


def energy(motion: ComputedMotion) -> Energy:
    """Return the energy ledger; ``impulses``, the work of blows and impacts, is None for a path in one leg."""
    segments, kernels = legs_of_path(motion), motion.kernels
    times = np.concatenate([[motion.path.start], motion.t])
    states = np.concatenate([segments[0].path.states[:1], motion.states])
    energies = motion._observed(kernels.motion(), "energy", times, states)
    n = kernels.model.n_q + kernels.model.n_u
    work, impulses = states[:, n] if motion.has_work else np.zeros(len(times)), None
    if isinstance(motion.path, Phases):
        impulses = np.array([s.impulses for s in segments])[motion.path.places(times)]
        impulses[0] = segments[0].impulses
        work, impulses = work + impulses, impulses[1:]
    residual = energies.sum(axis=1) - energies[0].sum() - (work - work[0])
    return Energy(energies[1:, 0], energies[1:, 1], work[1:], residual[1:], impulses)


def limit_pieces(motion: ComputedMotion) -> Iterator[Piece]:
    """Yield the legs of a motion with the margins to the limits of one-sided constraints."""
    for segment in legs_of_path(motion):
        program = segment.kernels.limits()
        parameters = motion._parameters if segment.parameters is None else segment.parameters
        yield piece_of(segment.path, program, program.constants(parameters))


def blow_warnings(happenings: Sequence[Happening]) -> tuple[MotionWarning, ...]:
    """Return the warnings of blows and impacts, one for each limit that they pass."""
    blows: dict[str, MotionWarning] = {}
    for warning in (warning for happening in happenings for warning in happening.warnings):
        first = blows.setdefault(warning.event, warning)
        if first is not warning:
            least, spans = min(first.value, warning.value), (*first.spans, *warning.spans)
            blows[warning.event] = replace(first, value=least, spans=spans)
    return tuple(blows.values())
