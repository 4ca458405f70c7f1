"""A run of the integrator, in pieces.

The compiled loop (`loop`) works in pieces of about a tenth of a second. Between two pieces Python may show the
progress, notice an interruption, and make new buffers; within a step there is no Python.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from time import perf_counter
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from . import layout, loop
from .path import (
    COLLAPSED,
    DIVERGED,
    FINISHED,
    INTERRUPTED,
    NOT_FINITE,
    RELEASED,
    STIFF,
    TERMINAL,
    TOO_MANY_STEPS,
    UNDEFINED,
    Array,
    Crossing,
    Path,
    Rates,
    Watch,
    cut,
)

_STATUS = {
    layout.FINISHED: FINISHED,
    layout.TERMINAL: TERMINAL,
    layout.NOT_FINITE: NOT_FINITE,
    layout.COLLAPSED: COLLAPSED,
    layout.DIVERGED: DIVERGED,
    layout.STIFF: STIFF,
    layout.UNDEFINED: UNDEFINED,
}
_ENDS = (layout.FINISHED, layout.TERMINAL)
FINEST_OF_SUMS = 1e-14
"""Relative tolerance below which explicit sums of many steps lose more to round-off than the steps err."""
_PIECE = 0.1  # seconds between two looks at the keyboard
_MEMORY = 1 << 25  # bytes of one buffer at most


class _Piece(NamedTuple):
    """What one call of the compiled loop has done: its steps, with the state at the start of each and at the end of the
    last, events, and why it ended."""

    times: Array
    lengths: Array
    states: Array
    crossings: list[Crossing]
    code: int


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
    halt: Callable[[Array, Array], int | None] | None = None,
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
    halt                 (times, states) of some steps -> the first of these states at which the run stops, with the
                         status RELEASED, if there is one
    """
    run = _Run(rates, watch, method, state, relative, absolute)
    span = abs(until - start)
    if step is not None:
        longest = min(step, max_step, span)
        first_step = span / math.ceil(span / longest * (1 - 1e-12)) if span else step
    run.integers[layout.ASKED], run.integers[layout.FIXED] = until_stiff, step is not None
    run.reals[:] = (start, first_step or 0.0, 0.0, until, max_step, start, layout.ORDERS[method])
    largest = max(16, _MEMORY // (8 * (rates.size + 2)))
    room = min(1024 if halt is None else 64, largest)  # what comes after a halt was for nothing
    left = math.inf if max_steps is None else max_steps
    steps, last = 0, None
    pieces: list[_Piece] = []
    status = ""
    try:
        while not status:
            clock = perf_counter()
            # a piece is appended whole: wherever the keyboard interrupts, the pieces fit together
            allowed = room if budget is None or steps >= budget else min(room, budget - steps)
            pieces.append(run.piece(int(min(allowed, left))))
            clock = perf_counter() - clock
            done = pieces[-1].lengths.size
            left -= done
            steps += done
            if halt is not None:
                found = halt(pieces[-1].times, pieces[-1].states)
                if found is not None and (found < done or pieces[-1].code not in _ENDS):
                    status, last = RELEASED, steps - done + found
                    break
            if steps == budget and done:
                # the same place whatever the computer's speed: a run can be repeated to the last bit
                _tighten(run, steps, start, until, layout.ORDERS[method])
            if pieces[-1].code != layout.RUNNING:
                status = _STATUS[pieces[-1].code]
            elif left <= 0:
                status = TOO_MANY_STEPS
            else:
                pace = max(done, 1) / max(clock, 1e-6)
                room = int(min(largest, max(16, min(4 * room, _PIECE * pace))))
                if between is not None:
                    between(float(pieces[-1].times[-1]))
    except KeyboardInterrupt:
        status = INTERRUPTED
    if not pieces:
        pieces.append(_Piece(np.array([start]), np.empty(0), np.array(state, dtype=float)[None], [], 0))
    *before, end = pieces
    counts = run.integers.tolist()
    path = Path(
        rates,
        np.concatenate([*(piece.times[:-1] for piece in before), end.times]),
        np.concatenate([piece.lengths for piece in pieces]),
        np.concatenate([*(piece.states[:-1] for piece in before), end.states]),
        tuple(crossing for piece in pieces for crossing in piece.crossings),
        status,
        counts[layout.BLAME],
        counts[layout.REJECTED],
        counts[layout.EVALUATED],
        method,
        run.relative.copy(),
        run.absolute.copy(),
        counts[layout.STIFFNESS],
    )
    return path if last is None else cut(path, last, status)


def _tighten(run: _Run, steps: int, start: float, until: float, order: int) -> None:
    """Tolerances for the rest of a long run: ε' N' = ε ``steps``, with N' = N (ε/ε')^(1/p) steps still to come."""
    now, relative = float(run.reals[layout.TIME]), run.relative
    ahead = steps * (until - now) / (now - start)
    factor = (steps / ahead) ** (order / (order - 1)) if ahead > steps else 1.0
    factor = max(factor, min(1.0, FINEST_OF_SUMS / float(np.min(relative)) if relative.size else 1.0))
    relative *= factor
    run.absolute *= factor
    run.reals[layout.STEP] *= factor ** (1 / order)


class _Run:
    """What the compiled loop works on, from one piece to the next: arrays in one block of memory."""

    def __init__(
        self,
        rates: Rates,
        watch: Watch | None,
        method: str,
        state: ArrayLike,
        relative: ArrayLike,
        absolute: ArrayLike,
    ) -> None:
        n, c, told = rates.size, rates.constants, rates.corrections
        watched, m, ce = 0, 0, c[:0]
        if watch is not None and watch.directions:
            watched, m = watch.address, len(watch.directions)
            ce = c if watch.constants is None else watch.constants
        self.function = loop.use(method, m > 0)
        place, starts, size = layout.block(method, n, c.size, told.size, m, ce.size)
        # from the start of a line of the cache: rows that lie across two are read and written in two parts
        memory = np.zeros(size + 8)
        base = loop.address(memory)
        shift = -base % 64 // 8
        base += 8 * shift
        real = memory[shift:]
        whole = real.view(np.int64)
        self.n, self.m, self.address = n, m, base + 8 * place["told"].start
        self.told, self.integers, self.reals = (
            whole[place["told"]],
            whole[place["integers"]],
            real[place["reals"]],
        )
        self.relative, self.absolute = real[place["relative"]], real[place["absolute"]]
        real[place["state"]] = state
        self.relative[:], self.absolute[:] = relative, absolute
        real[place["constants"]], whole[place["quaternions"]] = c, told
        if m:
            assert watch is not None
            real[place["watch_constants"]] = ce
            whole[place["directions"]], whole[place["terminal"]] = watch.directions, watch.terminal
            self.integers[layout.NAMED] = m if watch.named is None else watch.named
        self.told[: layout.NUMBERS] = (
            rates.address,
            n,
            layout.padded(n),
            len(rates.quaternions),
            0,
            watched,
            m,
        )
        np.add(starts, base, out=self.told[layout.NUMBERS : layout.NUMBERS + len(starts)])

    def piece(self, room: int) -> _Piece:
        """Up to ``room`` steps."""
        n, rows = self.n, room + 1
        logged = room + layout.most_events(self.m) if self.m else 0
        memory = np.empty(rows * (2 + n) + logged * (layout.LOGGED + n))
        of_events = rows * (2 + n)
        starts = (0, rows, 2 * rows, of_events, of_events + layout.LOGGED * logged)
        base = loop.address(memory)
        self.told[layout.ROOM] = room
        self.told[-len(starts) :] = [base + 8 * start for start in starts]
        code = self.function(self.address)
        done, found = int(self.integers[layout.ACCEPTED]), int(self.integers[layout.EVENTS])
        crossings = []
        if found:
            log = memory[starts[3] :][: layout.LOGGED * found].reshape(found, layout.LOGGED)
            where = memory[starts[4] :][: n * found].reshape(found, n)
            crossings = [
                Crossing(moment, int(number), int(sign), state.copy())
                for (moment, number, sign), state in zip(log.tolist(), where, strict=True)
            ]
        states = memory[2 * rows :][: n * (done + 1)].reshape(done + 1, n)
        return _Piece(memory[: done + 1], memory[rows : rows + done], states, crossings, code)
