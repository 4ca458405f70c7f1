"""Checks of the arguments of `simulate`. An argument that a run cannot use raises an error; none is silently
ignored.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from functools import cache, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...errors import SimulationError, nearest
from ..kernels.kernels import Kernels

FINEST = 1e-15
"""Smallest tolerance: below it, double precision has no digits."""
FINEST_OF_SERIES = 1e-16
"""Smallest tolerance of "taylor", whose steps are not iterated."""

_REAL = (int, float, np.integer, np.floating)


@cache
def largest_memory() -> float:
    """Return the number of bytes that results may take: 80 % of the computer's memory, infinite if that is unknown."""
    if not hasattr(os, "sysconf"):
        return math.inf
    return 0.8 * os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


MOST_STEPS = 10_000_000
"""Maximum number of steps of a run without max_steps=."""
_MEMORY = 1 << 31
"""Maximum number of bytes of the steps of such a run."""
STORED = 3
"""Numbers stored per step besides coordinates and speeds: its time, its length and the work."""


def most_steps(max_steps: int | None, stored: int) -> int:
    """Return the maximum number of steps of a run that stores ``stored`` numbers per step.

    The pieces of the run are joined at the end, and for a moment all steps are stored twice.
    """
    most, memory = MOST_STEPS, min(float(_MEMORY), largest_memory() / 4)
    if max_steps is not None:
        most, memory = max_steps, min(largest_memory(), 2.0**62)
    return max(1, min(most, int(memory / (16 * stored))))


def check_steps(begin: float, end: float, step: Any, max_step: Any, most: int) -> None:
    """Raise SimulationError if a run of known step length would take too many steps."""
    for name, length in (("step", step), ("max_step", max_step)):
        if length is not None:
            check_count(abs(end - begin) / length, most, f"{name} = {length:g} s", f"Take a longer {name}=")


def check_count(count: float, most: int, what: str, cure: str) -> None:
    """Raise SimulationError if a number of steps exceeds the maximum of the run."""
    if count > most * (1 + 1e-9):
        raise SimulationError(
            f"Expected a run of at most {most} steps, got {what}, which makes {count:.3g}. {cure}, end earlier, or "
            "raise max_steps= as far as the memory allows."
        )


def check_numbers(times: Any, samples: Any, max_step: Any, max_steps: Any, width: int) -> None:
    """Check the number of samples, of ``width`` numbers each, the longest step and the maximum number of steps."""
    if times is not None and samples is not None:
        raise SimulationError("Expected times= or samples=, got both. Leave one out.")
    if samples is not None and not (_is_whole(samples) and samples >= 2):
        raise SimulationError(f"Expected a number of samples of at least 2, got {samples!r}.")
    if samples is not None and 8 * width * samples > largest_memory():
        raise SimulationError(
            f"Expected samples that fit into memory, got samples={samples}, which take "
            f"{8 * width * samples / 2**30:.3g} GiB. Ask for fewer; trajectory.at(t) gives the state at any time."
        )
    if max_step is not None and not (is_number(max_step) and max_step > 0):
        raise SimulationError(f"Expected a longest step greater than 0 s, got max_step={max_step!r}.")
    if max_steps is not None and not (_is_whole(max_steps) and max_steps > 0):
        raise SimulationError(f"Expected a number of steps of at least 1, got max_steps={max_steps!r}.")


def check_forwards(begin: float, end: float, what: str, why: str) -> None:
    """Raise SimulationError if a run that can only go forwards in time ends before it starts."""
    if end < begin:
        raise SimulationError(
            f"Expected until later than start for {what}, got until = {end:g} s and start = {begin:g} s: {why} have no "
            "way back. Begin at the earlier time."
        )


def is_number(value: Any) -> bool:
    """Return True if a value is a real number and not a bool."""
    return isinstance(value, _REAL) and not isinstance(value, bool)


def _is_whole(value: Any) -> bool:
    return isinstance(value, (int, np.integer)) and not isinstance(value, bool)


def output_times(times: ArrayLike | None, begin: float, end: float) -> Any:
    """Return the output times of a run as an array, checked; None if none are given."""
    if times is None:
        return None
    try:
        wanted = np.atleast_1d(np.array(times, dtype=float))
    except (TypeError, ValueError):
        raise SimulationError(f"Expected a list of output times [s], got {times!r}.") from None
    first, last = min(begin, end), max(begin, end)
    if wanted.ndim != 1 or wanted.size == 0:
        raise SimulationError(f"Expected a list of output times, got an array of shape {np.shape(times)}.")
    outside = ~((wanted >= first) & (wanted <= last))
    if outside.any():
        raise SimulationError(
            f"Expected output times from {first:g} to {last:g} s, got {wanted[outside][0]:g}. "
            "Leave it out, or simulate further."
        )
    return wanted


def tolerances_of(kernels: Kernels, tolerance: Any, method: str) -> Any:
    """Return the relative tolerance of each component of the state, from one number or numbers by name."""
    finest = FINEST_OF_SERIES if method == "taylor" else FINEST
    if isinstance(tolerance, float) or not isinstance(tolerance, Mapping):
        return _equal(_tolerance(tolerance, finest), kernels.size)
    names = kernels.names
    by_name = {kernels.model.names.text_of(key): value for key, value in tolerance.items()}
    for name in by_name:
        if name not in names:
            raise SimulationError(f"Unknown name '{name}' in tolerance; {nearest(name, names)}")
    return np.array([_tolerance(by_name.get(name, 1e-9), finest) for name in names])


@lru_cache(maxsize=64)
def _equal(number: float, n: int) -> Any:
    """Return an array of ``n`` equal numbers, which is shared and cannot be written to."""
    result = np.full(n, number)
    result.setflags(write=False)
    return result


def _tolerance(value: Any, finest: float) -> float:
    if isinstance(value, list | tuple) or isinstance(value, np.ndarray) and value.ndim:
        raise SimulationError(
            f"Expected one number for tolerance=, or numbers by name, such as {{'theta': 1e-9}}, got {value!r}."
        )
    if not is_number(value) or not finest <= value < 1:
        raise SimulationError(
            f"Expected a tolerance between {finest:g} and 1, got {value!r}. "
            "1e-9 suits most purposes; below 1e-14 rounding errors dominate."
        )
    return float(value)
