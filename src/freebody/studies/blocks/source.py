"""Where the values of lanes come from: a law that says those of lane k, or arrays with an entry for each lane.

A source has ``count`` lanes and three methods: ``arguments(low, high)``, the values and initial values of lanes;
``weights(low, high)``, their importance weights; and ``part(low, high)``, a source of these lanes that is small enough
to be sent with a block, or itself, if it is small.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from ...motion.batch.start import Lanes
    from ..lanes.law import Law


@dataclass(frozen=True)
class ByLaw:
    """Lanes of a law.

    ``law``          says what varies
    ``parameters``   names among them that are parameters; the others are initial values
    ``values``       values of parameters that all lanes share
    ``initial``      initial values that all lanes share
    """

    law: Law
    parameters: tuple[str, ...]
    values: Mapping[Any, Any]
    initial: Mapping[Any, Any]

    @property
    def count(self) -> int:
        """Number of lanes."""
        return self.law.count

    def arguments(self, low: int, high: int) -> tuple[dict[Any, Any], dict[Any, Any]]:
        """Return ``values`` and ``initial`` of the lanes ``low`` to ``high`` - 1."""
        columns = self.law.columns(low, high)
        values = {name: x for name, x in columns.items() if name in self.parameters}
        starts = {name: x for name, x in columns.items() if name not in self.parameters}
        return {**self.values, **values}, {**self.initial, **starts}

    def weights(self, low: int, high: int) -> Any:
        """Return the importance weights of lanes; None if all are 1."""
        return self.law.weights(low, high)

    def part(self, low: int, high: int) -> ByLaw:
        """Return a source of these lanes."""
        part = self.law.part(low, high)
        return self if part is self.law else replace(self, law=part)


@dataclass(frozen=True, eq=False)
class ByArrays:
    """Lanes of arrays, the first of which is lane ``first`` of the study.

    ``values``, ``initial``   numbers, texts and expressions that all lanes share, or arrays and lists
    ``starts``                names of the initial values that are arrays or lists
    """

    count: int
    values: Mapping[str, Any]
    initial: Mapping[str, Any]
    starts: tuple[str, ...]
    first: int = 0

    @classmethod
    def of(cls, lanes: Lanes) -> ByArrays:
        """Return the source of lanes."""
        return cls(lanes.count, lanes.columns, lanes.initial, lanes.varied[1])

    def arguments(self, low: int, high: int) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return ``values`` and ``initial`` of the lanes ``low`` to ``high`` - 1."""
        rows = slice(low - self.first, high - self.first)
        values = {name: x[rows] if np.ndim(x) else float(x) for name, x in self.values.items()}
        return values, {name: x[rows] if name in self.starts else x for name, x in self.initial.items()}

    def weights(self, low: int, high: int) -> None:
        """Return None: all weights are 1."""

    def part(self, low: int, high: int) -> ByArrays:
        """Return a source of these lanes."""
        values, initial = self.arguments(low, high)
        return replace(self, values=values, initial=initial, first=low)
