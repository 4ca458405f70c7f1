"""Where a quantity is greatest along a path in phases: at their ends, or between them, where its rate vanishes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from ..ode.dense_output import Array
from .extremes import search_blocks
from .phases import Phases

HALVINGS = 60
"""Halvings of the interval in which a rate vanishes: to round-off."""


class Peak(NamedTuple):
    """A value that may be the greatest, its time and phase; ``end`` is -1 or 1 at the start or end of the phase."""

    value: float
    time: float
    segment: Any
    end: int = 0


def peaks(path: Phases, course: Callable[[Array, Any], Array], sign: int, name: str) -> Iterator[Peak]:
    """Yield where ``sign`` times a quantity may be greatest; ``course`` gives it and its rate at times of a phase."""
    for segment in path.segments:
        for end, time in ((-1, segment.path.start), (1, segment.path.end)):
            yield Peak(float(course(np.array([time]), segment)[0, 0]), float(time), segment, end)
    for leg, times, found, curved in search_blocks(path, lambda t, leg: course(t, leg.segments[0]), [name]):
        segment, rate = leg.segments[0], sign * found[:, 1]
        for i in np.flatnonzero((rate[:-1] > 0) & (rate[1:] <= 0)) if curved else ():
            low, high = float(times[i]), float(times[i + 1])
            for _ in range(HALVINGS):
                middle = (low + high) / 2
                rises = sign * course(np.array([middle]), segment)[0, 1] > 0
                low, high = (middle, high) if rises else (low, middle)
            yield Peak(float(course(np.array([low]), segment)[0, 0]), low, segment)
