"""``freebody analyze``: conserved quantities, steady motions, linear model, frequencies and mode shapes of a model."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter

import click

from .model import Number, Setting, find, model_argument, number_of, settings_of

FILES = ("analysis.txt", "analysis.tex", "analysis.json")


@click.command()
@model_argument
@click.option("--set", "settings", type=Setting(), multiple=True, metavar="NAME=VALUE",
              help="Value of a parameter; may be repeated. Also with a unit: 75deg, 2rev/s.")  # fmt: skip
@click.option("--about", "about", type=Setting(), multiple=True, metavar="NAME=VALUE",
              help="Coordinate or speed of the operating point; may be repeated. The first stable steady motion "
              "if not given.")  # fmt: skip
@click.option("--patience", type=Number("s"), default="20", show_default=True, metavar="SECONDS",
              help="Longest time for symbolic answers; beyond it, answers are numbers only.")  # fmt: skip
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False), metavar="DIR",
              help=f"Folder for {', '.join(FILES)}; made if missing.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print JSON instead of text.")
def analyze(
    model: str,
    settings: tuple[tuple[str, str], ...],
    about: tuple[tuple[str, str], ...],
    patience: float,
    output: Path | None,
    as_json: bool,
) -> None:
    """Print the conserved quantities of MODEL, its steady motions, and its oscillations about them.

    One line names everything that a model does not have. Nothing is written unless -o names a folder.
    """
    import json

    from ..studies.analysis.analysis import analysis

    if not patience > 0:
        raise click.BadParameter(
            f"Expected a time greater than 0, got {patience:g}.", param_hint="--patience"
        )
    start = perf_counter()
    entry = find(model)
    system = entry.build()
    values = settings_of(system, settings)
    point = {name: number_of(system, name, text, "--about") for name, text in about}
    result = analysis(system, values, point, entry.start, entry.near, patience)
    files = [] if output is None else [output / name for name in FILES]
    report = result.data() | {
        "files": [str(file) for file in files],
        "wall_time_s": round(perf_counter() - start, 6),
    }
    content = json.dumps(report, indent=2, ensure_ascii=False) + "\n"
    if output is not None:
        write(output, dict(zip(FILES, (result.text(), result.latex(), content), strict=True)))
    if as_json:
        click.echo(content, nl=False)
        return
    click.echo(result.text())
    for file in files:
        click.echo(f"wrote {file}")
    if output is None:
        click.echo("Add -o DIR to keep this as text, LaTeX and JSON.")


def write(folder: Path, files: dict[str, str]) -> None:
    """Write texts into a folder, each file completely or not at all."""
    from ..formats.files import replacing

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise click.BadParameter(
            f"Cannot make the folder '{folder}': {error.strerror}.", param_hint="-o"
        ) from None
    for name, content in files.items():
        with replacing(folder / name) as new:
            new.write_text(content, encoding="utf-8", newline="\n")
