"""The compiled functions of a model. Each is compiled at its first use and reused by later calls.

    rates        q', u' and, if drives or loads without a potential do work, the power P = W'
    energy       T and V                            (compiled together with the rates, whose expressions it shares)
    poses        position and rotation of every body
    reactions    force and moment of every joint
    expressions  any expression of the user: event functions, quantities to plot

The state of a run is y = (q, u) or (q, u, W).
"""

from __future__ import annotations

import io
import pickle
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ...describe.controller import Controller
from ...describe.description import changes_of
from ...describe.system import System
from ...describe.table import Changes
from ...dynamics import (
    State,
    coordinate_rates,
    kinetic_energy,
    poses,
    potential_energy,
    traced_state,
)
from ...dynamics.composite import mass_diagonal
from ...dynamics.conditions.constrained import (
    articulated_diagonal,
    independence,
    least_speed_change,
    moved_onto,
)
from ...dynamics.conditions.constraints import rows
from ...dynamics.conditions.linearized import linearized
from ...dynamics.conditions.mobility import check_bodies
from ...dynamics.conditions.unilateral import NEGLIGIBLE, margins, sizes
from ...dynamics.linear import Selection, entries
from ...dynamics.motion import Motion, all_reactions, motion, total_power
from ...errors import ModelError, SimulationError
from ...model import Model, assemble
from ...model.family import unrolled
from ...model.values import check_assumptions
from ...program.kernels import compile_tape
from ...program.large.tree_loop import LoopedSet, is_large
from ...scalar.algebra import Expression, Scalar, is_always_zero
from ...scalar.trace import Tape
from ..ode.dense_output import Rates
from .program import Conditions, Program
from .redundant_conditions import redundant_conditions
from .switches import value_of

Array = NDArray[np.float64]

UNROLLED = 1200
"""Limit of the contacts of families in a motion by events, each recorded in 6 ms; two boxes have 16."""


class Kernels:
    """Programs of one model."""

    def __init__(self, model: Model, active: tuple[int, ...] = ()) -> None:
        self.model = model
        self.active = active
        self._others: dict[tuple[int, ...], Kernels] = {}
        self.programs: dict[Any, Program] = {}
        self._work: bool | None = None
        self._names_dropped: tuple[str, ...] = ()
        self._defaults: dict[str, float] | None = None
        self._checked: dict[str, float] | None = None
        self.cache: dict[Any, Any] = {}  # for modules that build on these programs
        self._at: tuple[dict[str, float], Array, Rates] | None = None

    def __reduce__(self) -> Any:
        """Pickle the model without its machine code. Another process compiles it again, once for all objects that refer
        to the same machine.
        """
        return _restored, (packed(self.model), self.active)

    def __deepcopy__(self, memo: Any) -> Kernels:
        return self  # functions of a model, and a model never changes

    def holding(self, active: tuple[int, ...]) -> Kernels:
        """Return the programs of a constrained model with these independent conditions."""
        if active not in self._others:
            other = self._others[active] = Kernels(self.model, active)
            other._others = self._others
            other.programs |= {key: self.programs[key] for key in ("closing",) if key in self.programs}
        return self._others[active]

    @cached_property
    def works(self) -> bool:
        """True if drives or loads do work on the machine, so that the work is part of the state."""
        self.motion()
        assert self._work is not None
        return self._work

    @cached_property
    def operations(self) -> Mapping[str, int] | None:
        """Operation counts of the rates; None if unknown."""
        return getattr(self.motion().compiled["rates"], "operations", None)

    @cached_property
    def size(self) -> int:
        """Number of components of y."""
        return self.model.n_q + self.model.n_u + self.works

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the components of y."""
        work = ("work",) if self.works else ()
        return (*self.model.state_names, *work)

    def values(self, overrides: Mapping[Any, Any] | None) -> dict[str, float]:
        """Return the values of all parameters by name (:meth:`Model.values`). The defaults are read once."""
        if overrides is not None and not (isinstance(overrides, Mapping) and not overrides):
            result = self.model.values(overrides)
            self.model.refuse_written(overrides)
            return result
        if self._defaults is None:
            self._defaults = self.model.values()
        return dict(self._defaults)

    def check(self, values: Mapping[str, float]) -> None:
        """Check that the bodies can move (:func:`check_bodies`) and that the assumptions hold.

        The check is skipped if the values are those of the last successful check.
        """
        if self._checked != values:
            check_bodies(self.model, values)
            check_assumptions(self.model, values)
            self._checked = dict(values)

    def parameters(self, values: Mapping[str, float]) -> Array:
        """Return the values in the order of the model's parameters."""
        return np.array([values[name] for name in self._parameter_names], dtype=float)

    @cached_property
    def _parameter_names(self) -> list[str]:
        return [parameter.name for parameter in self.model.parameters]

    def rates_of(self, state: State) -> list[Scalar]:
        """Return y' on a tape: the rates of the coordinates and speeds, and the power of the work if there is any."""
        moving = motion(self.model, state, self.active)
        rates: list[Scalar] = [*coordinate_rates(self.model, state), *moving.udot]
        return [*rates, total_power(self.model, state, moving)] if self.works else rates

    def recorded(self, numbers_are_data: bool = False) -> tuple[Tape, State, list[Scalar]]:
        """Return a new tape, the state on it, and the constants of a run: the parameters."""
        tape = Tape(numbers_are_data)
        state = traced_state(self.model, tape)
        return tape, state, [state.values[parameter.symbol] for parameter in self.model.parameters]

    def program(
        self,
        key: Any,
        functions: Callable[..., Mapping[str, Sequence[Scalar]]],
        inputs: int = 0,
        numbers_are_data: bool = False,
    ) -> Program:
        """Compile any functions of the state, named lists of outputs, once per key.

        If ``inputs`` is not 0, y holds that many numbers after the state. They are the second argument of
        ``functions``. With numbers as data, functions that differ only in numbers of the model share their code.
        """
        if key not in self.programs:
            tape, state, parameters = self.recorded(numbers_are_data)
            extra_inputs = [tape.input(f"input {k}") for k in range(inputs)]
            outputs_by_name = {
                name: list(outputs)
                for name, outputs in (functions(state, extra_inputs) if inputs else functions(state)).items()
            }
            compiled = compile_tape(
                tape, outputs_by_name, state.t, [*state.q, *state.u, *extra_inputs], parameters
            )
            self.programs[key] = Program(compiled)
        return self.programs[key]

    def _large(self) -> Program | None:
        """Return the looped kernels of a large tree, or None if the machine is small."""
        if "large" not in self.programs:
            if not is_large(self.model, "forward_dynamics"):
                return None
            looped = LoopedSet(self.model)
            self._work = looped.works
            self.programs["large"] = Program(looped)
        return self.programs["large"]

    def by_events(self) -> Kernels:
        """Return the programs of the machine for a motion by events.

        Every pair of its families is a contact of its own, and points of disks that lie flat turn.

        Raises
        ------
        SimulationError
            More than `UNROLLED` contacts.
        """
        if not (self.model.families or any(contact.stands for contact in self.model.contacts)):
            return self
        if "unrolled" not in self.cache:
            model = unrolled(self.model, UNROLLED)
            if model is None:
                names = " and ".join(repr(family.name) for family in self.model.families)
                raise SimulationError(
                    f"The families of contacts {names} may touch at more than {UNROLLED} points, 16 of them for two "
                    "boxes and 8 for a box and a plane, and a motion by events records each. Take "
                    'method="timestepping" with step=, whose families may have any number.'
                )
            self.cache["unrolled"] = Kernels(model)
        kernels: Kernels = self.cache["unrolled"]
        return kernels

    def looped(self) -> tuple[Program, Program] | None:
        """Return the looped kernels (of the motion, and of forces from accelerations) for time steps, or None.

        They serve trees of many bodies with contacts in families only.
        """
        model = self.model
        driven = any(link.driven for link in model.links)
        if not model.families or model.contacts or model.switched or driven:
            return None
        motion = self._large()
        if motion is None:
            return None
        if "large inverse" not in self.programs:
            self.programs["large inverse"] = Program(LoopedSet(model, "inverse"))
        return motion, self.programs["large inverse"]

    def _motion(self, state: State) -> Motion:
        return motion(self.model, state, self.active)

    def motion(self) -> Program:
        """Program of the motion.

        Its functions are ``rates``, ``energy`` (kinetic, potential) and, for a constrained model, ``projection``,
        ``hold`` (how independent the conditions are) and ``dropped`` (residual and rate of the conditions that were
        redundant at the start).
        """

        def functions(state: State) -> dict[str, Sequence[Scalar]]:
            moving = self._motion(state)
            power = total_power(self.model, state, moving)
            self._work = not is_always_zero(power)
            rates = [*coordinate_rates(self.model, state), *moving.udot]
            energy = [kinetic_energy(self.model, state), potential_energy(self.model, state)]
            outputs: dict[str, Sequence[Scalar]] = {
                "rates": [*rates, power] if self._work else rates,
                "energy": energy,
            }
            if self.active:
                outputs["projection"] = moved_onto(self.model, state, self.active)
                outputs["hold"] = [independence(self.model, state, self.active)]
            self._names_dropped, checked = redundant_conditions(self.model, state, self.active)
            return {**outputs, "dropped": checked} if checked else outputs

        return self.programs.get("motion") or self._large() or self.program("motion", functions)

    def at(self, values: Mapping[str, float]) -> tuple[Array, Rates]:
        """Return the parameters in order, and the right-hand side with its constants. The last result is cached."""
        if self._at is None or self._at[0] != values:
            parameters = self.parameters(values)
            self._at = dict(values), parameters, self.rates(parameters)
        return self._at[1:]

    def rates(self, parameters: Array) -> Rates:
        """Return the right-hand side with the constants of these parameters."""
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

    def closing(self) -> Conditions:
        """Program of the constraints of a model, for `gauss_newton`; its functions are `closing_functions`."""
        m, n = len(self.on_speeds), self.model.n_u
        places: list[tuple[int, int]] = []

        def functions(state: State, selection: Sequence[Scalar]) -> dict[str, list[Scalar]]:
            found, result = self.closing_functions(state, selection)
            places.extend(found)
            return result

        if "closing" not in self.programs:
            program = self.program("closing", functions, n + m)
            rows_of_entries, columns = np.array(places, dtype=np.int64).reshape(-1, 2).T
            self.programs["closing"] = Conditions(
                program.compiled, rows=rows_of_entries, columns=np.ascontiguousarray(columns), shape=(m, n)
            )
        return cast(Conditions, self.programs["closing"])

    def closing_functions(
        self, state: State, selection: Sequence[Scalar]
    ) -> tuple[list[tuple[int, int]], dict[str, list[Scalar]]]:
        """Return the places of the entries of the matrix G of the conditions, and functions of (q, u, selection).

        These are ``conditions`` (the residuals of all conditions, the entries of G), ``motion`` (the rates of the
        conditions, the entries of G, the diagonal of the mass matrix M, and `articulated_diagonal`), ``moved`` (q') and
        ``least`` (`least_speed_change`).
        """
        model, n, linear = self.model, self.model.n_u, linearized(self.model, state)
        matrix = [(i, j, x) for i, row in enumerate(linear.matrix) for j, x in entries(row)]
        G = [x for _, _, x in matrix]
        masses = [*mass_diagonal(model, state), *articulated_diagonal(model, state)]
        return [(i, j) for i, j, _ in matrix], {
            "conditions": [*linear.residual, *G],
            "motion": [*linear.rate, *G, *masses],
            "moved": list(coordinate_rates(model, state)),
            "least": list(least_speed_change(model, state, Selection(selection[:n], selection[n:]))),
        }

    @cached_property
    def on_speeds(self) -> tuple[int, ...]:
        """For each condition, 1 if it restricts speeds only, else 0."""
        return tuple(int(row.on_speeds) for row in rows(self.model))

    @cached_property
    def dropped(self) -> tuple[str, ...]:
        """Conditions that were redundant at the start, without those that hold identically."""
        self.motion()
        return self._names_dropped

    def poses(self) -> Program:
        """Program with the function ``poses``: for each body, position (3) and rotation to ground axes (9, by rows)."""

        def functions(state: State) -> dict[str, Sequence[Scalar]]:
            postures = poses(self.model, state)
            return {
                "poses": [
                    x
                    for name in self.model.bodies
                    for x in (*postures[name].position, *(x for row in postures[name].rotation for x in row))
                ]
            }

        return self._large() or self.program("poses", functions)

    def reactions(self) -> Program:
        """Program with the functions ``reactions``, for each joint force (3) and moment (3), and ``multipliers``."""

        def functions(state: State) -> dict[str, Sequence[Scalar]]:
            moving = self._motion(state)
            reactions = all_reactions(self.model, state, moving)
            return {
                "reactions": [x for name in reactions for vector in reactions[name] for x in vector],
                "multipliers": list(moving.multipliers),
            }

        if self._large() is not None:
            if "large reactions" not in self.programs:
                self.programs["large reactions"] = Program(LoopedSet(self.model, "reactions"))
            return self.programs["large reactions"]
        return self.program("reactions", functions)

    def limits(self) -> Program:
        """Program with the function ``limits``: the margin to each limit of a one-sided constraint, then each margin
        plus the part of the forces that is negligible.
        """
        return self.program("limits", lambda state: {"limits": self._limits(state, self._motion(state))})

    def _limits(self, state: State, moving: Motion) -> list[Scalar]:
        slack = margins(self.model, state, moving.multipliers)
        size = sizes(self.model, state, self.active)
        return [*slack, *(a + NEGLIGIBLE * b for a, b in zip(slack, size, strict=True))]

    def expressions(self, expressions: Sequence[Expression]) -> Program:
        """Program with the function ``values``: expressions of the model's names."""
        return self.program(
            ("values", tuple(expressions)),
            lambda state: {"values": [value_of(state, e) for e in expressions]},
        )


class _Packer(pickle.Pickler):
    """Pickler of a model for a motion, which no longer calls any controller."""

    def reducer_override(self, value: Any) -> Any:
        if isinstance(value, Controller):
            try:
                pickle.dumps(value.function)
            except (pickle.PicklingError, AttributeError, TypeError):
                return type(value), (value.name, _Lost(value.name), value.period, value.inputs, value.sensors)
        return NotImplemented


@dataclass(frozen=True)
class _Lost:
    """Placeholder for a controller's function that stayed in another process."""

    name: str

    def __call__(self, *_: Any) -> Any:
        raise SimulationError(
            f"Expected the function of controller '{self.name}', but it stayed in the process that made this motion: "
            "it is no function of a module. Describe the machine here to simulate it again."
        )


def packed(model: Model) -> bytes:
    """Return a model as bytes, for another process."""
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
    """Return the programs of a system in its present description, or of a model. The last ones used are cached."""
    entry = _recent.get(id(machine))
    if entry is not None and entry[1].count == entry[2]:
        _recent.move_to_end(id(machine))
        return entry[3]
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
