"""Forces of constraints on the bodies, per unit of the multiplier of each condition.

    M u' + h = Q + Gᵀ λ

The power of the forces of row i of G is (G u)_i. Those of a contact that slides have friction besides, by which they do
not act along their condition alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy

from ...describe.constraints.constraint import Gear, Rolling, Rope
from ...describe.contacts.mesh import Mesh
from ...describe.loads.action import Action as ContactAction
from ...describe.loads.action import Couple, PointForce
from ...model.closure import Closure
from ...model.contact import elliptic_friction
from ...model.contact_modes import Touching
from ...model.model import Model
from ...scalar.algebra import (
    ZERO,
    Matrix,
    Scalar,
    Vector,
    add,
    apply,
    cross,
    divide,
    dot,
    multiply,
    negate,
    scale,
    subtract,
)
from ..kinematics import (
    Spot,
    place_of,
    point_position,
    rotation,
)
from ..loads.actions import scaled
from ..state import State
from .constraints import lowest_arm, own_rows
from .contact import friction_coefficient, rows_of, touch, unit_forces

Action = tuple[Any, Vector, Vector]
"""(point, force, moment) on a body, in ground axes; a point not fixed in the body is given as (body, point)."""


def torques(model: Model, state: State, gear: Gear) -> list[tuple[str, int, Scalar]]:
    """Return (joint, link, force or torque along its displacement) per unit multiplier of a gear known by its ratio.

    They act on driven shafts too, for which the matrix G of the free speeds has no column. The list is empty for a gear
    with a known pitch point, whose force acts on the bodies (:func:`wrenches`).
    """
    if isinstance(model.meshes[gear.name], Mesh):
        return []
    pairs = ((gear.first, 1), (gear.second, -state(gear.ratio)))
    return [(joint.name, model.joints[joint.name].links[0], value) for joint, value in pairs]


def separating_force(model: Model, state: State, gear: Gear) -> tuple[list[Action], Scalar]:
    """Return the (point, force, moment) per unit of the force that presses teeth apart, and that force per unit |λ|.

    The list is empty if only the ratio is known.
    """
    mesh = model.meshes[gear.name]
    if not isinstance(mesh, Mesh):
        return [], 0
    tangent, apart = state.vector(mesh.tangent), state.vector(mesh.apart)
    unit = scale(divide(1, state.field.sqrt(dot(apart, apart))), apart)
    size = state.field.sqrt(dot(tangent, tangent)) * state(sympy.tan(gear.pressure_angle))
    return _at_pitch_point(model, state, mesh, unit), size


def _at_pitch_point(model: Model, state: State, mesh: Mesh, force: Vector) -> list[Action]:
    """Return a force in the axes of the carrier on the first body, and its opposite on the second."""
    force = apply(rotation(model, state, place_of(model, mesh.carrier)[0]), force)
    at = point_position(model, state, mesh.point)
    return [(Spot(mesh.first, at), force, ZERO), (Spot(mesh.second, at), negate(force), ZERO)]


def wrenches(model: Model, state: State) -> list[list[Action]]:
    """Return, per condition, the (point, force, moment) per unit multiplier on bodies, in ground axes.

    A list is empty for conditions on coordinates and speeds, whose multipliers are generalized forces, and for gears
    known by their ratio only.
    """
    result: list[list[Action]] = []
    for constraint in model.constraints.values():
        if isinstance(constraint, Closure):
            R_P = _frame(model, state, constraint.parent, constraint.parent_axes)
            R_C = _frame(model, state, constraint.child, constraint.child_axes)
            at = constraint.child.point(*constraint.to)
            for _, e in constraint.along:
                force = state.vector(e) if constraint.in_ground else apply(R_P, state.vector(e))
                # the opposite force acts on the parent at the child's point
                result.append([(at, force, ZERO), ((constraint.parent, at), negate(force), ZERO)])
            for _, a, b in constraint.square:
                moment = cross(apply(R_C, state.vector(b)), apply(R_P, state.vector(a)))
                result.append([(at, ZERO, moment), ((constraint.parent, at), ZERO, negate(moment))])
            if constraint.thread is not None:
                # the power of the condition, d' - h φ'
                force = apply(R_P, state.vector(constraint.thread.axis))
                moment = scale(-state(constraint.thread.pitch), force)
                result.append([(at, force, moment), ((constraint.parent, at), negate(force), negate(moment))])
        elif isinstance(constraint, Rolling):
            arm = lowest_arm(model, state, constraint)
            for _, e in (constraint.normal, constraint.first, constraint.second):
                # the force acts at the contact: it is taken at the centre, with its moment about the centre
                result.append([(constraint.center, e, cross(arm, e))])
        elif isinstance(constraint, Rope):
            points = [point_position(model, state, point) for point in constraint.points]
            pulls: list[Action] = []
            for k, (a, b) in enumerate(zip(points, points[1:], strict=False)):
                span = subtract(b, a)
                unit = scale(divide(1, state.field.sqrt(dot(span, span))), span)
                pulls += [(constraint.points[k], unit, ZERO), (constraint.points[k + 1], negate(unit), ZERO)]
            result.append(pulls)
        elif isinstance(constraint, Touching):
            result += [_places(acting) for acting in closed_forces(model, state, constraint)]
        elif isinstance(constraint, Gear) and isinstance(mesh := model.meshes[constraint.name], Mesh):
            result.append(_at_pitch_point(model, state, mesh, state.vector(mesh.tangent)))
        else:
            result.append([])
    return result


def _frame(model: Model, state: State, body: Any, axes: Matrix) -> Matrix:
    link, _ = place_of(model, body)
    return multiply(rotation(model, state, link), state.matrix(axes))


def _places(acting: Sequence[ContactAction]) -> list[Action]:
    """Return the (point, force, moment) of actions on bodies."""
    result: list[Action] = []
    for action in acting:
        match action:
            case PointForce(point, force):
                result.append((point, force, ZERO))
            case Couple(body, moment):
                result.append((body.origin, ZERO, moment))
    return result


def closed_forces(model: Model, state: State, touching: Touching) -> list[tuple[ContactAction, ...]]:
    """Return, for each condition of a closed contact, its actions per unit multiplier, friction of slip included."""
    contact, found = touching.contact, unit_forces(model, state, touching.contact)
    result = list(found[own_rows(touching)])
    if touching.slips and not contact.frictionless:
        if contact.law is None:
            friction = slip_friction(model, state, touching)
            opposite = negate(friction)
            result[0] += tuple(
                PointForce(one.point, force)
                for one, force in zip(result[0], (friction, opposite), strict=True)
                if isinstance(one, PointForce)
            )
        else:
            shares = friction_along_tangents(model, state, touching, 1)
            for share, row in zip(shares, found[1:], strict=True):
                result[0] += tuple(scaled(action, share) for action in row)
    return result


def slip_friction(model: Model, state: State, touching: Touching) -> Vector:
    """Return the friction on the feature per unit force in the cone, in ground axes."""
    tangents = touch(model, state, touching.contact).tangents
    total: Vector = ZERO
    for share, t in zip(friction_along_tangents(model, state, touching, 1), tangents, strict=True):
        total = add(total, scale(share, t))
    return total


def friction_along_tangents(model: Model, state: State, touching: Touching, pressure: Scalar) -> list[Scalar]:
    """Return the friction of a slip along the tangents, -μ d (N + A), for a ``pressure`` N + A with the adhesion A.

    d is the direction of the slip γ; with two coefficients T = -(μ_1² γ_1, μ_2² γ_2) (N + A)/√(μ_1² γ_1² + μ_2² γ_2²).
    """
    contact, d = touching.contact, slip_direction(model, state, touching)
    if contact.friction_across is not None:
        shares = elliptic_friction(d, tuple(map(state, contact.coefficients)), state.field.sqrt)
        return [-(x * pressure) for x in shares]
    mu = friction_of_slip(model, state, touching)
    return [-(mu * pressure * x) for x in d]


def friction_of_slip(model: Model, state: State, touching: Touching) -> Scalar:
    """Return the coefficient of friction of a contact that slips."""
    return friction_coefficient(model, state, touching.contact, touching.direction or ())


def slip_direction(model: Model, state: State, touching: Touching) -> list[Scalar]:
    """Return the components of the unit direction of slip along the tangents: as prescribed, or γ/|γ|."""
    contact = touching.contact
    assert touching.direction is not None
    if touching.direction:
        return [state(d) for d in touching.direction]
    if contact.frictionless:
        return [0] * contact.tangents
    slip = rows_of(model, state, (contact,)).rate[1:]
    square: Scalar = 0
    for component in slip:
        square = square + component * component
    return [divide(component, state.field.sqrt(square)) for component in slip]
