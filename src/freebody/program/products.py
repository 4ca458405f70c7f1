"""Products of a program. Each product records one algorithm on a tape.

A product ``"f_by_x"`` is the derivative of product ``f`` by x: by one of its inputs (q, u, udot, forces), by time t, by
all ``parameters``, by one parameter, or by the ``displacement``: per unit of each speed, ∂f/∂q G with q' = G(q) u.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import sympy

from ..dynamics import (
    State,
    bias,
    coordinate_rates,
    coriolis_matrix,
    forward_dynamics,
    gravity_forces,
    inverse_dynamics,
    jacobian,
    kinetic_energy,
    mass_matrix,
    momentum,
    poses,
    potential_energy,
    traced_state,
)
from ..dynamics.conditions.constrained import constrained_dynamics
from ..dynamics.conditions.constraints import rows
from ..dynamics.conditions.linearized import linearized
from ..dynamics.kinematics import angular_velocity, jacobian_rate, point_velocity
from ..dynamics.motion import Motion, all_reactions, motion, transmitting
from ..dynamics.newton_euler import reactions
from ..dynamics.operational_space import COMPONENTS, operational_bias, operational_inertia
from ..dynamics.regressor import parameter_names, regressor
from ..errors import ModelError, nearest
from ..model import Model
from ..scalar.algebra import Expression, Scalar
from ..scalar.derivative import forward
from ..scalar.derivative import jacobian as derivative
from ..scalar.trace import Tape, Traced
from .arguments import place_of
from .kernel import KernelSet
from .kernels import compile_tape


@dataclass(frozen=True)
class Product:
    """A function of some of the inputs q, u, udot (u') and forces: its recording and the shape of its result.

    ``moves`` is true if the conditions of a constrained model enter. ``point`` is the point of a Jacobian.
    ``key`` tells products of points apart.
    """

    inputs: tuple[str, ...]
    record: Callable[[Recording], Sequence[Scalar]]
    shape: Callable[[Model], tuple[int, ...]]
    moves: bool = False
    point: Any = None
    key: Any = None


@dataclass(frozen=True)
class Recording:
    """A model on a tape: its state, accelerations and generalized forces as inputs."""

    model: Model
    tape: Tape
    state: State
    udot: tuple[Traced, ...]
    forces: tuple[Traced, ...]
    active: tuple[int, ...] | None

    @property
    def parameters(self) -> list[Traced]:
        """The parameters, in the model's order."""
        return [self.state.values[parameter.symbol] for parameter in self.model.parameters]

    def inputs(self, names: Sequence[str]) -> list[Traced]:
        """The inputs of a product in one list."""
        inputs = {"q": self.state.q, "u": self.state.u, "udot": self.udot, "forces": self.forces}
        return [x for name in names for x in inputs[name]]

    def motion(self) -> Motion:
        """Motion of the model: accelerations and constraint forces."""
        return motion(self.model, self.state, self.active)

    def forced(self) -> tuple[Scalar, ...]:
        """Accelerations under the additional generalized forces."""
        if self.model.constraints:
            assert self.active is not None
            return constrained_dynamics(self.model, self.state, self.active, self.forces)[0]
        return forward_dynamics(self.model, self.state, self.forces)


def recording(model: Model, active: tuple[int, ...] | None = None) -> Recording:
    """Record the state of a model on a new tape."""
    tape = Tape()
    state = traced_state(model, tape)
    udot = tuple(tape.input(f"{speed.name}'") for speed in model.speeds)
    forces = tuple(tape.input(f"{speed.name} force") for speed in model.speeds)
    return Recording(model, tape, state, udot, forces, active)


def compiled(model: Model, product: Product, batch: bool, active: tuple[int, ...] | None = None) -> KernelSet:
    """Compile the kernel ``"f"`` of a product."""
    r = recording(model, active)
    outputs = list(product.record(r))
    return compile_tape(
        r.tape, {"f": outputs}, r.state.t, r.inputs(product.inputs), r.parameters, ["f"] if batch else []
    )


def product_named(model: Model, name: Any) -> Product:
    """Return a product by its name; ``"f_by_x"`` names a derivative, ``"f of p: vx vy"`` a product of a point."""
    if isinstance(name, str) and " of " in name:
        return _named_of_point(model, name)
    if isinstance(name, str) and "_by_" in name:
        base, _, by = name.partition("_by_")
        return derivative_of(model, product_named(model, base), by)
    if not isinstance(name, str) or name not in PRODUCTS:
        raise ModelError(f"Unknown product '{name}'; {nearest(str(name), products_of(model))}")
    if name not in products_of(model):
        raise ModelError(
            f"Expected a machine with constraints for the product '{name}', but '{model.name}' has no constraints. "
            f"Its products are {', '.join(products_of(model))}."
        )
    return PRODUCTS[name]


def products_of(model: Model) -> tuple[str, ...]:
    """Names of the products of a machine; ``conditions`` only with constraints."""
    return tuple(name for name in PRODUCTS if model.constraints or name != "conditions")


def named_variable(model: Model, by: Any) -> Any:
    """Return the name of the variable of a derivative; the symbol of a parameter stands for its name."""
    if not isinstance(by, str | sympy.Basic):
        raise ModelError(
            f"Expected a variable to differentiate by, such as 'q' or the name of a parameter, got '{by}'."
        )
    names = {p.symbol: p.name for p in model.parameters}
    if by in ("q", "u", "udot", "forces", "displacement", "parameters") and by in names.values():
        raise ModelError(
            f"Expected one meaning of '{by}', but '{model.name}' has a parameter of this name, too. Rename the "
            "parameter."
        )
    return by if isinstance(by, str) else names.get(by, by)


def derivative_of(model: Model, product: Product, by: str) -> Product:
    """Return the product ∂f/∂x, whose last axis runs over x (no such axis for time and for one parameter)."""
    names = [parameter.name for parameter in model.parameters]
    displacement = ("displacement",) if "q" in product.inputs else ()
    variables = (*product.inputs, *displacement, "t", "parameters", *names)
    if by not in variables:
        raise ModelError(
            f"Expected a derivative by one of {', '.join(variables)}, got '{by}'; {nearest(str(by), variables)}"
        )

    def record(r: Recording) -> list[Scalar]:
        outputs = list(product.record(r))
        if by == "displacement":
            columns = []
            for k in range(model.n_u):
                unit = State(model, r.tape, r.state.t, r.state.q, _unit(model.n_u, k), r.state.values)
                columns.append(forward(r.tape, outputs, r.state.q, coordinate_rates(model, unit)))
            return [column[i] for i in range(len(outputs)) for column in columns]
        if by in product.inputs:
            wrt = r.inputs([by])
        elif by == "t":
            wrt = [r.state.t]
        elif by == "parameters":
            wrt = r.parameters
        else:
            wrt = [r.parameters[names.index(by)]]
        return _flat(derivative(r.tape, outputs, wrt))

    def shape(model: Model) -> tuple[int, ...]:
        sizes = {"q": model.n_q, "parameters": len(names)}
        several = by in product.inputs or by in ("displacement", "parameters")
        return (*product.shape(model), *((sizes.get(by, model.n_u),) if several else ()))

    return Product(product.inputs, record, shape, product.moves)


def _unit(n: int, k: int) -> list[int]:
    return [int(i == k) for i in range(n)]


def _flat(rows: Iterable[Iterable[Scalar]]) -> list[Scalar]:
    return [x for row in rows for x in row]


def _poses(r: Recording) -> list[Scalar]:
    postures = poses(r.model, r.state)
    return [x for name in r.model.bodies for x in (*_flat(postures[name].rotation), *postures[name].position)]


def _velocities(r: Recording) -> list[Scalar]:
    result = []
    for name in r.model.bodies:
        origin = place_of(r.model, name)
        result += [
            *angular_velocity(r.model, r.state, origin.body),
            *point_velocity(r.model, r.state, origin),
        ]
    return result


def _momentum(r: Recording) -> list[Scalar]:
    total = momentum(r.model, r.state)
    return [*total.linear, *total.angular]


def _reactions(r: Recording) -> list[Scalar]:
    return _flat(vector for pair in all_reactions(r.model, r.state, r.motion()).values() for vector in pair)


def _reactions_at(r: Recording) -> list[Scalar]:
    by_joint = reactions(r.model, r.state, r.udot)
    return [x for name in r.model.joints for vector in by_joint[name] for x in vector]


def _conditions(r: Recording) -> list[Scalar]:
    """G and γ of all conditions, by rows."""
    conditions = linearized(r.model, r.state)
    return [x for row, bias in zip(conditions.matrix, conditions.bias, strict=True) for x in (*row, bias)]


def _derivatives(r: Recording) -> list[Scalar]:
    return _flat(derivative(r.tape, r.motion().udot, [*r.state.q, *r.state.u]))


def _speeds(model: Model) -> tuple[int, ...]:
    return (model.n_u,)


def _number(model: Model) -> tuple[int, ...]:
    return ()


PRODUCTS: dict[str, Product] = {
    "forward_dynamics": Product(("q", "u"), lambda r: r.motion().udot, _speeds, True),
    "forced_dynamics": Product(("q", "u", "forces"), lambda r: r.forced(), _speeds, True),
    "inverse_dynamics": Product(
        ("q", "u", "udot"), lambda r: inverse_dynamics(r.model, r.state, r.udot), _speeds
    ),
    "mass_matrix": Product(("q",), lambda r: _flat(mass_matrix(r.model, r.state)), lambda m: (m.n_u, m.n_u)),
    "coriolis_matrix": Product(
        ("q", "u"), lambda r: _flat(coriolis_matrix(r.model, r.state)), lambda m: (m.n_u, m.n_u)
    ),
    "gravity_forces": Product(("q",), lambda r: gravity_forces(r.model, r.state), _speeds),
    "regressor": Product(
        ("q", "u", "udot"),
        lambda r: _flat(regressor(r.model, r.state, r.udot)),
        lambda m: (m.n_u, len(parameter_names(m))),
    ),
    "bias": Product(("q", "u"), lambda r: bias(r.model, r.state), _speeds),
    "coordinate_rates": Product(("q", "u"), lambda r: coordinate_rates(r.model, r.state), lambda m: (m.n_q,)),
    "kinetic_energy": Product(("q", "u"), lambda r: [kinetic_energy(r.model, r.state)], _number),
    "potential_energy": Product(("q",), lambda r: [potential_energy(r.model, r.state)], _number),
    "momentum": Product(("q", "u"), _momentum, lambda m: (6,)),
    "poses": Product(("q",), _poses, lambda m: (len(m.bodies), 12)),
    "velocities": Product(("q", "u"), _velocities, lambda m: (len(m.bodies), 6)),
    "reactions": Product(("q", "u"), _reactions, lambda m: (len(transmitting(m)), 6), True),
    "reactions_at": Product(("q", "u", "udot"), _reactions_at, lambda m: (len(m.joints), 6)),
    "conditions": Product(("q", "u"), _conditions, lambda m: (len(rows(m)), m.n_u + 1)),
    "derivatives": Product(("q", "u"), _derivatives, lambda m: (m.n_u, m.n_q + m.n_u), True),
}


OF_POINT: dict[str, tuple[tuple[str, ...], Callable[..., list[Scalar]]]] = {
    "jacobian": (("q",), lambda r, p, ks: _rows_of(jacobian(r.model, r.state, p), ks)),
    "jacobian_rate": (("q", "u"), lambda r, p, ks: _rows_of(jacobian_rate(r.model, r.state, p), ks)),
    "operational_inertia": (
        ("q",),
        lambda r, p, ks: _flat(operational_inertia(r.model, r.state, p, ks, r.active)),
    ),
    "operational_bias": (
        ("q", "u"),
        lambda r, p, ks: list(operational_bias(r.model, r.state, p, ks, r.active)),
    ),
}
"""Products of a point and of components of its velocities: inputs and recording."""


def _rows_of(J: Sequence[Sequence[Scalar]], components: Sequence[int]) -> list[Scalar]:
    return [x for k in components for x in J[k]]


def of_point(model: Model, name: Any, point: Any, components: Any = None) -> Product:
    """Return a product of a point, of all components of its velocities or of some."""
    if name not in OF_POINT:
        raise ModelError(f"Expected a product of a point, got '{name}'; {nearest(str(name), OF_POINT)}")
    place, chosen = place_of(model, point), _components(components)
    inputs, record = OF_POINT[name]
    operational = name.startswith("operational")
    if operational and (place.body.is_ground or len(chosen) > model.n_u):
        found = "a point of the ground" if place.body.is_ground else f"{model.n_u} speeds"
        raise ModelError(
            f"Expected a point that forces can move in {len(chosen)} components for the operational space, got {found}."
            " Choose fewer: components='vx vy'."
        )

    def shape(model: Model) -> tuple[int, ...]:
        size = (
            (model.n_u,) if name.startswith("jacobian") else (len(chosen),) * (name == "operational_inertia")
        )
        return (len(chosen), *size)

    looped = place if name == "jacobian" and components is None else None
    key = (name, place.body.name, place.components, *(chosen if components is not None else ()))
    return Product(inputs, lambda r: record(r, place, chosen), shape, operational, looped, key)


def operational_space(model: Model, point: Any, components: Any = None) -> Product:
    """Return the product (Λ, μ) of a point by rows, the bias last; Λ is recorded once for both."""
    inertia, mu = (of_point(model, f"operational_{name}", point, components) for name in ("inertia", "bias"))
    count = inertia.shape(model)[0]

    def record(r: Recording) -> list[Scalar]:
        return [*inertia.record(r), *mu.record(r)]

    return Product(
        mu.inputs, record, lambda m: (count + 1, count), True, None, ("operational_space", *mu.key[1:])
    )


def _components(names: Any) -> list[int]:
    """Return the numbers of components; without names, those of all."""
    if names is None:
        return list(range(len(COMPONENTS)))
    words = names.replace(",", " ").split() if isinstance(names, str) else list(names)
    for word in words:
        if word not in COMPONENTS or words.count(word) > 1:
            raise ModelError(f"Expected components of {' '.join(COMPONENTS)}, each once, got '{names}'.")
    if not words:
        raise ModelError(f"Expected at least one of the components {' '.join(COMPONENTS)}.")
    return [COMPONENTS.index(word) for word in words]


def _named_of_point(model: Model, name: str) -> Product:
    """Return the product ``"f of p"``, ``"f of p: vx vy"``, or ``"f_by_x of p"``."""
    base, _, rest = name.partition(" of ")
    frame, colon, components = rest.rpartition(":") if ":" in rest else (rest, "", None)
    if rest in (*model.bodies, *model.frames):  # names of frames may have colons
        frame, components = rest, None
    base, _, by = base.partition("_by_")
    product = of_point(model, base, frame, components)
    return derivative_of(model, product, by) if by else product


def values_of(expressions: Sequence[Expression], several: bool) -> Product:
    """Return the product of expressions of the model's names; a single one has no axis."""
    return Product(
        ("q", "u"),
        lambda r: [r.state(expression) for expression in expressions],
        lambda m: (len(expressions),) if several else (),
    )


def check_conditions(model: Model, active: tuple[int, ...] | None) -> None:
    """Raise an error if a machine has constraints and its independent conditions are unknown."""
    if model.constraints and active is None:
        raise ModelError(
            f"'{model.name}' has constraints ({', '.join(model.constraints)}), and its motion follows from the "
            f"conditions that are independent of each other. Give a configuration near one that fulfils them: "
            f"fb.compile(s, at=[...]), in the order of {', '.join(model.coordinate_names)}."
        )
