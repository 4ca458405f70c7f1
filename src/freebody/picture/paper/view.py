"""The map from space to paper: the plane of a planar machine, or an axonometric view."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...model.model import Model
from ...scalar.algebra import floats
from ...scalar.expression import evaluate
from ...symbolic.free_body.planar import normal_of

Array = NDArray[np.float64]

AZIMUTH, ELEVATION = math.radians(32), math.radians(22)
"""Position of the reader: x points toward the reader and left, y right, z up."""

ASIDE = math.radians(90) - AZIMUTH
"""Azimuth of a reader for whom x and y have changed their parts: points along x lie further apart."""


def _axonometric(azimuth: float) -> Array:
    along, up = math.cos(azimuth), math.sin(ELEVATION)
    return np.array(
        [[-math.sin(azimuth), along, 0.0], [-up * along, -up * math.sin(azimuth), math.cos(ELEVATION)]]
    )


@dataclass(frozen=True, eq=False)
class View:
    """A linear map of ground axes to paper: ``page = matrix @ point``, y upward.

    ``normal`` is the number of the ground axis at right angles to the plane of a planar machine, or None in space;
    ``toward`` points to the reader; ``gravity`` is the acceleration of gravity in ground axes [m/s²].
    """

    matrix: Array
    toward: Array
    normal: int | None = None
    gravity: Array | None = None

    @property
    def planar(self) -> bool:
        """True if the machine is drawn in its plane."""
        return self.normal is not None

    def __call__(self, points: Any) -> Array:
        """Map points in ground axes, shape (3,) or (n, 3), to paper, in units of length."""
        return np.asarray(points, dtype=float) @ self.matrix.T

    @property
    def axes(self) -> tuple[tuple[str, int], ...]:
        """Letters and numbers of the ground axes that the view shows."""
        return tuple(("xyz"[k], k) for k in range(3) if k != self.normal)

    def turn(self, moment: Any) -> float:
        """Component of a moment toward the reader, who sees it turn counter-clockwise if positive."""
        return float(np.dot(self.toward, np.asarray(moment, dtype=float)))


def view_of(
    model: Model,
    equations: Any,
    values: dict[str, float],
    axonometric: bool = False,
    azimuth: float = AZIMUTH,
) -> View:
    """Return the view in which a model is drawn: its plane, if it has one, and gravity downward where possible."""
    numbers = {p.symbol: values[p.name] for p in model.parameters}
    g = np.array([float(evaluate(c, numbers, floats)) for c in model.gravity])
    up = 2 if not g.any() else int(np.argmax(np.abs(g)))
    sign = -1.0 if g[up] > 0 else 1.0
    n = None if axonometric else normal_of(equations)
    if n is not None:
        across = [k for k in range(3) if k != n]
        high = up if g.any() and up != n else across[1]
        wide = next(k for k in across if k != high)
        matrix = np.zeros((2, 3))
        matrix[0, wide] = 1.0
        matrix[1, high] = sign if high == up and g.any() else 1.0
        return View(matrix, np.cross(matrix[0], matrix[1]), n, g)
    # a right-handed set whose third axis points up
    i, j = (up + 1) % 3, (up + 2) % 3
    if sign < 0:
        i, j = j, i
    matrix = np.zeros((2, 3))
    axes = _axonometric(azimuth)
    matrix[:, i], matrix[:, j], matrix[:, up] = axes[:, 0], axes[:, 1], sign * axes[:, 2]
    toward = np.cross(matrix[0], matrix[1])
    return View(matrix, toward / np.linalg.norm(toward), None, g)
