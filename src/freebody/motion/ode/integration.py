"""A run of the integrator, in pieces.

The compiled loop (`loop`) works in pieces of about a tenth of a second. Between two pieces Python may show the
progress, react to an interruption, and make new buffers. Within a step no Python runs.
"""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

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
from .run import COUNTS, NUMBERS, Run, equip, memory, most_events

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
"""Relative tolerance below which, in long runs, the round-off of explicit sums exceeds the error of the steps."""
_PIECE = 0.1  # seconds between two checks of the keyboard
_MEMORY = 1 << 25  # maximum number of bytes of one buffer
_FIRST = 1024  # steps of the first piece
_SMALL, _SHAPES = 1 << 20, 16  # maximum size in bytes, and number, of the buffers kept for later runs


Halt = Callable[[Array, Array], tuple[int, str, int] | None]


def first_halt(*halts: Halt | None) -> Halt | None:
    """Return a halt that asks several halts in order and reports the first answer."""
    active = [halt for halt in halts if halt is not None]
    if len(active) < 2:
        return active[0] if active else None
    return lambda times, states: next(
        (answer for halt in active if (answer := halt(times, states)) is not None), None
    )


_Piece = tuple[Array, Array, Array, list[Crossing], int]
"""Result of one call of the compiled loop: times, lengths and states of its steps, with the time and state of the end
of the last; events; and the status."""


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
    """Return the path from ``state`` at ``start`` to ``until`` (earlier than ``start``: backwards in time).

    The local error of component i is kept below absolute[i] + relative[i] |y_i|.

    Parameters
    ----------
    rates                right-hand side
    state                shape (n,); its quaternions are normalised
    relative, absolute   tolerances, scalar or shape (n,)
    watch                event functions
    max_step, first_step longest and first step; by default the first is chosen automatically
    max_steps            maximum number of accepted steps
    between              called with the reached time between two pieces of the run; KeyboardInterrupt, from it or
                         from the keyboard, ends the run and keeps the computed steps
    method               "dop853", "dop54", "radau", "gauss", "taylor" or "structure" (`layout.ORDERS`)
    step                 length of all steps, whatever their error; shortened so that a whole number of steps fits
    until_stiff          stop, with the status STIFF, where stability limits an explicit method far from the end
    budget               after so many steps, tighten the tolerances so that the errors of all remaining steps together
                         stay within the errors of as many steps again
    halt                 (times, states) of some steps -> index of the first of these states at which the run stops, the
                         status, and the index to blame; None if it goes on
    """
    common = Integration(
        rates, relative, watch, max_step, first_step, max_steps, method, step, until_stiff, budget
    )
    return common.path(state, start, until, absolute, between, halt)


@dataclass(eq=False, slots=True)
class Integration:
    """The common part of several paths, as arguments of `integrate`."""

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
        """Return the path from one initial state (`integrate`)."""
        rates, method, budget = self.rates, self.method, self.budget
        shape = method, rates.size, 0 if self.watch is None else len(self.watch.directions)
        run = _SPARE.pop(shape, None) or _Run(*shape)
        run.begin(self, state, absolute, start, until)
        room, growth = run.room, 4
        if (
            halt is not None
        ):  # steps after a halt are wasted, and those of a large machine cost more than a look at them
            room, growth = (16, 1) if rates.size >= layout.MANY_COMPONENTS else (min(64, room), 4)
        remaining = math.inf if self.max_steps is None else self.max_steps
        relative, steps, last = self.relative, 0, None
        pieces: list[_Piece] = []
        try:
            while True:
                clock = perf_counter()
                # append a piece as a whole, so that the pieces fit together wherever the keyboard interrupts
                allowed = room if budget is None or steps >= budget else min(room, budget - steps)
                pieces.append(run.piece(int(min(allowed, remaining))))
                times, lengths, states, _, code = pieces[-1]
                done = lengths.size
                remaining -= done
                steps += done
                if halt is not None:
                    answer = halt(times, states)
                    if answer is not None and (answer[0] < done or code not in _ENDS):
                        last, status, blame = steps - done + answer[0], *answer[1:]
                        break
                if code != layout.RUNNING:
                    status = _STATUS[code]
                    break
                if steps == budget and done:
                    # at a fixed number of steps, so that runs agree to the last bit on every computer
                    _tighten(run, steps, start, until, layout.ORDERS[method])
                    relative, absolute = run.relative.copy(), run.absolute.copy()
                if remaining <= 0:
                    status = TOO_MANY_STEPS
                    break
                pace = max(done, 1) / max(perf_counter() - clock, 1e-6)
                largest = max(16, _MEMORY // (8 * (rates.size + 2)))
                room = int(min(largest, max(16, min(growth * room, _PIECE * pace))))
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
            counts.blame,
            counts.rejected,
            counts.evaluated,
            method,
            relative,
            absolute,
            counts.stiffness,
            run.step() if method in layout.SINGLE_STEPS and steps == 1 else None,
        )
        run.give_back()
        return path if last is None else replace(cut(path, last, status), blame=blame)


def _joined(pieces: list[_Piece]) -> tuple[Array, Array, Array, tuple[Crossing, ...]]:
    """Return the times, lengths, states and events of all pieces."""
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
    """Tighten the tolerances for the rest of a long run: ε' N' = ε ``steps``, with N' = N (ε/ε')^(1/p)
    remaining steps.
    """
    now, relative = run.record.t, run.relative
    ahead = steps * (until - now) / (now - start)
    factor = (steps / ahead) ** (order / (order - 1)) if ahead > steps else 1.0
    factor = max(factor, min(1.0, FINEST_OF_SUMS / float(np.min(relative)) if relative.size else 1.0))
    relative *= factor
    run.absolute *= factor
    run.common = None
    run.record.h *= factor ** (1 / order)


_Counts = namedtuple("_Counts", COUNTS)  # type: ignore[misc]
_PACKED, _NUMBERS_AT = Run.packer(*NUMBERS)
_COUNTED, _COUNTS_AT = Run.packer(*COUNTS)
_NO_COUNTS = (0,) * len(COUNTS)


class _Run:
    """Memory of the compiled loop, kept from one piece to the next, and buffers for the steps of a piece. The next run
    of the same shape uses both again.
    """

    def __init__(self, *shape: Any) -> None:
        self.shape = shape
        method, n, m = shape
        self.record, self.own = record, _ = memory(*shape)
        self.n, self.m, self.address = n, m, record.address
        self.bytes = record.memory.data.cast("B")
        self.initial, self.relative, self.absolute = record.initial, record.relative, record.absolute
        self.common: Integration | None = None
        self.absolute_of: ArrayLike | None = None
        self.named = 0
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
        """Write the start of a run over the end of the last. Common arguments that have not changed stay."""
        if self.common is not common:
            self.common, self.absolute_of = common, None
            rates, watch, search = common.rates, common.watch, self.record.search
            equip(self.record, self.own, rates)
            if watch is not None and self.m:
                search.functions = watch.address
                search.c = rates.constants if watch.constants is None else watch.constants
                search.directions[:], search.terminal[:] = watch.directions, watch.terminal
                self.named = self.m if watch.named is None else watch.named
            self.relative[:] = common.relative
            self.function = loops.use(common.method)
        if self.absolute_of is not absolute:
            self.absolute[:] = absolute
            unchanging = isinstance(absolute, np.ndarray) and not absolute.flags.writeable
            self.absolute_of = absolute if unchanging else None
        first = common.first_step or 0.0
        if common.step is not None:
            span = abs(until - start)
            longest = min(common.step, common.max_step, span)
            first = span / math.ceil(span / longest * (1 - 1e-12)) if span else common.step
        self.initial[:] = state
        _PACKED.pack_into(
            self.bytes, _NUMBERS_AT, start, first, 0.0, until, common.max_step, start, *_NO_COUNTS,
            common.until_stiff, common.step is not None, self.named,
        )  # fmt: skip
        self.counts: Any = _Counts._make(_NO_COUNTS)

    def step(self) -> Any:
        """Return a copy of the memory of the method."""
        own = memory(*self.shape)[1]
        own.take(self.own)
        return own

    def give_back(self) -> None:
        """Offer this memory to the next run of the same shape."""
        if self.room and self.small:
            if len(_SPARE) >= _SHAPES:
                _SPARE.clear()
            _SPARE[self.shape] = self

    def _buffers(self, room: int) -> None:
        """Make new buffers for ``room`` steps."""
        n, rows = self.n, room + 1
        logged = room + most_events(self.m) if self.m else 0
        self.buffer = buffer = np.empty(rows * (2 + n) + logged * (3 + n))
        ends = np.cumsum([0, rows, rows, rows * n, logged, logged, logged, logged * n])
        parts = [buffer[begin:end] for begin, end in pairwise(ends.tolist())]
        record, search = self.record, self.record.search
        record.times, record.lengths, record.states = *parts[:2], parts[2].reshape(rows, n)
        search.log_times, search.log_states = parts[3], parts[6].reshape(logged, n)
        search.log_numbers, search.log_signs = parts[4].view(np.int64), parts[5].view(np.int64)

    def piece(self, room: int) -> _Piece:
        """Compute up to ``room`` steps."""
        if room > self.room:  # a long run: its pieces stay in their own buffers
            self._buffers(room)
            self.room = 0
        self.record.room = room
        code = self.function(self.address)
        self.counts = counts = _Counts._make(_COUNTED.unpack_from(self.bytes, _COUNTS_AT))
        count, events = counts.accepted, counts.events
        crossings = []
        if events:
            search = self.record.search
            log = search.log_times, search.log_numbers, search.log_signs
            crossings = [
                Crossing(*values, state.copy())
                for *values, state in zip(
                    *(x[:events].tolist() for x in log), search.log_states[:events], strict=True
                )
            ]
        rows = count + 1
        steps = self.buffer[: rows * (2 + self.n) - 1]
        if self.room:
            steps = steps.copy()
        return (
            steps[:rows],
            steps[rows : rows + count],
            steps[rows + count :].reshape(rows, self.n),
            crossings,
            code,
        )


_SPARE: dict[tuple[Any, ...], _Run] = {}
"""Memory of finished runs, by shape. A run takes it out at its start, so that no two runs share it."""
