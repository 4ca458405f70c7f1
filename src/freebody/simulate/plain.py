"""A run in one leg, which nothing strikes, switches, closes or touches; kept for the next call, with another start.

What `simulate` makes of its other arguments takes a small machine as long as a hundred steps. It stays as it is while
they, the machine and the values of its parameters do.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from operator import is_
from typing import Any

import numpy as np
import sympy

from . import path as runs
from .event import EventSpec
from .failure import failure
from .initial import are_single, asks_for_many, named_numbers, plain_state
from .kernels import Kernels
from .methods import Way
from .path import Array, Rates, observe
from .progress import Progress
from .trajectory import Trajectory

_FIXED = (type(None), bool, int, float, str, sympy.Basic, EventSpec)
"""Types of arguments that nobody can change."""
_KEPT = 32  # runs of a machine


@dataclass(eq=False, slots=True)
class PlainRun:
    """A run but for its start.

    ``asked``  the arguments that it was made of, events last, and ``given``, the values of parameters
    """

    asked: tuple[Any, ...]
    given: dict[Any, Any] | None
    kernels: Kernels
    numbers: Mapping[str, float]
    rates: Rates
    way: Way
    begin: float
    end: float
    specs: tuple[EventSpec, ...]
    tolerances: Array
    wanted: Array | None
    samples: int | None

    def keep(self) -> None:
        """For calls to come, if nobody can change what this one was made of."""
        fixed = all(isinstance(x, _FIXED) or (type(x), x) == (tuple, ()) for x in self.asked)
        if fixed and (self.given is None or are_single(self.given)):
            self.given = None if self.given is None else dict(self.given)
            if len(self.kernels.plain) >= _KEPT:
                self.kernels.plain.clear()
            self.kernels.plain[self.asked] = self

    def start(self, initial: Any) -> list[float] | None:
        """The state (q, u) that is named; None for a start of lanes."""
        model = self.kernels.model
        y = plain_state(model, initial)
        if y is None and not asks_for_many(model, initial, None):
            y, _ = named_numbers(model, self.numbers, initial)
        return y

    def motion(self, y: list[float], progress: bool | Callable[[float], Any] | None) -> Trajectory:
        """The motion from a state (q, u)."""
        kernels, begin, end, absolute = self.kernels, self.begin, self.end, self.tolerances
        if kernels.works:
            y.append(0.0)
            absolute = scaled(kernels, absolute, begin, y, self.rates)
        between = Progress(begin, end, progress)
        try:
            path = self.way.path(y, begin, end, absolute, between)
        finally:
            between.close()
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


def scaled(kernels: Kernels, tolerances: Array, begin: float, y: Any, rates: Rates) -> Array:
    """Absolute tolerances: that of the work in parts of the energy at the start."""
    first = observe(kernels.motion().address("energy"), 2, np.array([begin]), np.array([y]), rates.constants)[
        0
    ].tolist()
    energy = max(map(abs, first))
    result = tolerances.copy()
    result[-1] *= energy if energy > 0 and all(map(math.isfinite, first)) else 1.0
    return result
