"""States along a motion, as truncated series in time.

    q' = N(q) u,   u' = 0

Any algorithm that runs on such a state returns series whose coefficients are the exact time derivatives of its result.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..model.model import Model
from ..scalar.algebra import Field, Scalar, divide
from ..scalar.series import Series, SeriesField
from .kinematics import coordinate_rates
from .state import State


def state_along(model: Model, state: State, u: Sequence[Scalar], clock: int, order: int) -> State:
    """Return the state to first or second order along q' = N(q) u with u constant; ``clock`` is the rate of time."""
    field = SeriesField(state.field, order)
    first = coordinate_rates(model, replaced(state, state.field, state.t, state.q, u))
    taylor = [[a, b] for a, b in zip(state.q, first, strict=True)]
    if order > 1:
        short = SeriesField(state.field, 1)
        moving = replaced(state, short, state.t, [short.series(c) for c in taylor], u)
        for coefficients, rate in zip(taylor, coordinate_rates(model, moving), strict=True):
            coefficients.append(divide(rate.derivative(1), 2) if isinstance(rate, Series) else 0)
    t = field.series([state.t, clock]) if clock else state.t
    result = replaced(state, field, t, [field.series(c) for c in taylor], u)
    result.cache["start"] = state  # for axes that stay in place
    return result


def state_moving(model: Model, state: State, udot: Sequence[Scalar]) -> State:
    """Return the state with coordinates to second order along the motion with accelerations ``udot``, speeds unchanged.

    Functions of position then have their exact first and second time derivatives as coefficients.
    """
    first_order, second_order = SeriesField(state.field, 1), SeriesField(state.field, 2)
    first = coordinate_rates(model, state)
    u = [first_order.series([a, b]) for a, b in zip(state.u, udot, strict=True)]
    q = [first_order.series([a, b]) for a, b in zip(state.q, first, strict=True)]
    rates = coordinate_rates(model, replaced(state, first_order, first_order.series([state.t, 1]), q, u))
    taylor = [
        second_order.series([a, b, divide(rate.derivative(1), 2) if isinstance(rate, Series) else 0])
        for a, b, rate in zip(state.q, first, rates, strict=True)
    ]
    return replaced(state, second_order, second_order.series([state.t, 1]), taylor, state.u)


def replaced(state: State, field: Field, t: Scalar, q: Sequence[Scalar], u: Sequence[Scalar]) -> State:
    """Return the state of the same model and parameters at another instant."""
    return State(state.model, field, t, q, u, state.values)
