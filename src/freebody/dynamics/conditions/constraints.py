"""Constraints: closures of loops, conditions on coordinates and on speeds, in one form.

    φ(q, t) = 0,   ψ(u, q, t) = G u + g = 0,   G u' + γ = 0,   M u' + h = Q + Gᵀ λ

Every condition has one function, its residual for any scalar. G, g and γ are derivatives of the residuals along a
motion, taken by truncated series, so that no condition needs derivatives of its own. G and γ of joints that hold
two points together, however, follow from the motion of the bodies, with fewer operations (`loop_ends`).

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 8, with exact γ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, cast

import sympy

from ...describe.constraints.constraint import Gear, Rolling, Rope, SpeedCondition
from ...describe.contacts.mesh import Mesh
from ...describe.joints.joint import Joint
from ...describe.loads.action import Action as ContactAction
from ...describe.loads.action import Couple, PointForce
from ...errors import ModelError
from ...model.closure import Closure, Thread
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
    apply_transpose,
    cross,
    divide,
    dot,
    multiply,
    negate,
    scale,
    subtract,
)
from ...scalar.series import derivative_at_start, value_at_start
from ..kinematics import (
    Spot,
    angular_velocity,
    place_of,
    point_position,
    point_velocity,
    replaced,
    rotation,
    state_along,
)
from ..linear import entries
from ..loads.actions import scaled
from ..state import State
from .contact import ContactRows, friction_coefficient, rows_of, touch, unit_forces
from .dependence import dependence, directions
from .loop_ends import carrier_of, ends, last_link, loop_rows

Action = tuple[Any, Vector, Vector]
"""(point, force, moment) on a body, in ground axes; a point not fixed in the body is given as (body, point)."""


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
            contact_rows.update(range(len(result), len(result) + _count(constraint)))
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
            result += [0] * _conditions(constraint) if omitted else _closure(model, state, constraint)
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
            result += _touching(model, state, constraint) if contacts else [0] * _count(constraint)
        elif isinstance(constraint, Gear):
            first, second = (
                _displacement(model, state, joint) for joint in (constraint.first, constraint.second)
            )
            result.append(first - state(constraint.ratio) * second)
        else:
            result.append(state(constraint.expression))
    return result


def _conditions(pin: Closure) -> int:
    """Return the number of conditions of a pin."""
    return len(pin.along) + len(pin.square)


def _count(touching: Touching) -> int:
    """Return the number of conditions of a closed contact."""
    return (0 if touching.slips else touching.contact.tangents) + (0 if touching.contact.held else 1)


def _own(touching: Touching) -> slice:
    """Return the rows of a contact that are conditions while it is closed."""
    first = 1 if touching.contact.held else 0
    return slice(first, first + _count(touching))


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
    return [*given.gap, *(() if touching.slips else given.rate[1:])][_own(touching)]


def _displacement(model: Model, state: State, joint: Joint) -> Scalar:
    return state(model.links[model.joints[joint.name].links[0]].displacement)


def _frame(model: Model, state: State, body: Any, axes: Matrix) -> Matrix:
    link, _ = place_of(model, body)
    return multiply(rotation(model, state, link), state.matrix(axes))


def _closure(model: Model, state: State, joint: Closure) -> list[Scalar]:
    """Return the residuals of a closure, relative to the link that carries the loop: they depend on the loop only.

    Multiplied by the rotation R of that link they are in ground axes, like the force of the joint. No derivative of R
    matters, since φ = 0 in R φ.
    """
    parent, child = ends(model, state, joint)
    R_P, R_C = parent.axes, child.axes
    gap = subtract(child.place, parent.place)
    d = apply(_from_carrier(model, state, joint), gap) if joint.in_ground else apply_transpose(R_P, gap)
    result = [dot(state.vector(e), d) for _, e in joint.along]
    for _, a, b in joint.square:
        a, b = state.vector(a), state.vector(b)
        result.append(dot(apply(R_P, a), apply(R_C, b)) - dot(a, b))
    if joint.thread is not None:
        result.append(_thread(state, joint.thread, R_P, R_C, d))
    return result


def _from_carrier(model: Model, state: State, joint: Closure) -> Matrix:
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


def _arm(model: Model, state: State, wheel: Rolling) -> Vector:
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
    arm = _arm(model, state, wheel)
    contact = add(point_position(model, state, wheel.center), arm)
    height = dot(wheel.normal[1], subtract(contact, point_position(model, state, wheel.plane)))
    spin = angular_velocity(model, state, wheel.center.body)
    slip = add(point_velocity(model, state, wheel.center), cross(spin, arm))
    return [height, dot(wheel.first[1], slip), dot(wheel.second[1], slip)]


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
            arm = _arm(model, state, constraint)
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
    result = list(found[_own(touching)])
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


class Linearized:
    """The conditions at a state: residual φ (or ψ), rate ψ, matrix G of the speeds and γ; one entry per row.

    Each is computed when it is first used: as a formula γ can be far longer than the rest.
    """

    def __init__(self, model: Model, state: State) -> None:
        self._model = model
        self._state = state
        self._kinds = rows(model)
        places = {row.owner: i for i, row in reversed([*enumerate(self._kinds)])}
        self.touching = [
            (places[name], c) for name, c in model.constraints.items() if isinstance(c, Touching)
        ]
        self._pins = [
            (places[name], c)
            for name, c in model.constraints.items()
            if isinstance(c, Closure) and c.in_ground
        ]

    def _in_ground(self, pin: Closure) -> tuple[list[list[Scalar]], list[Scalar]]:
        """Return G and γ of a pin, its force in ground axes."""
        G, bias = loop_rows(self._model, self._state, pin, carrier_of(self._model, pin))
        R = _from_carrier(self._model, self._state, pin)
        # a zero times a float is not a plain zero
        columns = [apply(R, x) if entries(x) else x for x in zip(*G[:3], strict=True)]
        return [*map(list, zip(*columns, strict=True)), *G[3:]], [
            *apply(R, (bias[0], bias[1], bias[2])),
            *bias[3:],
        ]

    def in_loop_axes(
        self, active: Sequence[int]
    ) -> tuple[dict[int, tuple[Any, Any]], list[tuple[list[int], Any]]]:
        """Return G and γ of pins with the force in axes of the loop, in which more is constant, and the way back.

        Returns
        -------
        rows : dict
            Row -> (row of G, γ).
        back : list of (rows, matrix)
            The matrix times the multipliers gives the multipliers along ground axes.
        """
        result: dict[int, tuple[Any, Any]] = {}
        back = []
        for i, pin in self._pins:
            link = last_link(self._model, pin)
            R = rotation(self._model, self._state, link)
            used = [k for k in range(3) if i + k in active]
            # R must not mix used and unused rows: there are no unused ones, or the loop moves in a plane
            unused = [k for k in range(3) if k not in used]
            if used and all(entries((R[a][b], R[b][a])) == [] for a in used for b in unused):
                G, bias = loop_rows(self._model, self._state, pin, link)
                result |= {i + k: (G[k], bias[k]) for k in used}
                back.append(([i + k for k in used], [[R[a][b] for b in used] for a in used]))
        return result, back

    def _contact_rows(self, touching: Touching) -> ContactRows:
        return rows_of(self._model, self._state, (touching.contact,))

    @cached_property
    def residual(self) -> tuple[Scalar, ...]:
        """φ of conditions on coordinates, ψ of those on speeds."""
        return tuple(residuals(self._model, self._state))

    @cached_property
    def rate(self) -> tuple[Scalar, ...]:
        """ψ = G u + g."""
        along = _along_motion(self._model, self._state, self._state.u, 1, 1)
        pairs = zip(along, self._kinds, strict=True)
        result = [value_at_start(r) if kind.on_speeds else derivative_at_start(r, 1) for r, kind in pairs]
        for i, touching in self.touching:
            result[i : i + _count(touching)] = self._contact_rows(touching).rate[_own(touching)]
        return tuple(result)

    @cached_property
    def bias(self) -> tuple[Scalar, ...]:
        """γ, the part of ψ' that is free of accelerations."""
        along = _along_motion(self._model, self._state, self._state.u, 1, 2, pins=False)
        pairs = zip(along, self._kinds, strict=True)
        result = [derivative_at_start(r, 1 if kind.on_speeds else 2) for r, kind in pairs]
        for i, pin in self._pins:
            result[i : i + _conditions(pin)] = self._in_ground(pin)[1]
        for i, touching in self.touching:
            result[i : i + _count(touching)] = self._contact_rows(touching).bias[_own(touching)]
        return tuple(result)

    @cached_property
    def matrix(self) -> tuple[tuple[Scalar, ...], ...]:
        """G, a row per condition and a column per speed."""
        model, state, kinds = self._model, self._state, self._kinds
        depends = dependence(model)
        at_rest: list[Scalar] = []
        if _any_speed(kinds):
            zeros = [0] * model.n_u
            at_rest = residuals(model, replaced(state, state.field, state.t, state.q, zeros), contacts=False)
        columns: list[dict[int, Scalar]] = [{} for _ in kinds]
        for moving in directions(depends.values()):
            unit = [int(j in moving) for j in range(model.n_u)]
            for i, r in enumerate(_along_motion(model, state, unit, 0, 1, pins=False)):
                for j in moving & depends[kinds[i].owner]:
                    columns[i][j] = (
                        value_at_start(r) - at_rest[i] if kinds[i].on_speeds else derivative_at_start(r, 1)
                    )
        result = [tuple(row.get(j, 0) for j in range(model.n_u)) for row in columns]
        for i, pin in self._pins:
            result[i : i + _conditions(pin)] = map(tuple, self._in_ground(pin)[0])
        for i, touching in self.touching:
            result[i : i + _count(touching)] = self._contact_rows(touching).matrix[_own(touching)]
        return tuple(result)

    @cached_property
    def acting(self) -> tuple[tuple[Scalar, ...], ...]:
        """Generalized force per unit multiplier: the rows of G, and for contacts that slip W_N - μ Σ d W_T."""
        result = list(self.matrix)
        for i, touching in self.touching:
            if touching.slips and not touching.contact.frictionless:
                row = list(result[i])
                shares = friction_along_tangents(self._model, self._state, touching, 1)
                for share, tangent in zip(shares, self._contact_rows(touching).matrix[1:], strict=True):
                    row = [a + share * b for a, b in zip(row, tangent, strict=True)]
                result[i] = tuple(row)
        return tuple(result)

    @property
    def symmetric(self) -> bool:
        """True if all forces act along their own conditions, which sliding friction does not."""
        return not any(c.slips and not c.contact.frictionless for _, c in self.touching)


def linearized(model: Model, state: State) -> Linearized:
    """Return φ, ψ, G and γ of all conditions at a state."""
    if "constraints" not in state.cache:
        state.cache["constraints"] = Linearized(model, state)
    return state.cache["constraints"]


def _any_speed(kinds: Sequence[Row]) -> bool:
    return any(kind.on_speeds for kind in kinds)


def _along_motion(
    model: Model, state: State, u: Sequence[Scalar], clock: int, order: int, pins: bool = True
) -> list[Scalar]:
    """Return the residuals as series along q' = N(q) u with u constant; ``clock`` is the rate of time."""
    return residuals(model, state_along(model, state, u, clock, order), contacts=False, pins=pins)
