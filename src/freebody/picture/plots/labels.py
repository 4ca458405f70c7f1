"""Labels of plots: the names of a machine's quantities set as in its drawings, with their units."""

from __future__ import annotations

from collections.abc import Hashable
from typing import TYPE_CHECKING, Any

from ...errors import SimulationError
from ...motion.trajectory.outputs import OfContact, quantity_of
from ...motion.trajectory.units import unit_of
from ...symbolic.printing.latex import latex_name

if TYPE_CHECKING:
    from ...motion.trajectory.trajectory import Trajectory

SETTING: dict[str, Any] = {"fontsize": 11, "math_fontfamily": "stix"}
"""Type of the labels of axes; symbols are in the font of the drawings."""


def symbol(name: str) -> str:
    """Return the name of a coordinate, speed, acceleration or parameter as a symbol.

    >>> print(symbol("theta'"), symbol("omega_p"))
    $\\dot{\\theta}$ $\\omega_{p}$
    """
    base = name.rstrip("'")
    return f"${latex_name(base, len(name) - len(base))}$"


def text_of(trajectory: Trajectory, name: Any) -> str:
    """Return the name of a quantity as text."""
    if not isinstance(name, Hashable):
        raise SimulationError(f"Expected a name or an expression to plot, got {name!r}.")
    return name if isinstance(name, str) else trajectory.kernels.model.names.texts.get(name, str(name))


def unit(trajectory: Trajectory, name: Any) -> str:
    """Return the unit of a coordinate, a speed, a reaction or a quantity of a contact; empty for an expression."""
    text = text_of(trajectory, name)
    if text in trajectory.names:
        return unit_of(trajectory, text)
    model = trajectory.kernels.model
    found = next(iter(quantity_of(model, text).values()), None)
    if isinstance(found, OfContact):
        return found.unit(model)
    return found.unit if found else ""


def label(trajectory: Trajectory, name: Any) -> str:
    """Return the label of a quantity: a symbol if it is a coordinate, its rate or its acceleration; else its text."""
    text = text_of(trajectory, name)
    return symbol(text) if text.rstrip("'") in trajectory.kernels.model.coordinate_names else text


def with_unit(shown: str, unit: str) -> str:
    """Return a label with its unit, if it has one."""
    return f"{shown} [{unit}]".lstrip() if unit and unit != "1" else shown
