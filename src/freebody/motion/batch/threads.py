"""Lanes shared between threads, in chunks short enough to notice the keyboard between them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

_PIECE = 0.25  # seconds between two looks at the keyboard


def share(
    lanes: NDArray[np.int64],
    chunk: Callable[[NDArray[np.int64], Any], None],
    rooms: Sequence[Any],
    size: int,
    largest: int,
    between: Callable[[int], None],
) -> None:
    """Run ``chunk(some lanes, room)`` until all lanes are done, one thread for each of the rooms.

    The first chunks have ``size`` lanes, none has more than ``largest``; ``between`` is told how many lanes are done.
    """
    place = 0
    if len(rooms) == 1:
        while place < len(lanes):
            clock = perf_counter()
            chunk(lanes[place : place + size], rooms[0])
            place += size
            size = _next(size, perf_counter() - clock, largest)
            between(min(place, len(lanes)))
        return
    free, running, done = list(rooms), dict[Future[float], tuple[Any, int]](), 0

    def timed(some: NDArray[np.int64], room: Any) -> float:
        clock = perf_counter()
        chunk(some, room)
        return perf_counter() - clock

    with ThreadPoolExecutor(len(rooms), thread_name_prefix="freebody") as pool:
        while place < len(lanes) or running:
            while free and place < len(lanes):
                some = lanes[place : place + min(size, -(-(len(lanes) - place) // len(rooms)))]
                room = free.pop()
                running[pool.submit(timed, some, room)] = room, len(some)
                place += len(some)
            for task in wait(running, return_when=FIRST_COMPLETED).done:
                room, count = running.pop(task)
                size = _next(count, task.result(), largest)
                free.append(room)
                done += count
                between(done)


def _next(size: int, seconds: float, largest: int) -> int:
    """Lanes of the next chunk: about as many as fit between two looks at the keyboard."""
    return int(max(1, min(4 * size, largest, 1 + size * _PIECE / max(seconds, 1e-6))))
