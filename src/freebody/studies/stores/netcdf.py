"""Results of a batch in a file that is filled lane by lane.

The whole file is laid out before the first lane runs: every variable has its place and its size, filled with nan. Later
only numbers are written into these places, first the results of a lane and then its status. A run that is stopped, even
by force, leaves a file that can be read, and the same call continues with the lanes that are still waiting.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import SimulationError, path_of
from ...motion.batch.dataset import arrays_of, attributes_of, coordinates_of, labelled, variables_of
from ...motion.batch.job import Job
from ...motion.batch.results import REASON, Results
from ...motion.ending import STATUS, End
from ...motion.files.replacing import explained, lock, replacing, reserve
from ..blocks.block import Report, Whole
from ..blocks.cutting import ranges_within
from ..blocks.schedule import Range
from .memory import explained_starts, flagged, with_lost

if TYPE_CHECKING:
    import xarray


_MARK = "runs"  # attribute that holds the identity of the runs, part by part
_REST = "The lanes that were written before are whole, and the same call goes on with the others. "
_SMALL = 1 << 28  # bytes of a file that is read into memory
_HEAP = 1 << 16  # greatest number of bytes that HDF5 adds for texts and for attributes of the file
_ADDRESS = 16  # bytes in the file for the length and the address of a text
_EACH = 1 << 12  # greatest number of bytes that describe a variable


class NetCDF:
    """A netCDF file that is filled lane by lane, by the process that runs the study.

    Raises
    ------
    SimulationError
        No such folder, a file of other runs, or no netCDF file.
    """

    delivery = Whole()

    def __init__(self, path: Any, job: Job, identity: Mapping[str, str]) -> None:
        self.path, self.job = path_of(path, "store=", SimulationError), job
        self.lost: dict[int, str] = {}
        self.reasons: dict[int, str] = {}
        self.parts = dict(identity)
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
                waiting = "status" in file and bool((file["status"][:] == End.WAITING).any())
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
            for first, last in _runs(np.flatnonzero(statuses == End.WAITING)) if places else ():
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
            if job.unknowns:
                sizes["by"] = len(job.unknowns)
            file.dimensions = sizes
            for name, (dims, values, *about) in coordinates_of(job).items():
                values = np.asarray(values)
                if values.dtype == object:
                    variable = file.create_variable(name, (dims,), dtype=h5py.string_dtype())
                    variable[:] = values
                else:
                    file.create_variable(name, (dims,), data=values)
                for key, text in (about[0] if about else {}).items():
                    file[name].attrs[key] = text
            other_coordinates = [name for name in coordinates_of(job) if name not in sizes]
            for name, (dims, kind, about) in variables_of(job).items():
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
            for key, value in attributes_of(job).items():
                file.attrs[key] = value
            file.attrs[_MARK] = json.dumps(self.parts)

    def _size(self) -> int:
        """Return the greatest size of the file before the first lane runs."""
        job = self.job
        sizes = {
            "lane": job.lanes.count,
            "time": job.times.size,
            "event": len(job.specs),
            "by": len(job.unknowns),
        }
        variables = variables_of(job).values()
        columns = [np.asarray(values).size for _, values, *_ in coordinates_of(job).values()]
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

    def missing(self, blocks: Sequence[Range]) -> Iterator[Range]:
        """Yield the ranges of lanes that were not run, each within a block."""
        import h5py

        with h5py.File(self.path, "r") as file:
            waiting = file["status"][:] == End.WAITING
        yield from ranges_within(waiting, blocks)

    def receive(self, report: Report) -> None:
        """Write the results of a block."""
        self.reasons |= report.reasons
        self.write(report.content)

    def lose(self, lost: dict[int, str]) -> None:
        """Note lanes that are lost, and why; in the file they are waiting, and the next call runs them again."""
        self.lost |= lost

    def write(self, part: Results) -> None:
        """Write the results of lanes; lanes that were not run keep their place."""
        import h5py

        arrays = arrays_of(self.job, part)
        done = np.flatnonzero(arrays["status"] != End.WAITING)
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

    def enough(self) -> bool:
        """Return False: all lanes are kept."""
        return False

    def dataset(self) -> xarray.Dataset:
        """Return the results in the file: read into memory, or on demand if the file is large."""
        import xarray

        opened = xarray.open_dataset(self.path, engine="h5netcdf", mask_and_scale=False, decode_times=False)
        if opened.nbytes < _SMALL:
            opened.load()
            opened.close()
        codes, blame = opened["status"].values, opened["blame"].values
        opened.attrs.pop(_MARK, None)
        data = self._labelled(opened, codes, blame)
        data.set_close(opened.close)
        return data

    def _labelled(self, opened: xarray.Dataset, codes: Any, blame: Any) -> xarray.Dataset:
        """Return the results with words for the statuses."""
        job = explained_starts(self.job, self.reasons)
        data = labelled(opened.drop_vars(["status", "blame"]), codes, blame, job)
        return with_lost(data, self.lost)


class FlaggedNetCDF(NetCDF):
    """A netCDF file of a study, given back with statuses as numbers.

    The file tells how each lane ended, but not why: reasons are those of lanes that this process ran.
    """

    def _labelled(self, opened: xarray.Dataset, codes: Any, blame: Any) -> xarray.Dataset:
        codes = codes.copy()
        codes[list(self.lost)] = End.LOST
        reasons = self.reasons
        if REASON in opened:
            texts = opened[REASON].values
            reasons = {int(k): texts[k] for k in np.flatnonzero(texts != "")} | reasons
            opened = opened.drop_vars(REASON)
        return flagged(opened.drop_vars("lane"), codes, blame, self.job, reasons | self.lost)


def _runs(places: Any) -> list[tuple[int, int]]:
    """Return the ranges of consecutive numbers."""
    breaks = np.flatnonzero(np.diff(places) > 1) + 1
    return [(int(x[0]), int(x[-1]) + 1) for x in np.split(places, breaks)]


def _escaped(name: str) -> str:
    """Return a name without the separator of HDF5 groups."""
    return name.replace("/", "÷")
