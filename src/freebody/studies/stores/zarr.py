"""A study kept as a zarr store: one chunk a block, written by the worker that made it, its statuses last.

    x.zarr/NAME       (lane[, time | event])   a variable, one chunk for each block of lanes
    x.zarr/status     (lane)                   how each lane ended; -1 while it is waiting
    x.zarr/reason     (block)                  {reason: [lanes]} of the lanes of a block that failed, as JSON
    x.zarr/study/pickle                        the study itself

Every chunk is written under another name and renamed, so that a process that is killed leaves whole chunks only, and a
block counts once its statuses are there. The same block has the same bits wherever it is run, so that two writers do no
harm. The layout is that of `xarray.open_zarr`, which reads the store at any moment.
"""

from __future__ import annotations

import json
import os
import pickle
import shutil
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from threading import get_ident
from typing import Any

import numpy as np

from ...errors import SimulationError
from ...motion.batch.dataset import (
    arrays_of,
    attributes_of,
    blamed,
    coordinates_of,
    tell_waiting,
    variables_of,
)
from ...motion.batch.job import Job
from ...motion.batch.results import REASON, Results
from ...motion.ending import End
from ...motion.files.replacing import explained
from ..blocks.block import Report
from ..blocks.cutting import cut, ranges_within
from ..blocks.schedule import Range
from .memory import meanings_of

MARK = "study"
"""Attribute of the store: identity of the study, part by part, and the size of a block."""
_REST = "The blocks that were written before are whole, and the same call goes on with the others. "


@contextmanager
def _quiet() -> Iterator[None]:
    """Context without the warning that consolidated metadata is an extension of zarr 3."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Consolidated metadata")
        yield


def place_of(name: str) -> str:
    """Return the name of the array of a variable: without the separator of zarr's folders."""
    return name.replace("/", "÷")


@contextmanager
def laid_out(path: Path, mark: Mapping[str, Any], about: Mapping[str, Any], study: bytes) -> Iterator[Any]:
    """Context with the group of a new store, which is laid out beside its place and then renamed.

    Parameters
    ----------
    path : Path
    mark, about : mapping
        What tells the store from those of other studies, and other attributes.
    study : bytes
        Pickle of what is resumed.
    """
    import zarr

    if not path.parent.is_dir():
        raise SimulationError(
            f"Cannot write '{path}': there is no folder '{path.parent}'. Make it, or choose another path."
        )
    new = path.with_name(f".{path.name}.{os.getpid()}-{get_ident()}.new")
    system = {"command": " ".join(sys.argv), "python": sys.version.split()[0], "numpy": np.__version__}
    with explained(path), _quiet():
        shutil.rmtree(new, ignore_errors=True)
        try:
            group = zarr.create_group(
                str(new), zarr_format=3, attributes={**about, MARK: dict(mark), **system}
            )
            yield group
            content = np.frombuffer(study, dtype="u1")
            group.require_group("study").create_array("pickle", shape=content.shape, dtype="u1")[:] = content
            zarr.consolidate_metadata(str(new))
            try:
                new.rename(path)
            except OSError:
                if not path.exists():  # another call may have made it in the meantime
                    raise
        finally:
            shutil.rmtree(new, ignore_errors=True)


@dataclass(frozen=True)
class Written:
    """Results are written into a store, where they are made; their numbers are all that is sent back."""

    path: str

    def deliver(self, job: Job, source: Any, part: Results, report: Report) -> None:
        """Write the results of a block."""
        import zarr

        with explained(Path(self.path), more=_REST):
            group: Any = zarr.open_group(self.path, mode="r+", use_consolidated=False)
            rows = slice(part.low, part.high)
            values, initial = source.arguments(part.low, part.high)
            for name, (values_of, key) in _varied(job).items():
                group[place_of(name)][rows] = np.asarray((values, initial)[values_of][key], dtype=float)
            arrays = arrays_of(job, part)
            status = arrays.pop("status")
            arrays["blame"] = blamed(status, arrays["blame"], job)
            for name in arrays.keys() - {REASON}:
                if arrays[name].size:
                    group[place_of(name)][rows] = arrays[name]
            if report.reasons:
                self.explain(group, part.low, report.reasons)
            settle(Path(self.path), f"*/c/{part.low // group['status'].chunks[0]}")
            group["status"][rows] = status

    @staticmethod
    def explain(group: Any, low: int, reasons: Mapping[int, str]) -> None:
        """Write why lanes of a block failed, beside what is written of it."""
        block = low // group["status"].chunks[0]
        text = str(group[REASON][block])
        table = {} if not text else json.loads(text)
        for lane, reason in reasons.items():
            table[reason] = sorted({*table.get(reason, ()), lane})
        group[REASON][block] = json.dumps(table)


class ZarrStore:
    """A zarr store of a study, made or gone on with.

    Raises
    ------
    SimulationError
        No such folder, the store of another study, or something else at this path.
    """

    def __init__(
        self, path: Path, job: Job, parts: Mapping[str, str], size: int, study: Callable[[], bytes], law: str
    ) -> None:
        self.path, self.job, self.parts = path, job, parts
        if not path.exists():
            self._create(size, study(), law)
        self.check()
        self.delivery = Written(str(path.absolute()))

    def check(self) -> None:
        """Refuse the store of another study."""
        check(self.path, self.parts)

    def _create(self, size: int, study: bytes, law: str) -> None:
        """Lay out the store."""
        job = self.job
        mark = {"parts": dict(self.parts), "block": size, "lanes": job.count, "law": law}
        coordinates = [place_of(name) for name in _varied(job)]
        about = {**attributes_of(job), "coordinates": " ".join(coordinates)}
        with laid_out(self.path, mark, about, study) as group:
            for name, (dims, values, *more) in coordinates_of(job).items():
                if name in ("time", "event", "by"):
                    texts = np.asarray(values).dtype == object
                    group.create_array(
                        name, shape=np.shape(values), dtype=str if texts else "f8", dimension_names=(dims,),
                        attributes=more[0] if more else {},
                    )[:] = values  # fmt: skip
            sizes = {
                "lane": job.count,
                "time": job.times.size,
                "event": len(job.specs),
                "by": len(job.unknowns),
            }
            variables = {
                name: (("lane",), "f8", {"long_name": f"{name} of the lane"}) for name in _varied(job)
            } | variables_of(job)
            meanings = meanings_of(job)
            for name, (dims, kind, attributes) in variables.items():
                if name == REASON:
                    continue
                fill: Any = {"text": "", "f8": np.nan}.get(kind, End.WAITING)
                group.create_array(
                    place_of(name), shape=tuple(sizes[d] for d in dims), dtype=str if kind == "text" else kind,
                    chunks=(size, *(sizes[d] for d in dims[1:])), fill_value=fill, dimension_names=dims,
                    attributes={key: _plain(x) for key, x in attributes.items()} | meanings.get(name, {}),
                )  # fmt: skip
            group.create_array(
                REASON, shape=(-(-job.count // size),), chunks=(1,), dtype=str, fill_value="",
                dimension_names=("block",), attributes={"long_name": "lanes that failed, by the reason"},
            )  # fmt: skip

    def missing(self, blocks: Sequence[Range]) -> Iterable[Range]:
        """Return the ranges of lanes that are waiting, each within a block of the store."""
        return missing(self.path)

    def receive(self, report: Report) -> None:
        """Do nothing: the worker has written the block."""

    def lose(self, lost: dict[int, str]) -> None:
        """Write which lanes are lost, and why."""
        import zarr

        group: Any = zarr.open_group(str(self.path), mode="r+", use_consolidated=False)
        for lane, reason in lost.items():
            Written.explain(group, lane, {lane: reason})
            group["status"][lane] = End.LOST

    def enough(self) -> bool:
        """Return False: all lanes are kept."""
        return False

    def dataset(self) -> Any:
        """Return the results, read on demand."""
        data = opened(self.path)
        tell_waiting(data, statuses(self.path))
        return data


def size_of_block(path: Path) -> int | None:
    """Return the number of lanes of a block of a store; None if there is none."""
    if not path.exists():
        return None
    mark = mark_of(path)
    return int(mark["block"]) if "block" in mark else None


def statuses(path: Path) -> Any:
    """Return the codes of the statuses of all lanes."""
    import zarr

    group: Any = zarr.open_group(str(path), mode="r", use_consolidated=False)
    return group["status"][:]


def missing(path: Path) -> Iterator[Range]:
    """Return ranges of lanes that are waiting, each within a block of a store."""
    waiting = statuses(path) == End.WAITING
    return ranges_within(waiting, cut(len(waiting), int(mark_of(path)["block"])))


def forget_lost(path: Path) -> None:
    """Make lanes waiting again that were lost: those that ended their process, or whose block broke."""
    import zarr

    group: Any = zarr.open_group(str(path), mode="r+", use_consolidated=False)
    lost = np.flatnonzero(group["status"][:] == End.LOST)
    size = int(group["status"].chunks[0])
    for block in np.unique(lost // size).tolist():
        text = str(group[REASON][block])
        forgotten = set(lost[lost // size == block].tolist())
        table = {reason: sorted({*lanes} - forgotten) for reason, lanes in json.loads(text or "{}").items()}
        table = {reason: lanes for reason, lanes in table.items() if lanes}
        group[REASON][block] = json.dumps(table) if table else ""
    for lane in lost.tolist():
        group["status"][lane] = End.WAITING


def loaded(path: Path) -> Any:
    """Return what the store keeps as a pickle, which is run by reading it."""
    import zarr

    group: Any = zarr.open_group(str(path), mode="r", use_consolidated=False)
    return pickle.loads(group["study/pickle"][:].tobytes())


def check(path: Path, parts: Mapping[str, str]) -> None:
    """Refuse the store of another study."""
    stored = mark_of(path).get("parts", {})
    others = [name for name, digest in parts.items() if stored.get(name) != digest]
    if others:
        what = f"a study that differs in the {', the '.join(others)}" if stored else "something else"
        raise SimulationError(
            f"Expected '{path}' to hold results of the same study, which this call continues, but it holds those of "
            f"{what}. Choose another path, or remove it."
        )


def mark_of(path: Path) -> dict[str, Any]:
    """Return what a store tells of its study; nothing if it is no store of a study."""
    import zarr

    try:
        attributes = zarr.open_group(str(path), mode="r").attrs.asdict()
    except (OSError, ValueError, KeyError, zarr.errors.BaseZarrError) as error:
        raise SimulationError(
            f"Expected a zarr store of a study at '{path}', but it cannot be read: {error}. Choose another path."
        ) from None
    mark = attributes.get(MARK)
    return mark if isinstance(mark, dict) else {}


def opened(path: Path) -> Any:
    """Return the dataset of a store, read on demand."""
    import xarray

    data = xarray.open_zarr(str(path), chunks=None, mask_and_scale=False, decode_times=False)
    data = data.rename({name: name.replace("÷", "/") for name in data.variables if "÷" in str(name)})
    data.attrs.pop(MARK, None)
    return data


def _varied(job: Job) -> dict[str, tuple[int, str]]:
    """Return the coordinates of lanes: name -> (0 for a parameter or 1 for an initial value, its name)."""
    parameters, starts = job.lanes.varied
    model = job.kernels.model
    names = {*model.state_names}
    return {name: (0, name) for name in parameters} | {
        f"{name}_start": (1, name) for name in starts if name in names
    }


def settle(path: Path, chunks: str) -> None:
    """Wait until chunks are on the disk, so that statuses are not there before them."""
    for chunk in path.glob(chunks):
        for file in (chunk, *chunk.rglob("*")) if chunk.is_dir() else (chunk,):
            if file.is_file():
                number = os.open(file, os.O_RDONLY)
                try:
                    os.fsync(number)
                finally:
                    os.close(number)


def _plain(value: Any) -> Any:
    """Return an attribute as JSON can hold it."""
    return value.tolist() if isinstance(value, np.ndarray) else value
