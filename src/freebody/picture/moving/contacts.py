"""Contacts of a motion as a page shows them: forces, gaps, and the points where the bodies touch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...dynamics.conditions.contact import touches
from ...dynamics.state import State
from ...model.contact import friction_margin
from ...motion.contact.course import distances
from ...motion.ode.dense_output import observe
from ...motion.phase.candidates.candidates import layout_of, stretch_numbers
from ...scalar.algebra import ZERO, Scalar

if TYPE_CHECKING:
    from ...motion.trajectory.trajectory import Trajectory

Array = NDArray[np.float64]

FRAME = 18
"""Count of the numbers that describe a contact: gap, normal (3), two tangents (6), place (3), static
friction, adhesion, ratio of two coefficients of friction, reaches (2)."""


@dataclass(frozen=True, eq=False)
class Touched:
    """All contacts at n moments.

    Attributes
    ----------
    names : tuple of str
        Names of the contacts.
    forces : list of ndarray (n, 1 + tangents)
        For each contact N and the components of T [N]; least in norm where the motion does not determine them.
    gap : ndarray (n, contacts)
        Distances [m]; infinite beyond the ends of a side without corners for what is beside it.
    normal, place : ndarray (n, contacts, 3)
        Normal, and point of the feature [m], in ground axes.
    tangents : ndarray (n, contacts, 2, 3)
        Tangents in ground axes; the second is zero in a planar machine.
    static : ndarray (n, contacts)
        Coefficients of static friction.
    adhesion, ratio : ndarray (n, contacts)
        Pull that a contact bears [N], and ratio of the coefficients of friction across and along its direction.
    """

    names: tuple[str, ...]
    forces: list[Array]
    gap: Array
    normal: Array
    tangents: Array
    place: Array
    static: Array
    adhesion: Array
    ratio: Array

    def force(self, k: int, friction: bool) -> Array:
        """Normal force N n, or friction T, on the feature of contact k, in ground axes, shape (n, 3) [N]."""
        components = self.forces[k]
        if not friction:
            return np.asarray(components[:, :1] * self.normal[:, k])
        width = components.shape[1] - 1
        return np.asarray(np.einsum("ij,ijk->ik", components[:, 1:], self.tangents[:, k, :width]))

    def margin(self, k: int) -> Array:
        """Friction margin μ_s N - |T| of contact k, shape (n,) [N]."""
        components = self.forces[k]
        pressure, ratio = components[:, 0] + self.adhesion[:, k], self.ratio[:, k]
        return np.asarray(friction_margin(self.static[:, k], pressure, components[:, 1:].T, ratio, np.sqrt))


class Contacts:
    """Geometry of the contacts of a trajectory at any time."""

    def __init__(self, trajectory: Trajectory) -> None:
        self.trajectory = trajectory
        self.kernels = kernels = trajectory.kernels
        self.model = model = kernels.model
        self.first, _, self.rows = layout_of(model)
        self.ratios = stretch_numbers(model, trajectory.numbers)
        self.widths = [1 + contact.tangents for contact in model.contacts]

        def frames(state: State) -> dict[str, Sequence[Scalar]]:
            numbers: list[Scalar] = []
            for contact, touch in zip(model.contacts, touches(model, state), strict=True):
                first, second = (*touch.tangents, ZERO, ZERO)[:2]
                numbers += [touch.gap, *touch.normal, *first, *second, *touch.on_feature]
                numbers += [state(contact.static_friction), state(contact.adhesion), state(contact.stretch)]
                numbers += touch.both_reaches
            return {"frames": numbers}

        self.program = kernels.program("contact frames", frames)
        self.constants = self.program.constants(kernels.parameters(trajectory.numbers))

    def geometry(self, times: Array, states: Array) -> Array:
        """Gap, normal, tangents and place of all contacts, shape (n, FRAME contacts)."""
        return observe(
            self.program.address("frames"), FRAME * len(self.widths), times, states, self.constants
        )

    def touched(self, forces: Array, geometry: Array) -> Touched:
        """Return forces and geometry of all contacts at these moments together."""
        frame = geometry.reshape(len(geometry), len(self.widths), FRAME)
        gap, reach = frame[:, :, 0], frame[:, :, 16:].min(axis=2)
        return Touched(
            tuple(contact.name for contact in self.model.contacts),
            [forces[:, at : at + n] for at, n in zip(self.first, self.widths, strict=True)],
            distances(self.model, gap, reach, np.zeros_like(gap))[0],
            frame[:, :, 1:4],
            frame[:, :, 4:10].reshape(len(frame), len(self.widths), 2, 3),
            frame[:, :, 10:13],
            *(frame[:, :, k] for k in (13, 14, 15)),
        )
