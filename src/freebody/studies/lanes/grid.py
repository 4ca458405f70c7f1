"""Grids of lanes: every combination of the values of some names, by index arithmetic."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...errors import SimulationError
from ...model import Model
from .law import Array, Law, by_name, names_in, numbers_from

MOST = 1 << 40
"""Greatest number of lanes of a grid."""


@dataclass(frozen=True, eq=False, repr=False)
class Grid(Law):
    """Every combination of the values of some names; the last name varies fastest.

    ``axes``   (name, values) of each axis; values with a unit are texts until the grid is resolved
    """

    axes: tuple[tuple[str, Any], ...]

    @property
    def count(self) -> int:
        """Number of lanes, the product of the lengths of the axes."""
        return math.prod(self.shape)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the axes."""
        return tuple(name for name, _ in self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each axis."""
        return tuple(len(values) for _, values in self.axes)

    def columns(self, low: int, high: int) -> dict[str, Array]:
        """Return the values of the lanes ``low`` to ``high`` - 1 by name."""
        self._check(low, high)
        result: dict[str, Array] = {}
        stride = 1
        for name, values in reversed(self.axes):
            if not isinstance(values, np.ndarray):
                raise SimulationError(
                    f"Expected numbers for '{name}', got texts. resolved(model) reads their units."
                )
            # lanes r stride ... (r + 1) stride - 1 have value r mod n
            rows = np.arange(low // stride, -(-high // stride))
            lengths = np.minimum((rows + 1) * stride, high) - np.maximum(rows * stride, low)
            result[name] = np.repeat(values[rows % len(values)], lengths)
            stride *= len(values)
        return {name: result[name] for name in self.names}

    def resolved(self, model: Model, where: str = "lanes") -> Grid:
        """Return the grid with names of the model, and numbers in place of texts."""
        names = names_in(model, self.names, where)
        axes = [
            (name, _axis(values, name, where, model))
            for name, (_, values) in zip(names, self.axes, strict=True)
        ]
        return Grid(tuple(axes))

    def shaped(self, data: Any) -> Any:
        """Return the dataset with the axes of the grid in place of the lanes."""
        import xarray

        names = {name: name if name in data.coords else f"{name}_start" for name in self.names}
        variables: dict[str, Any] = {}
        for name, variable in data.data_vars.items():
            if "lane" not in variable.dims:  # of lanes that failed
                variables[name] = variable.variable
                continue
            dims = [d for d in variable.dims if d != "lane"]
            array = variable.transpose("lane", *dims).data
            variables[name] = (
                (*names.values(), *dims), array.reshape(*self.shape, *array.shape[1:]), variable.attrs
            )  # fmt: skip
        coordinates: dict[str, Any] = {
            names[name]: (names[name], array, data[names[name]].attrs if names[name] in data.coords else {})
            for name, array in self.axes
        }
        for name in ("time", "event", "by", "failed_lane"):
            if name in data.coords:
                coordinates[name] = data[name].variable
        result = xarray.Dataset(variables, coords=coordinates, attrs=data.attrs)
        result.set_close(data.close)
        return result

    def __repr__(self) -> str:
        axes = " × ".join(f"{len(values)} {name}" for name, values in self.axes)
        return f"grid of {axes}: {self._counted()}"


def grid(axes: Mapping[Any, Any] | None = None, /, **more: Any) -> Grid:
    """Lanes of a study: every combination of the values of some names.

    Lane k has the values x_i[(k // (n_{i+1} ... n_d)) mod n_i] of the names i = 1 ... d: the last name varies fastest.
    The combinations are computed where the lanes run; a grid of 10^12 lanes takes as much memory as its axes.

    Parameters
    ----------
    axes : mapping of name to array, optional
        Values of parameters, and initial values of coordinates and speeds, each of shape (n_i,). Names are texts,
        such as "theta'", or symbols; values are numbers, or texts with a unit such as "30 deg".
    **more
        The same as keyword arguments: ``fb.grid(I=[0.3, 0.5], theta=np.linspace(0, 3, 200))``.

    Returns
    -------
    Grid
        ``count`` is its number of lanes, ``columns(low, high)`` are the values of the lanes low to high - 1 by name.

    Raises
    ------
    SimulationError
        If an axis is not a list of different finite numbers, or the grid has more than 2^40 lanes.

    Examples
    --------
    >>> import freebody as fb
    >>> lanes = fb.grid(I=[0.3, 0.5], theta=[0.1, 0.2, 0.4])
    >>> lanes
    grid of 2 I × 3 theta: 6 lanes
    >>> lanes.columns(2, 5)
    {'I': array([0.3, 0.5, 0.5]), 'theta': array([0.4, 0.1, 0.2])}
    >>> fb.grid({"theta'": range(1000), "m": range(1, 10**6), "L": range(1, 1000)})
    grid of 1000 theta' × 999999 m × 999 L: 998999001000 lanes
    """
    return grid_of(by_name(axes, more, "fb.grid"), "the grid", "fb.grid({})")


def grid_of(axes: Mapping[str, Any], where: str, call: str) -> Grid:
    """Return the grid of axes by name; ``where``, and the ``call`` that takes them, are for messages."""
    result = Grid(tuple((name, _axis(values, name, where, None, call)) for name, values in axes.items()))
    if result.count > MOST:
        raise SimulationError(
            "Expected fewer than 10^12 runs. Vary fewer parameters, or fewer values of each."
        )
    return result


def _axis(entries: Any, name: str, where: str, model: Model | None, call: str = "") -> Any:
    """Return the values of an axis: at least one, finite, and all different."""
    array = numbers_from(entries, name, where, model)
    if np.ndim(array) != 1 or not len(array):
        example = call.format(f"{{'{name}': [1, 2, 3]}}")
        raise SimulationError(
            f"Expected a list of at least one number for '{name}' in {where}, got {entries!r}. Write {example}; a name "
            "with one value belongs in values= or initial=."
        )
    if isinstance(array, np.ndarray) and not np.isfinite(array).all():
        raise SimulationError(f"Expected finite numbers for '{name}' in {where}, got {entries!r}.")
    if len(set(array.tolist() if isinstance(array, np.ndarray) else array)) < len(array):
        raise SimulationError(f"Expected different numbers for '{name}' in {where}, got {entries!r}.")
    return array
