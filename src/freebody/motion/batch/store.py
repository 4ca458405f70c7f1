"""Results of a batch as a dataset, in memory or in a file that is filled lane by lane.

The whole file is laid out before the first lane runs: every variable has its place and its size, filled with nan. Later
only numbers are written into these places, first the results of a lane and then its status. A run that is stopped, even
by force, leaves a file that can be read, and the same call continues with the lanes that are still waiting.
"""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import SimulationError, path_of
from ...model import Model
from ...version import VERSION
from ..files.replacing import explained, lock, replacing, reserve
from ..lanes import lanes_layout as at
from ..ode import layout
from ..trajectory.outputs import CONTACT_MODES, TIMELINE, OfContact
from ..trajectory.trajectory import unit_of_name
from .job import Job
from .results import REASON, STATUS, WAITING, Results
from .study_identity import parts

if TYPE_CHECKING:
    import xarray


_MARK = "runs"  # attribute that holds the identity of the runs, part by part
_REST = "The lanes that were written before are whole, and the same call goes on with the others. "
_SMALL = 1 << 28  # bytes of a file that is read into memory
_HEAP = (
    1 << 16
)  # greatest number of bytes that HDF5 adds to a file for texts, and for the attributes of the file
_ADDRESS = 16  # bytes in the file for the length and the address of a text
_EACH = 1 << 12  # greatest number of bytes that describe a variable
TEXTS = {
    TIMELINE: "modes of contacts: [contact, mode, start, end, why], ...; read by freebody.timeline",
    REASON: "why the run failed, or is not physical",
}


def _variables(job: Job) -> dict[str, tuple[tuple[str, ...], Any, dict[str, str]]]:
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
        result["event_count"] = (("lane", "event"), "i8", {"long_name": "how often each event happened"})
    result["end"] = (("lane",), "f8", {"units": "s", "long_name": "time at which the run ended"})
    result["steps"] = (("lane",), "i8", {"long_name": "accepted steps"})
    for name in job.texts:
        result[name] = (("lane",), "text", {"long_name": TEXTS[name]})
    result["blame"] = (("lane",), "i8", {"long_name": "component, or event, that stopped a failed lane"})
    result["status"] = (("lane",), "i1", {"long_name": "how the run ended"})
    return result


_UNITS = {"gap": "m", "normal": "N", "tangential": "N", "slip": "m/s", "margin": "N"}


def _about(model: Model, name: str, value: Any) -> dict[str, Any]:
    """Return the attributes of an output."""
    if isinstance(value, OfContact):
        about = {"long_name": f"{value.what} of contact {model.contacts[value.contact].name}"}
        if value.what == "mode":
            return {
                **about,
                "flag_values": np.arange(len(CONTACT_MODES)),
                "flag_meanings": " ".join(CONTACT_MODES),
            }
        return {"units": _UNITS[value.what], **about}
    if name in model.coordinate_names or name in model.speed_names:
        return {"units": unit_of_name(model, name), "long_name": name}
    if name in ("kinetic_energy", "potential_energy", "energy", "work"):
        return {"units": "J", "long_name": name.replace("_", " ")}
    return {"long_name": name}


def _coordinates(job: Job) -> dict[str, Any]:
    """Return the coordinates of the dataset: lane, time, events, and varied parameters and initial values."""
    lanes = job.lanes
    result: dict[str, Any] = {"lane": ("lane", np.arange(lanes.count))}
    if job.outputs.timed:
        result["time"] = ("time", job.times, {"units": "s", "long_name": "time"})
    if job.specs:
        result["event"] = ("event", np.array([spec.name for spec in job.specs], dtype=object))
    for name in lanes.varied[0]:
        result[name] = ("lane", np.asarray(lanes.columns[name]), {"long_name": f"parameter {name}"})
    model = job.kernels.model
    names = [*model.coordinate_names, *model.speed_names]
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
        name for name in _variables(job) if name not in job.outputs.timed and name not in job.outputs.numbers
    ]
    taken = dict.fromkeys(
        [*fixed, "event_time", "event_last", "event_count", "event", "status", REASON],
        "tells how lanes ended",
    )
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


def _attributes(job: Job) -> dict[str, Any]:
    """Return the attributes of the dataset."""
    model, lanes = job.kernels.model, job.lanes
    fixed = {name: x for name, x in lanes.values_of(0).items() if name not in lanes.varied[0]}
    return {
        "title": f"Motions of {model.name}",
        "method": job.method,
        "tolerance": float(np.min(job.tolerances)) if len(job.tolerances) else 0.0,
        "start": job.begin,
        "until": job.end,
        "parameters": json.dumps(fixed),
        "source": f"freebody {VERSION}",
    }


def _parts(job: Job, part: Results) -> dict[str, Any]:
    """Return the arrays of results by the names of the variables; the status comes last."""
    result: dict[str, Any] = {name: part.values[:, :, i] for i, name in enumerate(job.outputs.timed)}
    for name in job.outputs.numbers:
        result[name] = job.outputs.number(name, part.reduced)
    if job.specs:
        m = len(job.specs)
        result["event_time"], result["event_last"] = part.event_times[:, :m, 0], part.event_times[:, :m, 1]
        result["event_count"] = part.counts[:, :m]
    for i, name in enumerate(job.texts):
        result[name] = part.texts[:, i]
    result["end"], result["steps"], result["blame"] = part.end_times, part.outcomes[:, 1], part.outcomes[:, 3]
    result["status"] = part.outcomes[:, 0]
    return result


def dataset_of(job: Job, part: Results) -> xarray.Dataset:
    """Return the dataset of results in memory."""
    import xarray

    arrays = _parts(job, part)
    variables = {
        name: (dims, arrays[name], about)
        for name, (dims, _, about) in _variables(job).items()
        if name != "status"
    }
    data = xarray.Dataset(variables, coords=_coordinates(job), attrs=_attributes(job))
    return _told(data, arrays["status"], arrays["blame"], job)


def _told(data: xarray.Dataset, codes: Any, blame: Any, job: Job) -> xarray.Dataset:
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
    components, events = list(job.kernels.names), [spec.name for spec in job.specs]
    names = np.array([*components, *events, ""], dtype=str)
    of_events = (layout.UNDEFINED, at.UNPHYSICAL, at.STOPPED_UNPHYSICAL)
    places = np.where(np.isin(codes, of_events), len(components) + blame, blame)
    blamed = (layout.NOT_FINITE, layout.COLLAPSED, layout.DIVERGED, *of_events)
    good = ~np.isin(codes, blamed)
    data["blame"] = (
        "lane", names[np.where(good, len(names) - 1, np.minimum(places, len(names) - 1))],
        {"long_name": "coordinate, speed or event that stopped a failed lane, or from which on it is not physical"},
    )  # fmt: skip
    waiting = int((codes == WAITING).sum())
    if waiting:
        data.attrs["interrupted"] = f"{waiting} of {len(codes)} lanes were not run"
    if job.no_start:
        data.attrs["no_start"] = json.dumps({str(k): v for k, v in list(job.no_start.items())[:20]})
    return data


class Store:
    """A netCDF file that is filled lane by lane.

    Raises
    ------
    SimulationError
        No such folder, a file of other runs, or no netCDF file.
    """

    def __init__(self, path: Any, job: Job) -> None:
        self.path, self.job = path_of(path, "store=", SimulationError), job
        self.parts = parts(job)
        with explained(self.path):
            if self.path.is_dir():
                raise SimulationError(
                    f"Expected the path of a file for store=, got the folder '{self.path}'. Name a file in it, such as "
                    f"'{self.path / 'lanes.nc'}'."
                )
            if not self.path.parent.is_dir():
                raise SimulationError(
                    f"Cannot write '{self.path}': there is no folder '{self.path.parent}'. Make it, or choose another "
                    "path."
                )
            exists = self.path.exists()
            if exists and not self.path.is_file():  # HDF5 would wait for a pipe
                raise SimulationError(
                    f"Expected the path of a file for store=, got '{self.path}', which is no file."
                )
        if exists:
            self._check()
        else:
            self._create()

    def _check(self) -> None:
        """Refuse a file of other runs; repair one whose last write was interrupted."""
        import h5py

        try:
            with h5py.File(self.path, "r") as file:
                mark = file.attrs.get(_MARK, "")
                waiting = "status" in file and bool((file["status"][:] == WAITING).any())
        except OSError as error:
            raise SimulationError(
                f"Expected results of a batch in '{self.path}', but it cannot be read: {error}. Choose another path."
            ) from None
        mark = mark.decode() if isinstance(mark, bytes) else str(mark)
        stored = json.loads(mark) if mark.startswith("{") else {}
        others = [name for name, digest in self.parts.items() if stored.get(name) != digest]
        if others:
            what = f"runs that differ in the {', the '.join(others)}" if stored else "something else"
            raise SimulationError(
                f"Expected '{self.path}' to hold results of the same runs, which this call continues, but it holds "
                f"those of {what}. Choose another path, or remove the file."
            )
        if waiting:
            with explained(self.path, more=_REST):
                self._mend()

    def _mend(self) -> None:
        """Empty the texts of lanes that were not run.

        A process that was killed while it wrote them left addresses of texts that it did not write, and HDF5 then
        cannot read any text.
        """
        import h5py

        with h5py.File(self.path, "r") as file:
            places = [file[_escaped(name)].id.get_offset() for name in self.job.texts]
            ended = file["status"].id.get_offset()
        with self.path.open("r+b") as raw:
            lock(raw)
            raw.seek(ended)
            statuses = np.frombuffer(raw.read(self.job.lanes.count), dtype=np.int8)
            for first, last in _runs(np.flatnonzero(statuses == WAITING)) if places else ():
                for place in places:
                    raw.seek(place + _ADDRESS * first)
                    raw.write(bytes(_ADDRESS * (last - first)))

    def _create(self) -> None:
        """Lay out the file."""
        import h5netcdf
        import h5py

        job = self.job
        with (
            replacing(self.path, self._size()) as new,
            h5netcdf.File(new, "w") as file,
        ):
            sizes = {"lane": job.lanes.count}
            if job.outputs.timed:
                sizes["time"] = job.times.size
            if job.specs:
                sizes["event"] = len(job.specs)
            file.dimensions = sizes
            for name, (dims, values, *about) in _coordinates(job).items():
                values = np.asarray(values)
                if values.dtype == object:
                    variable = file.create_variable(name, (dims,), dtype=h5py.string_dtype())
                    variable[:] = values
                else:
                    file.create_variable(name, (dims,), data=values)
                for key, text in (about[0] if about else {}).items():
                    file[name].attrs[key] = text
            other_coordinates = [name for name in _coordinates(job) if name not in sizes]
            for name, (dims, kind, about) in _variables(job).items():
                if kind == "text":
                    variable = file.create_variable(_escaped(name), dims, dtype=h5py.string_dtype())
                    variable[:] = ""
                    variable.attrs.update(about)
                    continue
                # writing one number makes HDF5 allocate and fill the whole variable
                empty = np.nan if kind == "f8" else -1
                variable = file.create_variable(_escaped(name), dims, dtype=kind, fillvalue=empty)
                variable[(0,) * len(dims)] = empty
                for key, text in about.items():
                    variable.attrs[key] = text
                if other_coordinates:
                    variable.attrs["coordinates"] = " ".join(other_coordinates)
            codes = {code: text for code, text in STATUS.items() if code >= 0}
            file["status"].attrs["flag_values"] = np.array(list(codes), dtype="i1")
            words = [text.replace(",", "").replace(" ", "_") for text in codes.values()]
            file["status"].attrs["flag_meanings"] = " ".join(words)
            for key, value in _attributes(job).items():
                file.attrs[key] = value
            file.attrs[_MARK] = json.dumps(self.parts)

    def _size(self) -> int:
        """Return the greatest size of the file before the first lane runs."""
        job = self.job
        sizes = {"lane": job.lanes.count, "time": job.times.size, "event": len(job.specs)}
        variables = _variables(job).values()
        columns = [np.asarray(values).size for _, values, *_ in _coordinates(job).values()]
        return (
            sum(
                _EACH + 16 * math.prod(sizes[d] for d in dims)
                for dims, kind, _ in variables
                if kind == "text"
            )
            + sum(
                _EACH + 8 * math.prod(sizes[d] for d in dims) for dims, kind, _ in variables if kind != "text"
            )
            + sum(_EACH + 16 * count for count in columns)
            + _HEAP
        )

    def waiting(self, low: int, high: int) -> Any:
        """Return 1 for each lane of a range that was not run, else 0."""
        import h5py

        with h5py.File(self.path, "r") as file:
            return (file["status"][low:high] == WAITING).astype(np.int64)

    def write(self, part: Results) -> None:
        """Write the results of lanes; lanes that were not run keep their place."""
        import h5py

        arrays = _parts(self.job, part)
        done = np.flatnonzero(arrays["status"] != WAITING)
        if not done.size:
            return
        texts = {name: [x.encode() for x in arrays[name][done]] for name in self.job.texts}
        growth = sum(_HEAP + sum(2 * len(x) + 64 for x in column) for column in texts.values())
        with explained(self.path, growth, _REST):
            reserve(self.path, growth)
            with h5py.File(self.path, "r+") as file:
                for name, array in arrays.items():
                    if name == "status":
                        file.flush()
                    if array.size:
                        for first, last in _runs(done):
                            file[_escaped(name)][part.low + first : part.low + last] = array[first:last]

    def dataset(self) -> xarray.Dataset:
        """Return the results in the file: read into memory, or on demand if the file is large."""
        import xarray

        opened = xarray.open_dataset(self.path, engine="h5netcdf", mask_and_scale=False, decode_times=False)
        if opened.nbytes < _SMALL:
            opened.load()
            opened.close()
        codes, blame = opened["status"].values, opened["blame"].values
        opened.attrs.pop(_MARK, None)
        data = _told(opened.drop_vars(["status", "blame"]), codes, blame, self.job)
        data.set_close(opened.close)
        return data


def _runs(places: Any) -> list[tuple[int, int]]:
    """Return the ranges of consecutive numbers."""
    breaks = np.flatnonzero(np.diff(places) > 1) + 1
    return [(int(x[0]), int(x[-1]) + 1) for x in np.split(places, breaks)]


def _escaped(name: str) -> str:
    """Return a name without the separator of HDF5 groups."""
    return name.replace("/", "÷")
