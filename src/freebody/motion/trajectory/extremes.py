"""Quantities of a motion at its output times, and their extremes over the whole run.

Extremes are sought at the ends of all steps and at seven points within each, on either side of every jump; where one of
these is greater than its neighbours, the bracket around it is halved eight times, by states that are ends of steps, and
closed by the vertex of a parabola.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from functools import cached_property
from typing import Any

import numpy as np

from ..ode.dense_output import Array
from .outputs import CONTACT_MODES, ENERGIES, OfContact
from .phases import Phases
from .trajectory import Trajectory

_PARTS = 8  # of a step at which extremes are looked for
_HALVINGS = 8
_BRACKETS = 4  # that are closed, of one quantity in one block
_BLOCK = 1000  # steps that are looked at together


def values(motion: Trajectory, asked: tuple[Any, ...]) -> Array:
    """Quantities (expressions, energies, of contacts) at the output times of a motion, one column each."""
    result = np.empty((len(motion.t), len(asked)))
    expressions = [x for x in asked if not isinstance(x, str | OfContact)]
    if expressions:
        program = motion.kernels.expressions(expressions)
        places = [i for i, x in enumerate(asked) if not isinstance(x, str | OfContact)]
        result[:, places] = motion._observed(program, "values", motion.t, motion.states)
    for i, x in enumerate(asked):
        if isinstance(x, str):
            result[:, i] = _energy(motion, x)
        elif isinstance(x, OfContact):
            result[:, i] = _of_contact(motion, x)
    return result


def _energy(motion: Any, name: str) -> Any:
    """One of `ENERGIES`."""
    assert name in ENERGIES
    if name != "work_rate":
        short = {
            "kinetic_energy": "kinetic",
            "potential_energy": "potential",
            "energy": "total",
            "work": "work",
        }
        return getattr(motion.energy, short[name])
    if not motion.has_work:
        return 0.0
    return motion._rates()[:, motion.kernels.model.n_q + motion.kernels.model.n_u]


def _of_contact(motion: Any, asked: OfContact) -> Any:
    """A quantity of a contact; the mode as its place in `CONTACT_MODES`."""
    contact = list(motion.contacts.values())[asked.contact]
    found = getattr(contact, asked.what)
    if asked.what == "mode":
        return [CONTACT_MODES.index(mode) for mode in found]
    return found if found.ndim == 1 else found[:, asked.component]


def extremes(motion: Any, asked: tuple[Any, ...]) -> Array:
    """Greatest, smallest, first and last value of each quantity over a motion, shape (quantities, 4)."""
    ends = values(_at(motion, np.array([motion.path.start, motion.path.end])), asked)
    best = np.full((2, len(asked)), -np.inf)  # of the quantities, and of their opposites
    for leg, times, bent in _legs(motion.path):

        def seen(moments: Array, leg: Any = leg) -> Array:
            found = values(_at(motion, moments, leg), asked)
            return np.stack([found, -found])

        found = seen(times)
        best = np.fmax(best, np.fmax.reduce(found, axis=1))
        if bent:
            best = _closed(times, found, best, seen)
    best[~np.isfinite(best)] = np.nan
    return np.stack([best[0], -best[1], *ends], axis=1)


def _closed(times: Array, found: Array, best: Array, seen: Callable[[Array], Array]) -> Array:
    """The greatest values with those between the times, where a bracket can hold a greater one."""
    a, b, c = found[:, :-2], found[:, 1:-1], found[:, 2:]
    with np.errstate(invalid="ignore"):
        reach = np.where((b >= a) & (b >= c), 2 * b - np.minimum(a, c), -np.inf)
        reach[~(reach > best[:, None])] = -np.inf
    side, place, which = [], [], []
    for k in range(2):
        for j in range(best.shape[1]):
            some = np.argsort(reach[k, :, j])[-_BRACKETS:]
            some = some[np.isfinite(reach[k, some, j])]
            side += [k] * len(some)
            place += some.tolist()
            which += [j] * len(some)
    if not place:
        return best
    K, i, J, rows = np.array(side), np.array(place), np.array(which), np.arange(len(place))
    t = np.stack([times[i], times[i + 1], times[i + 2]])
    f = np.stack([found[K, i, J], found[K, i + 1, J], found[K, i + 2, J]])

    def at_these(moments: Array) -> Array:
        """Each bracket's own quantity at its own moments, a row of them or several."""
        every = seen(moments.ravel()).reshape(2, *moments.shape, -1)
        got = every[K, ..., rows, J].T
        np.fmax.at(best, (K, J), np.fmax.reduce(np.atleast_2d(got)))
        return np.where(np.isfinite(got), got, -np.inf)

    for _ in range(_HALVINGS):
        left, right = (t[0] + t[1]) / 2, (t[1] + t[2]) / 2
        points = np.stack([t[0], left, t[1], right, t[2]])
        below, above = at_these(np.stack([left, right]))
        heights = np.stack([f[0], below, f[1], above, f[2]])
        middle = 1 + np.argmax(heights[1:4], axis=0)
        t, f = (np.stack([x[middle + d, rows] for d in (-1, 0, 1)]) for x in (points, heights))
    p, q = (t[1] - t[0]) * (f[1] - f[2]), (t[1] - t[2]) * (f[1] - f[0])
    with np.errstate(all="ignore"):
        vertex = t[1] - ((t[1] - t[0]) * p - (t[1] - t[2]) * q) / (2 * (p - q))
    inside = (vertex > np.minimum(t[0], t[2])) & (vertex < np.maximum(t[0], t[2]))
    at_these(np.where(inside, vertex, t[1]))
    return best


def _legs(whole: Any) -> Iterator[tuple[Any, Array, bool]]:
    """Parts of a path between jumps, in blocks: the part, times to look at, and whether it bends between them."""
    parts = whole.segments if isinstance(whole, Phases) else (None,)
    for segment in parts:
        one = whole if segment is None else segment.path
        leg = None if segment is None else Phases((segment,), whole.status)
        if not one.curved or one.steps == 0:
            yield leg, one.times, False
            continue
        for low in range(0, one.steps, _BLOCK):
            starts = one.times[max(0, low - 1) : low + _BLOCK + 1]  # what is at the seam is within
            parts_of = np.arange(_PARTS) / _PARTS
            inner = starts[:-1, None] + np.diff(starts)[:, None] * parts_of
            yield leg, np.append(inner.ravel(), starts[-1]), True


def _at(motion: Any, times: Array, leg: Any = None) -> Any:
    """The same motion, or one leg of it, with other output times."""
    other = copy.copy(motion)
    for kind in type(motion).__mro__:
        for name, entry in vars(kind).items():
            if isinstance(entry, cached_property):
                other.__dict__.pop(name, None)
    other.t = times
    if leg is not None:
        other.path = leg
    return other
