"""Motions beside a measurement: residuals and their derivatives by the unknowns of a fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..errors import FreebodyError, NoDerivativesError, SimulationError
from .measurement import Array
from .simulate import simulate


class Computed(NamedTuple):
    """Weighted residuals (computed minus measured), their Jacobian, and the motions."""

    residuals: Array
    jacobian: Array
    motions: list[Any]


@dataclass(eq=False)
class Comparison:
    """Motions with values p of the unknowns, beside measurements.

    ``measured``, ``weights``    of each measurement (`measurement.measured_by`, `measurement.weights_of`)
    ``initials``, ``values``     initial values of each motion, and values of parameters, by name
    ``bounds``                   least and greatest values of the unknowns
    ``options``                  further arguments of `simulate`;  ``calls``: how often motions were computed
    """

    machine: Any
    unknowns: Sequence[Any]
    measured: Sequence[tuple[Array, dict[str, Array]]]
    weights: Sequence[dict[str, Array]]
    initials: Sequence[Mapping[str, Any]]
    values: Mapping[Any, Any]
    bounds: tuple[Array, Array]
    options: Mapping[str, Any]
    calls: int = 0
    _last: tuple[bytes, Computed] | None = None

    def at(self, p: Array) -> Computed:
        """Return the motions at these unknowns, beside the measurement."""
        key = p.tobytes()
        if self._last is None or self._last[0] != key:
            self._last = None
            try:
                motions = self._motions(p, [x.name for x in self.unknowns])
                residuals, rows = self._compared(motions, True)
                J = np.concatenate(rows)
            except NoDerivativesError:
                motions = self._motions(p, None)
                residuals, J = self._compared(motions, False)[0], self._differences(p)
            self._last = key, Computed(residuals, J, motions)
        return self._last[1]

    def residuals(self, p: Array, count: int) -> Array:
        """Return the residuals, or ``count`` huge ones where there is no motion: a search then takes a shorter step."""
        try:
            return self.at(p).residuals
        except FreebodyError:
            return np.full(count, 1e150)

    def _motions(self, p: Array, sensitive: list[str] | None) -> list[Any]:
        self.calls += 1
        at = {x.name: value for x, value in zip(self.unknowns, p.tolist(), strict=True)}
        parameters = {**self.values, **{x.name: at[x.name] for x in self.unknowns if x.symbol is not None}}
        searched = {x.name: at[x.name] for x in self.unknowns if x.symbol is None}
        return [
            simulate(
                self.machine, float(times.max()), initial={**fixed, **searched}, values=parameters,
                times=np.unique(times), sensitivities=sensitive, progress=False, **self.options,
            )
            for (times, _), fixed in zip(self.measured, self.initials, strict=True)
        ]  # fmt: skip

    def _compared(self, motions: list[Any], sensitive: bool) -> tuple[Array, list[Array]]:
        """Return residuals of motions, and their derivatives if they are asked for."""
        residuals, rows = [], []
        for (times, columns), motion, scales in zip(self.measured, motions, self.weights, strict=True):
            places = np.searchsorted(motion.t, times)
            for name, array in columns.items():
                finite = np.isfinite(array)
                at = places[finite]
                if at.size and at.max() >= len(motion.t):
                    raise SimulationError(
                        "A terminal event ended the motion before the last measurement. Leave it out."
                    )
                residuals.append((motion[name][at] - array[finite]) / scales[name][finite])
                if sensitive:
                    rows.append(motion.sensitivity.of(name)[at] / scales[name][finite][:, None])
        return np.concatenate(residuals), rows

    def _differences(self, p: Array) -> Array:
        """Central differences over h = ε^⅓: their own error h² is as large as that of the motions, ε/h."""
        columns, h = [], self.options["tolerance"] ** (1 / 3) * np.where(p != 0, np.abs(p), 1.0)
        for j, step in enumerate(np.diag(h)):
            ends = [np.clip(p + side * step, *self.bounds) for side in (1, -1)]
            after, before = (self._compared(self._motions(end, None), False)[0] for end in ends)
            columns.append((after - before) / (ends[0][j] - ends[1][j]))
        return np.column_stack(columns)
