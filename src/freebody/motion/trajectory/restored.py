"""A motion that was saved (`saved`), read back.

Nothing of a file is executed: its texts are read by the parsers of model files and of JSON, and all else is numbers,
whose shapes are checked before compiled code sees them.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...describe.frame import own_body
from ...describe.system import System
from ...dynamics.constraints import rows
from ...errors import FreebodyError, SimulationError, path_of
from ...formats.toml.read import case_from_text
from ..contact.scene import phase_of, scene_of_layout
from ..kernels.kernels import Kernels, kernels_of
from ..kernels.methods import made_by
from ..legs.sensitivity import Variation, unknowns_of
from ..ode.dense_output import Array, Crossing, Rates
from ..ode.layout import ORDERS
from ..timestepping.stepped_trajectory import Impulses
from .event import EventSpec
from .phases import Happening, Phases, Segment
from .saved import COUNTS, FORM, GROUP, KINDS, WAYS
from .trajectory import Trajectory

if TYPE_CHECKING:
    import os


def load(path: str | os.PathLike[str], machine: System | None = None) -> Trajectory:
    """The motion of a file; see :meth:`Trajectory.load`."""
    source = path_of(path, "a trajectory", SimulationError)
    if not source.is_file():
        raise SimulationError(f"There is no file '{source}' to read a trajectory from.")
    if machine is not None:
        kernels_of(machine)  # or what is no machine is refused as such
    parts = _parts(source)
    try:
        about = json.loads(bytes(parts.pop("about")))
        text = bytes(parts.pop("machine")).decode()
        if about["form"] != FORM:
            raise ValueError(f"its form is {about['form']}, not {FORM}")
        if machine is None and not text:
            raise SimulationError(
                f"'{source}' holds a motion, but not its machine: {about['missing']}. Pass the machine, "
                "Trajectory.load(path, s); or read the table alone, xarray.load_dataset(path)."
            )
        system = case_from_text(text, f"the machine in {source.name}").system if machine is None else machine
        kernels = kernels_of(system)
        named = (*kernels.model.coordinate_names, *kernels.model.speed_names)
        if machine is not None and (
            named != tuple(about["names"])
            or {p.name for p in kernels.model.parameters} != set(about["values"])
        ):
            raise SimulationError(
                f"Expected the machine of the motion in '{source}', with {', '.join(about['names'])}; got "
                f"'{system.name}', with {', '.join(named)}, or with other parameters."
            )
        return _motion(kernels, about, parts)
    except SimulationError:
        raise
    except (
        FreebodyError,
        KeyError,
        ValueError,
        TypeError,
        IndexError,
        AttributeError,
        RecursionError,
    ) as error:
        raise _damaged(source, error) from None


def _damaged(source: Any, why: Any) -> SimulationError:
    return SimulationError(f"Expected a motion that was saved whole in '{source}', but it is damaged: {why}.")


def _parts(source: Any) -> dict[str, Any]:
    """The arrays of the group."""
    import h5py

    try:
        with h5py.File(source, "r") as file:
            if GROUP not in file or not isinstance(file.get(GROUP, getlink=True), h5py.HardLink):
                raise SimulationError(
                    f"Expected a motion that was saved by freebody in '{source}', found a table alone. "
                    "xarray.load_dataset(path) reads that."
                )
            group = file[GROUP]
            own = {name for name in group if isinstance(group.get(name, getlink=True), h5py.HardLink)}
            found = {
                name: x
                for name in own
                if isinstance(x := group[name], h5py.Dataset) and x.dtype.kind in "fiu"
            }
            if sum(x.nbytes for x in found.values()) > source.stat().st_size:  # written as they are
                raise _damaged(source, "it is shorter than what it holds")
            return {name: x[()] for name, x in found.items() if not x.external and not x.is_virtual}
    except (OSError, RuntimeError) as error:
        raise SimulationError(
            f"Expected a trajectory in netCDF format in '{source}', but it can not be read: {error}"
        ) from None


def _motion(whole: Kernels, about: Mapping[str, Any], parts: Mapping[str, Any]) -> Trajectory:
    """The motion of a machine that texts and arrays describe; `ValueError` where they do not fit it."""
    model, kind = whole.model, about["kind"]
    kernels = whole.holding(_active(model, about["active"])) if about["active"] else whole
    values = {str(name): float(x) for name, x in about["values"].items()}
    specs = [EventSpec(text, name, int(sign), bool(last)) for name, sign, last, text in about["specs"]]
    width = model.n_q + model.n_u
    variation = None
    if kind == "sensitivities":
        variation = Variation(kernels, unknowns_of(model, about["unknowns"], {}, "sensitivities"))
        widths = {variation.size}
    else:
        widths = {"contacts": {width + 2}, "steps": {width}}.get(kind, {width, width + 1})
    read = _Reader(parts)
    t = read.reals("output_times", (None,))
    outputs = read.reals("output_states", (len(t), None))
    if outputs.shape[1] not in widths:
        raise ValueError(f"its states have {outputs.shape[1]} components")
    segments = _segments(kernels, variation or kernels, about, read, outputs.shape[1], values)
    path: Any = segments[0].path
    if kind in ("phases", "contacts"):
        path = Phases(tuple(segments), str(about["status"]))
    asked = read.reals("asked", (None,)) if "asked" in parts else None
    samples = None if about["samples"] is None else int(about["samples"])
    given = kernels, values, path, specs, read.reals("tolerances", (None,)), asked, samples
    motion = _made(kind, given, about, read, variation)
    motion.__dict__.update(t=t, states=outputs)
    return motion


def _made(kind: str, given: Any, about: Mapping[str, Any], read: _Reader, variation: Any) -> Trajectory:
    kernels, path = given[0], given[2]
    model = kernels.model
    more: dict[str, Any] = {}
    if kind in ("phases", "contacts"):
        more["happenings"] = [
            Happening(float(t), str(name), int(sign), dict(before), str(text), dict(after))
            for t, name, sign, before, text, after in about["happenings"]
        ]
    if kind == "contacts":
        more |= {"changes": about["changes"], "unknown": about["unknown"]}
    if kind == "sensitivities":
        given = (variation, *given)
    if kind == "steps":
        first, tangents, m = scene_of_layout(model)
        steps, E = path.steps, len(first)
        modes = read.integers("modes", (steps, E), 5)
        did = Impulses(
            read.reals("contacts", (steps, m)), read.reals("constraints", (steps, len(rows(model)))),
            read.reals("works", (steps, 2)), modes, _blows(model, about["blows"]),
        )  # fmt: skip
        more = {name: float(about[name]) for name in ("step", "residual", "depth", "sweeps")}
        more |= {"impulses": did, "scene": (first, tangents)}
    return KINDS[kind](*given, **more)


def _blows(model: Any, told: Sequence[Any]) -> dict[int, list[Any]]:
    system, _ = model.described
    found: dict[int, list[Any]] = {}
    for step, name, acting in told:
        points = [
            (
                own_body(system, body, f"blow '{name}'").point(*texts),
                tuple(map(float, P)),
                tuple(map(float, n)),
            )
            for body, texts, P, n in acting
        ]
        found.setdefault(int(step), []).append((name, points))
    return found


def _active(model: Any, places: Any) -> tuple[int, ...]:
    found = tuple(map(int, places))
    if len(set(found)) != len(found) or not all(0 <= i < len(rows(model)) for i in found):
        raise ValueError("it names conditions that the machine does not have")
    return found


def _segments(
    kernels: Kernels,
    rates_of: Any,
    about: Mapping[str, Any],
    read: _Reader,
    width: int,
    values: Mapping[str, float],
) -> list[Segment]:
    """The segments of a run, which share the arrays."""
    told = about["segments"]
    steps = [int(one["steps"]) for one in told]
    if min(steps) < 0:
        raise ValueError("a segment has a negative number of steps")
    total = sum(steps)
    times = read.reals("times", (total + len(told),))
    lengths, states = read.reals("lengths", (total,)), read.reals("states", (total + len(told), width))
    count = sum(len(one["crossings"]) for one in told)
    moments = read.reals("crossing_times", (count,))
    there = read.reals("crossing_states", (count, width))
    n = len(kernels.model.parameters)
    switched = read.reals("parameters", (len(told), n)) if "parameters" in read.parts else None
    common = kernels.parameters(values)
    result: list[Segment] = []
    at = low = seen = 0
    for k, one in enumerate(told):
        high = at + steps[k] + 1
        here, status = times[at:high], one["status"]
        if not (
            np.isfinite(here).all() and np.isfinite(states[at:high]).all() and np.isfinite(lengths).all()
        ):
            raise ValueError("its steps are not finite")
        if (np.diff(here) * np.sign(here[-1] - here[0]) < 0).any():
            raise ValueError("its times are not in order")
        events = range(seen, seen + len(one["crossings"]))
        crossings = tuple(
            Crossing(float(moments[i]), int(number), int(sign), there[i])
            for i, (number, sign) in zip(events, one["crossings"], strict=True)
        )
        if any(not 0 <= c.number < len(about["specs"]) for c in crossings):
            raise ValueError("it has crossings of events that it does not name")
        own = _kernels(kernels, one)
        parameters = switched[k] if switched is not None and one["switched"] else None
        path = object.__new__(WAYS[one["way"]])
        recipe = _recipe(
            rates_of if own is kernels else own, common if parameters is None else parameters, one, width
        )
        accuracy = (None if x is None else np.broadcast_to(x, width).astype(float)
                    for x in about["accuracies"][one["accuracy"]])  # fmt: skip
        path.__dict__.update(
            times=here, lengths=lengths[low : low + steps[k]], states=states[at:high], crossings=crossings,
            status=str(status), method=one["method"], **dict(zip(("relative", "absolute"), accuracy, strict=True)),
            **{name: int(one[name]) for name in COUNTS}, _recipe=recipe,
        )  # fmt: skip
        loose = None if one["loose"] is None else np.array(one["loose"], dtype=bool)
        if about["kind"] == "contacts":
            first, _, m = scene_of_layout(kernels.model)
            if (
                one["modes"] is None
                or len(one["shown"]) != len(first)
                or loose is None
                or loose.shape != (m,)
            ):
                raise ValueError("a segment says nothing of its contacts")
        result.append(Segment(path, own, float(one["impulses"]), tuple(one["shown"]), loose, parameters))
        at, low, seen = high, low + steps[k], events.stop
    return result


def _kernels(kernels: Kernels, told: Mapping[str, Any]) -> Kernels:
    """The programs of a segment."""
    if told["modes"] is not None:
        modes = tuple(map(str, told["modes"]))
        if len(modes) != len(kernels.model.contacts):
            raise ValueError("its modes are not those of the machine's contacts")
        phase = phase_of(kernels, modes, tuple(map(int, told["active"])))
        _active(phase.model, phase.active)
        return phase
    if told["active"] is None or tuple(told["active"]) == kernels.active:
        return kernels
    return kernels.holding(_active(kernels.model, told["active"]))


def _recipe(of: Any, parameters: Array, told: Mapping[str, Any], width: int) -> tuple[Any, ...]:
    """What makes the rates of a path when they are asked for."""
    if told["way"] == "steps":
        return Rates, 0, width, np.zeros(0), of.model.quaternions
    method = told["method"]
    if method not in ORDERS:
        raise ValueError(f"it was made by {method!r}, which is no method")
    if isinstance(of, Variation):
        return _fitting, width, of.rates, parameters, method
    return _fitting, width, made_by, of, parameters, method


def _fitting(width: int, make: Callable[..., Rates], *arguments: Any) -> Rates:
    """Rates of as many components as the states have: compiled code writes that many."""
    rates = make(*arguments)
    if rates.size != width:
        raise SimulationError(
            f"Expected states of {rates.size} components of the machine of a saved motion, got {width}: the file is "
            "not of this machine."
        )
    return rates


class _Reader:
    """Arrays of given shapes, in memory as compiled code takes them."""

    def __init__(self, parts: Mapping[str, Any]) -> None:
        self.parts = parts

    def reals(self, name: str, shape: tuple[int | None, ...]) -> Array:
        return np.ascontiguousarray(self._checked(name, shape), dtype=float)

    def integers(self, name: str, shape: tuple[int | None, ...], below: int) -> Any:
        found = np.ascontiguousarray(self._checked(name, shape), dtype=np.int64)
        if found.size and not 0 <= found.min() <= found.max() < below:
            raise ValueError(f"'{name}' has numbers that mean nothing")
        return found

    def _checked(self, name: str, shape: tuple[int | None, ...]) -> Any:
        found = self.parts[name]
        if found.ndim != len(shape) or any(
            want not in (None, have) for want, have in zip(shape, found.shape, strict=True)
        ):
            raise ValueError(f"'{name}' has the shape {found.shape}")
        return found
