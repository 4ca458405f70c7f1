"""Positions, velocities and accelerations of the bodies.

Outward along the tree, in the axes of each link:

    V_i = X_i V_parent + vJ_i                        vJ = S y'

    α_i = Rᵀ α_parent + w_i × w_J + n y''
    a_i = Rᵀ (a_parent + B_parent p) + 2 Rᵀ w_parent × v_J + w_J × v_J + s y''          B = [α]× + [w]×²

a is the acceleration of the link's origin, so that a point p of the link has a + B p. It needs no linear velocities;
with spatial accelerations these would be multiplied and then cancel.

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), §5.2 for V; §2.11 for the two kinds of acceleration.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ..model.model import GROUND, Link, Model, Place
from ..scalar.algebra import (
    IDENTITY,
    ZERO,
    Field,
    Matrix,
    Scalar,
    Vector,
    add,
    add_matrices,
    apply,
    apply_transpose,
    cross,
    divide,
    multiply,
    skew,
    subtract,
)
from ..scalar.series import Series, SeriesField, derivative_at_start
from ..space.quaternion import quaternion_rate
from ..space.spatial import ZERO6, Spatial, motion_to_child, plus, times
from .state import State


@dataclass(frozen=True)
class Posture:
    """Rotation ``R_NB`` (ground from body) and position ``p_NB_N`` of a body's origin in ground axes [m]."""

    rotation: Matrix
    position: Vector


@dataclass(frozen=True)
class Spot:
    """The place on a body at which a force acts now, in ground axes; it may move over the body."""

    body: Any
    position: Vector


def velocities(model: Model, state: State) -> list[Spatial]:
    """Return the motion (w, v) of every link in the ground, about its origin, in its axes."""
    if "velocities" not in state.cache:
        result: list[Spatial] = []
        for i, link in enumerate(model.links):
            R, p, vJ = state.joint(i)
            V_P = ZERO6 if link.parent == GROUND else result[link.parent]
            result.append(state.intermediate("velocity", i, plus(motion_to_child(R, p, V_P), vJ)))
        state.cache["velocities"] = result
    return state.cache["velocities"]


def accelerations(
    model: Model, state: State, udot: Sequence[Scalar] | None, ground: Vector = ZERO
) -> list[Spatial]:
    """Return the angular acceleration of every link and the acceleration of its origin, in its axes.

    ``ground`` is the acceleration of the ground. With ``udot`` None: the part free of accelerations u'.
    """
    V = velocities(model, state)
    result: list[Spatial] = []
    for i, link in enumerate(model.links):
        R, p, (wJ, vJ) = state.joint(i)
        w_P, alpha, a = ZERO, ZERO, ground
        if link.parent != GROUND:
            w_P = V[link.parent][0]
            alpha, a = result[link.parent]
            a = add(a, apply(turning(w_P, alpha), p))
        alpha = add(apply_transpose(R, alpha), cross(V[i][0], wJ))
        w_P = apply_transpose(R, w_P)
        a = add(apply_transpose(R, a), cross(add(add(w_P, w_P), wJ), vJ))
        A = (alpha, a)
        if link.one_dof:
            A = plus(A, times(state.second_rate(link, udot), state.subspace(i)))
        elif link.u >= 0 and udot is not None:
            A = plus(A, _joint_rates(link, udot))
        result.append(state.intermediate("acceleration", i, A))
    return result


def turning(w: Vector, alpha: Vector) -> Matrix:
    """Return B = [α]× + [w]×²: B p is the acceleration of a body's point at p relative to its origin."""
    x, y, z = w
    xx, yy, zz, xy, yz, zx = x * x, y * y, z * z, x * y, y * z, z * x
    return add_matrices(skew(alpha), ((-(yy + zz), xy, zx), (xy, -(zz + xx), yz), (zx, yz, -(xx + yy))))


def _joint_rates(link: Link, udot: Sequence[Scalar]) -> Spatial:
    u = link.u
    w = (udot[u], udot[u + 1], udot[u + 2])
    return (w, (udot[u + 3], udot[u + 4], udot[u + 5])) if link.flies else (w, ZERO)


def link_postures(model: Model, state: State) -> list[Posture]:
    """Return the pose of every link's frame in the ground."""
    if "postures" not in state.cache:
        result: list[Posture] = []
        for i, link in enumerate(model.links):
            R, p, _ = state.joint(i)
            if link.parent == GROUND:
                result.append(Posture(R, p))
            else:
                P = result[link.parent]
                result.append(Posture(multiply(P.rotation, R), add(P.position, apply(P.rotation, p))))
        state.cache["postures"] = result
    return state.cache["postures"]


def poses(model: Model, state: State) -> dict[str, Posture]:
    """Return the pose of every body's frame in the ground."""
    if "poses" not in state.cache:
        links = link_postures(model, state)
        result = {}
        for name, place in model.bodies.items():
            link = links[place.link]
            shift = apply(link.rotation, state.vector(place.origin))
            result[name] = Posture(link.rotation, add(link.position, shift))
        state.cache["poses"] = result
    return state.cache["poses"]


def rotation(model: Model, state: State, link: int) -> Matrix:
    """Return R_NL of a link, the identity for the ground."""
    return IDENTITY if link == GROUND else link_postures(model, state)[link].rotation


def place_of(model: Model, body: Any) -> tuple[int, Vector]:
    """Return the link of a body and the body's origin in it, (GROUND, 0) for the ground."""
    if body.is_ground:
        return GROUND, ZERO
    place: Place = model.bodies[body.name]
    return place.link, place.origin


def point_position(model: Model, state: State, point: Any) -> Vector:
    """Return the position of a point in the ground, in ground axes [m]."""
    if isinstance(point, Spot):
        return point.position
    link, _ = place_of(model, point.body)
    p_LP_L = arm(model, state, point)
    if link == GROUND:
        return p_LP_L
    posture = link_postures(model, state)[link]
    return add(posture.position, apply(posture.rotation, p_LP_L))


def arm(model: Model, state: State, point: Any) -> Vector:
    """Return the position of a point from the origin of its body's link, in axes of the link [m]."""
    link, origin = place_of(model, point.body)
    if isinstance(point, Spot):
        posture = link_postures(model, state)[link]
        return apply_transpose(posture.rotation, subtract(point.position, posture.position))
    return state.vector(tuple(a + b for a, b in zip(origin, point.components, strict=True)))


def point_velocity(model: Model, state: State, point: Any) -> Vector:
    """Return the velocity of a point of a body in the ground, in ground axes [m/s].

    The velocity of a spot is that of the point of the body that is there now.
    """
    if place_of(model, point.body)[0] == GROUND:
        return ZERO
    return carried(model, state, point, velocities(model, state))


def carried(model: Model, state: State, point: Any, twists: Sequence[Spatial]) -> Vector:
    """Return the velocity of a point in ground axes if the links move with these (w, v) of their origins."""
    link, _ = place_of(model, point.body)
    if link == GROUND:
        return ZERO
    w, v = twists[link]
    if isinstance(point, Spot):
        posture = link_postures(model, state)[link]
        r = subtract(point.position, posture.position)
        return add(apply(posture.rotation, v), cross(apply(posture.rotation, w), r))
    return apply(rotation(model, state, link), add(v, cross(w, arm(model, state, point))))


def point_acceleration(model: Model, state: State, point: Any, udot: Sequence[Scalar]) -> Vector:
    """Return the acceleration of a point in the ground, in ground axes [m/s²]."""
    return accelerated(model, state, point, accelerations(model, state, udot))


def accelerated(model: Model, state: State, point: Any, links: Sequence[Spatial]) -> Vector:
    """Return the acceleration of a point in ground axes [m/s²] from those of the links (:func:`accelerations`)."""
    link, _ = place_of(model, point.body)
    if link == GROUND:
        return ZERO
    alpha, a = links[link]
    turned = turning(velocities(model, state)[link][0], alpha)
    return apply(rotation(model, state, link), add(a, apply(turned, arm(model, state, point))))


def angular_velocity(model: Model, state: State, body: Any) -> Vector:
    """Return the angular velocity of a body in the ground, in ground axes [rad/s]."""
    link, _ = place_of(model, body)
    return ZERO if link == GROUND else apply(rotation(model, state, link), velocities(model, state)[link][0])


def link_twists(model: Model, state: State, u: Sequence[Scalar]) -> list[Spatial]:
    """Return (w, v) of every link about its origin, in its axes, at these speeds with the drives at rest.

    They are also the changes of the links' motions at jumps u of the speeds, and of their accelerations with u'.
    """
    result: list[Spatial] = []
    for i, link in enumerate(model.links):
        R, p, _ = state.joint(i)
        twist = ZERO6 if link.parent == GROUND else motion_to_child(R, p, result[link.parent])
        for j, factor, S in motions(model, state, i):
            twist = plus(twist, times(factor * u[j], S))
        result.append(twist)
    return result


def coordinate_rates(model: Model, state: State) -> tuple[Scalar, ...]:
    """Return q' from q and u: u itself, and for ball and free joints

    e' = ½ e ∘ (0, w),    p' = R v.
    """
    rates: list[Scalar] = [None] * model.n_q
    speeds = iter(range(model.n_u))
    by_name = {speed.name: state.u[i] for i, speed in zip(speeds, model.speeds, strict=True)}
    for i, coordinate in enumerate(model.coordinates):
        if coordinate.kind == "scalar":
            rates[i] = by_name[coordinate.name + "'"]
    for i, link in enumerate(model.links):
        if not link.own:
            continue
        w, v = state.joint(i)[2]
        start = link.q
        if link.flies:
            # v is in link axes; p is in the joint axes on the parent, E' R = R(e)
            E = state.matrix(link.rotation)
            R = state.joint(i)[0]
            rates[start : start + 3] = apply_transpose(E, apply(R, v))
            start += 3
        rates[start : start + 4] = quaternion_rate(state.q[start : start + 4], w)
    return tuple(rates)


def jacobian(model: Model, state: State, point: Any) -> tuple[tuple[Scalar, ...], ...]:
    """Return the matrix J (6 x n_u) of the angular velocity of the point's body and the velocity of the point:

    (w_NB_N, v_NP_N) = J u + (part due to driven joints).
    """
    link, _ = place_of(model, point.body)
    p_NP_N = point_position(model, state, point)
    columns: list[list[Scalar]] = [[0] * 6 for _ in range(model.n_u)]
    while link != GROUND:
        posture = link_postures(model, state)[link]
        arm = subtract(p_NP_N, posture.position)
        for j, weight, (w, v) in motions(model, state, link):
            w_N, v_N = apply(posture.rotation, w), apply(posture.rotation, v)
            column = (*w_N, *add(v_N, cross(w_N, arm)))
            columns[j] = [a + weight * b for a, b in zip(columns[j], column, strict=True)]
        link = model.links[link].parent
    return tuple(tuple(column[row] for column in columns) for row in range(6))


def jacobian_rate(model: Model, state: State, point: Any) -> tuple[tuple[Scalar, ...], ...]:
    """Return dJ/dt (6 x n_u) along the motion, so that accelerations are J u' + J' u + (part due to driven joints)."""
    along = jacobian(model, state_along(model, state, state.u, 1, 1), point)
    return tuple(tuple(derivative_at_start(x) for x in row) for row in along)


def motions(model: Model, state: State, i: int) -> list[tuple[int, Scalar, Spatial]]:
    """Return (speed, factor, motion) of a link relative to its parent per unit speed, in its axes."""
    link = model.links[i]
    if link.one_dof:
        S = state.subspace(i)
        return [(j, state(partial), S) for j, partial in link.partials]
    if link.u < 0:
        return []
    rows = IDENTITY
    angular: list[tuple[int, Scalar, Spatial]] = [(link.u + k, 1, (rows[k], ZERO)) for k in range(3)]
    if link.pivots:
        return angular
    return angular + [(link.u + 3 + k, 1, (ZERO, rows[k])) for k in range(3)]


# --- states along a motion, as truncated series in time ------------------------------------------
#
# An algorithm that runs on such a state returns series whose coefficients are the exact derivatives of its result.


def state_along(model: Model, state: State, u: Sequence[Scalar], clock: int, order: int) -> State:
    """Return the state to first or second order along q' = N(q) u with u constant; ``clock`` is the rate of time."""
    field = SeriesField(state.field, order)
    first = coordinate_rates(model, replaced(state, state.field, state.t, state.q, u))
    taylor = [[a, b] for a, b in zip(state.q, first, strict=True)]
    if order > 1:
        short = SeriesField(state.field, 1)
        moving = replaced(state, short, state.t, [short.series(c) for c in taylor], u)
        for coefficients, rate in zip(taylor, coordinate_rates(model, moving), strict=True):
            coefficients.append(divide(rate.derivative(1), 2) if isinstance(rate, Series) else 0)
    t = field.series([state.t, clock]) if clock else state.t
    result = replaced(state, field, t, [field.series(c) for c in taylor], u)
    result.cache["start"] = state  # for axes that stay in place
    return result


def state_moving(model: Model, state: State, udot: Sequence[Scalar]) -> State:
    """Return the state with coordinates to second order along the motion with accelerations ``udot``, speeds unchanged.

    Functions of position then have their exact first and second time derivatives as coefficients.
    """
    first_order, second_order = SeriesField(state.field, 1), SeriesField(state.field, 2)
    first = coordinate_rates(model, state)
    u = [first_order.series([a, b]) for a, b in zip(state.u, udot, strict=True)]
    q = [first_order.series([a, b]) for a, b in zip(state.q, first, strict=True)]
    rates = coordinate_rates(model, replaced(state, first_order, first_order.series([state.t, 1]), q, u))
    taylor = [
        second_order.series([a, b, divide(rate.derivative(1), 2) if isinstance(rate, Series) else 0])
        for a, b, rate in zip(state.q, first, rates, strict=True)
    ]
    return replaced(state, second_order, second_order.series([state.t, 1]), taylor, state.u)


def replaced(state: State, field: Field, t: Scalar, q: Sequence[Scalar], u: Sequence[Scalar]) -> State:
    """Return the state of the same model and parameters at another instant."""
    return State(state.model, field, t, q, u, state.values)
