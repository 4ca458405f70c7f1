"""``freebody study``: run many motions of a model and keep them, or show what a store keeps."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import click

from ..errors import SimulationError
from ..scalar.digits import significant
from .lanes import Distribution, Range, law_of
from .model import Number, Setting, find, settings_of
from .table import Grid

MOST = 12
"""Most rows of the table."""
PICTURES = (".png", ".svg", ".pdf")
_CHUNK = 1 << 20  # numbers that are read at once


OPTIONS = (
    click.option("--vary", type=Range(), multiple=True, metavar="NAME=FROM:TO:COUNT",
                 help="Parameter, or initial value of a coordinate or speed; also NAME=A,B,C. Repeatable."),
    click.option("--until", type=Number("s"), default=None, metavar="T",
                 help="Length of the runs [s]; that of the model if not given."),
    click.option("--output", "outputs", multiple=True, metavar="WHAT",
                 help="theta, 'L*sin(theta)', 'max(theta)', ...; may be repeated. All coordinates if none."),
    click.option("--event", "events", multiple=True, metavar="EXPRESSION",
                 help="Expression whose first and last zero crossings are kept; may be repeated."),
    click.option("--samples", type=int, default=None, metavar="N", help="Number of output times (101)."),
    click.option("--tolerance", type=Number("1"), default=None, metavar="TOL",
                 help="Tolerance of the integration (1e-9)."),
    click.option("--set", "settings", type=Setting(), multiple=True, metavar="NAME=VALUE",
                 help="Value of a parameter in all runs; may be repeated."),
)  # fmt: skip
"""Options of commands that run many motions of a model."""


def runs_motions(command: Callable[..., Any]) -> Callable[..., Any]:
    """Return a command with the options of those that run many motions."""
    for option in reversed(OPTIONS):
        command = option(command)
    return command


@click.command()
@click.argument("model", metavar="MODEL|STORE")
@runs_motions
@click.option("--sample", type=Distribution(), multiple=True, metavar="NAME=DISTRIBUTION",
              help="Draw a parameter or initial value: 'I=norm(0.5,0.05)', a distribution of scipy.stats with its "
              "parameters, or I=LOW:HIGH. Repeatable.")  # fmt: skip
@click.option("--n", type=float, default=None, metavar="N", help="Number of lanes of --sample.")
@click.option(
    "--by", type=click.Choice(["sobol", "lhs", "random"]), default=None, help="How lanes are drawn (sobol)."
)
@click.option("--seed", type=int, default=None, metavar="SEED", help="Seed of the draws (1).")
@click.option("--executor", default=None, metavar="WHERE",
              help="threads (default), processes, or dask://HOST:PORT, the address of a dask scheduler.")  # fmt: skip
@click.option("-o", "--out", "out", type=click.Path(path_type=Path), default=None, metavar="FILE",
              help="x.zarr or x.nc for the results, from which the same command goes on after a stop; with STORE, "
              "x.png, x.svg or x.pdf for a picture of them.")  # fmt: skip
def study(model: str, executor: str | None, out: Path | None, **options: Any) -> None:
    """Run many motions of MODEL, or show what STORE, a folder x.zarr, keeps of them.

    \b
    freebody study gyroscope --sample "R=norm(0.06,0.002)" --n 1000 --output "max(theta)" -o x.zarr
    freebody study x.zarr -o x.png
    """
    path = Path(model)
    if path.suffix == ".zarr" or (path.is_dir() and path.suffix != ".toml"):
        show_store(path, out, executor, options)
        return
    if out is not None and out.suffix not in (".zarr", ".nc"):
        raise click.BadParameter(f"Expected x.zarr or x.nc for the results, got '{out}'.", param_hint="-o")
    run_lanes(model, options, executor, out)


def run_lanes(model: str, options: dict[str, Any], executor: str | None, out: Path | None) -> None:
    """Run the lanes that the options of a command ask for, and print how they ended."""
    if executor is not None and executor not in ("threads", "processes") and "://" not in executor:
        raise click.BadParameter(
            f"Expected threads, processes or dask://HOST:PORT, got '{executor}'.", param_hint="--executor"
        )
    runs = study_of(model, options)
    data = runs.run(executor, store=out)
    click.echo(f"{runs!r}\n")
    show(data)
    if out is not None:
        click.echo(f"wrote {out}")
    else:
        click.echo("Add -o FILE.zarr or -o FILE.nc to keep the motions.")
    waiting = codes_of(data).get("waiting", 0)
    if waiting:
        more = "the same command continues with them" if out is not None else "add -o to be able to continue"
        reason = data.attrs.get("interrupted", "")
        if "not begun" in reason:
            raise SimulationError(f"{waiting} runs are left ({reason}); {more}.")
        click.echo(f"Stopped by the keyboard: {waiting} runs are left; {more}.", err=True)
        raise click.exceptions.Exit(130)


def study_of(model: str, options: dict[str, Any]) -> Any:
    """Return the study of a model that the options of a command ask for."""
    from ..motion.kernels.kernels import kernels_of
    from ..studies.study import study as make

    entry = find(model)
    system = entry.build()
    law = law_of(system, options)
    until = entry.until if options["until"] is None else options["until"]
    if until is None:
        raise click.UsageError(
            f"Expected the length of the runs, which '{model}' does not give: add --until 10."
        )
    near = dict(entry.near or {}) if kernels_of(system).model.constraints else {}
    start = {name: value for name, value in dict(entry.start or {}).items() if name not in law.names}
    tolerance = options["tolerance"]
    return make(
        system, until, lanes=law, outputs=list(options["outputs"]) or None, initial=start, near=near,
        values=settings_of(system, options["settings"]), events=list(options["events"]), samples=options["samples"],
        tolerance=1e-9 if tolerance is None else tolerance,
    )  # fmt: skip


def show_store(path: Path, out: Path | None, executor: str | None, options: dict[str, Any]) -> None:
    """Print the state of a store, its failures and the ranges of its outputs; draw a picture of them."""
    from ..studies.open_study import open_study

    if executor is not None or any(x not in (None, ()) for x in options.values()):
        raise click.UsageError(
            f"'{path}' is a store: it is shown, and takes no option but -o PICTURE. To go on with it, repeat the "
            "command that made it."
        )
    if out is not None and out.suffix not in PICTURES:
        raise click.BadParameter(
            f"Expected a picture for -o, {', '.join(PICTURES)}, got '{out}'.", param_hint="-o"
        )
    stored = open_study(path)
    data = stored.data
    click.echo(f"{stored!r}")
    if stored.missing and data.attrs.get("command"):
        click.echo(f"Made by: {data.attrs['command']}")
    click.echo("")
    show(data)
    if out is not None:
        from ..picture.plots.lane_plots import lanes

        axes = lanes(data)
        try:
            axes.flat[0].figure.savefig(out)
        except OSError as error:
            raise click.BadParameter(f"Cannot write '{out}': {error.strerror}.", param_hint="-o") from None
        click.echo(f"wrote {out}")


def show(data: Any) -> None:
    """Print the range of every output over all lanes, how the lanes ended, and why they failed."""
    size = data.sizes["lane"]
    table = Grid("Output", "Smallest", "Largest", "Unit", title=f"{size} runs of {data.attrs['title'][11:]}")
    outputs = [
        name
        for name, x in data.data_vars.items()
        if name not in ("steps", "event_count", "status", "blame")
        and x.dtype.kind in "fi"
        and "lane" in x.dims
    ]
    for name in outputs[:MOST]:
        low, high = range_of(data[name])
        table.row(name, significant(low), significant(high), data[name].attrs.get("units", ""))
    table.print()
    ended = codes_of(data)
    click.echo("; ".join(f"{count} {status}" for status, count in ended.items()))
    failures(data)


def codes_of(data: Any) -> dict[str, int]:
    """Return the number of lanes by how they ended, the most frequent first."""
    import numpy as np

    from ..motion.ending import STATUS

    codes, counts = np.unique(np.asarray(data["status"].values), return_counts=True)
    order = np.argsort(-counts, kind="stable")
    return {STATUS[int(codes[k])]: int(counts[k]) for k in order}


def failures(data: Any) -> None:
    """Print the failed lanes by how they ended: how many, the first of them, its values, and why."""
    import numpy as np

    from ..motion.ending import GOOD, STATUS, End

    codes, told = np.asarray(data["status"].values), reasons(data)
    bad = [code for code in np.unique(codes) if code not in (*GOOD, End.WAITING)]
    if not bad:
        return
    events = [str(name) for name in data["event"].values] if "event" in data.variables else []
    with_blanks = {name.replace(" ", "_"): name for name in events}  # a meaning of a flag has none
    names = [with_blanks.get(name, name) for name in data["blame"].attrs.get("flag_meanings", "").split()]
    blame = np.asarray(data["blame"].values)
    table = Grid("Failed", "Lanes", "First", "To blame", "Why")
    varied = [name for name, x in data.variables.items() if x.dims == ("lane",) and name in _varied(data)]
    for code in bad:
        lanes = np.flatnonzero(codes == code)
        first = int(lanes[0])
        values = ", ".join(f"{name} = {float(data[name][first]):.6g}" for name in varied)
        place = int(blame[first]) + 1
        culprit = names[place] if 0 < place < len(names) else ""
        table.row(STATUS[int(code)], str(len(lanes)), f"{first} ({values})", culprit, told.get(first, ""))
    table.print()


def _varied(data: Any) -> list[str]:
    """Return the names of what varies: coordinates of the lanes."""
    stored = data.attrs.get("coordinates", "").split()
    return [str(name) for name in (*data.coords, *stored) if name in data.variables]


def reasons(data: Any) -> dict[int, str]:
    """Return why lanes failed, by lane, of results in memory or in a store."""
    if "reason" not in data:
        return {}
    if data["reason"].dims == ("failed",):
        return dict(zip(data["failed_lane"].values.tolist(), data["reason"].values.tolist(), strict=True))
    tables = [json.loads(text) for text in data["reason"].values.tolist() if text]
    return {lane: reason for table in tables for reason, lanes in table.items() for lane in lanes}


def range_of(variable: Any) -> tuple[float, float]:
    """Return the smallest and the largest value, read piece by piece; nan if there is none."""
    import numpy as np

    pieces = [piece[np.isfinite(piece)] for piece in _pieces(variable)]
    ends = [(piece.min(), piece.max()) for piece in pieces if piece.size]
    if not ends:
        return float("nan"), float("nan")
    return float(min(low for low, _ in ends)), float(max(high for _, high in ends))


def _pieces(variable: Any) -> Iterator[Any]:
    """Yield the values of a variable over the lanes, some lanes at a time."""
    lanes = variable.sizes["lane"]
    step = max(1, _CHUNK // max(1, variable.size // max(1, lanes)))
    for low in range(0, lanes, step):
        yield variable.isel(lane=slice(low, low + step)).values
