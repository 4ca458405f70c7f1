"""Momentum of a system of bodies, and the translation theorem.

    p = Σ m v_C,        H_0 = Σ (r_C × m v_C + H_C),    H_C = I_C ω

Source: chapter 6, eqs (6.3), (6.17)-(6.19).
"""

from __future__ import annotations

from dataclasses import dataclass

from ..model.model import GROUND, Model
from ..scalar.algebra import ZERO, Scalar, Vector, add, apply, cross, divide, scale, subtract
from ..space.spatial import momentum_of
from .kinematics import link_postures, rotation, velocities
from .state import State


@dataclass(frozen=True)
class Momentum:
    """Linear momentum [kg m/s] and moment of momentum [kg m²/s] about a point, in ground axes."""

    linear: Vector
    angular: Vector
    about: Vector

    def shifted(self, to: Vector) -> Momentum:
        """Return the momentum about another point: H_B = H_A + (r_A - r_B) × p (translation theorem)."""
        return Momentum(self.linear, add(self.angular, cross(subtract(self.about, to), self.linear)), to)


def momentum(model: Model, state: State, about: Vector = ZERO, bodies: set[str] | None = None) -> Momentum:
    """Return the momentum of all bodies, or of those named, about a point of the ground in ground axes.

    Rotors that a joint turns belong to the joint's parent; armature has no momentum but that along its joint.
    """
    linear, angular = ZERO, ZERO
    V, postures = velocities(model, state), link_postures(model, state)
    for i, link in enumerate(model.links):
        if bodies is not None and link.body not in bodies:
            continue
        n, p = momentum_of(state.inertia(i), V[i])
        R, r = postures[i].rotation, postures[i].position
        p_N = apply(R, p)
        linear = add(linear, p_N)
        angular = add(angular, add(apply(R, n), cross(r, p_N)))
    for i, link in enumerate(model.links):
        carrier = model.links[link.parent].body if link.parent != GROUND else "ground"
        spin = state.spin(i)
        if spin is not None and (bodies is None or carrier in bodies):  # rotors in the ground turn, too
            R = rotation(model, state, link.parent)
            angular = add(angular, apply(R, scale(state.rate(link), spin[0])))
    return Momentum(linear, angular, ZERO).shifted(about)


def mass_centre(model: Model, state: State) -> tuple[Scalar, Vector]:
    """Return the total mass [kg] and the position of the mass centre, in ground axes [m]."""
    mass, first_moment = 0, ZERO
    for i, posture in enumerate(link_postures(model, state)):
        m, h, _ = state.inertia(i)
        mass = mass + m
        first_moment = add(first_moment, add(scale(m, posture.position), apply(posture.rotation, h)))
    x, y, z = first_moment
    return mass, (divide(x, mass), divide(y, mass), divide(z, mass))
