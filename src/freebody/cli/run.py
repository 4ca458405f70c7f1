"""``freebody run``: derive the equations of a model, simulate it, and write answers and pictures."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

import click

from ..errors import SimulationError
from ..scalar.digits import significant
from .model import Number, Setting, check_run, find, model_argument, settings_of
from .table import Grid

MOST = 24
"""Most events, and contact modes, that are listed."""

LARGEST = 12
"""Most speeds of a machine whose diagrams are drawn."""

WIDEST = 50
"""Most characters of an answer in the table; longer answers are printed below it."""


@click.command()
@model_argument
@click.option(
    "--until", type=Number("s"), metavar="T", help="Length of the run [s]; that of the model if not given."
)
@click.option(
    "--tolerance", type=Number("1"), metavar="TOL", help="Tolerance of the integration, such as 1e-10."
)
@click.option("--set", "settings", type=Setting(), multiple=True, metavar="NAME=VALUE",
              help="Value of a parameter; may be repeated. Also with a unit: 75deg, 2rev/s.")  # fmt: skip
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False), metavar="DIR",
              help="Folder for the equations, the trajectory and the plots; made if missing.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print JSON instead of a table.")
def run(
    model: str,
    until: float | None,
    tolerance: float | None,
    settings: tuple[tuple[str, str], ...],
    output: Path | None,
    as_json: bool,
) -> None:
    """Derive the equations of MODEL, simulate it, and print the answers to its questions.

    Nothing is written unless -o names a folder.
    """
    check_run(until, tolerance)
    start = perf_counter()
    entry = find(model)
    values = settings_of(entry.build(), settings)
    try:
        outcome = entry.run(values, until, tolerance)
    except SimulationError as error:
        keep_motion(error, output)
        raise
    files = [] if output is None else write_products(outcome, output)
    elapsed = perf_counter() - start
    residual = outcome.trajectory.energy.relative_residual
    if as_json:
        import json

        click.echo(json.dumps(report(outcome, files, residual, elapsed), indent=2, ensure_ascii=False))
    else:
        show(outcome, residual, elapsed)
        for file in files:
            click.echo(f"wrote {file}")
    if outcome.trajectory.interrupted:
        end = float(outcome.trajectory.t[-1])
        click.echo(
            f"Stopped by the keyboard at t = {end:g} s: everything above is for the motion until then.",
            err=True,
        )
        raise click.exceptions.Exit(130)
    failures = [check.what for check in outcome.checks if not check.holds]
    if failures:
        click.echo(f"Checks that do not hold: {'; '.join(failures)}.", err=True)
        raise click.exceptions.Exit(1)
    if output is None and not as_json:
        click.echo("Add -o DIR to keep the equations, the trajectory and the plots.")


def report(outcome: Any, files: list[Path], residual: float, elapsed: float) -> dict[str, Any]:
    """Return the result of a run as data; `answers` are in the order of the questions."""
    from ..describe.description import about_of

    entry = outcome.entry
    return {
        "name": entry.name,
        "aliases": list(entry.aliases),
        "title": entry.title,
        "model": outcome.system.name,
        "asks": list(entry.asks),
        "parameters": {
            name: {"value": value, "unit": unit, "about": about}
            for name, value in outcome.values.items()
            for unit, about in [about_of(outcome.system).get(name, ("", ""))]
        },
        "answers": {
            key: {
                "value": plain(answer.value),
                "unit": answer.unit,
                "formula": answer.text or None,
                "question": answer.question,
                "latex": answer.latex or None,
                "how": answer.how,
                "where": answer.meaning,
            }
            for key, answer in outcome.answers.items()
        },
        "values": {key: plain(answer.value) for key, answer in outcome.answers.items()},
        "equations": {
            "contacts": " ".join(outcome.equations.heading) or None,
            "motion": outcome.equations.lines(),
            "free_bodies": {name: body.text() for name, body in outcome.free_bodies.items()},
        },
        "events": [{"time": event.time, "name": event.name, "text": str(event)} for event in outcome.events],
        "modes": [
            {"contact": m.contact, "mode": m.mode, "from": m.start, "to": m.end, "why": m.why}
            for m in getattr(outcome.trajectory, "modes", ())
        ],
        "checks": [
            {
                "what": c.what,
                "sentence": c.sentence,
                "residual": c.residual,
                "bound": c.bound,
                "holds": c.holds,
            }
            for c in outcome.checks
        ],
        "status": outcome.trajectory.status,
        "warnings": [dataclasses.asdict(warning) for warning in outcome.trajectory.warnings],
        "energy_residual": residual,
        "wall_time_s": elapsed,
        "files": [str(file) for file in files],
    }


def show(outcome: Any, residual: float, elapsed: float) -> None:
    """Print the questions, the free-body equations, the answers, events and checks."""
    entry = outcome.entry
    title = entry.title or outcome.system.name
    if entry.asks:
        click.echo(f"{title}\n\nAsked")
        click.echo("".join(f"  {line}\n" for line in entry.asks))
        for body in outcome.free_bodies.values():
            click.echo(body.text() + "\n")
    headings = ("Key", "Answer", "Value", "Unit") if outcome.answers else ("", "", "")
    grid = Grid(*headings, title="Answers" if outcome.answers else title)
    long, formulas = [], []
    meanings: dict[str, str] = {}
    for key, answer in outcome.answers.items():
        shown = significant(answer.value)
        if len(shown) > WIDEST:
            long.append(f"{key}: {answer.question}\n  {shown}")
        else:
            grid.row(key, answer.question, shown, answer.unit)
            if answer.text:
                formulas.append(f"  {key} = {answer.text}")
                meanings |= answer.meaning
    empty = ("",) if outcome.answers else ()
    legend = [f"  {name} = {x}" for name, x in meanings.items() if name not in outcome.answers]
    if legend:
        formulas += ["where", *legend]
    grid.row(*empty, "energy residual, relative", f"{residual:.1e}", "")
    grid.row(*empty, "wall time", f"{elapsed:.2f}", "s")
    grid.print()
    for lines in (long, ["Formulas", *formulas] if formulas else []):
        if lines:
            click.echo("\n".join([*lines, ""]))
    for line in happenings(outcome.trajectory, outcome.events):
        click.echo(line)
    if outcome.checks:
        click.echo("\n".join(["Checks", *(f"  {check.sentence}" for check in outcome.checks), ""]))


def happenings(trajectory: Any, events: list[Any]) -> list[str]:
    """Return lines with events, contact modes, warnings and indeterminate forces; long lists lose their middle."""
    lines = []
    for title, items in (("Events", events), ("Contacts", getattr(trajectory, "modes", ()))):
        if not len(items):
            continue
        texts = [f"  {item}" for item in items]
        if len(texts) > MOST:
            half = MOST // 2
            texts = [*texts[:half], f"  ... {len(texts) - 2 * half} more ...", *texts[-half:]]
        lines += [f"{title}:", *texts, ""]
    warnings = [f"  {warning}" for warning in getattr(trajectory, "warnings", ())]
    if warnings:
        lines += ["Warnings:", *warnings, ""]
    from ..describe.constraints.constraint import Condition, Gear

    # couplings of which only the ratio is known leave reactions indeterminate
    model = trajectory.kernels.model
    coupled = any(isinstance(x, Gear | Condition) for x in model.constraints.values())
    unknown = [*(trajectory.indeterminate if coupled else trajectory.course.indeterminate)]
    if unknown:
        lines += [f"Statically indeterminate: {', '.join(unknown)} (no motion determines these forces).", ""]
    return lines


def keep_motion(error: SimulationError, folder: Path | None) -> None:
    """Save the motion up to an error, if there is one, in the folder, if there is one."""
    trajectory = getattr(error, "trajectory", None)
    if trajectory is None or folder is None:
        return
    from ..formats.files import replacing

    folder.mkdir(parents=True, exist_ok=True)
    with replacing(folder / "trajectory.nc") as new:
        trajectory.save(new)
    click.echo(f"wrote {folder / 'trajectory.nc'}, the motion up to the error", err=True)


def write_products(outcome: Any, folder: Path) -> list[Path]:
    """Write all products of a run into a folder, each file completely or not at all; return the files."""
    from ..formats.files import replacing

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise click.BadParameter(
            f"Cannot make the folder '{folder}': {error.strerror}.", param_hint="-o"
        ) from None

    def text(content: str) -> Callable[[Path], Any]:
        return lambda path: path.write_text(
            content if content.endswith("\n") else content + "\n", encoding="utf-8"
        )

    products: dict[str, Callable[[Path], Any]] = {
        "equations.txt": text(outcome.equations.text()),
        "equations.tex": text(outcome.equations.latex()),
        "trajectory.nc": lambda path: outcome.trajectory.save(path),
        **{name: text(svg) for name, svg in diagrams(outcome).items()},
        **outcome.plots,
    }
    files = []
    for name, product in products.items():
        with replacing(folder / name) as new:
            product(new)
        files.append(folder / name)
    return files


def diagrams(outcome: Any) -> dict[str, str]:
    """Return the drawing and the free-body diagrams of all bodies as SVG, by file name; none for large machines."""
    import re

    from ..picture.free_body.free_body_diagram import free_body_diagram
    from ..picture.machine.draw import draw
    from ..picture.page.longest_phases import lasting_place, most_lasting

    e = most_lasting(outcome.equations, outcome.trajectory)
    if e.model.n_u > LARGEST:
        return {}
    coordinates = set(e.model.coordinate_names)
    near = {name: x for name, x in outcome.entry.near.items() if name in coordinates}
    options: dict[str, Any] = {"values": outcome.values, "near": near}
    place = lasting_place(outcome.trajectory)
    if place:  # bodies stand on what they touch
        options = {"values": outcome.values, "at": place}
    result = {"drawing.svg": draw(e, **options).svg}
    for name in e.model.bodies:
        safe = re.sub(r"[^\w-]", "_", name)
        result[f"free_body_{safe}.svg"] = free_body_diagram(e, name, **options).svg
    return result


def plain(value: Any) -> Any:
    """Return an answer as JSON can hold it."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return float(value)
