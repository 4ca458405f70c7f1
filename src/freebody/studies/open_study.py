"""open_study: a study that is kept in a zarr store, while it runs or after it was stopped."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import SimulationError, path_of
from ..motion.ending import GOOD, STATUS, End
from .reduction import reduce
from .stores.states import REDUCED, kept_lanes
from .stores.zarr import forget_lost, loaded, mark_of, missing, opened, statuses
from .study import Study

if TYPE_CHECKING:
    import xarray


def open_study(path: Any) -> StoredStudy:
    """Open the study that a zarr store keeps.

    Parameters
    ----------
    path : path
        What was passed as ``store="x.zarr"`` to :meth:`freebody.Study.run`.

    Returns
    -------
    StoredStudy

    Raises
    ------
    SimulationError
        If there is no store of a study at this path.

    Examples
    --------
    >>> import os, tempfile, freebody as fb
    >>> s = fb.System("stone")
    >>> stone = s.body("stone", fb.particle(1))
    >>> fall = s.slider("fall", s.ground, stone, axis="y", coordinate="y")
    >>> s.gravity = (0, -9.81, 0)
    >>> path = os.path.join(tempfile.mkdtemp(), "falls.zarr")
    >>> data = fb.study(s, until=1, lanes=fb.grid({"y'": [0, 5]}), outputs="final(y)").run(store=path)
    >>> kept = fb.open_study(path)
    >>> kept.missing, kept.data["final(y)"].round(3).values
    (0, array([-4.905,  0.095]))
    """
    return StoredStudy(path_of(path, "open_study()", SimulationError))


class StoredStudy:
    """A study in a zarr store; made by :func:`freebody.open_study`."""

    def __init__(self, path: Path) -> None:
        if not path.exists():
            raise SimulationError(f"Expected the zarr store of a study, got '{path}', where nothing is.")
        self.path, self.mark = path, mark_of(path)
        if "parts" not in self.mark:
            raise SimulationError(
                f"Expected the zarr store of a study, got '{path}', which holds something else. Its name is what was "
                "passed as store= to study.run()."
            )

    @property
    def count(self) -> int:
        """Number of lanes."""
        return int(self.mark["lanes"])

    @property
    def reduced(self) -> bool:
        """True if statistics of the lanes are kept, by ``study.reduce(store=...)``, not the lanes."""
        return REDUCED in self.mark

    @property
    def missing(self) -> int:
        """Number of lanes that are not kept yet."""
        if self.reduced:
            return self.count - kept_lanes(self.path, self.count)
        return sum(high - low for low, high in missing(self.path))

    @property
    def ended(self) -> dict[str, int]:
        """Number of lanes by how they ended."""
        self._need_lanes()
        codes, counts = np.unique(statuses(self.path), return_counts=True)
        return {STATUS[int(code)]: int(n) for code, n in zip(codes, counts, strict=True)}

    @property
    def failed(self) -> dict[str, int]:
        """Number of lanes that failed, by their status."""
        good = {STATUS[code] for code in (*GOOD, End.WAITING)}
        return {status: n for status, n in self.ended.items() if status not in good}

    @property
    def data(self) -> xarray.Dataset:
        """What is kept so far, read on demand."""
        self._need_lanes()
        return opened(self.path)

    @property
    def study(self) -> Study:
        """The study itself.

        It is a pickle: reading it runs what the pickle says, so ask for it only of stores that you trust. Lanes, data
        and statuses are read without it.
        """
        return self._kept[0]

    @property
    def _kept(self) -> tuple[Study, Any]:
        content = loaded(self.path)
        if not (isinstance(content, tuple) and len(content) == 2 and isinstance(content[0], Study)):
            raise SimulationError(f"Expected a study in '{self.path}', got {type(content).__name__}.")
        return content

    def _need_lanes(self) -> None:
        if self.reduced:
            raise SimulationError(
                f"Expected lanes, which study.run(store=...) keeps, but '{self.path}' keeps statistics of them. "
                "fb.open_study(...).resume() returns these."
            )

    def resume(
        self,
        executor: Any = None,
        *,
        lost: bool = False,
        progress: bool | Callable[[Any], Any] | None = None,
        threads: int | None = None,
    ) -> xarray.Dataset:
        """Run the lanes that are missing; arguments and result as of `Study.run`, or of `Study.reduce`.

        The study is read from the store, which runs what its pickle says: resume only stores that you trust.

        Parameters
        ----------
        lost : bool
            True to also run lanes again that were lost: that ended their process (for want of memory, by a signal), or
            whose block broke. A study that is reduced keeps no lost lanes, and always runs them again.
        """
        study, reduced = self._kept
        if reduced is None:
            if lost:
                forget_lost(self.path)
            return study.run(executor, store=self.path, progress=progress, threads=threads)
        reducers, options = reduced
        return reduce(
            study, reducers, replace(options, store=self.path), executor, progress=progress, threads=threads
        )

    def __repr__(self) -> str:
        left = self.missing
        if self.reduced:
            kept = f"{self.count - left} of {self.count} lanes are kept"
            return f"Reduced study in '{self.path}': {self.mark['law']}; {kept}"
        failed = "".join(f", {n} {status}" for status, n in self.failed.items())
        state = "all lanes are kept" if not left else f"{left} of {self.count} lanes are missing"
        return f"Study in '{self.path}': {self.mark['law']}; {state}{failed}"
