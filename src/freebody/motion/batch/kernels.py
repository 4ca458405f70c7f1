"""The machine code of a batch: everything that a lane computes, with one set of constants per lane.

One program holds the rates, the energy, the projection, the outputs at the output times, the quantities whose extremes
are sought and their rates dx/dt = ∂x/∂t + ∂x/∂q q' + ∂x/∂u u', and the events. Its constants depend on the parameters
only; the loop computes them once per lane.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ...dynamics import State, coordinate_rates, kinetic_energy, potential_energy
from ...dynamics.conditions.constrained import moved_onto
from ...dynamics.motion import all_reactions, motion, total_power
from ...errors import ExpressionError
from ...program.fixed import Fixed
from ...program.kernel import KernelSet
from ...program.kernels import compile_tape
from ...scalar.algebra import Expression, Scalar
from ...scalar.derivative import forward
from ..kernels.kernels import Kernels
from ..kernels.method_kernels import without_series
from ..kernels.methods import may_bend
from ..kernels.redundant_conditions import redundant_conditions
from ..kernels.sides import SidedTape, Sides, sides_of, unsided
from ..trajectory.outputs import ENERGIES, OfReaction, Quantity


@dataclass(frozen=True)
class OfLimit:
    """An output of `Kernels.limits`, by its index."""

    place: int


@dataclass(frozen=True)
class BatchProgram:
    """Kernels of a batch.

    ``compiled``   rates (for `taylor` the series instead, or both if the rates may bend), energy, outputs, reduced,
                   watched and, if there are any, projection, dropped, tangent
    ``watched``    number of event functions: events, then rates of the quantities with extremes, then the e of the laws
                   that switch (`kernels.sides`), whose sides follow the parameters
    ``sides``      these laws, or None
    ``dropped``    number of residuals that must stay zero
    """

    compiled: KernelSet | Fixed
    watched: int
    dropped: int
    sides: Sides | None = None

    @property
    def laws(self) -> int:
        """Number of laws that switch."""
        return 0 if self.sides is None else len(self.sides.laws)

    def address(self, name: str) -> int:
        """Address of a kernel, 0 if there is none."""
        return int(self.compiled[name].address) if name in self.compiled.kernels else 0

    @property
    def room(self) -> int:
        """Number of reals that the series of eight lanes writes."""
        return self.compiled["series"].room if "series" in self.compiled.kernels else 0

    def wide_address(self, name: str) -> int:
        """Address of a kernel for eight lanes, 0 if there is none."""
        return int(self.compiled[name].lanes_address or 0) if name in self.compiled.kernels else 0


def batch_program(
    kernels: Kernels, outputs: Sequence[Quantity], reduced: Sequence[Quantity],
    events: Sequence[Expression | OfLimit], method: str, wide: bool = False,
) -> BatchProgram:  # fmt: skip
    """Return the program of a batch; it is compiled once for the same outputs and events.

    Parameters
    ----------
    outputs, reduced : sequence of expressions, names among ENERGIES, or quantities of reactions
        Quantities at the output times, and quantities whose extremes are sought.
    events : sequence of expressions
    method : str
        `radau` needs the derivative of the rates along a direction, `taylor` the series of the motion.
    wide : bool
        True if eight lanes run at once.
    """
    tangent, series = method == "radau", method == "taylor"
    key = ("batch", tuple(outputs), tuple(reduced), tuple(events), tangent, series, wide)
    if key not in kernels.programs:
        try:
            made = _recorded(kernels, outputs, reduced, events, tangent, series, wide)
        except ExpressionError as error:
            if not series:
                raise
            raise without_series(kernels.model, error) from None
        kernels.programs[key] = made  # type: ignore[assignment]
    return kernels.programs[key]  # type: ignore[return-value]


def _recorded(
    kernels: Kernels, outputs: Sequence[Quantity], reduced: Sequence[Quantity],
    events: Sequence[Expression | OfLimit], tangent: bool, series: bool, wide: bool,
) -> BatchProgram:  # fmt: skip
    model, sides = kernels.model, sides_of(kernels)
    tape, state, parameters = (kernels if sides is None else sides.kernels).recorded()
    moving = motion(model, state, kernels.active)
    power = total_power(model, state, moving)
    laws: list[Scalar] = []
    if isinstance(tape, SidedTape):  # what is observed switches by itself
        laws, state = [e for _, e in tape.sides.values()], unsided(state)
    energy = [kinetic_energy(model, state), potential_energy(model, state)]
    y = [*state.q, *state.u]
    rates = [*coordinate_rates(model, state), *moving.udot]
    work: Scalar = 0
    if kernels.works:
        work = tape.input("work done")
        y.append(work)
        rates.append(power)
    named = dict(zip(ENERGIES, (*energy, energy[0] + energy[1], work, power), strict=True))

    limits = kernels._limits(state, moving) if any(isinstance(x, OfLimit) for x in events) else []

    asked = any(isinstance(x, OfReaction) for x in (*outputs, *reduced))
    reactions = all_reactions(model, state, moving) if asked else {}

    def value(expression: Quantity | OfLimit) -> Scalar:
        if isinstance(expression, OfLimit):
            return limits[expression.place]
        if isinstance(expression, OfReaction):
            force, moment = reactions[expression.joint]
            return expression.of(force if expression.what == "force" else moment, state.field.sqrt)
        return named[expression] if isinstance(expression, str) else state(expression)

    quantities = [value(x) for x in reduced]
    changes = forward(tape, quantities, [state.t, *y], [1, *rates])
    watched = [*map(value, events), *changes, *laws]
    functions: dict[str, Sequence[Any]] = {
        **({"series": rates} if series else {}),
        **({} if series and not may_bend(kernels) else {"rates": rates}),
        "energy": energy,
        "outputs": [value(x) for x in outputs],
        "reduced": quantities,
        "watched": watched,
    }
    if kernels.active:
        functions["projection"] = moved_onto(model, state, kernels.active)
    names, checked = redundant_conditions(model, state, kernels.active) if model.constraints else ((), ())
    if names:
        functions["dropped"] = checked
    inputs = list(y)
    if tangent:
        along = [tape.input(f"direction {i}") for i in range(len(y))]
        functions["tangent"] = forward(tape, rates, y, along)
        inputs += along
    limits_only = bool(events) and not reduced and not laws and all(isinstance(x, OfLimit) for x in events)
    wide_names = ("rates", "series", "projection", *(("watched",) if limits_only else ()))
    batch = [name for name in wide_names if wide and name in functions]
    more = {"series": len(y)} if series else {}
    compiled = compile_tape(tape, functions, state.t, inputs, parameters, batch, more)
    return BatchProgram(compiled, len(watched), len(functions.get("dropped", ())), sides)


def state_of(model: Any, field: Any, columns: Mapping[str, Any]) -> State:
    """Return a state at rest over any field, from values of the parameters by name."""
    from ...dynamics import rest_coordinates

    values = {parameter.symbol: columns[parameter.name] for parameter in model.parameters}
    return State(model, field, 0, rest_coordinates(model), [0] * model.n_u, values)
