"""Actions of loads and contacts at a state, checked: they are of four sorts, and act on this machine."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from typing import Any

from ...describe.loads.action import Action, Couple, GeneralizedForce, JointForce, PointForce
from ...describe.loads.load import Load
from ...describe.part import Part, answer, blame, is_own, line_of
from ...errors import ModelError, shown
from ...model.model import Model
from ...scalar.algebra import ZERO, Scalar, Vector, scale, three
from ...scalar.trace import Tape
from ..kinematics import accelerations
from ..state import State, traced_state
from .instant import Instant, own_link, own_place
from .own_kinds import Act, Ask, check_inertia, check_kind, values_of
from .power import speed_of

YIELD = "Yield what acts, such as fb.PointForce(self.point, force) with the three components of the force."
"""Cure for actions that are none."""


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


def accelerating(model: Model) -> frozenset[str]:
    """Return the names of the loads that ask for accelerations."""
    if "accelerating" not in model.memo:
        tape = Tape()
        state = traced_state(model, tape)
        links = [
            (_inputs(tape, f"turning {i}"), _inputs(tape, f"motion {i}")) for i in range(len(model.links))
        ]
        moving = state.accelerated(links)
        asking = set()
        for name, load in model.loads.items():
            at = Instant(model, moving, load)
            try:
                _actions_at(at, model, load, load.actions)
            except ArithmeticError as error:  # of plain numbers: at a recorded state nothing else can fail
                if not is_own(load):
                    raise
                blame(load, error)
            if at.asked_accelerations:
                asking.add(name)
        model.memo["accelerating"] = frozenset(asking)
    return model.memo["accelerating"]


def _inputs(tape: Tape, what: str) -> Vector:
    return (tape.input(f"{what} x"), tape.input(f"{what} y"), tape.input(f"{what} z"))


def _moving(model: Model, state: State, part: Part) -> State:
    """Return the state with the accelerations at u' = 0 for a load that asks for them, if it has none."""
    if not isinstance(part, Load) or state.accelerations is not None or part.name not in accelerating(model):
        return state
    return state.accelerated(accelerations(model, state, None))


def asked_actions(
    model: Model, state: State, part: Part, question: Callable[[Instant], Any]
) -> tuple[Action, ...]:
    """Return the actions that a part answers at a state, checked."""
    if is_own(part):

        def act(state: State) -> tuple[Action, ...]:
            return _actions_at(Instant(model, _moving(model, state, part), part), model, part, question)

        _once(model, part, question, lambda state: values_of(act(state)), act)
    return _actions_at(Instant(model, _moving(model, state, part), part), model, part, question)


def _actions_at(
    at: Instant, model: Model, part: Part, question: Callable[[Instant], Any]
) -> tuple[Action, ...]:
    found = answer(part, partial(question, at))
    if isinstance(found, str) or not hasattr(found, "__iter__"):
        raise ModelError(
            f"{part.heading}: expected actions, got {shown(found)} {line_of(found, question)}. {YIELD}"
        )
    rest, result = iter(found), []
    while (action := answer(part, lambda: next(rest, None))) is not None:
        try:
            result.append(_own_action(model, part, action))
        except ModelError as error:
            if not is_own(part):
                raise
            raise ModelError(f"{error} {line_of(found, question)}") from None
    return tuple(result)


def checked_actions(model: Model, part: Part, acting: Iterable[Action]) -> tuple[Action, ...]:
    """Return actions of a part, their vectors as tuples, if they act on this machine."""
    return tuple(_own_action(model, part, action) for action in acting)


def asked(model: Model, state: State, part: Part, question: Callable[[Instant], Any]) -> Any:
    """Return what a part answers at a state; an error in its code names the part, the line and the cure."""

    def ask(state: State) -> Any:
        return answer(part, lambda: question(Instant(model, state, part)))

    if is_own(part) and not question.__name__.startswith("<"):  # a function of its own, not of this package
        _once(model, part, question, lambda state: [ask(state)])
    return ask(state)


def _once(
    model: Model, part: Part, question: Callable[[Instant], Any], ask: Ask, act: Act | None = None
) -> None:
    """Check a user's kind the first time that a model asks it."""
    checked = model.memo.setdefault("checked kinds", set())
    key = (part.table, part.name, getattr(question, "__qualname__", ""))
    if key not in checked:
        checked.add(key)
        check_kind(model, part, question, ask, act)
        if act is not None and isinstance(part, Load) and part.name in accelerating(model):
            check_inertia(model, part, question, act)


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
    at = Instant(model, _moving(model, state, load), load)
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
        f"{load.heading}: expected fb.PointForce, fb.Couple, fb.JointForce or fb.GeneralizedForce from its actions, "
        f"got {shown(action)}. {YIELD}"
    )
