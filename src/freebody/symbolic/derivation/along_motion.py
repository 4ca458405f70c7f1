"""Quantities along a motion: residuals of the equations of motion, rates, momenta, and numbers for a state."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy

from ...dynamics.kinematics import coordinate_rates
from ...errors import ModelError, nearest
from ...model.values import check_assumptions
from ...scalar.algebra import Expression, Scalar
from .derivation import Derivation


def residuals_of(e: Derivation) -> tuple[Scalar, ...]:
    """E_j = M u' + h - Q - Gᵀ λ, canonical; zero along every motion."""
    if "residuals" not in e.state.cache:
        e.state.cache["residuals"] = tuple(left - right for left, right in e.balances)
    return e.state.cache["residuals"]


def rate_of(e: Derivation, x: Scalar) -> Scalar:
    """dx/dt along q' = N u, with u' as symbols."""
    rates = {
        c.symbol: rate
        for c, rate in zip(e.model.coordinates, coordinate_rates(e.model, e.state), strict=True)
    }
    rates.update({speed.symbol: udot for speed, udot in zip(e.model.speeds, e.udot, strict=True)})
    return e.ring.total_derivative(x, rates)


def momenta(e: Derivation) -> tuple[Scalar, ...]:
    """∂T/∂u_j, canonical."""
    if "momenta" not in e.state.cache:
        T = e.energy.canonical_kinetic
        e.state.cache["momenta"] = tuple(e.ring.derivative(T, speed.symbol) for speed in e.model.speeds)
    return e.state.cache["momenta"]


def random_numbers(e: Derivation, seed: int, count: int | None = None) -> dict[Any, Any]:
    """Random numbers for all atoms but accelerations: parameters between 1 and 2, other atoms between -1 and 1.

    With ``count``, atoms other than parameters get arrays of this length.
    """
    import numpy as np

    random = np.random.default_rng(seed)
    atoms: dict[Any, Any] = {}
    for g in e.ring.generators:
        if not g.arguments and g.atom is not None and g.kind not in ("constant", "acceleration"):
            fixed = g.kind == "parameter"
            atoms[g.atom] = 1 + random.random() if fixed else random.uniform(-1, 1, count)
    for start in e.model.quaternions:
        parts = [e.model.coordinates[start + k].symbol for k in range(4)]
        norm = np.sqrt(sum(atoms[part] ** 2 for part in parts))
        atoms.update({part: atoms[part] / norm for part in parts})
    return atoms


def numbers(e: Derivation, values: Mapping[Any, Expression]) -> dict[Any, Any]:
    """Numbers for all atoms: ``values`` by name or symbol, defaults of parameters, zero for coordinates and speeds.

    Raises
    ------
    ModelError
        An unknown name, or a parameter without a value.
    """
    model = e.model
    symbols = {**model.names.atoms}
    symbols.update({speed.name: speed.symbol for speed in model.speeds})
    symbols.update({c.name: c.symbol for c in model.coordinates})
    parameters = {parameter.name for parameter in model.parameters}
    names = {symbol: name for name, symbol in symbols.items()}
    atoms: dict[Any, Any] = {c.symbol: 0 for c in model.coordinates} | {s.symbol: 0 for s in model.speeds}
    atoms.update({model.coordinates[i].symbol: 1 for i in model.quaternions})
    atoms[model.names.atoms["t"]] = 0
    constants = {}
    for key, value in values.items():
        name = key if isinstance(key, str) else names.get(key, str(key))
        if name not in symbols:
            raise ModelError(f"Unknown name '{name}'; {nearest(name, symbols)}")
        if name in parameters and getattr(value, "ndim", 0) == 0:
            constants[name] = value
        else:
            atoms[symbols[name]] = _plain(value)
    array_parameters = {name for name in parameters if symbols[name] in atoms}
    parameter_values = model.values({**dict.fromkeys(array_parameters, 0), **constants})
    if not array_parameters:
        check_assumptions(model, parameter_values)
    for parameter in model.parameters:
        if parameter.name not in array_parameters:
            atoms[parameter.symbol] = parameter_values[parameter.name]
    return atoms


def _plain(value: Expression) -> Any:
    if isinstance(value, str | sympy.Basic):
        return float(sympy.sympify(value))
    return value
