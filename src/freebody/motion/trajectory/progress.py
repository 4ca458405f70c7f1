"""A progress bar for runs that take longer than a second."""

from __future__ import annotations

import sys
from collections.abc import Callable
from time import perf_counter
from types import TracebackType
from typing import Any

from ...errors import SimulationError

_PATIENCE = 1.0  # seconds before the bar appears


class Progress:
    """Context in which ``progress(t)`` shows how much of a run from ``start`` to ``until`` is done.

    ``display`` None shows a bar on a terminal only; a function is called with the part that is done, 0 to 1.
    """

    bar: Any = None
    task: Any = None

    def __init__(self, start: float, until: float, display: bool | Callable[[float], Any] | None) -> None:
        if not (display is None or isinstance(display, bool) or callable(display)):
            raise SimulationError(
                f"Expected True, False, or a function of the part that is done for progress=, got {display!r}."
            )
        self.start, self.until, self.display, self.clock = start, until, display, perf_counter()

    def __enter__(self) -> Progress:
        return self

    @property
    def shown(self) -> bool:
        """True if a long run shows a bar."""
        if self.display is None:
            return sys.stderr.isatty()
        return self.display is True

    def __call__(self, t: float) -> None:
        """Show the part of the run that is done at a time."""
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

    def close(self) -> None:
        """Remove the bar."""
        if self.bar is not None:
            self.bar.stop()
