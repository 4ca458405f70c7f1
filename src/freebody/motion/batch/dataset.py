"""Results of a batch as a dataset: its variables, their coordinates and attributes, and statuses in words."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import SimulationError
from ...model import Model
from ...version import VERSION
from ..ending import BLAMED, STATUS, End
from ..trajectory.outputs import AXES, CONTACT_MODES, TIMELINE, OfContact, OfReaction
from ..trajectory.units import unit_of_name
from .job import Job
from .results import REASON, Results

if TYPE_CHECKING:
    import xarray

TEXTS = {
    TIMELINE: "modes of contacts: [contact, mode, start, end, why], ...; read by freebody.timeline",
    REASON: "why the run failed, or is not physical",
}


def variables_of(job: Job) -> dict[str, tuple[tuple[str, ...], Any, dict[str, str]]]:
    """Return name -> dimensions, type, attributes of all variables that depend on the lane."""
    model, outputs = job.kernels.model, job.outputs
    result: dict[str, Any] = {}
    for name, value in zip(outputs.timed, outputs.timed_values, strict=True):
        result[name] = (("lane", "time"), "f8", _about(model, name, value))
    for name, (how, place) in outputs.numbers.items():
        about = _about(model, outputs.reduced[place], outputs.reduced_values[place])
        result[name] = (("lane",), "f8", {**about, "long_name": f"{how} of {outputs.reduced[place]}"})
    if job.specs:
        first = "first time of each event; nan where it did not happen"
        result["event_time"] = (("lane", "event"), "f8", {"units": "s", "long_name": first})
        result["event_last"] = (
            ("lane", "event"),
            "f8",
            {"units": "s", "long_name": "last time of each event"},
        )
        result["event_count"] = (("lane", "event"), "i4", {"long_name": "how often each event happened"})
    for name, dims in job.slopes.items():
        result[name] = (
            ("lane", *dims),
            "f8",
            {"long_name": f"derivative of {name[2:-1]} by each of the names of by"},
        )
    result["end"] = (("lane",), "f8", {"units": "s", "long_name": "time at which the run ended"})
    result["steps"] = (("lane",), "i4", {"long_name": "accepted steps"})
    for name in job.texts:
        result[name] = (("lane",), "text", {"long_name": TEXTS[name]})
    result["blame"] = (("lane",), "i4", {"long_name": "component, or event, that stopped a failed lane"})
    result["status"] = (("lane",), "i1", {"long_name": "how the run ended"})
    return result


def _about(model: Model, name: str, value: Any) -> dict[str, Any]:
    """Return the attributes of an output."""
    if isinstance(value, OfContact):
        about = {"long_name": f"{value.what} of contact {value.contact}"}
        if value.what == "mode":
            return {
                **about,
                "flag_values": np.arange(len(CONTACT_MODES)),
                "flag_meanings": " ".join(CONTACT_MODES),
            }
        return {"units": value.unit(model), **about}
    if isinstance(value, OfReaction):
        what = "magnitude" if value.component is None else f"{AXES[value.component]} component"
        return {
            "units": value.unit,
            "long_name": f"{what} of the reaction {value.what} of joint {value.joint}",
        }
    if name in model.coordinate_names or name in model.speed_names:
        return {"units": unit_of_name(model, name), "long_name": name}
    if name in ("kinetic_energy", "potential_energy", "energy", "work"):
        return {"units": "J", "long_name": name.replace("_", " ")}
    return {"long_name": name}


def coordinates_of(job: Job) -> dict[str, Any]:
    """Return the coordinates of the dataset: lane, time, events, and varied parameters and initial values."""
    lanes = job.lanes
    result: dict[str, Any] = {"lane": ("lane", np.arange(lanes.count))}
    if job.outputs.timed:
        result["time"] = ("time", job.times, {"units": "s", "long_name": "time"})
    if job.specs:
        result["event"] = ("event", np.array([spec.name for spec in job.specs], dtype=object))
    if job.unknowns:
        result["by"] = ("by", np.array(job.unknowns, dtype=object))
    for name in lanes.varied[0]:
        result[name] = ("lane", np.asarray(lanes.columns[name]), {"long_name": f"parameter {name}"})
    model = job.kernels.model
    names = model.state_names
    for name in lanes.varied[1]:
        if name in names:
            about = {"units": unit_of_name(model, name), "long_name": f"{name} at the start"}
            result[f"{name}_start"] = ("lane", np.asarray(lanes.initial[name], dtype=float), about)
    return result


def check_names(job: Job) -> None:
    """Refuse outputs and events whose name another variable of the dataset has.

    Raises
    ------
    SimulationError
        Names the output or event, and the variable.
    """
    fixed = [
        name
        for name in variables_of(job)
        if name not in job.outputs.timed and name not in job.outputs.numbers
    ]
    taken = dict.fromkeys(
        [*fixed, "event_time", "event_last", "event_count", "event", "status", REASON],
        "tells how lanes ended",
    )
    if job.unknowns:
        taken["by"] = "names what is differentiated by"
    taken |= dict.fromkeys(("lane", "time"), "counts the lanes and the times")
    for name in job.lanes.varied[0]:
        if name in taken:
            raise SimulationError(
                f"Expected another name for the varied parameter '{name}', which in the results {taken[name]}. "
                "Rename it."
            )
        taken[name] = "holds the varied parameter"
    taken |= {f"{name}_start": "holds the varied start" for name in job.lanes.varied[1]}
    for name in (*job.outputs.timed, *job.outputs.numbers):
        if name in taken:
            raise SimulationError(
                f"Expected another name for the output '{name}', which in the results {taken[name]}. Name it: "
                f"outputs={{'my_{name}': ...}}."
            )
    events = [spec.name for spec in job.specs]
    for name in events:
        if events.count(name) > 1:
            raise SimulationError(
                f"Expected events of different names in a batch, got '{name}' twice. Name them: "
                "fb.event(..., name=...)."
            )


def attributes_of(job: Job) -> dict[str, Any]:
    """Return the attributes of the dataset."""
    model, lanes = job.kernels.model, job.lanes
    fixed = {name: x for name, x in lanes.given_to(0).items() if name not in lanes.varied[0]}
    return {
        "title": f"Motions of {model.name}",
        "method": job.request.method,
        "tolerance": float(np.min(job.tolerances)) if len(job.tolerances) else 0.0,
        "start": job.begin,
        "until": job.end,
        "parameters": json.dumps(fixed),
        "source": f"freebody {VERSION}",
    }


def arrays_of(job: Job, part: Results) -> dict[str, Any]:
    """Return the arrays of results by the names of the variables; the status comes last."""
    result: dict[str, Any] = {name: part.values[:, :, i] for i, name in enumerate(job.outputs.timed)}
    for name in job.outputs.numbers:
        result[name] = job.outputs.number(name, part.reduced)
    if job.specs:
        m = len(job.specs)
        result["event_time"], result["event_last"] = part.event_times[:, :m, 0], part.event_times[:, :m, 1]
        result["event_count"] = part.counts[:, :m]
    result |= part.slopes
    for i, name in enumerate(job.texts):
        result[name] = part.texts[:, i]
    result["end"], result["steps"], result["blame"] = part.end_times, part.steps, part.blame
    result["status"] = part.status
    return result


def dataset_of(job: Job, part: Results) -> xarray.Dataset:
    """Return the dataset of results in memory."""
    import xarray

    arrays = arrays_of(job, part)
    variables = {
        name: (dims, arrays[name] if kind == "text" else arrays[name].astype(kind, copy=False), about)
        for name, (dims, kind, about) in variables_of(job).items()
        if name != "status"
    }
    data = xarray.Dataset(variables, coords=coordinates_of(job), attrs=attributes_of(job))
    return labelled(data, arrays["status"], arrays["blame"], job)


def labelled(data: xarray.Dataset, codes: Any, blame: Any, job: Job) -> xarray.Dataset:
    """Return the dataset with statuses and names in place of numbers."""
    widest = max(map(len, STATUS.values()))
    words = np.full(len(codes), "", dtype=f"<U{widest}")
    for code in np.unique(codes):
        words[codes == code] = STATUS[int(code)]
    for name in (*job.outputs.timed, *job.outputs.numbers):
        if job.outputs.is_mode(name):
            numbers = data[name].values
            place = np.where(np.isfinite(numbers), numbers, len(CONTACT_MODES)).astype(int)
            about = {"long_name": data[name].attrs["long_name"]}
            data[name] = (data[name].dims, np.array([*CONTACT_MODES, ""], dtype=object)[place], about)
    for name in job.texts:
        data[name] = data[name].astype(object)
    data["status"] = ("lane", words, {"long_name": "how the run ended"})
    data["blame"] = (
        "lane", np.array([*blamable(job), ""], dtype=str)[blamed(codes, blame, job)],
        {"long_name": "coordinate, speed or event that stopped a failed lane, or from which on it is not physical"},
    )  # fmt: skip
    tell_waiting(data, codes)
    if job.no_start:
        data.attrs["no_start"] = json.dumps({str(k): v for k, v in list(job.no_start.items())[:20]})
    return data


def tell_waiting(data: xarray.Dataset, codes: Any) -> None:
    """Note in the attributes of a dataset how many lanes were not run, if any."""
    waiting = int((codes == End.WAITING).sum())
    if waiting:
        data.attrs["interrupted"] = f"{waiting} of {len(codes)} lanes were not run"


def blamable(job: Job) -> list[str]:
    """Return the names of what may be to blame for a lane that failed: coordinates, speeds, events, quantities."""
    return [*job.kernels.names, *(spec.name for spec in job.specs), *job.outputs.reduced]


def blamed(codes: Any, blame: Any, job: Job) -> Any:
    """Return, for each lane, the place of what is to blame among the `blamable`; -1 if nothing is."""
    of_events = (End.UNDEFINED, End.UNRESOLVED, End.UNPHYSICAL, End.STOPPED_UNPHYSICAL)
    failed = np.isin(codes, (*BLAMED, *of_events))
    places = np.where(np.isin(codes, of_events), len(job.kernels.names) + blame, blame)
    return np.where(failed & (places < len(blamable(job))), places, -1)


def flags(texts: Iterable[str], values: Iterable[int]) -> dict[str, Any]:
    """Return the attributes by which CF tells the meanings of the numbers of a variable."""
    words = [text.replace(",", "").replace(" ", "_") or "_" for text in texts]
    return {"flag_values": list(values), "flag_meanings": " ".join(words)}
