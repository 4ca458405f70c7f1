"""``method="timestepping"``: many contacts with friction, in steps of fixed length.

The loop is in `moreau`; this file prepares its kernels and memory and turns its results into a trajectory. The method
is of first order in the step, and an impact acts within the step in which it happens. The laws are exact: in every step
each contact satisfies Signorini's and Coulomb's conditions to the residual that the trajectory states.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...dynamics.conditions.constraints import rows as conditions
from ...dynamics.impulse import blows_on, generalized_impulse
from ...dynamics.state import State, float_state
from ...errors import ModelError, SimulationError
from ...native import loop
from ..contact.motion import check_coefficients
from ..ending import End
from ..families.family_record import ENTRY
from ..families.memory import label_of
from ..kernels.kernels import Kernels
from ..legs.blow import Blow, blows_of, call_of, scheduled
from ..legs.impulse import resolved_blow
from ..ode.dense_output import Array, Crossing, Rates, observe
from ..phase.candidates import layout_of, stretch_numbers
from ..request import Problem, Request, problem_of
from ..start.arguments import STORED, check_count, check_forwards, most_steps
from ..start.initial import number
from ..start.overlap import refuse_overlap
from ..start.signals import refuse_switched
from ..trajectory.event import expressions_of
from ..trajectory.progress import Progress
from ..trajectory.trajectory import Trajectory
from .course import IMPULSES, Impulses, InSteps, Stepping, Steps
from .crossings import crossings
from .failure import MOST_SWEEPS, accepted, failure
from .memory import memory_of
from .stepped_kernels import stepping
from .stepping_record import CONTACTS, FULL, NONE

RESIDUAL = 1e-12
"""Speed by which a contact may violate its laws, relative to the greatest speed in the problem of a step."""
SWEEPS = 100
"""Sweeps of one problem before Newton's method takes over (`islands`); ten times as many if that fails."""
PAIRS = 64
"""Least room for closed pairs of families; it doubles where it does not suffice."""
NEAR = 1e-9
"""Depth of a contact at the start that counts as none [m]."""
BLOCK = 1000
"""Steps between two checks of events, progress and the keyboard; fewer in proportion with more than ten contacts."""


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
    refuse_switched(model, 'method="timestepping"')
    if not (model.contacts or model.families):
        raise SimulationError(
            "method='timestepping' is for machines with contacts, and this one has none. Take method='auto'."
        )
    if step is None:
        raise SimulationError(
            "Expected the length of a step for method='timestepping', such as step=1e-3 [s]."
        )
    h = number(model, values, step, "step")
    if not h > 0:
        raise SimulationError(f"Expected a step greater than 0 s, got step={h:g}.")
    check_forwards(begin, end, "a machine with contacts", "friction and impacts")
    _check_laws(kernels, values)
    blows = blows_of(request.impulses)
    for one in blows:
        if one.options["normal"] is not None or one.options["restitution"] is not None:
            raise SimulationError(
                f"The blow '{one.name}' meets a surface (normal=, restitution=), which method='timestepping' solves "
                "only with the other contacts: describe the surface by s.contact(..., restitution=e), or give impulse=."
            )
    most = most_steps(request.max_steps, STORED + model.n_q + model.n_u + 4 * len(model.contacts))
    check_count((end - begin) / h, most, f"step = {h:g} s", "Take a longer step=")
    count = max(round((end - begin) / h), 1 if end > begin else 0)
    if count and abs(count * h - (end - begin)) > 1e-9 * max(h, abs(end)):
        count = math.ceil((end - begin) / h)
    h = (end - begin) / count if count else h
    return _Run(problem, h, count, blows)


def _check_laws(kernels: Kernels, values: Mapping[str, float]) -> None:
    model = kernels.model
    check_coefficients(model, values)
    for c in model.contacts:
        moving = model.names.depends(c.friction, "coordinate", "speed", "time") + ["slip"] * c.slows
        if moving:
            raise SimulationError(
                f"method='timestepping' knows constant friction, but that of contact '{c.name}' depends on "
                f"{', '.join(moving)}. Take method='auto'."
            )
        if number(model, values, c.friction, "mu") != number(model, values, c.static_friction, "mu_s"):
            raise SimulationError(
                f"method='timestepping' knows one coefficient of friction, but contact '{c.name}' also has a static "
                "one. Leave static_friction out, or take method='auto'."
            )
        if c.impact != "newton" and number(model, values, c.restitution, "e") != 0:
            raise SimulationError(
                f"method='timestepping' knows Newton's restitution, but contact '{c.name}' has impact='{c.impact}'. "
                "Leave impact= out, or take method='auto'."
            )


class _Run:
    """One run: the compiled loop, its memory and the steps done so far."""

    def __init__(self, problem: Problem, h: float, count: int, blows: Sequence[Blow]) -> None:
        kernels, values = problem.kernels, problem.numbers
        begin, end, specs = problem.begin, problem.end, problem.specs
        self.problem, self.kernels, self.values, self.begin, self.end = problem, kernels, values, begin, end
        self.h, self.count, self.model = h, count, kernels.model
        model = kernels.model
        self.parameters = kernels.parameters(values)
        self.program, self.shape = stepping(kernels)
        self.constants = self.program.constants(self.parameters)
        self.first, self.tangents, self.rows = layout_of(model)
        self.pairs = (
            PAIRS + 6 * sum(len(family.members) for family in model.families) if model.families else 0
        )
        self._make_room()
        self.march = loop.code("motion.timestepping.moreau", "march")
        timed, self.called = scheduled(kernels, values, blows, begin, end)
        self.timed: dict[int, list[Blow]] = {}
        for time, one in timed:
            k = min(math.floor((time - begin) / h * (1 + 1e-12)), max(count - 1, 0))
            self.timed.setdefault(k, []).append(one)
        self.left = {id(one): np.inf if one.times is None else one.times for one in self.called}
        calls = [call_of(one) for one in self.called]
        self.asked = len(specs)
        self.specs = [*specs, *calls]
        self.expressions = [*problem.expressions, *expressions_of(model, calls)]
        # states, impulses, works, changes of q by corrections, modes, logs of pairs
        self.parts: list[list[Array]] = [[], [], [], [], [], []]
        self.blows: dict[int, list[tuple[str, Any]]] = {}
        self.done = 0

    def _make_room(self) -> None:
        """Make the memory, with room for ``pairs`` closed pairs of families."""
        self.memory, self.islands, self.owned = memory_of(
            self.kernels, self.values, self.program, self.shape, self.tangents, self.pairs
        )
        self.memory.h, self.memory.machine.c = self.h, self.constants
        self.memory.log_room = 4 * self.pairs
        self.memory.log = np.empty((max(self.memory.log_room, 1), ENTRY))

    def motion(self, between: Progress) -> Trajectory:
        n = self.model.n_q + self.model.n_u
        y = np.array(self.problem.state[:n], dtype=float)
        self.start = y.copy()
        self._check_start(y)
        status, stop = End.FINISHED, None
        try:
            while self.done < self.count and stop is None:
                y, stop = self._advanced(y)
                between(self.begin + self.done * self.h)
        except KeyboardInterrupt:
            status = End.INTERRUPTED
        except SimulationError as error:
            got = self._trajectory(End.BROKEN_OFF, None)
            made = " ".join(str(one) for one in got.warnings if one.event == "energy")
            error = SimulationError(f"{made} Then: {error}") if made else error
            error.trajectory = got  # type: ignore[attr-defined]
            raise error from None
        return self._trajectory(End.TERMINAL if stop else status, stop)

    def _check_start(self, y: Array) -> None:
        """Refuse contacts and members of families that begin inside each other."""
        pairs = self._gaps_of_pairs(y) if self.pairs else []
        cure = ", or hold two bodies apart: apart= of s.contacts" if pairs else ""
        gaps, contacts = self._gaps_of_contacts(y), self.memory.contacts
        own = [gap for gap, c in zip(gaps, self.model.contacts, strict=True) if not c.presser]
        refuse_overlap(self.model.name, [*pairs, *own], NEAR, cure)
        contacts.kept[:] = [
            gap <= NEAR and pull > 0 for (_, gap), pull in zip(gaps, contacts.adhesion, strict=True)
        ]

    def _gaps_of_contacts(self, y: Array) -> list[tuple[str, float]]:
        program, E = self.program, len(self.first)
        if E == 0:
            return []
        found = observe(
            program.address("closing"),
            program.outputs("closing"),
            np.array([self.begin]),
            y[None],
            self.constants,
        )[0, : E + len(self.shape.reach_of)]
        gaps = found[:E].copy()
        gaps[self.shape.reach_of[found[E:] < 0]] = np.inf
        return [(contact.name, gap) for contact, gap in zip(self.model.contacts, gaps, strict=False)]

    def _gaps_of_pairs(self, y: Array) -> list[tuple[str, float]]:
        while True:
            self.memory.z[: len(y)] = y
            loop.code("motion.timestepping.pairs", "deepest")(self.memory, self.begin - self.h, 0.0)
            pairs = self.memory.families.pairs
            if pairs.count <= pairs.most:
                break
            self.pairs *= 2
            self._make_room()
        return [
            (label_of(self.model, int(pairs.first[k]), int(pairs.second[k])), float(pairs.touch[k, 0]))
            for k in np.flatnonzero(pairs.touch[: pairs.count, 0] < -NEAR)
        ]

    def _advanced(self, y: Array) -> tuple[Array, Crossing | None]:
        """Return the state some steps later, and the terminal event if one occurs before it."""
        now = [*self.timed.pop(self.done, []), *self.timed.pop(-1, [])]
        watched = bool(self.called) or any(spec.terminal for spec in self.specs)
        contacts = len(self.first) + self.memory.families.members.count
        block = max(1, BLOCK // (10 if watched else 1) // (1 + contacts // 10))
        size = 1 if now else min(block, min(self.timed, default=self.count) - self.done)
        size = min(size, self.count - self.done)
        before = y.copy()
        if now:
            self._strike(now, y)
        found = self._steps(y, size)
        if not watched:
            self._keep(found)
            return y, None
        states = np.concatenate([before[None], found[0]])
        moments = self.begin + self.h * np.arange(self.done, self.done + len(states), dtype=np.float64)
        for c in crossings(self.kernels, self.values, self.specs, self.expressions, moments, states):
            if c.number < self.asked:
                if self.specs[c.number].terminal:
                    self._keep(found)
                    return y, c
                continue
            one = self.called[c.number - self.asked]
            if now or not self.left[id(one)] > 0:
                continue
            self.left[id(one)] -= 1  # return to the beginning of the step and apply the blow there
            k = int(np.searchsorted(moments, c.time, side="left")) - 1
            self._keep([part[:k] for part in found])
            self.timed.setdefault(-1, []).append(one)
            return states[k].copy(), None
        self._keep(found)
        return y, None

    def _keep(self, found: Sequence[Any]) -> None:
        for kept, part in zip(self.parts, found, strict=True):
            kept.append(part)
        self.done += len(found[0])

    def _strike(self, now: Sequence[Blow], y: Array) -> None:
        """Set the generalized impulse of blows, computed from the positions in the middle of the step."""
        n_q, t = self.model.n_q, self.begin + self.done * self.h
        rate = observe(self.program.address("moving"), n_q + 1, np.array([t]), y[None], self.constants)[0]
        q = y[:n_q] + self.h / 2 * rate[:n_q]
        for i in self.model.quaternions:
            q[i : i + 4] /= np.linalg.norm(q[i : i + 4])
        state: State = float_state(self.model, q.tolist(), y[n_q:].tolist(), t + self.h / 2, self.values)
        told = []
        for one in now:
            options = {key: one.options[key] for key in ("at", "impulse", "moment", "frame")}
            try:
                told.append((one.name, [resolved_blow(self.model, state, **options)]))
            except ModelError as error:
                raise SimulationError(
                    f"The blow '{one.name}' at t = {t:.9g} s cannot be applied: {error}"
                ) from None
        loads = blows_on(self.model, state, [blow for _, blows in told for blow in blows])
        blow = np.array([float(x) for x in generalized_impulse(self.model, state, loads)])
        self.memory.blow[:] = blow[self.shape.order]
        self.blows[self.done] = told

    def _steps(self, y: Array, size: int) -> list[Any]:
        """Return what `_Run.parts` lists of the next steps; ``y`` becomes the last state."""
        E, width = len(self.first), self.rows + len(self.shape.held)
        found: list[Any] = [np.empty((size, columns)) for columns in (len(y), width, 2, self.model.n_q)]
        found += [np.empty((size, E), dtype=np.int64), np.empty(size, dtype=object)]
        t, run = self.begin + self.done * self.h, self.memory
        got, sweeps, bound = 0, SWEEPS, RESIDUAL
        while got < size:
            room = slice(got, size if bound == RESIDUAL else got + 1)
            here = t + got * self.h
            done = self._marched(y, [part[room] for part in found], here, sweeps, bound)
            got += done
            if done:
                sweeps, bound = SWEEPS, RESIDUAL
            if got == size or (done and run.failure == NONE):
                continue
            if run.failure == FULL:
                self.pairs *= 2
                self._make_room()
                self.memory.residual, self.memory.depth, self.memory.sweeps = (
                    run.residual,
                    run.depth,
                    run.sweeps,
                )
                self.memory.contacts.kept[:] = run.contacts.kept
                self.memory.blow[:], run = run.blow, self.memory
                continue
            enough = accepted(run)
            close = run.problem.residual <= enough
            if run.failure == CONTACTS and (sweeps <= MOST_SWEEPS or (close and bound < enough)):
                bound = enough if close else RESIDUAL
                sweeps *= 10
                continue
            self._keep([part[:got] for part in found])
            raise SimulationError(failure(run, self.model, self.values, t + got * self.h, y))
        return found

    def _marched(self, y: Array, results: Sequence[Any], t: float, most_sweeps: int, tolerance: float) -> int:
        """Run the loop until the arrays are full or a step fails; return the number of steps done."""
        run = self.memory
        run.t, run.tolerance, run.most_sweeps, run.steps = t, tolerance, most_sweeps, len(results[0])
        run.y, (run.states, run.impulses, run.works, run.moved, run.modes, logs) = y, results
        run.log_end = np.zeros(max(run.steps, 1), dtype=np.int64)
        done = int(self.march(run, self.islands))
        if self.pairs:
            ends = [0, *run.log_end[:done].tolist()]
            for k in range(done):
                logs[k] = run.log[ends[k] : ends[k + 1]].copy()
        return done

    def _trajectory(self, status: End, stop: Crossing | None) -> Trajectory:
        n, E, held, h = len(self.start), len(self.first), len(self.shape.held), self.h
        widths = (n, self.rows + held, 2, self.model.n_q, E)
        states, impulses, works, corrections, modes = (
            np.concatenate([np.empty((0, width)), *part])
            for width, part in zip(widths, self.parts[:5], strict=True)
        )
        logs = [np.empty((0, ENTRY)) if one is None else one for part in self.parts[5] for one in part]
        states = np.concatenate([self.start[None], states])
        moments = self.begin + h * np.arange(len(states), dtype=np.float64)
        if len(states) == self.count + 1:
            moments[-1] = self.end  # exact: the sum of the steps has round-off
        if stop is not None:  # within a step: keep its part up to the event
            k = int(np.searchsorted(moments, stop.time, side="left"))
            part = (stop.time - moments[k - 1]) / h
            states, moments = (
                np.concatenate([states[:k], stop.state[None]]),
                np.append(moments[:k], stop.time),
            )
            impulses, works, modes, logs = impulses[:k].copy(), works[:k].copy(), modes[:k], logs[:k]
            corrections = corrections[:k].copy()
            corrections[-1] = 0  # that of this step is at its end
            impulses[-1] *= part
            works[-1] *= part
            logs[-1][:, IMPULSES] *= part
        seen = 0, n, self.constants, tuple(self.model.quaternions)
        rates = Rates(*seen, self.program, recipe=(Rates, *seen))
        specs, expressions = self.specs[: self.asked], self.expressions[: self.asked]
        crossed = crossings(self.kernels, self.values, specs, expressions, moments, states)
        if stop is not None:  # the last state is the event itself
            earlier = (
                c for c in crossed if c.time < moments[-2] or (c.time < stop.time and c.number != stop.number)
            )
            crossed = (*earlier, stop)
        path = Steps(rates, moments, np.diff(moments), states, crossed, status, 0, 0, len(states))
        constraints = np.zeros((len(impulses), len(conditions(self.model))))
        constraints[:, self.shape.held] = impulses[:, self.rows :]
        steps = range(len(impulses))
        forces = impulses[:, : self.rows] * stretch_numbers(self.model, self.values)
        did = Impulses(
            forces, constraints, works, corrections, modes.astype(np.int64),
            {k: told for k, told in self.blows.items() if k in steps}, tuple(logs),
        )  # fmt: skip
        run = self.memory
        sweeps = run.sweeps / max(self.done, 1)
        course = InSteps(
            self.kernels, dict(self.values), path, did, Stepping(h, run.residual, run.depth, sweeps),
            (self.first, self.tangents),
        )  # fmt: skip
        return Trajectory(*self.problem.outcome(path), course=course)
