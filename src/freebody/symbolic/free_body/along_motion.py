"""What conserved quantities and steady motions are made of: residuals of motion, rates along it, momenta, numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import sympy

from ...dynamics.kinematics import coordinate_rates
from ...errors import ModelError, nearest
from ...model.values import check_assumptions

if TYPE_CHECKING:
    from ..equations import Equations


def residuals_of(e: Equations) -> tuple[Any, ...]:
    """E_j = M u' + h - Q - Gᵀ λ, canonical; zero along every motion."""
    if "residuals" not in e.state.cache:
        e.state.cache["residuals"] = tuple(left - right for left, right in e.balances)
    return e.state.cache["residuals"]


def rate_of(e: Equations, x: Any) -> Any:
    """dx/dt along q' = N u, with u' as symbols."""
    rates = {
        c.symbol: rate
        for c, rate in zip(e.model.coordinates, coordinate_rates(e.model, e.state), strict=True)
    }
    rates.update({speed.symbol: udot for speed, udot in zip(e.model.speeds, e.udot, strict=True)})
    return e.ring.total_derivative(x, rates)


def momenta(e: Equations) -> tuple[Any, ...]:
    """∂T/∂u_j, canonical."""
    if "momenta" not in e.state.cache:
        T = e.energy.canonical_kinetic
        e.state.cache["momenta"] = tuple(e.ring.derivative(T, speed.symbol) for speed in e.model.speeds)
    return e.state.cache["momenta"]


def random_numbers(e: Equations, seed: int, count: int | None = None) -> dict[Any, Any]:
    """Numbers for all atoms but accelerations, parameters between 1 and 2; arrays of ``count`` of each that varies."""
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


def numbers(e: Equations, given: Mapping[Any, Any]) -> dict[Any, Any]:
    """Numbers for all atoms: those given by name or symbol, parameters by default, coordinates and speeds zero."""
    model = e.model
    known = {**model.names.atoms}
    known.update({speed.name: speed.symbol for speed in model.speeds})
    known.update({c.name: c.symbol for c in model.coordinates})
    parameters = {parameter.name for parameter in model.parameters}
    by_symbol = {symbol: name for name, symbol in known.items()}
    atoms: dict[Any, Any] = {c.symbol: 0 for c in model.coordinates} | {s.symbol: 0 for s in model.speeds}
    atoms.update({model.coordinates[i].symbol: 1 for i in model.quaternions})
    atoms[model.names.atoms["t"]] = 0
    constants = {}
    for key, value in given.items():
        name = key if isinstance(key, str) else by_symbol.get(key, str(key))
        if name not in known:
            raise ModelError(f"Unknown name '{name}'; {nearest(name, known)}")
        if name in parameters and getattr(value, "ndim", 0) == 0:
            constants[name] = value
        else:
            atoms[known[name]] = _plain(value)
    arrays_given = {name for name in parameters if known[name] in atoms}
    values = model.values({**dict.fromkeys(arrays_given, 0), **constants})
    if not arrays_given:
        check_assumptions(model, values)
    for parameter in model.parameters:
        if parameter.name not in arrays_given:
            atoms[parameter.symbol] = values[parameter.name]
    return atoms


def _plain(value: Any) -> Any:
    if isinstance(value, str | sympy.Basic):
        return float(sympy.sympify(value))
    return value
