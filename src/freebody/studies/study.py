"""study: many motions of one machine as a value, which is run here or elsewhere, kept, continued and reduced."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import cloudpickle
import numpy as np

from ..errors import SimulationError, arguments_named, nearest, path_of
from ..model import Model
from ..motion.batch.dataset import check_names
from ..motion.batch.job import Job, check_memory
from ..motion.batch.start import lanes_of
from ..motion.kernels.kernels import kernels_of
from ..motion.request import Request
from ..scalar.algebra import Expression
from .blocks.block import Ready, Work
from .blocks.crew import Here
from .blocks.cutting import seconds_per_lane
from .blocks.executors import sent
from .blocks.run import run
from .blocks.source import ByLaw
from .blocks.tally import spoken, spoken_size
from .function import StudyFunction
from .identity.study_identity import parts
from .lanes.chosen import Chosen
from .lanes.feasibility import check_possible
from .lanes.grid import Grid
from .lanes.law import Law, check_apart
from .reducers.reducer import Reducer
from .reduction import ReducerOptions, reduce
from .simulate import simulate
from .stores.memory import Flagged
from .stores.netcdf import FlaggedNetCDF
from .stores.zarr import ZarrStore, size_of_block

if TYPE_CHECKING:
    import xarray


_FIRST = 64  # lanes by which a study is read and checked
_OWN = (
    "machine", "until", "initial", "values", "outputs", "progress", "threads", "executor", "store",
)  # fmt: skip
OPTIONS = tuple(x.name for x in fields(Request) if x.init and x.name not in _OWN)
"""Arguments of :func:`freebody.simulate` that are the same in all lanes."""


@arguments_named
def study(
    s: Any,
    until: Expression,
    *,
    lanes: Law,
    outputs: Any = None,
    initial: Mapping[Any, Any] | None = None,
    values: Mapping[Any, Any] | None = None,
    **options: Any,
) -> Study:
    """Return a study: the motions of a machine for all lanes of a law. Nothing runs yet.

    Parameters
    ----------
    s : System or Model
    until : number, expression or text
        Time at which the runs end [s].
    lanes : Law
        What varies: :func:`freebody.grid`, :func:`freebody.table` or :func:`freebody.sample`.
    outputs : name, expression, sequence or mapping of them, optional
        Quantities over time, "theta", and numbers of the whole run, "max(theta)"; see :func:`freebody.simulate`. By
        default all coordinates and speeds.
    initial, values : mapping, optional
        Values that are the same in all lanes; expressions of parameters follow the parameters that vary.
    **options
        ``events``, ``times``, ``samples``, ``tolerance``, ``method``, ``near``, ... of :func:`freebody.simulate`.

    Returns
    -------
    Study

    Raises
    ------
    SimulationError
        If a name is unknown, or stands both in ``lanes`` and in ``initial`` or ``values``; if no machine can have the
        values of some lanes; also as :func:`freebody.simulate`.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> L, g = s.parameters(L=1.0, g=9.81)
    >>> s.gravity = (0, -g, 0)
    >>> bob = s.body("bob", fb.particle(1))
    >>> pin = s.hinge("pin", s.ground, bob, to=(0, L, 0), axis="z", coordinate="theta")
    >>> swings = fb.study(s, until=5, lanes=fb.grid(L=[1, 2], theta=[0.1, 1.0, 2.0]), outputs="max(theta')")
    >>> swings
    Study of 'pendulum' to 5 s: grid of 2 L × 3 theta: 6 lanes; outputs max(theta')
    >>> data = swings.run()
    >>> data["max(theta')"].round(4).values
    array([0.3131, 3.0032, 5.2711, 0.2214, 2.1236, 3.7273])
    """
    if not isinstance(lanes, Law):
        raise SimulationError(
            f"Expected fb.grid(...), fb.table(...) or fb.sample(...) for lanes=, got {lanes!r}."
        )
    for name in ("progress", "threads", "executor", "store"):
        if name in options:
            raise SimulationError(f"Expected {name}= where the study is run: study(...).run({name}=...).")
    unknown = [name for name in options if name not in OPTIONS]
    if unknown:
        raise SimulationError(f"Unknown argument '{unknown[0]}' of study(); {nearest(unknown[0], OPTIONS)}")
    model = kernels_of(s).model
    law = lanes.resolved(model)
    check_apart(model, law, values, initial)
    check_possible(law, model, values)
    result = Study(model, until, law, outputs, dict(initial or {}), dict(values or {}), options)
    check_names(result.ready.job)
    return result


@dataclass(frozen=True, eq=False, repr=False)
class Study:
    """Many motions of one machine; made by :func:`freebody.study`.

    Parameters
    ----------
    machine : Model
    until : number, expression or text
    lanes : Law
        What varies.
    outputs : Any
    initial, values : mapping
        The same in all lanes.
    options : mapping
        Of :func:`freebody.simulate`.
    """

    machine: Model
    until: Any
    lanes: Law
    outputs: Any
    initial: Mapping[Any, Any]
    values: Mapping[Any, Any]
    options: Mapping[str, Any]

    @property
    def count(self) -> int:
        """Number of lanes."""
        return self.lanes.count

    @cached_property
    def _source(self) -> ByLaw:
        names = self.lanes.names
        parameters = {parameter.name for parameter in self.machine.parameters}
        return ByLaw(self.lanes, tuple(x for x in names if x in parameters), self.values, self.initial)

    @cached_property
    def _work(self) -> Work:
        """What a process needs to run lanes: a table is left out, its lanes are sent with the blocks."""
        source = self._source
        some = np.unique(np.linspace(0, self.count - 1, min(_FIRST, self.count)).astype(np.int64)).tolist()
        rows = [source.arguments(k, k + 1) for k in some]
        values, initial = (
            {
                name: np.concatenate([row[kind][name] for row in rows]) if name in self.lanes.names else x
                for name, x in rows[0][kind].items()
            }
            for kind in (0, 1)
        )
        light = source.part(0, min(1, self.count)) is source
        request = Request(
            self.machine, self.until, values=values, initial=initial, outputs=self.outputs, **self.options
        )
        return Work(request, self.count, source if light else None)

    @cached_property
    def ready(self) -> Ready:
        """The study, read and checked, ready to run lanes in this process by one thread."""
        return Ready(self._work)

    @cached_property
    def _parts(self) -> dict[str, str]:
        return parts(self.ready.job, self.lanes)

    @property
    def identity(self) -> str:
        """Digest of all that the results depend on; two studies with one identity have the same results."""
        return hashlib.sha256(repr(sorted(self._parts.items())).encode()).hexdigest()

    def __getstate__(self) -> dict[str, Any]:
        fields = ("machine", "until", "lanes", "outputs", "initial", "values", "options")
        return {name: getattr(self, name) for name in fields}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)

    def __repr__(self) -> str:
        job = self.ready.job
        outputs = ", ".join((*job.outputs.timed, *job.outputs.numbers))
        return f"Study of '{self.machine.name}' to {job.end:g} s: {self.lanes!r}; outputs {outputs}"

    def __str__(self) -> str:
        """Describe the study, with what it costs, as a few lanes show."""
        job = self.ready.job
        size = job.bytes_per_lane * self.count
        seconds = self.seconds_per_lane
        cost = "" if seconds is None else (
            f"about {spoken(seconds * self.count)} of one processor ({spoken(seconds)} a lane), "
        )  # fmt: skip
        return f"{self!r}\n{cost}{spoken_size(size)} of results"

    @cached_property
    def seconds_per_lane(self) -> float | None:
        """Time that a lane takes one processor, from a trial of a few lanes [s]."""
        return seconds_per_lane(Here(self.ready, self._source, lambda done: None), self.count)

    def run(
        self,
        executor: Any = None,
        *,
        store: Any = None,
        progress: bool | Callable[[Any], Any] | None = None,
        threads: int | None = None,
    ) -> xarray.Dataset:
        """Run the lanes, or those that a store does not hold yet.

        Parameters
        ----------
        executor : Executor, text or None
            Who runs the blocks of lanes: anything with ``submit``, such as a ``ProcessPoolExecutor``, the pools of
            loky and mpi4py, or a ``dask.distributed.Client``; its address as text; "processes". By default the
            threads of this process.
        store : path, optional
            ``x.zarr``: written by the workers, a block at a time, and read by ``xarray.open_zarr`` at any moment.
            Other names: a netCDF file, written by this process. What a stopped study has kept is not run again.
        progress : bool or function, optional
            Show a line with what is done, what failed, and the time that is left; by default on terminals and in
            notebooks. A function gets the same: a number from 0 to 1 with ``done``, ``failed``, ``rate`` and
            ``remaining``.
        threads : int, optional
            Number of threads without an executor; all processors by default.

        Returns
        -------
        xarray.Dataset
            Outputs over ``lane`` and ``time``; ``status`` as a flag, with meanings; ``reason`` of the lanes that
            failed, over ``failed``, whose numbers ``failed_lane`` holds. A lane that fails raises no error. In a zarr
            store ``reason`` holds the lanes by reason for each block.

        Raises
        ------
        SimulationError
            An executor without ``submit``, a controller that cannot be sent, the store of another study.
        """
        ready = self.ready
        if executor is None or executor == "threads":
            ready = Ready(self._work, threads)
        elif threads is not None:
            raise SimulationError(
                "Expected threads= or executor=, got both: each block that an executor runs has one thread. Leave one "
                "out."
            )
        job = ready.job
        path = None if store is None else path_of(store, "store=", SimulationError)
        zarr = path is not None and (path.suffix == ".zarr" or path.is_dir())
        if path is None:
            check_memory(job)

        size = size_of_block(path) if path is not None and zarr else None

        def sink_of(size: int) -> Any:
            if path is None:
                return Flagged(job, job.room(0, self.count), lambda: self._with_all_lanes(job))
            if zarr:
                return ZarrStore(path, job, self._parts, size, self._pickled, repr(self.lanes))
            return FlaggedNetCDF(path, self._with_all_lanes(job), self._parts)

        return run(
            ready, self._source, None if executor == "threads" else executor, sink_of, progress=progress,
            size=size, pack=lambda: sent(self._work, self.machine),
        )  # fmt: skip

    def _pickled(self) -> bytes:
        """Return the study as it is kept in a store."""
        return bytes(cloudpickle.dumps((self, None)))

    def _with_all_lanes(self, job: Job) -> Job:
        """Return a job that holds the values of all lanes, as the coordinates of a dataset need them."""
        return replace(job, lanes=lanes_of(self.machine, *self._source.arguments(0, self.count)))

    def reduce(
        self,
        reducers: Mapping[str, Reducer],
        executor: Any = None,
        *,
        until: Any = None,
        most: int | None = None,
        failed: str = "raise",
        store: Any = None,
        progress: bool | Callable[[Any], Any] | None = None,
        threads: int | None = None,
    ) -> xarray.Dataset:
        """Return statistics of the lanes, computed where they run; nothing else of them is kept.

        Parameters
        ----------
        reducers : mapping of name to reducer
            :func:`freebody.mean`, :func:`freebody.quantile`, ... The outputs of the study do not matter: reducers name
            their own.
        executor, progress, threads
            As of :meth:`run`.
        until : rule or list of rules, optional
            :func:`freebody.error`: stop as soon as errors are small enough. The rule is asked after 1024 lanes, and
            then whenever half as many more have ended.
        most : int, optional
            Greatest number of lanes; all by default.
        failed : {"raise", "skip", "count"}
            What a lane that failed means: an error; a lane that is left out, and counted; or one in which the
            conditions hold, which makes a fraction an upper bound.
        store : path, optional
            ``x.zarr``: keeps what each block gives, a few kilobytes, written by the worker that made it. The same call,
            or ``fb.open_study("x.zarr").resume()``, goes on with the blocks that are missing after a stop of any kind,
            to the same bits.

        Returns
        -------
        xarray.Dataset
            For each name ``p`` its value, its standard error ``p_error``, the number of lanes ``p_count`` and more by
            the kind of the reducer. Attributes tell the numbers of lanes and of failed ones. The bits do not depend on
            workers, blocks or order.

        Raises
        ------
        SimulationError
            Unknown names, names that the result has for something else, a lane without the number that is asked for,
            a failed lane with ``failed="raise"``, the store of another study or of other reducers.

        Examples
        --------
        >>> import freebody as fb
        >>> s = fb.System("stone")
        >>> stone = s.body("stone", fb.particle(1))
        >>> fall = s.slider("fall", s.ground, stone, axis="y", coordinate="y")
        >>> s.gravity = (0, -9.81, 0)
        >>> study = fb.study(s, until=1, lanes=fb.sample({"y'": (0, 10)}, n=2000, by="random", seed=1))
        >>> study.reduce({"p": fb.mean("final(y) > 0"), "high": fb.largest("max(y)", 2)}).p.round(2).item()
        0.51
        """
        options = ReducerOptions(until, self.count if most is None else most, failed, store)
        return reduce(self, reducers, options, executor, progress=progress, threads=threads)

    def on_grid(self, data: xarray.Dataset) -> xarray.Dataset:
        """Return results of :meth:`run` with the axes of the grid in place of the lanes, as `freebody.sweep` does.

        Parameters
        ----------
        data : xarray.Dataset
            Of this study: from :meth:`run`, or ``fb.open_study("x.zarr").data``.

        Returns
        -------
        xarray.Dataset
            Dimensions by the names of the grid (``theta_start`` for the initial value of ``theta``), then ``time`` and
            ``event``. What belongs to the lanes that failed keeps their numbers.

        Raises
        ------
        SimulationError
            The lanes are no grid, or the dataset is not one of this study.

        Examples
        --------
        >>> import freebody as fb
        >>> s = fb.System("stone")
        >>> stone = s.body("stone", fb.particle(1))
        >>> fall = s.slider("fall", s.ground, stone, axis="y", coordinate="y")
        >>> study = fb.study(s, until=1, lanes=fb.grid({"y": [0, 1, 2], "y'": [3, 4]}), outputs="final(y)")
        >>> study.on_grid(study.run())["final(y)"].sel({"y_start": 2, "y'_start": 4}).item()
        6.0
        """
        if not isinstance(self.lanes, Grid):
            raise SimulationError(
                f"Expected a study over fb.grid(...), whose names are axes, got a {self.lanes!r}, whose lanes have one "
                "axis."
            )
        if data.sizes.get("lane") != self.count:
            raise SimulationError(
                f"Expected results of this study over {self.count} lanes, got the dimensions {dict(data.sizes)}."
            )
        return self.lanes.shaped(data)

    def as_function(
        self,
        executor: Any = None,
        *,
        failed: Any = "raise",
        progress: bool | Callable[[Any], Any] | None = False,
        threads: int | None = None,
    ) -> StudyFunction:
        """Return the outputs as a function of what varies, for sensitivity analysis and optimization.

        f(x) takes x of shape (d, n), one row for each name of ``f.names`` (the order of ``lanes``), and returns shape
        (s, n), one row for each output; x of shape (d,) is one lane, and one output that is not in a list is a number
        or shape (n,). ``f.rows(X)`` takes and returns one row for each lane. The lanes of the study give the names
        only; of ``fb.sample``, ``f.distributions`` are the distributions in the same order.

        Parameters
        ----------
        executor, progress, threads
            As of :meth:`run`. Workers that are started here end with ``f.close()``, or with ``f``.
        failed : "raise" or number
            What a lane that failed gives: an error, or a number such as nan or inf.

        Returns
        -------
        StudyFunction

        Raises
        ------
        SimulationError
            Outputs over time.

        Examples
        --------
        The height of a throw, v²/2g, depends on the speed alone, and not on the mass:

        >>> import freebody as fb
        >>> from scipy.stats import sobol_indices
        >>> s = fb.System("stone")
        >>> m = s.parameters(m=1.0)
        >>> fall = s.slider("fall", s.ground, s.body("stone", fb.particle(m)), axis="y", coordinate="y")
        >>> s.gravity = (0, -9.81, 0)
        >>> lanes = fb.sample({"y'": (1, 3), "m": (1, 2)}, n=1)
        >>> f = fb.study(s, until=1, lanes=lanes, outputs="max(y)").as_function()
        >>> f.names, f.outputs
        (("y'", 'm'), ('max(y)',))
        >>> f([2.0, 1.0]).round(6), f([[2.0, 3.0], [1.0, 1.0]]).round(6)
        (np.float64(0.203874), array([0.203874, 0.458716]))
        >>> indices = sobol_indices(func=f, n=1024, dists=f.distributions, random_state=1)
        >>> abs(indices.first_order).round(1), indices.total_order.round(1)
        (array([1., 0.]), array([1., 0.]))
        """
        return StudyFunction(self, executor, failed, threads, progress)

    def isel(self, lane: Any) -> Any:
        """Return the motion of one lane, or the study of some lanes.

        Parameters
        ----------
        lane : int, slice or sequence of int
            Numbers of lanes; negative numbers count from the end.

        Returns
        -------
        Trajectory
            For one number: the whole motion, to be drawn and asked.
        Study
            For a slice or several numbers.

        Raises
        ------
        SimulationError
            There is no such lane.
        """
        if isinstance(lane, slice):
            lanes = range(self.count)[lane]
            if not lanes:
                raise SimulationError(
                    f"Expected a slice with lanes among 0 to {self.count - 1}, got {lane!r}."
                )
            numbers = np.arange(lanes.start, lanes.stop, lanes.step)
            return replace(self, lanes=Chosen(self.lanes, numbers))
        numbers = np.asarray(lane)
        if numbers.dtype.kind not in "iu" or numbers.ndim > 1 or not numbers.size:
            raise SimulationError(f"Expected the number of a lane, several, or a slice, got {lane!r}.")
        if numbers.min() < -self.count or numbers.max() >= self.count:
            raise SimulationError(f"Expected lanes from 0 to {self.count - 1}, got {lane!r}.")
        numbers = np.where(numbers < 0, numbers + self.count, numbers)
        if numbers.ndim:
            return replace(self, lanes=Chosen(self.lanes, numbers))
        values, initial = self._source.arguments(int(numbers), int(numbers) + 1)
        names = self.lanes.names
        values, initial = (
            {name: float(x[0]) if name in names else x for name, x in part.items()}
            for part in (values, initial)
        )
        return simulate(self.machine, self.until, values=values, initial=initial, **self.options)
