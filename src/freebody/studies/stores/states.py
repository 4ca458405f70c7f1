"""States of a study that is reduced, kept in a zarr store: one chunk a block, written by the worker that made it.

    x.zarr/study/states   (lane)   pickled state of the block that begins at this lane, with its last lane; else empty
    x.zarr/study/pickle            the study, its reducers, and how they are asked for

A state is one chunk, which is written under another name and renamed: it is whole or missing. States merge to the same
bits in any order, so that a reduction that goes on after a stop has the result of one that was not stopped.
"""

from __future__ import annotations

import base64
import io
import pickle
from bisect import bisect_left
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...errors import SimulationError
from ...motion.batch.job import Job
from ...motion.batch.results import Results
from ...motion.files.replacing import explained
from ..blocks.block import Delivery, Report
from ..blocks.schedule import Range
from .zarr import check, laid_out, mark_of, settle

REDUCED = "reduced"
"""Mark of a store that holds states, not lanes."""
_PLACE = "study/states"
_REST = "The states that were written before are whole, and the same call goes on with the others. "
_ROOM = ("freebody.studies.reducers.",)
_PLAIN = {
    ("numpy", "ndarray"), ("numpy", "dtype"), ("numpy._core.multiarray", "_reconstruct"),
    ("numpy._core.multiarray", "scalar"), ("numpy._core.numeric", "_frombuffer"), ("fractions", "Fraction"),
}  # fmt: skip
"""What a state may hold besides the classes of the reducers."""


class _Reader(pickle.Unpickler):
    """Reads states, and runs nothing else that a file may ask for."""

    def find_class(self, module: str, name: str) -> Any:
        if module.startswith(_ROOM) or (module, name) in _PLAIN:
            return super().find_class(module, name)
        raise pickle.UnpicklingError(f"{module}.{name} is no part of a state")


@dataclass(frozen=True)
class WrittenStates:
    """States are written where they are made, and sent back.

    ``reduced``   delivery that makes them
    """

    reduced: Delivery
    path: str

    def deliver(self, job: Job, source: Any, part: Results, report: Report) -> Any:
        """Return the states of a block; they are on the disk if the whole block was run."""
        import zarr

        content = self.reduced.deliver(job, source, part, report)
        if report.interrupted or isinstance(content, str):
            return content
        with explained(Path(self.path), more=_REST):
            group: Any = zarr.open_group(self.path, mode="r+", use_consolidated=False)
            text = base64.b64encode(pickle.dumps(content, protocol=5)).decode()
            group[_PLACE][part.low] = f"{part.high} {text}"
            settle(Path(self.path), f"{_PLACE}/c/{part.low}")
        return content


class StateStore:
    """A zarr store of states, made or gone on with.

    Raises
    ------
    SimulationError
        No such folder, the store of another study or of other reducers, or something else at this path.
    """

    def __init__(
        self,
        path: Path,
        parts: Mapping[str, str],
        size: int,
        study: Callable[[], bytes],
        law: str,
        lanes: int,
    ) -> None:
        self.path = path
        if not path.exists():
            mark = {"parts": dict(parts), "block": size, "lanes": lanes, "law": law, REDUCED: True}
            with laid_out(path, mark, {"title": "States of a study that is reduced"}, study()) as group:
                group.create_group("study").create_array(
                    "states", shape=(lanes,), chunks=(1,), dtype=str, fill_value="", dimension_names=("lane",)
                )
        elif REDUCED not in mark_of(path):
            raise SimulationError(
                f"Expected '{path}' to hold a study that is reduced, but it holds the lanes of one, by "
                "study.run(store=...). Choose another path."
            )
        check(path, parts)
        self.starts = sorted(starts_of(path))

    def delivery(self, reduced: Delivery) -> Delivery:
        """Return the delivery that writes what another delivers."""
        return WrittenStates(reduced, str(self.path.absolute()))

    def kept(self, low: int, high: int) -> Iterator[tuple[Range, Any]]:
        """Yield ranges of lanes in their order: those that are kept, with their states, and the others with None."""
        place = low
        for first in self.starts[bisect_left(self.starts, low) :]:
            if first < place or first >= high:
                continue
            last, content = self._read(first)
            if last <= high:  # else it is of a call with another rule, whose stages ended elsewhere
                if first > place:
                    yield (place, first), None
                yield (first, last), content
                place = last
        if place < high:
            yield (place, high), None

    def _read(self, low: int) -> tuple[int, Any]:
        import zarr

        group: Any = zarr.open_group(str(self.path), mode="r", use_consolidated=False)
        end, text = str(group[_PLACE][low]).split()
        try:
            return int(end), _Reader(io.BytesIO(base64.b64decode(text))).load()
        except (pickle.UnpicklingError, ValueError, EOFError) as error:
            raise SimulationError(
                f"Expected the states of a study in '{self.path}', but those of lane {low} cannot be read: {error}. "
                "Remove the store."
            ) from None


def starts_of(path: Path) -> list[int]:
    """Return the first lanes of the blocks whose states are kept."""
    folder = path / _PLACE / "c"
    if not folder.is_dir():
        return []
    return [int(chunk.name) for chunk in folder.iterdir() if chunk.name.isdigit()]


def kept_lanes(path: Path, count: int) -> int:
    """Return the number of lanes, of ``count``, whose states are kept."""
    import zarr

    group: Any = zarr.open_group(str(path), mode="r", use_consolidated=False)
    kept = place = 0
    for first in sorted(starts_of(path)):
        last = int(str(group[_PLACE][first]).split()[0])
        kept += max(0, last - max(first, place))
        place = max(place, last)
    return kept
