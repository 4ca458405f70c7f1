"""Constraints: closures of loops, conditions on coordinates and on speeds, in one form.

    φ(q, t) = 0,   ψ(u, q, t) = G u + g = 0,   G u' + γ = 0,   M u' + h = Q + Gᵀ λ

Every condition is evaluated once, as a residual of any scalar; G, g and γ are derivatives of the residuals along a
motion, taken by truncated series, so that no condition brings derivatives of its own. But G and γ of joints that hold
two points together follow from the motion of the bodies, with fewer operations (`loop_ends`).

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 8, with exact γ.

The file is longer than others: every kind of condition has its residual here, by which all others are differentiated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import sympy

from ..describe.constraints.constraint import Gear, Rolling, Rope, SpeedCondition
from ..model.closure import Closure, Thread
from ..model.contact import Touching
from ..model.mesh import Mesh
from ..model.model import GROUND, Model
from ..scalar.algebra import (
    ZERO,
    Matrix,
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
from ..scalar.series import Series
from .along import replaced, state_along
from .contact import ContactRows, rows_of, touch
from .dependence import dependence, directions
from .kinematics import (
    Spot,
    angular_velocity,
    link_postures,
    place_of,
    point_position,
    point_velocity,
    rotation,
)
from .linear import entries
from .loop_ends import carrier_of, ends, last_link, loop_rows
from .state import State


@dataclass(frozen=True)
class Row:
    """One scalar condition: its name, the constraint it belongs to, and whether it is on speeds."""

    name: str
    owner: str
    on_speeds: bool = False


def rows(model: Model) -> tuple[Row, ...]:
    """Names of all scalar conditions, in order; an underscore keeps them apart from other names of the model."""
    result: list[Row] = []
    held: list[int] = []
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
            # these names are kept apart from others when the model is assembled
            contact = constraint.contact
            held += range(len(result), len(result) + 1 + (0 if constraint.slips else contact.tangents))
            result.append(Row(contact.normal_name, name))
            if not constraint.slips:
                result += [Row(tangent, name, True) for tangent in contact.tangent_names]
        else:
            result.append(Row(name, name, isinstance(constraint, SpeedCondition)))
    for i, row in enumerate(result):
        if i in held:
            continue
        name = row.name
        while name in taken:
            name += "_"
        taken.add(name)
        result[i] = replace(row, name=name)
    return tuple(result)


def radial_names(model: Model) -> dict[str, str]:
    """Of each gear whose pitch point is known, the name of the force that presses its teeth apart, ``mesh_r``."""
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


def residuals(model: Model, state: State, *, contacts: bool = True, pins: bool = True) -> list[Any]:
    """Value of every condition at a state: φ of those on coordinates, ψ of those on speeds.

    Without ``contacts``, and ``pins`` that close loops, zeros stand for theirs.
    """
    result: list[Any] = []
    for constraint in model.constraints.values():
        if isinstance(constraint, Closure):
            leave = constraint.in_ground and not pins
            result += [0] * _conditions(constraint) if leave else _closure(model, state, constraint)
        elif isinstance(constraint, Rope):
            points = [point_position(model, state, point) for point in constraint.points]
            spans = [subtract(b, a) for a, b in zip(points, points[1:], strict=False)]
            # the sign makes the multiplier the tension
            slack: Any = state(constraint.length)
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
    return len(pin.along) + len(pin.square)


def _count(touching: Touching) -> int:
    return 1 if touching.slips else 1 + touching.contact.tangents


def _touching(model: Model, state: State, touching: Touching) -> list[Any]:
    """The gap, and in stick the slip velocities."""
    gap = touch(model, state, touching.contact).gap
    if touching.slips:
        return [gap]
    return [gap, *rows_of(model, state, (touching.contact,)).rate[1:]]


def _displacement(model: Model, state: State, joint: Any) -> Any:
    return state(model.links[model.joints[joint.name].links[0]].displacement)


def _frame(model: Model, state: State, body: Any, axes: Matrix) -> Matrix:
    link, _ = place_of(model, body)
    return multiply(rotation(model, state, link), state.matrix(axes))


def _closure(model: Model, state: State, joint: Closure) -> list[Any]:
    """Seen from the link that carries the whole loop, so that only motions of the loop stand in it.

    The ground's axes, in which the force of the joint is given, are then those of the moment: of R φ with φ = 0 no
    derivative of R matters.
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
    return rotation(model, state.cache.get("start", state), carrier_of(model, joint))


def _thread(state: State, thread: Thread, R_P: Matrix, R_C: Matrix, d: Vector) -> Any:
    """d·n - h φ for small deviations: 2 h tan((d·n/h - φ)/2), which has one zero in a turn and needs no angle.

    cos φ and sin φ are the components of the child's first vector across the axis; of an angle x the tangent of the
    half is sin x/(1 + cos x).
    """
    n, h = state.vector(thread.axis), state(thread.pitch)
    turned = apply(R_C, state.vector(thread.first))
    cosine = dot(apply(R_P, state.vector(thread.first)), turned)
    sine = dot(apply(R_P, state.vector(thread.second)), turned)
    angle = divide(dot(n, d), h)
    c, s = state.field.cos(angle), state.field.sin(angle)
    return divide(2 * h * (s * cosine - c * sine), 1 + c * cosine + s * sine)


def _arm(model: Model, state: State, wheel: Rolling) -> Vector:
    """From the wheel's centre to its lowest point, in ground axes:

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


def _rolling(model: Model, state: State, wheel: Rolling) -> list[Any]:
    arm = _arm(model, state, wheel)
    contact = add(point_position(model, state, wheel.center), arm)
    height = dot(wheel.normal[1], subtract(contact, point_position(model, state, wheel.plane)))
    spin = angular_velocity(model, state, wheel.center.body)
    slip = add(point_velocity(model, state, wheel.center), cross(spin, arm))
    return [height, dot(wheel.first[1], slip), dot(wheel.second[1], slip)]


def torques(model: Model, state: State, gear: Gear) -> list[tuple[str, int, Any]]:
    """(joint, link, force or torque along its displacement) per unit multiplier of a gear of which the ratio is known.

    They act on driven shafts too, which the matrix G, over the free speeds, does not see. None of a gear whose pitch
    point is known: its force acts on the bodies (:func:`wrenches`).
    """
    if isinstance(model.meshes[gear.name], Mesh):
        return []
    pairs = ((gear.first, 1), (gear.second, -state(gear.ratio)))
    return [(joint.name, model.joints[joint.name].links[0], value) for joint, value in pairs]


def separating(model: Model, state: State, gear: Gear) -> tuple[list[tuple[Any, Vector, Vector]], Any]:
    """What presses the teeth of a gear apart: (point, force, moment) per unit force, and that force per unit |λ|.

    No pairs where only the ratio is known; None for the force where the pressure angle is not known.
    """
    mesh = model.meshes[gear.name]
    if not isinstance(mesh, Mesh):
        return [], None
    R = rotation(model, state, mesh.carrier)
    tangent, apart = state.vector(mesh.tangent), state.vector(mesh.apart)
    unit = apply(R, scale(divide(1, state.field.sqrt(dot(apart, apart))), apart))
    size = None
    if gear.pressure_angle is not None:
        size = state.field.sqrt(dot(tangent, tangent)) * state(sympy.tan(gear.pressure_angle))
    return _at_pitch_point(model, state, mesh, unit), size


def _at_pitch_point(
    model: Model, state: State, mesh: Mesh, force: Vector
) -> list[tuple[Any, Vector, Vector]]:
    R, point = rotation(model, state, mesh.carrier), state.vector(mesh.point)
    at = apply(R, point)
    if mesh.carrier != GROUND:
        at = add(link_postures(model, state)[mesh.carrier].position, at)
    return [(Spot(mesh.first, at), force, ZERO), (Spot(mesh.second, at), negate(force), ZERO)]


def wrenches(model: Model, state: State) -> list[list[tuple[Any, Vector, Vector]]]:
    """Per condition, the (point, force, moment) per unit multiplier on bodies, in ground axes.

    Empty for conditions on coordinates and speeds, whose multipliers are generalized forces, and for gears of which
    the ratio alone is known.
    """
    result: list[list[tuple[Any, Vector, Vector]]] = []
    for constraint in model.constraints.values():
        if isinstance(constraint, Closure):
            R_P = _frame(model, state, constraint.parent, constraint.parent_axes)
            R_C = _frame(model, state, constraint.child, constraint.child_axes)
            at = constraint.child.point(*constraint.to)
            for _, e in constraint.along:
                force = state.vector(e) if constraint.in_ground else apply(R_P, state.vector(e))
                # the parent feels the opposite force where the child's point is
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
                # the force acts at the contact: at the centre with its moment about the centre
                result.append([(constraint.center, e, cross(arm, e))])
        elif isinstance(constraint, Rope):
            points = [point_position(model, state, point) for point in constraint.points]
            one: list[tuple[Any, Vector, Vector]] = []
            for k, (a, b) in enumerate(zip(points, points[1:], strict=False)):
                span = subtract(b, a)
                unit = scale(divide(1, state.field.sqrt(dot(span, span))), span)
                one += [(constraint.points[k], unit, ZERO), (constraint.points[k + 1], negate(unit), ZERO)]
            result.append(one)
        elif isinstance(constraint, Touching):
            contact, it = constraint.contact, touch(model, state, constraint.contact)
            forces = [it.normal] if constraint.slips else [it.normal, *it.tangents]
            ends = (Spot(contact.feature.body, it.on_feature), Spot(contact.surface.body, it.on_surface))
            pairs = [[(ends[0], force, ZERO), (ends[1], negate(force), ZERO)] for force in forces]
            if constraint.slips and not contact.frictionless:
                friction = slip_friction(model, state, constraint)
                pairs[0] += [(ends[0], friction, ZERO), (ends[1], negate(friction), ZERO)]
            result += pairs
        elif isinstance(constraint, Gear) and isinstance(mesh := model.meshes[constraint.name], Mesh):
            tangent = apply(rotation(model, state, mesh.carrier), state.vector(mesh.tangent))
            result.append(_at_pitch_point(model, state, mesh, tangent))
        else:
            result.append([])
    return result


def slip_friction(model: Model, state: State, touching: Touching) -> Vector:
    """Friction on the feature per unit normal force, in ground axes: -μ d, with the unit direction of slip d."""
    contact = touching.contact
    tangents = touch(model, state, contact).tangents
    total: Vector = ZERO
    for d, t in zip(slip_direction(model, state, touching), tangents, strict=True):
        total = add(total, scale(d, t))
    return scale(-state(contact.friction), total)


def slip_direction(model: Model, state: State, touching: Touching) -> list[Any]:
    """Components of the unit direction of slip along the tangents: as given, or γ/|γ|."""
    contact = touching.contact
    assert touching.direction is not None
    if touching.direction:
        return [state(d) for d in touching.direction]
    if contact.frictionless:
        return [0] * contact.tangents
    slip = rows_of(model, state, (contact,)).rate[1:]
    square: Any = 0
    for component in slip:
        square = square + component * component
    return [divide(component, state.field.sqrt(square)) for component in slip]


class Linearized:
    """The conditions at a state: residual φ (or ψ), rate ψ, matrix G of the speeds and γ; one entry per row.

    Each is formed when it is asked for: in symbols γ can be far longer than the rest.
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

    def _in_ground(self, pin: Closure) -> tuple[list[list[Any]], list[Any]]:
        """G and γ of a pin, its force in ground axes."""
        G, bias = loop_rows(self._model, self._state, pin, carrier_of(self._model, pin))
        R = _from_carrier(self._model, self._state, pin)
        # a zero times a float is no plain zero
        columns = [apply(R, x) if entries(x) else x for x in zip(*G[:3], strict=True)]
        return [*map(list, zip(*columns, strict=True)), *G[3:]], [
            *apply(R, (bias[0], bias[1], bias[2])),
            *bias[3:],
        ]

    def turned(self, active: Sequence[int]) -> tuple[dict[int, tuple[Any, Any]], list[tuple[list[int], Any]]]:
        """G and γ of rows with the force of a pin in axes of the loop, in which more is constant, and the way back.

        Returns
        -------
        rows : dict
            Row -> (row of G, γ).
        back : list of (rows, matrix)
            The matrix times their multipliers gives those along ground axes.
        """
        found: dict[int, tuple[Any, Any]] = {}
        back = []
        for i, pin in self._pins:
            link = last_link(self._model, pin)
            R = rotation(self._model, self._state, link)
            held = [k for k in range(3) if i + k in active]
            # the others do not mix with these: they are none, or across a plane in which the loop moves
            apart = [k for k in range(3) if k not in held]
            if held and all(entries((R[a][b], R[b][a])) == [] for a in held for b in apart):
                G, bias = loop_rows(self._model, self._state, pin, link)
                found |= {i + k: (G[k], bias[k]) for k in held}
                back.append(([i + k for k in held], [[R[a][b] for b in held] for a in held]))
        return found, back

    def _contact_rows(self, touching: Touching) -> ContactRows:
        return rows_of(self._model, self._state, (touching.contact,))

    @cached_property
    def residual(self) -> tuple[Any, ...]:
        """φ of conditions on coordinates, ψ of those on speeds."""
        return tuple(residuals(self._model, self._state))

    @cached_property
    def rate(self) -> tuple[Any, ...]:
        """ψ = G u + g."""
        along = _along_motion(self._model, self._state, self._state.u, 1, 1)
        pairs = zip(along, self._kinds, strict=True)
        result = [_at(r, 0) if kind.on_speeds else _derivative(r, 1) for r, kind in pairs]
        for i, one in self.touching:
            result[i : i + _count(one)] = self._contact_rows(one).rate[: _count(one)]
        return tuple(result)

    @cached_property
    def bias(self) -> tuple[Any, ...]:
        """γ, what is left of ψ' without accelerations."""
        along = _along_motion(self._model, self._state, self._state.u, 1, 2, pins=False)
        pairs = zip(along, self._kinds, strict=True)
        result = [_derivative(r, 1 if kind.on_speeds else 2) for r, kind in pairs]
        for i, pin in self._pins:
            result[i : i + _conditions(pin)] = self._in_ground(pin)[1]
        for i, one in self.touching:
            result[i : i + _count(one)] = self._contact_rows(one).bias[: _count(one)]
        return tuple(result)

    @cached_property
    def matrix(self) -> tuple[tuple[Any, ...], ...]:
        """G, a row per condition and a column per speed."""
        model, state, kinds = self._model, self._state, self._kinds
        depends = dependence(model)
        still: list[Any] = []
        if _any_speed(kinds):
            rest = [0] * model.n_u
            still = residuals(model, replaced(state, state.field, state.t, state.q, rest), contacts=False)
        found: list[dict[int, Any]] = [{} for _ in kinds]
        for moving in directions(depends.values()):
            unit = [int(j in moving) for j in range(model.n_u)]
            for i, r in enumerate(_along_motion(model, state, unit, 0, 1, pins=False)):
                for j in moving & depends[kinds[i].owner]:
                    found[i][j] = _at(r, 0) - still[i] if kinds[i].on_speeds else _derivative(r, 1)
        result = [tuple(row.get(j, 0) for j in range(model.n_u)) for row in found]
        for i, pin in self._pins:
            result[i : i + _conditions(pin)] = map(tuple, self._in_ground(pin)[0])
        for i, one in self.touching:
            result[i : i + _count(one)] = self._contact_rows(one).matrix[: _count(one)]
        return tuple(result)

    @cached_property
    def acting(self) -> tuple[tuple[Any, ...], ...]:
        """Generalized force per unit multiplier: the rows of G, but for contacts that slip W_N - μ Σ d W_T."""
        result = list(self.matrix)
        for i, one in self.touching:
            if one.slips and not one.contact.frictionless:
                mu = self._state(one.contact.friction)
                row = list(result[i])
                directions = slip_direction(self._model, self._state, one)
                for d, tangent in zip(directions, self._contact_rows(one).matrix[1:], strict=True):
                    row = [a - mu * d * b for a, b in zip(row, tangent, strict=True)]
                result[i] = tuple(row)
        return tuple(result)

    @property
    def symmetric(self) -> bool:
        """Whether all forces act along their own conditions, which sliding friction does not."""
        return not any(one.slips and not one.contact.frictionless for _, one in self.touching)


def linearized(model: Model, state: State) -> Linearized:
    """φ, ψ, G and γ of all conditions."""
    if "constraints" not in state.cache:
        state.cache["constraints"] = Linearized(model, state)
    return state.cache["constraints"]


def _any_speed(kinds: Sequence[Row]) -> bool:
    return any(kind.on_speeds for kind in kinds)


def _along_motion(
    model: Model, state: State, u: Sequence[Any], clock: int, order: int, pins: bool = True
) -> list[Any]:
    """Residuals as series along q' = N(q) u with u constant; ``clock`` is the rate of the time."""
    return residuals(model, state_along(model, state, u, clock, order), contacts=False, pins=pins)


def _derivative(x: Any, k: int) -> Any:
    return x.derivative(k) if isinstance(x, Series) else 0


def _at(x: Any, k: int) -> Any:
    return x.c[k] if isinstance(x, Series) else x
