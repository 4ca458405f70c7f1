"""The compiled loop over lanes (`lanes`), with its memory: one thread for each block of memory."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...native.records import WIDTH, padded
from ..ending import BLAMED, End
from ..kernels.methods import BUDGET, FINE
from ..lanes import lanes_layout as at
from ..lanes import loops
from ..legs.driven import intervals
from ..legs.failure import to_blame
from ..ode import layout
from ..ode.dense_output import Array, Rates
from ..ode.run import POINTS, equip, memory, most_events, own_memory, sizes
from .job import Job
from .kernels import BatchProgram
from .results import Results
from .threads import share

BEFORE_SWITCHING = 20_000
"""Steps of a lane with a law that switches, after which it runs alone: a single run stops if it sticks on the law."""
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
        kernels = job.kernels
        self.wide = job.wide(method)
        self.program = program = program or job.program(method)
        self.limit = min(job.most_steps, BEFORE_SWITCHING) if program.switches else job.most_steps
        self.n = kernels.size
        m, watched = len(job.expressions), program.watched
        # values of limits at both ends of the steps of eight lanes
        self.limit_values = 16 * watched if program.wide_address("watched") else 0
        spans, self.columns, settings = intervals(kernels, job.lanes.values_of(0), job.begin, job.end)
        self.legs = np.array(spans, dtype=float).reshape(-1, 2)
        self.settings = np.array(settings, dtype=float).reshape(len(spans), -1)
        self.until_stiff = until_stiff
        negligible, rates = [-1] * job.limits, [0] * (watched - m)
        self.directions = [*(x.direction for x in job.specs), *negligible, *rates]
        self.terminal = [*(x.terminal for x in job.specs), *[0] * (watched - len(job.specs))]
        backwards = job.end < job.begin
        self.order = np.argsort(-job.times if backwards else job.times, kind="stable")
        self.times = job.times[self.order]
        self.function = loops.function(method, self.wide)

    def _batch(self) -> Any:
        """Return the description of the batch, with room for one thread."""
        job, program, outputs = self.job, self.program, self.job.outputs
        model, times = job.kernels.model, self.times.size if outputs.timed else 0
        batch = at.Batch.made(
            n_parameters=len(model.parameters), spare_size=max(2, self.n, len(outputs.reduced), program.dropped),
            sampled_size=max(1, times) * max(self.n, 1),
        )  # fmt: skip
        batch.prologue = program.compiled._prologue.address
        for name, kernel in (
            ("energy", "energy"), ("outputs", "outputs"), ("reductions", "reduced"), ("dropped", "dropped"),
            ("watched", "watched"),
        ):  # fmt: skip
            setattr(batch, name, program.address(kernel))
        batch.wide = program.wide_address("series" if self.method == "taylor" else "rates")
        batch.projection_wide, batch.rates_wide = map(program.wide_address, ("projection", "rates"))
        batch.watched_wide = program.wide_address("watched")
        batch.n_constants, batch.n_watched = program.compiled.hoisted, program.watched
        batch.n_events, batch.n_limits = len(job.expressions), 2 * job.limits
        batch.n_outputs, batch.n_times, batch.n_reduced = len(outputs.timed), times, len(outputs.reduced)
        batch.n_dropped, batch.n_legs, batch.n_settings = program.dropped, len(self.legs), len(self.columns)
        batch.room, batch.limit = _ROOM, self.limit
        batch.works, batch.stop_if_stiff = int(job.kernels.works), int(self.until_stiff)
        batch.budget = BUDGET if self.until_stiff else 0  # "auto" has one
        batch.limit_values = self._size_of_eight() if self.limit_values else 0
        batch.t0, batch.t1, batch.longest = job.begin, job.end, job.request.longest_step
        batch.order, batch.finest = layout.ORDERS[self.method], FINE
        batch.leg_starts, batch.leg_ends = (np.ascontiguousarray(column) for column in self.legs.T)
        batch.leg_steps = np.array(
            [_equal_steps(t1 - t0, job.request.step, job.request.longest_step) for t0, t1 in self.legs]
        )
        batch.settings, batch.columns = self.settings, np.array(self.columns, dtype=np.int64)
        batch.times, batch.tolerances = self.times, job.tolerances
        return batch

    def _rates(self) -> Rates:
        """Return the rates of a lane, with room for its constants. Those of the method have the same constants."""
        program, model = self.program, self.job.kernels.model
        projection = program.address("projection")
        return Rates(
            program.address("rates"), self.n, np.zeros(max(1, program.compiled.hoisted)), tuple(model.quaternions),
            projection=projection, projected=model.n_q + model.n_u if projection else 0,
            # parts of a step by series are not compared with the rates, as whole steps are
            method_kernels={"radau": (program.address("tangent"),), "taylor": (0, 0)}.get(self.method, ()),
        )  # fmt: skip

    def _watch(self, run: Any, c: Array, room: int) -> None:
        """Write the event functions into the memory of a run, with room for a log."""
        search, size = run.search, room + most_events(self.program.watched) + 1
        search.functions, search.c = self.program.address("watched"), c
        search.directions[:], search.terminal[:] = self.directions, self.terminal
        search.log_times, search.log_states = np.zeros(size), np.zeros((size, self.n))
        search.log_numbers, search.log_signs = np.zeros((2, size), dtype=np.int64)

    def memory(self) -> tuple[Any, ...]:
        """Return the memory of one thread: the batch, the lane, and more."""
        n, rates = self.n, self._rates()
        if self.wide:
            return self._memory_of_eight()
        lane = at.Lane.made(**sizes(n, self.program.watched))
        run, (sampler, own) = lane.run, memory(self.method, n)
        for each, of_method in ((run, own_memory(self.method, run)), (sampler, own)):
            equip(each, of_method, rates)
        self._watch(run, rates.constants, _ROOM)
        run.times, run.lengths, run.states = (
            np.zeros(_ROOM + 1),
            np.zeros(_ROOM + 1),
            np.zeros((_ROOM + 1, n)),
        )
        for name in ("times", "lengths", "states", "relative", "absolute"):
            setattr(sampler, name, getattr(run, name))
        return self._batch(), lane, sampler

    def _size_of_eight(self) -> int:
        """Return the size of the rows of eight lanes, without the values of limits."""
        numbers = (at.ROWS + 24) * 8 * self.n + at.WIDE_PLACES + self.program.room
        return padded(numbers)

    def _memory_of_eight(self) -> tuple[Any, ...]:
        """Return the batch, eight lanes, which share the rows of a step, and their memory side by side."""
        n, m, hoisted = self.n, self.program.watched, self.program.compiled.hoisted
        first = at.Lane.made(**sizes(n, m))
        rates = self._rates()
        equip(first.run, own_memory(self.method, first.run), rates)
        self._watch(first.run, rates.constants, 0)
        lanes = first.copies(8)
        constants, tables = np.zeros((8, max(1, hoisted))), np.zeros((8, POINTS, m + 1))
        signs = np.zeros((8, m), dtype=np.int64)
        for k in range(8):
            run = lanes[k].run
            run.c = run.search.c = constants[k]
            run.search.table, run.search.signs = tables[k], signs[k]
        lanes.keep = first, constants, tables, signs
        eight = at.EightLanes.made(constants=8 * max(1, hoisted), tolerances_size=16 * n)
        eight.w, eight.rows = 8 * n, _aligned(self._size_of_eight() + self.limit_values)
        return self._batch(), lanes, eight

    def chunk(self, lanes: NDArray[np.int64], memory: tuple[Any, ...]) -> None:
        """Run some lanes, given by number, and put their results in place."""
        job, results, n = self.job, self.results, len(lanes)
        rows = lanes - results.low
        initial = np.zeros((n, self.n))
        initial[:, : job.states.shape[1]] = job.states[lanes] if len(job.states) > 1 else job.states
        parameters = job.lanes.parameters(lanes)
        new = job.results(0, n)
        batch, *lanes_of_thread = memory
        batch.initial, batch.parameters = initial, parameters
        batch.values, batch.reduced = new.values.reshape(-1), new.reduced.reshape(-1, at.EXTREMES)
        batch.event_times, batch.event_counts = new.event_times.reshape(-1, 2), new.counts.reshape(-1)
        batch.outcomes, batch.ends = new.outcomes.reshape(-1), new.end_times
        first, last = lanes_of_thread
        self.function(0, n, batch, first, last)
        others = np.flatnonzero(new.outcomes[:, 0] != End.FINISHED)
        if others.size:
            others = others[np.isin(new.outcomes[others, 0], BLAMED)]
        for k in others:
            rates = job.kernels.rates(parameters[k])
            known = self.method != "taylor" or new.outcomes[k, 0] == End.NOT_FINITE
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
