"""Lanes shared between threads, in chunks short enough to notice Ctrl-C between them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

_PIECE = 0.25  # seconds that a chunk takes


def share(
    lanes: NDArray[np.int64],
    chunk: Callable[[NDArray[np.int64], Any], None],
    memories: Sequence[Any],
    size: int,
    largest: int,
    between: Callable[[int], None],
    halt: Callable[[], None] | None = None,
) -> None:
    """Run ``chunk(lanes, memory)`` until all lanes are done, with one thread for each memory.

    The first chunks have ``size`` lanes, and none has more than ``largest``; ``between`` gets the number of lanes done.
    ``halt`` is called at Ctrl-C, and ends the lanes that run; one thread of its own is taken for it. Without it the
    threads end their chunks, and for a single memory there is none.
    """
    place = 0
    if len(memories) == 1 and halt is None:
        while place < len(lanes):
            clock = perf_counter()
            chunk(lanes[place : place + size], memories[0])
            place += size
            size = _next(size, perf_counter() - clock, largest)
            between(min(place, len(lanes)))
        return
    free, running, done = list(memories), dict[Future[float], tuple[Any, int]](), 0

    def timed(some: NDArray[np.int64], memory: Any) -> float:
        clock = perf_counter()
        chunk(some, memory)
        return perf_counter() - clock

    with ThreadPoolExecutor(len(memories), thread_name_prefix="freebody") as pool:
        try:
            while place < len(lanes) or running:
                while free and place < len(lanes):
                    some = lanes[place : place + min(size, -(-(len(lanes) - place) // len(memories)))]
                    memory = free.pop()
                    running[pool.submit(timed, some, memory)] = memory, len(some)
                    place += len(some)
                for task in wait(running, return_when=FIRST_COMPLETED).done:
                    memory, count = running.pop(task)
                    size = _next(count, task.result(), largest)
                    free.append(memory)
                    done += count
                    between(done)
        except KeyboardInterrupt:  # the pool waits for its threads
            if halt is not None:
                halt()
            raise


def _next(size: int, seconds: float, largest: int) -> int:
    """Return the number of lanes of the next chunk, which is to take about ``_PIECE`` seconds."""
    return int(max(1, min(4 * size, largest, 1 + size * _PIECE / max(seconds, 1e-6))))
