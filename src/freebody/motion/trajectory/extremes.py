"""Quantities of a motion at its output times, and their extremes over the whole run.

Extremes are sought at the ends of all steps and at seven points within each, on both sides of every jump. If one of
these values is greater than its neighbours, the bracket around it is halved eight times, at states that are as accurate
as the steps, and a parabola gives the vertex.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from functools import cached_property
from typing import Any

import numpy as np

from ..ode.dense_output import Array
from .computed_motion import ComputedMotion
from .outputs import CONTACT_MODES, ENERGIES, OfContact, OfReaction, Quantity
from .phases import Phases

_PARTS = 8  # parts of a step at whose ends extremes are sought
_HALVINGS = 8
_BRACKETS = 4  # brackets that are refined, for one quantity in one block
_BLOCK = 1000  # steps that are searched together


def values(motion: ComputedMotion, quantities: tuple[Quantity, ...]) -> Array:
    """Return expressions, energies, quantities of contacts and of reactions at the output times, one column each."""
    result = np.empty((len(motion.t), len(quantities)))
    expressions = [x for x in quantities if not isinstance(x, str | OfContact | OfReaction)]
    if expressions:
        program = motion.kernels.expressions(expressions)
        columns = [i for i, x in enumerate(quantities) if not isinstance(x, str | OfContact | OfReaction)]
        result[:, columns] = motion._observed(program, "values", motion.t, motion.states)
    for i, x in enumerate(quantities):
        if isinstance(x, str):
            result[:, i] = _energy(motion, x)
        elif isinstance(x, OfContact):
            result[:, i] = _of_contact(motion, x)
        elif isinstance(x, OfReaction):
            result[:, i] = x.of(getattr(motion.reactions[x.joint], x.what).T, np.sqrt)
    return result


def _energy(motion: ComputedMotion, name: str) -> Any:
    """Return one of `ENERGIES` at the output times."""
    assert name in ENERGIES
    if name != "work_rate":
        attributes = {
            "kinetic_energy": "kinetic",
            "potential_energy": "potential",
            "energy": "total",
            "work": "work",
        }
        return getattr(motion.energy, attributes[name])
    if not motion.has_work:
        return 0.0
    return motion._rates()[:, motion.kernels.model.n_q + motion.kernels.model.n_u]


def _of_contact(motion: Any, quantity: OfContact) -> Any:
    """Return a quantity of a contact at the output times; a mode as its index in `CONTACT_MODES`."""
    contact = list(motion.contacts.values())[quantity.contact]
    result = getattr(contact, quantity.what)
    if quantity.what == "mode":
        return [CONTACT_MODES.index(mode) for mode in result]
    return result if result.ndim == 1 else result[:, quantity.component]


def extremes(motion: ComputedMotion, quantities: tuple[Quantity, ...]) -> Array:
    """Return greatest, smallest, first and last value of each quantity over a motion, shape (quantities, 4)."""
    ends = values(_at(motion, np.array([motion.path.start, motion.path.end])), quantities)
    best = np.full((2, len(quantities)), -np.inf)  # greatest values of the quantities, and of their negatives
    for leg, times, curved in search_blocks(motion.path):

        def both_signs(moments: Array, leg: Any = leg) -> Array:
            result = values(_at(motion, moments, leg), quantities)
            return np.stack([result, -result])

        samples = both_signs(times)
        best = np.fmax(best, np.fmax.reduce(samples, axis=1))
        if curved:
            best = _refined(times, samples, best, both_signs)
    best[~np.isfinite(best)] = np.nan
    return np.stack([best[0], -best[1], *ends], axis=1)


def _refined(times: Array, samples: Array, best: Array, function: Callable[[Array], Array]) -> Array:
    """Return the greatest values, with values between the times where a bracket can hold a greater one."""
    a, b, c = samples[:, :-2], samples[:, 1:-1], samples[:, 2:]
    with np.errstate(invalid="ignore"):
        reach = np.where((b >= a) & (b >= c), 2 * b - np.minimum(a, c), -np.inf)
        reach[~(reach > best[:, None])] = -np.inf
    signs, places, columns = [], [], []
    for k in range(2):
        for j in range(best.shape[1]):
            highest = np.argsort(reach[k, :, j])[-_BRACKETS:]
            highest = highest[np.isfinite(reach[k, highest, j])]
            signs += [k] * len(highest)
            places += highest.tolist()
            columns += [j] * len(highest)
    if not places:
        return best
    K, i, J, rows = np.array(signs), np.array(places), np.array(columns), np.arange(len(places))
    t = np.stack([times[i], times[i + 1], times[i + 2]])
    f = np.stack([samples[K, i, J], samples[K, i + 1, J], samples[K, i + 2, J]])

    def evaluate(moments: Array) -> Array:
        """Return the quantity of each bracket at its own times, one row of times or several."""
        everywhere = function(moments.ravel()).reshape(2, *moments.shape, -1)
        result = everywhere[K, ..., rows, J].T
        np.fmax.at(best, (K, J), np.fmax.reduce(np.atleast_2d(result)))
        return np.where(np.isfinite(result), result, -np.inf)

    for _ in range(_HALVINGS):
        left, right = (t[0] + t[1]) / 2, (t[1] + t[2]) / 2
        points = np.stack([t[0], left, t[1], right, t[2]])
        below, above = evaluate(np.stack([left, right]))
        heights = np.stack([f[0], below, f[1], above, f[2]])
        middle = 1 + np.argmax(heights[1:4], axis=0)
        t, f = (np.stack([x[middle + d, rows] for d in (-1, 0, 1)]) for x in (points, heights))
    p, q = (t[1] - t[0]) * (f[1] - f[2]), (t[1] - t[2]) * (f[1] - f[0])
    with np.errstate(all="ignore"):
        vertex = t[1] - ((t[1] - t[0]) * p - (t[1] - t[2]) * q) / (2 * (p - q))
    inside = (vertex > np.minimum(t[0], t[2])) & (vertex < np.maximum(t[0], t[2]))
    evaluate(np.where(inside, vertex, t[1]))
    return best


def search_blocks(whole: Any) -> Iterator[tuple[Any, Array, bool]]:
    """Yield parts of a path between jumps, in blocks: the part, times to search, True if it is curved between them."""
    segments = whole.segments if isinstance(whole, Phases) else (None,)
    for segment in segments:
        path = whole if segment is None else segment.path
        leg = None if segment is None else Phases((segment,), whole.status)
        if not path.curved or path.steps == 0:
            yield leg, path.times, False
            continue
        for low in range(0, path.steps, _BLOCK):
            starts = path.times[max(0, low - 1) : low + _BLOCK + 1]  # blocks overlap by one step
            inner = starts[:-1, None] + np.diff(starts)[:, None] * np.arange(_PARTS) / _PARTS
            yield leg, np.append(inner.ravel(), starts[-1]), True


def _at(motion: ComputedMotion, times: Array, leg: Any = None) -> ComputedMotion:
    """Return the same motion, or one leg of it, with other output times."""
    other = copy.copy(motion)
    for kind in type(motion).__mro__:
        for name, entry in vars(kind).items():
            if isinstance(entry, cached_property):
                other.__dict__.pop(name, None)
    other.t = times
    if leg is not None:
        other.path = leg
    return other
