"""What Python does while compiled code runs: it looks at the keyboard, and shows how much of a run is done.

Python notes Ctrl-C only between its own instructions. So code that may take long runs in a thread, the main thread
waits for it, and at Ctrl-C writes into the memory of the code that it is to stop (:class:`Halt`). The code looks there
at every step.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from functools import cached_property
from threading import get_ident
from time import perf_counter
from types import TracebackType
from typing import Any

from ...errors import SimulationError

_PATIENCE = 1.0  # seconds before the bar appears
SHORT = 0.02
"""Seconds that compiled code runs in the thread that called it: a change of threads takes about 1e-4 s."""
GLANCE = 0.05
"""Seconds between two looks at how far the code is."""


class HaltedError(BaseException):
    """Ends a run in a thread. Nothing of it is kept, so no trajectory is made of it, as of interrupted runs."""


class Halt:
    """Ends runs, in whichever threads they are."""

    def __init__(self) -> None:
        self.pressed = False
        self.records: dict[int, tuple[Any, ...]] = {}

    def watch(self, *records: Any) -> None:
        """Note the memory of the run of this thread: a ``stop`` that is not 0 ends its loops."""
        self.records[get_ident()] = records
        for record in records:
            record.stop = int(self.pressed)

    def press(self) -> None:
        """End all runs."""
        self.pressed = True
        for records in list(self.records.values()):
            for record in records:
                record.stop = 1


class Progress:
    """Context in which ``progress(t)`` shows how much of a run from ``start`` to ``until`` is done.

    ``display`` None shows a bar on a terminal only; a function is called with the part that is done, 0 to 1. A
    :class:`Halt` shows nothing, and ends the run when another thread says so.
    """

    bar: Any = None
    task: Any = None
    pool: ThreadPoolExecutor | None = None

    def __init__(
        self, start: float, until: float, display: bool | Callable[[float], Any] | Halt | None
    ) -> None:  # fmt: skip
        self.watched = False
        if isinstance(display, Halt):
            self.watched, self.halt, display = True, display, False  # by another thread
        if not (display is None or isinstance(display, bool) or callable(display)):
            raise SimulationError(
                f"Expected True, False, or a function of the part that is done for progress=, got {display!r}."
            )
        self.start, self.until, self.display = start, until, display
        self.clock = self.looked = perf_counter()

    @cached_property
    def halt(self) -> Halt:
        """What ends the run: made when it is first needed, since short runs take less than that."""
        return Halt()

    def __enter__(self) -> Progress:
        return self

    @property
    def shown(self) -> bool:
        """True if a long run shows a bar."""
        if self.display is None:
            return sys.stderr.isatty()
        return self.display is True

    def __call__(self, t: float) -> None:
        """Show the part of the run that is done at a time; raise HaltedError if another thread ends it."""
        if self.watched:
            if self.halt.pressed:
                raise HaltedError
            return
        part = (t - self.start) / (self.until - self.start)
        if callable(self.display):
            self.display(part)
        if perf_counter() - self.clock < _PATIENCE or not self.shown:
            return
        if self.bar is None:
            from rich.console import Console
            from rich.progress import BarColumn, TextColumn, TimeRemainingColumn
            from rich.progress import Progress as Bar

            console = Console(stderr=True, force_terminal=True if self.display is True else None)
            columns = (TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn())
            self.bar = Bar(*columns, console=console, transient=True)
            self.bar.start()
            self.task = self.bar.add_task("simulating", total=1.0)
        self.bar.update(
            self.task, completed=part, description=f"simulating, t = {t:.4g} of {self.until:.4g} s"
        )

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
        if self.pool is not None:
            self.pool.shutdown()

    @property
    def is_long(self) -> bool:
        """True if the run has taken so long that what follows is worth a thread."""
        return perf_counter() - self.clock > SHORT

    def result(self, now: Callable[[], float], code: Callable[..., Any], *arguments: Any) -> Any:
        """Return the result of compiled code that may take long, and show meanwhile how far it is, ``now()``.

        An exception in Python, such as that of Ctrl-C, ends the code early.
        """
        if self.watched:
            return code(*arguments)
        if self.pool is None:
            self.pool = ThreadPoolExecutor(1, thread_name_prefix="freebody")
        task = self.pool.submit(code, *arguments)
        try:
            while not wait([task], GLANCE).done:
                self._look(now())
            if perf_counter() - self.looked > GLANCE:  # many short pieces
                self._look(now())
        except BaseException:
            self.halt.press()
            wait([task])
            raise
        return task.result()

    def _look(self, t: float) -> None:
        self.looked = perf_counter()
        self(t)

    def close(self) -> None:
        """Remove the bar."""
        if self.bar is not None:
            self.bar.stop()
