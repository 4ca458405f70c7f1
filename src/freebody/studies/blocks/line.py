"""The line that shows how far a study is: by rich on terminals, by an output of the cell in notebooks."""

from __future__ import annotations

from time import perf_counter
from typing import Any

_PAUSE = 0.2  # seconds between two lines in a notebook
_WIDTH = 40  # signs of the bar in a notebook


class TerminalLine:
    """A line on the standard error, which is removed at the end; ``forced`` where that is no terminal, too."""

    def __init__(self, forced: bool) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn

        console = Console(stderr=True, force_terminal=True if forced else None)
        self.line = Progress(BarColumn(), TextColumn("{task.description}"), console=console, transient=True)
        self.line.start()
        self.bar = self.line.add_task("", total=1.0)

    def show(self, part: float, text: str) -> None:
        """Show the part that is done, and a text."""
        self.line.update(self.bar, completed=part, description=text)

    def stop(self) -> None:
        """Remove the line."""
        self.line.stop()


class NotebookLine:
    """An output of the cell that runs, which is replaced again and again.

    rich needs ipywidgets to replace lines in a notebook; this needs what every notebook has.
    """

    def __init__(self) -> None:
        self.handle: Any = None
        self.clock = 0.0

    def show(self, part: float, text: str) -> None:
        """Show the part that is done, and a text."""
        if perf_counter() - self.clock < _PAUSE:
            return
        self.clock = perf_counter()
        full = round(_WIDTH * part)
        self._display(f"{'█' * full}{'░' * (_WIDTH - full)} {text}")

    def stop(self) -> None:
        """Empty the output."""
        self._display("")

    def _display(self, text: str) -> None:
        from IPython.display import display

        data = {"text/plain": text}
        if self.handle is None:
            self.handle = display(data, raw=True, display_id=True)
        else:
            self.handle.update(data, raw=True)
