"""Some lanes of a law."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...model import Model
from .law import Array, Law


@dataclass(frozen=True, eq=False, repr=False)
class Chosen(Law):
    """Lanes of another law, by their numbers there."""

    law: Law
    lanes: np.ndarray[Any, np.dtype[np.int64]]

    @property
    def count(self) -> int:
        """Number of lanes."""
        return len(self.lanes)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters and initial values that vary."""
        return self.law.names

    def columns(self, low: int, high: int) -> dict[str, Array]:
        """Return the values of the lanes ``low`` to ``high`` - 1 by name, each of shape (high - low,)."""
        self._check(low, high)
        parts = [self.law.columns(first, last) for first, last in self._ranges(low, high)]
        return {name: np.concatenate([part[name] for part in parts]) for name in self.names if parts} or {
            name: np.empty(0) for name in self.names
        }

    def weights(self, low: int, high: int) -> Array | None:
        """Return the importance weights of the lanes; None if all are 1."""
        self._check(low, high)
        parts = [self.law.weights(first, last) for first, last in self._ranges(low, high)]
        weights = [part for part in parts if part is not None]
        return np.concatenate(weights) if weights else None

    def resolved(self, model: Model, where: str = "lanes") -> Chosen:
        """Return the law with names of the model, and numbers in place of texts."""
        return replace(self, law=self.law.resolved(model, where))

    def _ranges(self, low: int, high: int) -> list[tuple[int, int]]:
        """Return the ranges of consecutive numbers among some of the lanes."""
        numbers = self.lanes[low:high]
        breaks = np.flatnonzero(np.diff(numbers) != 1) + 1
        return [(int(x[0]), int(x[-1]) + 1) for x in np.split(numbers, breaks) if x.size]

    def __repr__(self) -> str:
        return f"{self._counted()} of a {self.law!r}"
