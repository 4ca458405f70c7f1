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
from ..scalar.algebra import floats
from ..scalar.expression import evaluate
from ..scalar.units import quantity

if TYPE_CHECKING:
    from .model import Model

_NUMBERS = frozenset((float, int, np.float64))


def parameter_values(model: Model, given: Mapping[Any, Any]) -> dict[str, float]:
    """See :meth:`Model.values`."""
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
    """What was assumed positive of the parameters alone, in a fixed order (`Model.assumed`).

    Assumptions on coordinates, such as ``cos(theta) > 0``, are of the motion and can not be asked of values.
    """
    known = {parameter.symbol for parameter in model.parameters}
    return tuple(
        expression
        for expression in sorted(model.positive, key=str)
        if isinstance(expression, sympy.Basic)
        and expression.free_symbols <= known
        and not expression.has(sympy.core.function.AppliedUndef)
    )


def check_assumptions(model: Model, numbers: Mapping[str, float]) -> None:
    """Refuse values that contradict what was assumed of the parameters (`Model.assumed`).

    Raises
    ------
    ModelError
        The expression that is not positive, with the values in it.
    """
    for expression in model.assumed:
        check_assumption(model, expression, numbers)


def check_assumption(model: Model, expression: Any, numbers: Mapping[str, float], where: str = "") -> None:
    """Refuse values at which an expression that was assumed positive is not."""
    known = {symbol.name: symbol for symbol in expression.free_symbols}
    value = float(evaluate(expression, {symbol: numbers[name] for name, symbol in known.items()}, floats))
    if not value > 0:
        shown = ", ".join(f"{name} = {numbers[name]:g}" for name in sorted(known))
        raise ModelError(
            f"{where}Expected {str(expression).replace('**', '^')} > 0 in '{model.name}', as s.assume or its use says, "
            f"but {shown} makes it {value:g}. Change the values, or take the assumption back."
        )


def _number(value: Any, name: str, model: Model) -> float:
    if type(value) in _NUMBERS and abs(value) <= sys.float_info.max:
        return float(value) + 0  # an expression of -0 is 0
    if isinstance(value, str):
        declared = model.about.get(name, ("", ""))[0]
        value = quantity(value, declared or _unit_by_use(model, name), f"parameter '{name}'")
    expression = model.names.expression(value, f"the value of parameter '{name}'")
    if isinstance(expression, sympy.Basic) and expression.free_symbols:
        raise ModelError(f"Expected a number for parameter '{name}', got '{value}'.")
    return finite(expression, f"parameter '{name}'")


def _unit_by_use(model: Model, name: str) -> str:
    """The unit of a parameter that is, but for a number, a mass, a length of a solid, a component of a joint's point
    or of gravity, or the pressure angle of a gear; none where it stands nowhere alone, or as one and as another."""
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
    gears = [one for one in model.constraints.values() if isinstance(one, Gear)]
    used += [("rad", gear.pressure_angle) for gear in gears]
    alone = {unit for unit, x in used if isinstance(x, sympy.Expr) and str(x.as_coeff_Mul()[1]) == name}
    return alone.pop() if len(alone) == 1 else ""
