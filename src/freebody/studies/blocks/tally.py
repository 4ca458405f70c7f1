"""How far a study is: lanes that are done, that failed and how, the rate, and the time that is left."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable
from time import perf_counter
from types import TracebackType
from typing import Any

from ...errors import SimulationError
from ...motion.ending import GOOD, STATUS, End
from .block import Report
from .line import NotebookLine, TerminalLine

_PATIENCE = 1.0  # seconds before the line appears


class State(float):
    """How far a study is: the part that is done, from 0 to 1, and what is known besides.

    ``done``, ``count``   number of lanes that have ended, and of all lanes
    ``failed``            number of lanes that failed, by their status
    ``rate``              lanes that end in a second
    ``remaining``         estimate of the time that is left [s]
    """

    done: int
    count: int
    failed: dict[str, int]
    rate: float
    remaining: float

    def __str__(self) -> str:
        failed = "".join(f", {n} {status}" for status, n in self.failed.items())
        left = "" if self.done == self.count else f", {spoken(self.remaining)} left"
        return f"{self.done:,} of {self.count:,} lanes{failed}, {self.rate:,.3g} lanes/s{left}"


def spoken(seconds: float) -> str:
    """Return a time in the unit that a reader would use."""
    for size, unit in ((86400.0, "d"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 2 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.2g} s" if seconds < 1 else f"{seconds:.3g} s"


def spoken_size(size: float) -> str:
    """Return a number of bytes in the unit that a reader would use."""
    for power, unit in ((4, "TB"), (3, "GB"), (2, "MB"), (1, "kB")):
        if size >= 1000**power:
            return f"{size / 1000**power:.3g} {unit}"
    return f"{size:.3g} bytes"


class Tally:
    """Context in which lanes are counted, and a line shows how far a long study is.

    ``display`` None shows the line on terminals and in notebooks only; a function is called with a `State`.
    """

    line: Any = None

    def __init__(
        self, count: int, display: bool | Callable[[State], Any] | None, task: str = "simulating"
    ) -> None:
        if not (display is None or isinstance(display, bool) or callable(display)):
            raise SimulationError(
                f"Expected True, False, or a function of the part that is done for progress=, got {display!r}."
            )
        self.total, self.task, self.display = count, task, display
        self.before = self.done = self.part = 0
        self.begun, self.run = False, 0
        self.worked = 0.0
        self.ended: Counter[int] = Counter()
        self.clock = perf_counter()

    def begin(self, count: int, done: int) -> None:
        """Begin to measure the rate of some lanes, of which so many were done before."""
        self.total = count
        self.before = self.done = done
        self.part = 0
        self.clock, self.begun = perf_counter(), True

    def count(self, report: Report) -> None:
        """Count the lanes of a block."""
        self.done += report.done
        self.run += report.done
        self.worked += report.seconds
        self.part = 0
        self.ended.update(report.ended)
        self.tell()

    def lose(self, lanes: int) -> None:
        """Count lanes that are lost."""
        self.done += lanes
        self.ended[End.LOST] += lanes
        self.tell()

    def within(self, lanes: float) -> None:
        """Show that so many lanes of the block that runs here have ended."""
        self.part = int(lanes)
        self.tell()

    @property
    def seconds_per_lane(self) -> float:
        """Time that a lane takes one worker [s]; 0 before the first block has ended."""
        return self.worked / max(1, self.run)

    @property
    def state(self) -> State:
        """How far the study is now."""
        done = self.done + self.part
        state = State(done / self.total if self.total else 1.0)
        state.done, state.count = done, self.total
        state.failed = {STATUS[code]: n for code, n in self.ended.items() if code not in (*GOOD, End.WAITING)}
        state.rate = (done - self.before) / max(perf_counter() - self.clock, 1e-9)
        state.remaining = (self.total - done) / state.rate if state.rate else float("inf")
        return state

    @property
    def shown(self) -> bool:
        """True if a long study shows a line."""
        if self.display is None:
            return sys.stderr.isatty() or "ipykernel" in sys.modules
        return self.display is True

    def tell(self) -> None:
        """Tell how far the study is, once it has begun."""
        if self.begun and callable(self.display):
            self.display(self.state)
        self.show()

    def show(self) -> None:
        """Show the line, once the study has taken long enough."""
        if not self.begun or perf_counter() - self.clock < _PATIENCE or not self.shown:
            return
        if self.line is None:
            in_notebook = "ipykernel" in sys.modules
            self.line = NotebookLine() if in_notebook else TerminalLine(forced=self.display is True)
        state = self.state
        self.line.show(float(state), f"{self.task}, {state}")

    def __enter__(self) -> Tally:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.line is not None:
            self.line.stop()
