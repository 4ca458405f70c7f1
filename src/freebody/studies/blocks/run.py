"""A study run from the first block to the last: who runs it, how it is cut, what is kept, and what is told."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol

from ...errors import SimulationError
from ...motion.batch.interruption import Keyboard
from ...motion.batch.job import Job
from ...native.records import WIDTH
from .block import Delivery, Report
from .crew import Here, crew_of
from .cutting import FEW, SHARES, cut, growing, seconds_per_lane, size_of_block
from .executors import executor_of
from .schedule import Range, Trouble, run_blocks, shuffled
from .tally import Tally

if TYPE_CHECKING:
    import xarray


class Sink(Protocol):
    """Where the results of blocks are kept."""

    delivery: Delivery

    def missing(self, blocks: Sequence[Range]) -> Iterable[Range]:
        """Return the ranges of lanes that are waiting."""

    def receive(self, report: Report) -> None:
        """Take the report of a block."""

    def lose(self, lost: dict[int, str]) -> None:
        """Note lanes that are lost, and why."""

    def enough(self) -> bool:
        """Return True if the lanes of a stage are enough."""

    def dataset(self) -> xarray.Dataset:
        """Return the results."""


def run(
    ready: Any, source: Any, executor: Any, sink_of: Callable[[int], Sink], *, size: int | None = None,
    in_order: bool = False, progress: Any = None, pack: Callable[[], bytes] = bytes,
    stages: Iterable[int] | None = None,
) -> xarray.Dataset:  # fmt: skip
    """Run the blocks of a study, and return its results.

    Parameters
    ----------
    ready : object with ``job`` and ``run`` of `block.Ready`
    source : ByLaw or ByArrays
        Values of the lanes.
    executor : Executor, text or None
    sink_of : function
        Returns the sink, from the number of lanes of a block.
    size : int, optional
        Number of lanes of a block; measured if it is not given.
    in_order : bool
        True to run blocks in the order of the lanes, the first ones small, instead of trying some lanes first.
    progress : bool or function, optional
    pack : function
        Returns what an executor is sent.
    stages : iterable of int, optional
        Numbers of lanes, the first of the study, after which the sink is asked whether these are enough; one crew runs
        all stages. All lanes in one stage if they are not given.

    Raises
    ------
    SimulationError
        No lane was run.
    """
    import_module("xarray").Dataset(
        coords={"lane": [0]}
    )  # loaded before the first lane: no Ctrl-C waits for it
    job: Job = ready.job
    whole = (job.count,) if stages is None else tuple(stages)
    tally = Tally(whole[0], progress)
    sink: Sink | None = None
    trouble: Trouble | None = None
    with executor_of(executor) as workers, Keyboard() as keyboard, tally:

        def check() -> None:
            tally.show()
            keyboard.check()

        def between(done: float) -> None:
            tally.within(done)
            keyboard.check()

        def receive(report: Report) -> None:
            with keyboard.held():
                sink.receive(report)  # type: ignore[union-attr]

        crew: Any = Here(ready, source, between)
        if workers is not None:
            work = None if isinstance(workers, ThreadPoolExecutor) else pack()
            crew = crew_of(workers, ready, work, source, job.kernels.model.name)
        try:
            keyboard.listening = True
            if size is None and not in_order:
                seconds = seconds_per_lane(crew, whole[-1], check) if whole[-1] > FEW else None
                size = size_of_block(whole[-1], seconds, crew.workers, job.bytes_per_lane)
            sink = sink_of(size or job.count)
            crew.delivery = sink.delivery
            for count in whole:
                step = size or count
                if len(whole) > 1:  # all workers take part in a short stage
                    step = min(step, max(WIDTH, -(-count // (SHARES * crew.workers))))
                missing = list(sink.missing(cut(count, step)))
                tally.begin(count, count - sum(high - low for low, high in missing))
                blocks: Iterable[Range] = shuffled(missing)
                if in_order and size is None:
                    first = FEW // crew.workers if job.looped else 1
                    blocks = growing(missing, max(1, first), count, job.bytes_per_lane, crew, tally)
                trouble = run_blocks(crew, blocks, receive, tally, check)
                if trouble.lost:
                    sink.lose(trouble.lost)
                if trouble.error is not None or (count < whole[-1] and sink.enough()):
                    break
            keyboard.listening = False
        except KeyboardInterrupt:
            keyboard.listening = False
            sink, trouble = sink or sink_of(size_of_block(job.count, None, 1, job.bytes_per_lane)), None
        finally:
            crew.close()
        if trouble is not None and not tally.before + tally.run:
            _refuse_lost(trouble, tally.total)
        return _told(sink.dataset(), trouble, tally.total)


def _refuse_lost(trouble: Trouble, count: int) -> None:
    """Refuse a study of which no lane was run, and tell why the first was not."""
    first = next(iter(trouble.lost.values()), None) or trouble.reason
    if first:
        raise SimulationError(f"No lane of {count} was run; the first was {first}.") from trouble.error


def _told(data: xarray.Dataset, trouble: Trouble | None, count: int) -> xarray.Dataset:
    """Return a dataset whose attributes tell what kept lanes from being run."""
    if trouble is not None and trouble.lost:
        lane, reason = next(iter(trouble.lost.items()))
        data.attrs["lost"] = f"{len(trouble.lost)} of {count} lanes, the first {lane}: {reason}"
    if trouble is not None and trouble.error is not None and "interrupted" in data.attrs:
        data.attrs["interrupted"] += f"; {trouble.reason}"
    return data
