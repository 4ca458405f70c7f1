"""The blocks of a study, run by a crew until each lane has ended.

Blocks run in a fixed pseudo-random order, so that the time that is left can be told honestly and no worker gets all the
long ones. A block whose worker dies runs again; after its second death it runs while nothing else does, and if its
worker dies even so, it is halved, until the lane that kills is alone: this lane is lost. So is a lane whose block ends
with an error that is no refusal of freebody.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .block import Delivery, Report
from .crew import GoneError, Range, died, gone
from .tally import Tally

_PATIENCE = 2.0  # seconds after Ctrl-C in which running blocks may return the lanes that are done
_GLANCE = 0.25  # seconds between two looks at the keyboard
_DEATHS = 2  # of a block's worker, after which the block runs alone, and then is halved


class Workers(Protocol):
    """Who runs the blocks: `crew.Here` or `crew.Crew`. ``delivery`` says what becomes of their results."""

    delivery: Delivery

    @property
    def room(self) -> int:
        """Number of blocks that may be started before one ends."""

    @property
    def low(self) -> int:
        """Number of running blocks at which more are started."""

    @property
    def workers(self) -> int:
        """Number of blocks that run at once."""

    def start(self, low: int, high: int) -> None:
        """Begin a block."""

    def wait(self, seconds: float) -> tuple[Range, Report | BaseException] | None:
        """Return a block that has ended; None if none did."""

    def renew(self) -> bool:
        """Return True if blocks can be started after a worker died."""

    def cancel(self) -> None:
        """Forget blocks that have not begun."""

    def close(self) -> None:
        """End what was begun for the blocks."""


@dataclass
class Trouble:
    """What kept lanes from being run.

    ``lost``    reasons of lanes that killed their worker, or whose block broke, by the lane
    ``error``   why the executor takes no more blocks
    """

    lost: dict[int, str]
    error: BaseException | None = None

    @property
    def reason(self) -> str:
        """Why lanes were not begun; nothing if all were."""
        return f"not begun: {type(self.error).__name__}: {self.error}" if self.error else ""


def shuffled(blocks: Sequence[Range]) -> list[Range]:
    """Return the blocks in a pseudo-random order, the same for the same blocks."""
    return [blocks[k] for k in np.random.default_rng(len(blocks)).permutation(len(blocks))]


def run_blocks(
    crew: Workers, blocks: Iterable[Range], receive: Callable[[Report], None], tally: Tally,
    check: Callable[[], None] = lambda: None,
) -> Trouble:  # fmt: skip
    """Run all blocks. ``receive`` gets each report, and ``check`` raises KeyboardInterrupt if Ctrl-C was pressed."""
    return _Run(crew, blocks, receive, tally, check).run()


class _Run:
    """Blocks that wait, run, or have to run alone."""

    def __init__(
        self, crew: Workers, blocks: Iterable[Range], receive: Callable[[Report], None], tally: Tally,
        check: Callable[[], None],
    ) -> None:  # fmt: skip
        self.crew, self.receive, self.tally, self.check = crew, receive, tally, check
        self.blocks = iter(blocks)
        self.again: deque[Range] = deque()
        self.alone: deque[Range] = deque()
        self.running: set[Range] = set()
        self.deaths: dict[Range, int] = {}
        self.broken = False
        self.trouble = Trouble({})

    def run(self) -> Trouble:
        """Run all blocks; return what kept lanes from being run."""
        try:
            while self._start() or self.running:  # what runs is waited for, whatever happened
                ended = self.crew.wait(_GLANCE)
                if ended is not None:
                    self._end(*ended)
                self.check()
        except KeyboardInterrupt:  # keep finished blocks, and the lanes that interrupted blocks return
            self.crew.cancel()
            while self.running and (ended := self.crew.wait(_PATIENCE)) is not None:
                block, report = ended
                self.running.discard(block)
                if isinstance(report, Report):
                    self.receive(report)
            raise
        finally:
            self.crew.cancel()
        return self.trouble

    def _start(self) -> bool:
        """Start as many blocks as there is room for; return True if any is left or runs."""
        if self.trouble.error is not None:
            return False
        if self.broken and not self.running:
            self.broken = False
            if not self.crew.renew():
                return False
        room = self.crew.room if len(self.running) <= self.crew.low else 0
        while not self.broken and len(self.running) < room:
            block = self.again.popleft() if self.again else next(self.blocks, None)
            if block is None:
                if not self.alone or self.running:
                    break
                block = self.alone.popleft()
            self.running.add(block)
            try:
                self.crew.start(*block)
            except GoneError as error:
                self.running.discard(block)
                self.trouble.error = error.__cause__ or error
                break
            if self.deaths.get(block, 0) >= _DEATHS:
                break
        return bool(self.running or self.again or self.alone)

    def _end(self, block: Range, report: Report | BaseException) -> None:
        """Take what a block has done, or decide what becomes of it."""
        self.running.discard(block)
        if isinstance(report, Report):
            self.receive(report)
            self.tally.count(report)
            if report.interrupted:  # here, or in a process that received Ctrl-C before this one
                raise KeyboardInterrupt
        elif gone(report):
            self.trouble.error = report.__cause__ or report
        elif died(report):
            self.broken = True
            self.deaths[block] = deaths = self.deaths.get(block, 0) + 1
            if deaths < _DEATHS:
                self.again.append(block)
            elif deaths < _DEATHS + (2 if block[1] - block[0] == 1 else 1):
                self.alone.append(block)
            else:
                self._halve(
                    block,
                    "its process ended abruptly, by a signal, for want of memory, or where it could not find what it "
                    f"was sent ({type(report).__name__})",
                )
        else:
            self._halve(block, f"{type(report).__name__}: {report}")

    def _halve(self, block: Range, reason: str) -> None:
        """Run both halves of a block alone; a single lane is lost."""
        low, high = block
        if high - low == 1:
            self.trouble.lost[low] = reason
            self.tally.lose(1)
            return
        middle = (low + high) // 2
        for half in ((low, middle), (middle, high)):
            self.deaths[half] = _DEATHS
            self.alone.append(half)
