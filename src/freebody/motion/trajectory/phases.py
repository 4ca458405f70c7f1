"""Motion in phases: a run whose equations, or whose speeds, change at moments.

Each segment has its own machine code and its own start; between two segments the speeds may jump (a blow, an impact)
and the set of active conditions may change (a contact that sticks, slips or opens). Together they are read as one
path: at the moment of a jump itself, the state just after.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...dynamics.unilateral import MotionWarning
from ..ode.dense_output import Array, Crossing, Path, Rates, observe
from .event import Event, Happening
from .one_sided_limits import Values, piece_of
from .trajectory import Energy, Trajectory


@dataclass(frozen=True, eq=False)
class Segment:
    """One phase of a run.

    ``path``      its states, in which only the events that the user asked for are counted as crossings
    ``kernels``   programs of its equations (``motion``, ``reactions``)
    ``impulses``  work of all blows and impacts up to its start [J]
    ``modes``     of every contact
    ``loose``     which contact forces the motion does not determine
    ``parameters``  values of the model's parameters, where they are not those of the whole run
    """

    path: Path
    kernels: Any
    impulses: float = 0.0
    modes: tuple[Any, ...] = ()
    loose: Any = None
    parameters: Any = None


@dataclass(frozen=True, eq=False)
class Phases:
    """Segments one after another, as a :class:`Path` is read."""

    segments: tuple[Segment, ...]
    status: str

    @property
    def rates(self) -> Rates:
        return self.segments[-1].path.rates

    @property
    def method(self) -> str:
        """Of the last segment."""
        return self.segments[-1].path.method

    @property
    def stiff(self) -> int:
        return sum(s.path.stiff for s in self.segments)

    @property
    def blame(self) -> int:
        return self.segments[-1].path.blame

    @property
    def start(self) -> float:
        return self.segments[0].path.start

    @property
    def end(self) -> float:
        return self.segments[-1].path.end

    @cached_property
    def times(self) -> Array:
        return np.concatenate([s.path.times for s in self.segments])

    @cached_property
    def states(self) -> Array:
        return np.concatenate([s.path.states for s in self.segments])

    @cached_property
    def lengths(self) -> Array:
        return np.concatenate([s.path.lengths for s in self.segments])

    @property
    def steps(self) -> int:
        return sum(s.path.steps for s in self.segments)

    @property
    def rejected(self) -> int:
        return sum(s.path.rejected for s in self.segments)

    @property
    def evaluations(self) -> int:
        return sum(s.path.evaluations for s in self.segments)

    @cached_property
    def crossings(self) -> tuple[Crossing, ...]:
        """Events that the user asked for; one that ends a segment is not counted again where the next begins."""
        result: list[Crossing] = []
        for segment in self.segments:
            begin = segment.path.start
            for crossing in segment.path.crossings:
                if crossing.time - begin <= 4 * np.finfo(float).eps * max(1.0, abs(begin)) and any(
                    one.number == crossing.number and abs(one.time - crossing.time) <= 1e-12
                    for one in result[-8:]
                ):
                    continue
                result.append(crossing)
        return tuple(result)

    @cached_property
    def starts(self) -> Array:
        return np.array([s.path.start for s in self.segments])

    def places(self, times: ArrayLike) -> Any:
        """Number of the segment that each time lies in; the last of those that begin there."""
        return np.clip(np.searchsorted(self.starts, times, side="right") - 1, 0, len(self.segments) - 1)

    def sample(self, times: ArrayLike, dense: bool = False) -> Array:
        """States at ``times``; see :meth:`Path.sample`."""
        wanted = np.atleast_1d(np.ascontiguousarray(times, dtype=float))
        outside = ~((wanted >= self.start) & (wanted <= self.end))
        if outside.any():
            raise ValueError(
                f"Expected times within the run, {self.start:g} to {self.end:g}; got {wanted[outside][0]}. "
                "Ask for a time inside, or simulate further."
            )
        result = np.empty((wanted.size, self.rates.size))
        for k, chosen in self.split(wanted):
            result[chosen] = self.segments[k].path.sample(wanted[chosen], dense)
        return result

    def split(self, times: Array) -> Iterable[tuple[int, Any]]:
        """(segment, which of the times lie in it), for segments that hold any."""
        places = self.places(times)
        return ((int(k), np.flatnonzero(places == k)) for k in np.unique(places))


def parts_of(path: Path | Phases, kernels: Any, impulses: float = 0.0) -> tuple[Segment, ...]:
    """Segments of a path; one if it has none."""
    return path.segments if isinstance(path, Phases) else (Segment(path, kernels, impulses),)


class EventList(list[Event]):
    """Events in their order; printed, a sentence each."""

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
        """As of any trajectory, with those of blows and impacts, one for each limit that these pass."""
        blows: dict[str, MotionWarning] = {}
        for one in (one for happening in self.happenings for one in happening.warnings):
            first = blows.setdefault(one.event, one)
            if first is not one:
                least, spans = min(first.value, one.value), (*first.spans, *one.spans)
                blows[one.event] = replace(first, value=least, spans=spans)
        return tuple(sorted([*super().warnings, *blows.values()], key=lambda one: one.time))

    @cached_property
    def events(self) -> list[Event]:
        """The events that happened, in their order; ``print`` shows a sentence each."""
        asked = super().events
        both = [(event.time, 0, i, event) for i, event in enumerate(asked)]
        both += [(event.time, 1, i, event) for i, event in enumerate(self.happenings)]
        return EventList(event for *_, event in sorted(both, key=lambda entry: entry[:3]))

    def _limit_pieces(self) -> Iterator[tuple[Array, Values | None, Array]]:
        for one in self.path.segments:
            program = one.kernels.limits()
            parameters = self._parameters if one.parameters is None else one.parameters
            yield piece_of(one.path, program, program.constants(parameters))

    def _observed(self, program: Any, function: str, times: Array, states: Array) -> Array:
        """With the constants, and for forces the conditions, of each segment."""
        segments = self.path.segments
        if all(s.parameters is None and s.kernels is self.kernels for s in segments):
            return super()._observed(program, function, times, states)
        result = np.empty((len(times), program.outputs(function)))
        for k, chosen in self.path.split(times):
            one, here = segments[k], program
            if function in ("reactions", "multipliers"):  # other conditions hold in each
                here = one.kernels.reactions()
            elif function == "rates":
                here = one.kernels.motion()
            constants = here.constants(self._parameters if one.parameters is None else one.parameters)
            result[chosen] = observe(
                here.address(function), result.shape[1], times[chosen], states[chosen], constants
            )
        return result

    @cached_property
    def energy(self) -> Energy:
        """The energy ledger; ``work`` holds that of blows, impacts and friction, of which ``impulses`` is the part of
        blows and impacts."""
        first = self.path.segments[0]
        times = np.concatenate([[self.path.start], self.t])
        states = np.concatenate([first.path.states[:1], self.states])
        both = self._observed(self.kernels.motion(), "energy", times, states)
        n = self.kernels.model.n_q + self.kernels.model.n_u
        work = states[:, n] if states.shape[1] > n else np.zeros(len(times))
        impulses = np.array([s.impulses for s in self.path.segments])[self.path.places(times)]
        impulses[0] = first.impulses
        work = work + impulses
        residual = both.sum(axis=1) - both[0].sum() - (work - work[0])
        return Energy(both[1:, 0], both[1:, 1], work[1:], residual[1:], impulses[1:])
