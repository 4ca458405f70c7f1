"""Derivatives of a motion by parameters and initial values: the variational equations, integrated with the motion.

    y' = f(t, y, p),    s_j = ∂y/∂p_j:    s_j' = (∂f/∂y) s_j + ∂f/∂p_j,    s_j(t₀) = ∂y₀/∂p_j - f ∂t₀/∂p_j

The s_j are components of the state: step-size control covers them, with the same tolerance, |error| <= ε (1 + |s|). The
four components of a quaternion have derivatives tangent to the unit sphere: e · ∂e/∂p = 0.

`variation` has the equations, `start_sensitivity` the s_j at the start, `number_derivatives` what becomes of extremes,
ends and times of events.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section I.14.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from ...errors import SimulationError, nearest
from ...model import Model
from ...scalar.algebra import Expression, floats
from ...scalar.expression import evaluate
from ..ending import FAILED, End
from ..kernels.methods import FINE
from ..kernels.program import at_state
from ..kernels.reading import expression_of
from ..ode.dense_output import Path, Rates
from ..ode.integration import Integration
from ..ode.layout import EXPLICIT
from ..request import Problem, Request, problem_of
from ..start.arguments import most_steps
from ..start.start_sensitivity import start_slopes
from ..trajectory.computed_motion import ComputedMotion
from ..trajectory.event import EventSpec, watching
from ..trajectory.in_legs import InLegs
from ..trajectory.outputs import outputs_of
from ..trajectory.phases import joined
from ..trajectory.progress import Progress
from ..trajectory.trajectory import Trajectory
from .failure import failure
from .number_derivatives import NumberDerivatives, Numbers
from .sided_variation import SidedVariation
from .switch_slopes import check_others, least_rate, passed, switching_laws
from .variation import Unknown, Variation, unknowns_of

Array = NDArray[np.float64]


def check_sensitive(request: Request) -> None:
    """Refuse motions without variational equations."""
    method = request.method
    allowed = ("auto", *EXPLICIT, "gauss", "taylor")
    if method not in allowed:
        raise SimulationError(
            f"Expected one of {', '.join(map(repr, allowed))} for sensitivities=, got method={method!r}."
        )
    check_start(request)


def check_start(request: Request) -> None:
    """Refuse a start that is moved onto the constraints."""
    if request.model.constraints and request.project:
        raise SimulationError(
            "Expected a start on the constraints for sensitivities=, got project=True, which moves named values. "
            "Name fewer coordinates and speeds: the others follow."
        )


def slopes_of(
    model: Model, unknowns: Sequence[Unknown], numbers: Mapping[str, float], value: Expression
) -> list[float]:
    """Return the derivatives of a time that may be an expression of parameters."""
    expression = expression_of(model, value, "a time")
    if not isinstance(expression, sympy.Basic):
        return [0.0] * len(unknowns)
    lookup = {parameter.symbol: numbers[parameter.name] for parameter in model.parameters}
    return [
        0.0 if x.symbol is None else float(evaluate(sympy.diff(expression, x.symbol), lookup, floats))
        for x in unknowns
    ]


def sensitive_motion(request: Request) -> Trajectory:
    """Return the motion with its derivatives.

    Raises
    ------
    SimulationError
        A motion without variational equations, or one that cannot be continued.
    """
    problem = problem_of(request)
    with problem.progress() as between:
        trajectory = _sensitive_motion(problem, between)
    if trajectory.path.status in FAILED:
        raise failure(trajectory, trajectory.path, problem.kernels, problem.end, problem.specs)
    return trajectory


def _sensitive_motion(problem: Problem, between: Progress) -> Trajectory:
    p, request, kernels, model = problem, problem.request, problem.kernels, problem.model
    method, initial, begin = request.method, request.initial or {}, problem.begin
    check_sensitive(request)
    variation = Variation(kernels, unknowns_of(model, request.sensitivities, initial, "sensitivities"))
    program, parameters = variation.program(), kernels.parameters(p.numbers)
    # times that depend on parameters
    shifts = np.array(
        [slopes_of(model, variation.unknowns, p.numbers, moment) for moment in (request.start, request.until)]
    )
    rows = start_slopes(kernels, variation.unknowns, p.state, p.numbers, initial, request.near or {}, begin)
    n, k = kernels.size, len(variation.unknowns)
    y = np.concatenate([p.state, np.zeros(n - p.state.size), rows.ravel()])
    if method == "auto":
        method = "gauss" if np.min(p.tolerances, initial=1.0) < FINE else "dop853"
    rates = variation.rates(parameters, method)
    if shifts[0].any():
        f = at_state(program, "rates", begin, y, program.constants(parameters))[:n]
        y[n:] -= np.outer(shifts[0], f).ravel()
    relative, absolute = np.tile(p.tolerances, 1 + k), np.tile(p.tolerances, 1 + k)
    if kernels.works:
        first = at_state(program, "energy", begin, y, rates.constants)
        energy = float(np.max(np.abs(first)))
        absolute[n - 1 :: n] *= energy if 0 < energy < math.inf else 1.0
    make = _Legs(problem, variation, parameters, method, between, absolute)
    paths = make.paths(y, rates, relative)
    return Trajectory(
        *p.outcome(joined(paths, kernels)), course=InLegs(derivatives=Derivatives(variation, shifts))
    )


@dataclass(frozen=True, eq=False)
class _Legs:
    """The legs of a run with derivatives, between the switches of loads."""

    problem: Problem
    variation: Variation
    parameters: Array
    method: str
    between: Progress
    absolute: Array

    def paths(self, y: Array, rates: Rates, relative: Array) -> list[Path]:
        """Return the paths of all legs from a state with its derivatives; ``rates`` are those without switches."""
        p = self.problem
        found = switching_laws(self.variation, self.parameters)
        if found is None:
            watch = watching(p.kernels, self.parameters, p.specs, p.expressions)
            return [self.way(rates, watch, relative).path(y, p.begin, p.end, self.absolute, self.between)]
        paths = list[Path]()
        try:
            self.go_on(y, relative, len(found.texts), paths)
        except KeyboardInterrupt:  # between two legs
            if not paths:
                raise
            paths[-1].status = End.INTERRUPTED
        for path in paths:
            path.crossings = tuple(x for x in path.crossings if x.number < len(p.specs))
        return paths

    def go_on(self, y: Array, relative: Array, laws: int, paths: list[Path]) -> None:
        """Append the paths of all legs, which end where one of so many laws switches."""
        p, n, t = self.problem, self.problem.kernels.size, self.problem.begin
        sided, count = SidedVariation(p.kernels, self.variation.unknowns), len(p.specs)
        signs = self.signs(sided, y, laws)
        while True:
            constants, rates = sided.at(self.parameters, signs, self.method)
            way = self.way(rates, sided.watching(p.specs, p.expressions, constants), relative)
            paths.append(way.path(y, t, p.end, self.absolute, self.between))
            last = paths[-1]
            if last.status != End.TERMINAL or last.crossings[-1].number < count:
                return
            law, side = last.crossings[-1].number - count, last.crossings[-1].sign
            t, y = last.end, last.states[-1].copy()
            if side == -signs[law]:
                now, before = sided.laws(constants), rates.at(t, y)[:n]
                signs[law] = side
                after = sided.at(self.parameters, signs, self.method)[1].at(t, y)[:n]
                least = least_rate(now, law, last.times, last.states, float(p.tolerances.max(initial=0.0)))
                tau, jump = passed(now, law, (t, y, y[n:].reshape(-1, n), side), (before, after), least)
                for j, one in enumerate(tau):
                    y[n * (1 + j) : n * (1 + j) + now.moved] += jump * one

    def way(self, rates: Rates, watch: Any, relative: Array) -> Integration:
        """Return how a leg is integrated."""
        request = self.problem.request
        return Integration(
            rates, relative, watch, method=self.method, step=request.step,
            max_step=request.longest_step, max_steps=most_steps(request.max_steps, rates.size + 2),
        )  # fmt: skip

    def signs(self, sided: SidedVariation, y: Array, count: int) -> Array:
        """Return the sign of each law at the start: that of e, or of its rate where e is zero."""
        t, n = self.problem.begin, self.problem.kernels.size
        signs = np.ones(count)
        for _ in range(2):  # an e that is zero has a rate, which may depend on other signs
            constants, rates = sided.at(self.parameters, signs, self.method)
            laws, f = sided.laws(constants), rates.at(t, y)[:n]
            rows = laws.at(t, y)
            speeds = rows[:, 1] + rows[:, 2 : 2 + laws.moved] @ f[: laws.moved]
            signs = np.where(rows[:, 0] != 0, np.sign(rows[:, 0]), np.where(speeds < 0, -1.0, 1.0))
        check_others(laws, -1, t, y, y[n:].reshape(-1, n), f)
        return signs


@dataclass(frozen=True, eq=False)
class Derivatives:
    """What gives the derivatives of a motion.

    ``shifts``   derivatives of the start and of the end of the run by the unknowns, shape (2, unknowns)
    """

    variation: Variation
    shifts: Array

    def of(self, motion: ComputedMotion) -> Sensitivity:
        """Return the derivatives of a motion."""
        return Sensitivity(motion, self.variation, NumberDerivatives(motion, self.variation, self.shifts))


class Sensitivity(Mapping[Any, Array]):
    """Derivatives of a motion by its unknowns, parameters and initial values.

    ``trajectory.sensitivity["theta", "m"]`` is ∂theta/∂m at the output times; the first may be any coordinate, speed,
    energy or expression of the machine's names, whose own dependence on the parameter counts.
    ``["max(theta)", "m"]``, and likewise min, range, initial and final, is the derivative of that number.
    :meth:`times` has derivatives of times of events. Iterates over coordinates and speeds.
    """

    numbers: Numbers

    def __init__(self, trajectory: ComputedMotion, variation: Variation, numbers: Numbers) -> None:
        self._trajectory, self.variation, self.numbers = trajectory, variation, numbers
        self.unknowns = tuple(unknown.name for unknown in variation.unknowns)

    def __getitem__(self, key: Any) -> Any:
        if not isinstance(key, tuple) or len(key) != 2:
            raise SimulationError(f"Expected a quantity and an unknown, such as ['theta', 'm'], got {key!r}.")
        column = self._place(key[1])
        result = self.of(key[0])[..., column]
        return result if result.ndim else float(result)

    def of(self, quantity: Any) -> Array:
        """Return the derivatives of a quantity by all unknowns, shape (times, unknowns); (unknowns,) for a number of
        the whole run.

        Raises
        ------
        SimulationError
            An unknown name, or a number without a derivative, such as the greatest of two equal extremes.
        """
        trajectory = self._trajectory
        model = trajectory.kernels.model
        text = quantity if isinstance(quantity, str) else model.names.texts.get(quantity)
        if text in trajectory.names:
            return self._of_component(text)
        output = outputs_of(model, [quantity])
        for name, (how, place) in output.numbers.items():
            return self.numbers.number(how, output.reduced_values[place], name)
        return self.of_value(output.timed_values[0])

    def of_value(self, quantity: Expression) -> Array:
        """Return the derivatives of an expression, or of an energy by name, at the output times."""
        trajectory = self._trajectory
        texts = trajectory.kernels.model.names.texts
        text = texts.get(quantity) if isinstance(quantity, sympy.Basic) else None
        if text in trajectory.names:
            return self._of_component(text)
        return self._of_expression(quantity)

    def _of_expression(self, quantity: Expression) -> Array:
        """Return the derivatives of an expression, or of an energy by name."""
        trajectory = self._trajectory
        program = self.variation.expression(quantity)
        return trajectory._observed(program, "values", trajectory.t, trajectory.states)

    def _of_component(self, name: str) -> Array:
        """Return the derivatives of a coordinate or speed."""
        trajectory = self._trajectory
        n = trajectory.kernels.size
        return np.asarray(trajectory.states[:, n + trajectory.names.index(name) :: n])

    def times(self, event: Any, unknown: Any = None) -> Array:
        """Return the derivatives of the times of an event, one for each time it happened, shape (times, unknowns).

        With an ``unknown`` they are the derivatives by it, shape (times,).

        Parameters
        ----------
        event : str or EventSpec
            Name of the event.
        unknown : name, optional

        Raises
        ------
        SimulationError
            An event that only touches zero, so that its time has no derivative.

        Examples
        --------
        >>> import freebody as fb
        >>> s = fb.System("throw")
        >>> g = s.parameters(g=9.81)
        >>> s.gravity = (0, -g, 0)
        >>> rail = s.slider("rail", s.ground, s.body("stone", fb.particle(1)), axis="y", coordinate="y")
        >>> hit = fb.event("y", name="hit", direction=-1, terminal=True)
        >>> motion = fb.simulate(s, 9, initial={"y'": 4.905}, events=[hit], sensitivities=["y'"])
        >>> motion.sensitivity.times("hit", "y'").round(9)  # t = 2 v/g
        array([0.2038736])
        """
        names, name = self._with_times(), event.name if isinstance(event, EventSpec) else event
        if name not in names:
            cure = nearest(str(name), names) if names else "The run has no events=."
            raise SimulationError(f"Unknown event '{name}' in trajectory.sensitivity.times; {cure}")
        rows = self._of_times(name)
        result = np.array(rows).reshape(len(rows), len(self.unknowns))
        return result if unknown is None else result[:, self._place(unknown)]

    def _with_times(self) -> list[str]:
        """Return the names of what has times."""
        return [spec.name for spec in self._trajectory.specs]

    def _of_times(self, name: str) -> list[Array]:
        """Return the derivatives of each time of what has a name."""
        specs, crossings = self._trajectory.specs, self._trajectory.path.crossings
        return [self.numbers.event(x) for x in crossings if specs[x.number].name == name]

    def _place(self, unknown: Any) -> int:
        name = self._trajectory.kernels.model.names.text_of(unknown)
        if name not in self.unknowns:
            raise SimulationError(
                f"Unknown name '{name}' in trajectory.sensitivity; {nearest(name, self.unknowns)} "
                "Name it in sensitivities= of fb.simulate."
            )
        return self.unknowns.index(name)

    def __iter__(self) -> Any:
        return iter((name, unknown) for name in self._trajectory.names for unknown in self.unknowns)

    def __len__(self) -> int:
        return len(self._trajectory.names) * len(self.unknowns)

    def __repr__(self) -> str:
        names, by = ", ".join(self._trajectory.names), ", ".join(self.unknowns)
        return f"<Derivatives of {names} by {by} at {len(self._trajectory.t)} times>"
