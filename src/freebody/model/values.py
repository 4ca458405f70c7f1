"""Numbers for the parameters of a model."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy

from ..describe.constraints.constraint import Gear
from ..describe.names import finite
from ..errors import ModelError, nearest, shown
from ..scalar.algebra import Expression, floats
from ..scalar.expression import evaluate
from ..scalar.units import quantity

if TYPE_CHECKING:
    from .model import Model

_NUMBERS = frozenset((float, int, np.float64))


def parameter_values(model: Model, given: Mapping[Any, Any]) -> dict[str, float]:
    """Values of all parameters by name; see :meth:`Model.values`."""
    if not isinstance(given, Mapping):
        raise ModelError(f"Expected values of parameters by name, such as {{'m': 2}}, got {shown(given)}.")
    by_name = dict(model.defaults)
    for key, value in given.items():
        name = key if isinstance(key, str) else model.parameter_names.get(key, key)
        if name not in by_name:
            raise ModelError(f"Unknown parameter '{key}'; {nearest(str(key), by_name)}")
        by_name[name] = _number(value, name, model)
    missing = [name for name, value in by_name.items() if value is None]
    if missing:
        raise ModelError(
            f"No value for {'parameter' if len(missing) == 1 else 'parameters'} {', '.join(missing)}. "
            f"Give a default in s.parameters, or a value: values={{'{missing[0]}': ...}}."
        )
    return {name: float(value) for name, value in by_name.items() if value is not None}


def assumed(model: Model) -> tuple[Any, ...]:
    """Expressions of the parameters alone that are assumed positive, in a fixed order (`Model.assumed`).

    Assumptions on coordinates, such as ``cos(theta) > 0``, restrict the motion and cannot be checked from values.
    """
    symbols = {parameter.symbol for parameter in model.parameters}
    return tuple(
        expression
        for expression in sorted(model.positive, key=str)
        if isinstance(expression, sympy.Basic)
        and expression.free_symbols <= symbols
        and not expression.has(sympy.core.function.AppliedUndef)
    )


def check_assumptions(model: Model, numbers: Mapping[str, float]) -> None:
    """Refuse values that contradict the assumptions on the parameters (`Model.assumed`).

    Raises
    ------
    ModelError
        If an expression is not positive; the message shows it with its values.
    """
    for expression in model.assumed:
        check_assumption(model, expression, numbers)


def check_assumption(
    model: Model, expression: Expression, numbers: Mapping[str, float], where: str = ""
) -> None:
    """Refuse values for which an expression that is assumed positive is not; ``where`` begins the message."""
    symbols = {symbol.name: symbol for symbol in expression.free_symbols}
    value = float(evaluate(expression, {symbol: numbers[name] for name, symbol in symbols.items()}, floats))
    if not value > 0:
        values = ", ".join(f"{name} = {numbers[name]:g}" for name in sorted(symbols))
        raise ModelError(
            f"{where}Expected {str(expression).replace('**', '^')} > 0 in '{model.name}', as s.assume or its use says, "
            f"but {values} makes it {value:g}. Change the values, or take the assumption back."
        )


def _number(value: Expression, name: str, model: Model) -> float:
    """The value of a parameter as a float; text may have a unit."""
    if type(value) in _NUMBERS and abs(value) <= sys.float_info.max:
        return float(value) + 0  # -0.0 becomes 0.0, as it does in expressions
    if isinstance(value, str):
        declared = model.about.get(name, ("", ""))[0]
        value = quantity(value, declared or _unit_by_use(model, name), f"parameter '{name}'")
    expression = model.names.expression(value, f"the value of parameter '{name}'")
    if isinstance(expression, sympy.Basic) and expression.free_symbols:
        raise ModelError(f"Expected a number for parameter '{name}', got '{value}'.")
    return finite(expression, f"parameter '{name}'")


def _unit_by_use(model: Model, name: str) -> str:
    """Unit of a parameter, from its use in the machine; "" if the uses give none or different units.

    A use that gives a unit is the parameter, or a number times it, as a mass, a length of a solid, a component of a
    joint's point or of gravity, or the pressure angle of a gear.
    """
    used: list[tuple[str, Any]] = [("m/s^2", g) for g in model.gravity]
    for place in model.bodies.values():
        used.append(("kg", place.mass))
        shapes = [place.properties.shape] if place.properties and place.properties.shape else []
        while shapes:
            shape = shapes.pop()
            shapes += shape.parts
            if shape.kind not in ("mesh", "revolved"):
                used += [("m", length) for _, length in shape.dimensions]
    used += [("m", x) for joint in model.joints.values() for x in (*joint.at, *joint.to)]
    gears = [constraint for constraint in model.constraints.values() if isinstance(constraint, Gear)]
    used += [("rad", gear.pressure_angle) for gear in gears]
    units = {unit for unit, x in used if isinstance(x, sympy.Expr) and str(x.as_coeff_Mul()[1]) == name}
    return units.pop() if len(units) == 1 else ""
