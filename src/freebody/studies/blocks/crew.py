"""Who runs the blocks: this process, an executor with ``submit``, or a cluster.

A crew takes tasks and puts how they ended into a queue. Executors differ in how many tasks they should hold, in how
they say that a worker died, and in whether they live on after it.
"""

from __future__ import annotations

import hashlib
import pickle
from collections import deque
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, ProcessPoolExecutor
from contextlib import suppress
from queue import Empty, SimpleQueue
from time import perf_counter
from typing import Any

from .block import Delivery, Report, Whole, packed_block, run_block, same

_DEATHS = ("KilledWorker", "TerminatedWorkerError", "WorkerCrashedError", "NodeDiedError", "OutOfMemoryError")
"""Errors of libraries that tell of a worker that died; those of concurrent.futures are `BrokenExecutor`."""
_GONE = ("CommClosedError", "FutureCancelledError", "CancelledError", "ClosedClientError")
"""Errors of libraries that tell of a cluster that is gone."""


_MESSAGE = 64  # tasks that a scheduler holds at least, half of which are sent at once
_REFRESH = 1.0  # seconds between two questions how many workers there are


class GoneError(Exception):
    """The executor takes no more tasks."""


def died(error: BaseException) -> bool:
    """Return True if an error tells of a worker that died."""
    return isinstance(error, BrokenExecutor) or type(error).__name__ in _DEATHS


def gone(error: BaseException) -> bool:
    """Return True if an error tells of an executor that is gone."""
    return isinstance(error, GoneError) or type(error).__name__ in _GONE


def prefix_of(name: str) -> str:
    """Return the name of a machine as the first part of dask's keys, by which its dashboard names tasks.

    dask cuts keys at "-", and at "," of names that begin with another sign than a letter.
    """
    return name.replace("-", "_").replace(",", "_") or "study"


Range = tuple[int, int]
"""First lane of a block, and the lane behind its last."""


class Here:
    """The process itself: blocks one after the other, each shared by its threads.

    ``ready``   has ``run`` of `block.Ready`
    """

    room = 1
    low = 0
    workers = 1

    delivery: Delivery = Whole()

    def __init__(self, ready: Any, source: Any, between: Callable[[float], None]) -> None:
        self.ready, self.source, self.between = ready, source, between

    def start(self, low: int, high: int) -> None:
        """Do nothing: a block runs when it is waited for."""
        self.block = (low, high)

    def wait(self, seconds: float) -> tuple[Range, Report | BaseException] | None:
        """Run the block that was started."""
        low, high = self.block
        return self.block, self.ready.run(
            low, high, self.delivery, self.source, lambda lane: self.between(lane - low)
        )

    def renew(self) -> bool:
        """Return False."""
        return False

    def cancel(self) -> None:
        """Do nothing."""

    def close(self) -> None:
        """Do nothing."""


class Crew:
    """The workers of an executor.

    ``work``     pickled work of the study; None if the workers are threads of this process, which share ``ready``
    ``source``   values of its lanes
    ``name``     of the study, for those who watch the workers
    """

    delivery: Delivery = Whole()

    def __init__(self, executor: Any, ready: Any, work: bytes | None, source: Any, name: str) -> None:
        self.executor: Any = executor
        self.ready, self.source, self.name = ready, source, name
        self.work = work or b""
        self.key = hashlib.sha256(self.work).hexdigest()
        self.ended: SimpleQueue[tuple[Range, Any]] = SimpleQueue()
        self.running: dict[Range, Any] = {}
        self.own: Executor | None = None

    @property
    def workers(self) -> int:
        """Number of workers that run at once, as far as the executor says it."""
        for name in ("_max_workers", "num_workers"):
            number = getattr(self.executor, name, None)
            if isinstance(number, int) and number > 0:
                return number
        return 64

    @property
    def room(self) -> int:
        """Number of tasks that the executor should hold: those that run, and one that can start at once.

        Of a pool of processes that lost one, tasks that were cancelled while they waited end the thread that should
        end the other processes, for which the program then waits (python/cpython#107219): one waits, no more.
        """
        return self.workers + 1

    @property
    def low(self) -> int:
        """Number of tasks at which the executor gets more: whenever one has ended."""
        return self.room - 1

    def start(self, low: int, high: int) -> None:
        """Give a block to the executor.

        Raises
        ------
        GoneError
            The executor takes no more tasks.
        """
        arguments = (low, high, self.delivery, self._lanes(low, high))
        try:
            if not self.work:
                task = self.executor.submit(self.ready.run, *arguments)
            else:
                task = self.executor.submit(run_block, *arguments, self.key, self.work)
        except BrokenExecutor as error:
            self.ended.put(((low, high), error))
            return
        except Exception as error:
            raise GoneError(f"{type(error).__name__}: {error}") from error
        self._follow((low, high), task)

    def _lanes(self, low: int, high: int) -> Any:
        """Return the source that is sent with a block; None if the worker has it."""
        part = self.source.part(low, high) if self.work else self.source
        return None if self.work and part is self.source else part

    def _follow(self, block: Range, task: Any) -> None:
        self.running[block] = task
        task.add_done_callback(lambda task: self.ended.put((block, task)))

    def wait(self, seconds: float) -> tuple[Range, Report | BaseException] | None:
        """Return a block that has ended and its report, or its error; None if none ends in this time."""
        try:
            block, task = self.ended.get(timeout=seconds)
        except Empty:
            return None
        return self._outcome(block, task)

    def _outcome(self, block: Range, task: Any) -> tuple[Range, Report | BaseException]:
        self.running.pop(block, None)
        if isinstance(task, BaseException):
            return block, task
        try:
            report = task.result()
            return block, pickle.loads(report) if isinstance(report, bytes) else report
        except (Exception, SystemExit) as error:
            return block, error
        except BaseException as error:  # dask's CancelledError is no Exception
            if gone(error):
                return block, error
            raise

    def renew(self) -> bool:
        """Return True if the executor runs again after a worker died; a pool of processes is made anew."""
        old: Any = self.executor
        if type(old).__module__.startswith("loky"):
            from loky import get_reusable_executor  # type: ignore[import-untyped, unused-ignore]

            self.executor = get_reusable_executor(old._max_workers)
            return True
        if issubclass(type(old), ProcessPoolExecutor):
            self.close()
            self.own = ProcessPoolExecutor(
                old._max_workers, mp_context=old._mp_context, initializer=old._initializer,
                initargs=old._initargs,
            )  # fmt: skip
            self.executor = self.own
            return True
        return False

    def cancel(self) -> None:
        """Cancel blocks that have not begun."""
        for task in self.running.values():
            task.cancel()

    def close(self) -> None:
        """End the pool that replaced the user's."""
        if self.own is not None:
            self.own.shutdown(wait=False, cancel_futures=True)


class Cluster(Crew):
    """The workers of a dask cluster, which are many: blocks go to the scheduler, and come back, several at a time.

    A message to the scheduler, and one for results, take about as long as the fixed cost of four blocks.
    """

    def __init__(self, executor: Any, ready: Any, work: bytes, source: Any, name: str) -> None:
        super().__init__(executor, ready, work, source, name)
        # a task, since what is scattered is lost with the workers that hold it, and tasks then wait without end
        self.sent = executor.submit(
            same, work, key=f"{prefix_of(name)}-{self.key[:8]}-work-{id(self)}", pure=False
        )
        self.begun: list[Range] = []
        self.outcomes: deque[tuple[Range, Report | BaseException]] = deque()
        self.count = 0
        self.threads, self.due = 1, 0.0

    @property
    def workers(self) -> int:
        """Number of workers that run at once; the scheduler is asked now and then, since clusters grow and shrink."""
        if perf_counter() > self.due:
            with suppress(OSError):  # a scheduler that is gone says so when it is given a task
                self.threads = max(1, sum(self.executor.nthreads().values()))
            self.due = perf_counter() + _REFRESH
        return self.threads

    @property
    def room(self) -> int:
        """Number of tasks that the scheduler should hold; few workers get as many as make a message worth its cost."""
        return max(_MESSAGE, 8 * self.workers)

    @property
    def low(self) -> int:
        """Number of tasks at which the scheduler gets more."""
        return self.room // 2

    def start(self, low: int, high: int) -> None:
        """Note a block, which is sent with others."""
        self.begun.append((low, high))

    def _send(self) -> None:
        """Send the blocks that were begun, in one message."""
        blocks, self.begun = self.begun, []
        names = [
            f"{prefix_of(self.name)}-{self.key[:8]}-{low}-{high}-{self.count + k}"
            for k, (low, high) in enumerate(blocks)
        ]
        self.count += len(blocks)
        lows, highs = zip(*blocks, strict=True)
        lanes = [self._lanes(low, high) for low, high in blocks]
        try:
            tasks = self.executor.map(
                packed_block, lows, highs, [self.delivery] * len(blocks), lanes, key=names, pure=False,
                work_key=self.key, work=self.sent,
            )  # fmt: skip
        except Exception as error:
            gone = GoneError(f"{type(error).__name__}: {error}")
            gone.__cause__ = error
            self.outcomes.extend((block, gone) for block in blocks)
            return
        for block, task in zip(blocks, tasks, strict=True):
            self._follow(block, task)

    def wait(self, seconds: float) -> tuple[Range, Report | BaseException] | None:
        """Return a block that has ended and its report, or its error; None if none ends in this time."""
        if self.begun:
            self._send()
        if not self.outcomes:
            try:
                ended = [self.ended.get(timeout=seconds)]
            except Empty:
                return None
            while not self.ended.empty():
                ended.append(self.ended.get())
            self._gather(ended)
        return self.outcomes.popleft()

    def _gather(self, ended: list[tuple[Range, Any]]) -> None:
        """Fetch the results of tasks that have ended, in one message."""
        good = [(block, task) for block, task in ended if task.status == "finished"]
        try:
            reports = self.executor.gather([task for _, task in good])
        except BaseException as error:  # one by one, each gives its own error
            if isinstance(error, KeyboardInterrupt):
                raise
            good, reports = [], []
        blocks = [block for block, _ in good]
        for block in blocks:
            self.running.pop(block, None)
        self.outcomes.extend(
            (block, pickle.loads(report)) for block, report in zip(blocks, reports, strict=True)
        )
        self.outcomes.extend(self._outcome(block, task) for block, task in ended if block not in set(blocks))

    def cancel(self) -> None:
        """Cancel blocks that have not begun."""
        self.outcomes.extend((block, GoneError("cancelled")) for block in self.begun)
        self.begun = []
        if self.running:
            with suppress(Exception):  # a scheduler that is gone has no tasks
                self.executor.cancel(list(self.running.values()))

    def renew(self) -> bool:
        """Return True: a scheduler starts tasks on other workers."""
        return True


def crew_of(executor: Any, ready: Any, work: bytes | None, source: Any, name: str) -> Crew:
    """Return the workers of an executor."""
    if hasattr(executor, "scatter") and hasattr(executor, "nthreads"):
        return Cluster(executor, ready, work or b"", source, name)
    return Crew(executor, ready, work, source, name)
