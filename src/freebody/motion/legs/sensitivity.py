"""Derivatives of a motion by parameters and initial values: the variational equations, integrated with the motion.

    y' = f(t, y, p),    s_j = ∂y/∂p_j:    s_j' = (∂f/∂y) s_j + ∂f/∂p_j,    s_j(t₀) = ∂y₀/∂p_j

f and its derivatives along the s_j come from one trace and are one kernel. The s_j are components of the state:
step-size control covers them, with the same tolerance, |error| <= ε (1 + |s|). The four components of a quaternion have
derivatives tangent to the unit sphere: e · ∂e/∂p = 0.

`start_sensitivity` computes the s_j at the start.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section I.14.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from ...dynamics import State, coordinate_rates, kinetic_energy, potential_energy, traced_state
from ...dynamics.motion import motion, total_power
from ...errors import ExpressionError, SimulationError, nearest
from ...model import Model
from ...program.kernels import compile_tape
from ...scalar.algebra import Expression, Scalar
from ...scalar.derivative import forward
from ...scalar.trace import Tape
from ..kernels.kernels import Kernels, Program
from ..kernels.method_kernels import series_of
from ..kernels.methods import FINE, with_series
from ..ode.dense_output import Rates, observe
from ..ode.integration import integrate
from ..start.arguments import most_steps
from ..start.start_sensitivity import start_slopes
from ..trajectory.event import EventSpec, watching
from ..trajectory.outputs import reduction
from ..trajectory.trajectory import Trajectory

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Unknown:
    """A parameter, or the initial value of a coordinate or speed (``place`` is its index in the state)."""

    name: str
    symbol: Any = None
    place: int = -1


def unknowns_of(model: Model, names: Any, initial: Mapping[Any, Any], what: str) -> tuple[Unknown, ...]:
    """Return parameters and initial values by name.

    Raises
    ------
    SimulationError
        An unknown name, a name given twice, or an initial value that is an expression of parameters.
    """
    if isinstance(names, str | sympy.Basic):
        names = [names]
    if not isinstance(names, Iterable) or isinstance(names, np.ndarray):
        raise SimulationError(f"Expected a list of names for {what}, got {names!r}.")
    texts = model.names.texts
    parameters = {p.name: p.symbol for p in model.parameters}
    starts = [*model.coordinate_names, *model.speed_names]
    result: list[Unknown] = []
    for key in names:
        name = model.names.text_of(key)
        if any(unknown.name == name for unknown in result):
            raise SimulationError(f"'{name}' is named twice in {what}. Leave one out.")
        if name in parameters:
            result.append(Unknown(name, parameters[name]))
        elif name in starts:
            result.append(Unknown(name, None, starts.index(name)))
        else:
            raise SimulationError(f"Unknown name '{name}' in {what}; {nearest(name, [*parameters, *starts])}")
    if not result:
        raise SimulationError(f"Expected at least one parameter or initial value in {what}, got none.")
    for unknown in result:
        for key, value in initial.items():
            name = key if isinstance(key, str) else texts.get(key, str(key))
            if name != unknown.name or unknown.symbol is not None:
                continue
            expression = model.names.expression(value, f"the initial value of '{name}'")
            if isinstance(expression, sympy.Basic) and expression.free_symbols:
                others = ", ".join(sorted(map(str, expression.free_symbols)))
                raise SimulationError(
                    f"Expected a number for the initial value of '{name}', since its derivative is asked for in "
                    f"{what}, got '{value}'. Ask for the derivatives by {others}."
                )
    return tuple(result)


class Variation:
    """The programs of a machine and of its variational equations."""

    def __init__(self, kernels: Kernels, unknowns: Sequence[Unknown]) -> None:
        self.kernels, self.unknowns = kernels, tuple(unknowns)

    @property
    def size(self) -> int:
        """Number of components of the state and all derivatives."""
        return self.kernels.size * (1 + len(self.unknowns))

    def rates(self, parameters: Array, method: str) -> Rates:
        """Return the right-hand side of the state and all derivatives, for a method."""
        kernels, program = self.kernels, self.program()
        rates = Rates(
            program.address("rates"),
            self.size,
            program.constants(parameters),
            kernels.model.quaternions,
            program,
        )
        if kernels.active:
            rates = replace(rates, projection=program.address("projection"), projected=self.size)
        if method == "taylor":
            rates = with_series(rates, self.series(), parameters, kernels)
        return replace(rates, recipe=(self.rates, parameters, method))

    def series(self) -> Program:
        """Return the function ``series`` of (y, s_1, s_2, ...): the coefficients of their Taylor series."""
        key = ("variation series", tuple(unknown.name for unknown in self.unknowns))
        programs = self.kernels._programs
        if key not in programs:
            tape, state, inputs, rates, parameters = self._rates()
            programs[key] = series_of(self.kernels.model, tape, rates, state.t, inputs, parameters)
        return programs[key]

    def _traced(self) -> tuple[Tape, State, list[Scalar], list[list[Scalar]], list[Scalar]]:
        """Return tape, state, y, the s_j, parameters."""
        model, tape = self.kernels.model, Tape()
        state = traced_state(model, tape)
        y = [*state.q, *state.u]
        if self.kernels.works:
            y.append(tape.input("work done"))
        rows = [[tape.input(f"derivative {i} by {x.name}") for i in range(len(y))] for x in self.unknowns]
        return tape, state, y, rows, [state.values[p.symbol] for p in model.parameters]

    def _along(
        self, tape: Tape, state: State, y: list[Scalar], rows: list[list[Scalar]], outputs: Sequence[Scalar]
    ) -> list[list[Scalar]]:
        """Return the derivatives of outputs by every unknown."""
        result = []
        for unknown, row in zip(self.unknowns, rows, strict=True):
            inputs, seeds = list(y), list(row)
            if unknown.symbol is not None:
                inputs.append(state.values[unknown.symbol])
                seeds.append(1)
            result.append(forward(tape, outputs, inputs, seeds))
        return result

    def program(self) -> Program:
        """Return the functions ``rates`` of (y, s_1, s_2, ...) and ``energy``.

        For constrained machines ``projection`` moves y onto the constraints, and the s_j onto the linearized ones.
        """
        key = ("variation", tuple(unknown.name for unknown in self.unknowns))
        programs = self.kernels._programs
        if key not in programs:
            tape, state, inputs, rates, parameters = self._rates()
            n, model = self.kernels.size, self.kernels.model
            y, rows = inputs[:n], [inputs[k : k + n] for k in range(n, len(inputs), n)]
            functions: dict[str, Sequence[Any]] = {
                "rates": rates,
                "energy": [kinetic_energy(model, state), potential_energy(model, state)],
            }
            if self.kernels.active:
                moved = self.kernels._projected(state)
                if self.kernels.works:
                    moved = [*moved, y[-1]]
                functions["projection"] = [
                    *moved, *(x for row in self._along(tape, state, y, rows, moved) for x in row)
                ]  # fmt: skip
            programs[key] = Program(compile_tape(tape, functions, state.t, inputs, parameters))
        return programs[key]

    def _rates(self) -> tuple[Tape, State, list[Scalar], list[Scalar], list[Scalar]]:
        """Return tape, state, (y, s_1, s_2, ...), their rates, parameters."""
        tape, state, y, rows, parameters = self._traced()
        model = self.kernels.model
        moving = motion(model, state, self.kernels.active)
        rates = [*coordinate_rates(model, state), *moving.udot]
        if self.kernels.works:
            rates.append(total_power(model, state, moving))
        along = self._along(tape, state, y, rows, rates)
        inputs = [*y, *(x for row in rows for x in row)]
        return tape, state, inputs, [*rates, *(x for row in along for x in row)], parameters

    def expression(self, expression: Expression) -> Program:
        """Return the function ``values``: derivatives of an expression by every unknown."""
        key = ("variation of", tuple(unknown.name for unknown in self.unknowns), expression)
        programs = self.kernels._programs
        if key not in programs:
            tape, state, y, rows, parameters = self._traced()
            value = [state(expression)]
            functions = {"values": [row[0] for row in self._along(tape, state, y, rows, value)]}
            inputs = [*y, *(x for row in rows for x in row)]
            programs[key] = Program(compile_tape(tape, functions, state.t, inputs, parameters))
        return programs[key]


METHODS = ("auto", "dop853", "dop54", "gauss", "taylor")


def sensitive_motion(
    kernels: Kernels,
    numbers: Mapping[str, float],
    unknowns: Any,
    initial: Mapping[Any, Any],
    near: Mapping[Any, Any],
    state: Array,
    begin: float,
    end: float,
    specs: Sequence[EventSpec],
    expressions: Sequence[Expression],
    tolerances: Array,
    times: Any,
    samples: int | None,
    *,
    method: str,
    step: float | None,
    max_step: float | None,
    max_steps: int | None,
    project: bool,
    between: Any,
) -> SensitiveTrajectory:
    """Return the motion with its derivatives; arguments as of :func:`freebody.simulate`, checked."""
    model = kernels.model
    if model.contacts:
        raise SimulationError(
            f"Expected a machine without contacts for sensitivities=, but '{model.name}' has "
            f"{', '.join(map(repr, model.contacts))}: their events move with the parameters."
        )
    if method not in METHODS:
        raise SimulationError(
            f"Expected one of {', '.join(map(repr, METHODS))} for sensitivities=, got method={method!r}."
        )
    variation = Variation(kernels, unknowns_of(model, unknowns, initial, "sensitivities"))
    program, parameters = variation.program(), kernels.parameters(numbers)
    if model.constraints and project:
        raise SimulationError(
            "Expected a start on the constraints for sensitivities=, got project=True, which moves named values. "
            "Name fewer coordinates and speeds: the others follow."
        )
    rows = start_slopes(kernels, variation.unknowns, state, numbers, initial, near, begin)
    n, k = kernels.size, len(variation.unknowns)
    y = np.concatenate([state, np.zeros(n - state.size), rows.ravel()])
    if method == "auto":
        method = "gauss" if np.min(tolerances, initial=1.0) < FINE else "dop853"
    rates = variation.rates(parameters, method)
    relative, absolute = np.tile(tolerances, 1 + k), np.tile(tolerances, 1 + k)
    if kernels.works:
        first = observe(program.address("energy"), 2, np.array([begin]), y[None], rates.constants)[0]
        energy = float(np.max(np.abs(first)))
        absolute[n - 1 :: n] *= energy if 0 < energy < math.inf else 1.0
    watch = watching(kernels, parameters, specs, expressions)
    path = integrate(
        rates, y, begin, end, relative=relative, absolute=absolute, watch=watch, method=method, step=step,
        max_step=math.inf if max_step is None else float(max_step), max_steps=most_steps(max_steps, y.size + 2),
        between=between,
    )  # fmt: skip
    return SensitiveTrajectory(variation, kernels, numbers, path, specs, tolerances, times, samples)


class SensitiveTrajectory(Trajectory):
    """A trajectory with derivatives by parameters and initial values.

    ``trajectory.sensitivity["theta", "m"]`` is ∂theta/∂m at the output times; the first may be any coordinate, speed or
    expression of the machine's names, whose own dependence on the parameter counts.
    """

    def __init__(self, variation: Variation, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.variation = variation

    @cached_property
    def sensitivity(self) -> Sensitivity:
        """Derivatives at the output times, by (quantity, parameter or initial value)."""
        return Sensitivity(self)


class Sensitivity(Mapping[Any, Array]):
    """Derivatives of quantities by unknowns at the output times; iterates over coordinates and speeds."""

    def __init__(self, trajectory: SensitiveTrajectory) -> None:
        self._trajectory = trajectory
        self.unknowns = tuple(unknown.name for unknown in trajectory.variation.unknowns)

    def __getitem__(self, key: Any) -> Array:
        if not isinstance(key, tuple) or len(key) != 2:
            raise SimulationError(f"Expected a quantity and an unknown, such as ['theta', 'm'], got {key!r}.")
        column = self._place(key[1])
        trajectory = self._trajectory
        model = trajectory.kernels.model
        text = key[0] if isinstance(key[0], str) else model.names.texts.get(key[0])
        n = trajectory.kernels.size
        if text in trajectory.names:
            return trajectory.states[:, n * (1 + column) + trajectory.names.index(text)]
        return self.of(key[0])[:, column]

    def of(self, quantity: Any) -> Array:
        """Return the derivatives of a quantity by all unknowns, shape (times, unknowns)."""
        trajectory = self._trajectory
        model = trajectory.kernels.model
        text = quantity if isinstance(quantity, str) else model.names.texts.get(quantity)
        n, k = trajectory.kernels.size, len(self.unknowns)
        if text in trajectory.names:
            i = trajectory.names.index(text)
            return trajectory.states[:, [n * (1 + j) + i for j in range(k)]]
        if isinstance(quantity, str) and reduction(quantity)[0]:
            raise SimulationError(
                f"Expected a quantity over time for trajectory.sensitivity, got '{quantity}', one number of the whole "
                "run. Ask for the quantity itself. At its greatest or smallest value inside the run, its derivative is "
                "the derivative of that number."
            )
        try:
            expression = model.names.expression(quantity, "trajectory.sensitivity[...]")
        except ExpressionError as error:
            raise SimulationError(
                f"Expected a coordinate, a speed or an expression of them. {error}"
            ) from None
        program = trajectory.variation.expression(expression)
        return trajectory._observed(program, "values", trajectory.t, trajectory.states)

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
