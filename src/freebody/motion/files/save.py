"""A motion as a file: the description of its machine and the computed path, from which all quantities follow.

A netCDF file (HDF5) holds the table that `dataset` makes, for all programs that read such files, and a group besides:

    machine    text of a model file (TOML), needed for quantities that follow from the motion
    about      text (JSON): the arguments of the run, and how it went, in segments
    ...        arrays: the steps of all segments, one after another; impulses of each time step

Signals and inputs of controllers are parameters with other values in each segment: the machine in the file has these
parameters in place of the signals and of Python functions. `load` reads the file back.
"""

from __future__ import annotations

import json
import os
import warnings
from dataclasses import asdict, astuple
from typing import Any

import numpy as np

from ...describe.description import changes_of, names_of, without_signals
from ...errors import FreebodyError, SimulationError, path_of
from ...formats.text import expression_text
from ...formats.toml.write import toml_text
from ..contact.course import Leap, Touching
from ..kernels.methods import made_by
from ..kernels.sides import SidedKernels
from ..legs.sided_variation import SidedVariation
from ..ode.dense_output import Path
from ..phase.phase import Phase
from ..timestepping.course import InSteps
from ..timestepping.steps import Steps
from ..trajectory.phases import Phases, Segment, segments_of
from ..trajectory.trajectory import Trajectory
from .replacing import replacing

GROUP = "freebody"
FORM = 2
"""Version of the contents of the group."""

PATHS: dict[str, type[Path]] = {"smooth": Path, "leap": Leap, "steps": Steps}
COUNTS = ("blame", "rejected", "evaluations", "stiff")


def save(trajectory: Trajectory, path: str | os.PathLike[str]) -> None:
    """Write a motion to a netCDF-4 file, first under another name, so that no half-written file remains."""
    import h5py

    data = trajectory.data
    target = path_of(path, "a trajectory", SimulationError)
    if target.suffix.lower() not in (".nc", ".nc4", ".h5"):
        raise SimulationError(
            f"Expected a file name that ends in .nc for a trajectory (netCDF), got '{target.name}'. A table "
            f"is written by trajectory.data[['{next(iter(data.data_vars))}']].to_dataframe().to_csv('table.csv')."
        )
    if not target.parent.is_dir():
        raise SimulationError(
            f"Cannot write '{target}': there is no folder '{target.parent}'. Make it, or choose another path."
        )
    texts = sum(
        sum(len(str(x).encode()) + 64 for x in variable.values.flat)
        for variable in data.variables.values()
        if variable.dtype.kind in "OU"
    )
    contents = group_contents(trajectory)
    # the last terms are for HDF5: for each variable, and for the file
    room = data.nbytes + 2 * texts + (len(data.variables) << 13) + (1 << 17)
    room += sum(np.asarray(array).nbytes + (1 << 13) for array in contents.values())
    with replacing(target, room) as new:
        data.to_netcdf(new, engine="h5netcdf")
        with h5py.File(new, "r+") as file:
            group = file.create_group(GROUP)
            for name, array in contents.items():
                group[name] = array


def machine_text(motion: Trajectory) -> tuple[str, str]:
    """Return the model file of the machine of a motion; or an empty text, and the reason."""
    system, count = motion.kernels.model.described
    if changes_of(system).count != count:
        return "", f"system '{system.name}' was changed after the run"
    if system.controllers or names_of(system).signals:
        system = without_signals(system)
        system.controllers.clear()
    try:
        return toml_text(system), ""
    except FreebodyError as error:
        return "", str(error).rstrip(".")


def group_contents(motion: Trajectory) -> dict[str, Any]:
    """Return the texts and arrays of the group."""
    machine, missing = machine_text(motion)
    if missing:
        warnings.warn(
            f"The file of the motion of '{motion.name}' holds its numbers, but not its machine: {missing}. "
            "Trajectory.load(path, s) will ask for the machine.",
            RuntimeWarning,
            stacklevel=4,
        )
    kind, course = kind_of(motion), motion.course
    segments = segments_of(motion.path, motion.kernels)
    times, samples = motion._times_and_samples
    accuracies: list[Any] = []
    arrays: dict[str, Any] = {
        "tolerances": motion.tolerances,
        "times": np.concatenate([s.path.times for s in segments]),
        "lengths": np.concatenate([s.path.lengths for s in segments]),
        "states": np.concatenate([s.path.states for s in segments]),
        "output_times": motion.t,
        "output_states": motion.states,
    }
    crossings = [c for s in segments for c in s.path.crossings]
    arrays["crossing_times"] = np.array([c.time for c in crossings])
    arrays["crossing_states"] = np.array([c.state for c in crossings]).reshape(
        len(crossings), motion.states.shape[1]
    )
    if times is not None:
        arrays["asked"] = times
    if any(s.parameters is not None for s in segments):
        arrays["parameters"] = np.array(
            [motion._parameters if s.parameters is None else s.parameters for s in segments]
        )
    about: dict[str, Any] = {
        "form": FORM,
        "kind": kind,
        "missing": missing,
        "names": motion.names,
        "values": motion.numbers,
        "active": motion.kernels.active,
        "specs": [(spec.name, spec.direction, spec.terminal, str(spec.expression)) for spec in motion.specs],
        "samples": samples,
        "status": str(motion.path.status),
        "segments": [_segment(s, accuracies) for s in segments],
        "accuracies": accuracies,
    }
    if kind in ("phases", "contacts"):
        about["happenings"] = [
            (x.time, x.name, x.direction, x.state, x.text, x.after, [*map(astuple, x.warnings)])
            for x in motion.happenings
        ]
    if isinstance(course, Touching):
        about["changes"] = [(x.contact, x.mode, x.start, x.end, x.why) for x in motion.modes]
        about["unknown"] = course.indeterminate
        about["residual"] = course.residual
    if kind == "sensitivities":
        about["unknowns"] = [unknown.name for unknown in course.derivatives.variation.unknowns]
        about["shifts"] = course.derivatives.shifts
    if isinstance(course, InSteps):
        impulses, texts = course.impulses, motion.kernels.model.names.texts
        arrays |= {
            "contacts": impulses.contacts,
            "constraints": impulses.constraints,
            "works": impulses.works,
            "corrections": impulses.corrections,
            "modes": impulses.modes,
        }
        if motion.kernels.model.families:
            arrays["pairs"] = impulses.pairs.entries
            arrays["pair_counts"] = np.diff(impulses.pairs.ends)
        for name in ("first", "parameters", "jumps") if len(course.intervals.first) > 1 else ():
            arrays[f"interval_{name}"] = getattr(course.intervals, name)
        about |= asdict(course.stepping)
        about["blows"] = [
            (step, name, [
                (point.body.name, [expression_text(x, texts) for x in point.components], P, n) for point, P, n in acting
            ])
            for step, blows in impulses.blows.items() for name, acting in blows
        ]  # fmt: skip
    text = json.dumps(about, default=lambda x: x.tolist() if hasattr(x, "tolist") else float(x))
    return {**arrays, "machine": _bytes(machine), "about": _bytes(text)}


def kind_of(motion: Trajectory) -> str:
    """Return the kind of a motion in a file: smooth, phases, contacts, steps or sensitivities."""
    if isinstance(motion.course, Touching):
        if motion.course.derivatives is not None:
            raise SimulationError(
                "Expected a motion with contacts and without sensitivities= for a file, got one with derivatives. Save "
                "the motion of a run without them; trajectory.sensitivity gives arrays, which numpy.savez keeps."
            )
        return "contacts"
    if isinstance(motion.course, InSteps):
        return "steps"
    if motion.course.derivatives is not None:
        return "sensitivities"
    return "phases" if isinstance(motion.path, Phases) else "smooth"


def _segment(segment: Segment, accuracies: list[Any]) -> dict[str, Any]:
    path, kernels = segment.path, segment.kernels
    accuracy = [None if x is None else np.asarray(x).tolist() for x in (path.relative, path.absolute)]
    if accuracy not in accuracies:
        accuracies.append(accuracy)
    return {
        "way": next(name for name, cls in PATHS.items() if type(path) is cls),
        "method": path.method,
        "status": str(path.status),
        "steps": path.steps,
        "accuracy": accuracies.index(accuracy),
        "crossings": [(c.number, c.sign) for c in path.crossings],
        "active": None if kernels is None else kernels.active,
        "modes": kernels.modes if isinstance(kernels, Phase) else None,
        "shown": segment.modes,
        "loose": segment.loose,
        "impulses": segment.impulses,
        "switched": segment.parameters is not None,
        "signs": kernels.sides if isinstance(kernels, Phase) else _signs(path),
        **{name: getattr(path, name) for name in COUNTS},
    }


def _signs(path: Any) -> list[float]:
    """Return the signs of laws that switch in a segment, which follow its parameters; 0 of a law left as it is."""
    make, *arguments = path.rates.recipe or (None,)
    source = arguments[0] if make is made_by else getattr(make, "__self__", None)
    numbers = arguments[1] if make is made_by else arguments[0] if arguments else ()
    if isinstance(source, SidedVariation):
        return list(map(float, numbers[len(source.kernels.model.parameters) :]))
    if not isinstance(source, SidedKernels):
        return []
    return list(map(float, numbers[len(source.model.parameters) :]))


def _bytes(text: str) -> Any:
    return np.frombuffer(text.encode(), dtype=np.uint8)
