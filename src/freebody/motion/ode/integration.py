"""A run of the integrator, in pieces.

The compiled loop (`loop`) works in pieces of about a tenth of a second. Between two pieces Python may show the
progress, react to an interruption, and make new buffers. Within a step no Python runs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...native.records import address
from ..ending import ENDS, GOOD, End
from . import layout, loops
from .dense_output import Array, Crossing, Path, Rates, Watch, cut
from .memory import equip, memory, most_events
from .run import NUMBERS, Counts, Run, Search

FINEST_OF_SUMS = 1e-14
"""Relative tolerance below which, in long runs, the round-off of explicit sums exceeds the error of the steps."""
_PIECE = 0.1  # seconds between two checks of the keyboard
_MEMORY = 1 << 25  # maximum number of bytes of one buffer
_FIRST = 1024  # steps of the first piece
_FAR = 100_000  # steps to the end, at the pace of the first piece, from which on its cause is looked for
_SMALL, _SHAPES = 1 << 20, 16  # maximum size in bytes, and number, of the buffers kept for later runs


Halt = Callable[[Array, Array], tuple[int, End, int] | None]


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


@dataclass(eq=False, slots=True)
class Integration:
    """How paths y' = f(t, y, c) are computed.

    The local error of component i is kept below absolute[i] + relative[i] |y_i|.

    Attributes
    ----------
    rates                right-hand side
    relative             tolerance, scalar or shape (n,)
    watch                event functions
    max_step, first_step longest and first step; by default the first is chosen automatically
    max_steps            maximum number of accepted steps
    method               a method of `layout.ORDERS`
    step                 length of all steps, whatever their error; shortened so that a whole number of steps fits
    until_stiff          stop, with the status STIFF, where stability limits an explicit method far from the end
    stalls               (time, state) -> True if a run of many short steps cannot come to its end: it stops, with the
                         status TOO_MANY_STEPS
    drive                what takes the steps in place of the loop of the method (`kernels.sided_way`), if not None
    budget               after so many steps, tighten the tolerances so that the errors of all remaining steps together
                         stay within the errors of as many steps again
    """

    rates: Rates
    relative: ArrayLike = 1e-9
    watch: Watch | None = None
    max_step: float = math.inf
    first_step: float | None = None
    max_steps: int | None = None
    method: str = "dop853"
    step: float | None = None
    until_stiff: bool = False
    stalls: Callable[[float, Array], bool] | None = None
    budget: int | None = None
    drive: Any = None

    def path(
        self, state: Sequence[float] | Array, start: float, until: float, absolute: ArrayLike = 1e-9,
        between: Callable[[float], None] | None = None, halt: Halt | None = None,
    ) -> Path:  # fmt: skip
        """Return the path from ``state`` at ``start`` to ``until`` (earlier than ``start``: backwards in time).

        Parameters
        ----------
        state                shape (n,); its quaternions are normalised
        absolute             tolerance, scalar or shape (n,)
        between              called with the reached time between two pieces of the run; KeyboardInterrupt, from it or
                             from the keyboard, ends the run and keeps the computed steps
        halt                 (times, states) of some steps -> index of the first of these states at which the run stops,
                             the status, and the index to blame; None if it goes on
        """
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
                    if answer is not None and (answer[0] < done or code not in GOOD):
                        last, status, blame = steps - done + answer[0], *answer[1:]
                        break
                if code != layout.RUNNING:
                    status = ENDS[code]
                    break
                if steps == budget and done:
                    # at a fixed number of steps, so that runs agree to the last bit on every computer
                    _tighten(run, steps, start, until, layout.ORDERS[method])
                    relative, absolute = run.relative.copy(), run.absolute.copy()
                if remaining <= 0 or (
                    len(pieces) == 1 and self.stalls is not None and _steps_ahead(times, until) > _FAR
                    and self.stalls(float(times[-1]), states[-1])
                ):  # fmt: skip
                    status = End.TOO_MANY_STEPS
                    break
                pace = max(done, 1) / max(perf_counter() - clock, 1e-6)
                largest = max(16, _MEMORY // (8 * (rates.size + 2)))
                room = int(min(largest, max(16, min(growth * room, _PIECE * pace))))
                if between is not None:
                    between(float(times[-1]))
        except KeyboardInterrupt:
            status = End.INTERRUPTED
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
        if last is not None:
            path = replace(cut(path, last, status), blame=blame)
        if self.drive is not None:
            path.__dict__["legs"] = run.function.legs
            run.function.give_back()
        run.give_back()
        return path


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


def _steps_ahead(times: Array, until: float) -> float:
    """Return the number of steps to the end at the pace of the later half of these."""
    half = len(times) // 2
    return half * abs(until - times[-1]) / max(abs(times[-1] - times[-1 - half]), float(np.finfo(float).tiny))


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


_PACKED, _NUMBERS_AT = Run.packer(*NUMBERS)
_COUNTED, _COUNTS_AT = Run.packer(*Counts._fields)
_NO_COUNTS = Counts()
_BUFFERS, _BUFFERS_AT = Run.packer("times", "lengths", "states")
_LOG, _LOG_AT = Search.packer("log_times", "log_numbers", "log_signs", "log_states")


class _Run:
    """Memory of the compiled loop, kept from one piece to the next, and buffers for the steps of a piece. The next run
    of the same shape uses both again.
    """

    def __init__(self, *shape: Any) -> None:
        self.shape = shape
        method, n, m = shape
        self.record, self.own = record, _ = memory(*shape)
        self.n, self.m, self.address, self.required = n, m, record.address, m
        self.bytes = record.memory.data.cast("B")
        self.initial, self.relative, self.absolute = record.initial, record.relative, record.absolute
        self.common: Integration | None = None
        self.function: Any = None
        self.absolute_of: ArrayLike | None = None
        self.allowed = 0
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
            if self.record.keep is not rates:
                equip(self.record, self.own, rates)
            if watch is not None and self.m:
                search.functions = watch.address
                search.c = rates.constants if watch.constants is None else watch.constants
                search.directions[:], search.terminal[:] = watch.directions, watch.terminal
                search.guarded = watch.guarded
                self.required = self.m - watch.guarded
            self.relative[:] = common.relative
            if common.drive is None:
                self.function = loops.use(common.method, self.m > 0)
        if self.absolute_of is not absolute:
            self.absolute[:] = absolute
            unchanging = isinstance(absolute, np.ndarray) and not absolute.flags.writeable
            self.absolute_of = absolute if unchanging else None
        first = common.first_step or 0.0
        if common.step is not None:
            span = abs(until - start)
            longest = min(common.step, common.max_step, span)
            first = span / math.ceil(span / longest * (1 - 1e-12)) if span else common.step
        if common.drive is not None:
            self.function = common.drive.begin(common, self.record, start, until)
        self.initial[:] = state
        _PACKED.pack_into(
            self.bytes, _NUMBERS_AT, start, first, 0.0, until, common.max_step, start, *_NO_COUNTS,
            common.until_stiff, common.step is not None, self.required,
        )  # fmt: skip
        self.counts = _NO_COUNTS

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
        self.log_at, self.logged = rows * (2 + n), logged
        base, size = address(buffer), buffer.itemsize
        _BUFFERS.pack_into(
            self.bytes, _BUFFERS_AT, base, base + size * rows, base + 2 * size * rows, n
        )  # fmt: skip
        if logged:
            log = (base + size * (self.log_at + k * logged) for k in range(4))
            _LOG.pack_into(self.bytes, Run.fields["search"].place + _LOG_AT, *log, n)

    def crossings(self, count: int) -> list[Crossing]:
        """Return the events in the log."""
        log, logged = self.buffer[self.log_at :], self.logged
        times, states = log[:count].tolist(), log[3 * logged :].reshape(logged, self.n)
        whole = log[logged : 3 * logged].view(np.int64).reshape(2, logged)
        numbers, signs = whole[:, :count].tolist()
        return [
            Crossing(moment, number, sign, state.copy())
            for moment, number, sign, state in zip(times, numbers, signs, states[:count], strict=True)
        ]

    def piece(self, room: int) -> _Piece:
        """Compute up to ``room`` steps."""
        if room > self.room:  # a long run: its pieces stay in their own buffers
            self._buffers(room)
            self.room = 0
        if room != self.allowed:  # an access to a field takes longer than a short step
            self.record.room = self.allowed = room
        code = self.function(self.address)
        self.counts = counts = Counts._make(_COUNTED.unpack_from(self.bytes, _COUNTS_AT))
        count, events = counts.accepted, counts.events
        crossings = self.crossings(events) if events else []
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
