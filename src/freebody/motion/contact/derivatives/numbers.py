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
from ...phase.candidates.candidate_slopes import along
from ...trajectory.computed_motion import ComputedMotion
from ...trajectory.event import expressions_of
from ...trajectory.in_legs import phases_of
from ...trajectory.outputs import OfContact, OfReaction
from ...trajectory.peaks import Peak, peaks
from ...trajectory.phases import Segment
from .following import Followed
from .quantities import Way, check, quantities, value_along
from .slopes import ENERGIES, Slopes, without_derivative

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
        _, rate, ways = self._changing(quantity, last, path.end, last.path.states[-1])
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
        _, rate, ways = self._changing(quantity, one.segment, one.time, row)
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
        value, rate, ways = self._changing(quantity, segment, crossing.time, row)
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

    def _changing(
        self, quantity: Expression | OfContacts, segment: Segment, t: float, row: Array
    ) -> tuple[float, float, Array]:
        """Return a quantity in a phase, its rate and its derivatives, at a state with its derivatives."""
        of, n = _slopes(segment), self.of.moved
        f = of.velocity(segment.kernels, t, row[: n + 2])
        ways = [(f, 1.0, np.zeros(len(of.symbols))), *_ways(of, row)]
        if isinstance(quantity, OfContact | OfContacts):
            found = self._of_contacts(quantity, segment, t, row, ways)
            rate, *slopes = (float(slope_of(found, j)) for j in range(len(ways)))
            return float(value_of(found)), rate, np.array(slopes)
        given = np.array([np.concatenate([row[:n], s, [tau], dp]) for s, tau, dp in ways])
        course = self._values(of, quantity, np.full(len(ways), t), given, "course")
        return float(course[0, 0]), float(course[0, 1]), course[1:, 1]

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
            if isinstance(quantity, OfContact):
                for row, x, one in zip(chosen, t, y, strict=True):
                    found = self._of_contacts(quantity, segment, x, one, _ways(of, one))
                    result[row] = [float(slope_of(found, j)) for j in range(len(of.unknowns))]
                continue
            for j, dp in enumerate(of.seeds):
                s = y[:, n + 2 + j * n :][:, :n]
                given = np.hstack([y[:, :n], s, np.zeros((len(t), 1)), np.tile(dp, (len(t), 1))])
                result[chosen, j] = self._values(of, quantity, t, given)[:, 0]
        if isinstance(quantity, OfContact) and quantity.what in ("normal", "tangential", "margin"):
            result[self._indeterminate(quantity, times)] = np.nan
        return result

    def _indeterminate(self, quantity: OfContact, times: Array) -> list[bool]:
        """Return True for each time at which the motion does not determine a force, or a margin, of a contact."""
        path, k = phases_of(self.motion), [x.name for x in self.of.model.contacts].index(quantity.contact)
        first, n = self.of.scene.first[k], self.of.scene.tangents[k]
        at = first + (1 + quantity.component if quantity.what == "tangential" else 0)
        is_margin = quantity.what == "margin"
        rows = slice(first, first + 1 + n) if is_margin else slice(at, at + 1)
        some = [path.segments[place] for place in path.places(times)]
        return [bool(np.any(one.loose[rows])) or (is_margin and one.modes[k] == "open") for one in some]

    def _of_contacts(
        self, quantity: OfContact | OfContacts, segment: Segment, t: float, row: Array, ways: Sequence[Way]
    ) -> Any:
        """Return a quantity of a contact, or an expression of such, with its derivatives along some ways."""
        of, y = _slopes(segment), row[: self.of.moved]
        if not segment.path.curved:  # the start of a straight step has no direction of slip yet
            t, y = segment.path.end, segment.path.states[-1, : of.moved]
        if isinstance(quantity, OfContacts):
            return value_along(of, segment.kernels, quantity, t, y, ways)
        check(of, quantity, t, y)
        terms = ((quantity.contact, quantity.what, quantity.component),)
        return quantities(of, segment.kernels, (terms,), t, y, ways)[terms]

    def _values(
        self, of: Slopes, quantity: Expression, times: Array, given: Array, function: str = "slope"
    ) -> Array:
        program = self._program(quantity)
        return at_states(program, function, times, given, program.constants(of.parameters))

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


def _ways(of: Slopes, row: Array) -> list[Way]:
    """Return the changes with each unknown of a state with its derivatives."""
    s = row[of.moved + 2 :].reshape(len(of.seeds), -1)
    return [(x, 0.0, dp) for x, dp in zip(s, of.seeds, strict=True)]


def _slopes(segment: Any) -> Slopes:
    """Return the derivatives with the values of the parameters in a phase."""
    return cast(Slopes, segment.path.slopes)
