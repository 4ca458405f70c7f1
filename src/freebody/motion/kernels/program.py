"""Compiled functions of (t, y), with the constants that the parameters give."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..ode.dense_output import observe, outputs_at
from .hoisted import Hoisted, add_constants

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Program:
    """A compiled set of functions of (t, y) and the parameters."""

    compiled: Any
    _last: list[tuple[bytes, Array]] = field(default_factory=list, compare=False)

    def address(self, name: str) -> int:
        """Address of a function."""
        return int(self.compiled[name].address)

    def outputs(self, name: str) -> int:
        """Number of outputs of a function."""
        return int(self.compiled[name].outputs)

    def follow(self, hoisted: Hoisted, constants: Array) -> None:
        """Let constants of the functions follow the parameters that a run writes."""
        add_constants(hoisted, self.compiled.prologue.address, constants)

    def constants(self, parameters: Array) -> Array:
        """Constants of the functions, computed once per run from the parameters. The last result is cached."""
        key = parameters.tobytes()
        last = self._last[0] if self._last else (b"", None)  # another thread may replace it meanwhile
        if last[1] is None or last[0] != key:
            last = key, np.ascontiguousarray(self.compiled.constants(parameters), dtype=float)
            self._last[:] = [last]
        return last[1].copy()


def at_state(program: Any, function: str, t: float, y: Array, constants: Array) -> Array:
    """Return the outputs of a function of a program at one state."""
    row = np.ascontiguousarray(y, dtype=float)
    return outputs_at(program.address(function), program.outputs(function), t, row, constants)


def at_states(program: Any, function: str, times: Array, states: Array, constants: Array) -> Array:
    """Return the outputs of a function of a program, shape (k, outputs), at each of k times and states."""
    return observe(program.address(function), program.outputs(function), times, states, constants)


@dataclass(frozen=True)
class Conditions(Program):
    """A compiled set of functions of the conditions, which give the matrix G by its entries.

    ``rows``, ``columns``  places of the entries of G, row by row
    ``shape``              numbers of conditions and speeds
    """

    rows: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64), compare=False)
    columns: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64), compare=False)
    shape: tuple[int, int] = (0, 0)

    @cached_property
    def pattern(self) -> NDArray[np.int64]:
        """Place of the first entry of each row and of the end, then the columns."""
        starts = np.searchsorted(self.rows, np.arange(self.shape[0] + 1))
        return np.concatenate([starts, self.columns]).astype(np.int64)

    def observed(self, function: str, times: Array, states: Array, constants: Array) -> Array:
        """Return the outputs of a function, shape (k, outputs), at states (q, u), shape (k, n_q + n_u)."""
        selection = np.zeros((len(states), sum(self.shape)))
        moved = np.concatenate([states, selection], axis=1)
        return at_states(self, function, times, moved, constants)

    def entries(self, outputs: Array) -> Array:
        """Return the entries of G, row by row, from the outputs of "conditions" or "motion" at one state."""
        m = self.shape[0]
        return outputs[m : m + self.columns.size]

    def matrix(self, outputs: Array) -> Array:
        """Return G as :meth:`entries`, with its zeros."""
        G = np.zeros(self.shape)
        G[self.rows, self.columns] = self.entries(outputs)
        return G
