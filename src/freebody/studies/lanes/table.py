"""Tables of lanes: one row, one lane."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...errors import SimulationError, shown
from ...model import Model
from .law import Array, Law, by_name, names_in, numbers_from


@dataclass(frozen=True, eq=False, repr=False)
class Table(Law):
    """One row of numbers for each lane.

    ``entries``   (name, values) of each column; values with a unit are texts until the table is resolved
    ``lanes``     number of lanes
    ``first``     lane of the first row of ``entries``, which is 0 but in a part of a table
    """

    entries: tuple[tuple[str, Any], ...]
    lanes: int
    first: int = 0

    @property
    def count(self) -> int:
        """Number of lanes."""
        return self.lanes

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(name for name, _ in self.entries)

    def columns(self, low: int, high: int) -> dict[str, Array]:
        """Return the values of the lanes ``low`` to ``high`` - 1 by name."""
        return {name: self._rows(values, name, low, high).copy() for name, values in self.entries}

    def part(self, low: int, high: int) -> Table:
        """Return the rows of the lanes ``low`` to ``high`` - 1; they keep their numbers."""
        rows = [(name, self._rows(values, name, low, high).copy()) for name, values in self.entries]
        return replace(self, entries=tuple(rows), first=low)

    def resolved(self, model: Model, where: str = "lanes") -> Table:
        """Return the table with names of the model, and numbers in place of texts."""
        names = names_in(model, self.names, where)
        entries = [
            (name, _column(values, name, where, model))
            for name, (_, values) in zip(names, self.entries, strict=True)
        ]
        return replace(self, entries=tuple(entries))

    def _rows(self, values: Any, name: str, low: int, high: int) -> Array:
        self._check(low, high)
        if not isinstance(values, np.ndarray):
            raise SimulationError(
                f"Expected numbers for '{name}', got texts. resolved(model) reads their units."
            )
        if not (self.first <= low and high - self.first <= len(values)):
            raise SimulationError(
                f"Expected lanes {self.first} to {self.first + len(values)}, which this part of a table holds, got "
                f"{low} to {high}."
            )
        return values[low - self.first : high - self.first]

    def __repr__(self) -> str:
        return f"table of {', '.join(self.names)}: {self._counted()}"


def table(data: Any = None, /, **columns: Any) -> Table:
    """Lanes of a study: one row of a table, one lane.

    Parameters
    ----------
    data : pandas.DataFrame, xarray.Dataset, mapping or structured array, optional
        Columns of parameters, and of initial values of coordinates and speeds, each of shape (lanes,). A dataset has
        one dimension, and its variables are the columns. Names are texts, such as "theta'", or symbols; values are
        numbers, or texts with a unit such as "30 deg".
    **columns
        The same as keyword arguments: ``fb.table(I=[0.3, 0.5], theta=[0.1, 0.2])``.

    Returns
    -------
    Table
        ``count`` is its number of lanes, ``columns(low, high)`` are the values of the lanes low to high - 1 by name.

    Raises
    ------
    SimulationError
        If columns are missing, have different lengths or more than one axis, or hold anything but finite numbers.

    Examples
    --------
    >>> import numpy as np
    >>> import freebody as fb
    >>> lanes = fb.table({"I": [0.3, 0.5, 0.4], "theta'": [1, 2, 4]})
    >>> lanes
    table of I, theta': 3 lanes
    >>> lanes.columns(1, 3)
    {'I': array([0.5, 0.4]), "theta'": array([2., 4.])}
    >>> fb.table(np.array([(1.0, 2.0)], dtype=[("m", float), ("L", float)]))
    table of m, L: 1 lane
    """
    entries = by_name(_mapping(data), columns, "fb.table")
    arrays = {name: _column(values, name, "the table", None) for name, values in entries.items()}
    first, *others = arrays
    for name in others:
        if len(arrays[name]) != len(arrays[first]):
            raise SimulationError(
                f"Expected columns of one length in the table, got {len(arrays[first])} values of '{first}' and "
                f"{len(arrays[name])} of '{name}'. Row k of every column belongs to lane k; for all combinations use "
                "fb.grid."
            )
    return Table(tuple(arrays.items()), len(arrays[first]))


def _mapping(data: Any) -> Any:
    """Return the columns of a table of any kind as a mapping."""
    pandas, xarray = sys.modules.get("pandas"), sys.modules.get("xarray")
    if pandas is not None and isinstance(data, pandas.DataFrame):
        if not data.columns.is_unique:
            twice = data.columns[data.columns.duplicated()][0]
            raise SimulationError(
                f"Expected each name once in the table, got '{twice}' twice. Leave one out."
            )
        return {name: data[name].to_numpy() for name in data.columns}
    if xarray is not None and isinstance(data, xarray.Dataset):
        if len(data.sizes) != 1:
            raise SimulationError(
                f"Expected a dataset with one dimension, the lanes, got {dict(data.sizes)}. For a dataset over a grid: "
                "dataset.stack(lane=[...]).reset_index('lane').reset_coords()."
            )
        if not data.data_vars:
            raise SimulationError(
                f"Expected the columns among the variables of the dataset, got coordinates only: "
                f"{', '.join(map(str, data.coords))}. Write fb.table(dataset.reset_coords())."
            )
        return {name: x.values for name, x in data.data_vars.items()}
    if isinstance(data, np.ndarray) and data.dtype.names:
        return {name: data[name] for name in data.dtype.names}
    if data is not None and not isinstance(data, Mapping):
        raise SimulationError(
            "Expected a pandas.DataFrame, an xarray.Dataset, a structured array, or columns by name, such as "
            f"fb.table({{'theta': [0.1, 0.2]}}), got {shown(data)}."
        )
    return data


def _column(entries: Any, name: str, where: str, model: Model | None) -> Any:
    """Return a column of the table: at least one number, all finite."""
    array = numbers_from(entries, name, where, model)
    if np.ndim(array) != 1 or not len(array):
        raise SimulationError(
            f"Expected one number for each lane for '{name}' in {where}, got shape {np.shape(array)}. A name with one "
            "value belongs in values= or initial=."
        )
    if isinstance(array, np.ndarray) and not np.isfinite(array).all():
        row = int(np.flatnonzero(~np.isfinite(array))[0])
        raise SimulationError(
            f"Expected finite numbers for '{name}' in {where}, got {array[row]} in row {row}. Leave that row out."
        )
    return array
