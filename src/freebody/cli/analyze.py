"""``freebody analyze``: integrals, steady motions, linear model, frequencies and modes of a model."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter

import click

from .model import Number, Setting, find, number_of, settings_of

FILES = ("analysis.txt", "analysis.tex", "analysis.json")


@click.command()
@click.argument("model")
@click.option("--set", "settings", type=Setting(), multiple=True, metavar="NAME=VALUE",
              help="Value of a parameter; may be repeated. Also with a unit: 75deg, 2rev/s.")  # fmt: skip
@click.option("--about", "about", type=Setting(), multiple=True, metavar="NAME=VALUE",
              help="Coordinate or speed where to linearise; may be repeated. The first stable steady motion "
              "if not given.")  # fmt: skip
@click.option("--patience", type=Number("s"), default="20", show_default=True, metavar="SECONDS",
              help="Longest time for the answers in symbols; beyond it only those in numbers are given.")  # fmt: skip
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
    """Say what is conserved in MODEL, how it can move steadily, and how it oscillates about that.

    What a model does not have is said in one line. Nothing is written unless -o names a folder.
    """
    import json

    from ..study.analysis import analysis

    if not patience > 0:
        raise click.BadParameter(
            f"Expected a time greater than 0, got {patience:g}.", param_hint="--patience"
        )
    start = perf_counter()
    entry = find(model)
    system = entry.build()
    values = settings_of(system, settings)
    chosen = {name: number_of(system, name, text, "--about") for name, text in about}
    found = analysis(system, values, chosen, entry.start, entry.near, patience)
    files = [] if output is None else [output / name for name in FILES]
    report = found.data() | {
        "files": [str(file) for file in files],
        "wall_time_s": round(perf_counter() - start, 6),
    }
    content = json.dumps(report, indent=2, ensure_ascii=False) + "\n"
    if output is not None:
        write(output, dict(zip(FILES, (found.text(), found.latex(), content), strict=True)))
    if as_json:
        click.echo(content, nl=False)
        return
    click.echo(found.text())
    for file in files:
        click.echo(f"wrote {file}")
    if output is None:
        click.echo("Add -o DIR to keep this as text, LaTeX and JSON.")


def write(folder: Path, files: dict[str, str]) -> None:
    """Write texts into a folder, each whole or not at all."""
    from ..formats.files import replacing

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise click.BadParameter(
            f"Can not make the folder '{folder}': {error.strerror}.", param_hint="-o"
        ) from None
    for name, content in files.items():
        with replacing(folder / name) as new:
            new.write_text(content, encoding="utf-8", newline="\n")
