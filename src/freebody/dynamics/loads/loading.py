"""Sums of loads: wrenches on the links, forces along displacements, potential and power.

A load says its actions (:mod:`freebody.dynamics.loads.actions`); this file knows only the four sorts of actions, and
no kind of load.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial

from ...describe.loads.action import Action, Couple, GeneralizedForce, JointForce, PointForce
from ...describe.part import Part, answer
from ...model.model import GROUND, Model
from ...scalar.algebra import Scalar, Vector, apply_transpose, cross, scale
from ...space.spatial import ZERO6, Spatial, plus
from ..kinematics import arm, place_of, rotation
from ..state import State
from .actions import actions
from .added_mass import added_energy_rate, moving
from .instant import Instant
from .power import action_power, joint_link, speed_of


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


def act(model: Model, state: State, result: Loading, part: Part, acting: Iterable[Action]) -> None:
    """Add the actions of a part to a loading."""
    for action in acting:
        _apply(model, state, result, part, action)


def loading(
    model: Model, state: State, only: set[str] | None = None, *, udot: Sequence[Scalar] | None = None
) -> Loading:
    """Return all loads except gravity (or ``only`` the loads of these names) at a state.

    Loads that ask for accelerations get those of ``udot``; without them, those at u' = 0.
    """
    state = moving(model, state, udot)
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
            link, _ = place_of(model, point.body)
            if link != GROUND:
                r = arm(model, state, point)
                force = apply_transpose(rotation(model, state, link), force)
                result.wrenches[link] = plus(result.wrench(link), (cross(r, force), force))
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
    """Return the power of all loads without potential: forces, couples, motors, dampers, generalized forces.

    That of added mass is not in it, since its kinetic energy is counted.
    """
    total = added_energy_rate(model, state)
    for name, load in model.loads.items():
        if not load.is_conservative:
            for action in actions(model, state, name):
                total = total + action_power(model, state, load, action)
    return total


def weight(model: Model, state: State, mass: Scalar) -> Vector:
    """Return m g, in ground axes."""
    return scale(state(mass), state.vector(model.gravity))
