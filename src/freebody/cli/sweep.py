"""``freebody sweep``: simulate a model at every combination of some of its values."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import click

from ..scalar.digits import significant
from .model import Number, Setting, find, number_of, settings_of
from .table import Grid

MOST = 12
"""Most rows of the table."""


class Range(click.ParamType):
    """``name=from:to:count`` or ``name=a,b,c`` on the command line."""

    name = "name=from:to:count"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, str]:
        """Return name and values as texts."""
        if isinstance(value, tuple):
            return value
        name, sign, text = value.partition("=")
        if not sign or not name.strip() or not text.strip():
            self.fail(f"Expected name=from:to:count or name=a,b,c, got '{value}'.", param, ctx)
        parts = text.split(":")
        if ":" in text and (len(parts) != 3 or not parts[2].strip().isdigit() or int(parts[2]) < 2):
            self.fail(f"Expected name=from:to:count, with a count of at least 2, got '{value}'.", param, ctx)
        return name.strip(), text


def numbers_of(system: Any, name: str, values: str) -> list[float]:
    """Return the numbers of ``from:to:count`` or ``a,b,c``, in the unit that the system declares for the name."""
    if ":" not in values:
        return [number_of(system, name, text, "--vary") for text in values.split(",")]
    *ends, last_part = values.split(":")
    first, last = (number_of(system, name, text, "--vary") for text in ends)
    count = int(last_part)
    return [first + (last - first) * k / (count - 1) for k in range(count)]


@click.command()
@click.argument("model")
@click.option("--vary", type=Range(), multiple=True, required=True, metavar="NAME=FROM:TO:COUNT",
              help="Parameter, or initial value of a coordinate or speed; also NAME=A,B,C. Repeatable.")  # fmt: skip
@click.option("--until", type=Number("s"), required=True, metavar="T", help="Length of the runs [s].")
@click.option("--output", "outputs", multiple=True, metavar="WHAT",
              help="theta, 'L*sin(theta)', 'max(theta)', ...; may be repeated. All coordinates if none.")  # fmt: skip
@click.option("--event", "events", multiple=True, metavar="EXPRESSION",
              help="Expression whose first and last zero crossings are kept; may be repeated.")  # fmt: skip
@click.option("--samples", type=int, default=None, metavar="N", help="Number of output times (101).")
@click.option(
    "--tolerance", type=Number("1"), default=None, metavar="TOL", help="Tolerance of the integration (1e-9)."
)
@click.option("--set", "settings", type=Setting(), multiple=True, metavar="NAME=VALUE",
              help="Value of a parameter in all runs; may be repeated.")  # fmt: skip
@click.option("-o", "--out", "store", type=click.Path(path_type=Path, dir_okay=False), default=None, metavar="FILE",
              help="netCDF file for the results; a stopped sweep continues from it.")  # fmt: skip
def sweep(
    model: str,
    vary: tuple[tuple[str, str], ...],
    until: float,
    outputs: tuple[str, ...],
    events: tuple[str, ...],
    samples: int | None,
    tolerance: float | None,
    settings: tuple[tuple[str, str], ...],
    store: Path | None,
) -> None:
    """Simulate MODEL at every combination of values, and write the motions to one file."""
    from ..motion.kernels.kernels import kernels_of
    from ..studies.sweep import sweep as run

    entry = find(model)
    system = entry.build()
    values = settings_of(system, settings)
    grid: dict[str, list[float]] = {}
    for name, text in vary:
        if name in grid:
            raise click.BadParameter(f"'{name}' is varied twice.", param_hint="--vary")
        grid[name] = numbers_of(system, name, text)
    near = dict(entry.near or {}) if kernels_of(system).model.constraints else {}
    start = {name: value for name, value in dict(entry.start or {}).items() if name not in grid}
    data = run(
        system, grid, until, outputs=list(outputs) or None, initial=start, near=near, values=values,
        events=list(events), samples=samples, tolerance=1e-9 if tolerance is None else tolerance, store=store,
    )  # fmt: skip
    show(data, grid)
    waiting = int((data.status == "waiting").sum())
    if store is not None:
        click.echo(f"wrote {store}")
    else:
        click.echo("Add -o FILE.nc to keep the motions.")
    if waiting:
        more = (
            "the same command continues with them" if store is not None else "add -o to be able to continue"
        )
        click.echo(f"Stopped by the keyboard: {waiting} runs are left; {more}.", err=True)
        raise click.exceptions.Exit(130)


def show(data: Any, grid: dict[str, list[float]]) -> None:
    """Print how the runs ended, and the range of every output over all runs."""
    size = 1
    for numbers in grid.values():
        size *= len(numbers)
    table = Grid("Output", "Smallest", "Largest", "Unit", title=f"{size} runs of {data.attrs['title'][11:]}")
    for name, variable in list(data.data_vars.items())[:MOST]:
        if name in ("steps", "event_count") or variable.dtype.kind not in "fi":  # texts have no range
            continue
        low, high = (float(x(variable)) for x in (_least, _most))
        table.row(name, significant(low), significant(high), variable.attrs.get("units", ""))
    table.print()
    ended = Counter(data.status.values.ravel().tolist())
    click.echo("; ".join(f"{count} {status}" for status, count in ended.most_common()))
    blamed = Counter(data.blame.values[data.blame.values != ""].ravel().tolist())
    if blamed:
        click.echo(f"To blame: {', '.join(f'{name} ({count})' for name, count in blamed.most_common())}")


def _least(variable: Any) -> Any:
    return variable.min()


def _most(variable: Any) -> Any:
    return variable.max()
