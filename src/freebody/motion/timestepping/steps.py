"""What a run in steps of fixed length leaves: the states at the ends of its steps, and the impulses of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..ode.dense_output import Array, Path, within
from .pair_motion import PairLog

IMPULSES = [0, 1, 2, 4, 5, 6]
"""Columns of the entries of pairs that are impulses."""


@dataclass(eq=False)
class Steps(Path):
    """States at the ends of the steps, with linear interpolation between them."""

    curved = False
    method: str = "Moreau-Jean time stepping, exact Coulomb cones"

    def sample(self, times: Any, dense: bool = False) -> Array:
        """Return the states at the given times, by linear interpolation; quaternions are normalized."""
        del dense
        wanted = within(self, times)
        k = np.clip(np.searchsorted(self.times, wanted, side="right") - 1, 0, max(len(self.times) - 2, 0))
        if len(self.times) == 1:
            return np.repeat(self.states, wanted.size, axis=0)
        x = ((wanted - self.times[k]) / (self.times[k + 1] - self.times[k]))[:, None]
        y = (1 - x) * self.states[k] + x * self.states[k + 1]
        for i in self.rates.quaternions:
            y[:, i : i + 4] /= np.linalg.norm(y[:, i : i + 4], axis=1, keepdims=True)
        return y


@dataclass(frozen=True, eq=False)
class Impulses:
    """Impulses, work and contact modes of every step.

    ``contacts`` (m) and ``constraints`` (all conditions): impulses [N s]. ``works`` [J]: of contacts and blows; of
    loads and constraints. ``corrections`` (n_q + n_u): changes of the state at the end of a step that
    separate bodies. ``modes`` (E): indices into :data:`MODES`. ``blows``: for each step with blows, a list of
    (name, [(point, impulse, moment impulse)]). ``pairs``: for each step, an entry for each pair of families that
    presses (`families.family_record.ENTRY`).
    """

    contacts: Array
    constraints: Array
    works: Array
    corrections: Array
    modes: Any
    blows: Mapping[int, Sequence[tuple[str, Any]]]
    pairs: PairLog


@dataclass(frozen=True)
class Stepping:
    """Measures of a motion in time steps; see the attributes of :class:`Trajectory` of these names."""

    step: float
    residual: float
    depth: float
    sweeps: float
    reduced: float = 0.0
