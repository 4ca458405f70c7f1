"""Tables in the terminal."""

from __future__ import annotations

import sys

import click


class Grid:
    """Rows of plain text under bold headings; cells are never read as markup."""

    def __init__(self, *headings: str, title: str | None = None) -> None:
        from rich import box
        from rich.table import Table
        from rich.text import Text

        self._text = Text
        self._table = Table(
            *headings,
            title=Text(title) if title else None, title_justify="left", title_style="bold",
            box=box.SIMPLE_HEAD, show_header=any(headings), pad_edge=False,
        )  # fmt: skip
        self.empty = True

    def row(self, *cells: str) -> None:
        """Add a row."""
        self.empty = False
        self._table.add_row(*(self._text(cell) for cell in cells))

    def print(self) -> None:
        """Print the table."""
        from rich.console import Console

        # a pipe has no width: do not fold rows there
        console = Console(file=sys.stdout, width=None if sys.stdout.isatty() else 200, highlight=False)
        with console.capture() as capture:
            console.print(self._table)
        lines = (line.rstrip() for line in capture.get().splitlines())
        click.echo("\n".join(lines).strip("\n") + "\n")
