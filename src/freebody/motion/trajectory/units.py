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
    for coordinate in model.coordinates:
        if coordinate.name == base and coordinate.kind != "scalar":
            return "m" if coordinate.kind == "position" else "1"
    atom = model.names.atoms[base]
    if base == name and name not in model.coordinate_names:  # a component of an angular or linear velocity
        return "rad/s" if name[-2:-1] == "w" else "m/s"
    units = {
        "m" if link.kind == "slider" else "rad"
        for link in model.links
        if link.one_dof and isinstance(link.displacement, sympy.Basic) and link.displacement.has(atom)
    }
    return units.pop() if len(units) == 1 else ""
