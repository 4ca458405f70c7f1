"""Blows in time steps: impulses of a step, beside those of its contacts, at the positions in its middle.

    M (u⁺ - u) = h f + Jᵀ P + Gᵀ λ + Wᵀ Λ

Against a surface, P is the impulse with which the point of a machine without contacts and loads would leave it,
n·v⁺ = -e n·v⁻.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...dynamics.impulse import blows_on, generalized_impulse, speed_jumps
from ...dynamics.state import State, float_state
from ...errors import ModelError, SimulationError
from ..legs.blow import Blow, refused_return
from ..ode.dense_output import Array, Crossing, observe
from .mean_motion import middle_of


def strike(run: Any, now: Sequence[Blow]) -> None:
    """Set the generalized impulse of blows in the next step of a run, each after the ones before it."""
    from ..legs.impulse import acting_blow  # imports all rooms of equations

    model, n_q, t, h = run.model, run.model.n_q, run.grid.times[run.done], run.grid.lengths[run.done]
    y = run.states[run.done].copy()
    rates = observe(run.program.address("moving"), n_q + 1, np.array([t]), y[None], run.memory.machine.c)
    middle = middle_of(model, y[None], rates, h)[0]
    state = _state(run, t + h / 2, middle, y[n_q:])
    told: list[tuple[str, list[Any]]] = []

    def generalized(blows: Sequence[Any]) -> Any:
        return generalized_impulse(model, state, blows_on(model, state, blows))

    def jumps(f: Sequence[Any]) -> Any:
        return speed_jumps(model, state, f, run.kernels.active)

    for one in now:
        earlier, met = [blow for _, blows in told for blow in blows], state
        try:
            if one.options["restitution"] is not None and earlier:
                met = _state(run, t + h / 2, middle, y[n_q:] + np.array(jumps(generalized(earlier))[0]))
            told.append((one.name, [acting_blow(model, met, jumps, one.options)]))
        except ModelError as error:
            raise SimulationError(
                f"The blow '{one.name}' at t = {t:.9g} s cannot be applied: {error}"
            ) from None
    total = generalized([blow for _, blows in told for blow in blows])
    run.memory.blow[:] = np.array([float(x) for x in total])[run.shape.order]
    run.blows[run.done] = told


def calls(run: Any, one: Blow, crossing: Crossing) -> bool:
    """Return True if a crossing calls for a blow: not in a step that has one, and for one against a surface, where its
    point approaches it.

    Raises
    ------
    SimulationError
        A rebound that the loads turn round within its step.
    """
    if one.options["normal"] is None:
        return not run.struck
    if not run.struck:
        return _approach(run, one, crossing.time, crossing.state) > 0
    end = run.reached
    if one.options["restitution"] != 0 and _approach(run, one, run.grid.times[end], run.states[end]) > 0:
        raise refused_return(one, crossing.time, run.grid.lengths[end - 1])
    return False


def _approach(run: Any, one: Blow, t: float, y: Array) -> float:
    """Return the speed with which the point of a blow approaches its surface."""
    from ..legs.impulse import approach_to_surface

    return approach_to_surface(run.model, _state(run, t, *np.split(y, [run.model.n_q])), one.options)


def _state(run: Any, t: float, q: Array, u: Array) -> State:
    return float_state(run.model, q.tolist(), u.tolist(), t, run.values.numbers)
