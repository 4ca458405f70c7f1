"""Times at which the force of a one-sided constraint passes its limit, and the warnings.

The run keeps the constraint as it is described. Its limits are evaluated on first use, at points of every step and on
the dense output between them, like events.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...dynamics.conditions.unilateral import Limit, MotionWarning
from ...errors import SimulationError
from ..ode.dense_output import Array, observe
from ..ode.run import PARTS

_BLOCK = 1 << 15
"""Number of times that are evaluated together."""


@dataclass
class Span:
    """A part of a run beyond a limit.

    ``least`` is the least value in it; ``surely`` is True if the limit is passed by more than round-off. A side without
    a bracket (``before``, ``after``) is the start or end of the run or of one of its segments.
    """

    limit: int
    begin: float
    end: float
    least: float
    surely: bool
    before: Any = None
    after: Any = None


Values = Callable[..., Array]
"""(times, dense) -> margin to each limit, then the same margins with negligible forces added; from the dense output, or
as accurate as the steps of the run."""


def spans(pieces: Iterable[tuple[Array, Values | None, Array]], count: int) -> list[Span]:
    """Return the parts of a run beyond one of ``count`` limits, in the order in which they begin.

    Parameters
    ----------
    pieces               (times, function, its values at the times) in the order of the run; without a function, the
                         values between the times are unknown
    """
    found: list[Span] = []
    start = math.nan
    last: dict[int, Span] = {}  # spans that reach the end of the previous piece
    for times, function, values in pieces:
        start = float(times[0]) if math.isnan(start) else start
        previous, last = last, {}
        for k in range(count):
            t, v, f = _enriched(times, values[:, k], values[:, count + k], function, k)
            below = v < 0  # False for nan
            edges = np.flatnonzero(np.diff(below, prepend=False, append=False))
            for a, b in zip(edges[::2], edges[1::2], strict=True):
                least, surely = float(v[a:b].min()), bool((f[a:b] < 0).any())
                if a == 0 and k in previous:
                    span = previous[k]
                    span.least, span.surely = min(span.least, least), span.surely or surely
                else:
                    span = Span(k, float(t[a]), float(t[b - 1]), least, surely)
                    if a > 0 and np.isfinite(v[a - 1]):
                        span.before = (function, t[a - 1], t[a])
                    found.append(span)
                span.end, span.after = float(t[b - 1]), None
                if b == len(t):
                    last[k] = span
                elif np.isfinite(v[b]):
                    span.after = (function, t[b - 1], t[b])
    result = [span for span in found if span.surely]
    for span in result:
        span.begin = _zero(span.limit, span.before, span.begin)
        span.end = _zero(span.limit, span.after, span.end)
        span.before = span.after = None
    return sorted(result, key=lambda span: abs(span.begin - start))


def _enriched(
    times: Array, v: Array, f: Array, function: Values | None, k: int
) -> tuple[Array, Array, Array]:
    """Return times and values, with added extremes that may lie beyond zero: minima that pass the limit by more than a
    negligible amount, and maxima of values beyond it.
    """
    if function is None or len(times) < 3:
        return times, v, f
    from scipy.optimize import minimize_scalar

    added = []
    with np.errstate(invalid="ignore"):
        before, here, after = v[:-2], v[1:-1], v[2:]
        dips = (here <= before) & (here < after) & (2 * f[1:-1] < np.maximum(f[:-2], f[2:]))
        peaks = (here >= before) & (here > after) & (2 * here > np.minimum(before, after))
        peaks &= (np.minimum(f[:-2], f[2:]) < 0) & (here < 0)
    for sign, extremes in ((1.0, dips), (-1.0, peaks)):
        for i in np.flatnonzero(extremes):
            bounds = sorted((times[i], times[i + 2]))
            x = minimize_scalar(
                lambda x, sign=sign: sign * _at(function, k, x, True), bounds=bounds, method="bounded",
                options={"xatol": 1e-9 * (bounds[1] - bounds[0])},
            ).x  # fmt: skip
            added.append((i + 1 + (abs(x - times[0]) > abs(times[i + 1] - times[0])), x))
    if not added:
        return times, v, f
    added.sort(key=lambda entry: (entry[0], abs(entry[1] - times[0])))
    places, moments = [place for place, _ in added], np.array([x for _, x in added])
    new = function(moments, True)
    count = new.shape[1] // 2
    return (
        np.insert(times, places, moments),
        np.insert(v, places, new[:, k]),
        np.insert(f, places, new[:, count + k]),
    )


def _at(function: Values, k: int, x: float, dense: bool) -> float:
    return float(function(np.array([x]), dense)[0, k])


def _zero(k: int, bracket: Any, otherwise: float) -> float:
    """Return the zero in a bracket, or ``otherwise`` without a bracket.

    It is sought on the dense output, and then nearby among states as accurate as the steps, where shorter steps have
    these.
    """
    if bracket is None or bracket[0] is None:
        return otherwise
    function, a, b = bracket
    near = _root(function, k, a, b, True)
    with suppress(SimulationError):  # the iteration of an implicit method may diverge in a shorter step
        for reach in (1e-9, 1e-6, 1e-3):
            left, right = (
                min(max(near + sign * reach * abs(b - a), min(a, b)), max(a, b)) for sign in (-1, 1)
            )
            if _at(function, k, left, False) * _at(function, k, right, False) <= 0:
                return _root(function, k, left, right, False)
    return near


def _root(function: Values, k: int, a: float, b: float, dense: bool) -> float:
    from scipy.optimize import brentq

    for end in (a, b):
        if _at(function, k, end, dense) == 0:
            return float(end)
    # to the last digit of the time
    return float(
        brentq(lambda x: _at(function, k, x, dense), a, b, xtol=5e-324, rtol=4 * np.finfo(float).eps)
    )


def piece_of(path: Any, program: Any, constants: Array) -> tuple[Array, Values | None, Array]:
    """Return a path as a piece for :func:`spans`, with the compiled function ``limits``."""
    address, outputs = program.address("limits"), program.outputs("limits")

    def values(times: Array, dense: bool) -> Array:
        return observe(address, outputs, times, path.sample(times, dense), constants)

    if path.steps == 0:
        return path.times, None, observe(address, outputs, path.times, path.states, constants)
    inner = path.times[:-1, None] + np.diff(path.times)[:, None] * np.arange(PARTS) / PARTS
    times = np.append(inner.ravel(), path.times[-1])
    blocks = [values(times[low : low + _BLOCK], True) for low in range(0, len(times), _BLOCK)]
    return times, values, np.concatenate(blocks)


def warnings_of(limits: Sequence[Limit], passed: Sequence[Span]) -> tuple[MotionWarning, ...]:
    """Return one warning for each limit that is passed, in the order of their first passing."""
    result: list[MotionWarning] = []
    for k in dict.fromkeys(span.limit for span in passed):
        group = [span for span in passed if span.limit == k]
        least = min(span.least for span in group)
        result.append(limits[k].passed(least, tuple((span.begin, span.end) for span in group)))
    return tuple(result)
