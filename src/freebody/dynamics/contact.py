"""Contacts at a state: gap, normal, slip, and their rates, for any scalar.

With the nearest points P on the feature and Q on the surface, the unit normal n from Q to P and the tangents t,

    g = n·(r_P - r_Q),     ġ = n·(v_P - v_Q) = W_N u + w_N,     γ = t·(v_P - v_Q) = W_T u + w_T,

where v_P, v_Q are the velocities of the material points at P and Q. P, Q, n and t move over the bodies. This motion
enters

    d(W u + w)/dt = W u' + b

through b, which is computed by truncated series along the motion and so is exact for all shapes. The force N n + T t
acts on the feature at P and its opposite on the surface at Q; the same rows W give its generalized force.

A contact that is known by its gap (:class:`freebody.Gap`) says the actions of its forces instead; their power gives
the rates, and their generalized force the rows.

Source: Pfeiffer & Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapters 4 and 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from ..describe.contact_shapes import kind_of
from ..describe.contacts.gap import Gap
from ..describe.loads.action import Action, Couple, GeneralizedForce, JointForce, PointForce
from ..errors import ModelError
from ..model.contact import Contact
from ..model.model import GROUND, Model
from ..scalar.algebra import (
    IDENTITY,
    ZERO,
    Scalar,
    Vector,
    add,
    apply,
    apply_transpose,
    cross,
    divide,
    dot,
    negate,
    scale,
    subtract,
)
from ..scalar.expression import evaluate
from ..scalar.series import derivative_at_start, value_at_start
from .kinematics import (
    Spot,
    link_postures,
    motions,
    place_of,
    point_position,
    point_velocity,
    rotation,
    state_along,
    state_moving,
)
from .loading import action_power, asked, asked_actions, checked_actions, joint_link, speed_of
from .state import State


@dataclass(frozen=True)
class Touch:
    """Geometry of one contact element, in ground axes [m].

    Attributes
    ----------
    gap : scalar
        Distance; negative if the bodies overlap.
    normal : Vector
        Unit normal from the surface to the feature.
    tangents : tuple of Vector
        One in a planar machine, else two; (t1, t2, n) is right-handed.
    on_feature, on_surface : Vector
        The points P and Q.
    reach : tuple of scalars
        For sides with ends: all are 0 or more if the foot of the contact lies between the ends.
    """

    gap: Scalar
    normal: Vector
    tangents: tuple[Vector, ...]
    on_feature: Vector
    on_surface: Vector
    reach: tuple[Scalar, ...] = ()


@dataclass(frozen=True)
class ContactRow:
    """One force component of one element: its name, the element's index, "N" or "T", and the direction's index."""

    name: str
    contact: int
    kind: str
    direction: int


def contact_layout(contacts: Sequence[Contact]) -> tuple[ContactRow, ...]:
    """Return the rows of all elements, in order: N, T, or N, T1, T2 of each."""
    result = []
    for i, contact in enumerate(contacts):
        result.append(ContactRow(contact.normal_name, i, "N", 0))
        result += [ContactRow(name, i, "T", k) for k, name in enumerate(contact.tangent_names)]
    return tuple(result)


def touches(model: Model, state: State) -> tuple[Touch, ...]:
    """Return the geometry of every contact element."""
    return tuple(touch(model, state, contact) for contact in model.contacts)


def touch(model: Model, state: State, contact: Contact) -> Touch:
    """Return the geometry of one contact element; it is evaluated once per state."""
    key = ("touch", contact.name)
    if key not in state.cache:
        state.cache[key] = _touch(model, state, contact)
    return state.cache[key]


def _touch(model: Model, state: State, contact: Contact) -> Touch:
    if contact.law is not None:
        return _touch_of_law(model, state, contact, contact.law)
    feature, surface = contact.feature, contact.surface
    first, second = (surface, feature) if contact.swapped else (feature, surface)
    if kind_of(second) in ("plane", "segment"):
        P, Q, n, gap, reach = _on_flat(model, state, first, second)
    elif kind_of(second) == "heightline":
        P, Q, n, gap, reach = _on_line(model, state, first, second)
    else:
        P, Q, n, gap, reach = _between_round(model, state, first, second)
    if contact.swapped:
        P, Q, n = Q, P, negate(n)
    return Touch(gap, n, _tangents(model, state, contact, n), P, Q, reach)


def reaches_along(
    model: Model, state: State, contact: Contact, udot: Sequence[Scalar]
) -> list[tuple[Scalar, Scalar, Scalar]]:
    """Return value, rate and acceleration of each ``reach`` of an element, along the motion with ``udot``."""
    reach = touch(model, state_moving(model, state, udot), contact).reach
    return [(value_at_start(x), derivative_at_start(x), derivative_at_start(x, 2)) for x in reach]


# --- the pairs of shapes -------------------------------------------------------------------------

Nearest = tuple[Vector, Vector, Vector, Scalar, tuple[Scalar, ...]]
"""P, Q, n, gap and reach of a pair of shapes."""


def _at(model: Model, state: State, body: Any, components: Sequence[Scalar]) -> Vector:
    """Return the position, in ground axes, of a place given in body axes."""
    link, origin = place_of(model, body)
    p = state.vector(tuple(a + b for a, b in zip(origin, components, strict=True)))
    if link == GROUND:
        return p
    posture = link_postures(model, state)[link]
    return add(posture.position, apply(posture.rotation, p))


def _turned(model: Model, state: State, body: Any, components: Sequence[Scalar]) -> Vector:
    """Return a direction, given in body axes, in ground axes."""
    link, _ = place_of(model, body)
    return apply(rotation(model, state, link), state.vector(components))


def _middle(model: Model, state: State, shape: Any) -> Vector:
    return _at(model, state, shape.body, shape.components if kind_of(shape) == "point" else shape.at)


def _radius(state: State, shape: Any) -> Any:
    return 0 if kind_of(shape) == "point" else state(shape.radius)


def _on_flat(model: Model, state: State, shape: Any, flat: Any) -> Nearest:
    """Return the nearest points of a point, sphere, ellipsoid or disk edge and a plane or straight side of normal n:

        P = C,    C - r n,    C - D n/sqrt(n·D n)  with D = R diag(a², b², c²) Rᵀ of the half axes,
        C - r p/|p|, p = n - (n·a) a = a × (n × a)  with the axis a of the disk;    Q = P - g n.

    The foot of the side is at s = e·(P - start) along it.
    """
    n = _turned(model, state, flat.body, flat.normal)
    C = _middle(model, state, shape)
    kind = kind_of(shape)
    P = C
    if kind == "sphere":
        P = subtract(C, scale(state(shape.radius), n))
    elif kind == "ellipsoid":
        link, _ = place_of(model, shape.body)
        R = rotation(model, state, link)
        within = apply_transpose(R, n)
        squares = tuple(state(half) * state(half) for half in shape.half_axes)
        support = tuple(square * x for square, x in zip(squares, within, strict=True))
        width = state.field.sqrt(dot(within, support))
        P = subtract(C, apply(R, scale(divide(1, width), support)))
    elif kind in ("circle", "cylinder"):
        a = _turned(model, state, shape.body, shape.axis)
        # as a product p is exact to its last digits for a disk that lies almost flat; for a flat disk the whole edge
        # touches, and the force acts at the middle
        P = subtract(C, scale(state(shape.radius), state.field.unit(cross(a, cross(n, a)))))
    side = kind_of(flat) == "segment"
    O = _at(model, state, flat.body, flat.start if side else flat.at)  # noqa: E741
    gap = dot(n, subtract(P, O))
    reach: tuple[Scalar, ...] = ()
    if side:
        s = dot(_turned(model, state, flat.body, flat.along), subtract(P, O))
        reach = (s, state(flat.length) - s)
    return P, subtract(P, scale(gap, n)), n, gap, reach


def _between_round(model: Model, state: State, a: Any, b: Any) -> Nearest:
    """Return the nearest points of points, spheres and walls of cylinders.

    With d from the centre of b to the centre of a, at right angles to the axis,

    outside  n = d/|d|,   g = |d| - r_a - r_b;        inside  n = -d/|d|,   g = r_b - r_a - |d|.
    """
    A, B = _middle(model, state, a), _middle(model, state, b)
    d = subtract(A, B)
    # the centre of a cylinder moves along its axis to the depth of the other shape
    if kind_of(b) in ("circle", "cylinder"):
        axis = _turned(model, state, b.body, b.axis)
        along = scale(dot(axis, d), axis)
        B, d = add(B, along), subtract(d, along)
    elif kind_of(a) in ("circle", "cylinder"):
        axis = _turned(model, state, a.body, a.axis)
        along = scale(dot(axis, d), axis)
        A, d = subtract(A, along), subtract(d, along)
    distance = state.field.sqrt(dot(d, d))
    r_a, r_b = _radius(state, a), _radius(state, b)
    if getattr(b, "inside", False):
        n = scale(divide(-1, distance), d)
        return subtract(A, scale(r_a, n)), subtract(B, scale(r_b, n)), n, r_b - r_a - distance, ()
    n = scale(divide(1, distance), d)
    return subtract(A, scale(r_a, n)), add(B, scale(r_b, n)), n, distance - r_a - r_b, ()


def _on_line(model: Model, state: State, point: Any, line: Any) -> Nearest:
    """Return the nearest points of a point and a line y = f(x), with the foot below the point:

    n = (-f', 1, 0)/sqrt(1 + f'²),  g = (y - f)/sqrt(1 + f'²). Near contact g is the distance to first order.
    """
    P = _middle(model, state, point)
    O = _at(model, state, line.body, line.at)  # noqa: E741
    link, _ = place_of(model, line.body)
    R = rotation(model, state, link)
    x, y, z = apply_transpose(R, subtract(P, O))
    values = {**state.values, line.variable: x}
    f, slope = (evaluate(x, values, state.field) for x in (line.height, line.slope))
    root = state.field.sqrt(1 + slope * slope)
    n = apply(R, (divide(-slope, root), divide(1, root), 0))
    return P, add(O, apply(R, (x, f, z))), n, divide(y - f, root), ()


def _tangents(model: Model, state: State, contact: Contact, n: Vector) -> tuple[Vector, ...]:
    if contact.planar is not None:
        return (cross(n, contact.planar),)
    for shape, flip in ((contact.surface, False), (contact.feature, True)):
        if kind_of(shape) == "plane":
            first, second = (_turned(model, state, shape.body, e) for e in (shape.first, shape.second))
            return (second, first) if flip else (first, second)
    for shape in (contact.surface, contact.feature):
        if kind_of(shape) in ("circle", "cylinder"):
            axis = _turned(model, state, shape.body, shape.axis)
            return (axis, cross(n, axis))
    return _upright(n, contact.upright)


def _upright(n: Vector, up: Vector) -> tuple[Vector, Vector]:
    """Return the axes at right angles to ``up``, turned with it to n the short way; undefined at n = -up.

    Source: Frisvad, Journal of Graphics Tools 16 (2012) 151-159.
    """
    k = up.index(1)
    e1, e2 = IDENTITY[(k + 1) % 3], IDENTITY[(k + 2) % 3]
    x, y, z = dot(n, e1), dot(n, e2), dot(n, up)
    share = divide(1, 1 + z)
    first = add(add(scale(1 - x * x * share, e1), scale(-(x * y * share), e2)), scale(-x, up))
    second = add(add(scale(-(x * y * share), e1), scale(1 - y * y * share, e2)), scale(-y, up))
    return first, second


# --- rows ------------------------------------------------------------------------------------------


class ContactRows:
    """Gaps and rates of contacts, with a row for each of :func:`contact_layout`.

    Each list is computed when it is first used: as a formula ``bias`` can be far longer than the rest.
    """

    def __init__(self, model: Model, state: State, contacts: Sequence[Contact]) -> None:
        self._model = model
        self._state = state
        self._contacts = tuple(contacts)

    @cached_property
    def gap(self) -> tuple[Scalar, ...]:
        """g of every element [m]."""
        return tuple(touch(self._model, self._state, c).gap for c in self._contacts)

    @cached_property
    def rate(self) -> tuple[Scalar, ...]:
        """ġ and the slip velocities γ [m/s]."""
        return tuple(_rates(self._model, self._state, self._contacts))

    @cached_property
    def matrix(self) -> tuple[tuple[Scalar, ...], ...]:
        """W, a column per speed."""
        model, state = self._model, self._state
        result = []
        for c in self._contacts:
            for row in unit_forces(model, state, c):
                result.append(row_of(model, state, row, c))
        return tuple(result)

    @cached_property
    def drift(self) -> tuple[Scalar, ...]:
        """w, the part of the rates due to driven joints."""
        rates = []
        for rate, row in zip(self.rate, self.matrix, strict=True):
            for entry, u in zip(row, self._state.u, strict=True):
                rate = rate - entry * u
            rates.append(rate)
        return tuple(rates)

    @cached_property
    def bias(self) -> tuple[Scalar, ...]:
        """b, the part of the rates' derivatives that is free of accelerations [m/s²]."""
        moving = state_along(self._model, self._state, self._state.u, 1, 1)
        rates = _rates(self._model, moving, self._contacts)
        return tuple(map(derivative_at_start, rates))


def contact_rows(model: Model, state: State) -> ContactRows:
    """Return the rows of all contacts of a model, computed once per state."""
    return rows_of(model, state, model.contacts)


def rows_of(model: Model, state: State, contacts: Sequence[Contact]) -> ContactRows:
    """Return the rows of some contacts, computed once per state."""
    key = ("contact rows", tuple(c.name for c in contacts))
    if key not in state.cache:
        state.cache[key] = ContactRows(model, state, contacts)
    return state.cache[key]


def _rates(model: Model, state: State, contacts: Sequence[Contact]) -> list[Scalar]:
    result: list[Scalar] = []
    for c in contacts:
        if c.law is not None:
            for row in unit_forces(model, state, c):
                power: Scalar = 0
                for action in row:
                    power = power + action_power(model, state, c.law, action)
                result.append(power)
            continue
        geometry = touch(model, state, c)
        v = subtract(
            point_velocity(model, state, Spot(c.feature.body, geometry.on_feature)),
            point_velocity(model, state, Spot(c.surface.body, geometry.on_surface)),
        )
        result += [dot(e, v) for e in (geometry.normal, *geometry.tangents)]
    return result


# --- forces ----------------------------------------------------------------------------------------


def unit_forces(model: Model, state: State, contact: Contact) -> tuple[tuple[Action, ...], ...]:
    """Return the actions of a unit of each force of a contact, in the order of :func:`contact_layout`."""
    law = contact.law
    if law is None:
        it = touch(model, state, contact)
        P, Q = Spot(contact.feature.body, it.on_feature), Spot(contact.surface.body, it.on_surface)
        return tuple((PointForce(P, e), PointForce(Q, negate(e))) for e in (it.normal, *it.tangents))
    key = ("unit forces", contact.name)
    if key not in state.cache:
        found = [asked_actions(model, state, law, law.normal)]
        if contact.tangents:
            tangents = asked(model, state, law, lambda at: tuple(map(tuple, law.tangents(at))))
            if len(tangents) != contact.tangents:
                raise ModelError(
                    f"{law.heading} has friction, so that its tangents must be {contact.tangents}, the number in "
                    f"'directions' of its class, got {len(tangents)}."
                )
            found += [checked_actions(model, law, row) for row in tangents]
        state.cache[key] = tuple(found)
    return state.cache[key]


def wrench_on_feature(
    model: Model, state: State, contact: Contact, acting: Sequence[Action]
) -> tuple[Vector, Vector]:
    """Return force and moment of actions on the feature's body, about the place where they act."""
    force: Vector = ZERO
    moment: Vector = ZERO
    for action in acting:
        match action:
            case PointForce(point, value) if point.body is contact.feature.body:
                force = add(force, value)
            case Couple(body, value) if body is contact.feature.body:
                moment = add(moment, value)
            case JointForce(_, value):
                i = joint_link(model, action)
                R, (w, v) = rotation(model, state, i), state.subspace(i)
                turns = any(x != 0 for x in w)
                moment = add(moment, scale(value, apply(R, w)))
                force = add(force, ZERO if turns else scale(value, apply(R, v)))
    return force, moment


def row_of(model: Model, state: State, acting: Sequence[Action], contact: Contact) -> tuple[Scalar, ...]:
    """Return the generalized force of actions. Length n_u."""
    total: list[Scalar] = [0] * model.n_u
    for action in acting:
        match action:
            case PointForce(point, force):
                _add_row(model, state, total, point.body, (point_position(model, state, point), force))
            case Couple(body, moment):
                _add_row(model, state, total, body, moment=moment)
            case JointForce():
                for j, partial in model.links[joint_link(model, action)].partials:
                    total[j] = total[j] + action.value * state(partial)
            case GeneralizedForce():
                assert contact.law is not None
                j = speed_of(model, contact.law, action.coordinate)
                total[j] = total[j] + action.value
    return tuple(total)


def _add_row(
    model: Model,
    state: State,
    total: list[Scalar],
    body: Any,
    pressed: tuple[Vector, Vector] | None = None,
    moment: Vector = ZERO,
) -> None:
    """Add the generalized force of (position, force) or of a moment on a body, in ground axes."""
    link, _ = place_of(model, body)
    while link != GROUND:
        posture = link_postures(model, state)[link]
        along = ZERO
        if pressed is not None:
            place, force = pressed
            moment = cross(subtract(place, posture.position), force)
            along = apply_transpose(posture.rotation, force)
        turning = apply_transpose(posture.rotation, moment)
        for j, weight, (w, v) in motions(model, state, link):
            total[j] = total[j] + weight * (dot(w, turning) + dot(v, along))
        link = model.links[link].parent


def _touch_of_law(model: Model, state: State, contact: Contact, law: Gap) -> Touch:
    """Return the gap, and the place and direction of the force on the feature; zeros for a force along a joint."""
    gap = asked(model, state, law, law.gap)
    place: Vector = ZERO
    directions: list[Vector] = []
    for row in unit_forces(model, state, contact):
        for action in row:
            if isinstance(action, PointForce) and action.point.body is contact.feature.body:
                place = point_position(model, state, action.point)
            elif isinstance(action, JointForce):
                place = point_position(model, state, action.joint.child.point(*action.joint.to))
        directions.append(wrench_on_feature(model, state, contact, row)[0])
    return Touch(gap, directions[0], tuple(directions[1:]), place, place)
