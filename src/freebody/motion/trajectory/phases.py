"""Motion in phases: a run whose equations or speeds change at certain times.

Each segment has its own machine code and its own initial state. Between two segments the speeds may jump (a blow, an
impact) and the active conditions may change (a contact that sticks, slips or opens). Together the segments are read as
one path; at the time of a jump it gives the state just after.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from ..ending import End
from ..ode.dense_output import Array, Crossing, Path, Rates, within
from .path import SampledPath


@dataclass(frozen=True, eq=False)
class Segment:
    """One phase of a run.

    ``path``        its states; its crossings are events of the user only
    ``kernels``     programs of its equations (``motion``, ``reactions``)
    ``impulses``    work of all blows and impacts up to its start [J]
    ``modes``       contact modes
    ``loose``       True for each contact force that the motion does not determine
    ``parameters``  values of the model's parameters, if they differ from those of the whole run
    """

    path: Path
    kernels: Any
    impulses: float = 0.0
    modes: tuple[Any, ...] = ()
    loose: Any = None
    parameters: Any = None

    def values(self, common: Array) -> Array:
        """Return the values of the parameters; ``common`` are those of the whole run."""
        return common if self.parameters is None else cast(Array, self.parameters)


@dataclass(frozen=True, eq=False)
class Phases:
    """Segments one after another, read like a :class:`Path`."""

    segments: Sequence[Segment]
    status: End

    @property
    def rates(self) -> Rates:
        """Right-hand side in the last segment."""
        return self.segments[-1].path.rates

    @property
    def method(self) -> str:
        """Method in the last segment."""
        return self.segments[-1].path.method

    @property
    def stiff(self) -> int:
        """Number of steps whose length stability limited."""
        return sum(s.path.stiff for s in self.segments)

    @property
    def blame(self) -> int:
        """Component, or event, that stopped the last segment."""
        return self.segments[-1].path.blame

    @property
    def start(self) -> float:
        """Time at which the run starts [s]."""
        return float(self.starts[0])

    @cached_property
    def end(self) -> float:
        """Time at which the run ends [s]."""
        return float(self._of_each("end")[-1])

    @property
    def sense(self) -> float:
        """1 if the run goes forwards in time, -1 if it goes backwards."""
        return 1.0 if self.end >= self.start else -1.0

    @cached_property
    def times(self) -> Array:
        """Starts of the steps and ends of the segments [s]."""
        return np.concatenate([s.path.times for s in self.segments])

    @cached_property
    def states(self) -> Array:
        """States at :attr:`times`."""
        return np.concatenate([s.path.states for s in self.segments])

    @cached_property
    def lengths(self) -> Array:
        """Lengths of the steps [s]."""
        return np.concatenate([s.path.lengths for s in self.segments])

    @property
    def steps(self) -> int:
        """Number of accepted steps."""
        return sum(self._of_each("steps"))

    @property
    def rejected(self) -> int:
        """Number of rejected steps."""
        return sum(self._of_each("rejected"))

    @property
    def evaluations(self) -> int:
        """Number of evaluations of the rates."""
        return sum(s.path.evaluations for s in self.segments)

    @cached_property
    def crossings(self) -> tuple[Crossing, ...]:
        """Events of the user; an event that ends a segment is not counted again at the start of the next."""
        result: list[Crossing] = []
        for begin, crossings in zip(self.starts, self._of_each("crossings"), strict=True):
            for crossing in crossings:
                if abs(crossing.time - begin) <= 4 * np.finfo(float).eps * max(1.0, abs(begin)) and any(
                    before.number == crossing.number and abs(before.time - crossing.time) <= 1e-12
                    for before in result[-8:]
                ):
                    continue
                result.append(crossing)
        return tuple(result)

    @cached_property
    def starts(self) -> Array:
        """Starts of the segments [s]."""
        return np.array(self._of_each("start"))

    def _of_each(self, name: str) -> Sequence[Any]:
        """Return what the path of every segment has by a name, without making the segments of a log."""
        of_log = getattr(self.segments, "of_each", None)
        return [getattr(s.path, name) for s in self.segments] if of_log is None else of_log(name)

    def places(self, times: ArrayLike) -> Any:
        """Return the number of the segment in which each time lies; the last, if several segments start then."""
        in_order = self.sense * np.asarray(times)
        before = np.searchsorted(self.sense * self.starts, in_order, side="right")
        return np.clip(before - 1, 0, len(self.segments) - 1)

    def sample(self, times: ArrayLike, dense: bool = False) -> Array:
        """Return states at ``times``; see :meth:`Path.sample`."""
        moments = within(self, times)
        result = np.empty((moments.size, self.segments[0].path.states.shape[1]))
        for k, chosen in self.split(moments):
            result[chosen] = self.segments[k].path.sample(moments[chosen], dense)
        return result

    def split(self, times: Array) -> Iterable[tuple[int, Any]]:
        """Return (segment, indices of the times in it) of each segment that holds any of the times."""
        places = self.places(times)
        return ((int(k), np.flatnonzero(places == k)) for k in np.unique(places))


def segments_of(path: SampledPath, kernels: Any, impulses: float = 0.0) -> Sequence[Segment]:
    """Return the segments of a path; a plain path becomes one segment."""
    return path.segments if isinstance(path, Phases) else (Segment(cast(Path, path), kernels, impulses),)


def joined(paths: Sequence[Path], kernels: Any, impulses: float = 0.0) -> Path | Phases:
    """Return the path of a run in one leg, or legs with the same programs; ``impulses`` as in a segment."""
    if len(paths) == 1:
        return paths[0]
    return Phases([Segment(path, kernels, impulses) for path in paths], paths[-1].status)
