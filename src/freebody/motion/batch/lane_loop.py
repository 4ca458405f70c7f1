"""The compiled loop over lanes (`lanes`), with its memory: one thread for each block of memory."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...native.records import WIDTH
from ..kernels.methods import BUDGET, FINE
from ..lanes import lanes_layout as at
from ..lanes import loops
from ..legs.driven import intervals
from ..legs.failure import to_blame
from ..ode import layout
from ..ode.dense_output import Array
from .job import Job
from .kernels import BatchProgram
from .results import Results
from .threads import share

BEFORE_SWITCHING = 20_000
"""Steps of a lane with a law that switches, after which it runs alone: a single run stops if it sticks on the law."""
_BLAMED = (layout.NOT_FINITE, layout.COLLAPSED, layout.DIVERGED)
"""How a lane ends if a coordinate or speed is to blame."""
LARGEST_BLOCK = 1 << 26
"""Bytes of results that are held before they are stored."""
_ROOM = 64  # steps between two looks at the output times


class LaneLoop:
    """The compiled loop over lanes, ready to run.

    ``limit``   number of steps after which a lane ends
    ``wide``    True if eight lanes run at once
    """

    def __init__(
        self, job: Job, method: str, results: Results, until_stiff: bool = False,
        program: BatchProgram | None = None,
    ) -> None:  # fmt: skip
        self.job, self.method, self.results = job, method, results
        kernels, model = job.kernels, job.kernels.model
        self.wide = job.wide(method)
        self.program = program = program or job.program(method)
        self.limit = min(job.most_steps, BEFORE_SWITCHING) if program.switches else job.most_steps
        self.n = kernels.size
        m, watched = len(job.expressions), program.watched
        self.addresses = np.array(
            [
                program.compiled._prologue.address, program.address("rates"), program.address("energy"),
                program.address("outputs"), program.address("reduced"), program.address("watched"),
                program.address("dropped"), program.wide_address("series" if method == "taylor" else "rates"),
                program.wide_address("projection"), program.wide_address("rates"),
                program.wide_address("watched"),
            ],
            dtype=np.int64,
        )  # fmt: skip
        # values of limits at both ends of the steps of eight lanes
        self.limit_values = 16 * watched if program.wide_address("watched") else 0
        spans, columns, settings = intervals(kernels, job.lanes.values_of(0), job.begin, job.end)
        lengths = [_equal_steps(t1 - t0, job.step, job.max_step) for t0, t1 in spans]
        self.legs = np.column_stack([spans, lengths, settings])
        self.columns = np.array([*columns, 0], dtype=np.int64)
        self.sizes = self._sizes(until_stiff, len(spans), len(columns))
        self.options = np.zeros(at.OPTIONS)
        self.options[at.T0], self.options[at.T1], self.options[at.LONGEST] = job.begin, job.end, job.max_step
        self.options[at.ORDER], self.options[at.FINEST] = layout.ORDERS[method], FINE
        # kernels of the method stand behind the quaternions; their constants are those of the rates. Parts of a step by
        # series are not compared with the rates, as whole steps are
        projection = program.address("projection")
        self.quaternions = np.array(
            [*model.quaternions, projection, model.n_q + model.n_u if projection else 0, 0,
             program.address("tangent"), 0],
            dtype=np.int64,
        )  # fmt: skip
        negligible, rates = [-1] * job.limits, [0] * (watched - m)
        self.directions = np.array([*(x.direction for x in job.specs), *negligible, *rates], dtype=np.int64)
        never = [0] * (watched - len(job.specs))
        self.terminal = np.array([*(x.terminal for x in job.specs), *never], dtype=np.int64)
        backwards = job.end < job.begin
        self.order = np.argsort(-job.times if backwards else job.times, kind="stable")
        self.times = job.times[self.order]
        self.function = loops.function(method, self.wide)

    def _sizes(self, until_stiff: bool, legs: int, settings: int) -> NDArray[np.int64]:
        """Return the counts that the compiled loop reads."""
        job, program, n = self.job, self.program, self.n
        kernels, model = job.kernels, job.kernels.model
        outputs = len(job.outputs.timed)
        sizes = np.zeros(at.SIZES, dtype=np.int64)
        sizes[at.N], sizes[at.WIDTH_OF_ROW] = n, layout.padded(n)
        sizes[at.N_WORK] = layout.rows(self.method, n) * layout.padded(n)
        sizes[at.N_QUATERNIONS], sizes[at.N_PARAMETERS] = len(model.quaternions), len(model.parameters)
        sizes[at.N_EVENTS], sizes[at.N_WATCHED] = len(job.expressions), program.watched
        sizes[at.N_OUTPUTS], sizes[at.N_TIMES] = outputs, job.times.size if outputs else 0
        sizes[at.N_REDUCED] = len(job.outputs.reduced)
        sizes[at.ROOM] = _ROOM
        sizes[at.LIMIT] = self.limit
        sizes[at.WORKS], sizes[at.STOP_STIFF_LANES] = kernels.works, until_stiff
        sizes[at.BUDGET] = BUDGET if until_stiff else 0  # "auto" has one
        sizes[at.N_DROPPED], sizes[at.N_LIMITS] = program.dropped, 2 * job.limits
        sizes[at.N_CONSTANTS] = program.compiled.hoisted
        sizes[at.N_LEGS], sizes[at.N_SETTINGS] = legs, settings
        if self.limit_values:
            sizes[at.LIMIT_VALUES] = self._size_of_eight()
        return sizes

    def memory(self) -> tuple[Any, ...]:
        """Return the work arrays of one thread, in the order of the loop's arguments."""
        if self.wide:
            return self._memory_of_eight()
        n, m = self.n, self.program.watched
        size = int(self.sizes[at.N_WORK])
        events = layout.most_events(m)
        largest = max(2, len(self.job.outputs.reduced), self.program.dropped)
        return (
            np.zeros(size), np.zeros(size), self._parameters(), np.zeros(max(1, self.program.compiled.hoisted)),
            np.zeros(2 * max(n, 1)),
            np.zeros(_ROOM + 1), np.zeros(_ROOM + 1), np.zeros((_ROOM + 1) * max(n, 1)),
            np.zeros(max(m, 1), dtype=np.int64), np.zeros((layout.PARTS + 3) * (m + 1)), np.zeros(max(m, 1)),
            np.zeros(max(1, events) * layout.EVENT_SIZE), np.zeros((_ROOM + events + 1) * layout.LOG_SIZE),
            np.zeros((_ROOM + events + 1) * max(n, 1)), np.zeros(max(1, self.times.size) * max(n, 1)),
            np.zeros(largest), np.zeros(layout.REALS), np.zeros(layout.INTEGERS, dtype=np.int64),
            np.zeros(layout.INTEGERS, dtype=np.int64),
        )  # fmt: skip

    def _size_of_eight(self) -> int:
        """Return the size of the work array of eight lanes, without the values of limits."""
        numbers = layout.rows(self.method, self.n) * 8 * self.n + at.WIDE_PLACES + self.program.room
        return layout.padded(numbers)

    def _parameters(self) -> Array:
        """Return room for the parameters of one lane."""
        return np.zeros(int(self.sizes[at.N_PARAMETERS]) + 1)

    def _memory_of_eight(self) -> tuple[Any, ...]:
        n, m, hoisted = self.n, self.program.watched, self.program.compiled.hoisted
        eight, events, size = 8 * n, layout.most_events(m), int(self.sizes[at.N_WORK])
        largest = max(2, n, len(self.job.outputs.reduced), self.program.dropped)
        rows = _aligned(self._size_of_eight() + self.limit_values)
        return (
            np.zeros(size), np.zeros(largest), self._parameters(), rows, _aligned(8 * max(1, hoisted)),
            np.zeros(8 * max(1, hoisted)), _aligned(2 * eight), np.zeros(n), np.zeros(at.WIDE_NUMBERS),
            np.zeros(at.WIDE_COUNTS, dtype=np.int64), np.zeros(8 * max(m, 1), dtype=np.int64),
            np.zeros(8 * (layout.PARTS + 3) * (m + 1)), np.zeros(max(m, 1)),
            np.zeros(max(1, events) * layout.EVENT_SIZE), np.zeros((events + 1) * layout.LOG_SIZE),
            np.zeros((events + 1) * n),
            np.zeros(layout.INTEGERS, dtype=np.int64),
        )  # fmt: skip

    def chunk(self, lanes: NDArray[np.int64], memory: tuple[Any, ...]) -> None:
        """Run some lanes, given by number, and put their results in place."""
        job, results, n = self.job, self.results, len(lanes)
        rows = lanes - results.low
        initial = np.zeros((n, max(self.n, 1)))
        if self.n:
            initial[:, : job.states.shape[1]] = job.states[lanes] if len(job.states) > 1 else job.states
        parameters = job.lanes.parameters(lanes)
        new = job.results(0, n)
        self.function(
            0, n, self.addresses, self.sizes, self.options, initial, parameters, self.legs, self.columns, self.times,
            self.quaternions, job.tolerances, job.tolerances, self.directions, self.terminal, *memory, new.values,
            new.reduced, new.event_times, new.counts, new.outcomes, new.end_times,
        )  # fmt: skip
        others = np.flatnonzero(new.outcomes[:, 0] != layout.FINISHED)
        if others.size:
            others = others[np.isin(new.outcomes[others, 0], _BLAMED)]
        for k in others:
            rates = job.kernels.rates(parameters[k])
            known = self.method != "taylor" or new.outcomes[k, 0] == layout.NOT_FINITE
            reported = int(new.outcomes[k, 3]) if known else None
            new.outcomes[k, 3] = to_blame(
                job.kernels, reported, rates, float(new.end_times[k]), initial[k, : self.n]
            )
        if new.values.size:
            results.values[rows[:, None], self.order] = new.values
        for name in ("reduced", "event_times", "counts", "end_times", "outcomes"):
            getattr(results, name)[rows] = getattr(new, name)

    def run(self, lanes: NDArray[np.int64], between: Callable[[float], None]) -> None:
        """Run lanes, given by number."""
        threads = max(1, min(self.job.threads, len(lanes)))
        memories = [self.memory() for _ in range(threads)]
        largest = max(1, LARGEST_BLOCK // (8 * self.job.bytes_per_lane))
        share(
            lanes, self.chunk, memories, 2 * WIDTH if self.wide else 1, largest,
            lambda done: between(float(self.results.low + done)),
        )  # fmt: skip


def _equal_steps(span: float, step: float | None, max_step: float) -> float:
    """Return the length of the steps of an interval, so that a whole number fits; 0 without a given length."""
    if step is None or span == 0:
        return 0.0
    return abs(span) / math.ceil(abs(span) / min(step, max_step, abs(span)) * (1 - 1e-12))


def _aligned(count: int) -> Array:
    """Return zeros that begin at a multiple of 64 bytes, as whole vector registers are read."""
    room = np.zeros(count + 8)
    shift = -(room.ctypes.data // 8) % 8
    return room[shift : shift + count]
