"""The variational equations of a machine: programs of a motion together with its derivatives.

    y' = f(t, y, p),    s_j = ∂y/∂p_j:    s_j' = (∂f/∂y) s_j + ∂f/∂p_j

f and its derivatives along the s_j come from one trace and are one kernel.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section I.14.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from ...dynamics import State, kinetic_energy, potential_energy, traced_state
from ...dynamics.conditions.constrained import moved_onto
from ...dynamics.motion import all_reactions, motion, total_power
from ...errors import SimulationError, nearest
from ...model import Model
from ...program.kernels import compile_tape
from ...scalar.algebra import Expression, Scalar
from ...scalar.derivative import forward, reverse
from ...scalar.trace import CODES, Tape
from ..kernels.kernels import Kernels
from ..kernels.method_kernels import series_of
from ..kernels.methods import with_series
from ..kernels.program import Program
from ..kernels.switches import value_of
from ..ode.dense_output import Rates
from ..trajectory.outputs import OfReaction
from .switch_slopes import law_outputs

Array = NDArray[np.float64]
Functions = dict[str, Sequence[Scalar]]
"""Outputs by the name of a function."""


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
    parameters = {p.name: p.symbol for p in model.parameters}
    starts = model.state_names
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
            name = model.names.text_of(key)
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

    kind = "variation"

    def __init__(self, kernels: Kernels, unknowns: Sequence[Unknown]) -> None:
        self.kernels, self.unknowns = kernels, tuple(unknowns)

    @property
    def _names(self) -> tuple[str, ...]:
        """Names of the unknowns."""
        return tuple(unknown.name for unknown in self.unknowns)

    @property
    def size(self) -> int:
        """Number of components of the state and all derivatives."""
        return self.kernels.size * (1 + len(self.unknowns))

    def rates(self, parameters: Array, method: str) -> Rates:
        """Return the right-hand side of the state and all derivatives, for a method."""
        kernels, program = self.kernels, self.program()
        constants = program.constants(parameters)
        rates = Rates(program.address("rates"), self.size, constants, kernels.model.quaternions, program)
        if kernels.active:
            rates = replace(rates, projection=program.address("projection"), projected=self.size)
        if method == "taylor":
            rates = with_series(rates, self.series(), parameters, kernels)
        return replace(rates, recipe=(self.rates, parameters, method))

    def series(self) -> Program:
        """Return the function ``series`` of (y, s_1, s_2, ...): the coefficients of their Taylor series."""
        key = (self.kind, "series", self._names)
        programs = self.kernels.programs
        if key not in programs:
            tape, state, inputs, rates, parameters = self._rates()
            programs[key] = series_of(self.kernels.model, tape, rates, state.t, inputs, parameters)
        return programs[key]

    def _traced(self) -> tuple[Tape, State, list[Scalar], list[list[Scalar]], list[Scalar]]:
        """Return tape, state, y, the s_j, parameters."""
        model, tape = self.kernels.model, self._tape()
        state = traced_state(model, tape)
        y = [*state.q, *state.u]
        if self.kernels.works:
            y.append(tape.input("work done"))
        rows = [[tape.input(f"derivative {i} by {x.name}") for i in range(len(y))] for x in self.unknowns]
        return tape, state, y, rows, [state.values[p.symbol] for p in model.parameters]

    def _tape(self) -> Tape:
        """Return the tape of the programs."""
        return Tape()

    def _constants(self, tape: Tape) -> list[Scalar]:
        """Return the constants of a run that follow the parameters."""
        return []

    def _others(self, state: State) -> Functions:
        """Return further functions of the program."""
        return {}

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
        key = (self.kind, self._names)
        programs = self.kernels.programs
        if key not in programs:
            tape, state, inputs, rates, parameters = self._rates()
            n, model = self.kernels.size, self.kernels.model
            y, rows = inputs[:n], [inputs[k : k + n] for k in range(n, len(inputs), n)]
            functions: dict[str, Sequence[Any]] = {
                "rates": rates,
                "energy": [kinetic_energy(model, state), potential_energy(model, state)],
                **self._others(state),
            }
            if self.kernels.active:
                moved = moved_onto(self.kernels.model, state, self.kernels.active)
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
        rates = self._rates_of_state(state)
        along = self._along(tape, state, y, rows, rates)
        inputs = [*y, *(x for row in rows for x in row)]
        constants = [*parameters, *self._constants(tape)]
        return tape, state, inputs, [*rates, *(x for row in along for x in row)], constants

    def _rates_of_state(self, state: State) -> list[Scalar]:
        """Return y'."""
        return self.kernels.rates_of(state)

    def expression(self, quantity: Expression) -> Program:
        """Return the function ``values``: derivatives of an expression, or of an energy, by every unknown."""

        def functions(tape: Tape, state: State, y: list[Scalar], rows: list[list[Scalar]]) -> Functions:
            value = [self._value(quantity, state, y)]
            return {"values": [row[0] for row in self._along(tape, state, y, rows, value)]}

        return self._program("variation of", quantity, functions)

    def course(self, quantity: Expression) -> Program:
        """Return the functions ``course``: x and x' of a quantity x; ``slopes``: x, x', ∂x/∂y and Dx by every unknown.

        Dx = (∂x/∂y) s + ∂x/∂p is the derivative at a fixed time.
        """

        def functions(tape: Tape, state: State, y: list[Scalar], rows: list[list[Scalar]]) -> Functions:
            value = self._value(quantity, state, y)
            rates = self._rates_of_state(state)
            course = [value, *forward(tape, [value], [state.t, *y], [1, *rates])]
            along = [row[0] for row in self._along(tape, state, y, rows, [value])]
            return {"course": course, "slopes": [*course, *reverse(tape, value, y), *along]}

        return self._program("course of", quantity, functions)

    def switches(self) -> tuple[Program, tuple[str, ...]] | None:
        """Return the function ``switches`` and the texts of e for each jump of the rates where e passes zero, sign(e).

        The function gives e, its derivatives by t, by (q, u) and by the unknowns, and Σ |∂u'/∂sign(e)| for each; None
        if there is no jump.
        """
        operations = self.kernels.operations
        if operations is not None and "sign" not in operations:
            return None
        texts_key = f"switches {self._names}"
        model, texts = self.kernels.model, list[str]()

        def functions(state: State) -> dict[str, list[Scalar]]:
            tape = state.field
            assert isinstance(tape, Tape)
            udot = motion(model, state, self.kernels.active).udot
            signs = [i for i in tape.used(udot) if tape.op[i] == CODES["sign"]]
            pairs = [(tape.scalar(i), tape.scalar(tape.a[i])) for i in signs]
            texts.extend(str(tape.to_sympy(e)) for _, e in pairs)
            return {"switches": law_outputs(tape, state, udot, pairs, self.unknowns)}

        program = self.kernels.program(("switches", self._names), functions)
        self.kernels.cache.setdefault(texts_key, tuple(texts))
        texts_of_e: tuple[str, ...] = self.kernels.cache[texts_key]
        return (program, texts_of_e) if texts_of_e else None

    def _program(self, what: str, quantity: Expression, functions: Callable[..., Functions]) -> Program:
        """Return the program of functions of (y, s_1, s_2, ...), compiled once."""
        key = (what, self._names, quantity)
        programs = self.kernels.programs
        if key not in programs:
            tape, state, y, rows, parameters = self._traced()
            inputs = [*y, *(x for row in rows for x in row)]
            named = functions(tape, state, y, rows)
            programs[key] = Program(compile_tape(tape, named, state.t, inputs, parameters))
        return programs[key]

    def _value(self, quantity: Expression, state: State, y: list[Scalar]) -> Scalar:
        """Return an expression, one of `ENERGIES`, or a quantity of a reaction, of a state."""
        model = self.kernels.model
        if isinstance(quantity, OfReaction):
            moving = motion(model, state, self.kernels.active)
            force, moment = all_reactions(model, state, moving)[quantity.joint]
            return quantity.of(force if quantity.what == "force" else moment, state.field.sqrt)
        if not isinstance(quantity, str):
            return value_of(state, quantity)
        if quantity == "work":
            return y[-1] if self.kernels.works else 0
        if quantity == "work_rate":
            return total_power(model, state, motion(model, state, self.kernels.active))
        return energy_named(model, state, quantity)


def energy_named(model: Model, state: State, name: str) -> Scalar:
    """Return the kinetic or the potential energy, or their sum, by its name."""
    parts = {"kinetic_energy": kinetic_energy, "potential_energy": potential_energy}
    return sum((part(model, state) for one, part in parts.items() if name in (one, "energy")), 0)
