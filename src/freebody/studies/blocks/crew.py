"""Who runs the blocks: this process, an executor with ``submit``, or a cluster.

A crew takes tasks and puts how they ended into a queue. Executors differ in how many tasks they should hold, in how
they say that a worker died, and in whether they live on after it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, ProcessPoolExecutor
from queue import Empty, SimpleQueue
from typing import Any

from .block import Delivery, Report, Whole, run_block

_DEATHS = ("KilledWorker", "TerminatedWorkerError", "WorkerCrashedError", "NodeDiedError", "OutOfMemoryError")
"""Errors of libraries that tell of a worker that died; those of concurrent.futures are `BrokenExecutor`."""
_GONE = ("CommClosedError", "FutureCancelledError", "CancelledError", "ClosedClientError")
"""Errors of libraries that tell of a cluster that is gone."""


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


class Here:
    """The process itself: blocks one after the other, each shared by its threads.

    ``ready``   has ``run`` of `block.Ready`
    """

    room = 1
    workers = 1

    delivery: Delivery = Whole()

    def __init__(self, ready: Any, source: Any, between: Callable[[float], None]) -> None:
        self.ready, self.source, self.between = ready, source, between

    def start(self, low: int, high: int) -> None:
        """Do nothing: a block runs when it is waited for."""
        self.block = (low, high)

    def wait(self, seconds: float) -> tuple[tuple[int, int], Report | BaseException] | None:
        """Run the block that was started."""
        low, high = self.block
        return self.block, self.ready.run(
            self.delivery, self.source, low, high, lambda lane: self.between(lane - low)
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
        self.ended: SimpleQueue[tuple[tuple[int, int], Any]] = SimpleQueue()
        self.running: dict[tuple[int, int], Any] = {}
        self.own: Executor | None = None
        self.client = hasattr(executor, "scatter") and hasattr(executor, "nthreads")
        if self.client:
            self.sent = executor.scatter(work, broadcast=True, hash=False)

    @property
    def workers(self) -> int:
        """Number of workers that run at once, as far as the executor says it."""
        if self.client:
            return max(1, sum(self.executor.nthreads().values()))
        for name in ("_max_workers", "num_workers"):
            number = getattr(self.executor, name, None)
            if isinstance(number, int) and number > 0:
                return number
        return 64

    @property
    def room(self) -> int:
        """Number of tasks that the executor should hold: those that run, and some that can start at once.

        Of a pool of processes that lost one, tasks that were cancelled while they waited end the thread that should
        end the other processes, for which the program then waits (python/cpython#107219): one waits, no more.
        """
        return 2 * self.workers + 2 if self.client else self.workers + 1

    def start(self, low: int, high: int) -> None:
        """Give a block to the executor.

        Raises
        ------
        GoneError
            The executor takes no more tasks.
        """
        part = self.source.part(low, high) if self.work else self.source
        arguments = (self.delivery, None if self.work and part is self.source else part, low, high)
        try:
            if not self.work:
                task = self.executor.submit(self.ready.run, *arguments)
            elif self.client:
                task = self.executor.submit(
                    run_block, self.key, self.sent, *arguments, pure=False,
                    key=f"{prefix_of(self.name)}-{self.key[:8]}-{low}-{high}-{id(arguments)}",
                )  # fmt: skip
            else:
                task = self.executor.submit(run_block, self.key, self.work, *arguments)
        except BrokenExecutor as error:
            self.ended.put(((low, high), error))
            return
        except Exception as error:
            raise GoneError(f"{type(error).__name__}: {error}") from error
        self.running[low, high] = task
        task.add_done_callback(lambda task: self.ended.put(((low, high), task)))

    def wait(self, seconds: float) -> tuple[tuple[int, int], Report | BaseException] | None:
        """Return a block that has ended and its report, or its error; None if none ends in this time."""
        try:
            block, task = self.ended.get(timeout=seconds)
        except Empty:
            return None
        self.running.pop(block, None)
        if isinstance(task, BaseException):
            return block, task
        try:
            return block, task.result()
        except (Exception, SystemExit) as error:
            return block, error
        except BaseException as error:  # dask's CancelledError is no Exception
            if gone(error):
                return block, error
            raise

    def renew(self) -> bool:
        """Return True if the executor runs again after a worker died; a pool of processes is made anew."""
        old: Any = self.executor
        if self.client:
            return True
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
