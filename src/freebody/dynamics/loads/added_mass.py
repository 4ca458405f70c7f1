"""Added mass: the part of loads that is linear in the accelerations of bodies, as that of a fluid which moves along.

With the accelerations A of all bodies and their motions V, a load that asks for accelerations is

    F = F_0(q, u, t) - B(q, t) A,        B symmetric,

so that B is inertia. It stands in the mass matrix and in the kinetic energy beside that of the bodies,

    M u' = Q - h,   M = M_bodies + Jᵀ B J,        T = T_bodies + ½ V·B V,

and the power of the load beyond dT/dt is that of F at u' = 0, and the change of ½ V·B V at constant speeds.

Source: Lamb, Hydrodynamics (1932), §§118-124.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from ...describe.loads.action import Action, Couple, PointForce
from ...model.model import Model
from ...scalar.algebra import HALF, Scalar, Vector
from ...scalar.series import SeriesField, derivative_at_start
from ...space.spatial import Spatial
from ..kinematics import (
    accelerations,
    link_twists,
    replaced,
    state_along,
    velocities,
)
from ..state import State
from .actions import accelerating, actions
from .power import power_in


def moving(model: Model, state: State, udot: Sequence[Scalar] | None) -> State:
    """Return the state with the accelerations that loads ask for; itself if none does, or ``udot`` is None."""
    if udot is None or not accelerating(model):
        return state
    return state.accelerated(accelerations(model, state, udot))


def added_forces(model: Model, state: State, twists: Sequence[Spatial]) -> Iterator[tuple[str, Action]]:
    """Yield (load, action) of -B A for accelerations A of the links, the part linear in them."""
    field = SeriesField(state.field, 1)
    still = replaced(state, field, state.t, state.q, [0] * model.n_u)
    growing = [tuple(tuple(field.series([0, x]) for x in v) for v in twist) for twist in twists]
    along = still.accelerated(growing)  # type: ignore[arg-type]
    for name in sorted(accelerating(model)):
        for action in actions(model, along, name):
            match action:
                case PointForce():
                    yield name, replace(action, force=_linear(action.force))
                case Couple():
                    yield name, replace(action, moment=_linear(action.moment))


def _linear(v: Vector) -> Vector:
    x, y, z = v
    return (derivative_at_start(x), derivative_at_start(y), derivative_at_start(z))


def added_mass(model: Model, state: State) -> tuple[tuple[Scalar, ...], ...] | None:
    """Return Jᵀ B J, symmetric, of shape (n_u, n_u); None if no load asks for accelerations."""
    if not accelerating(model):
        return None
    units = [[int(j == k) for k in range(model.n_u)] for j in range(model.n_u)]
    twists = [link_twists(model, state, unit) for unit in units]
    M: list[list[Scalar]] = [[0] * model.n_u for _ in units]
    for j in range(model.n_u):
        for _, action in added_forces(model, state, twists[j]):
            for k in range(j + 1):
                M[j][k] = M[j][k] - power_in(model, state, action, twists[k])
        for k in range(j):
            M[k][j] = M[j][k]
    return tuple(map(tuple, M))


def added_energy(model: Model, state: State) -> Scalar:
    """Return ½ V·B V, kinetic energy of what the loads set in motion [J]."""
    if not accelerating(model):
        return 0
    V = velocities(model, state)
    total: Scalar = 0
    for _, action in added_forces(model, state, V):
        total = total - power_in(model, state, action, V)
    return HALF * total


def added_energy_rate(model: Model, state: State) -> Scalar:
    """Return d(½ V·B V)/dt at constant speeds u [W]."""
    if not accelerating(model):
        return 0
    return derivative_at_start(added_energy(model, state_along(model, state, state.u, 1, 1)))
