"""Sliders of a live page: parameters that the motion or the drawing depends on, initial values, length of the run."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any

from ...describe.description import about_of
from ...describe.system import System
from ...dynamics.state import float_state, rest_coordinates
from ...model.model import Model
from ...model.symbols import symbols_of

NEAREST = 20
"""Part of its value from which the slider of a parameter begins that must be positive: 1 / NEAREST."""
FEW = 12
"""Most sliders of parameters, or of speeds, that stand open."""


def sliders(
    system: System, model: Model, values: Mapping[str, float], initial: Mapping[Any, Any], near: Mapping[Any, Any],
    without: Collection[str] = (),
) -> list[dict[str, Any]]:  # fmt: skip
    """Return sliders with their values, ranges and units; parameters named in ``without`` have none."""
    result = []
    about = about_of(system)
    relevant = relevant_parameters(system, model, initial, near).difference(without)
    for name, x in values.items():
        if name not in relevant:
            continue
        unit, text = about.get(name, ("", ""))
        low, high = range_of(model, name, x)
        result.append(slider("values", name, x, low, high, unit, text))
    rest = dict(zip(model.coordinate_names, map(float, rest_coordinates(model)), strict=True))
    start = start_of(system, model, values, initial)
    scalars = {c.name for c in model.coordinates if c.kind == "scalar"}
    # with constraints, only initial values that the model gives have sliders: all others follow from these
    for name in model.coordinate_names:
        if name in scalars and (not model.constraints or name in start):
            x = float(start.get(name, rest[name]))
            limits = {} if system.reading is None else system.reading.limits.get(name, {})
            low = min(limits.get("lower", -math.pi), 2 * x if x < 0 else x)
            high = max(limits.get("upper", math.pi), 2 * x if x > 0 else x)
            follows = followed(system, model, initial, name)
            result.append(slider("initial", name, x, low, high, "", "at the start", follows))
    for name in model.speed_names:
        if not model.constraints or name in start:
            x = float(start.get(name, 0.0))
            reach = max(10.0, 2 * abs(x))
            follows = followed(system, model, initial, name)
            result.append(slider("initial", name, x, -reach, reach, "", "at the start", follows))
    return folded(result, set(model.speed_names))


def folded(sliders: list[dict[str, Any]], speeds: Collection[str]) -> list[dict[str, Any]]:
    """Return the sliders; those of many parameters, and of many speeds, stand under a heading that opens them."""
    for heading, group in (
        ("Parameters", [one for one in sliders if one["group"] == "values"]),
        ("Speeds at the start", [one for one in sliders if one["name"] in speeds]),
    ):
        for one in group if len(group) > FEW else ():
            one["fold"] = heading
    return sliders


def range_of(model: Model, name: str, value: float) -> tuple[float, float]:
    """Return the ends of the slider of a parameter."""
    if name in {str(expression) for expression in model.assumed}:
        return value / NEAREST, 2 * value
    return (min(0.0, 2 * value), max(0.0, 2 * value)) if value else (-1.0, 1.0)


def slider(
    group: str,
    name: str,
    value: float,
    low: float,
    high: float,
    unit: str,
    about: str,
    follows: Sequence[str] = (),
) -> dict[str, Any]:
    """Return a slider; ``follows`` are the parameters on which an initial value depends until it is moved."""
    return {
        "group": group,
        "name": name,
        "value": value,
        "low": low,
        "high": high,
        "unit": unit,
        "about": about,
        "follows": list(follows),
    }


def relevant_parameters(
    system: System, model: Model, initial: Mapping[Any, Any], near: Mapping[Any, Any]
) -> set[str]:
    """Return the names of the parameters that the motion or the drawing depends on."""
    solids = [body.mass_properties for body in system.bodies.values()]
    start = [expression for x in (*initial.values(), *near.values()) for expression in expressions(system, x)]
    parts = (
        model.links, model.loads, model.gravity, model.constraints, model.contacts, model.controllers, solids, start
    )  # fmt: skip
    return {symbol.name for symbol in symbols_of(parts)}


def expressions(system: System, value: Any) -> list[Any]:
    """Return the expressions in an initial value: one, or four of a quaternion; none of a rotation."""
    if isinstance(value, tuple | list):
        return [system.expression(x) for x in value]
    return [] if hasattr(value, "as_quaternion") else [system.expression(value)]


def followed(system: System, model: Model, initial: Mapping[Any, Any], name: str) -> list[str]:
    """Return the names of the parameters that an initial value depends on."""
    parameters = {parameter.name for parameter in model.parameters}
    given = named(model, initial).get(name, 0)
    return sorted({symbol.name for symbol in symbols_of(system.expression(given))} & parameters)


def start_of(
    system: System, model: Model, values: Mapping[str, float], initial: Mapping[Any, Any]
) -> dict[str, float]:
    """Return the initial values that are given for single coordinates and speeds."""
    state = float_state(model, values=values)
    names = model.state_names
    return {
        name: float(state(system.expression(value)))
        for name, value in named(model, initial).items()
        if name in names
    }


def named(model: Model, initial: Mapping[Any, Any]) -> dict[str, Any]:
    """Return initial values by the names of coordinates, speeds and joints."""
    texts = model.names.texts
    return {
        key if isinstance(key, str) else texts.get(key, str(key)): value for key, value in initial.items()
    }
