"""Power of a load in a virtual motion, by its actions and by its potential.

In a virtual motion u at fixed time a load with the potential V has the power

    Σ F·(v(u) - v(0)) = -∂V/∂q · G u,

with the rates q' = G u + g(t) of the coordinates; v(0) are the velocities of driven motions.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...describe.loads.load import Load
from ...model.model import Model
from ...scalar.algebra import Scalar
from ...scalar.series import derivative_at_start
from ..kinematics import replaced, state_along
from ..state import State
from .actions import action_power, actions
from .instant import Instant


def virtual_powers(model: Model, state: State, load: Load, u: Sequence[Scalar]) -> tuple[float, float]:
    """Return the power of the actions of a load in a virtual motion of numbers, and that of its potential.

    Parameters
    ----------
    state : State of numbers
    load : Load with a potential
    u : speeds of the virtual motion
    """
    found = actions(model, state, load.name)
    moving = replaced(state, state.field, state.t, state.q, u)
    resting = replaced(state, state.field, state.t, state.q, [0] * model.n_u)
    power = sum(
        float(action_power(model, moving, load, action)) - float(action_power(model, resting, load, action))
        for action in found
    )
    along = state_along(model, state, u, 0, 1)
    return power, -float(derivative_at_start(load.potential(Instant(model, along, load))))
