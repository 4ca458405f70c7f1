"""A limit on the time of an answer."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from time import monotonic
from typing import Any


class OutOfTimeError(Exception):
    """Raised if an answer takes too long."""


@contextmanager
def within(deadline: float | None) -> Iterator[None]:
    """Stop the block at a time of the monotonic clock, if the system has timers and this is the main thread.

    Raises
    ------
    OutOfTimeError
        At the deadline.
    """
    if deadline is None:
        yield
        return
    remaining = deadline - monotonic()
    if remaining <= 0:
        raise OutOfTimeError
    if not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(*_: Any) -> None:
        raise OutOfTimeError

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, remaining)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
