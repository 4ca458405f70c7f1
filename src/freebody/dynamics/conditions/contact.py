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

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from ...describe.contacts.coefficients import SLIP
from ...describe.contacts.gap import Gap
from ...describe.contacts.normal_law import DEPTH
from ...describe.loads.action import Action, Couple, GeneralizedForce, JointForce, PointForce
from ...errors import ModelError
from ...model.contact import Contact
from ...model.model import GROUND, Model
from ...scalar.algebra import (
    ZERO,
    Scalar,
    Vector,
    add,
    apply,
    apply_transpose,
    cross,
    dot,
    negate,
    scale,
    subtract,
)
from ...scalar.series import derivative_at_start, value_at_start
from ..contact_geometry import Touch, law_values, normal_force, pressing, touch_of_shapes, velocity_over
from ..kinematics import (
    Spot,
    link_postures,
    motions,
    place_of,
    point_position,
    rotation,
    state_along,
    state_moving,
)
from ..loads.actions import asked, asked_actions, checked_actions
from ..loads.power import action_power, joint_link, speed_of
from ..state import State


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


def definite_touches(model: Model, state: State) -> Iterator[tuple[Contact, Touch]]:
    """Yield the contact elements whose nearest points are definite, with their geometry, in floats.

    Shapes with a common centre or axis are equally near on all sides; so is a disk that lies flat.
    """
    for contact in model.contacts:
        it = touch(model, state, contact)
        if not it.undirected:
            yield contact, it


def touch(model: Model, state: State, contact: Contact) -> Touch:
    """Return the geometry of one contact element; it is evaluated once per state."""
    if contact.law is None:
        return touch_of_shapes(model, state, contact)
    key = ("touch", contact.name)
    if key not in state.cache:
        state.cache[key] = _touch_of_law(model, state, contact, contact.law)
    return state.cache[key]


def reaches_along(
    model: Model, state: State, contact: Contact, udot: Sequence[Scalar]
) -> list[tuple[Scalar, Scalar, Scalar]]:
    """Return value, rate and acceleration of each ``reach`` of an element, along the motion with ``udot``."""
    key = "along accelerations", tuple(udot)
    if key not in state.cache:
        state.cache[key] = state_moving(model, state, udot)
    reach = touch(model, state.cache[key], contact).reach
    return [(value_at_start(x), derivative_at_start(x), derivative_at_start(x, 2)) for x in reach]


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
    def bias(self) -> tuple[Scalar, ...]:
        """b, the part of the rates' derivatives that is free of accelerations [m/s²]."""
        cache, key = self._state.cache, "along its speeds"
        if key not in cache:
            cache[key] = state_along(self._model, self._state, self._state.u, 1, 1)
        moving = cache[key]
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
        geometry, v = touch(model, state, c), velocity_over(model, state, c)
        result += [dot(e, v) for e in (geometry.normal, *geometry.tangents)]
    return result


def friction_coefficient(
    model: Model, state: State, contact: Contact, direction: Sequence[Any] = ()
) -> Scalar:
    """Return μ of slip at a state; the slip speed is d·γ along a known ``direction`` d, else |γ|."""
    if not contact.slows:
        return state(contact.friction)
    slip = rows_of(model, state, (contact,)).rate[1:]
    if direction:
        speed: Scalar = sum((state(d) * x for d, x in zip(direction, slip, strict=True)), 0)
    else:
        speed = slip_speed(state, slip)
    return state.with_values(contact.friction, {SLIP: speed})


def slip_speed(state: State, slip: Sequence[Scalar]) -> Scalar:
    """Return |γ| of a slip velocity."""
    if len(slip) == 1:
        return state.field.apply("abs", slip[0])
    return state.field.sqrt(sum((x * x for x in slip), 0))


def given_normal_force(model: Model, state: State, contact: Contact, touching: bool = False) -> Scalar:
    """Return the normal force that the state gives: 1 for friction in a joint, 0 where it is found with the motion.

    ``touching`` says that the depth of a compliant contact is not negative.
    """
    if contact.compliant:
        return normal_force(model, state, contact, touching)
    return 1 if contact.held and not contact.loaded else 0


def coefficients(model: Model, state: State, contact: Contact) -> list[Any]:
    """Return the laws of a contact: μ of its slip, μ_s, e, μ of a slip that begins, N of the state, its adhesion."""
    at_rest = (contact.static_friction, contact.restitution, contact.friction_at_rest)
    return [
        friction_coefficient(model, state, contact),
        *map(state, at_rest),
        given_normal_force(model, state, contact),
        state(contact.adhesion),
    ]


def watched_by_modes(model: Model, state: State, contact: Contact) -> list[Scalar]:
    """Return the numbers in the laws of a contact that reach zero only where its mode changes: slips and depths."""
    result: list[Scalar] = []
    if contact.slows:
        slip = rows_of(model, state, (contact,)).rate[1:]
        result += [*slip, slip_speed(state, slip)]
    if contact.compliant:
        values = law_values(model, state, contact)
        result += [values[DEPTH], pressing(state, values)[DEPTH]]
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
