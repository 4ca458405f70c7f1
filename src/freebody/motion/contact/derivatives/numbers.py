"""Derivatives of single numbers of a motion with contacts: of outputs, extremes, ends and times of events."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any, cast

import numpy as np

from ....dynamics import State
from ....errors import NoDerivativesError, SimulationError
from ....scalar.algebra import Expression, Scalar
from ....scalar.dual import slope_of, value_of
from ...kernels import switches
from ...kernels.contact_quantities import OfContacts
from ...kernels.program import Program, at_states
from ...legs.number_derivatives import Numbers
from ...legs.variation import energy_named
from ...ode.dense_output import Array, Crossing
from ...phase.candidate_slopes import along
from ...trajectory.computed_motion import ComputedMotion
from ...trajectory.event import expressions_of
from ...trajectory.in_legs import phases_of
from ...trajectory.outputs import OfContact, OfReaction
from ...trajectory.peaks import Peak, peaks
from ...trajectory.phases import Segment
from .following import Followed
from .quantities import value_along
from .slopes import ENERGIES, Slopes, of_contact, without_derivative

ALIKE, SAME = 1e-9, 1e-6
"""Relative differences up to which two values are equal, and their derivatives."""


class TouchingNumbers(Numbers):
    """Derivatives of single numbers of a motion with contacts."""

    def __init__(self, motion: ComputedMotion, shifts: Array, followed: Followed) -> None:
        super().__init__(motion, shifts)
        self.followed, self.of = followed, followed.slopes

    @cached_property
    def states(self) -> Array:
        """States with their derivatives at the output times."""
        return self.followed.path.sample(self.motion.t)

    def _at_end(self, quantity: Expression, how: str, name: str) -> Array:
        path, last = self.motion.path, self.followed.path.segments[-1]
        if how == "initial":
            return self.slopes(quantity, np.array([path.start]))[0]
        rate, ways = self._change(quantity, last, path.end, last.path.states[-1])
        return ways + rate * self.end

    def _greatest(self, quantity: Expression, sign: int, name: str) -> Array:
        """Return the derivatives of a quantity where ``sign`` times it is greatest: d/dp = Dx + x' dt/dp.

        At the ends of a phase dt/dp is that of the time at which it ends. Between them x' = 0.
        """
        if isinstance(quantity, OfContact):
            raise without_derivative(name)
        found = list(
            peaks(self.followed.path, lambda t, segment: self._course(quantity, t, segment), sign, name)
        )
        best = max(sign * one.value for one in found)
        size = max(abs(one.value) for one in found)
        near = [one for one in found if sign * one.value >= best - ALIKE * size]
        slopes = np.array([self._at_peak(quantity, one) for one in near])
        apart = np.abs(slopes - slopes[0]) > SAME * (1 + np.abs(slopes[0]))
        if apart.any():
            i, j = np.argwhere(apart)[0]
            first, last = sorted((near[0].time, near[i].time))
            raise NoDerivativesError(
                f"Expected one derivative of '{name}' by '{self.of.unknowns[j].name}', but the run reaches "
                f"{near[0].value:.6g} at t = {first:.6g} s and at t = {last:.6g} s alike, with the derivatives "
                f"{slopes[0, j]:.6g} and {slopes[i, j]:.6g}. Ask for the quantity at these times."
            )
        return cast(Array, slopes[0])

    def _course(self, quantity: Expression, times: Array, segment: Segment) -> Array:
        """Return a quantity and its rate in a phase."""
        of, n = _slopes(segment), self.of.moved
        y = segment.path.sample(times)[:, : n + 2]
        motion = segment.kernels.motion()
        f = at_states(motion, "rates", times, y, motion.constants(of.parameters))[:, :n]
        given = np.hstack([y[:, :n], f, np.ones((len(times), 1)), np.zeros((len(times), len(of.symbols)))])
        program = self._program(quantity)
        return at_states(program, "course", times, given, program.constants(of.parameters))

    def _at_peak(self, quantity: Expression, one: Peak) -> Array:
        """Return the derivatives of a value that may be the greatest."""
        path, shift = self.followed.path, np.zeros(len(self.of.unknowns))
        if one.end and one.time == path.end and one.segment is path.segments[-1]:
            shift = self.end
        elif one.end:
            shift = next((tau for a, b, tau in self.followed.shifts if a <= one.time <= b), shift)
        row = one.segment.path.sample(np.array([one.time]))[0]
        rate, ways = self._change(quantity, one.segment, one.time, row)
        return ways + rate * shift

    def event(self, crossing: Crossing) -> Array:
        """Return the derivatives of the time of an event of the user.

        Raises
        ------
        SimulationError
            The expression jumps over zero, or only touches it.
        """
        motion, spec = self.motion, self.motion.specs[crossing.number]
        quantity = expressions_of(motion.kernels.model, (spec,))[0]
        # the state before what may happen then
        segment = next(one for one in self.followed.path.segments if one.path.end >= crossing.time)
        row = segment.path.sample(np.array([crossing.time]))[0]
        value, rate, ways = self._passing(quantity, segment, crossing.time, row)
        if abs(value) > 1e-9 * (1 + abs(rate) + np.abs(row[: self.of.moved]).max(initial=0.0)):
            raise SimulationError(
                f"Expected event '{spec.name}' to pass through zero for a derivative of its time, but at t = "
                f"{crossing.time:.6g} s it jumps over it. Watch for another expression, or for the contact that makes "
                "it jump, motion.sensitivity.times(contact)."
            )
        if abs(rate) <= 1e-9 * (1 + np.abs(ways).max(initial=0.0)):
            raise SimulationError(
                f"Expected event '{spec.name}' to pass through zero for a derivative of its time, but at t = "
                f"{crossing.time:.6g} s it only touches zero, or jumps over it. Watch for another expression."
            )
        return -ways / rate

    def _passing(
        self, quantity: Expression | OfContacts, segment: Segment, t: float, row: Array
    ) -> tuple[float, float, Array]:
        """Return what an event watches, with its rate and its derivatives."""
        if not isinstance(quantity, OfContacts):
            program, y = self.motion.kernels.expressions((quantity,)), row[None, : self.of.moved]
            (value,) = self.motion._observed(program, "values", np.array([t]), y)[0]
            return float(value), *self._change(quantity, segment, t, row)
        of, y = _slopes(segment), row[: self.of.moved]
        f = of.velocity(segment.kernels, t, row[: of.moved + 2])
        s = row[of.moved + 2 :].reshape(len(of.seeds), -1)
        ways = [
            (f, 1.0, np.zeros(len(of.symbols))),
            *((x, 0.0, dp) for x, dp in zip(s, of.seeds, strict=True)),
        ]
        found = value_along(of, segment.kernels, quantity, t, y, ways)
        rate, *slopes = (float(slope_of(found, j)) for j in range(len(ways)))
        return float(value_of(found)), rate, np.array(slopes)

    def _change(self, quantity: Expression, segment: Segment, t: float, row: Array) -> tuple[float, Array]:
        """Return the rate of a quantity in a phase, and its derivatives, at a state with its derivatives."""
        of = _slopes(segment)
        n, zero = of.moved, np.zeros(len(of.symbols))
        f = of.velocity(segment.kernels, t, row[: n + 2])
        ways = [
            self._observed(segment, quantity, t, row[:n], row[n + 2 + j * n :][:n], 0.0, dp)[0]
            for j, dp in enumerate(of.seeds)
        ]
        (rate,) = self._observed(segment, quantity, t, row[:n], f, 1.0, zero)
        return rate, np.array(ways)

    # -- programs ----------------------------------------------------------------------------------

    def slopes(self, quantity: Expression, times: Array) -> Array:
        """Return the derivatives of a quantity at times, shape (times, unknowns)."""
        path, states = self.followed.path, self.states
        if times is not self.motion.t:
            states = path.sample(times)
        n, result = self.of.moved, np.empty((len(times), len(self.of.unknowns)))
        for k, chosen in path.split(times):
            segment, t, y = path.segments[k], times[chosen], states[chosen]
            of = _slopes(segment)
            for j, dp in enumerate(of.seeds):
                s = y[:, n + 2 + j * n :][:, :n]
                if isinstance(quantity, OfContact):
                    rows = zip(t, y, s, strict=True)
                    result[chosen, j] = [
                        self._observed(segment, quantity, x, one[:n], way, 0.0, dp)[0] for x, one, way in rows
                    ]
                    continue
                given = np.hstack([y[:, :n], s, np.zeros((len(t), 1)), np.tile(dp, (len(t), 1))])
                result[chosen, j] = self._values(of, quantity, t, given)[:, 0]
        if isinstance(quantity, OfContact) and quantity.what in ("normal", "tangential"):
            result[self._indeterminate(quantity, times)] = np.nan
        return result

    def _indeterminate(self, quantity: OfContact, times: Array) -> list[bool]:
        """Return True for each time at which the motion does not determine a force of a contact."""
        own, path = self.of.model.contacts, phases_of(self.motion)
        k = [contact.name for contact in own].index(quantity.contact)
        r = self.of.scene.first[k] + (1 + quantity.component if quantity.what == "tangential" else 0)
        return [bool(path.segments[place].loose[r]) for place in path.places(times)]

    def _observed(
        self, segment: Segment, quantity: Expression, t: float, y: Array, s: Array, tau: float, dp: Array
    ) -> Sequence[float]:
        of = _slopes(segment)
        if isinstance(quantity, OfContact):
            if not segment.path.curved:  # the start of a straight step has no direction of slip yet
                t, y = segment.path.end, segment.path.states[-1, : of.moved]
            return [
                of_contact(of, segment.kernels, quantity, t, y, of.along(segment.kernels, t, y, s, tau, dp))
            ]
        given = np.concatenate([y, s, [tau], dp])[None]
        return cast(Sequence[float], self._values(of, quantity, np.array([t]), given)[0])

    def _values(self, of: Slopes, quantity: Expression, times: Array, given: Array) -> Array:
        program = self._program(quantity)
        return at_states(program, "slope", times, given, program.constants(of.parameters))

    def _program(self, quantity: Expression) -> Program:
        slopes, model = self.of, self.of.model

        def value(state: State) -> Scalar:
            if not isinstance(quantity, str | OfReaction):
                return switches.value_of(state, quantity)
            if isinstance(quantity, OfReaction):
                raise without_derivative(f"{quantity.joint}.{quantity.what}")
            if quantity not in ENERGIES:
                raise without_derivative(quantity)
            return energy_named(model, state, quantity)

        def functions(state: State, given: Sequence[Scalar]) -> Any:
            x = value(state)
            slope = along(state, [x], slopes.symbols, given)
            return {"slope": slope, "course": [x, *slope]}

        key = ("slope of", quantity, tuple(map(str, slopes.symbols)))
        return slopes.kernels.program(key, functions, slopes.moved + 1 + len(slopes.symbols))


def _slopes(segment: Any) -> Slopes:
    """Return the derivatives with the values of the parameters in a phase."""
    return cast(Slopes, segment.path.slopes)
