"""Lanes that an executor runs, in processes or on other computers: blocks of lanes, each a batch of its own.

A block that fails, by itself or with its process, loses its own lanes only: the results of other blocks come back, and
each lane that was not run tells why.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, ProcessPoolExecutor, wait
from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np

from ...errors import SimulationError
from ...motion.batch.dataset import TEXTS
from ...motion.batch.job import Job, job_of
from ...motion.batch.results import REASON, Results
from ...motion.batch.run import run_lanes

_PATIENCE = 2.0  # seconds after Ctrl-C in which running blocks may return the lanes that are done
_BLOCKS = 64  # least number of blocks, so that results come evenly


def check_executor(executor: Any, model: Any, task: tuple[Any, ...]) -> None:
    """Refuse an object that is no executor, and a task that a pool of processes cannot be sent.

    Raises
    ------
    SimulationError
        Before anything runs: names the controller, or other object, that only this process knows.
    """
    if isinstance(executor, type) or not hasattr(executor, "submit"):
        raise SimulationError(
            f"Expected an executor with submit(), such as concurrent.futures.ProcessPoolExecutor(), got {executor!r}."
        )
    if not isinstance(executor, ProcessPoolExecutor):
        return
    error = _unsendable(task)
    if error is None:
        return
    cure = "or run the lanes in this process: leave out executor=, or pass a concurrent.futures.ThreadPoolExecutor()."
    for controller in model.controllers:
        reason = _unsendable(controller.function)
        if reason is not None:
            raise SimulationError(
                f"Expected a controller that other processes find by its name, for executor=ProcessPoolExecutor, but "
                f"'{controller.name}' is {controller.function!r}: {reason}. Define it with def at the top level of a "
                f"module (what it holds may be attributes of an object of a class there), {cure}"
            )
    raise SimulationError(
        f"Expected a machine and options that can be sent to other processes, for executor=ProcessPoolExecutor, but "
        f"'{model.name}' cannot be pickled: {error}. Make it of numbers, expressions and functions at the top "
        f"level of a module, {cure}"
    )


def _unsendable(value: Any) -> str | None:
    """Return the reason why a value cannot be pickled; None if it can."""
    try:
        pickle.dumps(value)
    except Exception as error:  # classes of the user may raise anything
        return f"{type(error).__name__}: {error}".rstrip(".")
    return None


class Elsewhere:
    """The blocks of a batch, run by an executor.

    ``reasons``   why lanes were not run, by their number
    ``error``     the first failure
    """

    def __init__(self, executor: Any, job: Job, task: tuple[Any, Any, Mapping[str, Any]]) -> None:
        self.executor, self.job, self.task = executor, job, task
        self.reasons: dict[int, str] = {}
        self.error: BaseException | None = None

    def run(
        self,
        blocks: Iterator[tuple[int, int]],
        take: Callable[[Results], None],
        between: Callable[[float], None],
    ) -> None:
        """Run all blocks. ``take`` gets the results of each as they come, ``between`` the number of lanes done."""
        count = self.job.lanes.count
        parts = []
        for first, last in blocks:
            size = max(1, min(last - first, -(-count // _BLOCKS)))
            parts += [(low, min(low + size, last)) for low in range(first, last, size)]
        done = count - sum(high - low for low, high in parts)
        waiting_parts = iter(parts)
        # only tasks that start at once are submitted: if a pool loses a process, cancelling a task that waits ends the
        # thread that should end the other processes (python/cpython#107219), and the program then waits for them
        room = getattr(self.executor, "_max_workers", 64) + 1
        running: dict[Any, tuple[int, int]] = {}
        try:
            while True:
                for low, high in islice(waiting_parts, room - len(running)):
                    try:
                        running[self.executor.submit(_block, *self._part(low, high))] = low, high
                    except RuntimeError as error:  # the executor accepts no more tasks
                        for first, last in ((low, high), *waiting_parts):
                            self._lose(first, last, error, "not begun")
                if not running:
                    return
                for task in wait(running, return_when=FIRST_COMPLETED).done:
                    part = self._result(task, *running.pop(task))
                    if part is not None:
                        take(part)
                        done += len(part.waiting) - int(part.waiting.sum())
                        between(float(done))
                        if part.waiting.any():  # a process that received Ctrl-C before this one
                            raise KeyboardInterrupt
        except KeyboardInterrupt:  # keep finished blocks, and the lanes that interrupted blocks return
            wait(running, timeout=_PATIENCE)
            for task in [task for task in running if task.done() and not task.cancelled()]:
                if task.exception() is None:
                    take(task.result())
                    del running[task]
            raise
        finally:
            for task in running:
                task.cancel()

    def _part(self, low: int, high: int) -> tuple[Any, ...]:
        """Arguments of :func:`_block` for some lanes."""
        machine, until, options = self.task
        values, initial = self.job.lanes.part(np.arange(low, high))
        return machine, until, {**options, "values": values, "initial": initial}, low

    def _result(self, task: Any, low: int, high: int) -> Any:
        try:
            return task.result()
        except (Exception, SystemExit) as error:
            self._lose(low, high, error, "not finished")
            return None

    def _lose(self, low: int, high: int, error: BaseException, how: str) -> None:
        """Note why lanes were not run."""
        self.error = self.error or error
        reason = f"{how}: {type(error).__name__}: {error}"
        if isinstance(error, BrokenExecutor):
            reason = (
                f"{how}: a process of the pool ended abruptly, by a signal, for want of memory, or where it could not "
                f"find what it was given ({type(error).__name__})"
            )
        self.reasons |= dict.fromkeys(range(low, high), reason)

    def report_lost_lanes(self, data: Any) -> None:
        """Note in the dataset which lanes were lost, and why.

        Raises
        ------
        SimulationError
            All lanes were lost.
        """
        waiting = (data["status"] == "waiting").values
        lost = {lane: reason for lane, reason in self.reasons.items() if waiting[lane]}
        if not lost:
            return
        first = next(iter(lost.values()))
        if waiting.all():
            raise SimulationError(f"No lane was run; the first was {first}.") from self.error
        reasons = data[REASON].values.copy() if REASON in data else np.full(len(waiting), "", dtype=object)
        reasons[list(lost)] = list(lost.values())
        data[REASON] = ("lane", reasons, {"long_name": TEXTS[REASON]})
        data.attrs["interrupted"] += f"; {len(lost)} were lost, the first {first}"


def _block(machine: Any, until: Any, options: dict[str, Any], low: int) -> Results:
    """Return the results of some lanes, in another process; after Ctrl-C, those that are done."""
    job = job_of(machine, until, threads=1, **options)
    part = job.results(0, job.lanes.count)
    try:
        run_lanes(job, part, lambda _: None)
    except KeyboardInterrupt:
        part.clear(np.flatnonzero(part.waiting))
    return replace(part, low=low, high=low + job.lanes.count)
