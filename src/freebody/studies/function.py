"""A study as a function of what varies in it, for libraries that choose the values themselves.

    f: (d, n) -> (s, n),    d values of each of n lanes -> s outputs

The study is read and checked once. Each call runs n lanes; an executor keeps the ready job from call to call.
"""

from __future__ import annotations

import weakref
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SimulationError
from ..motion.batch.start import lanes_of
from ..motion.ending import GOOD, STATUS, End
from .blocks.block import Ready
from .blocks.executors import executor_of, sent
from .blocks.run import run
from .lanes.distributions import Uniform
from .lanes.sample import Sample
from .lanes.table import Table
from .stores.memory import Flagged

if TYPE_CHECKING:
    import xarray

Array = NDArray[np.float64]


class Evaluator:
    """Runs lanes of a study with other values than those of its law.

    ``study``      machine, outputs and options, and the names that vary
    ``executor``   who runs the lanes, for all calls
    """

    def __init__(self, study: Any, executor: Any, threads: int | None, progress: Any) -> None:
        self.here = executor is None or executor == "threads"
        if threads is not None and not self.here:
            raise SimulationError(
                "Expected threads= or executor=, got both: each block that an executor runs has one thread. Leave one "
                "out."
            )
        self.study, self.progress = study, progress
        self.work = replace(study._work, source=None)
        self.ready = Ready(self.work, threads if self.here else 1)
        self.stack = ExitStack()
        self.workers = self.stack.enter_context(executor_of(None if self.here else executor))
        weakref.finalize(self, self.stack.close)

    def data(self, columns: Mapping[str, Array]) -> xarray.Dataset:
        """Return the dataset of lanes with these values by name, each of shape (n,)."""
        study, model = self.study, self.study.machine
        count = len(next(iter(columns.values())))
        source = replace(study._source, law=Table(tuple(columns.items()), count))
        job = replace(self.ready.job, count=count)

        def sink_of(size: int) -> Any:
            return Flagged(
                job,
                job.room(0, count),
                lambda: replace(job, lanes=lanes_of(model, *source.arguments(0, count))),
            )

        return run(
            _Counted(self.ready, job), source, self.workers, sink_of, in_order=True, progress=self.progress,
            size=count if self.here else None, pack=lambda: sent(self.work, model),
        )  # fmt: skip


class _Counted:
    """A ready study with another number of lanes."""

    def __init__(self, ready: Ready, job: Any) -> None:
        self.job, self.run, self.work = job, ready.run, ready.work


class StudyFunction:
    """The outputs of a study as a function of what varies; made by :meth:`freebody.Study.as_function`.

    Attributes
    ----------
    names : tuple of str
        What the rows of the argument stand for, in this order.
    outputs : tuple of str
        What the rows of the result stand for.
    """

    def __init__(
        self, study: Any, executor: Any = None, failed: Any = "raise", threads: int | None = None,
        progress: Any = False,
    ) -> None:  # fmt: skip
        self.arguments = (study, executor, failed, threads, progress)
        self.names = study.lanes.names
        job = study.ready.job
        if job.outputs.timed:
            name = next(iter(job.outputs.timed))
            raise SimulationError(
                f"Expected outputs that are one number of a whole run for as_function(), got '{name}' over time. Write "
                f"outputs=['final({name})'], or max, min, range, initial."
            )
        self.outputs = tuple(job.outputs.numbers)
        self.single = not isinstance(study.outputs, Mapping | list | tuple)
        self.value = None if isinstance(failed, str) and failed == "raise" else _number(failed)
        self.evaluator = Evaluator(study, executor, threads, progress)

    @property
    def distributions(self) -> list[Any]:
        """Distributions of the names, in their order, as ``dists=`` of ``scipy.stats.sobol_indices``."""
        from scipy.stats import uniform

        law = self.arguments[0].lanes
        if not isinstance(law, Sample):
            raise SimulationError(
                f"Expected the distributions of lanes=fb.sample(...), but the lanes are a {law!r}."
            )
        return [
            uniform(x.low, x.high - x.low) if isinstance(x, Uniform) else x.distribution
            for _, x in law.marginals
        ]

    def __call__(self, x: Any) -> Any:
        """Return the outputs.

        Parameters
        ----------
        x : array (d,) or (d, n)
            Values of ``names``, in their order, for one lane or n.

        Returns
        -------
        ndarray (s,) or (s, n)
            Values of ``outputs``. If the study has one output that is not in a list: a number, or shape (n,).

        Raises
        ------
        SimulationError
            Another shape, a number that is not finite, a lane that failed.
        """
        x = self._values(x)
        if x.ndim not in (1, 2) or len(x) != len(self.names):
            rows = (
                " For an array with one row for each lane, call .rows(x)."
                if x.shape[1:] == (len(self.names),)
                else ""
            )
            raise SimulationError(
                f"Expected an array of shape ({len(self.names)},) or ({len(self.names)}, n), whose rows are "
                f"{', '.join(self.names)}, got shape {x.shape}.{rows}"
            )
        y = self._outputs(x.reshape(len(self.names), -1))
        y = y[0] if self.single else y
        return y if x.ndim == 2 else y[()] if y.ndim == 0 else y[..., 0][()]

    def rows(self, x: Any) -> Array:
        """Return the outputs of lanes that are rows, as SALib calls functions.

        Parameters
        ----------
        x : array (n, d)
            One row for each lane: values of ``names``, in their order.

        Returns
        -------
        ndarray (n, s)
            One row for each lane. If the study has one output that is not in a list: shape (n,).
        """
        x = self._values(x)
        if x.ndim != 2 or x.shape[1] != len(self.names):
            raise SimulationError(
                f"Expected an array of shape (n, {len(self.names)}), whose columns are {', '.join(self.names)}, got "
                f"shape {x.shape}."
            )
        y = self._outputs(x.T)
        return np.ascontiguousarray(y[0] if self.single else y.T)

    def close(self) -> None:
        """End the workers that were started for this function."""
        self.evaluator.stack.close()

    def __enter__(self) -> StudyFunction:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def __reduce__(self) -> Any:
        return StudyFunction, self.arguments

    def __repr__(self) -> str:
        return f"({', '.join(self.names)}) -> ({', '.join(self.outputs)}), by a {self.arguments[0]!r}"

    def _values(self, x: Any) -> Array:
        """Return values as an array of finite numbers."""
        try:
            x = np.asarray(x, dtype=float)
        except (TypeError, ValueError):
            raise SimulationError(f"Expected numbers for {', '.join(self.names)}, got {x!r}.") from None
        if not np.isfinite(x).all():
            raise SimulationError(
                f"Expected finite numbers for {', '.join(self.names)}, got {x[~np.isfinite(x)].flat[0]}."
            )
        return x

    def _outputs(self, x: Array) -> Array:
        """Return the outputs (s, n) of values (d, n)."""
        if not x.shape[1]:
            return np.empty((len(self.outputs), 0))
        columns = {name: np.ascontiguousarray(row) for name, row in zip(self.names, x, strict=True)}
        data = self.evaluator.data(columns)
        codes = data["status"].values
        if (codes == End.WAITING).any():
            if "not begun" in (text := data.attrs.get("interrupted", "")):
                raise SimulationError(f"The lanes were not run to the end: {text}.")
            raise KeyboardInterrupt
        result = np.array([data[name].values for name in self.outputs], dtype=float)
        bad = ~np.isin(codes, GOOD)
        if self.value is None:
            lacking = bad | np.isnan(result).any(axis=0)
            if lacking.any():
                self._refuse(data, int(lacking.argmax()), bad, columns, int(lacking.sum()))
        else:
            result[:, bad] = self.value
        return result

    def _refuse(
        self, data: xarray.Dataset, lane: int, bad: Any, columns: Mapping[str, Array], count: int
    ) -> None:
        """Raise the error of a lane without outputs."""
        reason = "an output is not determined"
        if bad[lane]:
            reason = STATUS[int(data["status"].values[lane])]
            told = (
                dict(zip(data["failed_lane"].values, data["reason"].values, strict=True))
                if "reason" in data
                else {}
            )
            reason += f": {told[lane]}" if lane in told else ""
        values = ", ".join(f"{name} = {x[lane]:.6g}" for name, x in columns.items())
        raise SimulationError(
            f"{count} of {len(bad)} lanes failed, the first with {values}: {reason.rstrip('.')}. as_function(failed="
            "...) takes the number that such lanes have, such as nan or inf."
        )


def _number(failed: Any) -> float:
    """Return the outputs of a lane that failed."""
    try:
        return float(failed)
    except (TypeError, ValueError):
        raise SimulationError(
            f'Expected "raise", or the number that a failed lane has, such as nan or inf, for failed=, got {failed!r}.'
        ) from None
