"""Loads on the links: their actions at a state, wrenches, forces along displacements, potential and power.

A load says its actions to an :class:`Instant`, the machine at a state; everything else here knows only the four sorts
of actions, and no kind of load.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NoReturn

from ..describe.frame import Frame, Point
from ..describe.loads.action import Action, Couple, GeneralizedForce, JointForce, PointForce
from ..describe.part import Part, answer
from ..errors import ModelError, nearest, shown
from ..model.model import GROUND, Link, Model
from ..scalar.algebra import (
    FUNCTIONS,
    HALF,
    ZERO,
    Expression,
    FieldVector,
    Matrix,
    Scalar,
    Vector,
    apply,
    apply_transpose,
    cross,
    dot,
    scale,
    subtract,
    three,
)
from ..scalar.trace import Tape
from ..space.spatial import ZERO6, Spatial, plus
from .kinematics import (
    Spot,
    angular_velocity,
    link_postures,
    place_of,
    point_position,
    point_velocity,
    rotation,
)
from .state import State, traced_state


class Instant:
    """The machine at a state, as a load sees it; :class:`freebody.Load` lists what it gives."""

    def __init__(self, model: Model, state: State, load: Part) -> None:
        self._model = model
        self._state = state
        self._load = load
        self.field = state.field
        self.conditions: list[Scalar] = []
        """Conditions of :meth:`where` so far."""

    def __call__(self, expression: Expression) -> Scalar:
        """Return the value of an expression of the system's names."""
        return self._state(expression)

    def of(self, expression: Expression, values: Mapping[Any, Scalar]) -> Scalar:
        """Return the value of an expression with symbols of its own, which have these values."""
        return self._state.with_values(expression, values)

    def where(self, condition: Scalar, a: Scalar, b: Scalar) -> Scalar:
        """Return a if the condition is greater than zero, else b; both are computed.

        A motion locates the times at which the condition passes through zero; there the value is (a + b)/2.
        """
        self.conditions.append(condition)
        return b + (a - b) * (1 + self._state.field.apply("sign", condition)) * HALF

    def acceleration(self, *_: Any) -> NoReturn:
        """Refuse what would change the masses."""
        raise ModelError(
            f"{_begin(self._load)}a load that depends on accelerations changes the mass matrix, so it is no load. "
            f"Added mass is a body of its own, on a weld; inertia along a joint is armature= or rotor= of "
            f"the joint."
        )

    def __getattr__(self, function: str) -> Callable[..., Scalar]:
        """Return a function of scalars: ``at.sqrt``, ``at.tanh``, ``at.atan2``."""
        if function not in FUNCTIONS:
            names = [*FUNCTIONS, *(name for name in dir(type(self)) if not name.startswith("_"))]
            raise AttributeError(f"the machine at a state has no '{function}'; {nearest(function, names)}")
        return partial(self._state.field.apply, function)

    @property
    def t(self) -> Scalar:
        """Time [s]."""
        return self._state.t

    def vector(self, components: Any, frame: Any = None) -> FieldVector:
        """Return three components in the axes of a body (by default the ground) as a vector in ground axes.

        The components are expressions, or a vector of values.
        """
        v = components.components if isinstance(components, FieldVector) else self._state.vector(components)
        return self._of(v if self._is_ground(frame) else apply(self.rotation(frame), v))

    def rotation(self, body: Any) -> Matrix:
        """Return the rotation matrix R_NB of a body."""
        return rotation(self._model, self._state, self._place(body)[0])

    def position(self, point: Any, frame: Any = None) -> FieldVector:
        """Return the position of a point from the ground's origin [m]."""
        return self._in(point_position(self._model, self._state, self._point(point)), frame)

    def spot(self, body: Any, position: Any) -> Spot:
        """Return the place on a body that is at a position now, in ground axes; it may move over the body."""
        self._place(body)
        return Spot(body, three(position))

    def velocity(self, point: Any, frame: Any = None) -> FieldVector:
        """Return the velocity of a point in the ground [m/s]."""
        return self._in(point_velocity(self._model, self._state, self._point(point)), frame)

    def angular_velocity(self, body: Any, frame: Any = None) -> FieldVector:
        """Return the angular velocity of a body in the ground [rad/s]."""
        self._place(body)
        return self._in(angular_velocity(self._model, self._state, body), frame)

    def line(self, start: Any, end: Any) -> FieldVector:
        """Return the vector from a point to another [m]; long formulas give it a name."""
        d = self.position(end) - self.position(start)
        return self._of(self._state.intermediate("line", self._load.name, d.components))

    def named(self, force: Any) -> FieldVector:
        """Return a vector unchanged; long formulas give it the name of the load."""
        return self._of(self._state.intermediate("pull", self._load.name, three(force)))

    def displacement(self, joint: Any, index: int = 0) -> Scalar:
        """Return a displacement of a joint [m] or [rad]; ``index`` counts those of a joint that has several."""
        return self._state(self._link(joint, index).displacement)

    def rate(self, joint: Any, index: int = 0) -> Scalar:
        """Return the rate of a displacement of a joint [m/s] or [rad/s]."""
        return self._state.rate(self._link(joint, index))

    def _of(self, v: Vector) -> FieldVector:
        return FieldVector(self._state.field, v)

    def _in(self, v: Vector, frame: Any) -> FieldVector:
        """Return a vector, given in ground axes, in the axes of a body."""
        return self._of(v if self._is_ground(frame) else apply_transpose(self.rotation(frame), v))

    def _is_ground(self, frame: Any) -> bool:
        return frame is None or self._place(frame)[0] == GROUND

    def _point(self, point: Any) -> Point | Spot:
        point = point.origin if isinstance(point, Frame) else point
        if not isinstance(point, Point | Spot):
            raise ModelError(f"{_begin(self._load)}expected a point of a body, got {shown(point)}.")
        self._place(point.body)
        return point

    def _place(self, body: Any) -> tuple[int, Vector]:
        return _own_place(self._model, self._load, body)

    def _link(self, joint: Any, index: int) -> Link:
        return self._model.links[_own_link(self._model, self._load, joint, index)]


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

    def plus(self, other: Loading) -> Loading:
        """Return these loads together with others."""
        result = Loading(dict(self.wrenches), dict(self.along), dict(self.generalized))
        for link, wrench in other.wrenches.items():
            result.wrenches[link] = plus(result.wrench(link), wrench)
        for link, value in other.along.items():
            result.along[link] = result.along.get(link, 0) + value
        for j, value in other.generalized.items():
            result.generalized[j] = result.generalized.get(j, 0) + value
        return result


# --- actions -----------------------------------------------------------------------------------


def actions(model: Model, state: State, name: str) -> tuple[Action, ...]:
    """Return the actions of a load at a state, checked.

    Raises
    ------
    ModelError
        The load yields something else, or acts on another system; or its code fails.
    """
    key = ("actions", name)
    if key not in state.cache:
        load = model.loads[name]
        state.cache[key] = asked_actions(model, state, load, load.actions)
    return state.cache[key]


def asked_actions(
    model: Model, state: State, part: Part, question: Callable[[Instant], Any]
) -> tuple[Action, ...]:
    """Return the actions that a part answers at a state, checked."""
    return checked_actions(model, part, answer(part, lambda: tuple(question(Instant(model, state, part)))))


def checked_actions(model: Model, part: Part, acting: Iterable[Action]) -> tuple[Action, ...]:
    """Return actions of a part, their vectors as tuples, if they act on this machine."""
    return tuple(_own_action(model, part, action) for action in acting)


def asked(model: Model, state: State, part: Part, question: Callable[[Instant], Any]) -> Any:
    """Return what a part answers at a state; an error in its code names the part, the line and the cure."""
    return answer(part, lambda: question(Instant(model, state, part)))


def scaled(action: Action, factor: Scalar) -> Action:
    """Return an action times a factor."""
    match action:
        case PointForce():
            return replace(action, force=scale(factor, action.force))
        case Couple():
            return replace(action, moment=scale(factor, action.moment))
    return replace(action, value=factor * action.value)


def act(model: Model, state: State, result: Loading, part: Part, acting: Iterable[Action]) -> None:
    """Add the actions of a part to a loading."""
    for action in acting:
        _apply(model, state, result, part, action)


def conditions(model: Model, state: State, name: str) -> list[Scalar]:
    """Return the conditions on which a load switches (:meth:`Instant.where`), in the order in which it asks."""
    load = model.loads[name]
    at = Instant(model, state, load)
    answer(load, lambda: tuple(load.actions(at)))
    return at.conditions


def places(model: Model) -> dict[str, tuple[Action, ...]]:
    """Return the actions of all loads by name, without their values: where each load acts, in every state."""
    if "places" not in model.memo:
        state = traced_state(model, Tape())
        model.memo["places"] = {
            name: tuple(_without_value(action) for action in actions(model, state, name))
            for name in model.loads
        }
    return model.memo["places"]


def _without_value(action: Action) -> Action:
    match action:
        case PointForce():
            return replace(action, force=ZERO)
        case Couple():
            return replace(action, moment=ZERO)
    return replace(action, value=0)


def _begin(load: Part) -> str:
    return f"{load.heading}: "


def _own_action(model: Model, load: Part, action: Any) -> Action:
    """Return an action of a load, its vectors as tuples, if it acts on this machine."""
    try:
        match action:
            case PointForce(point, force):
                _own_place(model, load, point.body)
                return PointForce(point, three(force))
            case Couple(body, moment):
                _own_place(model, load, body)
                return Couple(body, three(moment))
            case JointForce(joint, _, index):
                _own_link(model, load, joint, index)
                return action
            case GeneralizedForce():
                speed_of(model, load, action.coordinate)
                return action
    except (TypeError, AttributeError) as error:
        raise ModelError(f"{_begin(load)}in its action {shown(action)}: {error}") from None
    raise ModelError(
        f"{_begin(load)}expected fb.PointForce, fb.Couple, fb.JointForce or fb.GeneralizedForce from its actions, got "
        f"{shown(action)}."
    )


def _own_place(model: Model, load: Part, body: Any) -> tuple[int, Vector]:
    if not isinstance(body, Frame):
        raise ModelError(f"{_begin(load)}expected a body, got {shown(body)}.")
    if body.system is not model.described[0] or not (body.is_ground or body.name in model.bodies):
        raise ModelError(
            f"{_begin(load)}body '{body.name}' belongs to another system than '{model.name}'. Take bodies and points "
            f"from the data of the load."
        )
    return place_of(model, body)


def _own_link(model: Model, load: Part, joint: Any, index: int) -> int:
    """Return the link that a displacement of a joint moves."""
    place = model.joints.get(getattr(joint, "name", ""))
    if place is None:
        closes = getattr(joint, "closes", False)
        why = "closes a loop and has no displacement" if closes else f"is not a joint of '{model.name}'"
        raise ModelError(f"{_begin(load)}{shown(joint)} {why}. Name a joint of the tree.")
    if not 0 <= index < len(place.links) or not model.links[place.links[index]].one_dof:
        raise ModelError(f"{_begin(load)}{shown(joint)} has no displacement {shown(index)}.")
    return place.links[index]


def speed_of(model: Model, load: Part, coordinate: Any) -> int:
    """Return the index of the speed to which a force on a coordinate is conjugate."""
    name = f"{model.names.texts.get(coordinate, coordinate)}'"
    if name not in model.speed_names:
        raise ModelError(f"{_begin(load)}'{coordinate}' is no coordinate of '{model.name}'.")
    return model.speed_names.index(name)


def joint_link(model: Model, action: JointForce) -> int:
    """Return the link that the displacement of a joint force moves."""
    return model.joints[action.joint.name].links[action.index]


# --- sums --------------------------------------------------------------------------------------


def loading(model: Model, state: State, only: set[str] | None = None) -> Loading:
    """Return all loads except gravity (or ``only`` the loads of these names) at a state."""
    key = ("loading", None if only is None else frozenset(only))
    if key in state.cache:
        return state.cache[key]
    result = Loading()
    for name, load in model.loads.items():
        if only is None or name in only:
            for action in actions(model, state, name):
                _apply(model, state, result, load, action)
    state.cache[key] = result
    return result


def _apply(model: Model, state: State, result: Loading, load: Part, action: Action) -> None:
    """Add one action to the loading."""
    match action:
        case PointForce(point, force):
            link, origin = place_of(model, point.body)
            if link != GROUND:
                if isinstance(point, Spot):
                    posture = link_postures(model, state)[link]
                    arm = apply_transpose(posture.rotation, subtract(point.position, posture.position))
                else:
                    arm = state.vector(tuple(a + b for a, b in zip(origin, point.components, strict=True)))
                force = apply_transpose(rotation(model, state, link), force)
                result.wrenches[link] = plus(result.wrench(link), (cross(arm, force), force))
        case Couple(body, moment):
            link, _ = place_of(model, body)
            if link != GROUND:
                moment = apply_transpose(rotation(model, state, link), moment)
                result.wrenches[link] = plus(result.wrench(link), (moment, (0, 0, 0)))
        case JointForce():
            link = joint_link(model, action)
            result.along[link] = result.along.get(link, 0) + action.value
        case GeneralizedForce():
            j = speed_of(model, load, action.coordinate)
            result.generalized[j] = result.generalized.get(j, 0) + action.value


def load_potential(model: Model, state: State) -> Scalar:
    """Return the potential energy of all loads that have one, such as springs."""
    total: Scalar = 0
    for load in model.loads.values():
        if load.is_conservative:
            total = total + answer(load, partial(load.potential, Instant(model, state, load)))
    return total


def load_power(model: Model, state: State) -> Scalar:
    """Return the power of all loads without potential: forces, couples, motors, dampers, generalized forces."""
    total: Scalar = 0
    for name, load in model.loads.items():
        if not load.is_conservative:
            for action in actions(model, state, name):
                total = total + action_power(model, state, load, action)
    return total


def action_power(model: Model, state: State, load: Part, action: Action) -> Scalar:
    """Return the power of one action at a state [W]."""
    match action:
        case PointForce(point, force):
            return dot(force, point_velocity(model, state, point))
        case Couple(body, moment):
            return dot(moment, angular_velocity(model, state, body))
        case JointForce():
            return action.value * state.rate(model.links[joint_link(model, action)])
    return action.value * state.u[speed_of(model, load, action.coordinate)]


def weight(model: Model, state: State, mass: Scalar) -> Vector:
    """Return m g, in ground axes."""
    return scale(state(mass), state.vector(model.gravity))
