"""The simulator of a live page: the machine as a WebAssembly module, and everything that the page tells it and shows.

A page holds the module (`motion.live.module`), the addresses of its fields, the sliders, and how what the page shows
follows from the outputs of a frame (`moving.live.Outputs`) and from the parameters (`Follow`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy

from ...describe.system import System
from ...dynamics.newton_euler import bias
from ...dynamics.state import State, float_state
from ...errors import FreebodyError
from ...model.model import Model
from ...motion.live.export import check_live, setting_of
from ...motion.live.machine import LiveMachine
from ...motion.live.module import module_of
from ...motion.trajectory.units import unit_of
from ..moving.keyframes import Keyframes
from ..moving.live import Outputs
from .follow import Follow
from .sliders import sliders

if TYPE_CHECKING:
    from ...motion.trajectory.trajectory import Trajectory

FEWEST, MOST = 400, 2400
"""Bounds for the number of frames of a motion that the page computes."""

MOST_STEPS = 20_000
"""Most steps of such a motion: some 50 ms of computation for a small machine."""

SAME = 1e-9
"""Relative difference up to which the formula of an answer gives its value."""


def simulator(
    s: System, trajectory: Trajectory, keys: Keyframes, scene: Mapping[str, Any], answers: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the data of a live page besides its scene.

    Raises
    ------
    SimulationError
        If the page cannot compute such a motion (`check_live`).
    """
    check_live(trajectory)
    kernels = trajectory.kernels
    outputs, follow = Outputs(kernels), Follow.of(trajectory, keys, scene)
    shown = followed_answers(trajectory, answers)
    held = holding(kernels.model)
    frames = int(np.clip(2 * len(keys.t), FEWEST, MOST))

    def asked(state: State) -> list[Any]:
        numbers = [state(x) for x in shown.values()]
        try:
            return numbers + holding_forces(kernels.model, state, held)
        except ZeroDivisionError:
            # a law has no value at rest, such as the slip of a tyre: no forces hold the machine
            held.clear()
            return numbers

    machine = LiveMachine(setting_of(trajectory, MOST_STEPS, frames), outputs, asked)
    module = module_of(machine, answers=tuple(shown))
    initial, near = trajectory.initial, trajectory.near
    path = trajectory.path
    length = path.end - path.start
    model = kernels.model
    places = {name: i for i, name in enumerate(module.parameters)} | {
        name: i for i, name in enumerate(module.state)
    }
    found = sliders(s, model, trajectory.values, initial, near, follow.beyond)
    for slider in found:
        slider["place"] = places[slider["name"]]
        if slider["group"] == "initial":
            slider["unit"] = unit_of(trajectory, slider["name"])
    return {
        "module": np.frombuffer(module.code, dtype=np.uint8),
        "record": module.address,
        "fields": {name: list(place) for name, place in module.fields.items()},
        "sliders": found,
        "length": length,
        "start": path.start,
        "bodies": outputs.bodies,
        "channels": {key: place for key, place in outputs.channels.items() if key in scene["channels"]},
        "points": outputs.points,
        "contacts": outputs.contacts,
        "figure": follow.numbers,
        "nodes": follow.nodes,
        "beyond": sorted(follow.beyond),
        "events": list(module.events),
        "answers": list(module.answers),
        "holding": {name: unit for name, (_, unit) in held.items()},
        "assumed": list(module.assumed),
        "conditions": list(module.conditions),
        "state": list(module.state),
        "laws": [] if machine.sides is None else list(machine.sides.texts),
    }


# -- forces that hold a position -------------------------------------------------------------------------------


def holding(model: Model) -> dict[str, tuple[int, str]]:
    """Return the speed that belongs to each coordinate of a machine without constraints, and the unit of its force.

    A coordinate with a force is the whole displacement of one joint; others have none.
    """
    if model.constraints:
        return {}
    links: dict[int, list[Any]] = {}
    for link in model.links:
        for k, _ in link.partials:
            links.setdefault(k, []).append(link)
    result = {}
    for k, moved in links.items():
        if len(moved) == 1 and len(moved[0].partials) == 1 and moved[0].partials[0][1] == 1:
            result[model.speed_names[k].removesuffix("'")] = (k, "N" if moved[0].slides_only else "N m")
    return result


def holding_forces(model: Model, state: State, held: Mapping[str, tuple[int, str]]) -> list[Any]:
    """Return the forces and torques that hold the machine at rest where it is: Q_k = h_k(q, 0)."""
    if not held:
        return []
    at_rest = State(model, state.field, state.t, state.q, [0] * model.n_u, state.values)
    h = bias(model, at_rest)
    return [h[k] for k, _ in held.values()]


# -- answers --------------------------------------------------------------------------------------------------


def followed_answers(trajectory: Trajectory, answers: Mapping[str, Any]) -> dict[str, Any]:
    """Return the formulas of answers that depend on parameters alone and give the answers' values, by name."""
    model, result = trajectory.kernels.model, {}
    parameters = {parameter.name: parameter.symbol for parameter in model.parameters}
    state = float_state(model, values=trajectory.values)
    for name, answer in answers.items():
        formula, value = getattr(answer, "formula", None), getattr(answer, "value", None)
        if not isinstance(formula, sympy.Expr) or not isinstance(value, int | float):
            continue
        for short, meant in getattr(
            answer, "where", {}
        ).items():  # earlier abbreviations may contain later ones
            formula = formula.subs({x: meant for x in formula.free_symbols if x.name == short})
        formula = formula.subs({x: parameters[x.name] for x in formula.free_symbols if x.name in parameters})
        if not formula.free_symbols or not formula.free_symbols <= {*parameters.values()}:
            continue
        try:
            number = float(state(formula))
        except (FreebodyError, ValueError, TypeError, ZeroDivisionError, OverflowError):
            continue
        if abs(number - value) <= SAME * max(abs(value), abs(number)):
            result[name] = formula
    return result
