"""Where the force of a one-sided constraint passes its limit along a motion (`dynamics.unilateral`), and what is said.

The run keeps the constraint as it is described. Its limits are looked at when they are asked for, in points of every
step and on the dense output between them, as events are.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...dynamics.unilateral import Limit, MotionWarning
from ..ode.dense_output import Array, observe
from ..ode.layout import PARTS

_BLOCK = 1 << 15
"""Moments that are looked at together."""
NOT_PHYSICAL = "not physical"
"""What is added to the status of a motion that passes a limit."""


@dataclass
class Span:
    """A part of a run in which a limit is passed; ``least`` is the least value in it, ``surely`` whether more than
    round-off is passed. A side without a bracket is where the run, or one of its segments, begins or ends."""

    limit: int
    begin: float
    end: float
    least: float
    surely: bool
    before: Any = None
    after: Any = None


Values = Callable[..., Array]
"""(times, dense) -> what is left to each limit, and then the same with what is negligible added; by the dense output,
or as accurate as the steps of the run."""


def spans(pieces: Iterable[tuple[Array, Values | None, Array]], count: int) -> list[Span]:
    """The parts of a run in which one of ``count`` limits is passed, in the order in which they begin.

    Parameters
    ----------
    pieces               (times, function, its values at them) in the order of the run; without a function nothing is
                         known between the times
    """
    found: list[Span] = []
    start = math.nan
    last: dict[int, Span] = {}  # those that reach the end of the piece before
    for times, function, values in pieces:
        start = float(times[0]) if math.isnan(start) else start
        goes_on, last = last, {}
        for k in range(count):
            t, v, f = _enriched(times, values[:, k], values[:, count + k], function, k)
            below = v < 0  # not where it has no value
            edges = np.flatnonzero(np.diff(below, prepend=False, append=False))
            for a, b in zip(edges[::2], edges[1::2], strict=True):
                least, surely = float(v[a:b].min()), bool((f[a:b] < 0).any())
                if a == 0 and k in goes_on:
                    one = goes_on[k]
                    one.least, one.surely = min(one.least, least), one.surely or surely
                else:
                    one = Span(k, float(t[a]), float(t[b - 1]), least, surely)
                    if a > 0 and np.isfinite(v[a - 1]):
                        one.before = (function, t[a - 1], t[a])
                    found.append(one)
                one.end, one.after = float(t[b - 1]), None
                if b == len(t):
                    last[k] = one
                elif np.isfinite(v[b]):
                    one.after = (function, t[b - 1], t[b])
    kept = [one for one in found if one.surely]
    for one in kept:
        one.begin, one.end = _zero(one.limit, one.before, one.begin), _zero(one.limit, one.after, one.end)
        one.before = one.after = None
    return sorted(kept, key=lambda one: abs(one.begin - start))


def _enriched(
    times: Array, v: Array, f: Array, function: Values | None, k: int
) -> tuple[Array, Array, Array]:
    """Values with the extremes between them that can pass zero: dips by more than what is negligible, and peaks of what
    is below it."""
    if function is None or len(times) < 3:
        return times, v, f
    from scipy.optimize import minimize_scalar

    more = []
    with np.errstate(invalid="ignore"):
        before, here, after = v[:-2], v[1:-1], v[2:]
        dips = (here <= before) & (here < after) & (2 * f[1:-1] < np.maximum(f[:-2], f[2:]))
        peaks = (here >= before) & (here > after) & (2 * here > np.minimum(before, after))
        peaks &= (np.minimum(f[:-2], f[2:]) < 0) & (here < 0)
    for sign, found in ((1.0, dips), (-1.0, peaks)):
        for i in np.flatnonzero(found):
            bounds = sorted((times[i], times[i + 2]))
            x = minimize_scalar(
                lambda x, sign=sign: sign * _at(function, k, x, True), bounds=bounds, method="bounded",
                options={"xatol": 1e-9 * (bounds[1] - bounds[0])},
            ).x  # fmt: skip
            more.append((i + 1 + (abs(x - times[0]) > abs(times[i + 1] - times[0])), x))
    if not more:
        return times, v, f
    more.sort(key=lambda one: (one[0], abs(one[1] - times[0])))
    places, moments = [place for place, _ in more], np.array([x for _, x in more])
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
    """The zero in a bracket; ``otherwise``, where there is none.

    It is sought on the dense output, and then beside that among states as accurate as the steps.
    """
    if bracket is None or bracket[0] is None:
        return otherwise
    function, a, b = bracket
    near = _root(function, k, a, b, True)
    for reach in (1e-9, 1e-6, 1e-3):
        some = [min(max(near + sign * reach * abs(b - a), min(a, b)), max(a, b)) for sign in (-1, 1)]
        if _at(function, k, some[0], False) * _at(function, k, some[1], False) <= 0:
            return _root(function, k, some[0], some[1], False)
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
    """A path for :func:`spans`, by the compiled function ``limits``."""
    address, outputs = program.address("limits"), program.outputs("limits")

    def values(times: Array, dense: bool) -> Array:
        return observe(address, outputs, times, path.sample(times, dense), constants)

    if path.steps == 0:
        return path.times, None, observe(address, outputs, path.times, path.states, constants)
    inner = path.times[:-1, None] + np.diff(path.times)[:, None] * np.arange(PARTS) / PARTS
    times = np.append(inner.ravel(), path.times[-1])
    blocks = [values(times[low : low + _BLOCK], True) for low in range(0, len(times), _BLOCK)]
    return times, values, np.concatenate(blocks)


def warnings_of(limits: Sequence[Limit], found: Sequence[Span]) -> tuple[MotionWarning, ...]:
    """One for each limit that is passed, in the order in which they first are."""
    result: list[MotionWarning] = []
    for k in dict.fromkeys(one.limit for one in found):
        mine = [one for one in found if one.limit == k]
        least = min(one.least for one in mine)
        result.append(limits[k].passed(least, tuple((one.begin, one.end) for one in mine)))
    return tuple(result)
