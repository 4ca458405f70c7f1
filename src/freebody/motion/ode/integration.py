"""A run of the integrator, in pieces.

The compiled loop (`loop`) works in pieces of about a tenth of a second. Between two pieces Python may show the
progress, notice an interruption, and make new buffers; within a step there is no Python.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...native import loop
from . import layout, loops
from .dense_output import (
    COLLAPSED,
    DIVERGED,
    FINISHED,
    INTERRUPTED,
    NOT_FINITE,
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
_FIRST = 1024  # steps of the first piece
_SMALL, _SHAPES = 1 << 20, 16  # bytes of a buffer that is kept for the next run, and how many are


Halt = Callable[[Array, Array], tuple[int, str, int] | None]


def first_halt(*halts: Halt | None) -> Halt | None:
    """The first of several halts that has something to say."""
    asked = [one for one in halts if one is not None]
    if len(asked) < 2:
        return asked[0] if asked else None
    return lambda times, states: next((k for one in asked if (k := one(times, states)) is not None), None)


_Piece = tuple[Array, Array, Array, list[Crossing], int]
"""What one call of the compiled loop has done: times, lengths and states of its steps, with the time and state of the
end of the last; events; and why it ended."""


def integrate(
    rates: Rates,
    state: Sequence[float] | Array,
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
    halt: Halt | None = None,
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
    method               "dop853", "dop54", "radau", "gauss", "taylor" or "structure" (`layout.ORDERS`)
    step                 length of all steps, whatever their error; made a little shorter, so that a whole number fits
    budget               of a long run, tighten the tolerances after so many steps, so that the errors of all that are
                         still to come together stay within the errors of as many steps again
    until_stiff          stop, with the status STIFF, where an explicit method is limited by stability and far from done
    halt                 (times, states) of some steps -> the first of these states at which the run stops, its status
                         there and what is to blame, if there is one
    """
    common = Integration(
        rates, relative, watch, max_step, first_step, max_steps, method, step, until_stiff, budget
    )
    return common.path(state, start, until, absolute, between, halt)


@dataclass(eq=False, slots=True)
class Integration:
    """What paths from several starts have in common, as arguments of `integrate`."""

    rates: Rates
    relative: ArrayLike
    watch: Watch | None = None
    max_step: float = math.inf
    first_step: float | None = None
    max_steps: int | None = None
    method: str = "dop853"
    step: float | None = None
    until_stiff: bool = False
    budget: int | None = None

    def path(
        self, state: Sequence[float] | Array, start: float, until: float, absolute: ArrayLike,
        between: Callable[[float], None] | None = None, halt: Halt | None = None,
    ) -> Path:  # fmt: skip
        """See `integrate`."""
        rates, method, budget = self.rates, self.method, self.budget
        shape = method, rates.size, 0 if self.watch is None else len(self.watch.directions)
        run = _SPARE.pop(shape, None) or _Run(*shape)
        run.begin(self, state, absolute, start, until)
        room = run.room if halt is None else min(64, run.room)  # what comes after a halt was for nothing
        left = math.inf if self.max_steps is None else self.max_steps
        relative, steps, last = self.relative, 0, None
        pieces: list[_Piece] = []
        try:
            while True:
                clock = perf_counter()
                # a piece is appended whole: wherever the keyboard interrupts, the pieces fit together
                allowed = room if budget is None or steps >= budget else min(room, budget - steps)
                pieces.append(run.piece(int(min(allowed, left))))
                times, lengths, states, _, code = pieces[-1]
                done = lengths.size
                left -= done
                steps += done
                if halt is not None:
                    found = halt(times, states)
                    if found is not None and (found[0] < done or code not in _ENDS):
                        last, status, blame = steps - done + found[0], *found[1:]
                        break
                if code != layout.RUNNING:
                    status = _STATUS[code]
                    break
                if steps == budget and done:
                    # the same place whatever the computer's speed: a run can be repeated to the last bit
                    _tighten(run, steps, start, until, layout.ORDERS[method])
                    relative, absolute = run.relative.copy(), run.absolute.copy()
                if left <= 0:
                    status = TOO_MANY_STEPS
                    break
                pace = max(done, 1) / max(perf_counter() - clock, 1e-6)
                largest = max(16, _MEMORY // (8 * (rates.size + 2)))
                room = int(min(largest, max(16, min(4 * room, _PIECE * pace))))
                if between is not None:
                    between(float(times[-1]))
        except KeyboardInterrupt:
            status = INTERRUPTED
        if not pieces:
            pieces.append((np.array([start]), np.empty(0), np.array(state, dtype=float)[None], [], 0))
        counts = run.counts
        path = Path(
            rates,
            *_joined(pieces),
            status,
            counts[layout.BLAME],
            counts[layout.REJECTED],
            counts[layout.EVALUATED],
            method,
            relative,
            absolute,
            counts[layout.STIFFNESS],
        )
        run.give_back()
        return path if last is None else replace(cut(path, last, status), blame=blame)


def _joined(pieces: list[_Piece]) -> tuple[Array, Array, Array, tuple[Crossing, ...]]:
    """Times, lengths, states and events of all."""
    if len(pieces) == 1:
        times, lengths, states, crossings, _ = pieces[0]
        return times, lengths, states, tuple(crossings)
    *before, (times, _, states, _, _) = pieces
    return (
        np.concatenate([*(piece[0][:-1] for piece in before), times]),
        np.concatenate([piece[1] for piece in pieces]),
        np.concatenate([*(piece[2][:-1] for piece in before), states]),
        tuple(crossing for piece in pieces for crossing in piece[3]),
    )


def _tighten(run: _Run, steps: int, start: float, until: float, order: int) -> None:
    """Tolerances for the rest of a long run: ε' N' = ε ``steps``, with N' = N (ε/ε')^(1/p) steps still to come."""
    now, relative = float(run.reals[layout.TIME]), run.relative
    ahead = steps * (until - now) / (now - start)
    factor = (steps / ahead) ** (order / (order - 1)) if ahead > steps else 1.0
    factor = max(factor, min(1.0, FINEST_OF_SUMS / float(np.min(relative)) if relative.size else 1.0))
    relative *= factor
    run.absolute *= factor
    run.common = None
    run.reals[layout.STEP] *= factor ** (1 / order)


class _Run:
    """What the compiled loop works on, from one piece to the next: arrays in one block of memory, and buffers for the
    steps of a piece in another. Both serve the next run of the same shape (`layout.block`)."""

    def __init__(self, *shape: Any) -> None:
        self.shape = shape
        _, n, m = shape
        place, starts, size = layout.block(*shape)
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
        # the state at the start, real numbers and integers, of which those before ASKED are zeros
        self.memory, self.carried = memory.data.cast("B"), 8 * (shift + place["start"].start)
        at_start = f"{n + layout.REALS}d{8 * layout.ASKED}x{layout.INTEGERS - layout.ASKED}q"
        self.write = struct.Struct(at_start).pack_into
        self.relative, self.absolute = real[place["relative"]], real[place["absolute"]]
        self.directions, self.terminal = whole[place["directions"]], whole[place["terminal"]]
        told = n, m, layout.padded(n), *(starts + base).tolist()
        self.told[layout.ROOM + 1 : -len(layout.BUFFERS)] = told
        self.common: Integration | None = None
        self.absolute_of: ArrayLike | None = None
        self.named, self.order = 0, layout.ORDERS[shape[0]]
        self.room = min(_FIRST, max(16, _MEMORY // (8 * (n + 2))))
        self._buffers(self.room)
        self.small = self.buffer.nbytes <= _SMALL

    def begin(
        self,
        common: Integration,
        state: Sequence[float] | Array,
        absolute: ArrayLike,
        start: float,
        until: float,
    ) -> None:
        """The start of a run in place of the end of another; what they have in common stays."""
        if self.common is not common:
            self.common, self.absolute_of = common, None
            rates, watch = common.rates, common.watch
            self.told[layout.RATES] = rates.told
            if watch is not None and self.m:
                constants = rates.constants if watch.constants is None else watch.constants
                self.told[layout.WATCHED] = watch.address, loop.passed(constants, "Reals") or 0
                self.directions[:], self.terminal[:] = watch.directions, watch.terminal
                self.named = self.m if watch.named is None else watch.named
            self.relative[:] = common.relative
            self.function = loops.use(common.method)
        if self.absolute_of is not absolute:
            self.absolute[:] = absolute
            kept = isinstance(absolute, np.ndarray) and not absolute.flags.writeable
            self.absolute_of = absolute if kept else None
        first = common.first_step or 0.0
        if common.step is not None:
            span = abs(until - start)
            longest = min(common.step, common.max_step, span)
            first = span / math.ceil(span / longest * (1 - 1e-12)) if span else common.step
        self.write(
            self.memory, self.carried, *state, start, first, 0.0, until, common.max_step, start, self.order,
            common.until_stiff, common.step is not None, self.named,
        )  # fmt: skip
        self.counts: Sequence[int] = _NOTHING

    def give_back(self) -> None:
        """The next run of this shape works here."""
        if self.room and self.small:
            if len(_SPARE) >= _SHAPES:
                _SPARE.clear()
            _SPARE[self.shape] = self

    def _buffers(self, room: int) -> None:
        """New ones, for ``room`` steps."""
        n, rows = self.n, room + 1
        logged = room + layout.most_events(self.m) if self.m else 0
        self.buffer = memory = np.empty(rows * (2 + n) + logged * (layout.LOGGED + n))
        of_events = rows * (2 + n)
        starts = (0, rows, 2 * rows, of_events, of_events + layout.LOGGED * logged)
        base = loop.address(memory)
        self.told[-len(starts) :] = [base + 8 * start for start in starts]
        self.log = memory[of_events : starts[4]].reshape(logged, layout.LOGGED)
        self.where = memory[starts[4] :].reshape(logged, n)

    def piece(self, room: int) -> _Piece:
        """Up to ``room`` steps."""
        if room > self.room:  # a long run: its pieces stay where they were made
            self._buffers(room)
            self.room = 0
        self.told[layout.ROOM] = room
        code = self.function(self.address)
        self.counts = counts = self.integers.tolist()
        done, found = counts[layout.ACCEPTED], counts[layout.EVENTS]
        crossings = []
        if found:
            crossings = [
                Crossing(moment, int(number), int(sign), state.copy())
                for (moment, number, sign), state in zip(
                    self.log[:found].tolist(), self.where[:found], strict=True
                )
            ]
        rows = done + 1
        made = self.buffer[: rows * (2 + self.n) - 1]
        if self.room:
            made = made.copy()
        return (
            made[:rows],
            made[rows : rows + done],
            made[rows + done :].reshape(rows, self.n),
            crossings,
            code,
        )


_NOTHING = (0,) * layout.INTEGERS

_SPARE: dict[tuple[Any, ...], _Run] = {}
"""Of runs that are over, by shape. A run that begins takes one out, so that no two ever share it."""
