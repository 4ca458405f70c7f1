"""Regressor Y: the forces that a motion needs are linear in the inertia of the bodies, τ = Y(q, u, u') θ.

A body has ten parameters θ about its origin O, in its axes: m, the first moment h = m c, and the moment of inertia I.
With the acceleration a of O, less that of gravity, and B = [α]× + [w]×²,

    n = I α + w × I w + h × a,        f = m a + B h

so that each parameter, alone and of size 1, needs one wrench; its column of Y is the power of that wrench per unit
speed. Armature, rotors and loads have no part in it.

Source: C. Atkeson, C. An, J. Hollerbach, Estimation of inertial parameters of manipulator loads and links (1986).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..model.model import GROUND, Model
from ..scalar.algebra import IDENTITY, ZERO, Matrix, Scalar, Vector, add, apply, cross, negate
from ..space.spatial import Spatial, motion_to_child, plus, power, rigid_inertia, times
from .kinematics import accelerations, motions, turning, velocities
from .state import State

PARAMETERS = ("m", "hx", "hy", "hz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
"""Inertial parameters of a body, in the order of Pinocchio and of most of the literature on identification."""
_ENTRIES = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))


def regressor(model: Model, state: State, udot: Sequence[Scalar]) -> tuple[tuple[Scalar, ...], ...]:
    """Return Y, by rows: one for each speed, with ten columns for each body."""
    V, S = velocities(model, state), _motions_in_links(model, state)
    A = accelerations(model, state, udot, negate(state.vector(model.gravity)))
    columns: list[list[Scalar]] = []
    for place in model.bodies.values():
        if place.link == GROUND:
            columns += [[0] * model.n_u for _ in PARAMETERS]
            continue
        origin = state.vector(place.origin)
        (w, _), (alpha, a) = V[place.link], A[place.link]
        B = turning(w, alpha)
        for n, f in _wrenches(w, alpha, add(a, apply(B, origin)), B):
            force = (add(n, cross(origin, f)), f)
            column: list[Scalar] = [0] * model.n_u
            for j, motion in S[place.link].items():
                column[j] = power(motion, force)
            columns.append(column)
    return tuple(zip(*columns, strict=True))


def inertial_parameters(model: Model, state: State) -> tuple[Scalar, ...]:
    """Return θ: ten parameters for each body, about its origin in its axes."""
    result: list[Scalar] = []
    for place in model.bodies.values():
        m, h, inertia = rigid_inertia(
            state(place.mass), state.vector(place.center), state.matrix(place.inertia)
        )
        result += [m, *h, *(inertia[j][k] for j, k in _ENTRIES)]
    return tuple(result)


def parameter_names(model: Model) -> tuple[str, ...]:
    """Names of θ, such as ``arm.hx``."""
    return tuple(f"{body}.{name}" for body in model.bodies for name in PARAMETERS)


def _wrenches(w: Vector, alpha: Vector, a: Vector, B: Matrix) -> Iterator[Spatial]:
    """Yield the wrench about the origin that each parameter needs."""
    yield ZERO, a
    for k, axis in enumerate(IDENTITY):
        yield cross(axis, a), (B[0][k], B[1][k], B[2][k])
    for j, k in _ENTRIES:
        yield add(_times(j, k, alpha), cross(w, _times(j, k, w))), ZERO


def _times(j: int, k: int, v: Vector) -> Vector:
    """Return E v: E is 1 at (j, k) and (k, j), else 0."""
    result: list[Scalar] = [0, 0, 0]
    result[j], result[k] = v[k], v[j]
    return (result[0], result[1], result[2])


def _motions_in_links(model: Model, state: State) -> list[dict[int, Spatial]]:
    """Return, for each link, its motion in the ground per unit of each speed that moves it, in its axes."""
    result: list[dict[int, Spatial]] = []
    for i, link in enumerate(model.links):
        R, p, _ = state.joint(i)
        above = {} if link.parent == GROUND else result[link.parent]
        moved = {j: motion_to_child(R, p, S) for j, S in above.items()}
        for j, factor, S in motions(model, state, i):
            own = times(factor, S)
            moved[j] = plus(moved[j], own) if j in moved else own
        result.append(moved)
    return result
