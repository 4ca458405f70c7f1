"""Quantities of a motion at its output times: energies, reactions, poses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SimulationError, nearest

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Energy:
    """The energy ledger at the output times, each of shape (n,) [J].

    ``work`` is the work done since the start by loads without potential and by drives; ``residual`` is the error of the
    ledger, (T + V) - (T₀ + V₀) - W, zero except for the error of the integration. ``impulses`` is the part of the work
    done by blows and impacts, ``friction`` the part done by friction of contacts, ``correction`` the part of a motion
    in time steps that moves overlapping bodies apart at the ends of steps; each is None if there are none.
    """

    kinetic: Array
    potential: Array
    work: Array
    residual: Array
    impulses: Array | None = None
    friction: Array | None = None
    correction: Array | None = None

    @property
    def total(self) -> Array:
        """Kinetic and potential energy."""
        return self.kinetic + self.potential

    @property
    def relative_residual(self) -> float:
        """Greatest residual, relative to the greatest kinetic energy, potential energy or work."""
        scale = max(float(np.max(np.abs(part))) for part in (self.kinetic, self.potential, self.work))
        worst = float(np.max(np.abs(self.residual)))
        return worst / scale if scale > 0 else worst


LEDGER = {
    "kinetic_energy": "kinetic", "potential_energy": "potential", "energy": "total", "work": "work",
    "energy_residual": "residual",
}  # fmt: skip
"""Parts of `Energy` by the names that outputs have for them."""


@dataclass(frozen=True, eq=False)
class Reaction:
    """Force and moment that a joint transmits, at the output times.

    ``force`` [N] and ``moment`` [N m], shape (n, 3), act **on** the body ``on``; the moment is **about** the point
    ``about``; components in the axes of ``frame``.
    """

    force: Array
    moment: Array
    on: str
    about: str
    frame: str = "ground"


@dataclass(frozen=True, eq=False)
class BodyPose:
    """Pose of a body at the output times: ``position`` (n, 3) of its origin in ground axes [m], ``rotation`` R_NB
    (n, 3, 3), and the unit ``quaternion`` (n, 4), scalar first, continuous in time.
    """

    position: Array
    rotation: Array

    @cached_property
    def quaternion(self) -> Array:
        """Unit quaternion (n, 4), scalar first, continuous in time."""
        return quaternions(self.rotation)


class ByName(dict[str, Any]):
    """Dictionary whose error for an unknown name offers the nearest one."""

    def __init__(self, what: str, items: Mapping[str, Any]) -> None:
        super().__init__(items)
        self.what = what

    def __missing__(self, name: Any) -> Any:
        raise SimulationError(f"Unknown {self.what} '{name}'; {nearest(str(name), self)}")

    def __getitem__(self, name: Any) -> Any:
        return super().__getitem__(name) if isinstance(name, str) else self.__missing__(name)


def quaternions(rotation: Array) -> Array:
    """Return unit quaternions (n, 4), scalar first, of rotation matrices (n, 3, 3), without jumps of sign along n.

    Of the four columns of 4 e eᵀ, whose diagonal is 1 + a R₁₁ + b R₂₂ + c R₃₃, the column with the greatest diagonal is
    used, so that no division is by a small number. Source: Shepperd (1978).
    """
    R = rotation
    x, y, z = R[:, 0, 0], R[:, 1, 1], R[:, 2, 2]
    a, b, c = R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]
    d, e, f = R[:, 1, 0] + R[:, 0, 1], R[:, 0, 2] + R[:, 2, 0], R[:, 2, 1] + R[:, 1, 2]
    columns = np.array(
        [
            [1 + x + y + z, a, b, c],
            [a, 1 + x - y - z, d, e],
            [b, d, 1 - x + y - z, f],
            [c, e, f, 1 - x - y + z],
        ]
    )
    best = np.argmax(np.einsum("iin->in", columns), axis=0)
    q = columns[best, :, np.arange(len(R))]
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    if len(q):
        turns = np.sign(np.einsum("ni,ni->n", q[1:], q[:-1]))
        turns[turns == 0] = 1
        first = -1.0 if q[0, 0] < 0 else 1.0
        q *= (first * np.concatenate([[1.0], np.cumprod(turns)]))[:, None]
    return q
