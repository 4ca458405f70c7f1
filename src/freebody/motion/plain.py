"""A run in one leg, which nothing strikes, switches or touches; kept for the next call, with another start.

What `simulate` makes of its other arguments takes as long as fifty steps of a small machine. It stays as it is while
they, the machine and the values of its parameters do.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from operator import is_
from typing import Any

import numpy as np
import sympy

from .kernels.kernels import Kernels
from .kernels.methods import Way, first_method
from .legs.branch import meets
from .legs.failure import failure
from .ode import dense_output as runs
from .ode import loops
from .ode.dense_output import Array, Rates
from .start.initial import are_single, asks_for_many, named_numbers, plain_state, texts_read
from .start.loop_closure import closed_start
from .trajectory.event import EventSpec
from .trajectory.progress import Progress
from .trajectory.trajectory import Trajectory

_FIXED = frozenset((type(None), bool, int, float, np.float64, str, EventSpec))
"""Types of arguments that nobody can change; expressions are others."""
_NAMED = frozenset((dict, type(None)))
_KEPT = 32  # runs of a machine


@dataclass(eq=False, slots=True)
class PlainRun:
    """A run but for its start.

    ``machine``   the kernels of the machine, of which ``kernels`` hold the conditions that are independent at the start
    ``asked``     the arguments that it was made of, events last, and ``given``, the values of parameters
    ``read``      texts of the last start that had some, and the numbers that they stand for
    """

    machine: Kernels
    asked: tuple[Any, ...]
    given: Mapping[Any, Any] | None
    kernels: Kernels
    numbers: Mapping[str, float]
    way: Way
    begin: float
    end: float
    specs: tuple[EventSpec, ...]
    tolerances: Array
    wanted: Array | None
    samples: int | None
    read: Mapping[str, float] = field(default_factory=dict)

    def keep(self) -> None:
        """For calls to come, if nobody can change what this one was made of."""
        kept = self.machine.plain
        fixed = all(
            type(x) in _FIXED or isinstance(x, sympy.Basic) or (type(x) is tuple and not x)
            for x in self.asked
        )
        if fixed and (self.given is None or are_single(self.given)):
            self.given = None if self.given is None else dict(self.given)
            if len(kept) >= _KEPT:
                kept.clear()
            kept[self.asked] = self

    def start(self, initial: Any, near: Any, project: Any) -> list[float] | None:
        """The state (q, u) that is named; None where this run does not begin so."""
        model = self.kernels.model
        if type(project) is not bool or type(initial) not in _NAMED or type(near) not in _NAMED:
            return None  # other words for these, or what is refused
        if model.constraints:
            if asks_for_many(model, initial, None):
                return None
            named, guessed = initial or {}, near or {}
            state, active = closed_start(self.machine, self.numbers, named, guessed, self.begin, project)
            return state.tolist() if active == self.kernels.active else None
        if near or project:
            return None
        y = plain_state(model, initial, self.read)
        if y is None and not asks_for_many(model, initial, None):
            y, _ = named_numbers(model, self.numbers, initial)
            self.read = texts_read(model, initial, y)
        return y

    def motion(self, y: list[float], progress: bool | Callable[[float], Any] | None) -> Trajectory | None:
        """The motion from a state (q, u); None where it comes near a position that one leg does not pass
        (`branch`)."""
        kernels, way, begin, end, absolute = self.kernels, self.way, self.begin, self.end, self.tolerances
        if kernels.works:
            y.append(0.0)
            absolute = scaled(kernels, absolute, begin, y, way.rates, way.first.method)
        between = Progress(begin, end, progress)
        try:
            path = way.path(y, begin, end, absolute, between)
        finally:
            between.close()
        if kernels.active and way.first.step is None and begin < end and meets(kernels, way.rates, path):
            return None
        motion = Trajectory(
            kernels, self.numbers, path, self.specs, self.tolerances, self.wanted, self.samples
        )
        if path.status in runs.FAILED:
            raise failure(motion, path, kernels, end, self.specs)
        return motion


def plain_run(kernels: Kernels, asked: tuple[Any, ...], given: Any) -> PlainRun | None:
    """The run that a call with these arguments asks for, if it was kept."""
    try:
        found: PlainRun | None = kernels.plain.get(asked)
    except TypeError:  # one that can be changed
        return None
    if (
        found is None
        or not (all(map(is_, asked, found.asked)) or all(map(is_, map(type, asked), map(type, found.asked))))
        or not (given is found.given or are_single(given) and given == found.given)
        or kernels.model.names.signals
    ):
        return None
    return found


def scaled(
    kernels: Kernels, tolerances: Array, begin: float, y: Sequence[float] | Array, rates: Rates, method: str
) -> Array:
    """Absolute tolerances: that of the work in parts of the energy at the start."""
    loops.use(first_method(kernels, method, tolerances))  # which observes too: no other has to be compiled
    energies = kernels.motion().address("energy")
    first = loops.observed(energies, 2, begin, y, rates.arguments[-1])
    energy = max(map(abs, first))
    result = tolerances.copy()
    result[-1] *= energy if energy > 0 and all(map(math.isfinite, first)) else 1.0
    return result
