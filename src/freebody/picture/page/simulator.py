"""The simulator of a live page: the machine as a WebAssembly module, and everything that the page tells it and shows.

A page holds the module (`motion.live.module`), the addresses of its fields, the sliders, and how what the page shows
follows from the outputs of a frame (`moving.live.Outputs`) and from the parameters (`Follow`).
"""

from __future__ import annotations

import base64
import gzip
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy

from ...describe.system import System
from ...dynamics.state import float_state
from ...errors import FreebodyError
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
    frames = int(np.clip(2 * len(keys.t), FEWEST, MOST))
    machine = LiveMachine(
        setting_of(trajectory, MOST_STEPS, frames), outputs, lambda state: [state(x) for x in shown.values()]
    )
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
        "module": base64.b64encode(gzip.compress(module.code, 9, mtime=0)).decode("ascii"),
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
        "assumed": list(module.assumed),
        "conditions": list(module.conditions),
        "state": list(module.state),
    }


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
        where = getattr(answer, "where", {})
        formula = formula.subs({x: where[x.name] for x in formula.free_symbols if x.name in where})
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
