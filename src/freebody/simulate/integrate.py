"""A run of the integrator, in pieces.

The compiled loop (`loop`) works in pieces of about a tenth of a second. Between two pieces Python may show the
progress, notice an interruption, and make new buffers; within a step there is no Python.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from . import layout, loop
from .path import (
    COLLAPSED,
    DIVERGED,
    FINISHED,
    INTERRUPTED,
    NOT_FINITE,
    STIFF,
    TERMINAL,
    TOO_MANY_STEPS,
    Array,
    Crossing,
    Path,
    Rates,
    Watch,
    observe,
    work_room,
)

_STATUS = {
    layout.FINISHED: FINISHED,
    layout.TERMINAL: TERMINAL,
    layout.NOT_FINITE: NOT_FINITE,
    layout.COLLAPSED: COLLAPSED,
    layout.DIVERGED: DIVERGED,
    layout.STIFF: STIFF,
}
FINEST_OF_SUMS = 1e-14
"""Relative tolerance below which explicit sums of many steps lose more to round-off than the steps err."""
_PIECE = 0.1  # seconds between two looks at the keyboard
_MEMORY = 1 << 25  # bytes of one buffer at most


class _Piece(NamedTuple):
    """What one call of the compiled loop has done: starts of steps, events, and where it ended."""

    times: Array
    lengths: Array
    states: Array
    crossings: list[Crossing]
    code: int
    end: float
    last: Array


def integrate(
    rates: Rates,
    state: ArrayLike,
    start: float,
    until: float,
    *,
    relative: ArrayLike = 1e-9,
    absolute: ArrayLike = 1e-9,
    watch: Watch | None = None,
    max_step: float = math.inf,
    first_step: float | None = None,
    max_steps: int | None = None,
    between: Callable[[float], None] | None = None,
    method: str = "dop853",
    step: float | None = None,
    until_stiff: bool = False,
    budget: int | None = None,
) -> Path:
    """The path from ``state`` at ``start`` to ``until`` (earlier than ``start``: backwards in time).

    The local error of component i is kept below absolute[i] + relative[i] |y_i|.

    Parameters
    ----------
    rates                right-hand side
    state                shape (n,); its quaternions are normalised
    relative, absolute   tolerances, scalar or shape (n,)
    watch                event functions
    max_step, first_step greatest and first length of a step; the first is chosen when it is not given
    max_steps            stop after so many accepted steps
    between              called with the reached time between two pieces of the run; KeyboardInterrupt, from it or
                         from the keyboard, ends the run and keeps what was computed
    method               "dop853", "dop54", "radau", "gauss", "taylor" or "structure" (`loop.SOURCES`)
    step                 length of all steps, whatever their error; made a little shorter, so that a whole number fits
    budget               of a long run, tighten the tolerances after so many steps, so that the errors of all that are
                         still to come together stay within the errors of as many steps again
    until_stiff          stop, with the status STIFF, where an explicit method is limited by stability and far from done
    """
    loop.use(method)
    y, start, until = np.array(state, dtype=float), float(start), float(until)
    for i in rates.quaternions:  # in the order of the compiled loop, to the last bit
        a, b, c, d = y[i : i + 4].tolist()
        y[i : i + 4] /= math.sqrt(a * a + b * b + c * c + d * d)
    rtol, atol = np.full(y.shape, relative, dtype=float), np.full(y.shape, absolute, dtype=float)

    def at(t: float, y: Array) -> Array:
        return observe(rates.address, rates.size, np.array([t]), y[None], rates.constants)[0]

    # of "taylor" the first series shows whether there are rates
    f = at(start, y) if method != "taylor" else np.zeros(y.shape)
    longest = min(max_step, abs(until - start))
    if longest == 0 or not np.isfinite(f).all():
        wrong = np.flatnonzero(~np.isfinite(f))
        status, blame = (NOT_FINITE, int(wrong[0])) if wrong.size else (FINISHED, 0)
        return Path(
            rates, np.array([start]), np.empty(0), y[None], (), status, blame, 0, 1, method, rtol, atol
        )
    direction = 1.0 if until >= start else -1.0
    if step is not None:
        first_step = abs(until - start) / math.ceil(abs(until - start) / min(step, longest) * (1 - 1e-12))
    elif method == "taylor":
        first_step = longest  # not used: each step follows from its series
    elif first_step is None:
        first_step = _first_step(
            at, start, direction, longest, y, f, atol + rtol * np.abs(y), layout.ORDERS[method]
        )

    run = _Run(rates, watch, y, f, rtol, atol, method)
    run.integers[layout.ASKED], run.integers[layout.FIXED] = until_stiff, step is not None
    run.reals[layout.TIME] = run.reals[layout.START] = start
    run.reals[layout.UNTIL], run.reals[layout.MAX_STEP] = until, max_step
    run.reals[layout.STEP], run.reals[layout.OLD_ERROR] = direction * min(first_step, longest), 1e-4
    largest = max(16, _MEMORY // (8 * (y.size + 2)))
    room = min(1024, largest)
    left = math.inf if max_steps is None else max_steps
    steps = 0
    pieces: list[_Piece] = []
    status = ""
    try:
        while not status:
            clock = perf_counter()
            # a piece is appended whole: wherever the keyboard interrupts, the pieces fit together
            allowed = room if budget is None or steps >= budget else min(room, budget - steps)
            pieces.append(run.piece(int(min(allowed, left))))
            clock = perf_counter() - clock
            done = pieces[-1].times.size
            left -= done
            steps += done
            if steps == budget and done:
                # the same place whatever the computer's speed: a run can be repeated to the last bit
                _tighten(run, steps, start, pieces[-1].end, until, layout.ORDERS[method], rtol, atol)
            if pieces[-1].code != layout.RUNNING:
                status = _STATUS[pieces[-1].code]
            elif left <= 0:
                status = TOO_MANY_STEPS
            else:
                pace = max(done, 1) / max(clock, 1e-6)
                room = int(min(largest, max(16, min(4 * room, _PIECE * pace))))
                if between is not None:
                    between(pieces[-1].end)
    except KeyboardInterrupt:
        status = INTERRUPTED
    end, last = (pieces[-1].end, pieces[-1].last) if pieces else (start, y)
    return Path(
        rates,
        np.concatenate([*(piece.times for piece in pieces), [end]]),
        np.concatenate([*(piece.lengths for piece in pieces), []]),
        np.concatenate([*(piece.states for piece in pieces), last[None]]),
        tuple(crossing for piece in pieces for crossing in piece.crossings),
        status,
        int(run.integers[layout.BLAME]),
        int(run.integers[layout.REJECTED]),
        int(run.integers[layout.EVALUATED]) + 2,
        method,
        rtol,
        atol,
        int(run.integers[layout.STIFFNESS]),
    )


def _tighten(
    run: _Run, steps: int, start: float, now: float, until: float, order: int, rtol: Array, atol: Array
) -> None:
    """Tolerances for the rest of a long run: ε' N' = ε ``steps``, with N' = N (ε/ε')^(1/p) steps still to come."""
    ahead = steps * (until - now) / (now - start)
    factor = (steps / ahead) ** (order / (order - 1)) if ahead > steps else 1.0
    factor = max(factor, min(1.0, FINEST_OF_SUMS / float(np.min(rtol)) if rtol.size else 1.0))
    rtol *= factor
    atol *= factor
    run.reals[layout.STEP] *= factor ** (1 / order)


class _Run:
    """The arrays that the compiled loop works on, from one piece to the next."""

    def __init__(
        self,
        rates: Rates,
        watch: Watch | None,
        y: Array,
        f: Array,
        relative: Array,
        absolute: Array,
        method: str,
    ) -> None:
        n, width = rates.size, layout.padded(rates.size)
        self.n, self.method = n, method
        self.reals = np.zeros(layout.REALS)
        self.integers = np.zeros(layout.INTEGERS, dtype=np.int64)
        work = work_room(method, n)
        self.state = work[layout.STATE * width :][:n]
        self.state[:] = y
        work[:n] = f
        self.corrections = rates.corrections
        self.fixed = (
            rates.address, n, rates.constants, work, width, self.corrections, len(rates.quaternions), relative,
            absolute, self.reals, self.integers,
        )  # fmt: skip
        self.rates, self.watch, self.y = rates, watch, y
        self.events: tuple | None = None

    def _watching(self, watch: Watch) -> tuple:
        """Arguments of the search for events."""
        m = len(watch.directions)
        constants = self.rates.constants if watch.constants is None else watch.constants
        table = np.zeros((layout.PARTS + 3, m + 1))
        begin = np.array([self.reals[layout.START]])
        table[0, :m] = observe(watch.address, m, begin, self.y[None], constants)[0]
        found = np.zeros((layout.most_events(m), layout.FOUND))
        return (
            watch.address, m, constants, np.array(watch.directions, dtype=np.int64),
            np.array(watch.terminal, dtype=np.int64), np.sign(table[0, :m]).astype(np.int64), table, np.zeros(m),
            found,
        )  # fmt: skip

    def piece(self, room: int) -> _Piece:
        """Up to ``room`` steps."""
        times, lengths, states = np.empty(room), np.empty(room), np.empty((room, self.n))
        crossings: list[Crossing] = []
        events: tuple[Any, ...] = (0, 0, *[None] * 9)
        if self.watch is not None and self.watch.directions:
            self.events = self.events or self._watching(self.watch)
            size = room + len(self.events[-1])
            log, where = np.empty((size, layout.LOGGED)), np.empty((size, self.n))
            events = (*self.events, log, where)
        code = loop.advance(self.method, *self.fixed, room, times, lengths, states, *events)
        crossings = [
            Crossing(float(log[k, 0]), int(log[k, 1]), int(log[k, 2]), where[k].copy())
            for k in range(self.integers[layout.EVENTS])
        ]
        done = self.integers[layout.ACCEPTED]
        end = float(self.reals[layout.TIME])
        return _Piece(times[:done], lengths[:done], states[:done], crossings, code, end, self.state.copy())


def _first_step(
    at: Callable[[float, Array], Array],
    t: float,
    direction: float,
    longest: float,
    y: Array,
    f: Array,
    scale: Array,
    order: int,
) -> float:
    """A length for the first step (Hairer, Norsett, Wanner, section II.4)."""
    if not y.size:  # every joint is driven: there is nothing to integrate
        return longest
    size, slope = float(np.max(np.abs(y) / scale)), float(np.max(np.abs(f) / scale))
    guess = min(1e-6 if size < 1e-5 or slope < 1e-5 else 0.01 * size / slope, longest)
    curve = float(np.max(np.abs(at(t + direction * guess, y + direction * guess * f) - f) / scale)) / guess
    if not math.isfinite(curve):
        return guess
    steepest = max(slope, curve)
    other = max(1e-6, guess * 1e-3) if steepest <= 1e-15 else (0.01 / steepest) ** (1 / order)
    return min(100 * guess, other, longest)
