"""Derivatives of a motion with contacts, read by the names of quantities and unknowns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
import sympy

from ....errors import NoDerivativesError, SimulationError
from ....model import Model
from ....scalar.algebra import Expression
from ...ending import End
from ...events import event_run
from ...kernels.methods import check_method_of_phases
from ...kernels.sides import sides_of, switching_contacts
from ...legs.blow import blows_of
from ...legs.blow_slopes import check_blow
from ...legs.sensitivity import (
    Derivatives,
    Sensitivity,
    check_sensitive,
    check_start,
    slopes_of,
)
from ...legs.switch_slopes import CURE
from ...legs.variation import Unknown, Variation, unknowns_of
from ...ode.dense_output import Array
from ...request import Problem, Request, problem_of
from ...start.start_sensitivity import start_slopes
from ...trajectory.computed_motion import ComputedMotion
from ...trajectory.in_legs import phases_of
from ...trajectory.progress import Progress
from ...trajectory.trajectory import Trajectory
from ..course import Touching
from ..history import History
from ..motion import touching_motion_of
from .following import Followed, follow
from .numbers import SAME, TouchingNumbers
from .slopes import Slopes, turned_points

CURE_OF_MACHINES = "Take differences of runs with values= that differ."


def check_derivable(request: Request) -> None:
    """Refuse motions without derivatives, with contacts or without."""
    (check_touching if request.in_phases else check_sensitive)(request)


def check_touching(request: Request) -> None:
    """Refuse machines whose contacts have laws without derivatives here."""
    model, blows = request.model, blows_of(request.impulses)
    if model.patches and model.switched:
        raise NoDerivativesError(
            "Expected contacts of points, edges and round shapes for sensitivities= beside signals and controllers, "
            f"but faces of solids touch in '{model.name}'. {CURE_OF_MACHINES}"
        )
    for contact in switching_contacts(model):
        laws = contact.friction, contact.static_friction, contact.normal_force
        if any(isinstance(law, sympy.Basic) and law.has(sympy.sign) for law in laws):
            raise NoDerivativesError(
                f"Expected laws of contacts that do not jump for sensitivities=, but that of '{contact.owner}' has a "
                f"sign(...), where the rates jump. Write tanh(x/width) for sign(x). Or t{CURE_OF_MACHINES[1:]}"
            )
    check_start(request)
    if not model.contacts:
        check_method_of_phases(
            request.method, request.step, "sensitivities= beside signals, controllers or blows"
        )
    for blow in blows:
        check_blow(blow)


def check_sizes(model: Model, unknowns: Sequence[Unknown]) -> None:
    """Refuse unknowns that are sizes of solids whose faces touch: their corners are data of the phases."""
    shapes = {shape for pair in model.patches for shape in (pair.whole.feature, pair.whole.surface)}
    for shape in shapes:
        used = {
            symbol for corner in shape.corners for x in corner for symbol in sympy.sympify(x).free_symbols
        }
        for unknown in unknowns:
            if unknown.symbol in used:
                raise NoDerivativesError(
                    f"Expected unknowns that are no sizes of solids whose faces touch, but '{unknown.name}' is one of "
                    f"the {shape.kind} of {shape.body!r}. {CURE_OF_MACHINES}"
                )


def check_rings(history: History) -> None:
    """Refuse a disk that lies flat and tips, or slides on points that have turned with the load.

    What sticks moves as if the points were anywhere: their angle has no derivative that counts.
    """
    it, model = history.work.it, history.work.model
    for kind, marks, numbers in history.entries(event_run.NOTE) if it.rings else ():
        if kind == event_run.NOTE and event_run.TIPS in marks[5 + it.contacts :: 4]:
            raise _no_rings(model, "tips", float(numbers[0]))
    for segment in history.path.segments if it.rings else ():
        turned = [] if segment.parameters is None else turned_points(model, segment.parameters)
        for points in turned:
            if any(segment.modes[k].startswith("slip") for k in points):
                raise _no_rings(model, "slides on points that have turned with the load", segment.path.start)


def _no_rings(model: Model, what: str, t: float) -> NoDerivativesError:
    return NoDerivativesError(
        f"A disk of '{model.name}' that lies flat {what} at t = {t:.9g} s, and a motion has no derivatives here beyond "
        f"that. {CURE_OF_MACHINES}"
    )


def refuse_dips(trajectory: Trajectory, problem: Problem, between: Progress) -> None:
    """Refuse a motion whose steps, which keep no sides, pass a switch of a law that jumps without a sign of it.

    The motion with sides tells. Controllers, whose functions remember, are not called again for it.
    """
    sides = sides_of(problem.kernels)
    if sides is None or not any(law.jumps for law in sides.laws) or problem.model.controllers:
        return
    found, parameters = touching_motion_of(problem, between)[0], problem.kernels.parameters(problem.numbers)
    both = phases_of(trajectory).segments, phases_of(found).segments
    for t, text in sides.unseen(*both, parameters, SAME * (problem.end - problem.begin)):
        raise NoDerivativesError(
            f"The motion has no derivatives by the unknowns of sensitivities= after t = {t:.9g} s, where a law "
            f"switches as {text} passes zero: its steps do not see it. {CURE}"
        )


def sensitive_touching_motion(request: Request) -> Trajectory:
    """Return the motion of a machine with contacts, with its derivatives.

    Raises
    ------
    SimulationError
        A motion that cannot be continued, or that has no derivatives.
    """
    check_touching(request)
    problem = problem_of(request)
    kernels, model, numbers = problem.kernels, problem.model, problem.numbers
    unknowns = unknowns_of(model, request.sensitivities, request.initial or {}, "sensitivities")
    check_sizes(model, unknowns)
    shifts = np.array(
        [slopes_of(model, unknowns, numbers, moment) for moment in (request.start, request.until)]
    )
    if shifts[0].any():
        raise SimulationError(
            f"Expected a start at a fixed time for sensitivities= with contacts, got start={request.start!r}, which "
            "depends on an unknown."
        )
    first = start_slopes(
        kernels, unknowns, problem.state, numbers, request.initial or {}, request.near or {}, problem.begin
    )
    slopes, variation = Slopes(kernels, unknowns, kernels.parameters(numbers)), Variation(kernels, unknowns)
    with problem.progress() as between:
        trajectory, history = touching_motion_of(problem, between, sided=False)
        if trajectory.path.status == End.INTERRUPTED:
            return trajectory
        refuse_dips(trajectory, problem, between)
        check_rings(history)
        followed = follow(slopes, history, problem, first[:, : slopes.moved], between)
    course = cast(Touching, trajectory.course)
    trajectory.course = replace(course, derivatives=TouchingDerivatives(variation, shifts, followed))
    return trajectory


@dataclass(frozen=True, eq=False)
class TouchingDerivatives(Derivatives):
    """What gives the derivatives of a motion with contacts."""

    followed: Followed

    def of(self, motion: ComputedMotion) -> TouchingSensitivity:
        """Return the derivatives of a motion."""
        numbers = TouchingNumbers(motion, self.shifts, self.followed)
        return TouchingSensitivity(motion, self.variation, numbers)


class TouchingSensitivity(Sensitivity):
    """Derivatives of a motion with contacts.

    :meth:`times` also takes the name of a contact: of the times at which its mode ends, since its gap closes, its force
    falls to zero, or its slip begins or ends.
    """

    numbers: TouchingNumbers

    def _of_expression(self, quantity: Expression) -> Array:
        return self.numbers.slopes(quantity, self._trajectory.t)

    def _of_component(self, name: str) -> Array:
        states, n = self.numbers.states, len(self._trajectory.names)
        return np.asarray(states[:, n + 2 + self._trajectory.names.index(name) :: n])

    def _with_times(self) -> list[str]:
        return [
            *super()._with_times(),
            *(contact.name for contact in self._trajectory.kernels.model.contacts),
        ]

    def _of_times(self, name: str) -> list[Array]:
        if name in super()._with_times():
            return super()._of_times(name)
        return [x.slopes for x in self.numbers.followed.happened if x.contact == name]
