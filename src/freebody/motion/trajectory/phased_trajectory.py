"""Trajectory of a motion in phases."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from ...dynamics.unilateral import MotionWarning
from ..ode.dense_output import Array, observe
from .event import Event, Happening
from .one_sided_limits import Values, piece_of
from .quantities import Energy
from .trajectory import Trajectory


class EventList(list[Event]):
    """Events in their order; ``print`` shows a sentence for each."""

    def __str__(self) -> str:
        return "\n".join(map(str, self))


class PhasedTrajectory(Trajectory):
    """A trajectory of several segments.

    Attributes
    ----------
    happenings : tuple of Happening
        Blows, impacts and changes of mode, in their order.
    """

    path: Any

    def __init__(self, *arguments: Any, happenings: Sequence[Happening] = (), **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.happenings = tuple(happenings)

    @property
    def warnings(self) -> tuple[MotionWarning, ...]:
        """Warnings of any trajectory, and those of blows and impacts, one for each limit that they pass."""
        blows: dict[str, MotionWarning] = {}
        for warning in (warning for happening in self.happenings for warning in happening.warnings):
            first = blows.setdefault(warning.event, warning)
            if first is not warning:
                least, spans = min(first.value, warning.value), (*first.spans, *warning.spans)
                blows[warning.event] = replace(first, value=least, spans=spans)
        return tuple(sorted([*super().warnings, *blows.values()], key=lambda warning: warning.time))

    @cached_property
    def events(self) -> list[Event]:
        """Events that happened, in their order; ``print`` shows a sentence for each."""
        sense = self.path.sense
        entries = [(sense * event.time, 0, i, event) for i, event in enumerate(super().events)]
        entries += [(sense * event.time, 1, i, event) for i, event in enumerate(self.happenings)]
        return EventList(event for *_, event in sorted(entries, key=lambda entry: entry[:3]))

    def _limit_pieces(self) -> Iterator[tuple[Array, Values | None, Array]]:
        for segment in self.path.segments:
            program = segment.kernels.limits()
            parameters = self._parameters if segment.parameters is None else segment.parameters
            yield piece_of(segment.path, program, program.constants(parameters))

    def _observed(self, program: Any, function: str, times: Array, states: Array) -> Array:
        """Return outputs with the constants of each segment, and for forces with its conditions."""
        segments = self.path.segments
        if all(s.parameters is None and s.kernels is self.kernels for s in segments):
            return super()._observed(program, function, times, states)
        result = np.empty((len(times), program.outputs(function)))
        for k, chosen in self.path.split(times):
            segment, own_program = segments[k], program
            if function in ("reactions", "multipliers"):  # segments have different active conditions
                own_program = segment.kernels.reactions()
            elif function == "rates":
                own_program = segment.kernels.motion()
            parameters = self._parameters if segment.parameters is None else segment.parameters
            constants = own_program.constants(parameters)
            result[chosen] = observe(
                own_program.address(function), result.shape[1], times[chosen], states[chosen], constants
            )
        return result

    @cached_property
    def energy(self) -> Energy:
        """Energy ledger; ``work`` includes blows, impacts and friction, ``impulses`` only blows and impacts."""
        first = self.path.segments[0]
        times = np.concatenate([[self.path.start], self.t])
        states = np.concatenate([first.path.states[:1], self.states])
        energies = self._observed(self.kernels.motion(), "energy", times, states)
        n = self.kernels.model.n_q + self.kernels.model.n_u
        work = states[:, n] if states.shape[1] > n else np.zeros(len(times))
        impulses = np.array([s.impulses for s in self.path.segments])[self.path.places(times)]
        impulses[0] = first.impulses
        work = work + impulses
        residual = energies.sum(axis=1) - energies[0].sum() - (work - work[0])
        return Energy(energies[1:, 0], energies[1:, 1], work[1:], residual[1:], impulses[1:])
