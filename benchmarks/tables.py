"""Clocks and tables."""

from __future__ import annotations

import importlib
import os
import platform
import statistics
import time
from collections.abc import Callable, Sequence
from typing import Any

NOT_INSTALLED = "not installed"


def seconds(call: Callable[[], Any], repeats: int = 5, before: Callable[[], Any] | None = None) -> float:
    """Median wall time of ``call()`` [s]; ``before()`` runs outside the clock ahead of each repeat."""
    times = []
    for _ in range(max(1, repeats)):
        if before is not None:
            before()
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def per_call(loop: Callable[[int], Any], repeats: int = 5, target: float = 0.02) -> float:
    """Median time of one call [s], where ``loop(n)`` makes ``n`` of them in about ``target`` s."""
    n = 1
    while True:
        start = time.perf_counter()
        loop(n)
        elapsed = time.perf_counter() - start
        if elapsed > target / 4 or n >= 10_000_000:
            break
        n = max(n + 1, min(10 * n, int(n * target / max(elapsed, 1e-9))))
    return seconds(lambda: loop(n), repeats) / n


def module(name: str) -> Any:
    """The peer's module, or None where it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


def time_text(value: Any) -> str:
    """A time with its unit, three digits."""
    if value is None:
        return "-"
    if isinstance(value, str):
        return value
    for unit, factor in (("s", 1.0), ("ms", 1e3), ("µs", 1e6)):
        if value * factor >= 1:
            return f"{value * factor:.3g} {unit}"
    return f"{value * 1e9:.3g} ns"


def ratio_text(theirs: Any, ours: Any) -> str:
    """How many times longer the peer takes; a peer stopped at its limit gives a lower bound."""
    bound = ""
    if isinstance(theirs, str) and theirs.startswith("> "):
        bound, theirs = "> ", float(theirs[2:].split()[0])
    if not isinstance(theirs, float | int) or not isinstance(ours, float | int) or ours <= 0:
        return "-"
    return f"{bound}{theirs / ours:.3g}×"


def show(
    title: str, columns: Sequence[str], rows: Sequence[Sequence[Any]], notes: Sequence[str] = ()
) -> None:
    """Print a table (with rich where it is installed) and the notes that say how it was measured."""
    cells = [["-" if cell is None else str(cell) for cell in row] for row in rows]
    if module("rich") is not None:
        from rich.console import Console
        from rich.table import Table

        width = None if os.environ.get("COLUMNS") or os.isatty(1) else 150
        console = Console(width=width, highlight=False)
        table = Table(title=title, title_justify="left")
        for i, column in enumerate(columns):
            table.add_column(column, justify="left" if i == 0 else "right")
        for row in cells:
            table.add_row(*row)
        console.print(table)
        for note in notes:
            console.print(f"  {note}", style="dim", markup=False)
        console.print()
        return
    widths = [max(len(row[i]) for row in [list(columns), *cells]) for i in range(len(columns))]
    print(title)
    for row in [list(columns), *cells]:
        print(
            "  ".join(
                cell.ljust(w) if i == 0 else cell.rjust(w)
                for i, (cell, w) in enumerate(zip(row, widths, strict=True))
            )
        )
    for note in notes:
        print(f"  {note}")
    print()


def versions() -> str:
    """The machine and the versions of everything that is measured."""
    from importlib import metadata

    parts = []
    for package in (
        "freebody",
        "sympy",
        "python-flint",
        "scipy",
        "numba",
        "llvmlite",
        "pin",
        "mujoco",
        "drake",
        "exudyn",
        "heyoka",
    ):
        try:
            parts.append(f"{package} {metadata.version(package)}")
        except metadata.PackageNotFoundError:
            if package == "freebody":
                import freebody

                parts.append(f"freebody {freebody.__version__}")
            else:
                parts.append(f"{package} {NOT_INSTALLED}")
    return f"Python {platform.python_version()}, {platform.machine()}, {os.cpu_count()} cores; " + ", ".join(
        parts
    )
