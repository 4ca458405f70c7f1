"""A saved motion (`save`), read back.

Nothing in a file is executed: its texts are read by the parsers of model files and of JSON; the rest are numbers, whose
shapes are checked before compiled code reads them.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

from ...describe.frame import own_body
from ...describe.system import System
from ...dynamics.conditions.constraints import rows
from ...dynamics.conditions.unilateral import MotionWarning
from ...errors import FreebodyError, SimulationError, path_of
from ...formats.toml.read import case_from_text
from ...model import Model
from ..contact.course import Change, Timeline, Touching
from ..contact.history import Told
from ..ending import NOT_PHYSICAL, End
from ..kernels.kernels import Kernels, kernels_of
from ..kernels.methods import made_by
from ..kernels.sides import sided_kernels
from ..kernels.switches import switches
from ..legs.sensitivity import Derivatives
from ..legs.sided_variation import with_signs
from ..legs.variation import Variation, unknowns_of
from ..ode.dense_output import Array, Crossing, Rates
from ..ode.layout import ORDERS
from ..phase.candidates.candidates import layout_of
from ..phase.phase import Phase
from ..phase.scene import phase_of
from ..timestepping.course import InSteps
from ..timestepping.intervals import Intervals
from ..timestepping.pair_motion import PairLog, width_of
from ..timestepping.steps import Impulses, Stepping
from ..trajectory.course import Course
from ..trajectory.event import EventSpec, Happening
from ..trajectory.in_legs import InLegs
from ..trajectory.phases import Phases, Segment
from ..trajectory.trajectory import Trajectory
from .reader import Reader, damaged, parts_of
from .save import COUNTS, FORM, PATHS

if TYPE_CHECKING:
    import os


def load(path: str | os.PathLike[str], machine: System | None = None) -> Trajectory:
    """Return the motion in a file; see :meth:`Trajectory.load`."""
    source = path_of(path, "a trajectory", SimulationError)
    if not source.is_file():
        raise SimulationError(f"There is no file '{source}' to read a trajectory from.")
    if machine is not None:
        kernels_of(machine)  # refuses an object that is no machine
    parts = parts_of(source)
    try:
        about = json.loads(bytes(parts.pop("about")))
        text = bytes(parts.pop("machine")).decode()
        if about["form"] != FORM:
            raise SimulationError(
                f"Expected a motion of form {FORM} in '{source}', which another version of freebody saved in form "
                f"{about['form']}. Run it again here, load it with that version, or read the table alone, "
                "xarray.load_dataset(path)."
            )
        if machine is None and not text:
            raise SimulationError(
                f"'{source}' holds a motion, but not its machine: {about['missing']}. Pass the machine, "
                "Trajectory.load(path, s); or read the table alone, xarray.load_dataset(path)."
            )
        system = case_from_text(text, f"the machine in {source.name}").system if machine is None else machine
        kernels = kernels_of(system)
        if about["kind"] != "steps":
            kernels = kernels.by_events()
        names = kernels.model.state_names
        if machine is not None and (
            names != tuple(about["names"])
            or {p.name for p in kernels.model.parameters} != set(about["values"])
        ):
            raise SimulationError(
                f"Expected the machine of the motion in '{source}', with {', '.join(about['names'])}; got "
                f"'{system.name}', with {', '.join(names)}, or with other parameters."
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
        raise damaged(source, error) from None


def _motion(whole: Kernels, about: Mapping[str, Any], parts: Mapping[str, Any]) -> Trajectory:
    """Return the motion of a machine that texts and arrays describe; raise `ValueError` if they do not fit it."""
    model, kind = whole.model, about["kind"]
    kernels = whole.holding(_active(model, about["active"])) if about["active"] else whole
    values = {str(name): float(x) for name, x in about["values"].items()}
    told = {str(x): x for x in switches(model)}
    specs = [
        EventSpec(told.get(text, text), name, int(sign), bool(last))
        for name, sign, last, text in about["specs"]
    ]
    width = model.n_q + model.n_u
    variation = None
    if kind == "sensitivities":
        variation = Variation(kernels, unknowns_of(model, about["unknowns"], {}, "sensitivities"))
        widths = {variation.size}
    else:
        widths = {"contacts": {width + 2}, "steps": {width}}.get(kind, {width, width + 1})
    read = Reader(parts)
    t = read.reals("output_times", (None,))
    outputs = read.reals("output_states", (len(t), None))
    if outputs.shape[1] not in widths:
        raise ValueError(f"its states have {outputs.shape[1]} components")
    segments = _segments(kernels, variation or kernels, about, read, outputs.shape[1], values)
    path: Any = segments[0].path
    if kind in ("phases", "contacts") or len(segments) > 1:
        path = Phases(tuple(segments), _end(about["status"]))
    times = read.reals("asked", (None,)) if "asked" in parts else None
    samples = None if about["samples"] is None else int(about["samples"])
    arguments = kernels, values, path, specs, read.reals("tolerances", (None,)), times, samples
    course = _course(kind, (kernels, values, path), about, read, variation)
    motion = Trajectory(*arguments, course=course)
    motion.__dict__.update(t=t, states=outputs)
    return motion


def _course(
    kind: str, of: tuple[Any, Any, Any], about: Mapping[str, Any], read: Reader, variation: Any
) -> Course:
    """Return the course of a kind of motion, of kernels, values of parameters and a path."""
    kernels, values, path = of
    model = kernels.model
    happenings = tuple(_happening(*entry) for entry in about.get("happenings", ()))
    if kind == "contacts":
        timeline = Timeline(Change(*change) for change in about["changes"])
        return Touching(
            Told(
                happenings,
                timeline,
                tuple(map(str, about["unknown"])),
                float(about.get("residual", np.nan)),
            )
        )
    if kind == "sensitivities":
        shifts = np.array(about.get("shifts", np.zeros((2, len(variation.unknowns)))), dtype=float)
        if shifts.shape != (2, len(variation.unknowns)):
            raise ValueError("its derivatives of times do not fit its unknowns")
        return InLegs(derivatives=Derivatives(variation, shifts))
    if kind == "steps":
        first, tangents, m = layout_of(model)
        steps, E = path.steps, len(first)
        modes = read.integers("modes", (steps, E), 5)
        impulses = Impulses(
            read.reals("contacts", (steps, m)), read.reals("constraints", (steps, len(rows(model)))),
            read.reals("works", (steps, 2)), _corrections(model, read, steps), modes,
            _blows(model, about["blows"]), _pairs(model, read, steps),
        )  # fmt: skip
        stepping = Stepping(*(float(about[x.name]) for x in fields(Stepping) if x.name in about))
        intervals = _intervals(kernels, values, read, steps)
        return InSteps(kernels, values, path, impulses, stepping, (first, tangents), intervals)
    if kind not in ("smooth", "phases"):
        raise ValueError(f"its kind is {kind!r}")
    return InLegs(happenings)


def _intervals(kernels: Kernels, values: Mapping[str, float], read: Reader, steps: int) -> Intervals:
    """Return the values of the parameters in every step."""
    if "interval_first" not in read.parts:
        return Intervals(np.zeros(1, dtype=np.int64), kernels.parameters(values)[None], np.zeros(1))
    first = read.integers("interval_first", (None,), max(steps, 1))
    if first[0] != 0 or (np.diff(first) <= 0).any():
        raise ValueError("its intervals are not in order")
    parameters = read.reals("interval_parameters", (len(first), len(kernels.model.parameters)))
    return Intervals(first, parameters, read.reals("interval_jumps", (len(first),)))


def _corrections(model: Model, read: Reader, steps: int) -> Array:
    """Return the corrections of the state; in files of earlier versions speeds had none."""
    width = model.n_q + model.n_u
    if np.shape(read.parts["corrections"]) != (steps, model.n_q):
        return read.reals("corrections", (steps, width))
    return np.pad(read.reals("corrections", (steps, model.n_q)), ((0, 0), (0, model.n_u)))


def _happening(
    time: Any, name: Any, sign: Any, before: Any, text: Any, after: Any, passed: Sequence[Any] = ()
) -> Happening:
    """Return a blow, an impact or a change, with its warnings, which files of earlier versions lack."""
    warnings = tuple(
        MotionWarning(
            str(who), str(event), float(t), str(what), float(value),
            tuple((float(low), float(high)) for low, high in spans), *map(str, words),
        )
        for who, event, t, what, value, spans, *words in passed
    )  # fmt: skip
    return Happening(float(time), str(name), int(sign), dict(before), str(text), dict(after), warnings)


def _pairs(model: Model, read: Reader, steps: int) -> PairLog:
    """Return the entries of pairs of families in every step."""
    if not model.families:
        return PairLog(np.empty((0, 0)), np.zeros(steps + 1, dtype=np.int64))
    entries = read.reals("pairs", (None, width_of(model)))
    counts = read.integers("pair_counts", (steps,), len(entries) + 1)
    members = sum(len(family.members) for family in model.families)
    if counts.sum() != len(entries) or not (
        np.isin(entries[:, 3], range(5)).all() and np.isin(entries[:, 10:12], range(members)).all()
    ):
        raise ValueError("its pairs of families are not those of its steps")
    return PairLog(entries, np.append(0, np.cumsum(counts)))


def _blows(model: Model, entries: Sequence[Any]) -> dict[int, list[Any]]:
    """Return the blows of each time step."""
    system, _ = model.described
    result: dict[int, list[Any]] = {}
    for step, name, acting in entries:
        points = [
            (
                own_body(system, body, f"blow '{name}'").point(*texts),
                tuple(map(float, P)),
                tuple(map(float, n)),
            )
            for body, texts, P, n in acting
        ]
        result.setdefault(int(step), []).append((name, points))
    return result


def _active(model: Model, numbers: Any) -> tuple[int, ...]:
    """Return the numbers of the active conditions, checked."""
    active = tuple(map(int, numbers))
    if len(set(active)) != len(active) or not all(0 <= i < len(rows(model)) for i in active):
        raise ValueError("it names conditions that the machine does not have")
    return active


def _end(text: Any) -> End:
    """Return how a run ended. Files of earlier versions add to it whether the motion is physical."""
    return End.of_text(str(text).removesuffix(f", {NOT_PHYSICAL}"))


def _segments(
    kernels: Kernels,
    rates_of: Any,
    about: Mapping[str, Any],
    read: Reader,
    width: int,
    values: Mapping[str, float],
) -> list[Segment]:
    """Return the segments of a run, whose steps stand in the arrays one after another."""
    entries = about["segments"]
    steps = [int(entry["steps"]) for entry in entries]
    if min(steps) < 0:
        raise ValueError("a segment has a negative number of steps")
    total = sum(steps)
    times = read.reals("times", (total + len(entries),))
    lengths, states = read.reals("lengths", (total,)), read.reals("states", (total + len(entries), width))
    count = sum(len(entry["crossings"]) for entry in entries)
    moments = read.reals("crossing_times", (count,))
    crossing_states = read.reals("crossing_states", (count, width))
    n = len(kernels.model.parameters)
    switched = read.reals("parameters", (len(entries), n)) if "parameters" in read.parts else None
    common = kernels.parameters(values)
    result: list[Segment] = []
    first = low = crossed = 0
    for k, entry in enumerate(entries):
        last = first + steps[k] + 1
        own_times, status = times[first:last], entry["status"]
        if not (
            np.isfinite(own_times).all()
            and np.isfinite(states[first:last]).all()
            and np.isfinite(lengths).all()
        ):
            raise ValueError("its steps are not finite")
        if (np.diff(own_times) * np.sign(own_times[-1] - own_times[0]) < 0).any():
            raise ValueError("its times are not in order")
        events = range(crossed, crossed + len(entry["crossings"]))
        crossings = tuple(
            Crossing(float(moments[i]), int(number), int(sign), crossing_states[i])
            for i, (number, sign) in zip(events, entry["crossings"], strict=True)
        )
        if any(not 0 <= c.number < len(about["specs"]) for c in crossings):
            raise ValueError("it has crossings of events that it does not name")
        own_kernels = _kernels(kernels, entry)
        parameters = switched[k] if switched is not None and entry["switched"] else None
        of_path, numbers = with_signs(
            rates_of if own_kernels is kernels else own_kernels,
            common if parameters is None else parameters,
            entry.get("signs", ()),
        )
        path = object.__new__(PATHS[entry["way"]])
        recipe = _recipe(of_path, numbers, entry, width)
        accuracy = (None if x is None else np.broadcast_to(x, width).astype(float)
                    for x in about["accuracies"][entry["accuracy"]])  # fmt: skip
        path.__dict__.update(
            times=own_times, lengths=lengths[low : low + steps[k]], states=states[first:last], crossings=crossings,
            status=_end(status), method=entry["method"], **dict(zip(("relative", "absolute"), accuracy, strict=True)),
            **{name: int(entry[name]) for name in COUNTS}, _recipe=recipe,
        )  # fmt: skip
        loose = None if entry["loose"] is None else np.array(entry["loose"], dtype=bool)
        if about["kind"] == "contacts":
            places, _, m = layout_of(kernels.model)
            if (
                entry["modes"] is None
                or len(entry["shown"]) != len(places)
                or loose is None
                or loose.shape != (m,)
            ):
                raise ValueError("a segment says nothing of its contacts")
        result.append(
            Segment(path, own_kernels, float(entry["impulses"]), tuple(entry["shown"]), loose, parameters)
        )
        first, low, crossed = last, low + steps[k], events.stop
    return result


def _kernels(kernels: Kernels, entry: Mapping[str, Any]) -> Kernels | Phase:
    """Return the programs of a segment."""
    if entry["modes"] is not None:
        modes = tuple(map(str, entry["modes"]))
        if len(modes) != len(kernels.model.contacts):
            raise ValueError("its modes are not those of the machine's contacts")
        sides = tuple(map(float, entry.get("signs", ())))
        of_phase = sided_kernels(kernels) if sides else kernels
        return phase_of(of_phase, modes, tuple(map(int, entry["active"])), sides)
    if entry["active"] is None or tuple(entry["active"]) == kernels.active:
        return kernels
    return kernels.holding(_active(kernels.model, entry["active"]))


def _recipe(source: Any, parameters: Array, entry: Mapping[str, Any], width: int) -> tuple[Any, ...]:
    """Return a function and arguments that make the rates of a path when they are needed."""
    if entry["way"] == "steps":
        return Rates, 0, width, np.zeros(0), source.model.quaternions
    method = entry["method"]
    if method not in ORDERS:
        raise ValueError(f"it was made by {method!r}, which is no method")
    if isinstance(source, Variation):
        return _fitting, width, source.rates, parameters, method
    return _fitting, width, made_by, source, parameters, method


def _fitting(width: int, make: Callable[..., Rates], *arguments: Any) -> Rates:
    """Return rates with as many components as the states have: compiled code writes that many."""
    rates = make(*arguments)
    if rates.size != width:
        raise SimulationError(
            f"Expected states of {rates.size} components of the machine of a saved motion, got {width}: the file is "
            "not of this machine."
        )
    return rates
