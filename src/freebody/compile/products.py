"""What a program can be asked for: each product records one algorithm on a tape."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ..dynamics import (
    State,
    bias,
    coordinate_rates,
    forward_dynamics,
    inverse_dynamics,
    jacobian,
    kinetic_energy,
    mass_matrix,
    poses,
    potential_energy,
    reactions,
    traced_state,
)
from ..model import Model
from ..scalar.derivative import jacobian as derivative
from ..scalar.trace import Tape, Traced
from .kernels import KernelSet, compile_tape


@dataclass(frozen=True)
class Product:
    """A function of some of the inputs q, u, udot (u') and forces, and how it is recorded."""

    inputs: tuple[str, ...]
    record: Callable[[Recording], Sequence[Any]]


@dataclass(frozen=True)
class Recording:
    """A model on a tape: its state, accelerations and generalized forces as inputs."""

    model: Model
    tape: Tape
    state: State
    udot: tuple[Traced, ...]
    forces: tuple[Traced, ...]

    def inputs(self, names: Sequence[str]) -> list[Traced]:
        """The inputs of a product, one after the other."""
        given = {"q": self.state.q, "u": self.state.u, "udot": self.udot, "forces": self.forces}
        return [x for name in names for x in given[name]]


def recording(model: Model) -> Recording:
    """A model on a new tape."""
    tape = Tape()
    state = traced_state(model, tape)
    udot = tuple(tape.input(f"{speed.name}'") for speed in model.speeds)
    forces = tuple(tape.input(f"{speed.name} force") for speed in model.speeds)
    return Recording(model, tape, state, udot, forces)


def compiled(model: Model, product: Product, batch: bool) -> KernelSet:
    """The kernel ``"f"`` of a product."""
    r = recording(model)
    parameters = [r.state.values[parameter.symbol] for parameter in model.parameters]
    outputs = list(product.record(r))
    return compile_tape(
        r.tape, {"f": outputs}, r.state.t, r.inputs(product.inputs), parameters, ["f"] if batch else []
    )


def _flat(rows: Sequence[Sequence[Any]]) -> list[Any]:
    return [x for row in rows for x in row]


def _poses(r: Recording) -> list[Any]:
    postures = poses(r.model, r.state)
    return [x for name in r.model.bodies for x in (*_flat(postures[name].rotation), *postures[name].position)]


def _reactions(r: Recording, udot: Sequence[Any]) -> list[Any]:
    found = reactions(r.model, r.state, udot)
    return [x for name in r.model.joints for vector in found[name] for x in vector]


def _derivatives(r: Recording) -> list[Any]:
    udot = forward_dynamics(r.model, r.state)
    return _flat(derivative(r.tape, udot, [*r.state.q, *r.state.u]))


PRODUCTS: dict[str, Product] = {
    "forward_dynamics": Product(("q", "u"), lambda r: forward_dynamics(r.model, r.state)),
    "forced_dynamics": Product(("q", "u", "forces"), lambda r: forward_dynamics(r.model, r.state, r.forces)),
    "inverse_dynamics": Product(("q", "u", "udot"), lambda r: inverse_dynamics(r.model, r.state, r.udot)),
    "mass_matrix": Product(("q",), lambda r: _flat(mass_matrix(r.model, r.state))),
    "bias": Product(("q", "u"), lambda r: bias(r.model, r.state)),
    "coordinate_rates": Product(("q", "u"), lambda r: coordinate_rates(r.model, r.state)),
    "kinetic_energy": Product(("q", "u"), lambda r: [kinetic_energy(r.model, r.state)]),
    "potential_energy": Product(("q",), lambda r: [potential_energy(r.model, r.state)]),
    "poses": Product(("q",), _poses),
    "reactions": Product(("q", "u"), lambda r: _reactions(r, forward_dynamics(r.model, r.state))),
    "reactions_at": Product(("q", "u", "udot"), lambda r: _reactions(r, r.udot)),
    "derivatives": Product(("q", "u"), _derivatives),
}


def jacobian_of(point: Any) -> Product:
    """The product ``jacobian`` of a point."""
    return Product(("q",), lambda r: _flat(jacobian(r.model, r.state, point)))


def values_of(expressions: Sequence[Any]) -> Product:
    """Expressions of the model's names."""
    return Product(("q", "u"), lambda r: [r.state(expression) for expression in expressions])
