"""Labels of plots: the names of a machine's quantities set as in its drawings, with their units."""

from __future__ import annotations

from collections.abc import Hashable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SimulationError
from ...motion.trajectory.outputs import OfContact, quantity_of
from ...motion.trajectory.units import unit_of
from ...symbolic.printing.latex import latex_name
from ...symbolic.printing.names import GREEK

if TYPE_CHECKING:
    from ...motion.trajectory.trajectory import Trajectory

Array = NDArray[np.float64]

SETTING: dict[str, Any] = {"fontsize": 11, "math_fontfamily": "stix"}
"""Type of the labels of axes; symbols are in the font of the drawings."""

HORIZONTAL, VERTICAL = {1: "left", 0: "center", -1: "right"}, {1: "bottom", 0: "center", -1: "top"}
"""Alignments of a text on a side of its point."""


def symbol(name: str) -> str:
    """Return the name of a coordinate, speed, acceleration or parameter as a symbol.

    >>> print(symbol("theta'"), symbol("omega_p"))
    $\\dot{\\theta}$ $\\omega_{p}$
    """
    base = name.rstrip("'")
    return f"${latex_name(base, len(name) - len(base))}$"


def name_of(name: str) -> str:
    """Return a name as a symbol if it reads as one, such as theta_1; else as words, with the symbols among them.

    >>> name_of("theta_1"), name_of("first_impact"), name_of("largest theta")
    ('$\\\\theta_{1}$', 'first impact', 'largest $\\\\theta$')
    """
    base = name.partition("_")[0].rstrip("'")
    if base in GREEK or len(base) == 1:
        return symbol(name)
    return " ".join(symbol(word) if word in GREEK else word for word in name.replace("_", " ").split(" "))


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


def free_side(v: Array, letters: int, longest: float, taken: list[Array]) -> Array:
    """Return the side of a point, in units of its gap, where a text is farthest from what is drawn; it is added."""
    boxes = []
    for side in np.array([(1, 1), (-1, 1), (1, -1), (-1, -1), (0, 1), (0, -1), (1, 0), (-1, 0)]):
        center = v + longest * side * (0.02 + 0.011 * letters * (side[0] != 0), 0.045)
        wide = longest * np.array([[0.011 * letters, 0.0]])
        boxes.append((center + np.linspace(-1, 1, 9)[:, None] * wide, side))
    drawn = np.concatenate(taken)
    distances = [np.linalg.norm(box[:, None] - drawn, axis=2).min() for box, _ in boxes]
    box, side = boxes[int(np.argmax(distances))]
    taken.append(box)
    return np.asarray(side)
