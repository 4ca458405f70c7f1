"""The compiled loop over lanes (`lanes`), with its memory: one thread for each block of memory."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...native.records import WIDTH, padded, zeros
from ..ending import BLAMED, End
from ..kernels.methods import BUDGET, FINE
from ..lanes import batch_memory as at
from ..lanes import loops
from ..legs.driven import intervals
from ..legs.failure import to_blame
from ..ode import layout
from ..ode.dense_output import Array, Rates
from ..ode.memory import equip, make_log, own_memory, sizes, watch
from ..ode.run import COEFFICIENTS, ROWS, Series
from .job import Job
from .kernels import BatchProgram
from .results import LANE_BY_LANE, Results
from .threads import share

LARGEST_BLOCK = 1 << 26
"""Bytes of results that are held before they are stored."""


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
        self.limit = job.most_steps
        self.n = kernels.size
        m, watched = len(job.expressions), program.watched
        spans, self.columns, settings = intervals(kernels, job.lanes.values_of(0), job.begin, job.end)
        self.legs = np.array(spans, dtype=float).reshape(-1, 2)
        self.settings = np.array(settings, dtype=float).reshape(len(spans), -1)
        self.until_stiff = until_stiff
        negligible, rates = [-1] * job.limits, [0] * (watched - m)
        self.directions = [*(x.direction for x in job.specs), *negligible, *rates]
        others = watched - len(job.specs) - program.laws
        self.terminal = [*(x.terminal for x in job.specs), *[0] * others, *[1] * program.laws]
        backwards = job.end < job.begin
        self.order = np.argsort(-job.times if backwards else job.times, kind="stable")
        self.times = job.times[self.order]
        self.function = loops.function(method, WIDTH if self.wide else 1)

    def _batch(self) -> Any:
        """Return the description of the batch, with room for one thread."""
        job, program, outputs = self.job, self.program, self.job.outputs
        model, times = job.kernels.model, self.times.size if outputs.timed else 0
        batch = at.Batch.made(
            n_parameters=len(model.parameters) + program.laws,
            spare_size=max(2, self.n, len(outputs.reduced), program.dropped),
        )  # fmt: skip
        batch.prologue = program.compiled._prologue.address
        for name, kernel in (
            ("energy", "energy"), ("outputs", "outputs"), ("reductions", "reduced"), ("dropped", "dropped"),
            ("watched", "watched"),
        ):  # fmt: skip
            setattr(batch, name, program.address(kernel))
        batch.n_constants, batch.n_watched = program.compiled.hoisted, program.watched
        batch.n_events, batch.n_limits = len(job.expressions), 2 * job.limits
        batch.n_outputs, batch.n_times, batch.n_reduced = len(outputs.timed), times, len(outputs.reduced)
        batch.n_dropped, batch.n_legs, batch.n_settings = program.dropped, len(self.legs), len(self.columns)
        batch.limit = self.limit
        batch.works, batch.stop_if_stiff = int(job.kernels.works), int(self.until_stiff)
        batch.budget = BUDGET if self.until_stiff else 0  # "auto" has one
        batch.near_limits = int(program.wide_address("watched") != 0)
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

    def _watch(self, run: Any, c: Array) -> None:
        """Write the event functions into the memory of a run, with room for the log of a step."""
        watch(run.search, self.program.address("watched"), c, self.directions, self.terminal)
        make_log(run.search, 0, self.n)

    def memory(self) -> tuple[Any, ...]:
        """Return the memory of one thread: the batch, its lanes side by side, and memory for single runs."""
        n, m, rates, lanes = self.n, self.program.watched, self._rates(), WIDTH if self.wide else 1
        one = at.Lane.made(**sizes(n, m))
        equip(one.run, own_memory(self.method, one.run), rates)
        if not self.wide:  # the lane is the memory of one run, and outputs are computed in further memory
            lane = at.Lane.made(**sizes(n, m))
            equip(lane.run, own_memory(self.method, lane.run), rates)
            self._watch(lane.run, rates.constants)
            one.run.absolute, one.run.relative = lane.run.absolute, lane.run.relative
            return self._batch(), lane, one
        self._watch(one.run, rates.constants)
        own = one.copies(lanes)
        constants, tables = np.zeros((lanes, rates.constants.size)), np.zeros((lanes, ROWS, padded(m + 1)))
        signs = np.zeros((lanes, m), dtype=np.int64)
        for k in range(
            lanes
        ):  # what is carried from step to step is that of a lane; the rows of a step are shared
            run = own[k].run
            run.c = run.search.c = constants[k]
            run.search.table, run.search.signs = tables[k], signs[k]
        own.keep = one, constants, tables, signs
        return self._batch(), self._side_by_side(lanes), own

    def _side_by_side(self, lanes: int) -> Any:
        """Return the memory of lanes side by side."""
        n, program, model = self.n, self.program, self.job.kernels.model
        lane = at.Lane.of(lanes).made(**{**sizes(n, program.watched), "width": n})
        run, c = lane.run, zeros(lanes * max(1, program.compiled.hoisted)).reshape(-1, lanes)
        run.rates, run.projection = map(program.wide_address, ("rates", "projection"))
        run.projected = model.n_q + model.n_u if run.projection else 0
        run.c, run.search.c, run.search.functions = c, c, program.wide_address("watched")
        run.quaternions, run.n_quaternions = (
            np.array(model.quaternions, dtype=np.int64),
            len(model.quaternions),
        )
        if self.method == "taylor":
            own = Series.of(lanes).made(n=n, width=n)
            # behind its coefficients, a series leaves those of what it is computed from
            row = lanes * max(n, 1)
            own.terms = zeros(row * max(COEFFICIENTS, -(-program.room // row))).reshape(-1, max(n, 1), lanes)
            own.coefficients, own.bends, own.c = program.wide_address("series"), int(run.rates != 0), c
            run.own = own.memory.reshape(-1, lanes)
            lane.keep = own
        return lane

    def chunk(self, lanes: NDArray[np.int64], memory: tuple[Any, ...]) -> None:
        """Run some lanes, given by number, and put their results in place."""
        job, results, n = self.job, self.results, len(lanes)
        rows = lanes - results.low
        initial = np.zeros((n, self.n))
        initial[:, : job.states.shape[1]] = job.states[lanes] if len(job.states) > 1 else job.states
        parameters = job.lanes.parameters(lanes)
        sides = self._sides(parameters, initial)
        new = job.results(0, n)
        batch, *lanes_of_thread = memory
        batch.initial, batch.parameters = initial, np.concatenate([parameters, sides], axis=1)
        batch.values, extremes = new.values.reshape(-1), np.full((4, n, len(job.outputs.reduced)), np.nan)
        batch.greatest, batch.smallest, batch.first, batch.last = extremes
        batch.event_times, batch.event_counts = new.event_times.reshape(-1, 2), new.counts.reshape(-1)
        batch.status, batch.steps, batch.rejected, batch.blame = (
            new.status,
            new.steps,
            new.rejected,
            new.blame,
        )
        batch.ends = new.end_times
        first, last = lanes_of_thread
        self.function(0, n, batch, first, last)
        if self.program.laws:
            new.status[self._switched(new, sides)] = End.RELEASED
        others = np.flatnonzero(new.status != End.FINISHED)
        # behind the events and all limits of one-sided forces come the rates of quantities with extremes
        rates_begin = len(job.expressions)
        new.blame[(new.status == End.UNRESOLVED) & (new.blame >= rates_begin)] -= rates_begin - len(job.specs)
        if others.size:
            others = others[np.isin(new.status[others], BLAMED)]
        for k in others:
            rates = job.kernels.rates(parameters[k])
            known = self.method != "taylor" or new.status[k] == End.NOT_FINITE
            reported = int(new.blame[k]) if known else None
            new.blame[k] = to_blame(
                job.kernels, reported, rates, float(new.end_times[k]), initial[k, : self.n]
            )
        if new.values.size:
            results.values[rows[:, None], self.order] = new.values
        results.reduced[rows] = np.moveaxis(extremes, 0, -1)
        for name in LANE_BY_LANE:
            getattr(results, name)[rows] = getattr(new, name)

    def _sides(self, parameters: Array, initial: Array) -> Array:
        """Return the sides of the laws of each lane at its start."""
        sides, count = self.program.sides, self.program.laws
        result = np.zeros((len(parameters), count))
        if sides is not None:
            for k, numbers in enumerate(parameters):
                result[k] = sides.start(self.job.begin, initial[k], numbers)
        return result

    def _switched(self, new: Results, sides: Array) -> NDArray[np.bool_]:
        """Return the lanes in which a law switches, which run alone."""
        terminal = [k for k, spec in enumerate(self.job.specs) if spec.terminal]
        own = (new.event_times[:, terminal, 1] == new.end_times[:, None]).any(axis=1)
        return (sides == 0).any(axis=1) | (new.status == End.TERMINAL) & ~own

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
