"""Units of the coordinates and speeds of a motion."""

from __future__ import annotations

from typing import Any

import sympy

from .computed_motion import ComputedMotion


def unit_of(trajectory: ComputedMotion, name: str) -> str:
    """Unit of a coordinate or speed: as described, else the unit of the joint it moves."""
    return unit_of_name(trajectory.kernels.model, name)


def unit_of_name(model: Any, name: str) -> str:
    """Unit of a coordinate or speed of a model."""
    base = name.rstrip("'")
    unit = model.about.get(base, ("", ""))[0] or _unit(model, name, base)
    return f"{unit}/s" if name.endswith("'") and unit else unit


def _unit(model: Any, name: str, base: str) -> str:
    if base == name and name not in model.coordinate_names:  # a component of an angular or linear velocity
        return "rad/s" if name[-2:-1] == "w" else "m/s"
    if "units_of_coordinates" not in model.memo:
        model.memo["units_of_coordinates"] = _units_of_coordinates(model)
    return str(model.memo["units_of_coordinates"].get(base, ""))


def _units_of_coordinates(model: Any) -> dict[str, str]:
    """Unit of each coordinate that is a position, a part of a quaternion, or moves joints of one kind alone."""
    names = {atom: name for name, atom in model.names.atoms.items()}
    used: dict[str, set[str]] = {}
    for link in model.links:
        if link.one_dof and isinstance(link.displacement, sympy.Basic):
            for part in sympy.preorder_traversal(link.displacement):
                if part in names:
                    used.setdefault(names[part], set()).add("m" if link.slides_only else "rad")
    result = {name: units.pop() for name, units in used.items() if len(units) == 1}
    for coordinate in model.coordinates:
        if coordinate.kind != "scalar":
            result[coordinate.name] = "m" if coordinate.kind == "position" else "1"
    return result
