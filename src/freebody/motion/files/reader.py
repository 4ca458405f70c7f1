"""Parts of a file, checked: arrays of the shape and the range that they must have."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import SimulationError
from ..ode.dense_output import Array
from .save import GROUP

if TYPE_CHECKING:
    pass


def damaged(source: Any, why: Any) -> SimulationError:
    """Return the error for a file that does not hold what it says."""
    return SimulationError(f"Expected a motion that was saved whole in '{source}', but it is damaged: {why}.")


def parts_of(source: Any) -> dict[str, Any]:
    """Return the arrays of the group."""
    import h5py

    try:
        with h5py.File(source, "r") as file:
            if GROUP not in file or not isinstance(file.get(GROUP, getlink=True), h5py.HardLink):
                raise SimulationError(
                    f"Expected a motion that was saved by freebody in '{source}', found a table alone. "
                    "xarray.load_dataset(path) reads that."
                )
            group = file[GROUP]
            names = {name for name in group if isinstance(group.get(name, getlink=True), h5py.HardLink)}
            arrays = {
                name: x
                for name in names
                if isinstance(x := group[name], h5py.Dataset) and x.dtype.kind in "fiu"
            }
            if sum(x.nbytes for x in arrays.values()) > source.stat().st_size:  # arrays are not compressed
                raise damaged(source, "it is shorter than what it holds")
            return {name: x[()] for name, x in arrays.items() if not x.external and not x.is_virtual}
    except (OSError, RuntimeError) as error:
        raise SimulationError(
            f"Expected a trajectory in netCDF format in '{source}', but it cannot be read: {error}"
        ) from None


class Reader:
    """Arrays of given shapes, in the memory layout of compiled code."""

    def __init__(self, parts: Mapping[str, Any]) -> None:
        self.parts = parts

    def reals(self, name: str, shape: tuple[int | None, ...]) -> Array:
        """Return an array of real numbers."""
        return np.ascontiguousarray(self._checked(name, shape), dtype=float)

    def integers(self, name: str, shape: tuple[int | None, ...], below: int) -> Any:
        """Return an array of integers from 0 to ``below`` - 1."""
        array = np.ascontiguousarray(self._checked(name, shape), dtype=np.int64)
        if array.size and not 0 <= array.min() <= array.max() < below:
            raise ValueError(f"'{name}' has numbers that mean nothing")
        return array

    def _checked(self, name: str, shape: tuple[int | None, ...]) -> Any:
        array = self.parts[name]
        if array.ndim != len(shape) or any(
            want not in (None, have) for want, have in zip(shape, array.shape, strict=True)
        ):
            raise ValueError(f"'{name}' has the shape {array.shape}")
        return array
