"""Loads on the links: wrenches, forces along displacements, and their potential and power."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ..describe.loads.load import (
    Damper,
    Force,
    GeneralizedForce,
    JointDamper,
    JointForce,
    JointSpring,
    Spring,
    Torque,
)
from ..model.model import GROUND, Model
from ..scalar.algebra import (
    HALF,
    Scalar,
    Vector,
    apply,
    apply_transpose,
    cross,
    divide,
    dot,
    negate,
    scale,
    subtract,
)
from ..space.spatial import ZERO6, Spatial, plus
from .kinematics import angular_velocity, place_of, point_position, point_velocity, rotation
from .state import State


@dataclass
class Loading:
    """Loads sorted by link, displacement and speed."""

    wrenches: dict[int, Spatial] = field(default_factory=dict)
    """Per link: (moment about the link's origin, force) in link axes."""
    along: dict[int, Scalar] = field(default_factory=dict)
    """Per 1-dof link: force or moment conjugate to its displacement."""
    generalized: dict[int, Scalar] = field(default_factory=dict)
    """Per speed: generalized force."""

    def wrench(self, link: int) -> Spatial:
        """Return the wrench on a link, zero if there is none."""
        return self.wrenches.get(link, ZERO6)


def loading(model: Model, state: State, only: set[str] | None = None) -> Loading:
    """Return all loads except gravity (or ``only`` the loads of these names) at a state."""
    key = ("loading", None if only is None else frozenset(only))
    if key in state.cache:
        return state.cache[key]
    result = Loading()
    for name, load in model.loads.items():
        if only is not None and name not in only:
            continue
        if isinstance(load, Force | Spring | Damper):
            for point, force_N in point_forces(model, state, load):
                _press(model, state, result, point, force_N)
        elif isinstance(load, Torque):
            for body, moment_N in couples(model, state, load):
                link, _ = place_of(model, body)
                if link != GROUND:
                    moment = apply_transpose(rotation(model, state, link), moment_N)
                    result.wrenches[link] = plus(result.wrench(link), (moment, (0, 0, 0)))
        elif isinstance(load, GeneralizedForce):
            j = speed_of(model, load)
            result.generalized[j] = result.generalized.get(j, 0) + state(load.value)
        else:
            link = model.joints[load.joint.name].links[load.index]
            result.along[link] = result.along.get(link, 0) + joint_force(model, state, load)
    state.cache[key] = result
    return result


def speed_of(model: Model, load: GeneralizedForce) -> int:
    """Return the index of the speed to which a generalized force is conjugate."""
    name = model.names.texts[load.coordinate] + "'"
    return model.speed_names.index(name)


def joint_force(model: Model, state: State, load: JointSpring | JointDamper | JointForce) -> Scalar:
    """Return the force of a joint's spring, damper or motor, conjugate to the displacement."""
    link = model.links[model.joints[load.joint.name].links[load.index]]
    if isinstance(load, JointSpring):
        return -(state(load.stiffness) * (state(link.displacement) - state(load.rest)))
    if isinstance(load, JointDamper):
        return -(state(load.damping) * state.rate(link))
    return state(load.value)


def point_forces(model: Model, state: State, load: Force | Spring | Damper) -> list[tuple[Any, Vector]]:
    """Return (point, force in ground axes) of a force at a point, or of a spring or damper at its two ends."""
    if isinstance(load, Force):
        frame, _ = place_of(model, load.frame)
        return [(load.point, apply(rotation(model, state, frame), state.vector(load.components)))]
    span_N, length = span(model, state, load)
    if isinstance(load, Spring):
        tension = divide(state(load.stiffness) * (length - state(load.rest)), length)
    else:
        tension = divide(
            state(load.damping) * dot(span_N, _relative_velocity(model, state, load)), length * length
        )
    force = state.intermediate("pull", load.name, scale(tension, span_N))
    return [(load.start, force), (load.end, negate(force))]


def span(model: Model, state: State, load: Spring | Damper) -> tuple[Vector, Scalar]:
    """Return the vector from start to end in ground axes, and its length."""
    d = subtract(point_position(model, state, load.end), point_position(model, state, load.start))
    d = state.intermediate("line", load.name, d)
    return d, state.field.sqrt(dot(d, d))


def _relative_velocity(model: Model, state: State, load: Spring | Damper) -> Vector:
    return subtract(point_velocity(model, state, load.end), point_velocity(model, state, load.start))


def couples(model: Model, state: State, load: Torque) -> list[tuple[Any, Vector]]:
    """Return (body, moment in ground axes) of a couple and of its opposite."""
    frame, _ = place_of(model, load.frame)
    moment = apply(rotation(model, state, frame), state.vector(load.components))
    pair = [(load.body, moment)]
    return pair if load.reaction_on is None else [*pair, (load.reaction_on, negate(moment))]


def _press(model: Model, state: State, result: Loading, point: Any, force_N: Vector) -> None:
    link, origin = place_of(model, point.body)
    if link == GROUND:
        return
    arm = state.vector(tuple(a + b for a, b in zip(origin, point.components, strict=True)))
    force = apply_transpose(rotation(model, state, link), force_N)
    result.wrenches[link] = plus(result.wrench(link), (cross(arm, force), force))


def spring_energy(model: Model, state: State) -> Scalar:
    """Return the energy ½ k (displacement - rest)² of all springs."""
    total: Scalar = 0
    for load in model.loads.values():
        if isinstance(load, JointSpring):
            link = model.links[model.joints[load.joint.name].links[load.index]]
            stretch = state(link.displacement) - state(load.rest)
        elif isinstance(load, Spring):
            stretch = span(model, state, load)[1] - state(load.rest)
        else:
            continue
        total = total + HALF * state(load.stiffness) * stretch * stretch
    return total


def load_power(model: Model, state: State) -> Scalar:
    """Return the power of all loads without potential: forces, couples, motors, dampers, generalized forces."""
    total: Scalar = 0
    for load in model.loads.values():
        if isinstance(load, Force | Damper):
            for point, force in point_forces(model, state, load):
                total = total + dot(force, point_velocity(model, state, point))
        elif isinstance(load, Torque):
            for body, moment in couples(model, state, load):
                total = total + dot(moment, angular_velocity(model, state, body))
        elif isinstance(load, GeneralizedForce):
            total = total + state(load.value) * state.u[speed_of(model, load)]
        elif isinstance(load, JointForce | JointDamper):
            link = model.links[model.joints[load.joint.name].links[load.index]]
            total = total + joint_force(model, state, load) * state.rate(link)
    return total


def weight(model: Model, state: State, mass: Scalar) -> Vector:
    """Return m g, in ground axes."""
    return scale(state(mass), state.vector(model.gravity))
