"""``method="timestepping"``: many contacts with friction, in steps of fixed length.

The loop is in `moreau`; this file prepares its kernels and memory and turns its results into a trajectory. The method
is of first order in the step, and an impact acts within the step in which it happens. The laws are exact: in every step
each contact satisfies Signorini's and Coulomb's conditions to the residual that the trajectory states.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np

from ...errors import SimulationError
from ..ending import End
from ..families.family_record import ENTRY
from ..families.memory import label_of
from ..kernels.contact_quantities import asked_by
from ..legs.blow import Blow, blows_of, call_of, scheduled
from ..legs.driven import Drives
from ..moreau.stepping_record import CONTACTS, FULL, NONE
from ..ode.dense_output import Array, Crossing, observe
from ..phase.candidates.candidates import layout_of
from ..request import Problem, Request, problem_of
from ..start.arguments import STORED, check_forwards, most_steps
from ..start.fitting import refuse_misfits
from ..start.initial import number
from ..start.loaded_joints import check_blows
from ..start.overlap import refuse_overlap, sides_of
from ..trajectory.event import expressions_of
from ..trajectory.progress import SHORT, Progress
from ..trajectory.trajectory import Trajectory
from .blows import calls, strike
from .crossings import Crossings
from .failure import MOST_SWEEPS, accept, check_laws, failure
from .grid import Grid, grid_of
from .intervals import Values
from .memory import carry, functions, kernels_and_shape, memory_of, set_parameters
from .pair_motion import PairLog, width_of
from .pieces import course_of, touched, with_contacts

RESIDUAL = 1e-12
"""Speed by which a contact may violate its laws, relative to the greatest speed in the problem of a step."""
SWEEPS = 100
"""Sweeps of one problem before Newton's method takes over (`islands`); ten times as many if that fails."""
PAIRS = 64
"""Least room for closed pairs of families; it doubles where it does not suffice."""
NEAR = 1e-9
"""Depth of a contact at the start that counts as none [m]."""
FEW = 16
"""Steps of a piece before a thread is worth it."""
BLOCK = 100
"""Steps between two looks for terminal events and those that call blows, fewer with more than ten contacts. A fixed
number: what a step begins its search with depends on it, to the last bit, where a run goes back to a blow."""


def stepped_motion(request: Request) -> Trajectory:
    """Return the motion of a machine with contacts in equal steps.

    Raises
    ------
    SimulationError
        Laws of contacts that the steps do not know, or a step without a solution.
    """
    problem = problem_of(request)
    with problem.progress() as between:
        return _run_of(problem).motion(between)


def _run_of(problem: Problem) -> _Run:
    """Return a run, ready for its first step."""
    request, kernels, values = problem.request, problem.kernels, problem.numbers
    model, step, begin, end = kernels.model, request.step, problem.begin, problem.end
    if step is None:
        raise SimulationError(
            "Expected the length of a step for method='timestepping', such as step=1e-3 [s]."
        )
    h = number(model, values, step, "step")
    if not h > 0:
        raise SimulationError(f"Expected a step greater than 0 s, got step={h:g}.")
    check_forwards(begin, end, "a machine with contacts", "friction and impacts")
    check_laws(kernels, values)
    blows = blows_of(request.impulses)
    most = most_steps(request.max_steps, STORED + model.n_q + model.n_u + 4 * len(model.contacts))
    drives = Drives(kernels, values, begin, end, most) if model.switched else None
    grid = grid_of(begin, end, h, drives.stops() if drives else (), most)
    return _Run(problem, grid, Values(kernels, values, drives, grid.first), blows)


class _Run:
    """One run: the compiled loop, its memory and the steps done so far."""

    def __init__(self, problem: Problem, grid: Grid, values: Values, blows: Sequence[Blow]) -> None:
        kernels, specs, count = problem.kernels, problem.specs, grid.count
        self.problem, self.kernels, self.values, self.grid = problem, kernels, values, grid
        self.count, self.model = count, kernels.model
        model = kernels.model
        self.program, self.shape = kernels_and_shape(kernels)
        self.first, self.tangents, self.rows = layout_of(model)
        self.pairs = (
            PAIRS + 6 * sum(len(family.members) for family in model.families) if model.families else 0
        )
        self._make_room()
        self.march = functions()["march"]
        check_blows(kernels.model, blows, "moves in time steps")
        timed, self.called = scheduled(kernels, problem.numbers, blows, problem.begin, problem.end)
        self.timed: dict[int, list[Blow]] = {}
        for time, one in timed:
            self.timed.setdefault(grid.step_at(time), []).append(one)
        self.left = {id(one): np.inf if one.times is None else one.times for one in self.called}
        calls = [call_of(one) for one in self.called]
        self.asked = len(specs)
        self.specs = [*specs, *calls]
        self.expressions = (*problem.expressions, *expressions_of(model, calls))
        self.watch = Crossings(kernels, self.specs, self.expressions)
        n, E = model.n_q + model.n_u, len(self.first)
        self.states = np.empty((count + 1, n))
        # pages of memory are used as the steps are written
        self.impulses, self.works, self.moved = (
            np.empty((count, width)) for width in (self.rows + len(self.shape.held), 2, n)
        )
        self.modes, self.log = np.empty((count, E), dtype=np.int64), PairLog.made(count, width_of(model))
        self.blows: dict[int, list[tuple[str, Any]]] = {}
        self.done = self.reached = 0  # steps that are kept, and those up to where the loop is
        self.slow = False  # the last piece took long
        if values.drives is not None:
            values.drives.touched = partial(touched, self, asked_by(values.drives.sensed))

    def _make_room(self) -> None:
        """Make the memory, with room for ``pairs`` closed pairs of families."""
        self.memory, self.islands, self.owned = memory_of(
            self.kernels, self.values.numbers, self.program, self.shape, self.tangents, self.pairs
        )
        self._set_parameters()
        self.memory.past[:] = self.grid.longest
        self.memory.log_room = 4 * self.pairs
        width = width_of(self.model)
        self.memory.resisted = int(width > ENTRY)
        self.memory.log = np.empty((max(self.memory.log_room, 1), width))

    def _set_parameters(self) -> None:
        """Give the memory the present values of the parameters."""
        set_parameters(self.memory, self.kernels, self.program, self.values.parameters)

    def motion(self, between: Progress) -> Trajectory:
        y = np.array(self.problem.state[: self.states.shape[1]], dtype=float)
        self.states[0] = y
        between.halt.watch(self.memory.problem, self.islands.part)
        self._check_start(y)
        status, stop = End.FINISHED, None
        try:
            while self.done < self.count and stop is None:
                failed: SimulationError | None = None
                try:
                    self._advance(between)
                except SimulationError as error:
                    failed = error
                there = self.reached
                stop = self._look()
                if failed is not None and stop is None and self.reached == there:
                    raise failed
        except KeyboardInterrupt:
            status, stop = End.INTERRUPTED, self._look()
        except SimulationError as error:
            got = self._trajectory(End.BROKEN_OFF, None)
            made = " ".join(str(one) for one in got.warnings if one.event == "energy")
            error = SimulationError(f"{made} Then: {error}") if made else error
            error.trajectory = got  # type: ignore[attr-defined]
            raise error from None
        return self._trajectory(End.TERMINAL if stop else status, stop)

    def _check_start(self, y: Array) -> None:
        """Refuse contacts and members of families that begin inside each other, and round shapes that do not fit."""
        refuse_misfits(self.model, self.values.numbers)
        self._begin(y)
        pairs = self._gaps_of_pairs()
        cure = ", or hold two bodies apart: apart= of s.contacts" if pairs else ""
        own = [
            gap
            for gap, c in zip(self._gaps_of_contacts(y), self.model.contacts, strict=True)
            if not c.presser
        ]
        refuse_overlap(self.model.name, [*pairs, *own], NEAR, cure, sides_of(self.model.contacts))

    def _gaps_of_contacts(self, y: Array) -> list[tuple[str, float]]:
        program, E = self.program, len(self.first)
        if E == 0:
            return []
        found = observe(
            program.address("closing"),
            program.outputs("closing"),
            np.array([self.problem.begin]),
            y[None],
            self.memory.machine.c,
        )[0, : E + len(self.shape.reach_of)]
        gaps = found[:E].copy()
        gaps[self.shape.reach_of[found[E:] < 0]] = np.inf
        return [(contact.name, gap) for contact, gap in zip(self.model.contacts, gaps, strict=False)]

    def _begin(self, y: Array) -> None:
        """Let what touches at a state begin closed there; make room for all pairs of families that do."""
        while True:
            self.memory.z[: len(y)] = y
            functions()["begin"](self.memory, self.grid.times[self.reached], NEAR)
            if self.memory.families.pairs.count <= self.pairs:
                return
            self.pairs *= 2
            self._make_room()

    def _gaps_of_pairs(self) -> list[tuple[str, float]]:
        pairs = self.memory.families.pairs
        return [
            (label_of(self.model, int(pairs.first[k]), int(pairs.second[k])), float(pairs.touch[k, 0]))
            for k in np.flatnonzero(pairs.touch[: pairs.count, 0] < -NEAR)
        ]

    def _advance(self, between: Progress) -> None:
        """Do steps up to the next look for events and blows, with a look at the keyboard after each piece of them."""
        if self.values.change(self.done, self.grid.times[self.done], self.states[self.done].copy()):
            self._set_parameters()
        now = [*self.timed.pop(self.done, []), *self.timed.pop(-1, [])]
        size = int(min(*self.timed, self.values.next_change(), self.count)) - self.done
        if now:
            strike(self, now)
            size = 1
        elif self._watched:
            contacts = len(self.first) + self.memory.families.members.count
            size = min(size, max(1, BLOCK // (1 + contacts // 10)))
        last = min(self.done + size, self.count)
        self.struck = bool(now)
        while self.reached < last:
            few, clock = min(FEW, last - self.reached), perf_counter()
            aside = between.is_long and (few < last - self.reached or self.slow)
            self._steps(last - self.reached if aside else few, aside, between)
            self.slow = perf_counter() - clock > SHORT
            between(self._now())

    @property
    def _watched(self) -> bool:
        """True if events end the run, or call blows."""
        return bool(self.called) or any(spec.terminal for spec in self.specs)

    def _look(self) -> Crossing | None:
        """Keep the steps up to where the loop is, or to a blow that an event calls; return a terminal event in them."""
        if self._watched and self.reached > self.done:
            first = max(self.done - 2, 0)  # with what was before the first of them
            moments, rows = (x[first : self.reached + 1] for x in (self.grid.times, self.states))
            if self.watch.asked:
                rows = with_contacts(course_of(self, first, self.reached), self.watch.asked)
            intervals = self.values.intervals()
            for c in self.watch.found(intervals, moments, rows, first, self.done):
                if c.time == self.grid.times[0]:  # recorded only
                    continue
                if c.number < self.asked:
                    if self.specs[c.number].terminal:
                        self.done = self.reached
                        return c
                    continue
                one = self.called[c.number - self.asked]
                if not calls(self, one, c) or not self.left[id(one)] > 0:
                    continue
                self.left[id(one)] -= 1  # return to the beginning of the step and apply the blow there
                step = int(np.searchsorted(moments, c.time, side="left")) - 1 + first
                self.reached = max(step, self.done)
                self.timed.setdefault(-1, []).append(one)
                break
        self.done = self.reached
        return None

    def _now(self) -> float:
        """Return the time up to which the loop is."""
        return float(self.grid.times[self.reached + self.memory.done])

    def _steps(self, size: int, aside: bool, between: Progress) -> None:
        """Do some steps, with more sweeps or more room where one of them needs it."""
        y, run = self.states[self.reached].copy(), self.memory
        last, sweeps = self.reached + size, SWEEPS
        while self.reached < last:
            end = last if sweeps == SWEEPS else self.reached + 1
            done = self._marched(y, end, sweeps, aside, between)
            if done:
                sweeps = SWEEPS
            if self.reached == last or (done and run.failure == NONE):
                continue
            if run.failure == FULL:
                self.pairs *= 2
                self._make_room()
                between.halt.watch(self.memory.problem, self.islands.part)
                carry(run, self.memory)
                run = self.memory
                continue
            if run.failure == CONTACTS and sweeps <= MOST_SWEEPS:
                sweeps *= 10
                continue
            raise SimulationError(
                failure(run, self.model, self.values.numbers, self.grid.times[self.reached], y)
            )

    def _marched(self, y: Array, last: int, most_sweeps: int, aside: bool, between: Progress) -> int:
        """Run the loop to the step ``last``, or until the log is full or a step fails; return the number of steps."""
        run, some = self.memory, slice(self.reached, last)
        run.times, run.h, run.tolerance = self.grid.times[some], self.grid.lengths[self.reached], RESIDUAL
        accept(run)
        run.most_sweeps, run.steps, run.y = most_sweeps, last - self.reached, y
        run.states, run.impulses, run.works = self.states[1:][some], self.impulses[some], self.works[some]
        run.moved, run.modes = self.moved[some], self.modes[some]
        run.log_end = np.zeros(max(run.steps, 1), dtype=np.int64)
        run.done = 0
        try:
            if aside or most_sweeps > SWEEPS:
                between.result(self._now, self.march, run, self.islands)
            else:
                self.march(run, self.islands)
        finally:  # at Ctrl-C, too
            done = run.done
            self.log.append(self.reached, run.log, run.log_end[:done])
            self.reached, run.done = self.reached + done, 0
        if run.problem.stop:
            between(self._now())
        return done

    def _trajectory(self, status: End, stop: Crossing | None) -> Trajectory:
        last = self.done if stop is None else int(np.searchsorted(self.grid.times, stop.time, side="left"))
        course = course_of(self, 0, last, stop)
        path = course.path
        watch = Crossings(self.kernels, self.specs[: self.asked], self.expressions[: self.asked])
        rows = with_contacts(course, watch.asked)
        crossed = watch.found(course.intervals, path.times, rows)
        if stop is not None:  # the last state is the event itself
            earlier = (
                c
                for c in crossed
                if c.time < path.times[-2] or (c.time < stop.time and c.number != stop.number)
            )
            crossed = (*earlier, stop)
        path = replace(path, crossings=crossed, status=status)
        return Trajectory(*self.problem.outcome(path), course=replace(course, path=path))
