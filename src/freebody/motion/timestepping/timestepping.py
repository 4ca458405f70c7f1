"""``method="timestepping"``: many contacts with friction, in steps of fixed length.

The loop is in `moreau`; this file prepares its kernels and memory and turns its results into a trajectory. The method
is of first order in the step, and an impact acts within the step in which it happens. The laws are exact: in every step
each contact satisfies Signorini's and Coulomb's conditions to the residual that the trajectory states.

The file is longer than others because a run fills the memory of the loop and reads it back, and both depend on its
layout.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ...dynamics.constraints import rows as conditions
from ...dynamics.impulse import blows_on, generalized_impulse
from ...dynamics.mobility import massless_motion
from ...dynamics.state import State, float_state
from ...errors import ModelError, SimulationError
from ...native import loop
from ..contact.cone_problem import eased, polished
from ..contact.motion import check_coefficients
from ..ending import End
from ..kernels.kernels import Kernels
from ..legs.blow import Blow, blows_of, call_of, scheduled
from ..legs.impulse import resolved_blow
from ..ode.dense_output import Array, Crossing, Rates, observe
from ..phase.candidates import layout_of
from ..request import Problem, Request, problem_of
from ..start.arguments import STORED, check_count, check_forwards, most_steps
from ..start.initial import number
from ..start.signals import refuse_switched
from ..trajectory.event import expressions_of
from ..trajectory.progress import Progress
from ..trajectory.trajectory import Trajectory
from .course import Impulses, InSteps, Stepping, Steps
from .stepped_kernels import Shape, stepping

RESIDUAL = 1e-12
"""Speed by which a contact may violate its laws, relative to the greatest speed in the problem of a step."""
ACCEPTED = 1e-9
"""The same limit for an almost degenerate problem, such as a pile coming to rest; see the trajectory's residual."""
SWEEPS = 3_000
"""Sweeps of one problem before Newton's method takes over (`polished`); ten times as many if that fails."""
MOST_SWEEPS = 100_000
PAST = 4 + 2 * 12
"""Number of rows in the array ``past`` of `moreau_problem.solve`."""
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
    if not model.contacts:
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
        self.memory = _memory(kernels, values, self.program, self.shape, self.tangents, self.rows)
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
        self.parts: list[list[Array]] = [[], [], [], []]  # states, impulses, works, modes
        self.blows: dict[int, list[tuple[str, Any]]] = {}
        self.done = 0

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
        program, E = self.program, len(self.first)
        found = observe(
            program.address("closing"),
            program.outputs("closing"),
            np.array([self.begin]),
            y[None],
            self.constants,
        )[0, : E + len(self.shape.reach_of)]
        depth = -found[:E]
        depth[self.shape.reach_of[found[E:] < 0]] = -np.inf
        worst = int(depth.argmax())
        if depth[worst] > 1e-9:
            raise SimulationError(
                f"The initial state of '{self.model.name}' has contact '{self.model.contacts[worst].name}' "
                f"{depth[worst]:.6g} m deep. Begin with every gap at zero or above."
            )

    def _advanced(self, y: Array) -> tuple[Array, Crossing | None]:
        """Return the state some steps later, and the terminal event if one occurs before it."""
        now = [*self.timed.pop(self.done, []), *self.timed.pop(-1, [])]
        watched = bool(self.called) or any(spec.terminal for spec in self.specs)
        block = max(1, BLOCK // (10 if watched else 1) // (1 + len(self.first) // 10))
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
        for c in _crossings(self.kernels, self.values, self.specs, self.expressions, moments, states):
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
        kick = np.array([float(x) for x in generalized_impulse(self.model, state, loads)])
        self.memory["kick"][:] = kick[self.shape.order]
        self.blows[self.done] = told

    def _steps(self, y: Array, size: int) -> list[Any]:
        """Return states, impulses, works and modes of the next steps; ``y`` becomes the last state."""
        E, width = len(self.first), self.rows + len(self.shape.held)
        states, impulses = np.empty((size, len(y))), np.empty((size, width))
        works, modes = np.empty((size, 2)), np.empty((size, E), dtype=np.int64)
        t = self.begin + self.done * self.h
        report = self.memory["report"]
        got, sweeps, bound = 0, SWEEPS, RESIDUAL
        while got < size:
            room = slice(got, size if bound == RESIDUAL else got + 1)
            here = t + got * self.h
            done = self._marched(
                y, states[room], impulses[room], works[room], modes[room], here, sweeps, bound
            )
            got += done
            if done:
                sweeps, bound = SWEEPS, RESIDUAL
            if got == size or (done and report[4] == 0):
                continue
            if report[4] == 1 and sweeps <= MOST_SWEEPS:
                if not self._by_newton() or not done:
                    bound = ACCEPTED if sweeps > SWEEPS and report[3] <= ACCEPTED else RESIDUAL
                    sweeps *= 10
                continue
            self._keep([states[:got], impulses[:got], works[:got], modes[:got]])
            raise SimulationError(self._failure(t + got * self.h, y))
        return [states, impulses, works, modes]

    def _marched(
        self,
        y: Array,
        states: Array,
        impulses: Array,
        works: Array,
        modes: Any,
        t: float,
        sweeps: int,
        bound: float,
    ) -> int:
        """Run the loop until the arrays are full or a step fails; return the number of steps done."""
        model, shape, memory = self.model, self.shape, self.memory
        done = self.march(
            *(self.program.address(name) for name in ("system", "closing", "moving", "loading")), int(shape.turning),
            self.constants, model.n_q, model.n_u, len(self.first), self.rows, len(shape.held), shape.holonomic,
            shape.order, shape.blocks, shape.squares, len(shape.blocks) - 1, shape.pieces, shape.row_first,
            shape.row_at, memory["tangents"], shape.reach_of, len(shape.reach_of), memory["quaternions"],
            len(model.quaternions), memory["mu"], memory["restitution"],
            np.array([t, self.h, bound]), len(states), memory["kick"], y,
            *(memory[name] for name in (*_REALS, *_WHOLES)), states, impulses, works, modes, memory["report"], sweeps,
        )  # fmt: skip
        if done:
            memory["kick"][:] = 0.0
        return int(done)

    def _by_newton(self) -> bool:
        """Solve by Newton's method the problem on which the sweeps failed; return True if this succeeds.

        The guess of the next attempt is the solution, or else the impulses that the sweeps reached.
        """
        memory, shape = self.memory, self.shape
        count = int(memory["report"][5])
        rows, kinds, mu = memory["rows"][:count], memory["kinds"][:count], memory["coefficient"][:count]
        W, X = np.zeros((count, self.model.n_u)), np.zeros((count, self.model.n_u))
        at_W = self.program.outputs("system") - int(shape.row_at[-1])
        for a, r in enumerate(rows):
            pieces = shape.pieces[shape.row_first[r] : shape.row_first[r + 1]]
            columns = [i for k in pieces for i in range(shape.blocks[k], shape.blocks[k + 1])]
            values = slice(shape.row_at[r], shape.row_at[r + 1])
            W[a, columns], X[a, columns] = memory["out"][at_W:][values], memory["X"][values]
        x = memory["x"][:count].copy()
        goal = RESIDUAL * memory["report"][6]
        A, b = W @ X.T, memory["b"][:count].copy()
        found = polished(A, b, kinds, mu, x.copy(), goal / 3)
        if found is None:
            found = eased(A, b, kinds, mu, goal / 3)
        memory["memory"][:] = 0.0
        memory["memory"][rows] = x if found is None else _within(found, kinds, mu)
        return found is not None

    def _failure(self, t: float, y: Array) -> str:
        report, model = self.memory["report"], self.model
        where = f"the step of '{model.name}' at t = {t:.9g} s"
        if report[4] == 1:
            return (
                f"The contacts of '{model.name}' were not solved in the step at t = {t:.9g} s: after {MOST_SWEEPS} "
                f"sweeps and Newton's method a law is still missed by {report[3]:.3g} of the greatest speed (required: "
                f"{ACCEPTED:g}). Where friction jams a contact (Painlevé) or restitution works against it, there may "
                "be no solution: less friction or restitution=0 has one. Otherwise take a shorter step, or masses "
                "that differ less: they need fewer sweeps."
            )
        if report[4] == 2:
            q, u = y[: model.n_q].tolist(), y[model.n_q :].tolist()
            idle = massless_motion(model, float_state(model, q, u, t, self.values))
            names = f" {' and '.join(map(repr, idle))} together move no mass." if idle else ""
            return (
                f"Expected a mass matrix that is positive definite in {where}.{names} Give every body that can move by "
                "itself a mass and moments of inertia, or fix each part that moves no mass by a joint."
            )
        if report[4] == 3:
            return (
                f"The constraints of '{model.name}' depend on each other in {where}: this happens when bars come into "
                "line. Stop the motion earlier with a terminal event, or change the lengths."
            )
        if report[4] == 4:
            return (
                f"The overlap of bodies could not be removed in {where}: {report[5]:.3g} m remain (required: 1e-10 m). "
                "The cause may be bodies wedged in too narrow a space or driven into each other. Otherwise take a "
                "shorter step."
            )
        if report[4] == 6:
            return (
                f"No mean speeds agree with the loads that depend on them in {where}. This happens where bodies turn "
                "several times in a step, or where a load jumps with a speed. Take a shorter step."
            )
        return (
            f"A rate or a speed is not a finite number in {where}. A division by zero, or a root or logarithm of a "
            "negative number causes this: check the loads there, or take a shorter step."
        )

    def _trajectory(self, status: End, stop: Crossing | None) -> Trajectory:
        n, E, held, h = len(self.start), len(self.first), len(self.shape.held), self.h
        widths = (n, self.rows + held, 2, E)
        states, impulses, works, modes = (
            np.concatenate([np.empty((0, width)), *part])
            for width, part in zip(widths, self.parts, strict=True)
        )
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
            impulses, works, modes = impulses[:k].copy(), works[:k].copy(), modes[:k]
            impulses[-1] *= part
            works[-1] *= part
        seen = 0, n, self.constants, tuple(self.model.quaternions)
        rates = Rates(*seen, self.program, recipe=(Rates, *seen))
        specs, expressions = self.specs[: self.asked], self.expressions[: self.asked]
        crossings = _crossings(self.kernels, self.values, specs, expressions, moments, states)
        if stop is not None:  # the last state is the event itself
            earlier = (
                c
                for c in crossings
                if c.time < moments[-2] or (c.time < stop.time and c.number != stop.number)
            )
            crossings = (*earlier, stop)
        path = Steps(rates, moments, np.diff(moments), states, crossings, status, 0, 0, len(states))
        constraints = np.zeros((len(impulses), len(conditions(self.model))))
        constraints[:, self.shape.held] = impulses[:, self.rows :]
        steps = range(len(impulses))
        did = Impulses(
            impulses[:, : self.rows], constraints, works, modes.astype(np.int64),
            {k: told for k, told in self.blows.items() if k in steps},
        )  # fmt: skip
        report = self.memory["report"]
        sweeps = float(report[1]) / max(self.done, 1)
        course = InSteps(
            self.kernels, dict(self.values), path, did, Stepping(h, float(report[0]), float(report[2]), sweeps),
            (self.first, self.tangents),
        )  # fmt: skip
        return Trajectory(*self.problem.outcome(path), course=course)


def _within(x: Array, kinds: Any, mu: Array) -> Array:
    """Return the impulses, those that round-off left outside their cones moved onto them."""
    for a in np.flatnonzero(kinds == 1):
        x[a] = max(x[a], 0.0)
        end = a + 1
        while end < len(kinds) and kinds[end] != 1:
            end += 1
        T, limit = float(np.linalg.norm(x[a + 1 : end])), mu[a + 1] * x[a] if end > a + 1 else 0.0
        if limit < T:
            x[a + 1 : end] *= limit / T
    return x


_REALS = (
    "z", "out", "rate", "u", "v", "dv", "L", "X", "K", "S", "sigma", "spare", "d", "b", "x", "before", "past", "local",
    "memory", "lam", "mean", "first_rate",
)  # fmt: skip
_WHOLES = ("rows", "kinds", "coefficient")


def _memory(
    kernels: Kernels, values: Mapping[str, float], program: Any, shape: Shape, tangents: Sequence[int], m: int
) -> dict[str, Array]:
    """Return the arrays of the loop, by the names of its arguments."""
    model = kernels.model
    n, held = model.n_u, len(shape.held)
    most = max(m, n, 1)
    sizes = {
        "z": model.n_q + n, "out": program.outputs("system"), "rate": model.n_q + 1, "u": n, "v": n, "dv": n,
        "L": int(shape.squares[-1]), "X": int(shape.row_at[-1]), "K": held * n, "S": held * held, "sigma": m * held,
        "spare": max(n, held * held, 2 * held), "d": 3 * m + 6, "b": most, "x": most, "before": most,
        "past": PAST * most + 16, "local": 6,
        "memory": most, "lam": max(held, 1), "coefficient": most, "kick": n, "report": 8,
        "mean": 7 * n, "first_rate": model.n_q + 1,
    }  # fmt: skip
    result = {name: np.zeros(max(size, 1)) for name, size in sizes.items()}
    result |= {name: np.zeros(most, dtype=np.int64) for name in ("rows", "kinds")}
    result["tangents"] = np.array(tangents, dtype=np.int64)
    result["quaternions"] = np.array(model.quaternions, dtype=np.int64)
    for name, attribute in (("mu", "friction"), ("restitution", "restitution")):
        result[name] = np.array([number(model, values, getattr(c, attribute), name) for c in model.contacts])
    return result


def _crossings(
    kernels: Kernels, values: Any, specs: Any, expressions: Any, times: Array, states: Array
) -> tuple[Crossing, ...]:
    """Return the zero crossings of the user's events, located by linear interpolation within each step.

    Raises
    ------
    SimulationError          if an event has no value
    """
    if not specs:
        return ()
    program = kernels.expressions(expressions)
    constants = program.constants(kernels.parameters(values))

    def at(moments: Array, there: Array) -> Array:
        return observe(program.address("values"), len(specs), moments, there, constants)

    g = at(times, states)
    lost = np.argwhere(~np.isfinite(g))
    if len(lost):
        k, i = lost[0]
        raise SimulationError(
            f"Expected a number for event '{specs[i].name}' at t = {times[k]:.9g} s, got {g[k, i]:g} for "
            f"{expressions[i]}. A division by zero, or a root or logarithm of a negative number, does this: watch what "
            "passes through zero itself, or stop before with a terminal event."
        )
    result = []
    for i, spec in enumerate(specs):
        for k in np.flatnonzero((g[:-1, i] * g[1:, i] < 0) | ((g[1:, i] == 0) & (g[:-1, i] != 0))):
            sign = 1 if g[k, i] < 0 else -1
            if spec.direction in (0, sign):
                x = g[k, i] / (g[k, i] - g[k + 1, i])

                def value(x: float, k: int = int(k), i: int = i) -> float:
                    between = states[k : k + 1] + x * (states[k + 1] - states[k])
                    return float(at(times[k : k + 1] + x * (times[k + 1] - times[k]), between)[0, i])

                if _through_infinity(value):
                    continue
                result.append(
                    Crossing(
                        float(times[k] + x * (times[k + 1] - times[k])),
                        i,
                        sign,
                        states[k] + x * (states[k + 1] - states[k]),
                    )
                )
    return tuple(sorted(result, key=lambda one: one.time))


def _through_infinity(value: Callable[[float], float]) -> bool:
    """Return True if a sign change between 0 and 1 is at a pole: near it, |value| far exceeds both end values."""
    low, high = 0.0, 1.0
    before, after = value(low), value(high)
    largest = max(abs(before), abs(after))
    for _ in range(40):
        x = (low + high) / 2
        found = value(x)
        if found == 0:
            return False
        low, high = (x, high) if (found > 0) == (before > 0) else (low, x)
    return not min(abs(value(low)), abs(value(high))) <= 1e3 * largest
