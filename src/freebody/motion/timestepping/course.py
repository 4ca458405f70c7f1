"""The motion of a machine in steps of fixed length: the impulses of every step, and the results that follow from them.

A step yields impulses, so all forces here are means over a step, impulse/h. Joint reactions close the momentum balance
of every body with the loads and the contact forces:  I A + V ×* (I V) = Σ F  with the mean acceleration A of the step,
at its middle.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ...dynamics.conditions.unilateral import MotionWarning, limits
from ...dynamics.contact_motion import forced_motion
from ...dynamics.kinematics import Spot
from ...dynamics.motion import all_reactions
from ...dynamics.newton_euler import drive_power
from ...dynamics.state import float_state
from ...errors import SimulationError
from ...model.contact import Contact, friction_margin
from ...scalar.algebra import ZERO
from ..contact.course import Change, ContactMotion, Timeline, distances
from ..kernels.kernels import Kernels
from ..kernels.program import Program
from ..ode.dense_output import Array
from ..start.initial import number
from ..start.overlap import behind_sides
from ..trajectory.computed_motion import ComputedMotion
from ..trajectory.course import Piece
from ..trajectory.event import Happening
from ..trajectory.quantities import ByName, Energy
from .intervals import Intervals
from .long_steps import far_turns, made_energy
from .mean_motion import mean_motion, middle_of
from .pair_motion import MODES, OfFamilies, pair_motion, wrenches
from .rebounds import rebounds
from .stepped_kernels import bodies_in_families, gaps, laws_of_friction, mean_reactions, stepping
from .steps import Impulses, Stepping, Steps
from .timeline import changes, happenings


@dataclass(frozen=True, eq=False)
class InSteps:
    """Course of a motion in steps of fixed length.

    Forces are means over a step: at an output time, over the step that ends at or after it.

    ``values``      values of the parameters at the start, and ``intervals``: those that signals and controllers give
    ``layout``      place of the first row of each contact, and its number of tangents
    """

    kernels: Kernels
    values: Mapping[str, float]
    path: Steps
    impulses: Impulses
    stepping: Stepping
    layout: tuple[Sequence[int], Sequence[int]]
    intervals: Intervals
    indeterminate: tuple[str, ...] = ()
    derivatives: None = None

    @property
    def residual(self) -> float:
        """Greatest residual of a step."""
        return self.stepping.residual

    def works(self, motion: ComputedMotion) -> bool:
        """Return True if loads or drives do work."""
        return self.kernels.works

    def observed(
        self, motion: ComputedMotion, program: Program, function: str, times: Array, states: Array
    ) -> Array:
        """Return the outputs of a function of a program at states."""
        return self._observed(program, function, times, states)

    def _observed(
        self, program: Program, function: str, times: Array, states: Array, steps: Any = None
    ) -> Array:
        """Return the outputs of a function, with the parameters of these steps or of those that begin at the times."""
        within = self._step_from(times) if steps is None else steps
        return self.intervals.observed(program, function, times, states, within)

    def _step_from(self, times: Array) -> Any:
        """Return the index of the step that begins at or before each time."""
        last = max(len(self.path.lengths) - 1, 0)
        return np.clip(np.searchsorted(self.path.times, times, side="right") - 1, 0, last)

    def quantity(self, motion: ComputedMotion, name: str) -> Array:
        """Return reactions or multipliers, means over a step.

        Raises
        ------
        SimulationError
            Rates are asked for.
        """
        if name == "reactions":
            return self.mean_reactions(motion.t)
        if name == "multipliers":
            return self._mean(self.impulses.constraints, motion.t)
        raise SimulationError(
            "Expected a coordinate, a speed or an expression of them: the speeds of a motion by "
            'method="timestepping" jump from step to step, so it has no accelerations. Divide differences of speeds by '
            "trajectory.step."
        )

    def _step_of(self, times: Array) -> Any:
        """Return the index of the step that ends at or after each time."""
        ends = self.path.times[1:]
        return np.clip(np.searchsorted(ends, times, side="left"), 0, max(len(ends) - 1, 0))

    def _mean(self, impulses: Array, times: Array) -> Array:
        lengths = np.diff(self.path.times)
        if not len(lengths):
            return np.zeros((len(times), impulses.shape[1]))
        k = self._step_of(times)
        return np.asarray(impulses[k] / lengths[k, None])

    def mean_forces(self, times: Array) -> Array:
        """Return the mean contact forces over the step that ends at or after each time, in layout order [N]."""
        return self._mean(self.impulses.contacts, times)

    def mean_reactions(self, times: Array) -> Array:
        """Return the mean reactions of all joints over the step that ends at or after each time.

        Force and moment of each joint in turn, shape (n, 6 joints) [N, N m].
        """
        steps, place = np.unique(self._step_of(times), return_inverse=True)
        return np.asarray(self._of_steps(steps)[0][place])

    def _of_steps(self, steps: Any) -> tuple[Array, Array]:
        """Return the mean reactions and the mean power of the drives in these steps."""
        model = self.kernels.model
        if model.families and all(link.flies for link in model.links):
            return np.zeros((len(steps), 6 * len(model.joints))), np.zeros(len(steps))
        program = mean_reactions(self.kernels)
        if len(self.path.times) < 2:
            return np.zeros((len(steps), program.outputs("reactions"))), np.zeros(len(steps))
        h = self.path.lengths[steps]
        moving, _ = stepping(self.kernels)
        t, begin = self.path.times[steps], self.path.states[steps]
        rate = self._observed(moving, "moving", t, begin, steps)
        middle = middle_of(model, begin, rate, h[:, None])
        lengths = (self.path.times[steps + 1] - t)[:, None]
        end = self.path.states[steps + 1] - self.impulses.corrections[steps]  # before what follows the forces
        u, udot = mean_motion(model, self.values, middle, begin, end, lengths)
        known = [
            udot,
            self.impulses.contacts[steps] / lengths,
            self.impulses.constraints[steps] / lengths,
            wrenches(self.kernels.model, self.impulses.pairs, steps) / lengths,
        ]
        given = np.concatenate([middle, u, *known], axis=1)
        found = self._observed(program, "reactions", t + h / 2, given, steps)
        drive = self._observed(program, "drive", t + h / 2, given, steps)[:, 0]
        for k in np.flatnonzero(np.isin(steps, list(self.impulses.blows))):
            found[k], drive[k] = self._struck(
                steps[k], t[k] + h[k] / 2, middle[k], u[k], [x[k] for x in known]
            )
        return found, drive

    def _struck(self, step: int, t: float, q: Array, u: Array, known: Any) -> tuple[Any, float]:
        """Return the same two results for one step with blows."""
        model = self.kernels.model
        numbers, h = self.intervals.numbers(self.kernels, step), self.path.lengths[step]
        state = float_state(model, q.tolist(), u.tolist(), t, numbers)
        blows = [
            (point, tuple(x / h for x in P), tuple(x / h for x in n))
            for _, acting in self.impulses.blows[step]
            for point, P, n in acting
        ]
        udot, forces, multipliers, wrenches = (x.tolist() for x in known)
        bodies = bodies_in_families(model).values()
        blows += [
            (Spot(body, ZERO), tuple(wrenches[6 * k : 6 * k + 3]), tuple(wrenches[6 * k + 3 : 6 * k + 6]))
            for k, body in enumerate(bodies)
        ]
        moving = forced_motion(model, state, udot, forces, multipliers, blows)
        found = all_reactions(model, state, moving)
        return (
            [float(x) for name in found for vector in found[name] for x in vector],
            float(drive_power(model, state, moving.udot, moving.loads)),
        )

    def limit_pieces(self, motion: ComputedMotion) -> Iterator[Piece]:
        """Yield times and limit values from the mean forces of each step, constant within the step."""
        model, lengths = self.kernels.model, np.diff(self.path.times)
        if not len(lengths):
            return
        forces = self.impulses.constraints / lengths[:, None]
        left = []
        for one in limits(model):
            force, *friction = forces[:, one.places].T
            if friction:
                mu = number(model, self.values, one.friction, "a coefficient of friction")
                force = mu * force - np.hypot(*friction)
            left.append(force)
        n = len(left)
        at_starts = self._observed(
            self.kernels.limits(), "limits", self.path.times[:-1], self.path.states[:-1]
        )
        negligible = (at_starts[:, n:] - at_starts[:, :n]).T
        values = np.repeat(np.concatenate([left, left + negligible]), 2, axis=1).T
        yield np.repeat(self.path.times, 2)[1:-1], None, values

    @cached_property
    def _work(self) -> Array:
        """Work in every step: by contacts and blows; by loads, constraints and drives. Shape (steps, 2) [J]."""
        works = self.impulses.works
        model = self.kernels.model
        if not len(works) or not any(link.driven for link in model.links):
            return works
        _, drive = self._of_steps(np.arange(len(works)))
        return works + np.column_stack([np.zeros(len(works)), drive * np.diff(self.path.times)])

    def work_until(self, times: Array) -> Array:
        """Return the total work since the start, and the part by contacts, blows and changes, shape (n, 2) [J]."""
        done, of_loads = (self._until(times, column) for column in self._work.T)
        done += self.intervals.work_until(self._step_from(times))
        return np.column_stack([done + of_loads, done])

    def _until(self, times: Array, work: Array) -> Array:
        """Return the work in every step as its sum since the start."""
        total: Array = np.interp(times, self.path.times, np.concatenate([[0.0], np.cumsum(work)]))
        return total

    @cached_property
    def corrected(self) -> Array:
        """Energy that the correction at the end of every step adds: that after it less that before [J]."""
        moved, path = self.impulses.corrections, self.path
        result = np.zeros(len(moved))
        steps = np.flatnonzero(moved.any(axis=1))
        if len(steps):
            after = path.states[steps + 1]
            before = after.copy()
            before[:, : moved.shape[1]] -= moved[steps]
            energies = [
                self._observed(self.kernels.motion(), "energy", path.times[steps + 1], y, steps).sum(axis=1)
                for y in (before, after)
            ]
            with np.errstate(invalid="ignore"):  # a motion that has blown up
                result[steps] = energies[1] - energies[0]
        return result

    def energy(self, motion: ComputedMotion) -> Energy:
        """Return the energy ledger; its residual is the error of the method, of second order in the step.

        The correction at the end of steps, which moves overlapping bodies apart, does work of first order.
        """
        times = np.concatenate([[self.path.start], motion.t])
        states = np.concatenate([self.path.states[:1], motion.states])
        both = self._observed(self.kernels.motion(), "energy", times, states)
        work, corrected = self.work_until(times), self._until(times, self.corrected)
        total = work[:, 0] + corrected
        residual = both.sum(axis=1) - both[0].sum() - total
        return Energy(
            both[1:, 0], both[1:, 1], total[1:], residual[1:], work[1:, 1], correction=corrected[1:]
        )

    def warnings(self, motion: ComputedMotion) -> tuple[MotionWarning, ...]:
        """Return a warning if the steps have made more energy than the machine had, for turns too far, and for
        what comes behind a side.
        """
        return (*self._warnings, *behind_sides(motion))

    @cached_property
    def _warnings(self) -> tuple[MotionWarning, ...]:
        return (*made_energy(self), *far_turns(self), *rebounds(self))

    # -- contacts --------------------------------------------------------------------------------

    def contacts(self, motion: ComputedMotion) -> dict[str, ContactMotion]:
        """Return gap, mean forces over the step, slip and mode of every contact, by name."""
        first, tangents = self.layout
        model, times = self.kernels.model, motion.t
        program = gaps(self.kernels)
        gap, reach = (self._observed(program, name, times, motion.states) for name in ("gap", "reach"))
        rates = self._observed(program, "rate", times, motion.states)
        found, approaches = distances(model, gap, reach.reshape(*gap.shape, 2).min(axis=2), rates[:, first])
        forces = self.mean_forces(times)
        none = np.zeros((len(times), len(first)), dtype=np.int64)
        modes = np.array(MODES)[
            self.impulses.modes[self._step_of(times)] if len(self.impulses.modes) else none
        ]
        result: dict[str, ContactMotion] = {}
        pressures: dict[str, Array] = {}
        for e, contact in enumerate(model.contacts):
            at, n = first[e], tangents[e]
            lam, v = forces[:, at : at + 1 + n], rates[:, at + 1 : at + 1 + n]
            mode = np.array([contact.shown(x) for x in modes[:, e]])
            pressure = lam[:, 0] + number(model, self.values, contact.adhesion, "an adhesion")
            if contact.presser:
                pressure = lam[:, 0] = np.where(mode == "open", 0.0, pressures[contact.presser])
            pressures[contact.name] = pressure
            mu = self.static_friction(contact.name, contact, times, motion.states)
            ratio = number(model, self.values, contact.stretch, "a ratio of friction")
            margin = friction_margin(mu, pressure, lam[:, 1:].T, ratio, np.sqrt)
            if not contact.compliant:
                approaches[mode != "open", e] = 0.0
            result[contact.name] = ContactMotion(
                found[:, e], lam[:, 0], lam[:, 1] if n == 1 else lam[:, 1:], v[:, 0] if n == 1 else v,
                np.where(mode == "open", np.nan, margin), mode, lam, mu, margin,
                approaches[:, e],
            )  # fmt: skip
        if not model.families:
            return ByName("contact", result)
        return OfFamilies(result, lambda *pair: pair_motion(self, motion, *pair), model.families)

    def static_friction(self, name: str, law: Contact, times: Array, states: Array) -> Array:
        """Return the coefficient of friction at rest of a contact, or of a family with its law, at states."""
        program, names = laws_of_friction(self.kernels)
        if program is None or name not in names:
            mu = number(self.kernels.model, self.values, law.friction, "a coefficient of friction")
            return np.full(len(times), mu)
        at_rest = np.pad(states, ((0, 0), (0, 1)))
        return self._observed(program, names[name], times, at_rest)[:, 1]

    def modes(self, motion: ComputedMotion) -> Timeline:
        """Return the modes of every contact: from the beginning of the first step to the end of the last, and why each
        began.
        """
        return Timeline(change for _, _, change in self.changes)

    @cached_property
    def changes(self) -> list[tuple[int, int, Change]]:
        """(step, contact, change) of every mode, in the order of their beginnings."""
        return changes(self)

    @cached_property
    def happenings(self) -> tuple[Happening, ...]:
        """Blows and changes of mode in order of time, each at the beginning of its step."""
        return happenings(self)
