"""The simulator of a live page: the machine as a WebAssembly module, and everything that the page tells it and shows.

A page holds the module (`motion.live.module`), the addresses of its fields, the sliders, and how what the page shows
follows from the outputs of a frame (`moving.live.Outputs`) and from the parameters (`Follow`).
"""

from __future__ import annotations

import base64
import gzip
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy

from ...describe.system import System
from ...dynamics.state import float_state
from ...errors import FreebodyError, ModelError
from ...motion.live.export import check_live, setting_of
from ...motion.live.machine import LiveMachine
from ...motion.live.module import module_of
from ...motion.trajectory.units import unit_of
from ..moving.keyframes import Keyframes
from ..moving.live import Outputs
from .animation import figure
from .sliders import sliders

if TYPE_CHECKING:
    from ...motion.trajectory.trajectory import Trajectory

FEWEST, MOST = 400, 2400
"""Bounds for the number of frames of a motion that the page computes."""

MOST_STEPS = 20_000
"""Most steps of such a motion: some 50 ms of computation for a small machine."""

Path = tuple[Any, ...]
Tree = Mapping[Path, Any]
"""Numbers and texts of a drawing, by their paths in its data."""

PARTS = (-0.5, -0.2, 0.3, 0.5)
"""Changes of a parameter, as parts of its value, at which the drawing is compared with its linear extrapolation."""

ROUND = 1e-9
"""Difference from that extrapolation, relative to the numbers and the size of the machine, that is round-off."""


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
        "wheels": outputs.wheels,
        "figure": follow.numbers,
        "beyond": sorted(follow.beyond),
        "events": list(module.events),
        "answers": list(module.answers),
        "assumed": list(module.assumed),
        "conditions": list(module.conditions),
        "state": list(module.state),
    }


# -- the drawing as a function of the parameters ----------------------------------------------------------------


@dataclass(frozen=True)
class Follow:
    """How the numbers of a drawing follow the parameters: f(p) = f(p₀) + Σ_k s_k (p_k - p₀_k).

    Lengths, radii and places of points are of this form unless a description multiplies or divides lengths. It is
    checked, each parameter by itself and all together.

    Attributes
    ----------
    numbers : list
        Path to a number in the scene, its value, and its slopes [number of the parameter, slope].
    beyond : set of str
        Parameters on which the drawing depends in another way.
    """

    numbers: list[list[Any]] = field(default_factory=list)
    beyond: set[str] = field(default_factory=set)

    @classmethod
    def of(cls, trajectory: Trajectory, keys: Keyframes, scene: Mapping[str, Any]) -> Follow:
        """Return how the drawing of a scene follows the parameters."""
        model, values, size = trajectory.kernels.model, trajectory.values, scene["size"]
        up = np.array(scene["up"])

        def drawn(changed: Mapping[str, float]) -> dict[Path, Any]:
            picture = figure(model, {**values, **changed}, keys, size, up)
            picture["arrows"] = [a for a in picture["arrows"] if a["channel"] in scene["channels"]]
            bodies = {cone["body"] for cone in scene["cones"]}
            picture["cones"] = [cone for cone in picture["cones"] if cone["body"] in bodies]
            return dict(_leaves(picture))

        base = drawn({})
        slopes: dict[str, dict[Path, float]] = {}
        beyond: set[str] = set()
        for name, value in values.items():
            steps = [part * (value or 1.0) for part in PARTS]
            found = _slopes(base, [(step, _or_none(drawn, {name: value + step})) for step in steps], size)
            if found is None:
                beyond.add(name)
            elif found:
                slopes[name] = found
        together = {name: values[name] * (1 + part) for name, part in zip(slopes, _parts(), strict=False)}
        wrong = _wrong(base, slopes, values, together, _or_none(drawn, together), size)
        for name in [name for name, found in slopes.items() if wrong is None or wrong & found.keys()]:
            beyond.add(name)
            del slopes[name]
        places = {parameter.name: i for i, parameter in enumerate(model.parameters)}
        numbers: dict[Path, list[Any]] = {}
        for name, found in slopes.items():
            for path, slope in found.items():
                numbers.setdefault(path, [list(path), base[path], []])[2].append([places[name], slope])
        return cls(list(numbers.values()), beyond)


def _parts() -> Iterator[float]:
    """Changes of several parameters at once, no two equal."""
    k = 0
    while True:
        yield 0.4 * (-1) ** k / (1 + 0.3 * k)
        k += 1


def _or_none(drawn: Any, changed: Mapping[str, float]) -> Tree | None:
    """The drawing at values that it may not exist for."""
    try:
        result: Tree = drawn(changed)
    except (ModelError, ValueError, ZeroDivisionError):
        return None
    return result


def _leaves(tree: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Numbers and texts of a scene with their paths."""
    if isinstance(tree, Mapping):
        for key, value in tree.items():
            yield from _leaves(value, (*path, key))
    elif isinstance(tree, list):
        for i, value in enumerate(tree):
            yield from _leaves(value, (*path, i))
    else:
        yield path, tree


def _slopes(base: Tree, others: list[tuple[float, Any]], size: float) -> dict[Path, float] | None:
    """Slopes of the numbers that change with one parameter; None if the drawing does not follow it linearly."""
    at = [(step, other) for step, other in others if other is not None]
    if len(at) < 2 or any(other.keys() != base.keys() for _, other in at):
        return None
    (step, last), result = at[-1], {}
    for path, value in base.items():
        if not isinstance(value, float):
            if any(other[path] != value for _, other in at):
                return None
            continue
        slope = (last[path] - value) / step
        if any(
            not abs(other[path] - value - slope * h) <= ROUND * (abs(value) + abs(slope * h) + size)
            for h, other in at
        ):
            return None
        if abs(slope * step) > ROUND * size:
            result[path] = slope
    return result


def _wrong(
    base: Tree, slopes: Mapping[str, Mapping[Path, float]], values: Mapping[str, float], changed: Mapping[str, float],
    drawn: Tree | None, size: float,
) -> set[Path] | None:  # fmt: skip
    """Paths of the numbers that do not follow several parameters together; None if the drawing is another one."""
    if drawn is None or drawn.keys() != base.keys():
        return None
    result = set()
    for path, value in base.items():
        if isinstance(value, float):
            change = sum(
                found.get(path, 0.0) * (changed[name] - values[name]) for name, found in slopes.items()
            )
            if not abs(drawn[path] - value - change) <= ROUND * (abs(value) + abs(change) + size):
                result.add(path)
        elif drawn[path] != value:
            return None
    return result


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
        if abs(number - value) <= ROUND * max(abs(value), abs(number)):
            result[name] = formula
    return result
