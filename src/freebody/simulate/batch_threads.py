"""Lanes shared between threads, in chunks short enough to notice the keyboard between them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
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
    with ThreadPoolExecutor(len(rooms), thread_name_prefix="freebody") as pool:
        while place < len(lanes):
            clock = perf_counter()
            size = min(size, -(-(len(lanes) - place) // len(rooms)))
            tasks = []
            for room in rooms:
                tasks.append(pool.submit(chunk, lanes[place : place + size], room))
                place += size
            for task in tasks:
                task.result()
            size = _next(size, perf_counter() - clock, largest)
            between(min(place, len(lanes)))


def _next(size: int, seconds: float, largest: int) -> int:
    """Lanes of the next chunk: about as many as fit between two looks at the keyboard."""
    return int(max(1, min(4 * size, largest, 1 + size * _PIECE / max(seconds, 1e-6))))
