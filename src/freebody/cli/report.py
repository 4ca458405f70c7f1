"""``freebody report``: one HTML page about a model and its motion, which opens offline."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter

import click

from .model import Number, Setting, check_run, find, model_argument, settings_of


@click.command()
@model_argument
@click.option("-o", "--output", type=click.Path(path_type=Path, dir_okay=False), metavar="FILE",
              help="File for the page, .html or .pdf; NAME.html in this folder if not given.")  # fmt: skip
@click.option(
    "--until", type=Number("s"), metavar="T", help="Length of the run [s]; that of the model if not given."
)
@click.option(
    "--tolerance", type=Number("1"), metavar="TOL", help="Tolerance of the integration, such as 1e-10."
)
@click.option("--set", "settings", type=Setting(), multiple=True, metavar="NAME=VALUE",
              help="Value of a parameter; may be repeated. Also with a unit: 75deg, 2rev/s.")  # fmt: skip
@click.option(
    "--figures", is_flag=True, help="Show the figures of the model, too, such as the path of a spin axis."
)
@click.option("--equations/--no-equations", "equations", default=None,
              help="Show free-body diagrams and equations; by default for machines of up to six speeds.")  # fmt: skip
@click.option("--live", "kind", flag_value="live",
              help="Put sliders into the page, which computes the motion again as they move.")  # fmt: skip
@click.option("--pdf", "kind", flag_value="pdf",
              help="Print the page to a PDF file, NAME.pdf if no FILE is given; this needs a Chromium.")  # fmt: skip
def report(
    model: str,
    output: Path | None,
    until: float | None,
    tolerance: float | None,
    settings: tuple[tuple[str, str], ...],
    figures: bool,
    equations: bool | None,
    kind: str | None,
) -> None:
    """Simulate MODEL and write one HTML page with its animation, plots, diagrams, equations and answers.

    The page opens offline: it makes no request.
    """
    from ..picture.page.report import report as write

    check_run(until, tolerance)
    if kind == "pdf" and output is not None and output.suffix.lower() != ".pdf":
        raise click.UsageError(
            f"--pdf: expected a file name that ends in .pdf after -o, got '{output.name}'."
        )
    start = perf_counter()
    entry = find(model)
    outcome = entry.run(settings_of(entry.build(), settings), until, tolerance)
    captions = {Path(name).stem.replace("_", " "): plot for name, plot in outcome.plots.items()}
    target = write(
        outcome.system,
        outcome.trajectory,
        Path(f"{outcome.system.name}{'.pdf' if kind == 'pdf' else '.html'}") if output is None else output,
        title=entry.title or outcome.system.name,
        about="; ".join(entry.asks),
        answers=outcome.answers,
        figures=captions if figures else None,
        equations=equations,
        live=kind == "live",
        drawn=entry.drawing(outcome.values),
        names=entry.names,
    )
    size = target.stat().st_size
    click.echo(f"wrote {target}, {size / 1e6:.2f} MB, in {perf_counter() - start:.1f} s")
