"""The machine code of a model, compiled as it is asked for and kept for the next call.

    rates        q', u' and, where loads without potential or drives do work, the power P = W'
    energy       T and V                            (in one program with the rates, whose parts it shares)
    poses        position and rotation of every body
    reactions    force and moment of every joint
    expressions  whatever a user asks for: event functions, quantities to plot

The state of a run is y = (q, u) or (q, u, W).
"""

from __future__ import annotations

import io
import pickle
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...describe.constraints.constraint import Rolling
from ...describe.controller import Controller
from ...describe.description import changes_of
from ...describe.system import System
from ...describe.table import Changes
from ...dynamics import (
    State,
    coordinate_rates,
    kinetic_energy,
    mass_matrix,
    poses,
    potential_energy,
    traced_state,
)
from ...dynamics.constrained import condition_groups, independence, position_correction, speed_correction
from ...dynamics.constraints import linearized, rows
from ...dynamics.linear import Factorization, applied, products
from ...dynamics.mobility import check_bodies
from ...dynamics.motion import Motion, all_reactions, motion, total_power
from ...dynamics.unilateral import NEGLIGIBLE, margins, sizes
from ...errors import ModelError, SimulationError
from ...model import Model, assemble
from ...model.closure import Closure
from ...model.contact import Touching
from ...model.values import check_assumptions
from ...program.kernels import compile_tape
from ...program.large.tree_loop import LoopedSet, is_large
from ...scalar.algebra import divide
from ...scalar.trace import Tape
from ..ode.dense_output import Rates

Array = NDArray[np.float64]

LOOSE = 100
"""Multiple of an independent condition in a dependent one beyond which the latter is to take its place."""


@dataclass(frozen=True)
class Program:
    """A compiled set of functions of (t, y) and the parameters."""

    compiled: Any
    _last: list[tuple[bytes, Array]] = field(default_factory=list, compare=False)

    def address(self, name: str) -> int:
        return int(self.compiled[name].address)

    def outputs(self, name: str) -> int:
        return int(self.compiled[name].outputs)

    def constants(self, parameters: Array) -> Array:
        """What the kernels need of the parameters, computed once for a run; of the last ones it is kept."""
        key = parameters.tobytes()
        if not self._last or self._last[0][0] != key:
            made = np.ascontiguousarray(self.compiled.constants(parameters), dtype=float)
            self._last[:] = [(key, made)]
        return self._last[0][1].copy()


class Kernels:
    """Programs of one model."""

    def __init__(self, model: Model, active: tuple[int, ...] = ()) -> None:
        self.model = model
        self.active = active
        self._others: dict[tuple[int, ...], Kernels] = {}
        self._programs: dict[Any, Program] = {}
        self._work: bool | None = None
        self._names_dropped: tuple[str, ...] = ()
        self._defaults: dict[str, float] | None = None
        self._checked: dict[str, float] | None = None
        self.at_hand: dict[str, Any] = {}  # memory of those that build on these programs
        self._at: tuple[dict[str, float], Array, Rates] | None = None
        self.plain: dict[Any, Any] = {}  # runs for calls to come (`plain`)

    def __reduce__(self) -> Any:
        """The machine code stays: another process makes it anew, once for all that bring the same machine."""
        return _restored, (packed(self.model), self.active)

    def __deepcopy__(self, memo: Any) -> Kernels:
        return self  # functions of a model, which is never changed

    def holding(self, active: tuple[int, ...]) -> Kernels:
        """The programs of a constrained model with these independent conditions."""
        if active not in self._others:
            other = self._others[active] = Kernels(self.model, active)
            other._others = self._others
            other._programs |= {key: self._programs[key] for key in ("closing",) if key in self._programs}
        return self._others[active]

    @cached_property
    def works(self) -> bool:
        """Whether power goes in or out of the machine, so that the work is part of the state."""
        self.motion()
        assert self._work is not None
        return self._work

    @cached_property
    def operations(self) -> Mapping[str, int] | None:
        """Counts of operations of the rates; None where they are not known."""
        return getattr(self.motion().compiled["rates"], "operations", None)

    @cached_property
    def size(self) -> int:
        """Number of components of y."""
        return self.model.n_q + self.model.n_u + self.works

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the components of y."""
        work = ("work",) if self.works else ()
        return (*self.model.coordinate_names, *self.model.speed_names, *work)

    def values(self, given: Mapping[Any, Any] | None) -> dict[str, float]:
        """Values of all parameters by name (:meth:`Model.values`); the defaults are read once."""
        if given is not None and not (isinstance(given, Mapping) and not given):
            return self.model.values(given)
        if self._defaults is None:
            self._defaults = self.model.values()
        return dict(self._defaults)

    def check(self, values: Mapping[str, float]) -> None:
        """That the bodies can move (:func:`check_bodies`) and the assumptions hold, unless that was seen last time."""
        if self._checked != values:
            check_bodies(self.model, values)
            check_assumptions(self.model, values)
            self._checked = dict(values)

    def parameters(self, values: Mapping[str, float]) -> Array:
        """Values in the order of the model's parameters."""
        return np.array([values[parameter.name] for parameter in self.model.parameters], dtype=float)

    def _program(
        self, key: Any, functions: Callable[..., Mapping[str, Sequence[Any]]], inputs: int = 0
    ) -> Program:
        if key not in self._programs:
            tape = Tape()
            state = traced_state(self.model, tape)
            parameters = [state.values[parameter.symbol] for parameter in self.model.parameters]
            more = [tape.input(f"input {k}") for k in range(inputs)]
            given = {
                name: list(outputs)
                for name, outputs in (functions(state, more) if inputs else functions(state)).items()
            }
            compiled = compile_tape(tape, given, state.t, [*state.q, *state.u, *more], parameters)
            self._programs[key] = Program(compiled)
        return self._programs[key]

    def _large(self) -> Program | None:
        """The looped kernels of a large tree."""
        if "large" not in self._programs:
            if not is_large(self.model, "forward_dynamics"):
                return None
            looped = LoopedSet(self.model)
            self._work = looped.works
            self._programs["large"] = Program(looped)
        return self._programs["large"]

    def program(
        self, key: Any, functions: Callable[..., Mapping[str, Sequence[Any]]], inputs: int = 0
    ) -> Program:
        """Any functions of the state, compiled once under a key: named lists of outputs.

        With ``inputs``, so many numbers that follow the state in y are their second argument.
        """
        return self._program(key, functions, inputs)

    def _motion(self, state: State) -> Motion:
        return motion(self.model, state, self.active)

    def motion(self) -> Program:
        """Functions ``rates``, ``energy`` (kinetic, potential) and, of a constrained model, ``projection``, ``hold``
        (how well the conditions do) and ``dropped`` (residual and rate of the conditions that were redundant at the
        start)."""

        def functions(state: State) -> dict[str, Sequence[Any]]:
            moving = self._motion(state)
            power = total_power(self.model, state, moving)
            self._work = not _is_zero(power)
            rates = [*coordinate_rates(self.model, state), *moving.udot]
            energy = [kinetic_energy(self.model, state), potential_energy(self.model, state)]
            found: dict[str, Sequence[Any]] = {
                "rates": [*rates, power] if self._work else rates,
                "energy": energy,
            }
            if self.active:
                found["projection"] = self._projected(state)
                found["hold"] = [independence(self.model, state, self.active)]
            left = self._dropped(state)
            self._names_dropped = tuple(left)
            return {**found, "dropped": self._checked_conditions(state, left)} if left else found

        return self._programs.get("motion") or self._large() or self._program("motion", functions)

    def at(self, values: Mapping[str, float]) -> tuple[Array, Rates]:
        """Parameters in their order, and the right-hand side with the constants of them; the last ones are kept."""
        if self._at is None or self._at[0] != values:
            parameters = self.parameters(values)
            self._at = dict(values), parameters, self.rates(parameters)
        return self._at[1:]

    def rates(self, parameters: Array) -> Rates:
        """The right-hand side with the constants of these parameters."""
        program = self.motion()
        constants = program.constants(parameters)
        rates = Rates(
            program.address("rates"), self.size, constants, self.model.quaternions, program,
            recipe=(self.rates, parameters),
        )  # fmt: skip
        if not self.active:
            return rates
        projected = self.model.n_q + self.model.n_u
        return replace(rates, projection=program.address("projection"), projected=projected)

    def closing(self) -> Program:
        """Of a constrained model, for `gauss_newton`: ``conditions`` (residuals of all of them, their matrix G),
        ``motion`` (their rates, G, and the mass matrix M) and ``moved`` (q')."""

        def functions(state: State) -> dict[str, Sequence[Any]]:
            given = linearized(self.model, state)
            matrix = [x for row in given.matrix for x in row]
            mass = [x for row in mass_matrix(self.model, state) for x in row]
            return {
                "conditions": [*given.residual, *matrix],
                "motion": [*given.rate, *matrix, *mass],
                "moved": list(coordinate_rates(self.model, state)),
            }

        return self._program("closing", functions)

    @cached_property
    def on_speeds(self) -> tuple[int, ...]:
        """Of each condition, 1 if it is one on speeds only."""
        return tuple(int(row.on_speeds) for row in rows(self.model))

    @cached_property
    def dropped(self) -> tuple[str, ...]:
        """Conditions that were redundant at the start, less those that hold identically."""
        self.motion()
        return self._names_dropped

    def _dropped(self, state: State) -> dict[str, tuple[Any, Any]]:
        given = linearized(self.model, state)
        return {
            row.name: (given.residual[i], given.rate[i])
            for i, row in enumerate(rows(self.model))
            if i not in self.active and not (_is_zero(given.residual[i]) and _is_zero(given.rate[i]))
        }

    def _checked_conditions(self, state: State, left: Mapping[str, tuple[Any, Any]]) -> list[Any]:
        """Residuals of dropped conditions, and 1 where one is a large multiple of others that hold, else 0 or less."""
        matrix, kinds = linearized(self.model, state).matrix, rows(self.model)
        unit: dict[int, list[Any]] = {}
        for group in condition_groups(self.model):
            square = sum((x * x for i in group for x in matrix[i]), 0)
            size = 1 if _is_zero(square) else state.field.sqrt(square)
            unit |= {i: [divide(x, size) for x in matrix[i]] for i in group}
        held = [unit[i] for i in self.active]
        gram, most = Factorization(products(held, held)), 0
        for i, row in enumerate(kinds):
            if row.name in left:
                for part in gram.solve(applied(held, unit[i])):
                    most = state.field.apply("max", most, part * part)
        return [*(x for pair in left.values() for x in pair), state.field.apply("sign", most - LOOSE * LOOSE)]

    def _projected(self, state: State) -> list[Any]:
        """(q, u) moved onto the constraints, by one Newton step for q, then for u.

        A state after a step is off by the local error, so one step, whose error is the square of that, reaches
        round-off.
        """
        q = position_correction(self.model, state, self.active)
        there = State(self.model, state.field, state.t, q, state.u, state.values)
        return [*q, *speed_correction(self.model, there, self.active)]

    def poses(self) -> Program:
        """Function ``poses``: of each body, position (3) and rotation to ground axes (9, by rows)."""

        def functions(state: State) -> dict[str, Sequence[Any]]:
            postures = poses(self.model, state)
            return {
                "poses": [
                    x
                    for name in self.model.bodies
                    for x in (*postures[name].position, *(x for row in postures[name].rotation for x in row))
                ]
            }

        return self._large() or self._program("poses", functions)

    @property
    def transmitting(self) -> list[tuple[str, str, str]]:
        """(name, body acted on, point) of every reaction, in the order of :meth:`reactions`."""
        model = self.model
        result = [
            (name, joint.child, f"the point of joint '{name}' on '{joint.child}'")
            for name, joint in model.joints.items()
        ]
        for name, held in model.constraints.items():
            if isinstance(held, Closure):
                result.append((name, held.child.name, f"the point of joint '{name}' on '{held.child.name}'"))
            elif isinstance(held, Rolling):
                result.append((name, held.center.body.name, f"the centre of the wheel of '{name}'"))
            elif isinstance(held, Touching):
                result.append((name, held.contact.feature.body.name, f"the point of contact '{name}'"))
        return result

    def reactions(self) -> Program:
        """Function ``reactions``: of each joint, force (3) and moment (3)."""

        def functions(state: State) -> dict[str, Sequence[Any]]:
            moving = self._motion(state)
            found = all_reactions(self.model, state, moving)
            return {
                "reactions": [x for name in found for vector in found[name] for x in vector],
                "multipliers": list(moving.multipliers),
            }

        if self._large() is not None:
            if "large reactions" not in self._programs:
                self._programs["large reactions"] = Program(LoopedSet(self.model, "reactions"))
            return self._programs["large reactions"]
        return self._program("reactions", functions)

    def limits(self) -> Program:
        """Function ``limits``: what is left to each limit of a one-sided constraint, and then the same with what is
        negligible of the forces added."""
        return self._program("limits", lambda state: {"limits": self._limits(state, self._motion(state))})

    def _limits(self, state: State, moving: Motion) -> list[Any]:
        left = margins(self.model, state, moving.multipliers)
        size = sizes(self.model, state, self.active)
        return [*left, *(a + NEGLIGIBLE * b for a, b in zip(left, size, strict=True))]

    def expressions(self, given: Sequence[Any]) -> Program:
        """Function ``values`` of expressions of the model's names."""
        return self._program(("values", tuple(given)), lambda state: {"values": [state(e) for e in given]})


def _is_zero(value: Any) -> bool:
    return isinstance(value, int | Fraction) and value == 0


class _Packer(pickle.Pickler):
    """What a motion needs of a model, which calls no controller any more."""

    def reducer_override(self, value: Any) -> Any:
        if isinstance(value, Controller):
            try:
                pickle.dumps(value.function)
            except (pickle.PicklingError, AttributeError, TypeError):
                return type(value), (value.name, _Lost(value.name), value.period, value.inputs, value.sensors)
        return NotImplemented


@dataclass(frozen=True)
class _Lost:
    """In the place of a controller's function that stayed in another process."""

    name: str

    def __call__(self, *_: Any) -> Any:
        raise SimulationError(
            f"Expected the function of controller '{self.name}', but it stayed in the process that made this motion: "
            "it is no function of a module. Describe the machine here to simulate it again."
        )


def packed(model: Model) -> bytes:
    """A model for another process."""
    stream = io.BytesIO()
    _Packer(stream, pickle.HIGHEST_PROTOCOL).dump(model)
    return stream.getvalue()


@lru_cache(maxsize=16)
def _unpacked(data: bytes) -> Kernels:
    return Kernels(pickle.loads(data))


def _restored(data: bytes, active: tuple[int, ...]) -> Kernels:
    whole = _unpacked(data)
    return whole.holding(active) if active else whole


_KEPT = 16
_recent: OrderedDict[int, tuple[Any, Changes, int, Kernels]] = OrderedDict()


def kernels_of(machine: System | Model) -> Kernels:
    """The programs of a system as it is described now, or of a model; those used last are kept."""
    known = _recent.get(id(machine))
    if known is not None and known[1].count == known[2]:
        _recent.move_to_end(id(machine))
        return known[3]
    if not isinstance(machine, (System, Model)):
        raise ModelError(
            f"Expected a System or a Model to simulate, got {machine!r}. "
            "A machine is described first: s = fb.System('name')."
        )
    if isinstance(machine, System):
        kernels, changes = Kernels(assemble(machine)), changes_of(machine)
    else:
        kernels, changes = Kernels(machine), Changes()
    _recent[id(machine)] = (machine, changes, changes.count, kernels)
    while len(_recent) > _KEPT:
        _recent.popitem(last=False)
    return kernels
