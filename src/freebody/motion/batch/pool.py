"""Lanes that an executor runs: blocks of them, each a batch of its own, in processes or on other computers.

A block that fails, with its process or by itself, costs its lanes only: the others are given back, and each lane that
was not run says why.
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
from .alone import REASON
from .store import TEXTS

_PATIENCE = 2.0  # seconds after Ctrl-C in which blocks that are run may give back the lanes that are done
_BLOCKS = 64  # at least, so that they come evenly


def check_executor(executor: Any, model: Any, task: tuple[Any, ...]) -> None:
    """Refuse what is no executor, and what a pool of processes can not be handed over.

    Raises
    ------
    SimulationError
        The controller, or what else only this process knows, before anything is run.
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
    for one in model.controllers:
        reason = _unsendable(one.function)
        if reason is not None:
            raise SimulationError(
                f"Expected a controller that other processes find by its name, for executor=ProcessPoolExecutor, but "
                f"'{one.name}' is {one.function!r}: {reason}. Define it with def at the top level of a module (what "
                f"it holds may be attributes of an object of a class there), {cure}"
            )
    raise SimulationError(
        f"Expected a machine and options that other processes can be given, for executor=ProcessPoolExecutor, but "
        f"'{model.name}' can not be pickled: {error}. Make it of numbers, expressions and functions at the top "
        f"level of a module, {cure}"
    )


def _unsendable(x: Any) -> str | None:
    """Why something can not be pickled."""
    try:
        pickle.dumps(x)
    except Exception as error:  # whatever the classes of a user raise
        return f"{type(error).__name__}: {error}".rstrip(".")
    return None


class Elsewhere:
    """The blocks of a batch, by an executor.

    ``reasons``   of lanes that were not run, by number: why
    ``error``     the first failure
    """

    def __init__(self, executor: Any, job: Any, task: tuple[Any, Any, Mapping[str, Any]]) -> None:
        self.executor, self.job, self.task = executor, job, task
        self.reasons: dict[int, str] = {}
        self.error: BaseException | None = None

    def run(
        self, blocks: Iterator[tuple[int, int]], take: Callable[[Any], None], between: Callable[[float], None]
    ) -> None:
        """Hand over all blocks; ``take`` gets the results of each, as they come, ``between`` how many are done."""
        count = self.job.given.count
        parts = []
        for first, last in blocks:
            size = max(1, min(last - first, -(-count // _BLOCKS)))
            parts += [(low, min(low + size, last)) for low in range(first, last, size)]
        done = count - sum(high - low for low, high in parts)
        left = iter(parts)
        # what is handed over is begun at once: in a pool that loses a process, a task that waits and is cancelled ends
        # the thread that would end the other processes (python/cpython#107219), and the program then waits for them
        room = getattr(self.executor, "_max_workers", 64) + 1
        running: dict[Any, tuple[int, int]] = {}
        try:
            while True:
                for low, high in islice(left, room - len(running)):
                    try:
                        running[self.executor.submit(_block, *self._part(low, high))] = low, high
                    except RuntimeError as error:  # the executor takes no more
                        for first, last in ((low, high), *left):
                            self._lose(first, last, error, "not begun")
                if not running:
                    return
                for task in wait(running, return_when=FIRST_COMPLETED).done:
                    part = self._result(task, *running.pop(task))
                    if part is not None:
                        take(part)
                        done += len(part.waiting) - int(part.waiting.sum())
                        between(float(done))
                        if part.waiting.any():  # a process that heard the keyboard before this one
                            raise KeyboardInterrupt
        except (
            KeyboardInterrupt
        ):  # other blocks that are done are kept, and what those give back that hear of it
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
        s, until, asked = self.task
        values, initial = self.job.given.part(np.arange(low, high))
        return s, until, {**asked, "values": values, "initial": initial}, low

    def _result(self, task: Any, low: int, high: int) -> Any:
        try:
            return task.result()
        except (Exception, SystemExit) as error:
            self._lose(low, high, error, "not finished")
            return None

    def _lose(self, low: int, high: int, error: BaseException, how: str) -> None:
        self.error = self.error or error
        reason = f"{how}: {type(error).__name__}: {error}"
        if isinstance(error, BrokenExecutor):
            reason = (
                f"{how}: a process of the pool ended abruptly, by a signal, for want of memory, or where it could not "
                f"find what it was given ({type(error).__name__})"
            )
        self.reasons |= dict.fromkeys(range(low, high), reason)

    def tell(self, data: Any) -> None:
        """Note in the results which lanes were lost, and why.

        Raises
        ------
        SimulationError
            There is no other.
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


def _block(s: Any, until: Any, options: dict[str, Any], low: int) -> Any:
    """Some lanes, in another process; after Ctrl-C those that are done."""
    from .batch import Results, job_of

    job = job_of(s, until, threads=1, **options)
    part = Results.of(job, 0, job.given.count)
    try:
        job.run(part, lambda _: None)
    except KeyboardInterrupt:
        part.clear(np.flatnonzero(part.waiting))
    return replace(part, low=low, high=low + job.given.count)
