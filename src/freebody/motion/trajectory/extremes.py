"""Quantities of a motion at its output times, and their extremes over the whole run.

Extremes are sought in windows, first the steps of the run, on both sides of every jump. A window is halved until the
polynomial through nine points of it describes each quantity that may be greatest or smallest there (`_unseen`). Where a
value exceeds its neighbours, the bracket around it is halved eight times, at states that are as accurate as the steps,
and a parabola gives the vertex.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from ...errors import SimulationError
from ..ode.dense_output import Array
from ..ode.run import AT_MARGIN, CLEAR, MARGIN, PARTS
from .computed_motion import ComputedMotion
from .outputs import CONTACT_MODES, ENERGIES, OfContact, OfReaction, Output, Quantity
from .phases import Phases
from .quantities import LEDGER

_HALVINGS = 8
_BRACKETS = 64  # brackets that are refined together
_BLOCK = 1000  # steps that are searched together
_FINEST = 12  # times that a step is halved; windows that short may hold a bend or a jump
_MOST = 64  # of them in a step, on average
_EVEN = np.arange(PARTS + 1) / PARTS
_FRACTIONS = np.array([*_EVEN, MARGIN, 1 - MARGIN])
_NINTH = np.array([(-1) ** k * math.comb(PARTS, k) for k in range(PARTS + 1)])  # Δ⁸
_ALMOST = np.array([AT_MARGIN, AT_MARGIN[::-1]])  # the polynomial at MARGIN and 1 - MARGIN
_RESOLVED = 1e-10  # error of the polynomial, as a fraction of the greatest value, that is none

Function = Callable[[Array], Array]
"""Quantities at some times, shape (times, quantities)."""


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
        return getattr(motion.energy, LEDGER[name])
    if not motion.has_work:
        return 0.0
    return motion._rates()[:, motion.kernels.model.n_q + motion.kernels.model.n_u]


def _of_contact(motion: Any, quantity: OfContact) -> Any:
    """Return a quantity of a contact at the output times; a mode as its index in `CONTACT_MODES`."""
    contact = motion.contacts[quantity.contact]
    result = getattr(contact, quantity.what)
    if quantity.what == "mode":
        return [CONTACT_MODES.index(mode) for mode in result]
    return result if result.ndim == 1 else result[:, quantity.component]


def extremes(motion: ComputedMotion, outputs: Output) -> Array:
    """Return greatest, smallest, first and last value of each reduced quantity over a motion, shape (quantities, 4).

    Raises
    ------
    SimulationError
        A quantity changes more often than can be told apart in one step.
    """
    quantities = outputs.reduced_values
    ends = values(_at(motion, np.array([motion.path.start, motion.path.end])), quantities)
    best = np.full((2, len(quantities)), -np.inf)  # greatest values of the quantities, and of their negatives

    def function(moments: Array, leg: Any) -> Array:
        return values(_at(motion, moments, leg), quantities)

    blocks = search_blocks(motion.path, function, outputs.reduced) if outputs.searches else ()
    for leg, times, found, curved in blocks:

        def both_signs(moments: Array, leg: Any = leg) -> Array:
            result = function(moments, leg)
            return np.stack([result, -result])

        samples = np.stack([found, -found])
        best = np.fmax(best, np.fmax.reduce(samples, axis=1))
        if curved:
            best = _refined(times, samples, best, both_signs)
    best[~np.isfinite(best)] = np.nan
    return np.stack([best[0], -best[1], *ends], axis=1)


def _refined(times: Array, samples: Array, best: Array, function: Function) -> Array:
    """Return the greatest values, with values between the times where a bracket can hold a greater one."""
    a, b, c = samples[:, :-2], samples[:, 1:-1], samples[:, 2:]
    left, right = np.diff(times)[None, :-1, None], np.diff(times)[None, 1:, None]
    with np.errstate(all="ignore"):  # the parabola rises by slope² / (2 curvature) above b
        before, after = (b - a) / left, (c - b) / right
        slope = (before * right + after * left) / (left + right)
        gain = slope * slope * (left + right) / np.abs(4 * (after - before))
        reach = np.where((b >= a) & (b >= c), b + 2 * np.fmin(gain, b - np.minimum(a, c)), -np.inf)
    chosen = np.argwhere(reach > best[:, None]).T
    chosen = chosen[:, np.argsort(-reach[tuple(chosen)])]
    while chosen.size:
        best = _narrowed(times, samples, best, function, *chosen[:, :_BRACKETS])
        rest = chosen[:, _BRACKETS:]
        chosen = rest[:, reach[tuple(rest)] > best[rest[0], rest[2]]]
    return best


def _narrowed(times: Array, samples: Array, best: Array, function: Function, K: Any, i: Any, J: Any) -> Array:
    """Return the greatest values, with the vertices in brackets around the (i + 1)th times, of quantities J with signs
    K.
    """
    rows = np.arange(len(K))
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


def search_blocks(
    whole: Any, quantities: Callable[[Array, Any], Array], names: Sequence[str]
) -> Iterator[tuple[Any, Array, Array, bool]]:
    """Yield parts of a path between jumps, in blocks: the part, times to search, quantities, True if it is curved.

    ``quantities`` returns quantities at some times of a part, shape (times, quantities): those called ``names``, whose
    extremes are sought, then any others.
    """
    segments = whole.segments if isinstance(whole, Phases) else (None,)
    for segment in segments:
        path = whole if segment is None else segment.path
        leg = None if segment is None else Phases((segment,), whole.status)
        if not path.curved or path.steps == 0:
            yield leg, path.times, quantities(path.times, leg), False
            continue
        for low in range(0, path.steps, _BLOCK):
            starts = path.times[max(0, low - 1) : low + _BLOCK + 1]  # blocks overlap by one step
            times, found = _resolved(starts, lambda moments, leg=leg: quantities(moments, leg), names)  # type: ignore[misc]
            yield leg, times, found, True


def _resolved(steps: Array, function: Function, names: Sequence[str]) -> tuple[Array, Array]:
    """Return times of some steps, in their order, that show where quantities may be extreme, and the quantities."""
    begins, spans, best, n = steps[:-1], np.diff(steps), np.array([[-np.inf]]), len(names)
    found = [(steps[-1:], function(steps[-1:]))]
    for halvings in range(_FINEST + 1):
        times = np.clip(
            begins[:, None] + spans[:, None] * _FRACTIONS, min(steps[0], steps[-1]), max(steps[0], steps[-1])
        )
        samples = function(times.ravel()).reshape(*times.shape, -1)
        both = np.stack([samples[..., :n], -samples[..., :n]])
        best = np.fmax(best, np.fmax.reduce(both, axis=(1, 2)))
        unseen = _unseen(both, best)
        rough = unseen.any(axis=1)
        if halvings > 2 and rough.any():
            rough[rough] = ~_is_noise(begins[rough], spans[rough], samples[rough, :, :n], function)
        if halvings == _FINEST:
            if rough.sum() > _MOST * (len(steps) - 1):
                name = names[int(np.argmax(unseen[rough].sum(axis=0)))]
                raise SimulationError(
                    f"Expected a quantity whose extremes can be told apart, but between t = {times[rough].min():.9g} s "
                    f"and {times[rough].max():.9g} s '{name}' has more of them than {2**_FINEST} parts of a step show. "
                    "Pass a smaller max_step=, or ask for a quantity that changes less often."
                )
            rough[:] = False
        found.append((times[~rough, :PARTS].ravel(), samples[~rough, :PARTS].reshape(-1, samples.shape[-1])))
        spans = np.repeat(spans[rough] / 2, 2)
        begins = np.repeat(begins[rough], 2) + spans * (np.arange(len(spans)) % 2)
        if not len(begins):
            break
    moments, values_there = (np.concatenate(parts) for parts in zip(*found, strict=True))
    result, at = np.unique(moments, return_index=True)
    forwards = slice(None, None, 1 if steps[-1] >= steps[0] else -1)
    return result[forwards], values_there[at[forwards]]


def _error(samples: Array) -> Array:
    """Return the error of the polynomial through the even points of windows, as `window.error_between` does."""
    even = samples[..., : PARTS + 1, :]
    middle = np.abs(np.einsum("k,...kq->...q", _NINTH, even)) / 70
    ends = np.abs(np.einsum("ek,...kq->...eq", _ALMOST, even) - samples[..., PARTS + 1 :, :]).max(axis=-2)
    return np.asarray(np.maximum(middle, ends / (PARTS * PARTS * MARGIN)))


def _unseen(both: Array, best: Array) -> Any:
    """Return in which windows which quantity, or its negative, may exceed ``best`` unseen."""
    with np.errstate(invalid="ignore"):
        error = _error(both)
        higher = both.max(axis=2) + CLEAR * error > best[:, None]
        return (higher & (error > _RESOLVED * np.abs(best).max(axis=0))).any(axis=0)


def _is_noise(begins: Array, spans: Array, samples: Array, function: Function) -> Any:
    """Return the windows in which the error comes from round-off, as `window.is_noise` does."""
    times = begins[:, None] + spans[:, None] * (_EVEN[:-1] + 0.5 / PARTS)
    shortest = 64 * np.spacing(np.abs(times) + np.abs(spans[:, None])) * np.sign(spans[:, None])
    n = samples.shape[-1]
    now, then = (function(x.ravel())[:, :n].reshape(*x.shape, n) for x in (times, times + shortest))
    with np.errstate(invalid="ignore"):
        return (_error(samples) <= CLEAR * CLEAR * np.abs(then - now).max(axis=1)).all(axis=1)


def _at(motion: ComputedMotion, times: Array, leg: Any = None) -> ComputedMotion:
    """Return the same motion, or one leg of it, with other output times."""
    other = copy.copy(motion)
    for name in motion._computed:
        other.__dict__.pop(name, None)
    other.t = times
    if leg is not None:
        other.path = leg
    return other
