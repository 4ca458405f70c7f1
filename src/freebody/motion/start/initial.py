"""The initial state: the names and values of the user become the state (q, u)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from ...errors import ExpressionError, SimulationError, nearest
from ...model import Model
from ...scalar.algebra import Expression, floats
from ...scalar.expression import evaluate
from ...scalar.units import quantity
from ...space.rotation import Rotation
from ..kernels.reading import expression_of


def number(model: Model, values: Mapping[str, float], value: Expression, what: str) -> float:
    """Return a finite number from a number, or from an expression or text of the parameters."""
    if type(value) in _NUMBERS and math.isfinite(value):
        return float(value) + 0.0  # -0.0 becomes 0.0
    try:
        expression = expression_of(model, value, what)
    except ExpressionError:
        refuse_unit(value, what)
        raise
    if isinstance(expression, sympy.Basic):
        moving = model.names.depends(expression, "coordinate", "speed", "time")
        if moving:
            raise SimulationError(
                f"Expected a number or an expression of parameters for {what}, "
                f"but '{expression}' depends on {', '.join(moving)}."
            )
        lookup = {parameter.symbol: values[parameter.name] for parameter in model.parameters}
        try:
            expression = evaluate(expression, lookup, floats)
        except (ValueError, ZeroDivisionError, OverflowError) as error:
            raise SimulationError(
                f"Expected a number for {what}, but '{value}' has no value: {error}."
            ) from None
    result = float(expression)
    if not math.isfinite(result):
        raise SimulationError(f"Expected a finite number for {what}, got {value!r}.")
    return result


def refuse_unit(value: Expression, what: str) -> None:
    """Raise SimulationError if a text that is no expression is a number with a unit."""
    try:
        amount = quantity(value, "", what) if isinstance(value, str) else None
    except ExpressionError:
        return
    if isinstance(amount, sympy.Basic | int | float):
        raise SimulationError(
            f"Expected a number, or an expression of parameters, without a unit for {what}, got '{value}'. Write "
            f"{amount} (in m, kg, s and rad), or make it a parameter: units are read in values=."
        )


def initial_state(
    model: Model, values: Mapping[str, float], initial: Mapping[Any, Any]
) -> NDArray[np.float64]:
    """Return the state (q, u), shape (n_q + n_u,). Everything not named is zero, and every rotation the identity."""
    return np.array(named_numbers(model, values, initial)[0])


def named_state(
    model: Model, values: Mapping[str, float], initial: Mapping[Any, Any], where: str = "initial"
) -> tuple[NDArray[np.float64], set[int]]:
    """Return the state (q, u) and the indices of its named components.

    Parameters
    ----------
    model : Model
    values : mapping of str to float
        Values of all parameters.
    initial : mapping
        By name or SymPy atom of a coordinate or speed: a number, or an expression or text of parameters. By
        name of a ball or free joint: its quaternion (w, x, y, z), or a Rotation (parent from child axes).

    Raises
    ------
    SimulationError
        An unknown name (with the nearest known one), a value given twice, a quaternion of length zero.
    """
    y, names = named_numbers(model, values, initial, where)
    return np.array(y), set(names)


def named_numbers(
    model: Model, values: Mapping[str, float], initial: Mapping[Any, Any], where: str = "initial"
) -> tuple[list[float], dict[int, Any]]:
    """Return the state of `named_state` as a list, and the names by index."""
    if not isinstance(initial, (dict, Mapping)):  # dict first: it is the faster check
        raise SimulationError(f"Expected {where} values by name, such as {{'theta': 0.1}}, got {initial!r}.")
    places = model.places
    y = list(model.rest)
    names: dict[int, Any] = {}
    for key, value in initial.items():
        name = key if isinstance(key, str) else model.names.texts.get(key, str(key))
        i = places.get(name)
        if i is not None and i not in names and type(value) in _NUMBERS and math.isfinite(value):
            names[i], y[i] = key, float(value)
            continue
        if i is not None:
            parts = [number(model, values, value, f"the initial value of '{name}'")]
        else:
            quaternions = quaternions_by_joint(model)
            if name not in quaternions:
                raise SimulationError(
                    f"Unknown name '{name}' in {where}; {nearest(name, [*places, *quaternions])}{_cure(name, places)}"
                )
            i, parts = quaternions[name], _quaternion(model, values, value, name)
        for place, part in enumerate(parts, i):
            if place in names:
                raise SimulationError(
                    f"The initial value of '{list(places)[place]}' is given twice, as '{names[place]}' and as '{key}'. "
                    "Leave one out."
                )
            names[place], y[place] = key, part
    for start in model.quaternions:
        inside = range(start, start + 4)
        if names.keys().isdisjoint(inside):
            continue
        four = np.array([y[i] if i in names else 0.0 for i in inside])
        length = float(np.linalg.norm(four))
        if length == 0:
            raise SimulationError(
                f"Expected a quaternion ({', '.join(model.coordinate_names[start : start + 4])}) of length 1, got all "
                "zeros. Leave it out for no rotation, or give (1, 0, 0, 0)."
            )
        y[start : start + 4] = (four / length).tolist()
    return y, names


def several(value: Any) -> Any:
    """Return a value as a list, tuple or array if it has several entries; None if it is a single value.

    Ranges and arrays of any library become NumPy arrays.
    """
    if isinstance(value, list | tuple):
        return value
    if isinstance(value, range) or (hasattr(value, "__array__") and not isinstance(value, Rotation)):
        value = np.asarray(value)
        return value if value.ndim else None
    return None


def asks_for_many(model: Model, initial: Any, values: Any) -> bool:
    """Return True if a value of a parameter, or an initial value, has an axis of lanes.

    The components of a quaternion are no axis of lanes.
    """
    parameters = values if values is not None and isinstance(values, (dict, Mapping)) else {}
    start = initial if initial is not None and isinstance(initial, (dict, Mapping)) else {}
    if _SINGLE.issuperset(map(type, chain(parameters.values(), start.values()))):
        return False

    def many(value: Any, own_axes: int) -> bool:
        value = several(value)
        if value is None:
            return False
        if len(value) and isinstance(value[0], Rotation):
            return True
        try:
            return np.ndim(value) > own_axes
        except ValueError:
            return True

    quaternions = quaternions_by_joint(model)
    return any(many(value, 0) for value in parameters.values()) or any(
        many(value, int(str(key) in quaternions)) for key, value in start.items()
    )


_NUMBERS = frozenset((float, int, np.float64))
_SINGLE = _NUMBERS | {str}
"""Types of a value without an axis."""


def quaternions_by_joint(model: Model) -> dict[str, int]:
    """Return the index, among the coordinates, of the quaternion of each ball and free joint."""
    return {link.joint: link.quaternion for link in model.links if link.own}


def _quaternion(model: Model, values: Mapping[str, float], value: Any, joint: str) -> list[float]:
    if isinstance(value, Rotation):
        return [float(part) for part in value.as_quaternion()]
    if isinstance(value, str) or not isinstance(value, Sequence | np.ndarray) or len(value) != 4:
        raise SimulationError(
            f"Expected a quaternion (w, x, y, z) or a Rotation for joint '{joint}' in initial, got {value!r}. "
            "For angles: fb.Rotation.euler('ZXZ', psi, theta, phi)."
        )
    return [number(model, values, part, f"the initial quaternion of joint '{joint}'") for part in value]


def _cure(name: str, places: Mapping[str, int]) -> str:
    if name.endswith("_dot") and name[:-4] + "'" in places:
        return f' A speed is written with a prime: "{name[:-4]}\'".'
    return ""
