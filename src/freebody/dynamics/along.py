"""A state carried along a motion without accelerations, as truncated series in time.

    q' = N(q) u,   u' = 0

What an algorithm computes on it has the exact time derivatives of its result as coefficients.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..model.model import Model
from ..scalar.algebra import divide
from ..scalar.series import Series, SeriesField
from .kinematics import coordinate_rates
from .state import State


def state_along(model: Model, state: State, u: Sequence[Any], clock: int, order: int) -> State:
    """The state of first or second order along q' = N(q) u with u constant; ``clock`` is the rate of the time."""
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
    result.cache["start"] = state  # for axes that do not move along
    return result


def state_moving(model: Model, state: State, udot: Sequence[Any]) -> State:
    """The coordinates of second order along the motion with the accelerations ``udot``; speeds stay those of the state.

    What is computed from positions has its exact first and second derivatives as coefficients.
    """
    one, two = SeriesField(state.field, 1), SeriesField(state.field, 2)
    first = coordinate_rates(model, state)
    u = [one.series([a, b]) for a, b in zip(state.u, udot, strict=True)]
    q = [one.series([a, b]) for a, b in zip(state.q, first, strict=True)]
    rates = coordinate_rates(model, replaced(state, one, one.series([state.t, 1]), q, u))
    taylor = [
        two.series([a, b, divide(rate.derivative(1), 2) if isinstance(rate, Series) else 0])
        for a, b, rate in zip(state.q, first, rates, strict=True)
    ]
    return replaced(state, two, two.series([state.t, 1]), taylor, state.u)


def replaced(state: State, field: Any, t: Any, q: Sequence[Any], u: Sequence[Any]) -> State:
    """The same model and parameters at another instant."""
    return State(state.model, field, t, q, u, state.values)
