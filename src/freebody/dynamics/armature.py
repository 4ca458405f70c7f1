"""Inertia that turns with the displacements of joints: armature, and the rotors of motors behind gears.

With the displacement y of a joint, its armature A (of a rotor J behind a gear G: J G²), and the spin s = J G n per unit
rate of rotors that stand in the joint's parent P and do not move in it,

    T = ½ A y'² + y' s·w_P                          kinetic energy beyond that of the bodies
    τ = A y'' + s·α_P                               force along the displacement
    n_P = s y'' + w_P × s y'                        moment on the parent

The speeds of a ball or free joint are components in axes that turn with w, so that a force A (v' + w × v) drives the
armature A of the slides of a free joint.

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), §9.6; Lagrange's equations of T.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..model.model import GROUND, Model
from ..scalar.algebra import HALF, ZERO, Scalar, Vector, add, cross, dot, scale
from ..space.spatial import Spatial
from .state import State


def has_armature(model: Model) -> bool:
    """Return True if a joint has armature or turns a rotor."""
    return any(link.armature for link in model.links)


def rates(state: State, i: int) -> list[Scalar]:
    """Return the speeds of the own motions of link ``i``: y', or those of a ball or free joint."""
    link = state.model.links[i]
    return [state.rate(link)] if link.one_dof else list(state.u[link.u : link.u + len(link.armature)])


def armature_energy(state: State, i: int, V: Sequence[Spatial]) -> Scalar:
    """Return the kinetic energy of the armature and the rotors of a link's joint [J]; V are the links' motions."""
    armature = state.armature(i)
    if not armature:
        return 0
    speeds = rates(state, i)
    total: Scalar = 0
    for a, u in zip(armature, speeds, strict=True):
        total = total + a * u * u
    total = HALF * total
    spin, parent = state.spin(i), state.model.links[i].parent
    return total if spin is None or parent == GROUND else total + speeds[0] * dot(spin[0], V[parent][0])


def spin_rate(state: State, i: int, udot: Sequence[Scalar] | None, V: Sequence[Spatial]) -> Vector:
    """Return the moment s y'' + w_P × s y' that the rotors which link ``i`` turns need in its parent, in its axes."""
    link, spin = state.model.links[i], state.spin(i)
    if spin is None or link.parent == GROUND:
        return ZERO
    s = spin[0]
    return add(scale(state.second_rate(link, udot), s), cross(V[link.parent][0], scale(state.rate(link), s)))


def resistance(
    state: State, i: int, udot: Sequence[Scalar] | None, A: Sequence[Spatial]
) -> tuple[Scalar, ...]:
    """Return the forces that the armature of link ``i`` needs along its motions; A are the links' accelerations."""
    armature, link = state.armature(i), state.model.links[i]
    if not armature:
        return ()
    if link.one_dof:
        spin, along = state.spin(i), armature[0] * state.second_rate(link, udot)
        return (along if spin is None or link.parent == GROUND else along + dot(spin[0], A[link.parent][0]),)
    turned = turned_slides(state, i)
    second = [0] * len(armature) if udot is None else udot[link.u : link.u + len(armature)]
    return tuple(a * (x + c) for a, x, c in zip(armature, second, turned, strict=True))


def turned_slides(state: State, i: int, speeds: Sequence[Scalar] | None = None) -> tuple[Scalar, ...]:
    """Return the part of each relative acceleration of a ball or free joint that is not u': w × v of the slides.

    With ``speeds`` of the joint, v is that of these; w is always that of the state.
    """
    link = state.model.links[i]
    if not link.flies:
        return ZERO
    u = state.u[link.u : link.u + 6]
    v = u if speeds is None else speeds
    return (*ZERO, *cross((u[0], u[1], u[2]), (v[3], v[4], v[5])))
