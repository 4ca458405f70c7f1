"""Kinetic and potential energy, and the power of loads without potential.

    T = ½ Σ V·(I V),        V = -Σ m g·r_C + ½ Σ k (displacement - rest)²

Source: chapter 6, eq (6.35): T = ½ m v_C² + ½ ω·H_C.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..model.model import Model
from ..scalar.algebra import HALF, Scalar, add, apply, dot, scale
from ..space.spatial import momentum_of, power
from .armature import armature_energy, has_armature
from .kinematics import link_postures, velocities
from .loads.added_mass import added_energy
from .loads.loading import Loading, load_potential, load_power
from .newton_euler import drive_power
from .state import State


def kinetic_energy(model: Model, state: State) -> Scalar:
    """Return the kinetic energy of all bodies, of the armature of joints, and of added mass [J]."""
    total: Scalar = 0
    V = velocities(model, state)
    for i, V_i in enumerate(V):
        total = total + power(V_i, momentum_of(state.inertia(i), V_i))
    total = HALF * total
    for i in range(len(V)) if has_armature(model) else ():
        total = total + armature_energy(state, i, V)
    return total + added_energy(model, state)


def potential_energy(model: Model, state: State) -> Scalar:
    """Return the potential energy of weights (zero at the ground's origin) and springs (zero at zero force) [J]."""
    g = state.vector(model.gravity)
    total = load_potential(model, state)
    if g == (0, 0, 0):
        return total
    for i, posture in enumerate(link_postures(model, state)):
        m, h, _ = state.inertia(i)
        total = total - dot(g, add(scale(m, posture.position), apply(posture.rotation, h)))
    return total


def mechanical_power(
    model: Model, state: State, udot: Sequence[Scalar], loads: Loading | None = None
) -> Scalar:
    """Return the rate of change of the total energy: power of loads without potential, and of drives [W].

    Only drives use ``udot`` and ``loads``: all loads, constraint forces included (by default the model's loads).
    """
    return load_power(model, state) + drive_power(model, state, udot, loads)
