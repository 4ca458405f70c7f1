"""Actions of loads and contacts at a state, checked: they are of four sorts, and act on this machine."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

from ...describe.loads.action import Action, Couple, GeneralizedForce, JointForce, PointForce
from ...describe.part import Part, answer
from ...errors import ModelError, shown
from ...model.model import Model
from ...scalar.algebra import ZERO, Scalar, dot, scale, three
from ...scalar.trace import Tape
from ..kinematics import angular_velocity, point_velocity
from ..state import State, traced_state
from .instant import Instant, own_link, own_place


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


def _own_action(model: Model, load: Part, action: Any) -> Action:
    """Return an action of a load, its vectors as tuples, if it acts on this machine."""
    try:
        match action:
            case PointForce(point, force):
                own_place(model, load, point.body)
                return PointForce(point, three(force))
            case Couple(body, moment):
                own_place(model, load, body)
                return Couple(body, three(moment))
            case JointForce(joint, _, index):
                own_link(model, load, joint, index)
                return action
            case GeneralizedForce():
                speed_of(model, load, action.coordinate)
                return action
    except (TypeError, AttributeError) as error:
        raise ModelError(f"{load.heading}: in its action {shown(action)}: {error}") from None
    raise ModelError(
        f"{load.heading}: expected fb.PointForce, fb.Couple, fb.JointForce or fb.GeneralizedForce from its actions, got "
        f"{shown(action)}."
    )


def speed_of(model: Model, load: Part, coordinate: Any) -> int:
    """Return the index of the speed to which a force on a coordinate is conjugate."""
    name = f"{model.names.texts.get(coordinate, coordinate)}'"
    if name not in model.speed_names:
        raise ModelError(f"{load.heading}: '{coordinate}' is no coordinate of '{model.name}'.")
    return model.speed_names.index(name)


def joint_link(model: Model, action: JointForce) -> int:
    """Return the link that the displacement of a joint force moves."""
    return model.joints[action.joint.name].links[action.index]


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
