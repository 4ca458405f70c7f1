"""Ctrl-C in a batch: it ends the lanes, but not the writing of their results."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType, TracebackType


class Keyboard:
    """Context in which Ctrl-C raises KeyboardInterrupt once, and only while ``listening``.

    If Ctrl-C is pressed at another moment, or where Python has to ignore the exception, the next :meth:`check` raises
    it. Nothing changes in threads other than the main one, and in programs that handle SIGINT themselves.
    """

    def __init__(self) -> None:
        self.handling = self.listening = self.pressed = False

    def __enter__(self) -> Keyboard:
        main = threading.current_thread() is threading.main_thread()
        self.handling = main and signal.getsignal(signal.SIGINT) is signal.default_int_handler
        if self.handling:
            signal.signal(signal.SIGINT, self._press)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.handling:
            signal.signal(signal.SIGINT, signal.default_int_handler)

    def _press(self, number: int, frame: FrameType | None) -> None:
        self.pressed = True
        if self.listening:
            self.listening = False
            raise KeyboardInterrupt

    def check(self) -> None:
        """Raise KeyboardInterrupt if Ctrl-C was pressed."""
        if self.pressed:
            self.listening = False
            raise KeyboardInterrupt

    @contextmanager
    def held(self) -> Iterator[None]:
        """Context that Ctrl-C does not interrupt; the exception is raised at its end, if it could be raised before."""
        before, self.listening = self.listening, False
        yield
        self.listening = before
        if before:
            self.check()
