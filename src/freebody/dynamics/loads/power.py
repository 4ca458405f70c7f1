"""Power of actions, and of a potential in a virtual motion.

In a virtual motion u at fixed time a load with the potential V has the power

    Σ F·(v(u) - v(0)) = -∂V/∂q · G u,

with the rates q' = G u of the coordinates; v(0) are the velocities of driven motions.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...describe.loads.action import Action, Couple, JointForce, PointForce
from ...describe.loads.load import Load
from ...describe.part import Part
from ...errors import ModelError
from ...model.model import GROUND, Model
from ...scalar.algebra import Scalar, apply, dot
from ...scalar.series import derivative_at_start
from ...space.spatial import Spatial
from ..kinematics import angular_velocity, carried, place_of, point_velocity, replaced, rotation, state_along
from ..state import State
from .instant import Instant


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


def power_in(model: Model, state: State, action: Action, twists: Sequence[Spatial]) -> Scalar:
    """Return the power of a force or a couple if the links move with these (w, v)."""
    if isinstance(action, PointForce):
        return dot(action.force, carried(model, state, action.point, twists))
    assert isinstance(action, Couple)
    link, _ = place_of(model, action.body)
    return 0 if link == GROUND else dot(action.moment, apply(rotation(model, state, link), twists[link][0]))


def virtual_powers(
    model: Model, state: State, load: Load, u: Sequence[Scalar], acting: Sequence[Action]
) -> tuple[float, float]:
    """Return the power of the actions of a load in a virtual motion of numbers, and that of its potential.

    Parameters
    ----------
    state : State of numbers
    load : Load with a potential
    u : speeds of the virtual motion
    acting : actions of the load at the state
    """
    moving = replaced(state, state.field, state.t, state.q, u)
    resting = replaced(state, state.field, state.t, state.q, [0] * model.n_u)
    power = sum(
        float(action_power(model, moving, load, action)) - float(action_power(model, resting, load, action))
        for action in acting
    )
    along = state_along(model, state, u, 0, 1)
    return power, -float(derivative_at_start(load.potential(Instant(model, along, load))))
