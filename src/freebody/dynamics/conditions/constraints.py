"""Constraints: closures of loops, conditions on coordinates and on speeds, in one form.

    φ(q, t) = 0,   ψ(u, q, t) = G u + g = 0

Every condition has one function, its residual for any scalar. Derivatives are in `linearized`, forces in
`constraint_forces`.

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 8, with exact γ.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import cast

from ...describe.constraints.constraint import Gear, Rolling, Rope, SpeedCondition
from ...describe.contacts.mesh import Mesh
from ...describe.joints.joint import Joint
from ...errors import ModelError
from ...model.closure import Closure, Thread
from ...model.contact_modes import Touching
from ...model.model import Model
from ...scalar.algebra import (
    Matrix,
    Scalar,
    Vector,
    add,
    apply,
    apply_transpose,
    cross,
    divide,
    dot,
    scale,
    subtract,
)
from ..kinematics import (
    angular_velocity,
    place_of,
    point_position,
    point_velocity,
    rotation,
)
from ..state import State
from .contact import rows_of, touch
from .loop_ends import carrier_of, ends


@dataclass(frozen=True)
class Row:
    """One scalar condition: its name, the constraint it belongs to, and True if it is on speeds."""

    name: str
    owner: str
    on_speeds: bool = False


def rows(model: Model) -> tuple[Row, ...]:
    """Return all scalar conditions, in order; an underscore at the end keeps a name apart from others of the model."""
    if "rows" not in model.memo:
        model.memo["rows"] = _rows(model)
    return cast("tuple[Row, ...]", model.memo["rows"])


def _rows(model: Model) -> tuple[Row, ...]:
    result: list[Row] = []
    contact_rows: set[int] = set()
    taken = {*model.names.kinds, *model.loads}
    taken |= {
        f"{name}_{ending}"
        for name in model.joints
        for ending in (*"xyznpq", "Mx", "My", "Mz", "Mn", "Mp", "Mq")
    }
    for name, constraint in model.constraints.items():
        if isinstance(constraint, Closure):
            result += [Row(f"{name}_{letter}", name) for letter, _ in constraint.along]
            result += [Row(f"{name}_M{letter}", name) for letter, _, _ in constraint.square]
            if constraint.thread is not None:
                result.append(Row(f"{name}_{constraint.thread.letter}", name))
        elif isinstance(constraint, Rolling):
            result.append(Row(f"{name}_{constraint.normal[0]}", name))
            result += [Row(f"{name}_{e[0]}", name, True) for e in (constraint.first, constraint.second)]
        elif isinstance(constraint, Touching):
            # assembly already keeps these names apart from others
            contact = constraint.contact
            contact_rows.update(range(len(result), len(result) + count_of_contact(constraint)))
            if not contact.held:
                result.append(Row(contact.normal_name, name))
            if not constraint.slips:
                result += [Row(tangent, name, True) for tangent in contact.tangent_names]
        else:
            result.append(Row(name, name, isinstance(constraint, SpeedCondition)))
    for i, row in enumerate(result):
        if i in contact_rows:
            continue
        name = row.name
        while name in taken:
            name += "_"
        taken.add(name)
        result[i] = replace(row, name=name)
    return tuple(result)


def radial_names(model: Model) -> dict[str, str]:
    """Return, by gear with a known pitch point, the name of the force that presses its teeth apart, ``mesh_r``."""
    taken = {*model.names.kinds, *model.loads, *(row.name for row in rows(model))}
    result = {}
    for gear, mesh in model.meshes.items():
        if isinstance(mesh, Mesh):
            name = f"{gear}_r"
            while name in taken:
                name += "_"
            taken.add(name)
            result[gear] = name
    return result


def residuals(model: Model, state: State, *, contacts: bool = True, pins: bool = True) -> list[Scalar]:
    """Return every condition's residual: φ of those on coordinates, ψ of those on speeds.

    Without ``contacts``, or without the ``pins`` that close loops, their residuals are replaced by zeros.
    """
    result: list[Scalar] = []
    for constraint in model.constraints.values():
        if isinstance(constraint, Closure):
            omitted = constraint.in_ground and not pins
            result += [0] * count_of_pin(constraint) if omitted else _closure(model, state, constraint)
        elif isinstance(constraint, Rope):
            points = [point_position(model, state, point) for point in constraint.points]
            spans = [subtract(b, a) for a, b in zip(points, points[1:], strict=False)]
            # the sign makes the multiplier the tension
            slack: Scalar = state(constraint.length)
            for span in spans:
                slack = slack - state.field.sqrt(dot(span, span))
            result.append(slack)
        elif isinstance(constraint, Rolling):
            result += _rolling(model, state, constraint)
        elif isinstance(constraint, Touching):
            result += _touching(model, state, constraint) if contacts else [0] * count_of_contact(constraint)
        elif isinstance(constraint, Gear):
            first, second = (
                _displacement(model, state, joint) for joint in (constraint.first, constraint.second)
            )
            result.append(first - state(constraint.ratio) * second)
        else:
            result.append(state(constraint.expression))
    return result


def count_of_pin(pin: Closure) -> int:
    """Return the number of conditions of a pin."""
    return len(pin.along) + len(pin.square)


def count_of_contact(touching: Touching) -> int:
    """Return the number of conditions of a closed contact."""
    return (0 if touching.slips else touching.contact.tangents) + (0 if touching.contact.held else 1)


def own_rows(touching: Touching) -> slice:
    """Return the rows of a contact that are conditions while it is closed."""
    first = 1 if touching.contact.held else 0
    return slice(first, first + count_of_contact(touching))


def _touching(model: Model, state: State, touching: Touching) -> list[Scalar]:
    """Return the gap and, in stick, the slip velocities; refuse a contact without a direction."""
    contact = touching.contact
    if contact.law is None and touch(model, state, contact).undirected:
        raise ModelError(
            f"Contact '{contact.name}' of '{model.name}' cannot be closed: the centre of the {contact.feature.kind} "
            f"is held on that of the {contact.surface.kind}, or on its axis, so that a force between them has no "
            f'direction. Leave it open, modes={{"{contact.name}": "open"}}; a shaft in its bearing is a joint.'
        )
    given = rows_of(model, state, (contact,))
    return [*given.gap, *(() if touching.slips else given.rate[1:])][own_rows(touching)]


def _displacement(model: Model, state: State, joint: Joint) -> Scalar:
    return state(model.links[model.joints[joint.name].links[0]].displacement)


def _closure(model: Model, state: State, joint: Closure) -> list[Scalar]:
    """Return the residuals of a closure, relative to the link that carries the loop: they depend on the loop only.

    Multiplied by the rotation R of that link they are in ground axes, like the force of the joint. No derivative of R
    matters, since φ = 0 in R φ.
    """
    parent, child = ends(model, state, joint)
    R_P, R_C = parent.axes, child.axes
    gap = subtract(child.place, parent.place)
    d = apply(from_carrier(model, state, joint), gap) if joint.in_ground else apply_transpose(R_P, gap)
    result = [dot(state.vector(e), d) for _, e in joint.along]
    for _, a, b in joint.square:
        a, b = state.vector(a), state.vector(b)
        result.append(dot(apply(R_P, a), apply(R_C, b)) - dot(a, b))
    if joint.thread is not None:
        result.append(_thread(state, joint.thread, R_P, R_C, d))
    return result


def from_carrier(model: Model, state: State, joint: Closure) -> Matrix:
    """Return the rotation, ground from the link that carries the loop, at the start of a motion."""
    return rotation(model, state.cache.get("start", state), carrier_of(model, joint))


def _thread(state: State, thread: Thread, R_P: Matrix, R_C: Matrix, d: Vector) -> Scalar:
    """Return d·n - h φ for small deviations: 2 h tan((d·n/h - φ)/2), which has one zero per turn and needs no angle.

    cos φ and sin φ are the components of the child's first vector across the axis, and tan(x/2) = sin x/(1 + cos x).
    """
    n, h = state.vector(thread.axis), state(thread.pitch)
    turned = apply(R_C, state.vector(thread.first))
    cosine = dot(apply(R_P, state.vector(thread.first)), turned)
    sine = dot(apply(R_P, state.vector(thread.second)), turned)
    angle = divide(dot(n, d), h)
    c, s = state.field.cos(angle), state.field.sin(angle)
    return divide(2 * h * (s * cosine - c * sine), 1 + c * cosine + s * sine)


def lowest_arm(model: Model, state: State, wheel: Rolling) -> Vector:
    """Return the vector from the wheel's centre to its lowest point, in ground axes:

    -R n for a sphere;  -R (n - (n·a) a) / sqrt(1 - (n·a)²) for a rim at right angles to the axle a.
    """
    radius, n = state(wheel.radius), wheel.normal[1]
    if wheel.axis is None:
        return scale(-radius, n)
    link, _ = place_of(model, wheel.center.body)
    a = apply(rotation(model, state, link), state.vector(wheel.axis))
    lean = dot(n, a)
    slope = state.field.sqrt(1 - lean * lean)
    return scale(divide(-radius, slope), subtract(n, scale(lean, a)))


def _rolling(model: Model, state: State, wheel: Rolling) -> list[Scalar]:
    """Return the height of the wheel's lowest point over the plane, and its slip velocities."""
    arm = lowest_arm(model, state, wheel)
    contact = add(point_position(model, state, wheel.center), arm)
    height = dot(wheel.normal[1], subtract(contact, point_position(model, state, wheel.plane)))
    spin = angular_velocity(model, state, wheel.center.body)
    slip = add(point_velocity(model, state, wheel.center), cross(spin, arm))
    return [height, dot(wheel.first[1], slip), dot(wheel.second[1], slip)]
